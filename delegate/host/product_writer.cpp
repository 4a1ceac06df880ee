#include "delegate/host/product_writer.h"

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <climits>
#include <cmath>
#include <mutex>

#include "core/color/color_config.h"
#include "delegate/host/product_pixels.h"
#include "delegate/host/product_plan.h"
#include "delegate/support/output_file.h"

namespace alabaster::hd::host {
namespace {

/// Bytes of the rows that are encoded together: enough for every thread, and little beside the frame. OpenImageIO hands
/// no more than this to OpenEXR's threads at once.
constexpr size_t kStripBytes = size_t(16) << 20;

bool fail(const DiagnosticSink& sink, const char* code, const std::string& where, std::string text) {
  if (sink) sink({Severity::error, code, where, std::move(text)});
  return false;
}

alabaster::DiagnosticSink to_core(const DiagnosticSink& sink) {
  if (!sink) return {};
  return [sink](const alabaster::Diagnostic& d) { sink({Severity(int(d.severity)), d.code, d.where, d.text}); };
}
static_assert(int(Severity::info) == int(alabaster::Severity::info) &&
              int(Severity::warning) == int(alabaster::Severity::warning) &&
              int(Severity::error) == int(alabaster::Severity::error));

/// The conversion of one product's colours from the rendering space.
struct OutputTransform {
  std::shared_ptr<const ColorConfig> config;
  std::shared_ptr<const ColorTransform> transform;
  std::string description;  // attribute "colorSpace"
};

bool make_output_transform(const RenderProduct& product, const ProductPlan& plan, const OutputColors& colors,
                           const DiagnosticSink& sink, OutputTransform& out) {
  const alabaster::DiagnosticSink core_sink = to_core(sink);
  out.config = ColorConfig::load(colors.ocio, core_sink);
  if (!out.config) return false;
  if (plan.display_referred) {
    const std::string display = product.display.empty() ? out.config->default_display() : product.display;
    const std::string view = product.view.empty() ? out.config->default_view(display) : product.view;
    out.transform = out.config->display_transform({display, view, product.look, product.exposure}, core_sink);
    out.description = display + " / " + view;
  } else {
    const std::string space = product.colorSpace.empty() ? out.config->rendering_space() : product.colorSpace;
    out.transform = out.config->from_rendering_space(space, core_sink);
    out.description = space;
  }
  return out.transform != nullptr;
}

// ---- attributes -----------------------------------------------------------------------------------------------------

/// Sets one attribute in EXR's own type, or as text if EXR has no such type.
struct AttributeSetter {
  OIIO::ImageSpec& spec;
  const std::string& name;
  const Value& value;

