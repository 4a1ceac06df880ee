// Where samples are kept. Rows run DOWN (y-down, as data windows do); RenderBuffer::Resolve turns them bottom-up.
// A sample belongs to one pixel only (the pixel filter is importance-sampled), so no merge order exists to depend on.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "core/color/rgb.h"
#include "core/math/vector.h"

namespace alabaster {

/// What can be asked for. Averaged: color, alpha, normal, albedo, diffuse parts. Closest sample: depth and ids.
enum class Aov { color, alpha, depth, camera_depth, normal, albedo, prim_id, instance_id, element_id, sample_count };
inline constexpr int kAovCount = 10;
constexpr uint32_t aov_bit(Aov a) {
  return 1u << static_cast<uint32_t>(a);
}

/// "color", "depth", ... ; components per pixel (color 4: premultiplied RGBA); whether values are int32.
const char* aov_name(Aov a);
int aov_components(Aov a);
bool aov_is_integer(Aov a);
bool aov_from_name(const std::string& name, Aov* a);

/// Rectangle of pixels, y-down, half open.
struct PixelRect {
  int x0 = 0, y0 = 0, x1 = 0, y1 = 0;
  int width() const { return x1 - x0; }
  int height() const { return y1 - y0; }
  bool empty() const { return x1 <= x0 || y1 <= y0; }
  bool operator==(const PixelRect&) const = default;
};

/// What one camera sample brings.
struct FilmSample {
  Rgb color{0.0f};
  float alpha = 0;
  float distance = 0;      // to the first hit; infinity if none: decides which sample is closest
  float depth = 1;         // Hydra's 0..1 clip depth (1 = far, background)
  float camera_depth = 0;  // along -z, world units; 0 if no hit
  Vec3f normal{0, 0, 0};   // world, shading; 0 if no hit
  Rgb albedo{0.0f};
  int32_t prim_id = -1, instance_id = -1, element_id = -1;
};

/// Accumulators of one pixel.
struct FilmPixel {
  std::array<double, 4> color{};  // sum, premultiplied
  std::array<float, 3> normal{};  // sum
  std::array<float, 3> albedo{};  // sum
  float distance = 0, depth = 1, camera_depth = 0;
  int32_t prim_id = -1, instance_id = -1, element_id = -1;
  uint32_t samples = 0;

  void add(const FilmSample& s);
};

/// Accumulators of a data window, in tiles. Workers accumulate privately and store a tile at a time; readers copy a
/// tile at a time under that tile's lock: neither waits for a whole pass.
class Film {
 public:
  static constexpr int kTileSize = 32;
  explicit Film(const PixelRect& data_window);

  const PixelRect& data_window() const { return window_; }
  int tile_count() const { return tiles_x_ * tiles_y_; }
  PixelRect tile_rect(int tile) const;
  /// Pixels of a tile, row-major within tile_rect.
  void load_tile(int tile, std::vector<FilmPixel>* pixels) const;
  void store_tile(int tile, const std::vector<FilmPixel>& pixels);

  /// Resolved values of the whole window, row-major, y-down. Float AOVs: aov_components() floats per pixel.
  std::vector<float> resolve_float(Aov aov) const;
  std::vector<int32_t> resolve_int(Aov aov) const;

 private:
  PixelRect window_;
  int tiles_x_ = 0, tiles_y_ = 0;
  std::vector<std::vector<FilmPixel>> tiles_;
  mutable std::vector<std::mutex> locks_;
};

}  // namespace alabaster
