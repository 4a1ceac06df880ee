// Values of image files and their place, by their headers: precision, exposure, primaries, orientation, cubes.
#include <zlib.h>

#include <algorithm>
#include <array>
#include <limits>

#include "core/color/chromaticities.h"
#include "core/texture/texel_store.h"
#include "testenv/support/bytes_read.h"
#include "testenv/support/texture_file.h"

namespace alabaster {
namespace {

using testing::bytes_read;
using testing::TextureFile;
using Bytes = std::vector<uint8_t>;

Bytes bytes_of(const std::string& text) {
  return {text.begin(), text.end()};
}

class ImageValues : public TextureFile {
 protected:
  long count(const std::string& code) const {
    return std::count_if(reports_.all.begin(), reports_.all.end(), [&](const Diagnostic& d) { return d.code == code; });
  }
  /// Pixels of four bytes: red, green, blue, exponent.
  std::string write_hdr(const std::string& header, const std::vector<std::array<uint8_t, 4>>& pixels) const {
    Bytes file = bytes_of("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n" + header + "\n");
    for (const auto& pixel : pixels) file.insert(file.end(), pixel.begin(), pixel.end());
    return spit("a.hdr", file);
  }
};
constexpr std::array<uint8_t, 4> kOne = {128, 64, 32, 129};  // 1, 0.5, 0.25

TEST_F(ImageValues, FloatsStayFloats) {
  const std::vector<float> values = {5e6f, 1e-8f, 100.0001f, -3e30f, 1234.567f, 1e-30f};
  for (const char* const name : {"a.exr", "a.tif"}) {
    const auto t = load(write(name, 2, 1, 3, OIIO::TypeFloat, values));
    ASSERT_TRUE(t) << reports_.text();
    EXPECT_EQ(t->texel(0, 0), Rgb(values[0], values[1], values[2])) << name;
    EXPECT_EQ(t->texel(1, 0), Rgb(values[3], values[4], values[5])) << name;
    EXPECT_TRUE(reports_.all.empty());
  }
  // Grey texels come first, and opaque ones, so that what is kept changes on the way.
  std::vector<float> pixels(64 * 64 * 4, 1.0f);
  pixels[4 * 4000] = 0.1f, pixels[4 * 4000 + 3] = 0.3f, pixels[4 * 4095 + 1] = 1e7f;
  const auto late = load(write("late.exr", 64, 64, 4, OIIO::TypeFloat, pixels));
  EXPECT_EQ(late->texel(32, 62), Rgb(0.1f, 1, 1));
  EXPECT_EQ(late->texel(63, 63), Rgb(1, 1e7f, 1));
  EXPECT_NEAR(late->alpha({(32 + 0.5f) / 64, 1 - (62 + 0.5f) / 64}), 0.3f, 1e-6f);
}

TEST_F(ImageValues, WholeNumbersOf16BitsStay) {
  std::vector<float> ramp;
  for (int i = 0; i < 4096; ++i) ramp.push_back(float(i + 30000) / 65535);
  for (const char* const name : {"ramp.png", "ramp.tif"}) {
    const auto t = load(write(name, 64, 64, 1, OIIO::TypeUInt16, ramp), "raw");
    ASSERT_TRUE(t) << reports_.text();
    for (int i = 0; i < 4096; ++i) ASSERT_NEAR(t->texel(i % 64, i / 64).r, ramp[size_t(i)], 1e-7f) << name << i;
  }
}

TEST_F(ImageValues, AreHalvesWhereTheseAreEqual) {
  const std::vector<float> halves = {0.5f, 65504, 0, 1};
  EXPECT_EQ(load(write("a.exr", 2, 2, 1, OIIO::TypeFloat, halves))->memory_bytes(), 2u * 4);
  EXPECT_EQ(load(write("b.exr", 2, 2, 1, OIIO::TypeFloat, {0.5f, 65505, 0, 1}))->memory_bytes(), 4u * 4);
  EXPECT_EQ(load(write("c.exr", 2, 2, 1, OIIO::TypeHalf, {0.1f, 0.2f, 0, 1}))->memory_bytes(), 2u * 4);
}

TEST_F(ImageValues, InfinityIsTheLargest) {
  const float inf = std::numeric_limits<float>::infinity(), nan = std::nanf("");
  for (const auto& format : {OIIO::TypeHalf, OIIO::TypeFloat}) {
    const auto t = load(write("a.exr", 2, 1, 3, format, {inf, -inf, 2, nan, 0.5f, 3}));
    ASSERT_TRUE(t) << reports_.text();
    EXPECT_EQ(t->texel(0, 0), Rgb(65504, -65504, 2));
    EXPECT_EQ(t->texel(1, 0), Rgb(0, 0.5f, 3));
  }
  const auto hot = load(write("b.exr", 2, 1, 3, OIIO::TypeFloat, {inf, 1, 2, 5e6f, 0.5f, 3}));
  EXPECT_EQ(hot->texel(0, 0), Rgb(5e6f, 1, 2)) << "the image's largest";
}

// From the least memory to enough of it: no texture, halves with a warning, floats.
TEST_F(ImageValues, MemoryThatIsShortOfFloatsHoldsHalvesAndSaysSo) {
  std::vector<float> pixels = testing::noise(size_t(128) * 128 * 3);
  const std::string floats = write("a.exr", 128, 128, 3, OIIO::TypeFloat, pixels);
  const std::string bytes = write("a.png", 128, 128, 3, OIIO::TypeUInt8, pixels);
  std::string order;
  for (size_t limit = size_t(16) << 10; limit < size_t(4) << 20; limit += size_t(16) << 10) {
    reports_.all.clear();
    const auto memory = std::make_shared<MemoryBudget>(limit);
    const TextureLoading loading = {.store = std::make_shared<TexelStore>(reports_.sink, memory)};
    const auto t = load_texture({floats, nullptr, "raw"}, *colors_, reports_.sink, loading);
    const char found = !t ? '0' : t->texel(5, 5).r == pixels[3 * (5 * 128 + 5)] ? 'f' : 'h';
    if (order.empty() || order.back() != found) order += found;
    ASSERT_EQ(count("texture.precision"), found == 'h' ? 1 : 0) << limit << reports_.text();
    ASSERT_EQ(count("texture.memory"), found == '0' ? 1 : 0) << limit << reports_.text();
    if (t) {
      EXPECT_NEAR(t->texel(5, 5).r, pixels[3 * (5 * 128 + 5)], 5e-4f);
    }
    reports_.all.clear();
    load_texture({bytes, nullptr, "raw"}, *colors_, reports_.sink, loading);
    ASSERT_EQ(count("texture.precision"), 0) << "bytes are never floats";
  }
  EXPECT_EQ(order, "0hf");
}

// Halves take as much as floats where all texels are bytes: a refusal on the way is no reason to read the file again.
TEST_F(ImageValues, AnImageThatMemoryDoesNotHoldIsNotReadTwice) {
  if (bytes_read() == 0) GTEST_SKIP() << "the kernel counts no bytes that are read";
  constexpr int kSide = 256, kGreyRows = 200;  // colours come late, and need more memory
  std::vector<float> pixels = testing::noise(size_t(kSide) * kSide * 3);
  for (size_t i = 0; i < size_t(kSide) * kGreyRows * 3; ++i) pixels[i] = pixels[i / 3 * 3];
  const TextureSource source{write("late.png", kSide, kSide, 3, OIIO::TypeUInt8, pixels), nullptr, "raw"};
  const auto read_with = [&](size_t limit, bool* held) {
    const TextureLoading loading = {
        .store = std::make_shared<TexelStore>(reports_.sink, std::make_shared<MemoryBudget>(limit))};
    const uint64_t before = bytes_read();
    *held = load_texture(source, *colors_, reports_.sink, loading) != nullptr;
    return bytes_read() - before;
  };
  bool held = false;
  const uint64_t once = read_with(size_t(64) << 20, &held);
  ASSERT_TRUE(held) << reports_.text();
  size_t on_the_way = 0;
  for (size_t limit = size_t(32) << 10; limit < size_t(2) << 20; limit += size_t(32) << 10) {
    const uint64_t read = read_with(limit, &held);
    EXPECT_LT(read, once + once / 5) << limit;
    on_the_way += !held && read > once / 2;
  }
  EXPECT_GT(on_the_way, 0u) << "else this test would see nothing";
}

TEST_F(ImageValues, FilteredFloatsAreFloats) {
  std::vector<float> pixels(3 * 16 * 16, 1e6f);
  const auto t = load(write("a.exr", 16, 16, 3, OIIO::TypeFloat, pixels));
  ASSERT_TRUE(t && t->prepare_filtering());
  EXPECT_FLOAT_EQ(t->filtered({0.5f, 0.5f}, 8).r, 1e6f);
}

// A material multiplies the colour by the alpha once more.
TEST_F(ImageValues, AssociatedColorsAreDividedByAlphaWhereThatIsAskedFor) {
  const auto load_both = [&](const std::string& file) {
    TextureSource source;
    source.path = file, source.color_space = "raw";
    const auto stored = load(source);
    source.is_straight = true;
    return std::pair(stored, load(source));
  };
  const std::vector<float> pixels = {0.5f, 0.25f, 0.125f, 0.5f, 3, 2, 1, 0, 0.75f, 0.5f, 0.25f, 1};
  const auto [stored, straight] = load_both(write("a.exr", 3, 1, 4, OIIO::TypeFloat, pixels));
  ASSERT_TRUE(stored && straight) << reports_.text();
  EXPECT_EQ(stored->texel(0, 0), Rgb(0.5f, 0.25f, 0.125f));
  EXPECT_EQ(straight->texel(0, 0), Rgb(1, 0.5f, 0.25f));
  EXPECT_EQ(straight->texel(1, 0), Rgb(3, 2, 1)) << "light alone";
  EXPECT_EQ(straight->texel(2, 0), Rgb(0.75f, 0.5f, 0.25f));
  EXPECT_NEAR(straight->alpha({1 / 6.0f, 0.5f}), 0.5f, 1e-3f);
  for (const bool is_associated : {false, true}) {
    OIIO::ImageSpec spec(1, 1, 4, OIIO::TypeUInt8);
    if (!is_associated) spec.attribute("oiio:UnassociatedAlpha", 1);
    const uint8_t pixel[] = {100, 50, 25, 128};
    const auto out = OIIO::ImageOutput::create("a.tif");
    ASSERT_TRUE(out->open(path("a.tif"), spec) && out->write_image(OIIO::TypeUInt8, pixel) && out->close());
    const auto bytes = load_both(path("a.tif")).second;
    ASSERT_TRUE(bytes) << reports_.text();
    EXPECT_NEAR(bytes->texel(0, 0).r * 255, is_associated ? 199 : 100, 0.1) << is_associated;
    EXPECT_NEAR(bytes->texel(0, 0).b * 255, is_associated ? 50 : 25, 0.1) << is_associated;
  }
}

TEST_F(ImageValues, KindsThatAreNotReadAreNamed) {
  EXPECT_FALSE(load(spit("big.tif", bytes_of(std::string("II+\0\10\0\0\0", 8)))));
  EXPECT_NE(reports_.text().find("BigTIFF"), std::string::npos) << reports_.text();
  std::vector<uint8_t> exr = slurp(write("a.exr", 1, 1, 3, OIIO::TypeFloat, {1, 1, 1}));
  const std::string name = std::string("compression\0compression\0", 24);
  const auto at = std::search(exr.begin(), exr.end(), name.begin(), name.end());
  ASSERT_NE(at, exr.end());
  at[24 + 4] = 10;  // of OpenEXR 3.4
  EXPECT_FALSE(load(spit("new.exr", exr)));
  EXPECT_NE(reports_.text().find("its compression"), std::string::npos) << reports_.text();
  const auto other =
      load(spit("a.hdr", bytes_of("#?AUTOPANO11\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 1\n\x80\x40\x20\x81")));
  ASSERT_TRUE(other) << reports_.text();
  EXPECT_EQ(other->texel(0, 0), Rgb(1, 0.5f, 0.25f));
}

TEST_F(ImageValues, ExposureIsDividedBy) {
  const auto plain = load(write_hdr("\n-Y 1 +X 1", {kOne}));
  ASSERT_TRUE(plain) << reports_.text();
  EXPECT_EQ(plain->texel(0, 0), Rgb(1, 0.5f, 0.25f));
  // Each line has multiplied the values.
  const auto t = load(write_hdr("EXPOSURE= 2\nEXPOSURE=4\nCOLORCORR= 1 2 .5\n\n-Y 1 +X 1", {kOne}));
  ASSERT_TRUE(t) << reports_.text();
  EXPECT_EQ(t->texel(0, 0), Rgb(1 / 8.0f, 0.5f / 16, 0.25f / 4));
  EXPECT_FALSE(load(write_hdr("EXPOSURE=0\n\n-Y 1 +X 1", {kOne})));
  EXPECT_NE(reports_.text().find("EXPOSURE="), std::string::npos) << reports_.text();
  EXPECT_FALSE(load(spit("xyz.hdr", bytes_of("#?RADIANCE\nFORMAT=32-bit_rle_xyze\n\n-Y 1 +X 1\n\x80\x80\x80\x81"))));
  EXPECT_NE(reports_.text().find("CIE XYZ"), std::string::npos) << reports_.text();
}

TEST_F(ImageValues, PrimariesAreTheFiles) {
  const auto write_exr = [&](const Chromaticities& chromaticities, const std::vector<float>& pixels) {
    OIIO::ImageSpec spec(2, 1, 3, OIIO::TypeFloat);
    spec.attribute("chromaticities", OIIO::TypeDesc(OIIO::TypeDesc::FLOAT, 8), chromaticities.data());
    const auto out = OIIO::ImageOutput::create("x.exr");
    EXPECT_TRUE(out->open(path("x.exr"), spec) && out->write_image(OIIO::TypeFloat, pixels.data()) && out->close());
  };
  write_exr({0.708f, 0.292f, 0.170f, 0.797f, 0.131f, 0.046f, 0.3127f, 0.3290f}, {1, 0, 0, 1, 1, 1});
  const auto near = [](const Rgb& a, const Rgb& b) {
    for (int i = 0; i < 3; ++i) EXPECT_NEAR(a[i], b[i], 2e-3f) << i;
  };
  // ITU-R BT.2087 has the matrix.
  near(load(path("x.exr"))->texel(0, 0), {1.6605f, -0.1246f, -0.0182f});
  near(load(path("x.exr"))->texel(1, 0), Rgb(1));
  EXPECT_EQ(load(path("x.exr"), "raw")->texel(0, 0), Rgb(1, 0, 0)) << "a named space overrules";
  const auto hdr =
      load(write_hdr("PRIMARIES= .708 .292 .170 .797 .131 .046 .3127 .3290\n\n-Y 1 +X 1", {{128, 0, 0, 129}}));
  ASSERT_TRUE(hdr) << reports_.text();
  near(hdr->texel(0, 0), {1.6605f, -0.1246f, -0.0182f});
  write_exr({1, 0, 0, 1, 0, 0, 1 / 3.0f, 1 / 3.0f}, {0.9505f, 1, 1.0891f, 0.4124f, 0.2126f, 0.0193f});
  near(load(path("x.exr"))->texel(0, 0), Rgb(1));
  near(load(path("x.exr"))->texel(1, 0), {1, 0, 0});
  // Primaries on one line. The infinity is known after the last row, so that the rows are read twice.
  write_exr({0.1f, 0.1f, 0.2f, 0.2f, 0.3f, 0.3f, 1 / 3.0f, 1 / 3.0f},
            {std::numeric_limits<float>::infinity(), 0, 0, 5e6f, 1, 1});
  EXPECT_EQ(load(path("x.exr"))->texel(0, 0), Rgb(5e6f, 0, 0));
  EXPECT_EQ(count("texture.chromaticities"), 1) << reports_.text();
}

// Orientation ---------------------------------------------------------------------------------------
enum Side { top, bottom, left, right };
struct Orientation {
  int number;
  Side row, column;  // where the first ones lie: TIFF 6.0, page 36
  const char* hdr;
};
constexpr int kWidth = 3, kHeight = 2;
constexpr Orientation kOrientations[] = {{1, top, left, "-Y 2 +X 3"},     {2, top, right, "-Y 2 -X 3"},
                                         {3, bottom, right, "+Y 2 -X 3"}, {4, bottom, left, "+Y 2 +X 3"},
                                         {5, left, top, "+X 3 -Y 2"},     {6, right, top, "-X 3 -Y 2"},
                                         {7, right, bottom, "-X 3 +Y 2"}, {8, left, bottom, "+X 3 +Y 2"}};

/// The places in the picture of the stored pixels, row by row; `size`: stored width and height.
std::vector<std::array<int, 2>> stored_places(const Orientation& orientation, std::array<int, 2>* size) {
  const bool is_turned = orientation.row == left || orientation.row == right;
  *size = is_turned ? std::array{kHeight, kWidth} : std::array{kWidth, kHeight};
  std::vector<std::array<int, 2>> places;
  for (int row = 0; row < (*size)[1]; ++row)
    for (int column = 0; column < (*size)[0]; ++column) {
      std::array<int, 2> place{};
      for (const auto& [side, i] : {std::pair{orientation.row, row}, std::pair{orientation.column, column}}) {
        if (side == top || side == bottom) place[1] = side == top ? i : kHeight - 1 - i;
        if (side == left || side == right) place[0] = side == left ? i : kWidth - 1 - i;
      }
      places.push_back(place);
    }
  return places;
}
float value_at(int x, int y) {
  return float(1 + x + kWidth * y) / 8;
}

class ImageOrientation : public ImageValues {
 protected:
  void expect_upright(const std::string& file, const std::string& what) {
    const auto t = load(file, "raw");
    ASSERT_TRUE(t) << what << reports_.text();
    const int block = t->width() / kWidth;
    ASSERT_EQ(t->width(), kWidth * block) << what;
    ASSERT_EQ(t->height(), kHeight * block) << what;
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth; ++x)
        EXPECT_NEAR(t->texel(x * block + block / 2, y * block + block / 2).r, value_at(x, y), 0.01f)
            << what << ": " << x << " " << y;
  }
  /// In blocks, for JPEG.
  std::string write_stored(const std::string& name, const Orientation& o, OIIO::TypeDesc format, int block) const {
    std::array<int, 2> size{};
    const auto places = stored_places(o, &size);
    std::vector<float> pixels;
    for (int y = 0; y < size[1] * block; ++y)
      for (int x = 0; x < size[0] * block; ++x) {
        const auto& place = places[size_t(y / block * size[0] + x / block)];
        pixels.insert(pixels.end(), 3, value_at(place[0], place[1]));
      }
    OIIO::ImageSpec spec(size[0] * block, size[1] * block, 3, format);
    if (!name.ends_with(".png") && !name.ends_with(".webp")) spec.attribute("Orientation", o.number);
    spec.attribute("compression", name.ends_with(".webp") ? "lossless" : name.ends_with(".jpg") ? "jpeg:98" : "none");
    const auto out = OIIO::ImageOutput::create(name);
    EXPECT_TRUE(out->open(path(name), spec) && out->write_image(OIIO::TypeFloat, pixels.data()) && out->close())
        << out->geterror();
    return path(name);
  }
  /// Big endian, one entry.
  static Bytes exif(int orientation) {
    return {'M', 'M', 0, 42, 0, 0, 0, 8, 0, 1, 0x01, 0x12, 0, 3, 0, 0, 0, 1, 0, uint8_t(orientation), 0, 0, 0, 0, 0, 0};
  }
};

TEST_F(ImageOrientation, RadianceOrientationIsApplied) {
  for (const Orientation& o : kOrientations) {
    std::array<int, 2> size{};
    std::vector<std::array<uint8_t, 4>> pixels;
    for (const auto& [x, y] : stored_places(o, &size)) {
      const auto byte = uint8_t(value_at(x, y) * 128);
      pixels.push_back({byte, byte, byte, 129});
    }
    expect_upright(write_hdr(std::string("\n") + o.hdr, pixels), o.hdr);
  }
}

TEST_F(ImageOrientation, TiffOrientationIsApplied) {
  for (const Orientation& o : kOrientations)
    for (const auto& format : {OIIO::TypeUInt8, OIIO::TypeUInt16, OIIO::TypeFloat})
      expect_upright(write_stored("a.tif", o, format, 1), "TIFF " + std::to_string(o.number));
}

TEST_F(ImageOrientation, ExifOrientationInJpegIsApplied) {
  for (const Orientation& o : kOrientations)
    expect_upright(write_stored("a.jpg", o, OIIO::TypeUInt8, 16), "JPEG " + std::to_string(o.number));
}

TEST_F(ImageOrientation, ExifOrientationInPngIsApplied) {
  for (const Orientation& o : kOrientations) {
    Bytes file = slurp(write_stored("a.png", o, OIIO::TypeUInt8, 1));
    const Bytes data = exif(o.number);
    Bytes chunk = bytes_of("eXIf");
    chunk.insert(chunk.end(), data.begin(), data.end());
    const uLong sum = crc32(0, chunk.data(), uInt(chunk.size()));
    for (int i = 3; i >= 0; --i) chunk.push_back(uint8_t(sum >> (8 * i)));
    chunk.insert(chunk.begin(), {0, 0, 0, uint8_t(data.size())});
    constexpr int kAfterHeader = 8 + 25;  // signature and IHDR; OpenImageIO 2.5 wrote a second eXIf chunk of its own
    file.insert(file.begin() + kAfterHeader, chunk.begin(), chunk.end());
    expect_upright(spit("a.png", file), "PNG " + std::to_string(o.number));
  }
}

TEST_F(ImageOrientation, ExifOrientationInWebpIsApplied) {
  if (!OIIO::ImageOutput::create("a.webp")) GTEST_SKIP() << "OpenImageIO was built without WebP";
  for (const Orientation& o : kOrientations) {
    const Bytes plain = slurp(write_stored("a.webp", o, OIIO::TypeUInt8, 16));
    std::array<int, 2> size{};
    static_cast<void>(stored_places(o, &size));
    Bytes file(plain.begin(), plain.begin() + 12);
    const auto add = [&](const std::string& type, const Bytes& payload) {
      file.insert(file.end(), type.begin(), type.end());
      for (size_t i = 0; i < 4; ++i) file.push_back(uint8_t(payload.size() >> (8 * i)));
      file.insert(file.end(), payload.begin(), payload.end());
      if (payload.size() % 2 != 0) file.push_back(0);
    };
    constexpr uint8_t kHasExif = 0x08;
    add("VP8X", {kHasExif, 0, 0, 0, uint8_t(size[0] * 16 - 1), 0, 0, uint8_t(size[1] * 16 - 1), 0, 0});
    file.insert(file.end(), plain.begin() + 12, plain.end());
    add("EXIF", exif(o.number));
    for (size_t i = 0; i < 4; ++i) file[4 + i] = uint8_t((file.size() - 8) >> (8 * i));
    expect_upright(spit("a.webp", file), "WebP " + std::to_string(o.number));
  }
}

// Cubes ---------------------------------------------------------------------------------------------
constexpr int kSize = 16;  // of a face

/// Offset of the byte behind the header, whose last standard attribute is found at `at`.
size_t end_of_header(const Bytes& file, size_t at) {
  while (file[at] != 0) {
    for (int words = 0; words < 2; ++at) words += file[at] == 0;
    at += 4 + file[at];
  }
  return at + 1;
}

/// An EXR of 16 rows a piece whose header gets an attribute "envmap" of one byte, 1; the table of pieces moves with it.
Bytes with_cube_attribute(Bytes file) {
  const Bytes attribute = bytes_of(std::string("envmap\0envmap\0\1\0\0\0\1", 19));
  const std::string first = "channels", last = "screenWindowWidth";
  const auto place = std::search(file.begin(), file.end(), first.begin(), first.end());
  const auto end = std::search(file.begin(), file.end(), last.begin(), last.end());
  const size_t table = end_of_header(file, size_t(end - file.begin()));
  for (size_t piece = 0; piece < 6; ++piece) {
    uint64_t offset = attribute.size();
    for (size_t b = 0; b < 8; ++b) offset += uint64_t(file[table + 8 * piece + b]) << (8 * b);
    for (size_t b = 0; b < 8; ++b) file[table + 8 * piece + b] = uint8_t(offset >> (8 * b));
  }
  file.insert(place, attribute.begin(), attribute.end());
  return file;
}

class ImageCube : public ImageValues {
 protected:
  /// Red: the face, +x, -x, +y, -y, +z, -z. Green: its upper half. Blue: its left half.
  std::string write_cube() const {
    OIIO::ImageSpec spec(kSize, 6 * kSize, 3, OIIO::TypeFloat);
    spec.attribute("compression", "zip");
    std::vector<float> pixels;
    for (int y = 0; y < 6 * kSize; ++y)
      for (int x = 0; x < kSize; ++x)
        pixels.insert(pixels.end(),
                      {float(y / kSize + 1), y % kSize < kSize / 2 ? 1.0f : 0.0f, x < kSize / 2 ? 1.0f : 0.0f});
    const auto out = OIIO::ImageOutput::create("x.exr");
    EXPECT_TRUE(out->open(path("x.exr"), spec) && out->write_image(OIIO::TypeFloat, pixels.data()) && out->close());
    return spit("cube.exr", with_cube_attribute(slurp(path("x.exr"))));
  }
};

// Places beside the middle of each face: longitude falls from left to right. Faces: ImfEnvmap.h.
TEST_F(ImageCube, CubeMapFileIsReadAsAnEnvironment) {
  TextureSource source;
  source.path = write_cube(), source.is_environment = true;
  const auto t = load(source);
  ASSERT_TRUE(t) << reports_.text();
  ASSERT_EQ(t->width(), 4 * kSize);
  ASSERT_EQ(t->height(), 2 * kSize);
  constexpr int kMiddle = 2 * kSize, kQuarter = kSize, kAbove = kSize - 3;
  struct Look {
    int x, y;
    Rgb color;
    const char* what;
  };
  for (const Look& look : {Look{kMiddle - 3, kAbove, {5, 1, 1}, "+z, x > 0"},
                           {kMiddle + 2, kAbove, {5, 1, 0}, "+z, x < 0"},
                           {kQuarter - 3, kAbove, {1, 1, 1}, "+x, z < 0"},
                           {kQuarter + 2, kAbove, {1, 1, 0}, "+x, z > 0"},
                           {3 * kQuarter - 3, kAbove, {2, 1, 1}, "-x, z > 0"},
                           {3 * kQuarter + 2, kAbove, {2, 1, 0}, "-x, z < 0"},
                           {2, kAbove, {6, 1, 0}, "-z, x > 0"},
                           {kMiddle - 5, 2, {3, 1, 0}, "+y, z > 0, x > 0"},
                           {kMiddle + 4, 2, {3, 1, 1}, "+y, z > 0, x < 0"},
                           {4, 2, {3, 0, 0}, "+y, z < 0, x > 0"},
                           {kMiddle - 5, 2 * kSize - 3, {4, 0, 0}, "-y, z > 0, x > 0"}})
    for (int i = 0; i < 3; ++i) EXPECT_NEAR(t->texel(look.x, look.y)[i], look.color[i], 1e-3f) << look.what << i;
  source.is_environment = false;
  EXPECT_EQ(load(source)->height(), 6 * kSize) << "a surface shows the pixels";
}

}  // namespace
}  // namespace alabaster
