#include "core/texture/image_reader.h"

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <span>
#include <string_view>

#include "core/texture/environment_image.h"
#include "core/texture/exr_layers.h"
#include "core/texture/exr_pieces.h"
#include "core/texture/hdr_header.h"
#include "core/texture/image_streams.h"

namespace alabaster {
namespace {

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
    {"#?", "hdr"},  // and the name of the program that wrote it
    {"RIFF", "webp"},
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

const char* opening_code(InputFile::Fault fault) {
  switch (fault) {
    case InputFile::Fault::missing:
      return "texture.missing";
    case InputFile::Fault::outside:
      return "texture.outside";
    default:
      return "texture.unreadable";
  }
}

/// Empty, or why the image will not be read.
std::string refusal(const ImageLayout& image, size_t max_pixels) {
  if (image.width <= 0 || image.height <= 0 || image.channels == 0) return "the image has no pixels";
  if (!image.flat) return "the image is a volume or has deep samples; use a flat one";
  const uint64_t pixels = uint64_t(image.width) * uint64_t(image.height);
  // The channels are bounded with the pixels: a header may claim thousands of them.
  if (pixels > max_pixels || pixels * image.channels > uint64_t(max_pixels) * 64)
    return "the image claims " + std::to_string(image.width) + " x " + std::to_string(image.height) + " pixels of " +
           std::to_string(image.channels) + " channels and the limit is " + std::to_string(max_pixels) +
           " pixels; make it smaller";
  return {};
}

}  // namespace

bool ImageReader::fail(const DiagnosticSink& sink, const char* code, const std::string& text) const {
  report(sink, Severity::error, code, path_, text);
  return false;
}

FileBytes ImageReader::file_bytes() const {
  FileBytes bytes;
  if (bytes_) {
    bytes.size = bytes_->size();
    bytes.read = [this](uint64_t offset, void* out, size_t count) {
      std::memcpy(out, bytes_->data() + offset, count);
      return true;
    };
  } else {
    bytes.size = file_->size();
    bytes.read = [this](uint64_t offset, void* out, size_t count) { return file_->read(offset, out, count); };
  }
  return bytes;
}

bool ImageReader::check_exr(const TextureSource& source, size_t max_pixels, const DiagnosticSink& sink) {
  const FileBytes bytes = file_bytes();
  ImageFault fault;
  const auto refuse = [&] { return fail(sink, fault.code.c_str(), fault.text); };
  std::vector<ExrPart> parts;
  ExrLayer layer;
  if (!check_exr_header(bytes, max_pixels, &fault, &parts)) return refuse();
  if (!find_exr_layer(parts, source.layer, &layer, &fault)) return refuse();
  chosen_.part = layer.part, chosen_.channels = layer.channels;
  std::string missing;
  const ImageFunctions* images = image_functions(&missing);
  if (!images) return fail(sink, "images.library", missing);
  if (parts.empty()) return true;  // OpenEXR says what is wrong with it
  const ExrPart& part = parts[layer.part];
  is_cube_ = part.environment == ExrPart::Environment::cube && source.is_environment;
  // An environment is in the data window.
  chosen_.window = part.environment == ExrPart::Environment::none ? part.display : part.window;
  chromaticities_ = part.chromaticities;
  return check_exr_pieces(bytes, part, *images, &fault) || refuse();
}

bool ImageReader::check_hdr(const DiagnosticSink& sink) {
  HdrHeader header;
  ImageFault fault;
  if (!read_hdr_header(file_bytes(), &header, &fault)) return fail(sink, fault.code.c_str(), fault.text);
  scale_ = header.scale, chromaticities_ = header.chromaticities;
  chosen_.orientation = header.orientation;
  return true;
}

// Finds the format, and checks the file as far as OpenImageIO does not. `limits.memory` counts what is kept of it.
bool ImageReader::load_bytes(const TextureSource& source, const ImageLimits& limits, const DiagnosticSink& sink) {
  if (!source.fault.empty()) return fail(sink, "texture.unusable", source.fault);
  bytes_ = source.bytes;
  std::array<uint8_t, 64> head{};
  size_t head_size = 0;
  if (bytes_) {
    head_size = std::min(head.size(), bytes_->size());
    std::copy_n(bytes_->begin(), head_size, head.begin());
  } else {
    file_.emplace(path_, source.within);
    if (!*file_) return fail(sink, opening_code(file_->fault()), file_->reason());
    head_size = size_t(std::min<uint64_t>(head.size(), file_->size()));
    if (head_size == 0 || !file_->read(0, head.data(), head_size))
      return fail(sink, "texture.unreadable", "the file is empty or cannot be read; export or copy the image again");
  }
  format_ = format_of(std::span(head.data(), head_size), path_);
  const std::string_view start(reinterpret_cast<const char*>(head.data()), 4);
  if (start == std::string_view("II+\0", 4) || start == std::string_view("MM\0+", 4))
    return fail(sink, "texture.format", "it is a BigTIFF, which is not read; export it as TIFF or EXR");
  if (format_.empty())
    return fail(sink, "texture.format",
                "not an image of a kind that is read (PNG, JPEG, TIFF, EXR, HDR, WebP, TGA); convert it");
  if (format_ == "openexr") return check_exr(source, limits.max_pixels, sink);
  if (!source.layer.empty())
    return fail(sink, "texture.layer", "only an EXR has layers; leave out the texture's 'layer'");
  if (format_ == "hdr") return check_hdr(sink);
  return clean_bytes(limits, sink);
}

bool ImageReader::clean_bytes(const ImageLimits& limits, const DiagnosticSink& sink) {
  std::vector<uint8_t> read;
  const auto hold = [&](size_t bytes) {
    if (limits.memory) limits.memory->resize(bytes, "an image file of " + std::to_string(bytes) + " bytes");
  };
  constexpr uint64_t kLargestFile = uint64_t(1) << 32;  // a TIFF's offsets have 32 bits
  if (!bytes_ && file_->size() >= kLargestFile)
    return fail(sink, "texture.size", "the file has 4 GiB or more; export the image smaller, or as EXR");
  if (!bytes_) {
    hold(size_t(file_->size()));
    if (!file_->read(&read))
      return fail(sink, "texture.unreadable", "the file cannot be read to its end; check the disk");
  }
  const std::span<const uint8_t> whole = bytes_ ? std::span(*bytes_) : std::span<const uint8_t>(read);
  hold(read.size() + whole.size());
  std::string damage;
  JpegFrame frame;
  auto clean = format_ == "png"    ? essential_png(whole, damage, &chosen_.orientation)
               : format_ == "jpeg" ? essential_jpeg(whole, frame, damage)
               : format_ == "webp" ? essential_webp(whole, damage, &chosen_.orientation)
               : format_ == "tiff" ? essential_tiff(whole, damage)
                                   : essential_tga(whole, damage);
  if (clean.empty()) return fail(sink, "texture.damaged", damage + "; export or copy the image again");
  // libjpeg decodes all scans as soon as the file is opened.
  if (format_ == "jpeg") {
    ImageLayout claim;
    claim.width = int(frame.width), claim.height = int(frame.height), claim.channels = frame.components;
    if (const std::string reason = refusal(claim, limits.max_pixels); !reason.empty())
      return fail(sink, "texture.size", reason);
  }
  if (format_ == "jpeg") chosen_.orientation = frame.orientation;
  if (format_ == "tiff") chosen_.orientation = exif_orientation(whole);
  hold(clean.size() + frame.decoder_bytes);
  bytes_ = std::make_shared<const std::vector<uint8_t>>(std::move(clean));
  return true;
}

bool ImageReader::open_input(const DiagnosticSink& sink) {
  std::string missing;
  const ImageFunctions* images = image_functions(&missing);
  if (!images) return fail(sink, "images.library", missing);
  ImageFault fault;
  ImageSource source = chosen_;
  source.path = path_, source.format = format_;
  if (bytes_)
    source.bytes = *bytes_;
  else
    source.descriptor = file_->descriptor();
  input_ = images->open(source, fault);
  if (input_ && is_cube_) input_ = as_lat_long(std::move(input_), &fault);
  return input_ || fail(sink, fault.code.c_str(), fault.text);
}

bool ImageReader::open(const TextureSource& source, const ImageLimits& limits, const DiagnosticSink& sink) {
  path_ = source.path;
  if (!load_bytes(source, limits, sink) || !open_input(sink)) return false;
  const std::string reason = refusal(layout(), limits.max_pixels);
  return reason.empty() || fail(sink, "texture.size", reason);
}

int ImageReader::read_rows(int y, ImageRows& rows, const DiagnosticSink& sink) {
  std::string fault;
  const int count = input_->read_rows(y, rows, fault);
  if (count == 0) fail(sink, "texture.damaged", fault + "; export or copy the image again");
  return count;
}

}  // namespace alabaster
