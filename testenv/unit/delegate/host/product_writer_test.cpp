#include <OpenImageIO/imageio.h>
#include <gtest/gtest.h>
#include <half.h>

#include <cmath>
#include <fstream>
#include <limits>

#include "testenv/unit/delegate/host/product_fixture.h"

namespace alabaster::hd::host {
namespace {

struct Read {
  OIIO::ImageSpec spec;
  std::vector<float> pixels;
  explicit Read(const std::string& file) {
    OIIO::ImageSpec config;
    config["oiio:UnassociatedAlpha"] = 1;
    const auto in = OIIO::ImageInput::open(file, &config);
    EXPECT_TRUE(in) << OIIO::geterror();
    if (!in) return;
    spec = in->spec();
    pixels.resize(size_t(spec.image_pixels()) * size_t(spec.nchannels));
    EXPECT_TRUE(in->read_image(0, 0, 0, spec.nchannels, OIIO::TypeFloat, pixels.data())) << in->geterror();
  }
  float at(int pixel, const std::string& channel) const {
    const int c = spec.channelindex(channel);
    EXPECT_GE(c, 0) << channel;
    return c < 0 ? NAN : pixels[size_t(pixel * spec.nchannels + c)];
  }
  OIIO::TypeDesc type(const std::string& channel) const { return spec.channelformat(spec.channelindex(channel)); }
};

/// The names of a PNG's chunks of colour before its pixels, cICP with its bytes.
std::string tags_of(const std::string& file) {
  std::ifstream stream(file, std::ios::binary);
  const std::string bytes((std::istreambuf_iterator<char>(stream)), {});
  const auto number = [&](size_t at) {
    uint32_t value = 0;
    for (size_t i = 0; i < 4; ++i) value = value << 8 | uint8_t(bytes.at(at + i));
    return value;
  };
  std::string tags;
  for (size_t at = 8; bytes.compare(at + 4, 4, "IDAT") != 0; at += 12 + number(at)) {
    const std::string name = bytes.substr(at + 4, 4);
    if (name == "cICP")
      for (size_t i = 0; i < 4; ++i) tags += (i == 0 ? "cICP " : "") + std::to_string(uint8_t(bytes[at + 8 + i])) + " ";
    if (name == "iCCP" || name == "sRGB" || name == "gAMA" || name == "cHRM") tags += name;
  }
  return tags;
}

std::vector<uint32_t> read_uints(const std::string& file, const std::string& channel) {
  const auto in = OIIO::ImageInput::open(file);
  const int c = in->spec().channelindex(channel);
  std::vector<uint32_t> values(size_t(in->spec().image_pixels()));
  EXPECT_TRUE(in->read_image(0, 0, c, c + 1, OIIO::TypeUInt32, values.data()));
  return values;
}

// promise: pipeline.aov.color, pipeline.format.exr, pipeline.name.layers
TEST_F(ProductFile, ExrHoldsEveryAovUnderItsUsualName) {
  RenderProduct p = product("all.exr");
  p.vars = all_vars();
  const ProductImage image = frame();
  ASSERT_TRUE(check(p)) << text();
  ASSERT_TRUE(write(p, image)) << text();
  EXPECT_EQ(listing(), std::vector<std::string>{"all.exr"});
  const Read exr(p.file);
  EXPECT_EQ(exr.spec.nchannels, 16);
  for (int i = 0; i < kCount; ++i) {
    const auto value = [&](const char* aov, int c) { return float_of(image, aov, i, c); };
    // Halves are the floats rounded to half, bit for bit; floats are unchanged.
    const char* rgba[] = {"R", "G", "B", "A"};
    for (int c = 0; c < 4; ++c) ASSERT_EQ(exr.at(i, rgba[c]), float(half(value("color", c))));
    const char* xyz[] = {"N.X", "N.Y", "N.Z"};
    const char* albedo[] = {"albedo.R", "albedo.G", "albedo.B"};
    for (int c = 0; c < 3; ++c) {
      ASSERT_EQ(exr.at(i, xyz[c]), float(half(value("normal", c))));
      ASSERT_EQ(exr.at(i, albedo[c]), float(half(value("albedo", c))));
    }
    ASSERT_EQ(exr.at(i, "depth.Z"), value("depth", 0));
    ASSERT_EQ(exr.at(i, "Z"), i == 0 ? 1e10f : value("cameraDepth", 0)) << "0: nothing was hit";
  }
  EXPECT_EQ(exr.type("R"), OIIO::TypeHalf);
  EXPECT_EQ(exr.type("Z"), OIIO::TypeFloat);
  for (const char* id : {"primId", "instanceId", "elementId"}) {
    const auto read = read_uints(p.file, std::string(id) + ".X");
    for (int i = 0; i < kCount; ++i)
      ASSERT_EQ(int32_t(read[size_t(i)]), image.aovs.at(id).ints[index_of(image, id, i)]) << id;
  }
  EXPECT_EQ(read_uints(p.file, "primId.X")[0], 4294967295u);
  EXPECT_EQ(exr.type("sampleCount.X"), OIIO::TypeFloat);
  EXPECT_EQ(exr.at(3, "sampleCount.X"), 70003);
}

// promise: pipeline.format.exr
TEST_F(ProductFile, ExrFloatAndNamedLayers) {
  RenderProduct p = product("f.exr");
  p.dataType = "float";
  p.vars = {
      {"beauty", "color", "half"}, {"Zdepth", "depth", "float"}, {"ids", "primId", "float"}, {"", "normal", "half"}};
  const ProductImage image = frame();
  ASSERT_TRUE(write(p, image)) << text();
  const Read exr(p.file);
  for (int i = 0; i < kCount; ++i) {
    ASSERT_EQ(exr.at(i, "beauty.G"), float_of(image, "color", i, 1));
    ASSERT_EQ(exr.at(i, "Zdepth.Z"), float_of(image, "depth", i, 0));
    ASSERT_EQ(exr.at(i, "N.X"), float_of(image, "normal", i, 0));
  }
  EXPECT_EQ(exr.at(0, "ids.X"), -1.0f);
}

// promise: pipeline.name.attributes
TEST_F(ProductFile, ExrWindowsAndMetadata) {
  RenderProduct p = product("m.exr");
  ProductImage image = frame();
  image.framing.pixelAspectRatio = 2;
  image.incomplete = true;
  image.metadata = {{"alabaster/samples", 64},
                    {"alabaster/seconds", 1.25},
                    {"alabaster/exposure", 0.5f},
                    {"alabaster/rays", int64_t(5000000000)},
                    {"alabaster/seed", uint32_t(4000000000u)},
                    {"alabaster/scene", "a scene.glb"},
                    {"alabaster/camera", Path("/cameras/main")},
                    {"alabaster/crop", Vec2i(3, 4)},
                    {"alabaster/transform", Matrix4d().setTranslation(Vec3d(1, 2, 3))},
                    {"capDate", "2024:02:29 12:34:56"},
                    {"compression", "rle"},
                    {"oiio:ColorSpace", "Linear"}};
  ::testing::internal::CaptureStdout();
  ::testing::internal::CaptureStderr();
  ASSERT_TRUE(write(p, image)) << text();
  EXPECT_EQ(::testing::internal::GetCapturedStderr() + ::testing::internal::GetCapturedStdout(), "");
  const OIIO::ImageSpec spec = Read(p.file).spec;
  EXPECT_EQ(spec.x, 3);
  EXPECT_EQ(spec.y, -2);
  EXPECT_EQ(spec.width, kWidth);
  EXPECT_EQ(spec.height, kHeight);
  EXPECT_EQ(spec.full_x, 0);
  EXPECT_EQ(spec.full_width, 20);
  EXPECT_EQ(spec.full_height, 10);
  EXPECT_EQ(spec.get_float_attribute("PixelAspectRatio"), 2);
  EXPECT_EQ(spec.get_int_attribute("alabaster/samples"), 64);
  EXPECT_EQ(spec.get_float_attribute("alabaster/seconds"), 1.25f);
  EXPECT_EQ(spec.get_float_attribute("alabaster/exposure"), 0.5f);
  EXPECT_EQ(spec.get_string_attribute("alabaster/rays"), "5000000000");
  EXPECT_EQ(spec.get_string_attribute("alabaster/seed"), "4000000000");
  EXPECT_EQ(spec.get_string_attribute("alabaster/scene"), "a scene.glb");
  EXPECT_EQ(spec.get_string_attribute("alabaster/camera"), "/cameras/main");
  EXPECT_EQ(spec.get_string_attribute("DateTime"), "2024:02:29 12:34:56");
  EXPECT_EQ(spec.get_string_attribute("Software"), "Alabaster 0.1.0");
  EXPECT_EQ(spec.get_string_attribute("compression"), "none") << "metadata does not steer the writer";
  EXPECT_EQ(spec.get_int_attribute("alabaster/incomplete"), 1);
  EXPECT_EQ(spec.get_string_attribute("colorSpace"), "Linear Rec.709");
  const auto* xy = spec.find_attribute("chromaticities");
  ASSERT_TRUE(xy);
  EXPECT_FLOAT_EQ(static_cast<const float*>(xy->data())[0], 0.64f);
  EXPECT_FLOAT_EQ(static_cast<const float*>(xy->data())[6], 0.3127f);
  const auto* matrix = spec.find_attribute("alabaster/transform");
  ASSERT_TRUE(matrix);
  EXPECT_EQ(matrix->type().aggregate, OIIO::TypeDesc::MATRIX44);
}

TEST_F(ProductFile, ExrInAnotherSpaceIsConvertedAndSaysSo) {
  RenderProduct p = product("acescg.exr");
  p.colorSpace = "ACEScg";
  p.dataType = "float";
  ProductImage image = frame();
  image.aovs["color"] = floats(4, [](int, int c) { return c == 0 ? 1.0f : c == 3 ? 0.5f : 0.0f; });
  ASSERT_TRUE(write(p, image)) << text();
  const Read exr(p.file);
  EXPECT_NEAR(exr.at(0, "R"), 0.6131f, 2e-4f);  // AP1 of Rec.709 red, Bradford-adapted
  EXPECT_EQ(exr.at(0, "A"), 0.5f);
  EXPECT_EQ(exr.spec.get_string_attribute("colorSpace"), "ACEScg");
  EXPECT_FLOAT_EQ(static_cast<const float*>(exr.spec.find_attribute("chromaticities")->data())[0], 0.713f);
}

float srgb(float v) {
  return v <= 0.0031308f ? 12.92f * v : 1.055f * std::pow(v, 1 / 2.4f) - 0.055f;
}

// The picture is the same with and without somebody waiting for it, and for each of several at once.
TEST_F(ProductFile, IncompleteImagesHoldTheSamePixelsUncompressed) {
  ProductImage image = frame();
  const std::vector<RenderProduct> whole{product("a.exr"), product("a.png")}, hasty{product("b.exr"), product("b.png")};
  EXPECT_EQ(WriteProducts(whole, image, colors_, sink_), (std::vector<std::string>{whole[0].file, whole[1].file}));
  image.incomplete = true;
  EXPECT_EQ(WriteProducts(hasty, image, colors_, sink_), (std::vector<std::string>{hasty[0].file, hasty[1].file}));
  EXPECT_EQ(text(), "");
  for (size_t i = 0; i < 2; ++i) EXPECT_EQ(Read(whole[i].file).pixels, Read(hasty[i].file).pixels);
  EXPECT_EQ(Read(whole[0].file).spec.get_string_attribute("compression"), "zip");
  EXPECT_EQ(Read(hasty[0].file).spec.get_string_attribute("compression"), "none");
}

// promise: pipeline.format.compression
TEST_F(ProductFile, AnExrIsCompressedAsItsProductSays) {
  const ProductImage image = frame();
  ASSERT_TRUE(write(product("a.exr"), image)) << text();
  const Read usual(path("a.exr"));
  for (const std::string name : {"none", "rle", "zip", "zips", "piz", "pxr24", "b44", "b44a", "dwaa", "dwab"}) {
    RenderProduct p = product(name + ".exr");
    p.compression = name;
    ASSERT_TRUE(write(p, image)) << text();
    const Read exr(p.file);
    EXPECT_EQ(exr.spec.get_string_attribute("compression"), name);
    const bool keeps_halves = name[0] != 'b' && name[0] != 'd';
    EXPECT_TRUE(!keeps_halves || exr.pixels == usual.pixels) << name;
  }
}

// Threads of OpenEXR compress the tiles, and end in any order.
// promise: pipeline.format.tiles
TEST_F(ProductFile, TilesOfAnExrHaveTheSameBytesEachTime) {
  constexpr Vec2i kSize{301, 203};
  ProductImage image = frame();
  image.metadata["capDate"] = "2024:02:29 12:34:56";  // else the time of writing
  image.framing.dataWindow = {-5, 7, -5 + kSize.x, 7 + kSize.y};
  image.aovs = {{"color", floats(
                              4, [](int i, int c) { return float((i * (c + 3)) % 1013) / 64; }, kSize)},
                {"depth", floats(
                              1, [](int i, int) { return 1 + float(i) * 1e-3f; }, kSize)}};
  RenderProduct p = product("scanlines.exr");
  p.vars = {UsualRenderVar("color"), UsualRenderVar("depth")};
  ASSERT_TRUE(write(p, image)) << text();
  const Read scanlines(p.file);
  EXPECT_EQ(scanlines.spec.tile_width, 0);
  p.tiles = 16;
  std::string first;
  for (int i = 0; i < 8; ++i) {
    p.file = path("tiles.exr");
    ASSERT_TRUE(write(p, image)) << text();
    std::ifstream stream(p.file, std::ios::binary);
    const std::string bytes((std::istreambuf_iterator<char>(stream)), {});
    if (i == 0) first = bytes;
    EXPECT_TRUE(bytes == first) << i;
  }
  const Read tiles(p.file);
  EXPECT_EQ(tiles.spec.tile_width, 16);
  EXPECT_EQ(tiles.spec.tile_height, 16);
  EXPECT_EQ(tiles.spec.x, -5);
  EXPECT_TRUE(tiles.pixels == scanlines.pixels);
}

TEST_F(ProductFile, ValidProductsAreWrittenBesideInvalidOnes) {
  RenderProduct bad = product("none/b.exr");
  EXPECT_EQ(WriteProducts({product("a.exr"), bad, product("c.tif")}, frame(), colors_, sink_),
            (std::vector<std::string>{path("a.exr"), path("c.tif")}));
  ASSERT_EQ(reports_.size(), 1u) << text();
  EXPECT_EQ(reports_[0].where, bad.file);
}

// promise: pipeline.format.jpg, pipeline.format.png_tif
TEST_F(ProductFile, IntegerFilesGoThroughTheView) {
  const ProductImage image = frame();
  for (const char* name : {"v.png", "v.tif", "v.tiff", "v.jpg", "v.jpeg", "V.PNG"})
    for (const char* type : {"", "uint16"}) {
      RenderProduct p = product(name);
      p.view = "Un-tone-mapped";
      p.dataType = type;
      const bool jpeg = p.file.find(".jp") != std::string::npos;
      if (jpeg && *type) continue;
      ASSERT_TRUE(write(p, image)) << text();
      const Read read(p.file);
      ASSERT_EQ(read.spec.nchannels, jpeg ? 3 : 4);
      EXPECT_EQ(read.spec.format, *type ? OIIO::TypeUInt16 : OIIO::TypeUInt8);
      EXPECT_EQ(read.spec.x, 0);
      // One level of dither in 8 bits, half a level in 16; JPEG at quality 95 loses a few levels on smooth ramps.
      const float tolerance = jpeg ? 12.0f / 255 : *type ? 0.6f / 65535 + 1e-5f : 1.01f / 255;
      for (int i = 0; i < kCount; ++i)
        for (int c = 0; c < 3; ++c) {
          const float linear = std::min(float_of(image, "color", i, c), 1.0f);
          ASSERT_NEAR(read.pixels[size_t(i * read.spec.nchannels + c)], srgb(linear), tolerance) << name << type;
        }
      EXPECT_TRUE(jpeg || read.at(0, "A") == 1);
    }
}

TEST_F(ProductFile, TheDefaultViewOfAPngIsToneMapped) {
  ProductImage image = frame();
  image.aovs["color"] = floats(3, [](int, int) { return 2.0f; });
  RenderProduct p = product("d.png");
  ASSERT_TRUE(write(p, image)) << text();
  const Read png(p.file);
  EXPECT_EQ(png.spec.nchannels, 3) << "no alpha was rendered";
  EXPECT_GT(png.pixels[0], 0.8f);
  EXPECT_LT(png.pixels[0], 0.99f) << "twice the white of paper is not clipped by ACES";
  EXPECT_NE(png.spec.get_string_attribute("ImageDescription").find("colorSpace: sRGB / ACES"), std::string::npos);
  p.exposure = -4;
  ASSERT_TRUE(write(p, image)) << text();
  EXPECT_LT(Read(p.file).pixels[0], 0.5f);
}

// promise: pipeline.format.jpg
TEST_F(ProductFile, PngHasStraightAlphaAndJpegIsOverBlack) {
  ProductImage image = frame();
  image.aovs["color"] = floats(4, [](int i, int c) { return i == 0 ? 0.0f : c == 3 ? 0.25f : 0.125f; });  // 0.5 * 0.25
  RenderProduct p = product("a.png");
  p.view = "Un-tone-mapped";
  p.dataType = "uint16";
  for (const char* name : {"a.png", "a.tif"}) {
    p.file = path(name);
    ASSERT_TRUE(write(p, image)) << text();
    const Read read(p.file);
    EXPECT_NEAR(read.at(5, "R"), srgb(0.5f), 1e-4f) << name;
    EXPECT_NEAR(read.at(5, "A"), 0.25f, 1e-4f) << "alpha is not a colour";
    EXPECT_EQ(read.at(0, "A"), 0);
    EXPECT_EQ(read.at(0, "R"), 0);
  }
  p.file = path("a.jpg");
  p.dataType = "";
  ASSERT_TRUE(write(p, image)) << text();
  EXPECT_NEAR(Read(p.file).at(kCount - 1, "G"), srgb(0.125f), 0.03f);
}

TEST_F(ProductFile, DitherKeepsTheMeanAndIsTheSameEveryTime) {
  ProductImage image;
  image.framing.displayMax = {64, 64};
  image.framing.dataWindow = {0, 0, 64, 64};
  image.aovs["color"] = floats(3, [](int, int) { return 0.2f; }, {64, 64});
  RenderProduct p = product("d.png");
  p.view = "Un-tone-mapped";
  ASSERT_TRUE(write(p, image)) << text();
  const Read first(p.file);
  double sum = 0;
  for (const float v : first.pixels) sum += double(v);
  // A level's fraction f is a Bernoulli variable: sigma of the mean over n is sqrt(f (1 - f) / n) <= 0.5 / sqrt(n).
  const double n = double(first.pixels.size());
  EXPECT_NEAR(sum / n, double(srgb(0.2f)), 4 * 0.5 / 255 / std::sqrt(n) + 1e-5);
  ASSERT_TRUE(write(p, image));
  EXPECT_EQ(Read(p.file).pixels, first.pixels);
  // Exact levels get no dither: black and white are flat.
  for (const float level : {0.0f, 1.0f}) {
    image.aovs["color"] = floats(3, [&](int, int) { return level; }, {64, 64});
    p.view = "Raw";
    ASSERT_TRUE(write(p, image));
    for (const float v : Read(p.file).pixels) ASSERT_EQ(v, level);
  }
}

TEST_F(ProductFile, WildPixelsGiveAWholeFile) {
  const float nan = std::numeric_limits<float>::quiet_NaN(), inf = std::numeric_limits<float>::infinity();
  const float wild[] = {nan, inf, -inf, 1e30f, -1e30f, 1e-40f, 0.5f};
  ProductImage image = frame();
  image.aovs["color"] = floats(4, [&](int i, int c) { return wild[(i + c) % 7]; });
  for (const char* name : {"w.png", "w.tif", "w.jpg", "w.exr"}) {
    ASSERT_TRUE(write(product(name), image)) << name << text();
    const Read read(path(name));
    for (size_t i = 0; i < read.pixels.size(); ++i) {
      const bool is_exr_alpha = std::string(name) == "w.exr" && i % 4 == 3;
      ASSERT_TRUE(is_exr_alpha || std::isfinite(read.pixels[i])) << name << i;
    }
  }
  EXPECT_EQ(Read(path("w.exr")).at(3, "R"), 65504);
}

TEST_F(ProductFile, SingleAovsInIntegerFiles) {
  const ProductImage image = frame();
  RenderProduct p = product("albedo.tif");
  p.vars = {{"albedo", "albedo", "half"}};
  p.colorSpace = "raw";
  p.dataType = "uint16";
  ASSERT_TRUE(write(p, image)) << text();
  EXPECT_NEAR(Read(p.file).pixels[30], 30.0f / 128, 1e-5f);
  p = product("alpha.png");
  p.vars = {{"alpha", "alpha", "half"}};
  ASSERT_TRUE(write(p, image)) << text();
  EXPECT_EQ(Read(p.file).pixels, std::vector<float>(kCount, 1.0f));
}

class TaggedPng : public ProductFile {
 protected:
  /// What a PNG of that view says of its space, and "warning" if a report says that it cannot.
  std::string tags(const std::string& display, const std::string& view) {
    RenderProduct p = product("display.png");
    p.display = display, p.view = view;
    EXPECT_TRUE(check(p)) << text();
    const std::string said = text();
    EXPECT_TRUE(write(p, frame())) << text();
    EXPECT_EQ(Read(p.file).spec.width, kWidth);
    return tags_of(p.file) + (said.find("take it for sRGB") == std::string::npos ? "" : "warning");
  }
};

// promise: pipeline.colour.tags
TEST_F(TaggedPng, APngSaysItsDisplay) {
  EXPECT_EQ(tags("sRGB", "ACES"), "");
  EXPECT_EQ(tags("", ""), "");
  EXPECT_EQ(tags("P3-D65", "ACES"), "warning");
  EXPECT_EQ(tags("Rec.709", "Un-tone-mapped"), "warning");
  EXPECT_EQ(tags("Rec.2100-PQ", "ACES"), "cICP 9 16 0 1 ");
  for (const char* display : {"sRGB", "P3-D65"}) EXPECT_EQ(tags(display, "Raw"), "warning");
}

// Spaces are recognised by their values, under any name.
TEST_F(TaggedPng, APngOfAStudiosDisplaySaysItsSpace) {
  const std::string file = path("studio.ocio");
  std::ofstream(file) << R"(ocio_profile_version: 2
roles: {default: lin, scene_linear: lin, cie_xyz_d65_interchange: XYZ}
displays:
  Grading suite: [!<View> {name: V, view_transform: plain, display_colorspace: suite}]
  P3: [!<View> {name: V, view_transform: plain, display_colorspace: <USE_DISPLAY_NAME>}]
  Odd: [!<View> {name: V, view_transform: plain, display_colorspace: odd}]
  Old: [!<View> {name: V, colorspace: filmic sRGB}, !<View> {name: W, colorspace: filmic}]
view_transforms:
  - !<ViewTransform> {name: plain, from_scene_reference: !<MatrixTransform> {}}
display_colorspaces:
  - !<ColorSpace> {name: XYZ}
  - !<ColorSpace> {name: suite, from_display_reference: !<BuiltinTransform> {style: DISPLAY - CIE-XYZ-D65_to_REC.2100-HLG-1000nit}}
  - !<ColorSpace> {name: P3, to_display_reference: !<BuiltinTransform> {style: DISPLAY - CIE-XYZ-D65_to_ST2084-P3-D65, direction: inverse}}
  - !<ColorSpace> {name: odd, from_display_reference: !<ExponentTransform> {value: [1.7, 1.7, 1.7, 1], direction: inverse}}
colorspaces:
  - !<ColorSpace> {name: lin}
  - !<ColorSpace> {name: filmic sRGB, from_scene_reference: !<ExponentTransform> {value: 2, direction: inverse}}
  - !<ColorSpace> {name: filmic, from_scene_reference: !<ExponentTransform> {value: 2, direction: inverse}}
)";
  colors_ = {file};
  EXPECT_EQ(tags("Grading suite", "V"), "cICP 9 18 0 1 ");
  EXPECT_EQ(tags("P3", "V"), "cICP 12 16 0 1 ");
  EXPECT_EQ(tags("Odd", "V"), "warning");
  EXPECT_EQ(tags("Old", "V"), "");
  EXPECT_EQ(tags("Old", "W"), "warning");
}

TEST_F(ProductFile, ATiffOrJpegThatCannotSayItsDisplayIsReported) {
  for (const char* name : {"a.tif", "a.jpg"}) {
    RenderProduct p = product(name);
    EXPECT_TRUE(check(p));
    EXPECT_EQ(text(), "");
    p.display = "Rec.2100-PQ";
    EXPECT_TRUE(check(p));
    EXPECT_EQ(reports_.size(), 1u);
    EXPECT_NE(text().find("write a .png file"), std::string::npos) << text();
  }
}

}  // namespace
}  // namespace alabaster::hd::host
