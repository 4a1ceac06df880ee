// Image files that a test writes, damages and loads as textures.
#pragma once

#include <OpenImageIO/imageio.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <random>

#include "core/texture/texture.h"
#include "testenv/support/reports.h"

namespace alabaster::testing {

class TextureFile : public ::testing::Test {
 protected:
  TextureFile() { std::filesystem::create_directories(folder_); }
  ~TextureFile() override { std::filesystem::remove_all(folder_); }

  std::string path(const std::string& name) const { return (folder_ / name).string(); }

  /// Writes `pixels` (floats, rows from the top) with `channels` channels in `format`.
  std::string write(const std::string& name, int width, int height, int channels, OIIO::TypeDesc format,
                    const std::vector<float>& pixels, int tile = 0) const {
    OIIO::ImageSpec spec(width, height, channels, format);
    spec.attribute("oiio:UnassociatedAlpha", 1);
    spec.tile_width = spec.tile_height = tile;
    if (tile > 0) spec.tile_depth = 1;
    const auto out = OIIO::ImageOutput::create(name);
    EXPECT_TRUE(out->open(path(name), spec) && out->write_image(OIIO::TypeFloat, pixels.data()) && out->close())
        << out->geterror();
    return path(name);
  }
  std::shared_ptr<const Texture> load(TextureSource source) {
    reports_.all.clear();
    return load_texture(source, *colors_, reports_.sink);
  }
  std::shared_ptr<const Texture> load(const std::string& file, const std::string& space = "auto",
                                      Wrap wrap = Wrap::repeat) {
    TextureSource source;
    source.path = file;
    source.color_space = space;
    source.wrap_s = source.wrap_t = wrap;
    return load(source);
  }
  static std::vector<uint8_t> slurp(const std::string& file) {
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }
  std::string spit(const std::string& name, const std::vector<uint8_t>& bytes) const {
    std::ofstream(path(name), std::ios::binary)
        .write(reinterpret_cast<const char*>(bytes.data()), std::streamsize(bytes.size()));
    return path(name);
  }

  std::filesystem::path folder_ =
      std::filesystem::temp_directory_path() / ("alabaster_texture_" + std::to_string(::getpid()));
  std::shared_ptr<const ColorConfig> colors_ = ColorConfig::load("built-in", {});
  Reports reports_;
};

/// A 2 x 2 picture: red, green / blue, white from the top left.
inline const std::vector<float> kQuad = {1, 0, 0, 0, 1, 0, 0, 0, 1, 1, 1, 1};

/// The same numbers at each call, in [0, 1).
inline std::vector<float> noise(size_t count) {
  std::mt19937 random(3);
  std::uniform_real_distribution<float> unit(0, 1);
  std::vector<float> values(count);
  for (float& v : values) v = unit(random);
  return values;
}

}  // namespace alabaster::testing
