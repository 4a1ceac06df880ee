#include "delegate/host/product_writer.h"

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>
#include <half.h>
#include <unistd.h>

#include <algorithm>
#include <climits>
#include <cmath>
#include <cstring>
#include <filesystem>

#include "core/color/color_config.h"
#include "delegate/host/atomic_file.h"
#include "delegate/host/product_plan.h"

namespace alabaster::hd::host {
namespace {

constexpr float kLargestHalf = 65504.0f;
constexpr int kRowsAtOnce = 64;

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

/// How the colours of one product leave the rendering space.
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

/// Sets one attribute in the type that EXR has for it; what it has no type for becomes text.
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
  std::string program = "Alabaster";
  if (const auto version = image.metadata.find("alabaster/version"); version != image.metadata.end())
    if (const auto* text = version->second.get<std::string>()) program += " " + *text;
  spec.attribute("Software", program);
  if (kind == FileKind::exr) return;

  // The other formats have no free attributes (PNG: only texts): one description holds them all.
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

/// PNG, TIFF and JPEG hold the data window alone: viewers disagree about offsets.
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
      spec.attribute("compression", "zip");
      break;
    case FileKind::jpeg:
      spec.attribute("compression", "jpeg:95");
      spec.attribute("jpeg:subsampling", "4:4:4");
      break;
    case FileKind::tiff:
      spec.attribute("compression", "zip");
      break;
    case FileKind::png:
      break;
  }
  return spec;
}

// ---- pixels ---------------------------------------------------------------------------------------------------------

/// A number in [0, 1) that depends on the pixel of the full frame alone, so that crops and re-renders agree (PCG's
/// output permutation, O'Neill 2014, over a multiplicative mix of the position).
float dither_of(int x, int y, int channel) {
  uint32_t h = uint32_t(x) * 0x9e3779b1u ^ uint32_t(y) * 0x85ebca77u ^ uint32_t(channel + 1) * 0xc2b2ae3du;
  h = h * 747796405u + 2891336453u;
  h = ((h >> ((h >> 28) + 4)) ^ h) * 277803737u;
  h = (h >> 22) ^ h;
  return float(h >> 8) * 0x1p-24f;
}

template <class T>
void put(uint8_t*& out, T value) {
  std::memcpy(out, &value, sizeof value);
  out += sizeof value;
}

/// Fills strips of the file: one row of AOVs at a time, converted, then stored channel by channel.
class RowEncoder {
 public:
  RowEncoder(const ProductPlan& plan, const ProductImage& image, const ColorTransform& transform)
      : plan_(plan), image_(image), transform_(transform), width_(size_t(image.framing.dataWindow.width())) {
    for (const PlannedChannel& channel : plan.channels) {
      if (!channel.is_color || converted_.contains(channel.aov.str())) continue;
      converted_[channel.aov.str()].resize(4 * width_);
    }
  }

  void encode(int row, uint8_t*& out) {
    for (auto& [name, rgba] : converted_) convert(image_.aovs.at(name), size_t(row), rgba);
    for (size_t x = 0; x < width_; ++x)
      for (const PlannedChannel& channel : plan_.channels) store(channel, x, row, out);
  }

 private:
  // EXR keeps its colour premultiplied, as compositors expect. PNG and TIFF hold straight colour, and what an eye sees
  // of it is what the view makes of the straight colour. JPEG, without alpha, is the frame over black: its
  // premultiplied colour.
  void convert(const AovPixels& pixels, size_t row, std::vector<float>& rgba) const {
    const size_t components = size_t(pixels.components);
    const bool straight = components == 4 && (plan_.kind == FileKind::png || plan_.kind == FileKind::tiff);
    const float* in = pixels.floats.data() + row * width_ * components;
    for (size_t x = 0; x < width_; ++x) {
      const float alpha = components == 4 ? in[components * x + 3] : 1.0f;
      const float scale = straight && alpha > 0 && alpha < 1 ? 1 / alpha : 1.0f;
      for (size_t c = 0; c < 3; ++c) rgba[4 * x + c] = in[components * x + c] * scale;
      rgba[4 * x + 3] = 1;
    }
    // Unconverted colours keep their full float range; but a NaN in a file spreads through every filter after it.
    if (!transform_.is_noop()) return transform_.apply(rgba.data(), width_);
    for (float& v : rgba) v = std::isfinite(v) ? v : 0.0f;
  }

  float value_of(const PlannedChannel& channel, const AovPixels& pixels, size_t x, int row) const {
    if (channel.is_color) return converted_.at(channel.aov.str())[4 * x + size_t(channel.component)];
    const size_t at = (size_t(row) * width_ + x) * size_t(pixels.components) + size_t(channel.component);
    return pixels.integer ? float(pixels.ints[at]) : pixels.floats[at];
  }

