#include "core/texture/environment_image.h"

#include <algorithm>
#include <cmath>

#include "core/math/largest_half.h"
#include "core/texture/cube_map.h"

namespace alabaster {
namespace {

class LatLongImage final : public ImageInput {
 public:
  explicit LatLongImage(std::unique_ptr<ImageInput> cube) : cube_(std::move(cube)) {
    const ImageLayout& faces = cube_->layout();
    const auto size = size_t(faces.width);
    layout_ = faces;
    layout_.width = int(4 * size), layout_.height = int(2 * size);
    layout_.channels = 3, layout_.rgb = {0, 1, 2}, layout_.alpha = {};
    layout_.bytes = layout_.halves = false;
    layout_.working_bytes += (6 + 8) * size * size * sizeof(Rgb) + size * 4 * sizeof(Rgb);
  }

  int read_rows(int y, ImageRows& to, std::string& fault) override {
    if (texels_.empty() && !read_cube(fault)) return 0;
    const auto width = size_t(layout_.width);
    to.floats.clear();
    for (size_t x = 0; x < width; ++x)
      for (int c = 0; c < 3; ++c) to.floats.push_back(texels_[size_t(y) * width + x][c]);
    return 1;
  }

 private:
  // The faces of y stand upside down in OpenEXR.
  bool read_cube(std::string& fault) {
    CubeMap cube;
    cube.size = size_t(cube_->layout().width);
    ImageRows rows;
    for (int y = 0; y < cube_->layout().height;) {
      const int count = cube_->read_rows(y, rows, fault);
      if (count == 0) return false;
      for (size_t i = 0; i < size_t(count) * cube.size; ++i)
        cube.faces[(size_t(y) + i / cube.size) / cube.size].push_back(color(rows, i));
      y += count;
    }
    for (const size_t face : {size_t(2), size_t(3)}) std::reverse(cube.faces[face].begin(), cube.faces[face].end());
    texels_ = to_lat_long(cube);
    return true;
  }
  Rgb color(const ImageRows& rows, size_t texel) const {
    const ImageLayout& layout = cube_->layout();
    const auto value = [&](size_t i) {
      const float v =
          layout.rgb[i] == ImageLayout::kNoChannel ? 0 : rows.floats[texel * layout.channels + layout.rgb[i]];
      return std::isnan(v) ? 0.0f : std::isinf(v) ? std::copysign(kLargestHalf, v) : v;
    };
    return {value(0), value(1), value(2)};
  }

  const std::unique_ptr<ImageInput> cube_;
  std::vector<Rgb> texels_;
};

}  // namespace

std::unique_ptr<ImageInput> as_lat_long(std::unique_ptr<ImageInput> cube, ImageFault* fault) {
  const ImageLayout& layout = cube->layout();
  if (layout.width > 0 && int64_t(layout.height) == 6 * int64_t(layout.width) && !layout.bytes)
    return std::make_unique<LatLongImage>(std::move(cube));
  *fault = {"texture.format", "its header calls it a cube, but it is not six times as high as wide; export it again"};
  return nullptr;
}

}  // namespace alabaster
