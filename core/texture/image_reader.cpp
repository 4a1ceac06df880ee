#include "core/texture/image_reader.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <span>
#include <string_view>

#include "core/texture/png_stream.h"

namespace alabaster {
namespace {

constexpr int kRowsAtOnce = 64;
constexpr size_t kStripBytes = size_t(64) << 20;  // fewer rows at once where they are very long

struct Magic {
  std::string_view bytes;
  const char* format;  // OpenImageIO's name of the reader
};
// Only formats that scenes use, picked by content: OpenImageIO would offer an unknown file to each of its readers,
// movie and medical ones among them.
constexpr Magic kMagics[] = {
    {std::string_view("\x89PNG\r\n\x1a\n", 8), "png"},
    {"\xff\xd8\xff", "jpeg"},
    {"v/1\x01", "openexr"},
    {std::string_view("II*\0", 4), "tiff"},
    {std::string_view("MM\0*", 4), "tiff"},
    {"#?RADIANCE", "hdr"},
    {"#?RGBE", "hdr"},
    {"RIFF", "webp"},
    {"BM", "bmp"},
};

std::string format_of(std::span<const uint8_t> head, const std::string& path) {
  const std::string_view text(reinterpret_cast<const char*>(head.data()), head.size());
  for (const Magic& magic : kMagics)
    if (text.starts_with(magic.bytes) && (magic.bytes != "RIFF" || text.substr(0, 12).ends_with("WEBP")))
      return magic.format;
  std::string ending = std::filesystem::path(path).extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(),
                 [](char c) { return c >= 'A' && c <= 'Z' ? char(c + 32) : c; });
  return ending == ".tga" ? "targa" : "";  // TGA is the one without a signature
}

ImageLayout layout_of(const OIIO::ImageSpec& spec) {
  ImageLayout layout;
  layout.width = spec.width;
  layout.height = spec.height;
  layout.channels = size_t(spec.nchannels);
  // Renderers' EXRs hold many layers: the plain R, G, B, A are the picture. Without names, one or two channels are grey
  // and grey with alpha.
  const int r = spec.channelindex("R"), g = spec.channelindex("G"), b = spec.channelindex("B");
  if (r >= 0 && g >= 0 && b >= 0)
    layout.rgb = {size_t(r), size_t(g), size_t(b)};
  else if (spec.nchannels >= 3)
    layout.rgb = {0, 1, 2};
  if (const int a = spec.channelindex("A"); a >= 0)
    layout.alpha = size_t(a);
  else if (spec.alpha_channel >= 0)
    layout.alpha = size_t(spec.alpha_channel);
  const OIIO::TypeDesc format = spec.format;
  layout.bytes = format == OIIO::TypeUInt8;
  layout.low_precision = !format.is_floating_point() && format.basesize() <= 2;
  return layout;
}

/// Empty, or why the image will not be read.
std::string refusal(const OIIO::ImageSpec& spec, size_t max_pixels) {
  if (spec.width <= 0 || spec.height <= 0 || spec.nchannels <= 0) return "the image has no pixels";
  if (spec.depth > 1 || spec.deep) return "the image is a volume or has deep samples; use a flat one";
  const uint64_t pixels = uint64_t(spec.width) * uint64_t(spec.height);
  // The channels are bounded with the pixels: a header may claim thousands of them.
  if (pixels > max_pixels || pixels * uint64_t(spec.nchannels) > uint64_t(max_pixels) * 64)
    return "the image claims " + std::to_string(spec.width) + " x " + std::to_string(spec.height) + " pixels of " +
           std::to_string(spec.nchannels) + " channels and the limit is " + std::to_string(max_pixels) +
           " pixels; make it smaller";
  return {};
}

}  // namespace

bool ImageReader::fail(const DiagnosticSink& sink, const char* code, const std::string& text) const {
  report(sink, Severity::error, code, path_, text);
  return false;
}

