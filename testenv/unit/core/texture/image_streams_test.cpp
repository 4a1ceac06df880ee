// Image files reach OpenImageIO without the parts that make it read beyond a buffer.
#include <map>

#include "core/texture/texel_store.h"
#include "testenv/support/texture_file.h"

namespace alabaster {
namespace {

using testing::kQuad;
using testing::TextureFile;
using Bytes = std::vector<uint8_t>;

void add(Bytes& bytes, const Bytes& more) {
  bytes.insert(bytes.end(), more.begin(), more.end());
}
void add_number(Bytes& bytes, uint32_t value, int size) {
  for (int i = 0; i < size; ++i) bytes.push_back(uint8_t(value >> (8 * i)));
}

class ImageStreams : public TextureFile {
 protected:
  /// The error, or nothing if the image is read.
  std::string fault_of(const std::string& name, const Bytes& bytes) {
    texture_ = load(spit(name, bytes), "raw");
    EXPECT_NE(texture_ == nullptr, reports_.all.empty()) << name;
    return texture_ ? "" : reports_.text();
  }
  std::shared_ptr<const Texture> texture_;
};

// TGA ----------------------------------------------------------------------------------------------
struct Tga {
  uint8_t kind = 1, entry = 24, bits = 8;
  uint16_t first = 0, length = 2;
  uint8_t has_palette = 1;
  /// Four by one texels.
  Bytes file(const Bytes& texels) const {
    Bytes bytes = {3, has_palette, kind};
    add_number(bytes, first, 2), add_number(bytes, length, 2);
    add(bytes, {entry, 0, 0, 0, 0, 4, 0, 1, 0, bits, 0, 'i', 'd', '!'});
    for (int i = 0; i < length * ((entry + 7) / 8); ++i) bytes.push_back(uint8_t(20 + i));
    add(bytes, texels);
    return bytes;
  }
};

TEST_F(ImageStreams, ATgaOfTexelsWithoutBitsIsRefused) {
  for (const uint8_t kind : Bytes{1, 3, 9, 11})
    EXPECT_NE(fault_of("a.tga", Tga{.kind = kind, .bits = 0}.file({})).find("no TGA of a kind that is read"),
              std::string::npos);
  EXPECT_NE(fault_of("a.tga", Tga{.entry = 0}.file({0, 0, 0, 0})).find("no TGA"), std::string::npos);
}

TEST_F(ImageStreams, EveryIndexOfATgaIsInItsPalette) {
  const std::string beyond = "index is not in its palette";
  for (const uint8_t entry : Bytes{15, 16, 24, 32}) {
    const Tga plain{.entry = entry}, runs{.kind = 9, .entry = entry};
    const Tga wide{.entry = entry, .bits = 16}, wide_runs{.kind = 9, .entry = entry, .bits = 16};
    EXPECT_EQ(fault_of("a.tga", plain.file({0, 1, 0, 1})), "");
    EXPECT_EQ(fault_of("a.tga", runs.file({0x82, 1, 0x00, 0})), "");
    EXPECT_EQ(fault_of("a.tga", wide.file({0, 0, 1, 0, 0, 0, 1, 0})), "");
    EXPECT_EQ(fault_of("a.tga", wide_runs.file({0x83, 1, 0})), "");
    for (const auto& [tga, texels] : std::initializer_list<std::pair<Tga, Bytes>>{{plain, {0, 1, 0, 2}},
                                                                                  {plain, {255, 0, 0, 0}},
                                                                                  {runs, {0x82, 2, 0x00, 0}},
                                                                                  {runs, {0x82, 1, 0x00, 200}},
                                                                                  {runs, {0x03, 0, 0, 1, 2}},
                                                                                  {wide, {0, 0, 1, 0, 0, 0, 0, 1}},
                                                                                  {wide_runs, {0x83, 0xff, 0xff}}})
      EXPECT_NE(fault_of("a.tga", tga.file(texels)).find(beyond), std::string::npos) << int(entry);
  }
  EXPECT_NE(fault_of("a.tga", Tga{.length = 0}.file({0, 0, 0, 0})).find(beyond), std::string::npos);
}

// Indices count from the palette's first; indices before it have no colour.
TEST_F(ImageStreams, APaletteOfATgaMayBeginAtAnyIndex) {
  const Tga from_seven{.kind = 9, .first = 7};
  ASSERT_EQ(fault_of("a.tga", from_seven.file({0x82, 8, 0x00, 7})), "");
  EXPECT_NEAR(texture_->texel(0, 0).r, 25 / 255.0f, 1e-3f);
  EXPECT_NEAR(texture_->texel(3, 0).b, 20 / 255.0f, 1e-3f);
  for (const uint8_t index : Bytes{0, 1, 6, 9})
    EXPECT_NE(fault_of("a.tga", from_seven.file({0x83, index})).find("not in its palette"), std::string::npos);
  EXPECT_NE(fault_of("a.tga", Tga{.bits = 16, .first = 65535}.file({0, 0, 0, 0, 0, 0, 0, 0})).find("65535 entries"),
            std::string::npos);
}

// CVE-2026-43996: an index before the palette's first is -4 bytes, which no check of OpenImageIO refuses.
TEST_F(ImageStreams, AnIndexBeforeAPaletteOfFourBytesIsRefused) {
  for (const uint16_t first : {uint16_t(1), uint16_t(5), uint16_t(200)}) {
    const auto low = uint8_t(first - 1);
    const Tga plain{.entry = 32, .first = first}, runs{.kind = 9, .entry = 32, .first = first};
    const Tga wide{.entry = 32, .bits = 16, .first = first};
    for (const Bytes& file : {plain.file({uint8_t(first), low, uint8_t(first), uint8_t(first)}), runs.file({0x83, low}),
                              wide.file({low, 0, low, 0, low, 0, low, 0})})
      EXPECT_NE(fault_of("a.tga", file).find("not in its palette"), std::string::npos) << first;
    EXPECT_EQ(fault_of("a.tga", runs.file({0x83, uint8_t(first)})), "");
  }
}

TEST_F(ImageStreams, HeadersOfTgasFitTheirTexels) {
  for (const Tga& tga : {Tga{.kind = 1, .has_palette = 0}, Tga{.kind = 2, .bits = 8}, Tga{.kind = 3, .bits = 24},
                         Tga{.kind = 1, .bits = 32}, Tga{.kind = 0}, Tga{.kind = 4}, Tga{.entry = 8}, Tga{.entry = 0}})
    EXPECT_NE(fault_of("a.tga", tga.file(Bytes(64))).find("of a kind that is read"), std::string::npos)
        << int(tga.kind);
  EXPECT_EQ(fault_of("a.tga", Tga{.kind = 2, .bits = 24}.file(Bytes(12, 255))), "") << "a palette for nothing";
  EXPECT_EQ(texture_->texel(3, 0), Rgb(1.0f));
  EXPECT_NE(fault_of("a.tga", Tga{}.file({0, 1, 0})).find("cut off"), std::string::npos);
  EXPECT_NE(fault_of("a.tga", Tga{.kind = 9}.file({0x00, 1, 0x82})).find("cut off"), std::string::npos);
}

// WebP ---------------------------------------------------------------------------------------------
Bytes chunk(const char* type, const Bytes& payload) {
  Bytes bytes(type, type + 4);
  add_number(bytes, uint32_t(payload.size()), 4);
  add(bytes, payload);
  if (bytes.size() % 2 != 0) bytes.push_back(0);
  return bytes;
}
Bytes riff(const std::vector<Bytes>& chunks) {
  Bytes body = {'W', 'E', 'B', 'P'};
  for (const Bytes& part : chunks) add(body, part);
  return chunk("RIFF", body);
}
/// VP8X of a picture.
Bytes extended(uint8_t flags, uint32_t width, uint32_t height) {
  Bytes payload = {flags, 0, 0, 0};
  add_number(payload, width - 1, 3), add_number(payload, height - 1, 3);
  return chunk("VP8X", payload);
}
/// ANMF of a frame of two by two pixels.
Bytes frame(uint32_t x, uint32_t y, const Bytes& picture) {
  Bytes payload;
  for (const uint32_t value : {x, y, 1u, 1u, 0u}) add_number(payload, value, 3);
  payload.push_back(0);
  add(payload, picture);
  return chunk("ANMF", payload);
}

class WebpStreams : public ImageStreams {
 protected:
  /// The chunk of the pixels of an image of two by two.
  Bytes picture() {
    const Bytes file = slurp(write("a.webp", 2, 2, 3, OIIO::TypeUInt8, kQuad));
    for (size_t at = 12; at + 8 < file.size();) {
      const size_t size = 8 + file[at + 4] + 256u * file[at + 5], whole = size + size % 2;
      if (file[at + 3] == ' ' || file[at + 3] == 'L') return {file.begin() + long(at), file.begin() + long(at + whole)};
      at += whole;
    }
    ADD_FAILURE() << "OpenImageIO wrote no picture";
    return {};
  }
};

// OpenImageIO takes six bytes off a block of Exif, however short it is.
TEST_F(WebpStreams, ChunksOtherThanThePictureAreDropped) {
  constexpr uint8_t kExif = 0x08;
  EXPECT_EQ(fault_of("a.webp", riff({extended(kExif, 2, 2), picture(), chunk("EXIF", {1, 2})})), "");
  EXPECT_EQ(texture_->width(), 2);
  EXPECT_EQ(fault_of("a.webp", riff({picture(), chunk("EXIF", {1, 2})})), "");
  EXPECT_NE(fault_of("a.webp", riff({chunk("EXIF", {1, 2})})).find("no picture"), std::string::npos);
  Bytes cut = riff({picture()});
  cut.resize(cut.size() - 4);
  EXPECT_NE(fault_of("a.webp", cut).find("cut off"), std::string::npos);
}

// EXT_texture_webp shows an animation's first frame. OpenImageIO does not clear what that leaves open.
TEST_F(WebpStreams, AnAnimationIsItsFirstFrame) {
  constexpr uint8_t kAnimation = 0x02;
  const Bytes one = frame(0, 0, picture()), moved = frame(1, 0, picture());
  const Bytes background = chunk("ANIM", {0, 0, 0, 0, 0, 0});
  EXPECT_EQ(fault_of("a.webp", riff({extended(kAnimation, 2, 2), background, one, moved})), "");
  EXPECT_EQ(texture_->height(), 2);
  for (const Bytes& file : {riff({extended(kAnimation, 4, 4), background, one}),
                            riff({extended(kAnimation, 4, 2), background, moved, one})})
    EXPECT_NE(fault_of("a.webp", file).find("does not cover the picture"), std::string::npos);
  EXPECT_NE(fault_of("a.webp", riff({extended(kAnimation, 2, 2), picture()})).find("without frames"),
            std::string::npos);
}

// JPEG ---------------------------------------------------------------------------------------------
class JpegStreams : public ImageStreams {
 protected:
  Bytes whole_ = slurp(write("a.jpg", 2, 2, 3, OIIO::TypeUInt8, kQuad));
  /// With these bytes after the start of the image.
  Bytes with(const Bytes& segments) const {
    Bytes file(whole_.begin(), whole_.begin() + 2);
    add(file, segments);
    file.insert(file.end(), whole_.begin() + 2, whole_.end());
    return file;
  }
  /// Where the first segment of that kind begins.
  size_t find(uint8_t marker) const {
    size_t at = 2;
    while (whole_.at(at + 1) != marker) at += 2 + 256u * whole_.at(at + 2) + whole_.at(at + 3);
    return at;
  }
};

TEST_F(JpegStreams, ApplicationSegmentsAreDropped) {
  ASSERT_EQ(fault_of("a.jpg", whole_), "");
  const Rgb plain = texture_->texel(1, 1);
  EXPECT_EQ(fault_of("a.jpg", with({0xff, 0xe1, 0, 7, 'E', 'x', 'i', 'f', 0})), "");
  EXPECT_EQ(texture_->texel(1, 1), plain);
  EXPECT_EQ(
      fault_of("a.jpg", with({0xff, 0xed, 0, 16, 'P', 'h', 'o', 't', 'o', 's', 'h', 'o', 'p', ' ', '3', '.', '0', 0})),
      "");
  EXPECT_EQ(fault_of("a.jpg", with({0xff, 0xff, 0xff, 0xfe, 0, 2})), "") << "filling, and an empty comment";
  EXPECT_NE(fault_of("a.jpg", with({0xff, 0xe1, 0xff, 0xff})).find("cut off inside a segment"), std::string::npos);
}

// libjpeg passes over them, too.
TEST_F(JpegStreams, StrayBytesBetweenSegmentsArePassedOver) {
  ASSERT_EQ(fault_of("a.jpg", whole_), "");
  const Rgb plain = texture_->texel(1, 1);
  for (const Bytes& stray : {Bytes{0x12}, Bytes{0, 0, 0}, Bytes{0xff, 0, 0x34}, Bytes{0x12, 0xff}}) {
    Bytes segments = {0xff, 0xfe, 0, 2};
    add(segments, stray);
    EXPECT_EQ(fault_of("a.jpg", with(segments)), "");
    EXPECT_EQ(texture_ ? texture_->texel(1, 1) : Rgb(), plain);
  }
  Bytes endless = {0xff, 0xd8, 0xff, 0xfe, 0, 2};
  endless.resize(4096, 0x12);
  EXPECT_NE(fault_of("a.jpg", endless).find("cut off"), std::string::npos);
}

// libjpeg keeps all coefficients of an image that comes in scans, and reads it as it is opened.
TEST_F(JpegStreams, ScansAreBoundedBeforeTheImageIsOpened) {
  const size_t frame = find(0xc0), scan = find(0xda);
  Bytes scans = whole_;
  for (int i = 0; i < 120; ++i) scans.insert(scans.begin() + long(scan), whole_.begin() + long(scan), whole_.end() - 2);
  EXPECT_NE(fault_of("a.jpg", scans).find("more than 100 scans"), std::string::npos);
  Bytes huge = whole_;
  huge[frame + 1] = 0xc2;
  for (size_t i = 5; i < 9; ++i) huge[frame + i] = 0xf0;
  EXPECT_NE(fault_of("a.jpg", huge).find("claims 61680 x 61680 pixels"), std::string::npos);
  for (size_t i = 5; i < 9; i += 2) huge[frame + i] = 0x3f;
  const auto memory = std::make_shared<MemoryBudget>(size_t(256) << 20);
  reports_.all.clear();
  EXPECT_FALSE(load_texture({spit("a.jpg", huge), nullptr, "raw"}, *colors_, reports_.sink,
                            {.store = std::make_shared<TexelStore>(reports_.sink, memory)}));
  EXPECT_NE(reports_.text().find("needs 1"), std::string::npos) << reports_.text();
}

// TIFF ---------------------------------------------------------------------------------------------
class TiffStreams : public ImageStreams {
 protected:
  using Numbers = std::map<uint16_t, uint32_t>;
  /// Two by two pixels of bytes, black is zero; a number of 0 takes its entry away.
  static Bytes tiff(const Numbers& changes, size_t colors = 0) {
    Numbers entries = {{256, 2}, {257, 2}, {258, 8}, {259, 1}, {262, 1}, {277, 1}, {278, 2}};
    for (const auto& [tag, value] : changes) value == 0 ? void(entries.erase(tag)) : void(entries[tag] = value);
    if (changes.contains(262) && changes.at(262) == 0) entries[262] = 0;  // white is zero
    const bool tiled = entries.contains(322);
    if (tiled) entries.erase(278);
    const uint16_t offsets = tiled ? 324 : 273, counts = tiled ? 325 : 279;
    entries[offsets] = entries[counts] = 0;
    constexpr uint32_t kBytes = 4096;
    if (colors > 0) entries[320] = 0;
    const auto after = uint32_t(8 + 2 + 12 * entries.size() + 4);
    entries[offsets] = after, entries[counts] = kBytes;
    Bytes file = {'I', 'I', '*', 0, 8, 0, 0, 0};
    add_number(file, uint32_t(entries.size()), 2);
    for (const auto& [tag, value] : entries) {
      add_number(file, tag, 2), add_number(file, tag == 320 ? 3 : 4, 2);
      add_number(file, tag == 320 ? uint32_t(colors) : 1, 4), add_number(file, tag == 320 ? after + kBytes : value, 4);
    }
    add_number(file, 0, 4);
    file.resize(file.size() + kBytes, 51);
    file.resize(file.size() + 2 * colors, 102);
    return file;
  }
};

// promise: security.image_memory
TEST_F(TiffStreams, KindsThatOpenImageIoReadsBeyondItsBuffersAreRefused) {
  const std::map<std::string, Bytes> files = {
      {"samples", tiff({{258, 64}, {339, 3}, {322, 16}, {323, 16}})},  // never converted in tiles
      {"samples    ", tiff({{258, 64}})},
      {"samples     ", tiff({{258, 64}, {339, 2}})},
      {"samples ", tiff({{258, 24}, {322, 16}, {323, 16}})},  // never converted in tiles
      {"samples  ", tiff({{258, 8}, {339, 3}})},
      {"colours", tiff({{262, 3}, {258, 32}}, 768)},  // two bytes of memory for each index of four
      {"colours ", tiff({{262, 3}}, 3)},
      {"colours  ", tiff({{262, 3}})},
      {"colours   ", tiff({{262, 5}, {277, 4}, {322, 16}, {323, 16}})},  // four samples in room for three
      {"colours    ", tiff({{262, 5}, {277, 4}, {258, 4}})},
      {"samples   ", tiff({{262, 5}, {277, 4}, {258, 4}, {322, 16}, {323, 16}})},
      {"colours     ", tiff({{262, 8}, {277, 5}})},
      {"colours      ", tiff({{262, 0}, {277, 2}})},  // inverts samples by their number squared
      {"compression", tiff({{259, 7}, {277, 2}})},
      {"volume", tiff({{32997, 3}})},
      {"size", tiff({{322, 65536}, {323, 65536}})},
      {"size ", tiff({{256, 1 << 26}, {257, 1}, {277, 64}})}};
  for (const auto& [reason, file] : files) {
    const std::string word = reason.substr(0, reason.find(' ')), fault = fault_of("a.tif", file);
    EXPECT_NE(fault.find(word), std::string::npos) << reason << ": " << fault;
    EXPECT_NE(fault.find("export"), std::string::npos) << fault;
  }
}

TEST_F(TiffStreams, OrdinaryKindsAreRead) {
  struct Case {
    const char* what;
    Bytes file;
    float value;
  };
  const Case cases[] = {{"grey", tiff({}), 0.2f},
                        {"no rows a strip", tiff({{278, 0}}), 0.2f},
                        {"all rows in a strip", tiff({{278, UINT32_MAX}}), 0.2f},
                        {"white is zero", tiff({{262, 0}}), 0.8f},
                        {"RGB", tiff({{262, 2}, {277, 3}}), 0.2f},
                        {"tiles", tiff({{322, 16}, {323, 16}}), 0.2f},
                        {"16 bits", tiff({{258, 16}}), 0.2f},
                        {"16 bits, white is zero", tiff({{258, 16}, {262, 0}}), 0.8f},
                        {"16 bits, white is zero, tiles", tiff({{258, 16}, {262, 0}, {322, 16}, {323, 16}}), 0.8f},
                        {"bytes without a type", tiff({{339, 4}}), 0.2f},
                        {"16 bits without a type", tiff({{258, 16}, {339, 4}}), 0.2f},
                        {"colours", tiff({{262, 3}}, 768), 0.4f},
                        {"CMYK", tiff({{262, 5}, {277, 4}}), 0.64f},
                        {"one bit by default", tiff({{258, 0}, {259, 0}}), 0.0f}};
  for (const Case& c : cases) {
    EXPECT_EQ(fault_of("a.tif", c.file), "") << c.what;
    EXPECT_NEAR(texture_ ? texture_->texel(0, 0).r : -1, c.value, 2e-3f) << c.what;
  }
}

TEST_F(TiffStreams, FloatsOf64BitsAreRead) {
  Bytes file = tiff({{258, 64}, {339, 3}});
  const double numbers[] = {0.25, -3.5, 1e-3, 1e300};
  std::memcpy(&file[file.size() - 4096], numbers, sizeof numbers);
  EXPECT_EQ(fault_of("a.tif", file), "");
  ASSERT_TRUE(texture_);
  EXPECT_EQ(texture_->texel(0, 0), Rgb(0.25f));
  EXPECT_EQ(texture_->texel(1, 0), Rgb(-3.5f));
  EXPECT_NEAR(texture_->texel(0, 1).g, 1e-3f, 1e-6f);
  EXPECT_TRUE(std::isfinite(texture_->texel(1, 1).b)) << "as large ones of 32 bits are";
}

}  // namespace
}  // namespace alabaster
