// Which channels of an EXR with parts and layers are the picture, and its windows.
#include "testenv/support/texture_file.h"

namespace alabaster {
namespace {

using testing::TextureFile;

struct Part {
  std::string name;
  std::vector<std::string> channels;
  std::vector<float> pixel;  // of all pixels
};

class ImageLayers : public TextureFile {
 protected:
  static constexpr int kWidth = 4, kHeight = 2;

  std::string write_parts(const std::vector<Part>& parts) const {
    std::vector<OIIO::ImageSpec> specs;
    for (const Part& part : parts) {
      OIIO::ImageSpec spec(kWidth, kHeight, int(part.channels.size()), OIIO::TypeFloat);
      spec.channelnames = part.channels;
      if (!part.name.empty()) spec.attribute("oiio:subimagename", part.name);
      specs.push_back(spec);
    }
    const std::string file = path("parts.exr");
    const auto out = OIIO::ImageOutput::create(file);
    EXPECT_TRUE(out->open(file, int(specs.size()), specs.data())) << out->geterror();
    for (size_t i = 0; i < parts.size(); ++i) {
      if (i > 0) {
        EXPECT_TRUE(out->open(file, specs[i], OIIO::ImageOutput::AppendSubimage)) << out->geterror();
      }
      std::vector<float> pixels;
      for (int p = 0; p < kWidth * kHeight; ++p)
        pixels.insert(pixels.end(), parts[i].pixel.begin(), parts[i].pixel.end());
      EXPECT_TRUE(out->write_image(OIIO::TypeFloat, pixels.data())) << out->geterror();
    }
    EXPECT_TRUE(out->close());
    return file;
  }
  /// The layer's colour; black if it is refused.
  Rgb color_of(const std::vector<Part>& parts, const std::string& layer = "") {
    TextureSource source;
    source.path = write_parts(parts), source.layer = layer;
    texture_ = load(source);
    return texture_ ? texture_->texel(1, 1) : Rgb(0.0f);
  }
  std::shared_ptr<const Texture> texture_;
};

const Part kDepth{"depth", {"Z"}, {7}};
const Part kNormals{"N", {"R", "G", "B"}, {0, 0, 1}};
const Part kPicture{"rgba", {"R", "G", "B", "A"}, {1, 0.5f, 0.25f, 0.125f}};
const Rgb kColor(1, 0.5f, 0.25f);

TEST_F(ImageLayers, ThePictureIsThePartThatIsCalledSo) {
  EXPECT_EQ(color_of({kDepth, kPicture}), kColor) << reports_.text();
  EXPECT_EQ(texture_->alpha({0.5f, 0.5f}), 0.125f);
  EXPECT_EQ(color_of({kDepth, kNormals, kPicture}), kColor) << reports_.text();
  EXPECT_EQ(color_of({kNormals, kDepth, {"left", kPicture.channels, kPicture.pixel}}), kColor) << reports_.text();
  EXPECT_EQ(color_of({kNormals, {"beauty", kPicture.channels, kPicture.pixel}}), kColor) << reports_.text();
}

TEST_F(ImageLayers, ThePictureIsTheLayerThatIsCalledSo) {
  EXPECT_EQ(color_of({{"", {"N.X", "N.Y", "N.Z", "beauty.R", "beauty.G", "beauty.B"}, {0, 0, 1, 1, 0.5f, 0.25f}}}),
            kColor);
  EXPECT_EQ(
      color_of({{"",
                 {"View Layer.Combined.R", "View Layer.Combined.G", "View Layer.Combined.B", "View Layer.Depth.Z"},
                 {1, 0.5f, 0.25f, 7}}}),
      kColor);
  EXPECT_EQ(color_of({{"", {"albedo.R", "albedo.G", "albedo.B", "R", "G", "B"}, {9, 9, 9, 1, 0.5f, 0.25f}}}), kColor);
  EXPECT_EQ(color_of({{"", {"Y", "Z"}, {0.5f, 7}}}), Rgb(0.5f)) << "luminance beside depth";
  EXPECT_EQ(color_of({{"", {"height"}, {3}}}), Rgb(3)) << "the only channel";
  EXPECT_EQ(color_of({{"", {"R", "G"}, {0.5f, 0.25f}}}), Rgb(0.5f, 0.25f, 0));
}

TEST_F(ImageLayers, WithoutAPictureAreNamedAndChosen) {
  const std::vector<Part> others = {kDepth, kNormals, {"diffuse", {"R", "G", "B"}, {0.5f, 0, 0}}};
  const std::vector<Part> layers = {
      {"", {"Z", "N.X", "N.Y", "N.Z", "diffuse.R", "diffuse.G", "diffuse.B"}, {7, 0, 0, 1, 0.5f, 0, 0}}};
  EXPECT_EQ(color_of(layers), Rgb(0.0f));
  EXPECT_FALSE(texture_);
  for (const char* const name : {"Z", "N", "diffuse", "'layer'"})
    EXPECT_NE(reports_.text().find(name), std::string::npos) << name << ": " << reports_.text();
  for (const auto& file : {others, layers}) {
    EXPECT_EQ(color_of(file, "N"), Rgb(0, 0, 1)) << reports_.text();
    EXPECT_EQ(color_of(file, "diffuse"), Rgb(0.5f, 0, 0)) << reports_.text();
    EXPECT_EQ(color_of(file, "Z"), Rgb(7)) << reports_.text();
    EXPECT_EQ(color_of(file, "gone"), Rgb(0.0f));
    EXPECT_NE(reports_.text().find("no layer 'gone'; it has"), std::string::npos) << reports_.text();
  }
  EXPECT_EQ(color_of({kDepth, {"", {"N.X", "N.Y", "N.Z"}, {0, 0, 1}}}), Rgb(0.0f)) << "depth and normals alone";
  EXPECT_FALSE(texture_);
}

TEST_F(ImageLayers, BelongToExr) {
  TextureSource source;
  source.path = write("a.png", 2, 2, 3, OIIO::TypeUInt8, testing::kQuad), source.layer = "diffuse";
  EXPECT_FALSE(load(source));
  EXPECT_NE(reports_.text().find("only an EXR has layers"), std::string::npos) << reports_.text();
}

/// Pieces of all parts before the one that is read, at several sizes.
TEST_F(ImageLayers, ArePlacedBehindThoseOfOtherSizes) {
  for (const int tile : {0, 16})
    for (const int width : {33, 64}) {
      std::vector<OIIO::ImageSpec> specs;
      for (const char* const name : {"depth", "rgba"}) {
        OIIO::ImageSpec spec(width, 40, 3, OIIO::TypeHalf);
        spec.attribute("oiio:subimagename", name);
        spec.tile_width = spec.tile_height = tile, spec.tile_depth = 1;
        specs.push_back(spec);
      }
      const std::vector<float> dark(size_t(width) * 40 * 3, 0.125f), bright(size_t(width) * 40 * 3, 0.5f);
      const auto out = OIIO::ImageOutput::create("x.exr");
      ASSERT_TRUE(out->open(path("x.exr"), 2, specs.data()) && out->write_image(OIIO::TypeFloat, dark.data()) &&
                  out->open(path("x.exr"), specs[1], OIIO::ImageOutput::AppendSubimage) &&
                  out->write_image(OIIO::TypeFloat, bright.data()) && out->close())
          << out->geterror();
      const auto texture = load(path("x.exr"));
      ASSERT_TRUE(texture) << reports_.text();
      for (int y = 0; y < 40; ++y) EXPECT_EQ(texture->texel(width - 1, y), Rgb(0.5f));
    }
}

// Windows -------------------------------------------------------------------------------------------
class ImageWindows : public TextureFile {
 protected:
  /// Pixel (x, y) of the data window has the colour of (x, y); the display window is 0, 0, `width`, `height`.
  std::string write_window(int left, int top, int right, int bottom, int width, int height, int tile) const {
    OIIO::ImageSpec spec(right - left, bottom - top, 4, OIIO::TypeFloat);
    spec.x = left, spec.y = top;
    spec.full_x = 0, spec.full_y = 0, spec.full_width = width, spec.full_height = height;
    spec.tile_width = spec.tile_height = tile, spec.tile_depth = 1;
    spec.channelnames = {"R", "G", "B", "A"};
    std::vector<float> pixels;
    for (int y = top; y < bottom; ++y)
      for (int x = left; x < right; ++x) pixels.insert(pixels.end(), {color(x, y).r, color(x, y).g, 1, 1});
    const auto out = OIIO::ImageOutput::create("x.exr");
    EXPECT_TRUE(out->open(path("x.exr"), spec) && out->write_image(OIIO::TypeFloat, pixels.data()) && out->close())
        << out->geterror();
    return path("x.exr");
  }
  static Rgb color(int x, int y) { return {float(x + 100), float(y + 100), 1}; }
};

TEST_F(ImageWindows, ThePictureIsTheDisplayWindow) {
  struct Window {
    int left, top, right, bottom;
  };
  constexpr int kWidth = 150, kHeight = 140;
  for (const Window& w : {Window{32, 8, 48, 16}, Window{-40, -70, 200, 190}, Window{-7, 90, 60, 200},
                          Window{100, -3, 151, 139}, Window{0, 0, kWidth, 1}})
    for (const int tile : {0, 32}) {
      const auto texture = load(write_window(w.left, w.top, w.right, w.bottom, kWidth, kHeight, tile));
      ASSERT_TRUE(texture) << reports_.text();
      ASSERT_EQ(texture->width(), kWidth);
      ASSERT_EQ(texture->height(), kHeight);
      for (int y = 0; y < kHeight; ++y)
        for (int x = 0; x < kWidth; ++x) {
          const bool is_inside = x >= w.left && x < w.right && y >= w.top && y < w.bottom;
          ASSERT_EQ(texture->texel(x, y), is_inside ? color(x, y) : Rgb(0.0f)) << x << " " << y << " tile " << tile;
          const Vec2f uv((float(x) + 0.5f) / kWidth, 1 - (float(y) + 0.5f) / kHeight);
          ASSERT_NEAR(texture->alpha(uv), is_inside ? 1 : 0, 1e-4f);
        }
    }
}

TEST_F(ImageWindows, DisjointWindowsAreRefused) {
  EXPECT_FALSE(load(write_window(200, 0, 210, 10, 100, 50, 0)));
  EXPECT_NE(reports_.text().find("outside of its display window"), std::string::npos) << reports_.text();
  EXPECT_FALSE(load(write_window(0, 0, 10, 10, 1 << 20, 1 << 20, 0)));
  EXPECT_NE(reports_.text().find("1048576 x 1048576 pixels"), std::string::npos) << reports_.text();
}

}  // namespace
}  // namespace alabaster