  void store(const PlannedChannel& channel, size_t x, int row, uint8_t*& out) const {
    const AovPixels& pixels = image_.aovs.at(channel.aov.str());
    if (channel.store == ChannelStore::uint32) {
      const size_t at = (size_t(row) * width_ + x) * size_t(pixels.components);
      return put(out, pixels.integer ? uint32_t(pixels.ints[at]) : count_of(pixels.floats[at]));
    }
    const float v = value_of(channel, pixels, x, row);
    switch (channel.store) {
      case ChannelStore::half:
        return put(out, Imath::half(std::clamp(v, -kLargestHalf, kLargestHalf)));
      case ChannelStore::uint8:
        return put(out, uint8_t(quantise(v, 255, channel, x, row)));
      case ChannelStore::uint16:
        return put(out, uint16_t(quantise(v, 65535, channel, x, row)));
      default:
        return put(out, v);
    }
  }

  static uint32_t count_of(float v) { return v >= 0 && v < 4294967040.0f ? uint32_t(v + 0.5f) : UINT32_MAX; }

  /// 8-bit colours are dithered against banding; exact levels (black, white) stay exact, for only what lies between two
  /// levels can go either way.
  float quantise(float v, float levels, const PlannedChannel& channel, size_t x, int row) const {
    const float scaled = (v > 0 ? std::min(v, 1.0f) : 0.0f) * levels;  // a NaN is black
    const Rect2i& window = image_.framing.dataWindow;
    const bool dithers = channel.is_color && channel.store == ChannelStore::uint8 && plan_.display_referred;
    const float threshold = dithers ? dither_of(window.minX + int(x), window.minY + row, channel.component) : 0.5f;
    return std::min(std::floor(scaled + threshold), levels);
  }

  const ProductPlan& plan_;
  const ProductImage& image_;
  const ColorTransform& transform_;
  size_t width_;
  std::map<std::string, std::vector<float>> converted_;  // one RGBA row for each colour AOV
};

/// Encodes the whole file in memory: OpenImageIO's PNG writer does not notice a full disk and its JPEG writer ends the
/// process, so the bytes are put on the disk by code that does neither. Empty on success, else the reason.
std::string encode(const OIIO::ImageSpec& spec, const ProductPlan& plan, RowEncoder& rows,
                   std::vector<unsigned char>& file) {
  constexpr const char* kNames[] = {"x.exr", "x.png", "x.tif", "x.jpg"};
  const char* name = kNames[int(plan.kind)];
  OIIO::Filesystem::IOVecOutput memory(file);
  const auto output = OIIO::ImageOutput::create(name);
  if (!output) return "OpenImageIO has no writer for it: " + OIIO::geterror();
  output->set_ioproxy(&memory);
  if (!output->open(name, spec)) return output->geterror();
  const size_t row_bytes = spec.scanline_bytes(true);
  std::vector<uint8_t> strip(row_bytes * size_t(std::min(kRowsAtOnce, spec.height)));
  for (int y = 0; y < spec.height; y += kRowsAtOnce) {
    const int end = std::min(y + kRowsAtOnce, spec.height);
    uint8_t* at = strip.data();
    for (int row = y; row < end; ++row) rows.encode(row, at);
    const bool good = output->write_scanlines(
        spec.y + y, spec.y + end, 0, plan.kind == FileKind::exr ? OIIO::TypeUnknown : spec.format, strip.data());
    if (!good) return output->geterror();
  }
  return output->close() ? std::string() : output->geterror();
}

/// Drops the alpha that the image does not have, and says what else is missing.
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
    const size_t values = pixels.integer ? pixels.ints.size() : pixels.floats.size();
    const bool fits = channel.component < pixels.components && values == count * size_t(pixels.components) &&
                      !(channel.is_color && pixels.integer);
    if (!fits)
      return fail(sink, "product.aov.size", product.file,
                  "AOV '" + channel.aov.str() + "' does not fill the data window of " + std::to_string(window.width()) +
                      " x " + std::to_string(window.height()) + "; resolve it in the format the delegate proposes");
  }
  return true;
}

bool check_folder(const std::string& file, const DiagnosticSink& sink) {
  namespace fs = std::filesystem;
  std::error_code error;
  const fs::path path(file);
  const fs::path folder = path.has_parent_path() ? path.parent_path() : fs::path(".");
  if (!fs::is_directory(folder, error))
    return fail(sink, "product.folder", file, "there is no folder '" + folder.string() + "'; create it");
  if (fs::is_directory(path, error))
    return fail(sink, "product.file", file, "a folder has this name; choose another name");
  if (::access(folder.c_str(), W_OK | X_OK) != 0)
    return fail(
        sink, "product.folder", file,
        "the folder '" + folder.string() + "' may not be written to; change its permissions or write elsewhere");
  return true;
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
    return check_folder(product.file, sink) && make_output_transform(product, plan, colors, sink, out);
  } catch (const std::exception& e) {
    return fail(sink, "product.invalid", product.file, std::string(e.what()) + "; check the product's settings");
  }
}

bool WriteProduct(const RenderProduct& product, const ProductImage& image, const OutputColors& colors,
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
    RowEncoder rows(plan, image, *out.transform);
    std::vector<unsigned char> file;
    error = encode(spec, plan, rows, file);
    if (!error.empty())
      return fail(sink, "product.encode", product.file, "cannot encode the image: " + error + "; write an .exr file");
    error = WriteFileAtomically(product.file, file);
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