  void vector(OIIO::TypeDesc::BASETYPE base, OIIO::TypeDesc::AGGREGATE aggregate, const void* data) const {
    spec.attribute(name, OIIO::TypeDesc(base, aggregate), data);
  }
  void integer(int64_t v) const {
    if (v >= INT_MIN && v <= INT_MAX)
      spec.attribute(name, int(v));
    else
      spec.attribute(name, std::to_string(v));
  }
  void operator()(std::monostate) const {}
  void operator()(bool v) const { spec.attribute(name, int(v)); }
  void operator()(int32_t v) const { integer(v); }
  void operator()(int64_t v) const { integer(v); }
  void operator()(uint32_t v) const { integer(v); }
  void operator()(float v) const { spec.attribute(name, v); }
  void operator()(double v) const { spec.attribute(name, OIIO::TypeDesc(OIIO::TypeDesc::DOUBLE), &v); }
  void operator()(const Vec2f& v) const { vector(OIIO::TypeDesc::FLOAT, OIIO::TypeDesc::VEC2, &v); }
  void operator()(const Vec3f& v) const { vector(OIIO::TypeDesc::FLOAT, OIIO::TypeDesc::VEC3, &v); }
  void operator()(const Vec2i& v) const { vector(OIIO::TypeDesc::INT, OIIO::TypeDesc::VEC2, &v); }
  void operator()(const Vec3i& v) const { vector(OIIO::TypeDesc::INT, OIIO::TypeDesc::VEC3, &v); }
  void operator()(const Matrix4d& v) const { vector(OIIO::TypeDesc::DOUBLE, OIIO::TypeDesc::MATRIX44, &v); }
  void operator()(const Token& v) const { spec.attribute(name, v.str()); }
  void operator()(const std::string& v) const { spec.attribute(name, v); }
  void operator()(const Path& v) const { spec.attribute(name, v.str()); }
  template <class T>
  void operator()(const T&) const {
    spec.attribute(name, value.to_string());
  }
};

void set_attributes(const ProductImage& image, const OutputTransform& out, FileKind kind, OIIO::ImageSpec& spec) {
  for (const auto& [key, value] : image.metadata) {
    if (key.starts_with("oiio:")) continue;                        // directions to OpenImageIO, which are given below
    const std::string name = key == "capDate" ? "DateTime" : key;  // OpenImageIO's name for EXR's attribute
    std::visit(AttributeSetter{spec, name, value}, value.storage());
  }
  spec.attribute("colorSpace", out.description);
  if (image.incomplete) spec.attribute("alabaster/incomplete", 1);
  if (!image.metadata.contains("Software")) {
    const std::string versions = AlabasterVersions();
    spec.attribute("Software", "Alabaster " + versions.substr(0, versions.find('\n')));
  }
  if (kind == FileKind::exr) return;

  // The other formats have no free attributes (PNG has only texts), so one description holds them all.
  std::string description;
  for (const OIIO::ParamValue& attribute : spec.extra_attribs) {
    if (attribute.name() == "Software" || attribute.name() == "DateTime") continue;
    description += attribute.name().string() + ": " + attribute.get_string() + "\n";
  }
  std::erase_if(spec.extra_attribs, [](const OIIO::ParamValue& attribute) {
    return attribute.name() != "Software" && attribute.name() != "DateTime";
  });
  spec.attribute("ImageDescription", description);
}

// ---- layout of the file ---------------------------------------------------------------------------------------------

OIIO::TypeDesc type_of(ChannelStore store) {
  switch (store) {
    case ChannelStore::half:
      return OIIO::TypeHalf;
    case ChannelStore::float32:
      return OIIO::TypeFloat;
    case ChannelStore::uint32:
      return OIIO::TypeUInt32;
    case ChannelStore::uint8:
      return OIIO::TypeUInt8;
    case ChannelStore::uint16:
      break;
  }
  return OIIO::TypeUInt16;
}

void set_windows(const Framing& framing, OIIO::ImageSpec& spec) {
  spec.x = framing.dataWindow.minX;
  spec.y = framing.dataWindow.minY;
  spec.full_x = int(std::lround(framing.displayMin.x));
  spec.full_y = int(std::lround(framing.displayMin.y));
  spec.full_width = std::max(1, int(std::lround(framing.displayMax.x)) - spec.full_x);
  spec.full_height = std::max(1, int(std::lround(framing.displayMax.y)) - spec.full_y);
}

constexpr int kPngNoFilter = 8;  // libpng's PNG_FILTER_NONE

/// PNG, TIFF and JPEG hold the data window alone, because viewers disagree about offsets. Somebody waits for an
/// incomplete image, so it is not compressed.
OIIO::ImageSpec make_spec(const ProductPlan& plan, const ProductImage& image, const OutputTransform& out) {
  const Rect2i& window = image.framing.dataWindow;
  OIIO::ImageSpec spec(window.width(), window.height(), int(plan.channels.size()), type_of(plan.channels[0].store));
  spec.channelnames.clear();
  for (size_t i = 0; i < plan.channels.size(); ++i) {
    const PlannedChannel& channel = plan.channels[i];
    spec.channelnames.push_back(channel.name);
    spec.channelformats.push_back(type_of(channel.store));
    if (channel.name == "A" && plan.channels.size() > 1) spec.alpha_channel = int(i);
  }
  set_attributes(image, out, plan.kind, spec);
  spec.attribute("PixelAspectRatio", image.framing.pixelAspectRatio);
  spec.attribute("oiio:UnassociatedAlpha", 1);  // PNG and TIFF get straight alpha; EXR ignores this
  switch (plan.kind) {
    case FileKind::exr:
      set_windows(image.framing, spec);
      spec.attribute("compression", image.incomplete ? "none" : "zip");
      break;
    case FileKind::jpeg:
      spec.attribute("compression", "jpeg:95");
      spec.attribute("jpeg:subsampling", "4:4:4");
      break;
    case FileKind::tiff:
      spec.attribute("compression", image.incomplete ? "none" : "zip");
      break;
    case FileKind::png:
      if (!image.incomplete) break;
      spec.attribute("png:compressionLevel", 0);
      spec.attribute("png:filter", kPngNoFilter);
      break;
  }
  return spec;
}

/// Encodes the file in memory. OpenImageIO's own PNG writer does not notice a full disk, and its JPEG writer ends the
/// process on one. Returns an empty text on success, else the reason.
std::string encode(const OIIO::ImageSpec& spec, const ProductPlan& plan, const RowEncoder& rows,
                   std::vector<unsigned char>& file) {
  constexpr const char* kNames[] = {"x.exr", "x.png", "x.tif", "x.jpg"};
  const char* name = kNames[int(plan.kind)];
  OIIO::Filesystem::IOVecOutput memory(file);
  const auto output = OIIO::ImageOutput::create(name);
  if (!output) return "OpenImageIO cannot write this format: " + OIIO::geterror();
  output->set_ioproxy(&memory);
  if (!output->open(name, spec)) return output->geterror();
  const int rows_at_once = int(std::clamp(kStripBytes / rows.row_bytes(), size_t(1), size_t(spec.height)));
  std::vector<uint8_t> strip(rows.row_bytes() * size_t(rows_at_once));
  for (int y = 0; y < spec.height; y += rows_at_once) {
    const int end = std::min(y + rows_at_once, spec.height);
    rows.encode(y, end, strip.data());
    const bool good = output->write_scanlines(
        spec.y + y, spec.y + end, 0, plan.kind == FileKind::exr ? OIIO::TypeUnknown : spec.format, strip.data());
    if (!good) return output->geterror();
  }
  return output->close() ? std::string() : output->geterror();
}

/// Takes alpha out of the plan if the image has none. Returns false after a report if it lacks anything else.
bool check_image(const RenderProduct& product, const ProductImage& image, ProductPlan& plan,
                 const DiagnosticSink& sink) {
  if (!image.framing.valid())
    return fail(sink, "product.framing", product.file, "the frame is empty; give a display and a data window");
  const Rect2i& window = image.framing.dataWindow;
  const size_t count = size_t(window.width()) * size_t(window.height());
  std::erase_if(plan.channels, [&](const PlannedChannel& channel) {
    const auto found = image.aovs.find(channel.aov.str());
    return channel.aov == Token("color") && found != image.aovs.end() && found->second.components == 3 &&
           channel.component == 3;
  });
  for (const PlannedChannel& channel : plan.channels) {
    const auto found = image.aovs.find(channel.aov.str());
    if (found == image.aovs.end())
      return fail(sink, "product.aov.missing", product.file,
                  "AOV '" + channel.aov.str() + "' was not rendered; bind a render buffer to it or leave it out");
    const AovPixels& pixels = found->second;
    const size_t values = pixels.floats.size() + (channel.is_color ? 0 : pixels.ints.size());
    const bool fits = channel.component < pixels.components && values == count * size_t(pixels.components);
    if (!fits)
      return fail(sink, "product.aov.size", product.file,
                  "AOV '" + channel.aov.str() + "' does not fill the data window of " + std::to_string(window.width()) +
                      " x " + std::to_string(window.height()) + "; resolve it in the format the delegate proposes");
  }
  return true;
}

bool check_output(const std::string& file, const DiagnosticSink& sink) {
  const std::string fault = support::OutputFault(file);
  return fault.empty() || fail(sink, "product.file", file, fault);
}

std::string lines(const std::string& title, const std::vector<std::string>& names) {
  std::string text = title + ":" + (names.empty() ? " none" : "") + "\n";
  for (const std::string& name : names) text += "  " + name + "\n";
  return text;
}

}  // namespace

bool CheckProduct(const RenderProduct& product, const OutputColors& colors, const DiagnosticSink& sink) {
  try {
    ProductPlan plan;
    std::string error;
    if (!PlanProduct(product, plan, error)) return fail(sink, "product.invalid", product.file, error);
    OutputTransform out;
    return check_output(product.file, sink) && make_output_transform(product, plan, colors, sink, out);
  } catch (const std::exception& e) {
    return fail(sink, "product.invalid", product.file, std::string(e.what()) + "; check the product's settings");
  }
}

namespace {

bool write_product(const RenderProduct& product, const ProductImage& image, const OutputColors& colors,
                   const DiagnosticSink& sink) {
  try {
    ProductPlan plan;
    std::string error;
    if (!PlanProduct(product, plan, error)) return fail(sink, "product.invalid", product.file, error);
    OutputTransform out;
    if (!check_image(product, image, plan, sink) || !make_output_transform(product, plan, colors, sink, out))
      return false;
    OIIO::ImageSpec spec = make_spec(plan, image, out);
    if (plan.kind == FileKind::exr && !plan.display_referred) {
      const auto xy = out.config->chromaticities(product.colorSpace);
      spec.attribute("chromaticities", OIIO::TypeDesc(OIIO::TypeDesc::FLOAT, 8), xy.data());
    }
    const RowEncoder rows(plan, image, *out.transform);
    std::vector<unsigned char> file;
    // Room that is not used costs nothing; growing would copy the file.
    file.reserve(spec.image_bytes(true) + spec.image_bytes(true) / 64);
    error = encode(spec, plan, rows, file);
    if (!error.empty())
      return fail(sink, "product.encode", product.file, "cannot encode the image: " + error + "; write an .exr file");
    error =
        support::WriteOutputFile(product.file, file, image.incomplete ? support::Flush::none : support::Flush::disk);
    if (!error.empty())
      return fail(sink, "product.write", product.file,
                  error + "; check the folder, its permissions and the space on the disk, or write elsewhere");
    return true;
  } catch (const std::bad_alloc&) {
    return fail(sink, "product.memory", product.file, "not enough memory to encode the image; write a smaller crop");
  } catch (const std::exception& e) {
    return fail(sink, "product.write", product.file, std::string(e.what()) + "; check the product's settings");
  }
}

}  // namespace

std::vector<std::string> WriteProducts(const std::vector<RenderProduct>& products, const ProductImage& image,
                                       const OutputColors& colors, const DiagnosticSink& sink) {
  std::mutex mutex;
  const DiagnosticSink one_at_a_time = [&](const Diagnostic& diagnostic) {
    const std::lock_guard lock(mutex);
    if (sink) sink(diagnostic);
  };
  std::vector<char> written(products.size(), 0);
  // The host's own arena may be busy or limited to one thread.
  tbb::task_arena arena;
  arena.execute([&] {
    tbb::parallel_for(size_t(0), products.size(),
                      [&](size_t i) { written[i] = write_product(products[i], image, colors, one_at_a_time); });
  });
  std::vector<std::string> files;
  for (size_t i = 0; i < products.size(); ++i)
    if (written[i]) files.push_back(products[i].file);
  return files;
}

bool ApplyDisplay(const RenderProduct& product, const OutputColors& colors, std::span<float> rgb,
                  const DiagnosticSink& sink) {
  try {
    ProductPlan plan;
    plan.display_referred = true;
    OutputTransform out;
    if (!make_output_transform(product, plan, colors, sink, out)) return false;
    constexpr size_t kPixelsAtOnce = 1024;
    std::array<float, 4 * kPixelsAtOnce> rgba;
    for (size_t first = 0; first < rgb.size() / 3; first += kPixelsAtOnce) {
      const std::span<float> pixels = rgb.subspan(3 * first).first(3 * std::min(kPixelsAtOnce, rgb.size() / 3 - first));
      for (size_t i = 0; i < pixels.size(); ++i) rgba[i / 3 * 4 + i % 3] = pixels[i];
      out.transform->apply(rgba.data(), pixels.size() / 3);
      for (size_t i = 0; i < pixels.size(); ++i) {
        const float v = rgba[i / 3 * 4 + i % 3];
        pixels[i] = v > 0 ? std::min(v, 1.0f) : 0.0f;  // a NaN is black
      }
    }
    return true;
  } catch (const std::bad_alloc&) {
    return fail(sink, "product.memory", product.file, "not enough memory to convert the image; take a smaller crop");
  } catch (const std::exception& e) {
    return fail(sink, "product.invalid", product.file, std::string(e.what()) + "; check the product's settings");
  }
}

std::string DescribeColors(const OutputColors& colors, const DiagnosticSink& sink) {
  const auto config = ColorConfig::load(colors.ocio, to_core(sink));
  if (!config) return {};
  std::string text = "configuration: " + config->origin() + "\nrendering space: " + config->rendering_space() + "\n";
  text += lines("colour spaces", config->color_spaces());
  text += "displays (* is the default):\n";
  for (const std::string& display : config->displays()) {
    text += "  " + display + (display == config->default_display() ? " *" : "") + "\n";
    for (const std::string& view : config->views(display))
      text += "    " + view + (view == config->default_view(display) ? " *" : "") + "\n";
  }
  return text + lines("looks", config->looks());
}

std::string SerializeColors(const OutputColors& colors, const DiagnosticSink& sink) {
  const auto config = ColorConfig::load(colors.ocio, to_core(sink));
  return config ? config->serialize() : std::string();
}

}  // namespace alabaster::hd::host
