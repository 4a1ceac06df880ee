// A set of images as one texture. Internal to this room.
#pragma once

#include <cmath>
#include <map>
#include <utility>

#include "core/texture/texture.h"

namespace alabaster {

/// Images by the unit square of uv that each covers. Black and transparent where there is none.
class UdimTexture final : public Texture {
 public:
  /// At least one; none null. They are clamped at their edges: no texel of a neighbour is looked at.
  explicit UdimTexture(std::map<std::pair<int, int>, std::shared_ptr<const Texture>> tiles) : tiles_(std::move(tiles)) {
    for (const auto& [place, tile] : tiles_)
      width_ = std::max(width_, tile->width()), height_ = std::max(height_, tile->height());
  }

  Rgb rgb(const Vec2f& uv) const override {
    const Place at = find(uv);
    return at.tile ? at.tile->rgb(at.uv) : Rgb(0.0f);
  }
  Rgb filtered(const Vec2f& uv, float width) const override {
    const Place at = find(uv);
    if (!at.tile) return Rgb(0.0f);
    return at.tile->filtered(at.uv, width * static_cast<float>(at.tile->width()) / static_cast<float>(width_));
  }
  float alpha(const Vec2f& uv) const override {
    const Place at = find(uv);
    return at.tile ? at.tile->alpha(at.uv) : 0;
  }
  bool is_set() const override { return true; }
  bool covers(const Vec2f& uv) const override { return find(uv).tile != nullptr; }
  bool prepare_filtering(const CancelToken& cancel) const override {
    for (const auto& [place, tile] : tiles_)
      if (!tile->prepare_filtering(cancel)) return false;
    return true;
  }
  std::shared_ptr<const Texture> placed(const TextureSource& source) const override {
    TextureSource one = source;
    one.wrap_s = one.wrap_t = Wrap::clamp;
    std::map<std::pair<int, int>, std::shared_ptr<const Texture>> tiles;
    for (const auto& [place, tile] : tiles_) tiles[place] = tile->placed(one);
    return std::make_shared<UdimTexture>(std::move(tiles));
  }
  // The size of the largest tile.
  int width() const override { return width_; }
  int height() const override { return height_; }
  size_t memory_bytes() const override {
    size_t bytes = 0;
    for (const auto& [place, tile] : tiles_) bytes += tile->memory_bytes();
    return bytes;
  }
  Rgb texel(int x, int y) const override { return tiles_.begin()->second->texel(x, y); }
  void add_to(Digest* digest) const override {
    for (const auto& [place, tile] : tiles_) {
      digest->add(place.first);
      digest->add(place.second);
      tile->add_to(digest);
    }
  }

 private:
  struct Place {
    const Texture* tile;
    Vec2f uv;  // in it
  };
  // A point on the border of two squares belongs to the one that has an image.
  Place find(const Vec2f& uv) const {
    if (!(std::abs(uv.x) < 1e4f && std::abs(uv.y) < 1e4f)) return {nullptr, uv};
    const Vec2f corner(std::floor(uv.x), std::floor(uv.y));
    for (int left = 0; left <= (uv.x == corner.x); ++left)
      for (int below = 0; below <= (uv.y == corner.y); ++below) {
        const Vec2f at(corner.x - static_cast<float>(left), corner.y - static_cast<float>(below));
        const auto found = tiles_.find({static_cast<int>(at.x), static_cast<int>(at.y)});
        if (found != tiles_.end()) return {found->second.get(), uv - at};
      }
    return {nullptr, uv};
  }

  std::map<std::pair<int, int>, std::shared_ptr<const Texture>> tiles_;
  int width_ = 0, height_ = 0;
};

}  // namespace alabaster