// Finds the format, and for PNG takes the whole file into memory, cleaned.
bool ImageReader::load_bytes(const TextureSource& source, const DiagnosticSink& sink) {
  bytes_ = source.bytes;
  std::array<uint8_t, 16> head{};
  size_t head_size = 0;
  if (bytes_) {
    head_size = std::min(head.size(), bytes_->size());
    std::copy_n(bytes_->begin(), head_size, head.begin());
  } else {
    std::error_code error;
    if (!std::filesystem::exists(path_, error))
      return fail(sink, "texture.missing", "there is no such file; correct the path or put the image there");
    std::ifstream file(path_, std::ios::binary);
    file.read(reinterpret_cast<char*>(head.data()), std::streamsize(head.size()));
    head_size = size_t(std::max<std::streamsize>(file.gcount(), 0));
    if (head_size == 0)
      return fail(sink, "texture.unreadable", "the file is empty, a folder, or may not be read; check its permissions");
  }
  format_ = format_of(std::span(head.data(), head_size), path_);
  if (format_.empty())
    return fail(sink, "texture.format",
                "not an image of a kind that is read (PNG, JPEG, TIFF, EXR, HDR, WebP, BMP, TGA); convert it");
  if (format_ != "png") return true;

  std::vector<uint8_t> whole;
  if (!bytes_) {
    std::ifstream file(path_, std::ios::binary | std::ios::ate);
    whole.resize(size_t(std::max<std::streamoff>(file.tellg(), 0)));
    file.seekg(0);
    file.read(reinterpret_cast<char*>(whole.data()), std::streamsize(whole.size()));
    if (!file) return fail(sink, "texture.unreadable", "the file cannot be read to its end; check the disk");
  }
  std::string damage;
  auto clean = essential_png(bytes_ ? std::span<const uint8_t>(*bytes_) : std::span<const uint8_t>(whole), damage);
  if (clean.empty()) return fail(sink, "texture.damaged", damage + "; export or copy the image again");
  bytes_ = std::make_shared<const std::vector<uint8_t>>(std::move(clean));
  return true;
}

bool ImageReader::open_input(const DiagnosticSink& sink) {
  input_ = OIIO::ImageInput::create(format_);
  if (!input_) {
    static_cast<void>(OIIO::geterror());
    return fail(sink, "texture.format",
                "OpenImageIO was built without a reader for " + format_ + "; convert the image");
  }
  OIIO::ImageSpec request;
  request["oiio:UnassociatedAlpha"] = 1;
  if (bytes_) {
    if (!input_->supports("ioproxy"))
      return fail(sink, "texture.format", format_ + " images cannot be embedded; use PNG or JPEG, or a file");
    proxy_ = std::make_unique<OIIO::Filesystem::IOMemReader>(const_cast<uint8_t*>(bytes_->data()), bytes_->size());
    input_->set_ioproxy(proxy_.get());
  }
  OIIO::ImageSpec spec;
  if (!input_->open(path_, spec, request))
    return fail(sink, "texture.damaged", input_->geterror() + "; export or copy the image again");
  return true;
}

bool ImageReader::open(const TextureSource& source, size_t max_pixels, const DiagnosticSink& sink) {
  path_ = source.path;
  if (!load_bytes(source, sink) || !open_input(sink)) return false;
  const OIIO::ImageSpec& spec = input_->spec();
  if (const std::string reason = refusal(spec, max_pixels); !reason.empty()) return fail(sink, "texture.size", reason);
  layout_ = layout_of(spec);
  return true;
}

int ImageReader::read_rows(int y, std::vector<float>& pixels, const DiagnosticSink& sink) {
  const OIIO::ImageSpec& spec = input_->spec();
  const bool tiled = spec.tile_width > 0;
  const size_t row_bytes = size_t(spec.width) * layout_.channels * sizeof(float);
  const int strip = int(std::clamp(kStripBytes / std::max(row_bytes, size_t(1)), size_t(1), size_t(kRowsAtOnce)));
  const int rows = std::min(tiled ? spec.tile_height : strip, spec.height - y);
  pixels.resize(size_t(rows) * size_t(spec.width) * layout_.channels);
  const int begin = spec.y + y, end = begin + rows;
  const bool good =
      tiled ? input_->read_tiles(0, 0, spec.x, spec.x + spec.width, begin, end, spec.z, spec.z + 1, 0, spec.nchannels,
                                 OIIO::TypeFloat, pixels.data())
            : input_->read_scanlines(0, 0, begin, end, spec.z, 0, spec.nchannels, OIIO::TypeFloat, pixels.data());
  // Some readers fill up a file that is cut off and mention it only in the error text.
  if (good && !input_->has_error()) return rows;
  const std::string reason = input_->geterror();
  fail(sink, "texture.damaged",
       (reason.empty() ? "the pixels cannot be decoded" : reason) + "; export or copy the image again");
  return 0;
}

}  // namespace alabaster
