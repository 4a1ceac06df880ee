// Images that are damaged, claim too much, or are none.
#include "testenv/support/texture_file.h"

namespace alabaster {
namespace {

using testing::kQuad;
using testing::noise;
using testing::TextureFile;

TEST_F(TextureFile, FileThatIsNoImageIsReported) {
  struct Case {
    std::string file, expected;
  };
  const Case cases[] = {
      {path("none.png"), "no such file"},
      {folder_.string(), "folder"},
      {spit("empty.png", {}), "empty"},
      {spit("text.png", {'h', 'e', 'l', 'l', 'o', ' ', 't', 'h', 'e', 'r', 'e'}), "kind that is read"},
      {spit("sig.png", {0x89, 'P', 'N', 'G', 0x0d, 0x0a, 0x1a, 0x0a}), "cut off"},
      {spit("movie.mov", {0, 0, 0, 20, 'f', 't', 'y', 'p', 'q', 't', ' ', ' '}), "kind that is read"},
      {spit("old.bmp", {'B', 'M', 70, 0, 0, 0, 0, 0, 0, 0, 58, 0, 0, 0, 40}), "WebP, TGA); convert it"},
      {spit("old.gif", {'G', 'I', 'F', '8', '9', 'a', 2, 0, 2, 0}), "WebP, TGA); convert it"}};
  for (const Case& c : cases) {
    EXPECT_FALSE(load(c.file)) << c.file;
    ASSERT_EQ(reports_.all.size(), 1u) << c.file;
    EXPECT_EQ(reports_.all[0].where, c.file);
    EXPECT_NE(reports_.all[0].text.find(c.expected), std::string::npos) << reports_.text();
  }
}

TEST_F(TextureFile, TruncatedFilesAreRefusedWithoutOutput) {
  ::testing::internal::CaptureStderr();
  for (const char* name : {"t.png", "t.jpg", "t.exr", "t.tif", "t.hdr", "t.webp"}) {
    const bool is_float = std::string(name) == "t.exr" || std::string(name) == "t.hdr";
    const auto whole = slurp(write(name, 64, 64, 3, is_float ? OIIO::TypeFloat : OIIO::TypeUInt8, noise(64 * 64 * 3)));
    for (int percent = 2; percent < 98; percent += 5) {
      const std::vector<uint8_t> part(whole.begin(),
                                      whole.begin() + std::ptrdiff_t(whole.size() * size_t(percent) / 100));
      EXPECT_FALSE(load(spit("part_" + std::string(name), part))) << name << " at " << percent << "%";
      EXPECT_FALSE(reports_.all.empty());
    }
  }
  EXPECT_EQ(::testing::internal::GetCapturedStderr(), "");
}

TEST_F(TextureFile, FlippedBitsNeverCrashOrPrint) {
  ::testing::internal::CaptureStderr();
  std::mt19937 random(11);
  for (const char* name : {"f.png", "f.jpg", "f.exr", "f.tif", "f.hdr", "f.webp", "f.tga"}) {
    const bool is_float = std::string(name) == "f.exr" || std::string(name) == "f.hdr";
    const auto whole = slurp(write(name, 32, 32, 3, is_float ? OIIO::TypeFloat : OIIO::TypeUInt8, noise(32 * 32 * 3)));
    for (int trial = 0; trial < 60; ++trial) {
      auto damaged = whole;
      for (int flips = 0; flips <= trial % 4; ++flips) {
        // The first bytes hold sizes and offsets, so half of the damage goes there.
        const size_t range = trial % 2 ? damaged.size() : std::min<size_t>(damaged.size(), 200);
        damaged[random() % range] ^= uint8_t(1u << (random() % 8));
      }
      const auto t = load_texture({spit("damaged_" + std::string(name), damaged), nullptr, "auto"}, *colors_,
                                  reports_.sink, {.max_pixels = size_t(1) << 20});
      EXPECT_TRUE(!t || is_finite(t->rgb({0.4f, 0.6f})));
      EXPECT_FALSE(t && std::string(name) == "f.png") << "every bit of a PNG is under a checksum";
    }
  }
  EXPECT_EQ(::testing::internal::GetCapturedStderr(), "");
}

uint32_t crc_of(const std::vector<uint8_t>& bytes) {
  uint32_t c = ~0u;
  for (const uint8_t b : bytes) {
    c ^= b;
    for (int k = 0; k < 8; ++k) c = (c >> 1) ^ (0xedb88320u & (0u - (c & 1)));
  }
  return ~c;
}
void append_chunk(std::vector<uint8_t>& file, const std::string& type, const std::vector<uint8_t>& data) {
  const auto word = [&](uint32_t v) {
    for (int shift = 24; shift >= 0; shift -= 8) file.push_back(uint8_t(v >> shift));
  };
  word(uint32_t(data.size()));
  std::vector<uint8_t> body(type.begin(), type.end());
  body.insert(body.end(), data.begin(), data.end());
  file.insert(file.end(), body.begin(), body.end());
  word(crc_of(body));
}

TEST_F(TextureFile, HugeClaimsAreRefusedBeforeAnythingIsAllocated) {
  // A valid PNG header of 60000 x 60000 RGBA pixels with next to no data.
  std::vector<uint8_t> file = {0x89, 'P', 'N', 'G', 0x0d, 0x0a, 0x1a, 0x0a};
  append_chunk(file, "IHDR", {0, 0, 0xea, 0x60, 0, 0, 0xea, 0x60, 8, 6, 0, 0, 0});
  append_chunk(file, "IDAT", {0x78, 0x9c, 0x03, 0x00, 0x00, 0x00, 0x00, 0x01});
  append_chunk(file, "IEND", {});
  EXPECT_FALSE(load(spit("huge.png", file)));
  EXPECT_NE(reports_.text().find("60000"), std::string::npos) << reports_.text();

  const std::string file4 = write("four.png", 2, 2, 3, OIIO::TypeUInt8, kQuad);
  testing::Reports reports;
  EXPECT_FALSE(load_texture({file4, nullptr, "auto"}, *colors_, reports.sink, {.max_pixels = 3}));
  EXPECT_TRUE(load_texture({file4, nullptr, "auto"}, *colors_, reports.sink, {.max_pixels = 4}));
  EXPECT_EQ(reports.all.size(), 1u);
}

// OpenImageIO opens them.
TEST_F(TextureFile, WithoutWidthOrHeightIsRefused) {
  for (const char* size : {"-Y 2 +X 0", "-Y 0 +X 2", "-Y 0 +X 0"}) {
    const std::string text = std::string("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n") + size + "\n\x80\x80\x80\x80";
    reports_.all.clear();
    EXPECT_FALSE(load(spit("none.hdr", {text.begin(), text.end()}))) << size;
    EXPECT_NE(reports_.text().find("no pixels"), std::string::npos) << reports_.text();
  }
}

// Right checksums, and pixels that libpng gives up on.
TEST_F(TextureFile, DamagedPixelsOfPngsDoNotPrint) {
  const std::vector<uint8_t> good = {0, 0, 0, 2, 0, 0, 0, 2, 8, 0, 0, 0, 0};
  // Two rows of a filter and two bytes, not compressed.
  const std::vector<uint8_t> pixels = {0x78, 0x01, 1, 6, 0, 0xf9, 0xff, 0, 9, 9, 0, 9, 9, 0, 0x72, 0, 0x25};
  const auto fault = [&](const std::vector<uint8_t>& header, const std::vector<uint8_t>& data) {
    std::vector<uint8_t> file = {0x89, 'P', 'N', 'G', 0x0d, 0x0a, 0x1a, 0x0a};
    append_chunk(file, "IHDR", header);
    append_chunk(file, "IDAT", data);
    append_chunk(file, "IEND", {});
    ::testing::internal::CaptureStderr();
    const bool is_read = load(spit("pixels.png", file)) != nullptr;
    EXPECT_EQ(::testing::internal::GetCapturedStderr(), "");
    EXPECT_EQ(is_read, reports_.all.empty());
    return reports_.text();
  };
  EXPECT_EQ(fault(good, pixels), "");
  const auto changed = [](std::vector<uint8_t> bytes, size_t at, uint8_t value) {
    bytes[at] = value;
    return bytes;
  };
  EXPECT_NE(fault(changed(good, 8, 3), pixels).find("export or copy"), std::string::npos) << "three bits";
  EXPECT_NE(fault(changed(good, 9, 3), pixels).find("export or copy"), std::string::npos) << "no palette";
  EXPECT_NE(fault(changed(good, 3, 9), pixels).find("export or copy"), std::string::npos) << "too few pixels";
  EXPECT_NE(fault(good, changed(pixels, 7, 77)).find("export or copy"), std::string::npos) << "no such filter";
  EXPECT_NE(fault(good, changed(pixels, 0, 0)).find("export or copy"), std::string::npos) << "no zlib";
}

TEST_F(TextureFile, OddProfilesInPngsDoNotPrint) {
  // A colour profile that is garbage makes libpng warn; the picture is good.
  const auto whole = slurp(write("a.png", 2, 2, 3, OIIO::TypeUInt8, kQuad));
  std::vector<uint8_t> file(whole.begin(), whole.begin() + 33);  // signature and IHDR
  append_chunk(file, "iCCP", {'x', 0, 0, 1, 2, 3, 4});
  file.insert(file.end(), whole.begin() + 33, whole.end());
  ::testing::internal::CaptureStderr();
  const auto t = load(spit("profile.png", file));
  EXPECT_EQ(::testing::internal::GetCapturedStderr(), "");
  ASSERT_TRUE(t) << reports_.text();
  EXPECT_EQ(t->texel(0, 0), Rgb(1, 0, 0));
}

// TIFF 6.0, section 8: a strip may claim more rows than the image has.
TEST_F(TextureFile, StripsTallerThanTheImageTakeNoMemory) {
  constexpr int kWidth = 40000;
  const std::vector<float> pixels = noise(kWidth * 2 * 3);
  auto file = slurp(write("strips.tif", kWidth, 2, 3, OIIO::TypeUInt8, pixels));
  const auto number = [&](size_t at, int bytes) {
    uint32_t value = 0;
    for (int i = bytes; i-- > 0;) value = value << 8 | file.at(at + size_t(i));
    return value;
  };
  constexpr uint32_t kRowsPerStrip = 278;
  const uint32_t directory = number(4, 4);
  bool found = false;
  for (size_t at = directory + 2; at < directory + 2 + 12 * number(directory, 2); at += 12)
    if (number(at, 2) == kRowsPerStrip) file[at + 8] = 0xe0, file[at + 9] = 0xff, found = true;  // 65504
  ASSERT_TRUE(found);
  const auto t = load(spit("tall_strips.tif", file), "raw");
  ASSERT_TRUE(t) << reports_.text();
  EXPECT_NEAR(t->texel(kWidth - 1, 1).r, pixels[size_t(3 * (2 * kWidth - 1))], 0.5f / 255);
}

}  // namespace
}  // namespace alabaster
