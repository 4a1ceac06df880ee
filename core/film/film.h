// Where samples are kept. Rows run DOWN (y-down, as data windows do); RenderBuffer::Resolve turns them bottom-up.
// A sample belongs to one pixel only (the pixel filter is importance-sampled), so no merge order exists to depend on.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <limits>
#include <mutex>
#include <string>
#include <vector>

#include "core/color/rgb.h"
#include "core/film/pixel_noise.h"
#include "core/math/vector.h"

namespace alabaster {

/// What can be asked for. Averaged: color, alpha, normal, albedo, the layers of light. Closest sample: depth and ids.
enum class Aov {
  color,
  alpha,
  depth,
  camera_depth,
  normal,
  albedo,
  prim_id,
  instance_id,
  element_id,
  sample_count,
  diffuse,  // from here on layers: see LightLayers
  subsurface,
  subsurface_single,
  subsurface_multiple,
  subsurface_unscattered,
  specular,
  emission,
  error  // of color: PixelNoise::deviation()
};
inline constexpr int kAovCount = 18;
constexpr uint32_t aov_bit(Aov a) {
  return 1u << static_cast<uint32_t>(a);
}
/// The AOVs that need LightLayers.
inline constexpr uint32_t kLayerAovs = aov_bit(Aov::diffuse) | aov_bit(Aov::subsurface) |
                                       aov_bit(Aov::subsurface_single) | aov_bit(Aov::subsurface_multiple) |
                                       aov_bit(Aov::subsurface_unscattered) | aov_bit(Aov::specular) |
                                       aov_bit(Aov::emission);

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

/// A sample's color by what sent the light to the camera. The layers add up to color but for float rounding.
struct LightLayers {
  Rgb diffuse{0.0f};      // scattered at the first surface by its diffuse and sheen lobes
  Rgb specular{0.0f};     // by its specular and clearcoat lobes
  Rgb unscattered{0.0f};  // came through the body from the first surface without scattering in it,
  Rgb single{0.0f};       // with one scattering event,
  Rgb multiple{0.0f};     // with two or more
  Rgb emission{0.0f};     // seen directly: emissive surfaces, lights, the background
};

/// Accumulators of one tile. Only the planes that the requested AOVs need exist.
class FilmTile {
 public:
  FilmTile() = default;
  FilmTile(size_t pixels, uint32_t aovs);

  /// `pixel`: row-major within the tile. Order matters to the last bit: one tile's samples come in sample order.
  /// A pixel's samples must be those of one PixelSampler, from index 0 on. `layers` of the sample: null where none of
  /// kLayerAovs was asked for.
  void add(size_t pixel, const FilmSample& sample, const LightLayers* layers = nullptr);
  uint32_t samples(size_t pixel) const { return samples_[pixel]; }
  /// aov_components() values of a pixel: averages, or what the closest sample brought.
  void resolve(size_t pixel, Aov aov, float* out) const;
  int32_t resolve_int(size_t pixel, Aov aov) const;
  PixelNoise noise(size_t pixel) const;
  /// What another tile of the same shape and planes has gathered there.
  void take(size_t pixel, const FilmTile& from);
  /// Of the accumulators that these AOVs need.
  static size_t bytes_per_pixel(uint32_t aovs);

 private:
  using Sums = std::vector<std::array<double, 3>>;
  struct LayerPlane {
    Aov aov;
    Sums sums;
  };
  struct Closest {
    float distance = std::numeric_limits<float>::infinity(), depth = 1, camera_depth = 0;
    int32_t prim_id = -1, instance_id = -1, element_id = -1;
  };
  struct Halves {
    std::array<float, 3> first{};  // sum of color over the first m samples
    float latest = 0, previous = 0, earlier = 0;
  };
  void compare_halves(size_t pixel);

  std::vector<uint32_t> samples_;
  std::vector<std::array<double, 4>> color_;  // sums, premultiplied
  Sums normal_, albedo_;
  std::vector<Halves> halves_;
  std::vector<LayerPlane> layers_;  // those that were asked for
  std::vector<Closest> closest_;
};

/// Bytes of a Film of this window, but for a few per tile: known before it is allocated.
size_t film_bytes(const PixelRect& data_window, uint32_t aovs);

/// Accumulators of a data window, in tiles. Workers accumulate privately and store a tile at a time; readers copy a
/// tile at a time under that tile's lock: neither waits for a whole pass.
class Film {
 public:
  static constexpr int kTileSize = 32;
  /// `aovs`: bits of Aov. Color and alpha are always kept.
  Film(const PixelRect& data_window, uint32_t aovs);

  const PixelRect& data_window() const { return window_; }
  uint32_t aovs() const { return aovs_; }
  int tile_count() const { return tiles_x_ * tiles_y_; }
  PixelRect tile_rect(int tile) const;
  FilmTile load_tile(int tile) const;
  void store_tile(int tile, FilmTile pixels);
  /// Grows with every tile that is stored: equal numbers show equal pixels; 0: nothing yet. Any thread.
  uint64_t revision() const { return revision_.load(); }

  /// Resolved values of the whole window, row-major, y-down; aov_components() values per pixel. An AOV that was not
  /// asked for resolves to its background value.
  std::vector<float> resolve_float(Aov aov) const;
  std::vector<int32_t> resolve_int(Aov aov) const;
  std::vector<PixelNoise> noise() const;

 private:
  template <class T, class Write>
  std::vector<T> resolve_tiles(int components, const Write& write) const;

  PixelRect window_;
  uint32_t aovs_ = 0;
  int tiles_x_ = 0, tiles_y_ = 0;
  std::atomic<uint64_t> revision_{0};
  std::vector<FilmTile> tiles_;
  mutable std::vector<std::mutex> locks_;
};

}  // namespace alabaster
