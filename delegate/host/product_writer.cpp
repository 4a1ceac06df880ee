#include "delegate/host/product_writer.h"

#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <climits>
#include <cmath>
#include <cstdio>
#include <mutex>
#include <nlohmann/json.hpp>
#include <set>

#include "core/color/config_inputs.h"
#include "core/digest/cryptomatte_hash.h"
#include "core/files/real_path.h"
#include "core/film/aov.h"
#include "core/images/format_limits.h"
#include "core/math/float_environment.h"
#include "delegate/host/light_paths.h"
#include "delegate/host/planned_product.h"
#include "delegate/host/product_metadata.h"
#include "delegate/host/product_pixels.h"
#include "delegate/support/json_values.h"
#include "delegate/support/output_file.h"
#include "delegate/support/size_text.h"

namespace alabaster::hd::host {
namespace {

bool fail(const DiagnosticSink& sink, const char* code, const std::string& where, std::string text) {
  if (sink) sink({Severity::error, code, where, std::move(text)});
  return false;
}

// ---- attributes -----------------------------------------------------------------------------------------------------

/// The value in the type that EXR has for it, or as text if it has none.
decltype(ImageAttribute::value) attribute_value(const Value& value) {
  const auto at = [&](size_t i) { return static_cast<float>(value.component(i)); };
  const auto whole = [&](size_t i) { return static_cast<int>(value.component(i)); };
  if (value.is_array()) return value.to_string();
  switch (value.type()) {
    case ALABASTER_FLOAT:
      return at(0);
    case ALABASTER_DOUBLE:
      return value.component(0);
    case ALABASTER_FLOAT2:
      return std::array{at(0), at(1)};
    case ALABASTER_FLOAT3:
      return std::array{at(0), at(1), at(2)};
    case ALABASTER_INT2:
      return std::array{whole(0), whole(1)};
    case ALABASTER_INT3:
      return std::array{whole(0), whole(1), whole(2)};
    case ALABASTER_MATRIX: {
      std::array<double, 16> numbers{};
      for (size_t i = 0; i < numbers.size(); ++i) numbers[i] = value.component(i);
      return numbers;
    }
    case ALABASTER_BOOL:
    case ALABASTER_INT:
    case ALABASTER_INT64:
    case ALABASTER_UINT:
      if (const double number = value.component(0); number >= INT_MIN && number <= INT_MAX) return whole(0);
      return value.to_string();
    case ALABASTER_TOKEN:
    case ALABASTER_STRING:
    case ALABASTER_PATH:
      return value.text_or("");
    default:
      return value.to_string();
  }
}

bool is_camera_matrix(const std::string& key) {
  return std::any_of(std::begin(kCameraMatrices), std::end(kCameraMatrices), [&](const char* n) { return key == n; });
}

std::vector<ImageAttribute> attributes_of(const ProductImage& image, const OutputTransform& out, FileKind kind) {
  std::vector<ImageAttribute> attributes;
  for (const auto& [key, value] : image.metadata) {
    if (kind != FileKind::exr && is_camera_matrix(key)) continue;  // others have no matrices
    if (key.starts_with("oiio:") || value.empty()) continue;       // directions to OpenImageIO are not the host's
    const std::string name = key == "capDate" ? "DateTime" : key;  // OpenImageIO's name for EXR's attribute
    attributes.push_back({name, attribute_value(value)});
  }
  attributes.push_back({"colorSpace", out.description});
  if (image.incomplete) attributes.push_back({"alabaster/incomplete", 1});
  if (!image.metadata.contains("Software")) {
    const std::string versions = AlabasterVersions();
    attributes.push_back({"Software", "Alabaster " + versions.substr(0, versions.find('\n'))});
  }
  return attributes;
}

/// The names of the numbers in a file: of Cryptomatte's layers as its specification 1.2.0 has them, of others by
/// number.
void add_names(const ProductPlan& plan, const Dictionary& names, std::vector<ImageAttribute>* attributes) {
  std::set<std::string> layers;
  for (const PlannedChannel& channel : plan.channels) {
    const std::string aov(rank_pair(channel.aov.str()).aov);
    const AovInfo* info = find_aov(aov);
    const auto found = names.find(aov);
    if (plan.kind != FileKind::exr || !info || found == names.end()) continue;
    const std::string table =
        support::json_of(found->second).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
    std::string layer = channel.name.substr(0, channel.name.rfind('.'));
    if (info->source == AovSource::ids && layer.size() > 2) layer.resize(layer.size() - 2);  // without its number
    if (!layers.insert(layer).second) continue;
    if (info->source != AovSource::ids) {
      attributes->push_back({"alabaster/names/" + aov, table});
      continue;
    }
    char id[9];
    std::snprintf(id, sizeof id, "%08x", cryptomatte_hash(layer));
    const std::string prefix = "cryptomatte/" + std::string(id, 7) + "/";
    attributes->push_back({prefix + "name", layer});
    attributes->push_back({prefix + "hash", std::string("MurmurHash3_32")});
    attributes->push_back({prefix + "conversion", std::string("uint32_to_float32")});
    attributes->push_back({prefix + "manifest", table});
  }
}

bool has_color(const ProductPlan& plan) {
  return std::any_of(plan.channels.begin(), plan.channels.end(), [](const auto& c) { return c.is_color; });
}

/// Somebody waits for an incomplete image, so it is not compressed.
ImageDescription describe(const ProductPlan& plan, const ProductImage& image, const OutputTransform& out) {
  const Framing& framing = image.framing;
  ImageDescription file;
  file.kind = plan.kind;
  file.width = framing.dataWindow.width(), file.height = framing.dataWindow.height();
  for (const PlannedChannel& channel : plan.channels) file.channels.push_back({channel.name, channel.store});
  file.pixel_aspect = framing.pixelAspectRatio;
  file.origin = {framing.dataWindow.minX, framing.dataWindow.minY};
  const int x = int(std::lround(framing.displayMin.x)), y = int(std::lround(framing.displayMin.y));
  file.display = {x, y, std::max(1, int(std::lround(framing.displayMax.x)) - x),
                  std::max(1, int(std::lround(framing.displayMax.y)) - y)};
  file.attributes = attributes_of(image, out, plan.kind);
  add_names(plan, image.names, &file.attributes);
  if (has_color(plan) && out.encoding != kSrgbCodePoints) file.encoding = out.encoding;
  file.fast = image.incomplete;
  file.compression = plan.compression;
  file.tiles = plan.tiles;
  return file;
}

/// OpenEXR's corners are ints, of which it uses half.
bool is_within_limits(const Framing& framing) {
  constexpr float kMost = 1e9f;
  const Vec2f &low = framing.displayMin, &high = framing.displayMax;
  const Rect2i& window = framing.dataWindow;
  for (const float corner :
       {low.x, low.y, high.x, high.y, float(window.minX), float(window.minY), float(window.maxX), float(window.maxY)})
    if (!(std::abs(corner) <= kMost)) return false;
  return true;
}

/// Bytes of a value in a text. Lines after the first are indented by two.
size_t text_size(const std::string& value) {
  return value.size() + 2 * size_t(std::count(value.begin(), value.end(), '\n'));
}
template <class T>
size_t text_size(const T& numbers) {
  constexpr size_t kNumber = 24, kWord = 4;  // bytes of a number in text, and in memory
  return sizeof numbers / kWord * kNumber;
}
/// Bytes of an attribute in a text that holds them all.
size_t text_size(const ImageAttribute& attribute) {
  return attribute.name.size() + 3 + std::visit([](const auto& value) { return text_size(value); }, attribute.value);
}

/// `text` cut to at most `bytes` bytes, at a boundary of UTF-8 characters.
std::string cut_off(const std::string& text, size_t bytes) {
  while (bytes > 0 && (static_cast<unsigned char>(text[bytes]) & 0xc0) == 0x80) --bytes;
  return text.substr(0, bytes) + "...";
}

/// Cuts off or leaves out, after a warning, what the file cannot hold.
void limit_attributes(const RenderProduct& product, const DiagnosticSink& sink, ImageDescription* file) {
  constexpr size_t kLongestInJpeg = 4000;  // bytes
  const bool jpeg = file->kind == FileKind::jpeg;
  size_t left = kMostJpegText;
  std::vector<ImageAttribute> kept;
  for (ImageAttribute& attribute : file->attributes) {
    const char* fault = nullptr;
    if (auto* text = std::get_if<std::string>(&attribute.value); jpeg && text && text->size() > kLongestInJpeg) {
      *text = cut_off(*text, kLongestInJpeg);
      fault = "is cut off: a JPEG holds short texts only; an .exr file holds all of it";
    }
    const size_t size = text_size(attribute);
    const bool fits = jpeg ? size <= left : file->kind != FileKind::exr || attribute.name.size() <= kLongestExrName;
    if (!fits)
      fault = jpeg ? "is left out: a JPEG holds short texts only; an .exr file holds it"
                   : "is left out: names of attributes in an EXR have 255 bytes at most; give it a shorter one";
    if (fault && sink)
      sink({Severity::warning, "product.attribute", product.file,
            "attribute '" + attribute.name.substr(0, kLongestExrName) + "' " + fault});
    if (!fits) continue;
    left -= jpeg ? size : 0;
    kept.push_back(std::move(attribute));
  }
  file->attributes = std::move(kept);
}

/// Takes alpha out of the plan if the image has none. Returns false after a report if it lacks anything else.
bool check_image(const RenderProduct& product, const ProductImage& image, ProductPlan& plan,
                 const DiagnosticSink& sink) {
  if (!image.framing.valid())
    return fail(sink, "product.framing", product.file, "the frame is empty; give a display and a data window");
  if (!is_within_limits(image.framing))
    return fail(sink, "product.framing", product.file,
                "the display or data window reaches beyond 1e9 pixels; give it other corners");
  if (const std::string fault = window_fault(plan, image.framing.dataWindow); !fault.empty())
    return fail(sink, "product.invalid", product.file, fault);
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
                  "AOV '" + channel.aov.str() + "' does not fill the data window of " +
                      support::size_text(window.width(), window.height()) +
                      "; resolve it in the format the delegate proposes");
  }
  return true;
}

