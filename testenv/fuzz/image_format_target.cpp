// Image files of a chosen format: a header of plausible and of odd numbers, and texels. Other targets edit whole files,
// and seldom change two numbers that must fit each other.
#include <array>
#include <cmath>

#include "core/texture/texture.h"
#include "testenv/fuzz/small_render.h"
#include "testenv/fuzz/structured_input.h"

namespace alabaster::fuzz {
namespace {

using File = std::string;

void add_number(File& file, uint64_t value, int size, bool big_endian = false) {
  for (int i = 0; i < size; ++i) file.push_back(char(value >> (8 * (big_endian ? size - 1 - i : i))));
}

/// One of these, or now and then any number.
uint32_t one_of(StructuredInput& in, std::initializer_list<uint32_t> list) {
  const int choice = in.choice(24);
  if (choice == 23) return in.raw<uint32_t>();
  return list.begin()[size_t(choice) % list.size()];
}

void add_rest(File& file, StructuredInput& in) {
  file += in.text(size_t(1) << 20);
}

File tga(StructuredInput& in) {
  File file;
  add_number(file, one_of(in, {0, 0, 3}), 1);
  add_number(file, one_of(in, {0, 1}), 1);
  add_number(file, one_of(in, {1, 2, 3, 9, 10, 11}), 1);
  add_number(file, one_of(in, {0, 0, 0, 1, 9, 65535}), 2);
  add_number(file, one_of(in, {0, 2, 4, 16, 256, 65535}), 2);
  add_number(file, one_of(in, {15, 16, 24, 32}), 1);
  add_number(file, in.raw<uint32_t>(), 4);
  for (int i = 0; i < 2; ++i) add_number(file, one_of(in, {1, 2, 5, 16, 33, 128}), 2);
  add_number(file, one_of(in, {8, 15, 16, 24, 32}), 1);
  add_number(file, in.byte(), 1);
  const bool has_footer = in.choice(8) == 0;
  add_rest(file, in);
  if (has_footer) {
    add_number(file, file.size() / 2, 4), add_number(file, 0, 4);
    file += std::string_view("TRUEVISION-XFILE.\0", 18);
  }
  return file;
}

/// A zlib stream that is not compressed.
File stored(const std::string& data) {
  File file = {0x78, 0x01};
  uint32_t a = 1, b = 0;
  constexpr size_t kMost = 65535;
  for (size_t at = 0;; at += kMost) {
    const size_t size = std::min(kMost, data.size() - at);
    const bool is_last = at + size == data.size();
    file.push_back(is_last);
    add_number(file, size, 2), add_number(file, ~size, 2);
    for (const char c : data.substr(at, size)) file.push_back(c), a = (a + uint8_t(c)) % 65521, b = (b + a) % 65521;
    if (is_last) break;
  }
  add_number(file, b << 16 | a, 4, true);
  return file;
}

File tiff(StructuredInput& in) {
  const bool big = in.flag();
  std::vector<std::array<uint32_t, 4>> entries;
  const auto number = [&](uint32_t tag, uint32_t value) { entries.push_back({tag, 4, 1, value}); };
  const int count = 8 + in.choice(12);
  constexpr uint32_t kAfter = 8 + 2 + 12 * 24 + 4;
  const uint32_t samples = one_of(in, {1, 2, 3, 4, 5}), bits = one_of(in, {1, 2, 4, 8, 8, 8, 12, 16, 24, 32, 64});
  const uint32_t width = one_of(in, {1, 2, 7, 16, 33}), height = one_of(in, {1, 2, 7, 16, 33});
  const uint32_t compression = one_of(in, {1, 1, 1, 2, 3, 4, 5, 6, 7, 8, 32773, 32946, 34676});
  number(256, width), number(257, height), number(258, bits), number(259, compression);
  number(262, one_of(in, {0, 1, 2, 3, 5, 6, 8, 9, 32844, 32845})), number(277, samples);
  const bool tiled = in.choice(4) == 0;
  if (tiled) {
    number(322, one_of(in, {16, 32, 48})), number(323, one_of(in, {16, 32, 48}));
  } else if (in.choice(8) != 0) {
    number(278, one_of(in, {1, 2, 8, 33, UINT32_MAX, 0}));
  }
  for (int i = 0; i < count - 8; ++i) {
    constexpr std::array<uint32_t, 16> kTags = {284, 317, 338, 339,   332,   266,   274,   320,
                                                347, 530, 700, 33723, 34665, 34675, 32997, 32998};
    const uint32_t tag = kTags[size_t(in.choice(16))];
    if (tag == 320)
      entries.push_back({tag, 3, 3u << std::min(bits, 16u), kAfter});
    else if (tag >= 347)
      entries.push_back({tag, uint32_t(1 + in.choice(13)), one_of(in, {1, 2, 4, 8, 40}), kAfter + in.byte()});
    else
      number(tag, one_of(in, {1, 2, 3, 0}));
  }
  const std::string pixels = in.text(size_t(1) << 20);
  const File data = compression == 8 || compression == 32946 ? stored(pixels) : pixels;
  number(tiled ? 324 : 273, kAfter), number(tiled ? 325 : 279, uint32_t(data.size()));
  File file;
  file += big ? std::string_view("MM\0*", 4) : std::string_view("II*\0", 4);
  add_number(file, 8, 4, big), add_number(file, entries.size(), 2, big);
  for (const auto& [tag, type, length, value] : entries) {
    add_number(file, tag, 2, big), add_number(file, type, 2, big);
    add_number(file, length, 4, big), add_number(file, value, 4, big);
  }
  file.resize(kAfter, 0);
  file.insert(file.end(), data.begin(), data.end());
  return file;
}

void add_chunk(File& file, const char* type, const File& data) {
  add_number(file, data.size(), 4, true);
  const size_t begin = file.size();
  file.append(type, 4);
  file.insert(file.end(), data.begin(), data.end());
  uint32_t c = ~0u;
  for (size_t i = begin; i < file.size(); ++i) {
    c ^= uint8_t(file[i]);
    for (int k = 0; k < 8; ++k) c = (c >> 1) ^ (0xedb88320u & (0u - (c & 1)));
  }
  add_number(file, ~c, 4, true);
}

File png(StructuredInput& in) {
  File file, header;
  file += "\x89PNG\r\n\x1a\n";
  for (int i = 0; i < 2; ++i) add_number(header, one_of(in, {1, 2, 7, 16, 33}), 4, true);
  for (const auto& list : {std::initializer_list<uint32_t>{1, 2, 4, 8, 16}, {0, 2, 3, 4, 6}, {0}, {0}, {0, 0, 1}})
    header.push_back(char(one_of(in, list)));
  add_chunk(file, "IHDR", header);
  const auto bytes = [&](size_t most) {
    const std::string text = in.text(in.byte() % (most + 1));
    return text;
  };
  if (in.flag()) add_chunk(file, "PLTE", bytes(255));
  if (in.flag()) add_chunk(file, "tRNS", bytes(255));
  if (in.choice(8) == 0) add_chunk(file, "gAMA", bytes(8));
  add_chunk(file, "IDAT", stored(in.text(size_t(1) << 20)));
  add_chunk(file, "IEND", {});
  return file;
}

File hdr(StructuredInput& in) {
  constexpr const char* kSizes[] = {"-Y %d +X %d", "+Y %d +X %d", "-X %d +Y %d", "+X %d -Y %d"};
  char size[64];
  const int format = in.choice(4), height = int(one_of(in, {1, 2, 8})), width = int(one_of(in, {1, 7, 8, 33, 300}));
  const int length = std::snprintf(size, sizeof size, kSizes[format], height, width);
  File file;
  file += in.flag() ? "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\nGAMMA=1\n\n" : "#?RGBE\nFORMAT=32-bit_rle_rgbe\n\n";
  file.append(size, size_t(length));
  file.push_back('\n');
  if (in.flag()) add_number(file, 2u | 2u << 8 | uint32_t(width >> 8 & 0xff) << 16 | uint32_t(width & 0xff) << 24, 4);
  add_rest(file, in);
  return file;
}

/// Chunks of any kind around the picture that follows.
File webp(StructuredInput& in) {
  File body;
  body += "WEBP";
  const auto add = [&](const char* type, const File& payload, uint32_t claimed) {
    body.append(type, 4);
    add_number(body, claimed, 4);
    body.insert(body.end(), payload.begin(), payload.end());
    if (body.size() % 2 != 0) body.push_back(0);
  };
  const auto add_whole = [&](const char* type, const File& payload) { add(type, payload, uint32_t(payload.size())); };
  if (in.flag()) {
    File header;
    add_number(header, in.flag() ? in.byte() : 0u, 4);
    for (int i = 0; i < 2; ++i) add_number(header, one_of(in, {0, 1, 2, 15}), 3);
    add_whole("VP8X", header);
  }
  for (int i = in.choice(4); i > 0; --i) {
    constexpr const char* kTypes[] = {"EXIF", "XMP ", "ICCP", "ALPH", "ANIM"};
    const std::string text = in.text(in.byte() % 32);
    add_whole(kTypes[in.choice(5)], text);
  }
  const char* const type = in.flag() ? "VP8L" : "VP8 ";
  const bool animated = in.choice(4) == 0;
  File frame;
  if (animated) {
    for (int i = 0; i < 5; ++i) add_number(frame, one_of(in, {0, 0, 1, 15}), 3);
    frame.push_back(0);
  }
  const std::string picture = in.text(size_t(1) << 20);
  if (animated) {
    frame.append(type, 4), add_number(frame, picture.size(), 4), frame += picture;
    add_whole("ANMF", frame);
  } else {
    add_whole(type, picture);
  }
  File file;
  file += "RIFF", add_number(file, body.size(), 4);
  file.insert(file.end(), body.begin(), body.end());
  return file;
}

/// The bytes as they are: kept inputs bring whole JPEGs and EXRs.
File whole(StructuredInput& in) {
  File file;
  add_rest(file, in);
  return file;
}

struct Format {
  const char* name;
  File (*make)(StructuredInput& in);
};
constexpr Format kFormats[] = {{"x.tga", tga},   {"x.tif", tiff},  {"x.png", png},  {"x.hdr", hdr},
                               {"x.webp", webp}, {"x.jpg", whole}, {"x.exr", whole}};

}  // namespace

void run_image_format(Bytes input) {
  StructuredInput in(input);
  const Format& format = kFormats[in.choice(int(std::size(kFormats)))];
  TextureSource source;
  source.path = format.name;
  const File file = format.make(in);
  source.bytes = std::make_shared<const std::vector<uint8_t>>(file.begin(), file.end());
  source.color_space = "raw";
  static const auto colors = ColorConfig::load("built-in", {});
  int errors = 0;
  const DiagnosticSink sink = [&](const Diagnostic& d) { errors += d.severity == Severity::error; };
  const auto texture = load_texture(source, *colors, sink, {.max_pixels = size_t(1) << 16});
  if ((texture == nullptr) != (errors > 0)) broken("an image's texture and its reports contradict each other");
  if (!texture) return;
  for (int y = 0; y < texture->height(); ++y)
    for (int x = 0; x < texture->width(); ++x)
      if (!is_finite(texture->texel(x, y))) broken("a texel is not finite");
}

}  // namespace alabaster::fuzz
