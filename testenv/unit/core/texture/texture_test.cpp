#include "core/texture/texture.h"

#include <half.h>

#include <cmath>
#include <limits>

#include "core/texture/texel_store.h"
#include "testenv/support/texture_file.h"

namespace alabaster {
namespace {

using testing::kQuad;
using testing::noise;
using testing::TextureFile;

float srgb_to_linear(float v) {
  return v <= 0.04045f ? v / 12.92f : std::pow((v + 0.055f) / 1.055f, 2.4f);
}

TEST_F(TextureFile, VIsUpAndTexelCentresAreAtHalfIntegers) {
  const auto t = load(write("a.png", 2, 2, 3, OIIO::TypeUInt8, kQuad));
  ASSERT_TRUE(t) << reports_.text();
  EXPECT_EQ(t->width(), 2);
  EXPECT_EQ(t->height(), 2);
  EXPECT_EQ(t->rgb({0.25f, 0.75f}), Rgb(1, 0, 0));
  EXPECT_EQ(t->rgb({0.75f, 0.75f}), Rgb(0, 1, 0));
  EXPECT_EQ(t->rgb({0.25f, 0.25f}), Rgb(0, 0, 1));
  EXPECT_EQ(t->rgb({0.75f, 0.25f}), Rgb(1, 1, 1));
  EXPECT_EQ(t->texel(0, 0), Rgb(1, 0, 0));
  EXPECT_EQ(t->texel(1, 1), Rgb(1, 1, 1));
  const Rgb middle = t->rgb({0.5f, 0.5f});
  EXPECT_FLOAT_EQ(middle.r, 0.5f);
  EXPECT_FLOAT_EQ(middle.g, 0.5f);
  EXPECT_FLOAT_EQ(middle.b, 0.5f);
  const Rgb quarter = t->rgb({0.375f, 0.75f});  // a quarter of the way from red to green
  EXPECT_FLOAT_EQ(quarter.r, 0.75f);
  EXPECT_FLOAT_EQ(quarter.g, 0.25f);
  EXPECT_EQ(t->memory_bytes(), 2u * 2 * 6);
}

TEST_F(TextureFile, WrapModesAgreeWithTheirDefinition) {
  // A row 0, 1, 2, 3 (raw floats): the definition is written out on whole texels, then checked at texel centres far
  // out.
  const std::vector<float> ramp = {0, 1, 2, 3};
  const std::string file = write("ramp.exr", 4, 1, 1, OIIO::TypeFloat, ramp);
  for (const Wrap wrap : {Wrap::repeat, Wrap::mirror, Wrap::clamp, Wrap::black}) {
    const auto t = load(file, "raw", wrap);
    ASSERT_TRUE(t) << reports_.text();
    for (int i = -11; i <= 11; ++i) {
      const int period = ((i % 4) + 4) % 4, both = ((i % 8) + 8) % 8;
      float expected = 0;
      if (wrap == Wrap::repeat) expected = ramp[size_t(period)];
      if (wrap == Wrap::mirror) expected = ramp[size_t(both < 4 ? both : 7 - both)];
      if (wrap == Wrap::clamp) expected = ramp[size_t(std::clamp(i, 0, 3))];
      if (wrap == Wrap::black) expected = i >= 0 && i < 4 ? ramp[size_t(i)] : 0;
      EXPECT_NEAR(t->rgb({(float(i) + 0.5f) / 4, 0.5f}).r, expected, 1e-5) << int(wrap) << " at " << i;
    }
    // Between the last and the first texel.
    const float edge = t->rgb({1.0f, 0.5f}).r;
    EXPECT_NEAR(edge, wrap == Wrap::repeat || wrap == Wrap::black ? 1.5f : 3.0f, 1e-5) << int(wrap);
  }
}

TEST_F(TextureFile, AnyUvGivesADefinedResult) {
  const float nan = std::numeric_limits<float>::quiet_NaN(), inf = std::numeric_limits<float>::infinity();
  const std::string file = write("a.png", 2, 2, 3, OIIO::TypeUInt8, kQuad);
  for (const Wrap wrap : {Wrap::repeat, Wrap::mirror, Wrap::clamp, Wrap::black}) {
    const auto t = load(file, "auto", wrap);
    for (const float u : {nan, inf, -inf, 1e30f, -1e30f, 3e9f, 1e-40f, -1e-9f, std::nextafter(1.0f, 0.0f)})
      for (const Vec2f& uv : {Vec2f(u, 0.3f), Vec2f(0.3f, u), Vec2f(u, u)}) {
        const Rgb c = t->rgb(uv);
        EXPECT_TRUE(is_finite(c) && max_component(c) <= 1.001f && c.r >= 0 && c.g >= 0 && c.b >= 0);
      }
    EXPECT_EQ(t->rgb({nan, inf}), t->rgb({0, 0}));
  }
}

TEST_F(TextureFile, AutoMeansSrgbForIntegersAndLinearForFloats) {
  const std::vector<float> grey(12, 0.5f);
  const float byte = std::round(0.5f * 255) / 255;
  EXPECT_NEAR(load(write("a8.png", 2, 2, 3, OIIO::TypeUInt8, grey))->texel(0, 0).r, srgb_to_linear(byte), 2e-4);
  EXPECT_NEAR(load(write("a16.png", 2, 2, 3, OIIO::TypeUInt16, grey))->texel(0, 0).r, srgb_to_linear(0.5f), 2e-4);
  EXPECT_NEAR(load(write("a16.tif", 2, 2, 3, OIIO::TypeUInt16, grey))->texel(0, 0).r, srgb_to_linear(0.5f), 2e-4);
  EXPECT_NEAR(load(write("a.jpg", 2, 2, 3, OIIO::TypeUInt8, grey))->texel(0, 0).r, srgb_to_linear(byte), 6e-3);
  EXPECT_EQ(load(write("a.exr", 2, 2, 3, OIIO::TypeHalf, grey))->texel(0, 0).r, 0.5f);
  EXPECT_NEAR(load(write("a.hdr", 2, 2, 3, OIIO::TypeFloat, grey))->texel(0, 0).r, 0.5f, 4e-3);
  EXPECT_EQ(load(write("af.tif", 2, 2, 3, OIIO::TypeFloat, grey))->texel(0, 0).r, 0.5f);
  // A named space overrules.
  EXPECT_NEAR(load(path("a8.png"), "raw")->texel(0, 0).r, byte, 3e-4);
  EXPECT_NEAR(load(path("a.exr"), "sRGB")->texel(0, 0).r, srgb_to_linear(0.5f), 2e-4);
  EXPECT_FALSE(load(path("a.exr"), "no such space"));
  EXPECT_NE(reports_.text().find("ACEScg"), std::string::npos) << reports_.text();
  EXPECT_EQ(reports_.all[0].where, path("a.exr"));
}

TEST_F(TextureFile, ChannelsOfEveryCount) {
  const auto grey = load(write("g.png", 1, 1, 1, OIIO::TypeUInt8, {1}), "raw");
  EXPECT_EQ(grey->texel(0, 0), Rgb(1));
  const auto grey_alpha = load(write("ga.png", 1, 1, 2, OIIO::TypeUInt8, {1, 0.2f}), "raw");
  EXPECT_EQ(grey_alpha->texel(0, 0), Rgb(1)) << "alpha is straight, as the file has it";
  const auto rgba = load(write("rgba.png", 1, 1, 4, OIIO::TypeUInt8, {1, 0, 1, 0}), "raw");
  EXPECT_EQ(rgba->texel(0, 0), Rgb(1, 0, 1)) << "colour survives where alpha is zero";

  // An EXR with other layers before and after the colour.
  OIIO::ImageSpec spec(1, 1, 6, OIIO::TypeFloat);
  spec.channelnames = {"R", "G", "B", "A", "N.X", "Z"};
  spec.alpha_channel = 3;
  const auto out = OIIO::ImageOutput::create("x.exr");
  const float pixel[6] = {0.125f, 0.25f, 0.5f, 0.75f, -1, 100};
  ASSERT_TRUE(out->open(path("layers.exr"), spec) && out->write_image(OIIO::TypeFloat, pixel) && out->close());
  const auto layers = load(path("layers.exr"));
  ASSERT_TRUE(layers) << reports_.text();
  EXPECT_EQ(layers->texel(0, 0), Rgb(0.125f, 0.25f, 0.5f));
}

// Bytes per texel, without palettes.
TEST_F(TextureFile, TexelsAreKeptAsSmallAsTheyGo) {
  constexpr size_t kTexels = 64 * 64, kPalette = 3 * 256 * 4;
  std::vector<float> grey = noise(kTexels), rgb = noise(3 * kTexels), rgba = noise(4 * kTexels), grey_as_rgb;
  for (const float g : grey) grey_as_rgb.insert(grey_as_rgb.end(), 3, g);
  const auto bytes = [&](const char* name, int channels, OIIO::TypeDesc format, const std::vector<float>& pixels,
                         const char* space) {
    const auto texture = load(write(name, 64, 64, channels, format, pixels), space);
    EXPECT_TRUE(texture) << reports_.text();
    return texture ? texture->memory_bytes() : 0;
  };
  EXPECT_EQ(bytes("1.png", 1, OIIO::TypeUInt8, grey, "auto"), kTexels + kPalette);
  EXPECT_EQ(bytes("2.png", 3, OIIO::TypeUInt8, grey_as_rgb, "auto"), kTexels + kPalette);
  EXPECT_EQ(bytes("3.png", 3, OIIO::TypeUInt8, rgb, "auto"), 3 * kTexels + kPalette);
  EXPECT_EQ(bytes("4.png", 4, OIIO::TypeUInt8, rgba, "raw"), 4 * kTexels + kPalette + 256 * 4);
  EXPECT_EQ(bytes("5.png", 1, OIIO::TypeUInt16, grey, "raw"), 4 * kTexels);
  EXPECT_EQ(bytes("6.exr", 3, OIIO::TypeHalf, rgb, "auto"), 6 * kTexels);
  EXPECT_EQ(bytes("7.exr", 4, OIIO::TypeFloat, rgba, "auto"), 16 * kTexels);
  EXPECT_EQ(bytes("8.hdr", 3, OIIO::TypeFloat, grey_as_rgb, "auto"), 2 * kTexels);
  EXPECT_EQ(bytes("9.png", 3, OIIO::TypeUInt8, rgb, "ACEScg"), 6 * kTexels) << "the conversion mixes channels";
}

// Whichever way texels are kept, they are what the conversion gives, rounded to halves.
TEST_F(TextureFile, BytesInAPaletteAreTheValuesOfHalves) {
  std::vector<float> values = noise(64 * 64 * 4), rounded;
  for (const float v : values) rounded.push_back(std::round(v * 255) / 255);
  // Grey first, then not: texels that were kept as bytes become halves on the way.
  std::fill_n(values.begin(), 8, 0.5f), std::fill_n(rounded.begin(), 8, 128 / 255.0f);
  for (const char* space : {"raw", "sRGB", "ACEScg"}) {
    const auto bytes = load(write("a.png", 64, 64, 4, OIIO::TypeUInt8, values), space);
    const auto floats = load(write("a.tif", 64, 64, 4, OIIO::TypeFloat, rounded), space);
    ASSERT_TRUE(bytes && floats) << reports_.text();
    for (int y = 0; y < 64; ++y)
      for (int x = 0; x < 64; ++x) {
        const Vec2f centre((float(x) + 0.5f) / 64, 1 - (float(y) + 0.5f) / 64);
        const Rgb color = floats->texel(x, y);
        ASSERT_EQ(bytes->texel(x, y), Rgb(half(color.r), half(color.g), half(color.b))) << space << x << "," << y;
        ASSERT_EQ(bytes->alpha(centre), half(floats->alpha(centre))) << space << x << "," << y;
      }
  }
}

TEST_F(TextureFile, LookupsAreTheSameInAStoreThatHoldsNoWholeImage) {
  const auto tight = std::make_shared<TexelStore>();
  tight->set_budget(0);
  for (const char* name : {"a.png", "a.exr"}) {
    const auto format = std::string(name) == "a.png" ? OIIO::TypeUInt8 : OIIO::TypeHalf;
    const std::string file = write(name, 300, 200, 4, format, noise(300 * 200 * 4));
    for (const Wrap wrap : {Wrap::repeat, Wrap::mirror, Wrap::clamp, Wrap::black}) {
      const TextureSource source{file, nullptr, "auto", wrap, wrap};
      const auto ample = load(source), paged = load_texture(source, *colors_, reports_.sink, {.store = tight});
      ASSERT_TRUE(ample && paged) << reports_.text();
      EXPECT_LT(paged->memory_bytes(), 5000u);
      std::mt19937 random(2);
      std::uniform_real_distribution<float> unit(-1, 2);
      for (int i = 0; i < 5000; ++i) {
        const Vec2f uv(unit(random), unit(random));
        ASSERT_EQ(ample->rgb(uv), paged->rgb(uv)) << uv;
        ASSERT_EQ(ample->alpha(uv), paged->alpha(uv)) << uv;
      }
    }
  }
}

TEST_F(TextureFile, DecodingThatIsCancelledKeepsAndReportsNothing) {
  const std::string file = write("cancelled.png", 40, 300, 3, OIIO::TypeUInt8, noise(40 * 300 * 3));
  const auto memory = std::make_shared<MemoryBudget>();
  const auto texels = std::make_shared<TexelStore>(reports_.sink, memory);
  std::atomic<bool> cancelled = true;
  const TextureLoading loading = {.store = texels, .cancel = CancelToken(&cancelled)};
  EXPECT_THROW(load_texture({file, nullptr, "auto"}, *colors_, reports_.sink, loading), BuildCancelled);
  EXPECT_EQ(memory->in_use(MemoryUse::textures), 0u);
  EXPECT_EQ(reports_.text(), "");
  cancelled = false;
  EXPECT_TRUE(load_texture({file, nullptr, "auto"}, *colors_, reports_.sink, loading));
}

TEST_F(TextureFile, TiledAndLargeImagesAreReadWhole) {
  constexpr int kWidth = 150, kHeight = 131;  // not a multiple of a tile or a strip
  std::vector<float> pixels(size_t(kWidth * kHeight * 3));
  for (size_t i = 0; i < pixels.size(); ++i) pixels[i] = float(i % 2048) / 2048;
  for (const char* name : {"tiled.exr", "tiled.tif", "strips.exr", "strips.png"}) {
    const bool tiled = std::string(name).starts_with("tiled"), png = std::string(name).ends_with("png");
    const auto t =
        load(write(name, kWidth, kHeight, 3, png ? OIIO::TypeUInt16 : OIIO::TypeFloat, pixels, tiled ? 64 : 0), "raw");
    ASSERT_TRUE(t) << name << reports_.text();
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth; ++x)
        ASSERT_NEAR(t->texel(x, y).g, pixels[size_t(3 * (y * kWidth + x) + 1)], 3e-4) << name << x << "," << y;
  }
}

TEST_F(TextureFile, EncodedBytesInMemoryGiveTheSameTexture) {
  std::vector<float> pixels(48);
  for (size_t i = 0; i < pixels.size(); ++i) pixels[i] = float(i) / 48;
  for (const char* name : {"m.png", "m.jpg", "m.exr", "m.tif", "m.webp"}) {
    const std::string file =
        write(name, 4, 4, 3, std::string(name) == "m.exr" ? OIIO::TypeHalf : OIIO::TypeUInt8, pixels);
    TextureSource source;
    source.path = "image 0 of scene.glb";
    source.bytes = std::make_shared<const std::vector<uint8_t>>(slurp(file));
    const auto memory = load(source);
    ASSERT_TRUE(memory) << name << reports_.text();
    const auto disk = load(file);
    for (int y = 0; y < 4; ++y)
      for (int x = 0; x < 4; ++x) EXPECT_EQ(memory->texel(x, y), disk->texel(x, y)) << name;
  }
  TextureSource none;
  none.path = "empty";
  none.bytes = std::make_shared<const std::vector<uint8_t>>();
  EXPECT_FALSE(load(none));
  EXPECT_EQ(reports_.all.size(), 1u);
  EXPECT_EQ(reports_.all[0].where, "empty");
}

TEST_F(TextureFile, TheContentsCountAndNotTheName) {
  const auto bytes = slurp(write("a.png", 2, 2, 3, OIIO::TypeUInt8, kQuad));
  const auto t = load(spit("really_a_png.jpg", bytes));
  ASSERT_TRUE(t) << reports_.text();
  EXPECT_EQ(t->texel(0, 0), Rgb(1, 0, 0));
}

}  // namespace
}  // namespace alabaster