/// Viewers take a file without tags for sRGB.
void report_untagged(const RenderProduct& product, const ProductPlan& plan, const OutputTransform& out,
                     const DiagnosticSink& sink) {
  if (!sink || !has_color(plan) || !plan.display_referred || plan.kind == FileKind::exr) return;
  if (out.encoding == kSrgbCodePoints || (out.encoding && plan.kind == FileKind::png)) return;
  const char* const name = plan.kind == FileKind::png ? "PNG" : plan.kind == FileKind::tiff ? "TIFF" : "JPEG";
  sink({Severity::warning, "product.untagged", product.file,
        std::string("this ") + name + " cannot say the colour space of display and view '" + out.description +
            "', and viewers take it for sRGB; " +
            (out.encoding ? "write a .png file, which says it, or choose a display of sRGB"
                          : "choose a display and view of sRGB, or name the space where the file is opened")});
}

bool check_output(const RenderProduct& product, const DiagnosticSink& sink) {
  if (!product.within.empty())
    if (const std::string fault = outside_fault(product.within, product.file); !fault.empty())
      return fail(sink, "product.outside", product.file, fault);
  const std::string fault = support::OutputFault(product.file, product.within);
  return fault.empty() || fail(sink, "product.file", product.file, fault);
}

std::string lines(const std::string& title, const std::vector<std::string>& names) {
  std::string text = title + ":" + (names.empty() ? " none" : "") + "\n";
  for (const std::string& name : names) text += "  " + name + "\n";
  return text;
}

