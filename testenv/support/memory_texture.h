// A texture of given texels, for tests of its users. Repeats in u and v, bilinear.
#pragma once

#include <cmath>
#include <utility>
#include <vector>

#include "core/texture/texture.h"

namespace alabaster::testing {

class MemoryTexture : public Texture {
 public:
  /// Rows from the top, `width` texels each.
  MemoryTexture(int width, std::vector<Rgb> texels)
      : width_(width), height_(static_cast<int>(texels.size()) / width), texels_(std::move(texels)) {}

  Rgb rgb(const Vec2f& uv) const override {
    const float x = uv.x * static_cast<float>(width_) - 0.5f, y = (1 - uv.y) * static_cast<float>(height_) - 0.5f;
    const float fx = x - std::floor(x), fy = y - std::floor(y);
    const int x0 = static_cast<int>(std::floor(x)), y0 = static_cast<int>(std::floor(y));
    return lerp(lerp(wrapped(x0, y0), wrapped(x0 + 1, y0), fx), lerp(wrapped(x0, y0 + 1), wrapped(x0 + 1, y0 + 1), fx),
                fy);
  }
  int width() const override { return width_; }
  int height() const override { return height_; }
  size_t memory_bytes() const override { return texels_.size() * sizeof(Rgb); }
  Rgb texel(int x, int y) const override { return texels_[static_cast<size_t>(y * width_ + x)]; }

 private:
  Rgb wrapped(int x, int y) const { return texel((x % width_ + width_) % width_, (y % height_ + height_) % height_); }
  int width_, height_;
  std::vector<Rgb> texels_;
};

}  // namespace alabaster::testing
