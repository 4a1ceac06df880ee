#include <zlib.h>

#include <algorithm>

#include "core/images/format_limits.h"
#include "core/images/open_image_io/functions.h"

namespace alabaster {
namespace {

/// Bytes of the rows that are encoded together: enough for every thread, and little beside the frame. OpenImageIO hands
/// no more than this to OpenEXR's threads at once.
constexpr size_t kStripBytes = size_t(16) << 20;
constexpr int kPngNoFilter = 8;  // libpng's PNG_FILTER_NONE

/// Sets an attribute in EXR's own type.
struct AttributeSetter {
  OIIO::ImageSpec& spec;
  const std::string& name;

  void operator()(int v) const { spec.attribute(name, v); }
  void operator()(float v) const { spec.attribute(name, v); }
  void operator()(double v) const { spec.attribute(name, OIIO::TypeDesc(OIIO::TypeDesc::DOUBLE), &v); }
  void operator()(const std::string& v) const { spec.attribute(name, v); }
  void operator()(const std::array<float, 2>& v) const { vector(OIIO::TypeDesc::FLOAT, OIIO::TypeDesc::VEC2, &v); }
  void operator()(const std::array<float, 3>& v) const { vector(OIIO::TypeDesc::FLOAT, OIIO::TypeDesc::VEC3, &v); }
  // OpenEXR has types of its own for these two.
  void operator()(const std::array<int, 2>& v) const {
    if (name == "framesPerSecond") return spec.attribute(name, OIIO::TypeRational, v.data());
    if (name == "timeCode") return spec.attribute("smpte:TimeCode", OIIO::TypeTimeCode, v.data());
    vector(OIIO::TypeDesc::INT, OIIO::TypeDesc::VEC2, &v);
  }
  void operator()(const std::array<int, 3>& v) const { vector(OIIO::TypeDesc::INT, OIIO::TypeDesc::VEC3, &v); }
  // OpenEXR's own attributes are of floats.
  void operator()(const std::array<double, 16>& v) const {
    if (name == "worldToCamera" || name == "worldToNDC") {
      std::array<float, 16> floats{};
      std::transform(v.begin(), v.end(), floats.begin(), [](double number) { return static_cast<float>(number); });
      return vector(OIIO::TypeDesc::FLOAT, OIIO::TypeDesc::MATRIX44, &floats);
    }
    vector(OIIO::TypeDesc::DOUBLE, OIIO::TypeDesc::MATRIX44, &v);
  }
  void operator()(const std::array<float, 8>& v) const {
    spec.attribute(name, OIIO::TypeDesc(OIIO::TypeDesc::FLOAT, 8), v.data());
  }
  void vector(OIIO::TypeDesc::BASETYPE base, OIIO::TypeDesc::AGGREGATE aggregate, const void* data) const {
    spec.attribute(name, OIIO::TypeDesc(base, aggregate), data);
  }
};

// A line for each attribute. A value's further lines are indented, so that they are no attributes of their own.
void describe_in_words(OIIO::ImageSpec& spec) {
  const auto is_free = [](const OIIO::ParamValue& a) { return a.name() != "Software" && a.name() != "DateTime"; };
  std::string description;
  for (const OIIO::ParamValue& attribute : spec.extra_attribs)
    if (is_free(attribute))
      description +=
          OIIO::Strutil::replace(attribute.name().string() + ": " + attribute.get_string(), "\n", "\n  ", true) + "\n";
  std::erase_if(spec.extra_attribs, is_free);
  spec.attribute("ImageDescription", description);
}

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

void set_compression(const ImageDescription& image, OIIO::ImageSpec& spec) {
  switch (image.kind) {
    case FileKind::exr:
      spec.attribute("compression", image.fast ? "none" : image.compression);
      break;
    case FileKind::tiff:
      spec.attribute("compression", image.fast ? "none" : "zip");
      break;
    case FileKind::jpeg:
      spec.attribute("compression", "jpeg:95");
      spec.attribute("jpeg:subsampling", "4:4:4");
      break;
    case FileKind::png:
      if (!image.fast) break;
      spec.attribute("png:compressionLevel", 0);
      spec.attribute("png:filter", kPngNoFilter);
      break;
  }
}

/// PNG, TIFF and JPEG hold the data window alone, because viewers disagree about offsets.
OIIO::ImageSpec make_spec(const ImageDescription& image) {
  OIIO::ImageSpec spec(image.width, image.height, int(image.channels.size()), type_of(image.channels[0].store));
  spec.channelnames.clear();
  for (size_t i = 0; i < image.channels.size(); ++i) {
    const ImageChannel& channel = image.channels[i];
    spec.channelnames.push_back(channel.name);
    spec.channelformats.push_back(type_of(channel.store));
    if (channel.name == "A" && image.channels.size() > 1) spec.alpha_channel = int(i);
  }
  for (const ImageAttribute& attribute : image.attributes)
    std::visit(AttributeSetter{spec, attribute.name}, attribute.value);
  if (image.kind != FileKind::exr) describe_in_words(spec);
  spec.attribute("PixelAspectRatio", image.pixel_aspect);
  spec.attribute("oiio:UnassociatedAlpha", 1);  // PNG and TIFF get straight alpha; EXR ignores this
  if (image.kind == FileKind::exr) {
    spec.x = image.origin[0], spec.y = image.origin[1];
    spec.full_x = image.display[0], spec.full_y = image.display[1];
    spec.full_width = image.display[2], spec.full_height = image.display[3];
  }
  if (image.kind == FileKind::exr && image.tiles > 0) {
    spec.tile_width = spec.tile_height = image.tiles;
    spec.attribute("openexr:lineOrder", "increasingY");  // else the order in which threads end
  }
  set_compression(image, spec);
  return spec;
}

/// OpenImageIO does not write cICP: it goes between IHDR and what follows.
void tag_png(const CodePoints& codes, std::vector<unsigned char>& file) {
  constexpr size_t kHeader = 33;  // the signature and IHDR
  std::vector<unsigned char> chunk{0, 0, 0, 4, 'c', 'I', 'C', 'P', codes.primaries, codes.transfer, 0, 1};
  const auto check = uint32_t(crc32(0, chunk.data() + 4, uInt(chunk.size() - 4)));
  for (int shift = 24; shift >= 0; shift -= 8) chunk.push_back(static_cast<unsigned char>(check >> shift));
  file.insert(file.begin() + kHeader, chunk.begin(), chunk.end());
}

}  // namespace

std::string encode_image(const ImageDescription& image, const RowSource& rows, std::vector<unsigned char>& file) {
  if (image.width > most_pixels(image.kind) || image.height > most_pixels(image.kind))
    return "it has more pixels than the format holds";
  if (image.kind == FileKind::exr)
    if (std::string fault = openexr_fault(); !fault.empty()) return fault;
  constexpr const char* kNames[] = {"x.exr", "x.png", "x.tif", "x.jpg"};
  const char* name = kNames[int(image.kind)];
  const OIIO::ImageSpec spec = make_spec(image);
  size_t text = 0;
  for (const OIIO::ParamValue& attribute : spec.extra_attribs)
    if (attribute.type() == OIIO::TypeString) text += attribute.get_string().size();
  if (image.kind == FileKind::jpeg && text > kMostJpegText + 1000) return "its attributes are longer than a JPEG holds";
  // Room that is not used costs nothing; growing would copy the file.
  file.reserve(spec.image_bytes(true) + spec.image_bytes(true) / 64);
  OIIO::Filesystem::IOVecOutput memory(file);
  const auto output = OIIO::ImageOutput::create(name);
  if (!output) return "OpenImageIO cannot write this format: " + failure_text(OIIO::geterror());
  output->set_ioproxy(&memory);
  if (!output->open(name, spec)) return failure_text(output->geterror());
  int rows_at_once = int(std::clamp(kStripBytes / rows.row_bytes(), size_t(1), size_t(spec.height)));
  if (spec.tile_height > 0) rows_at_once = std::max(rows_at_once / spec.tile_height, 1) * spec.tile_height;
  std::vector<uint8_t> strip(rows.row_bytes() * size_t(std::min(rows_at_once, spec.height))), tile;
  for (int y = 0; y < spec.height; y += rows_at_once) {
    const int end = std::min(y + rows_at_once, spec.height);
    rows.encode(y, end, strip.data());
    const OIIO::TypeDesc type = image.kind == FileKind::exr ? OIIO::TypeUnknown : spec.format;
    bool good = true;
    if (spec.tile_height == 0) good = output->write_scanlines(spec.y + y, spec.y + end, 0, type, strip.data());
    // One tile at a time, because OpenImageIO copies what it is given several times.
    for (int top = y; spec.tile_height > 0 && top < end; top += spec.tile_height)
      for (int x = 0; good && x < spec.width; x += spec.tile_width) {
        const int right = std::min(x + spec.tile_width, spec.width), bottom = std::min(top + spec.tile_height, end);
        const size_t pixel = rows.row_bytes() / size_t(spec.width);
        tile.clear();
        for (int row = top; row < bottom; ++row) {
          const uint8_t* const from = strip.data() + size_t(row - y) * rows.row_bytes();
          tile.insert(tile.end(), from + size_t(x) * pixel, from + size_t(right) * pixel);
        }
        good = output->write_tiles(spec.x + x, spec.x + right, spec.y + top, spec.y + bottom, 0, 1, type, tile.data());
      }
    if (!good) return failure_text(output->geterror());
  }
  if (!output->close()) return failure_text(output->geterror());
  if (image.kind == FileKind::png && image.encoding) tag_png(*image.encoding, file);
  return {};
}

}  // namespace alabaster