ProductStatus status_of(const std::string& code) {
  if (code.starts_with("ocio.")) return ProductStatus::colors;
  if (code == "product.invalid") return ProductStatus::invalid;
  if (code == "product.outside") return ProductStatus::outside;
  return code == "product.memory" ? ProductStatus::out_of_memory : ProductStatus::output;
}

bool make_plan(const RenderProduct& product, const OutputColors& colors, const DiagnosticSink& sink,
               PlannedProduct* planned) {
  std::string error;
  planned->product = product;
  if (!PlanProduct(product, planned->plan, error)) return fail(sink, "product.invalid", product.file, error);
  return make_output_transform(product, planned->plan, colors, sink, planned->out);
}

/// False after a report, too, where `plan` throws.
template <class Plan>
bool guarded(const RenderProduct& product, const DiagnosticSink& sink, const Plan& plan) {
  try {
    return plan();
  } catch (const MemoryRefused& e) {
    return fail(sink, "product.memory", product.file, e.what());
  } catch (const std::exception& e) {
    return fail(sink, "product.invalid", product.file, std::string(e.what()) + "; check the product's settings");
  }
}

bool write_product(const PlannedProduct& planned, const ProductImage& image, const DiagnosticSink& sink) {
  const auto& [product, whole_plan, out] = planned;
  try {
    ProductPlan plan = whole_plan;
    if (!check_image(product, image, plan, sink)) return false;
    std::string error;
    const ImageFunctions* images = image_functions(&error);
    if (!images) return fail(sink, "images.library", product.file, error);
    ImageDescription description = describe(plan, image, out);
    if (plan.kind == FileKind::exr && !plan.display_referred)
      description.attributes.push_back({"chromaticities", out.config->chromaticities(product.colorSpace)});
    limit_attributes(product, sink, &description);
    const RowEncoder rows(plan, image, *out.transform);
    std::vector<unsigned char> file;
    error = images->encode(description, rows, file);
    if (!error.empty())
      return fail(sink, "product.encode", product.file, "cannot encode the image: " + error + "; write an .exr file");
    error = support::WriteOutputFile(product.file, file, image.incomplete ? support::Flush::none : support::Flush::disk,
                                     product.within);
    if (error.empty()) return true;
    if (const std::string kept = support::KeepElsewhere(product.file, file); !kept.empty())
      return fail(sink, "product.write", product.file,
                  error + "; the picture was kept as " + kept + ": move it to its place");
    return fail(sink, "product.write", product.file,
                error + "; check the folder, its permissions and the space on the disk, or write elsewhere");
  } catch (const MemoryRefused& e) {
    return fail(sink, "product.memory", product.file, e.what());
  } catch (const std::bad_alloc&) {
    return fail(sink, "product.memory", product.file, "not enough memory to encode the image; write a smaller crop");
  } catch (const std::exception& e) {
    return fail(sink, "product.write", product.file, std::string(e.what()) + "; check the product's settings");
  }
}

}  // namespace

ProductCheck plan_product(const RenderProduct& product, const Rect2i& window, const OutputColors& colors,
                          const DiagnosticSink& sink, PlannedProduct* planned) {
  const FloatEnvironment environment;
  ProductCheck fault;  // the last error is the cause
  const DiagnosticSink noted = [&](const Diagnostic& diagnostic) {
    if (diagnostic.severity == Severity::error) fault = {status_of(diagnostic.code), diagnostic.text};
    if (sink) sink(diagnostic);
  };
  const bool ok = guarded(product, noted, [&] {
    if (!make_plan(product, colors, noted, planned)) return false;
    const ProductPlan& plan = planned->plan;
    std::string error = window_fault(plan, window);
    if (!error.empty()) return fail(noted, "product.invalid", product.file, error);
    if (!check_output(product, noted)) return false;
    if (!image_functions(&error)) return fail(noted, "images.library", product.file, error);
    if (plan.kind == FileKind::exr && !plan.display_referred)
      report_unknown_primaries(*planned->out.config, to_core(noted));
    report_untagged(product, plan, planned->out, noted);
    return true;
  });
  return ok ? ProductCheck() : fault;
}

ProductCheck CheckProduct(const RenderProduct& product, const Rect2i& window, const OutputColors& colors,
                          const DiagnosticSink& sink) {
  PlannedProduct planned;
  RenderProduct resolved = product;
  resolve_light_paths(&resolved.vars);
  return plan_product(resolved, window, colors, sink, &planned);
}

std::vector<std::string> write_planned(const std::vector<PlannedProduct>& products, const ProductImage& image,
                                       const DiagnosticSink& sink) {
  const FloatEnvironment environment;
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
                      [&](size_t i) { written[i] = write_product(products[i], image, one_at_a_time); });
  });
  std::vector<std::string> files;
  for (size_t i = 0; i < products.size(); ++i)
    if (written[i]) files.push_back(products[i].product.file);
  return files;
}

std::vector<std::string> WriteProducts(const std::vector<RenderProduct>& products, const ProductImage& image,
                                       const OutputColors& colors, const DiagnosticSink& sink) {
  const FloatEnvironment environment;
  std::vector<PlannedProduct> planned;
  for (const RenderProduct& product : products) {
    PlannedProduct one;
    if (guarded(product, sink, [&] { return make_plan(product, colors, sink, &one); })) planned.push_back(one);
  }
  return write_planned(planned, image, sink);
}

std::string DescribeColors(const OutputColors& colors, const DiagnosticSink& sink) {
  const auto config = colors.config(sink);
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

std::vector<ColorDisplay> ListDisplays(const OutputColors& colors, const DiagnosticSink& sink) {
  std::vector<ColorDisplay> all;
  const auto config = colors.config(sink);
  if (!config) return all;
  const auto with_first = [](std::vector<std::string> names, const std::string& first) {
    std::stable_partition(names.begin(), names.end(), [&](const std::string& name) { return name == first; });
    return names;
  };
  for (const std::string& display : with_first(config->displays(), config->default_display()))
    all.push_back({display, with_first(config->views(display), config->default_view(display))});
  return all;
}

std::string SerializeColors(const OutputColors& colors, const DiagnosticSink& sink) {
  const FloatEnvironment environment;
  const auto config = colors.config(sink);
  return config ? config->serialize() : std::string();
}

}  // namespace alabaster::hd::host
