// Where samples are kept. Rows run down (y-down, as data windows do); RenderBuffer::Resolve turns them bottom-up.
// A sample belongs to one pixel only, because the pixel filter is importance-sampled. So tiles need no merging.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <mutex>
#include <span>
#include <vector>

#include "core/color/rgb.h"
#include "core/film/aov.h"
#include "core/film/pixel_noise.h"
#include "core/math/vector.h"

namespace alabaster {

/// Rectangle of pixels, y-down, half open.
struct PixelRect {
  int x0 = 0, y0 = 0, x1 = 0, y1 = 0;
  int width() const { return x1 - x0; }
  int height() const { return y1 - y0; }
  bool empty() const { return x1 <= x0 || y1 <= y0; }
  bool operator==(const PixelRect&) const = default;
};

/// The result of one camera sample. Values of the first hit keep their defaults where no bound AOV shows them.
struct FilmSample {
  Rgb color{0.0f};
  float alpha = 0;
  float distance = 0;      // to the first hit, infinity if none; the least decides which sample is closest
  float depth = 1;         // Hydra's 0..1 clip depth (1 = far, background)
  float camera_depth = 0;  // along -z, world units; 0 if no hit
  Vec3f normal{0, 0, 0};   // world, shading; 0 if no hit
  Rgb albedo{0.0f};
  int32_t prim_id = -1, instance_id = -1, element_id = -1;
};

/// A sample's colour, split by how the light left the first surface. The layers add up to color but for float rounding.
struct LightLayers {
  Rgb diffuse{0.0f};      // scattered by the diffuse and sheen lobes
  Rgb specular{0.0f};     // scattered by the specular and clearcoat lobes
  Rgb unscattered{0.0f};  // through the body below, without a scattering event
  Rgb single{0.0f};       // through the body, one scattering event
  Rgb multiple{0.0f};     // through the body, two scattering events or more
  Rgb emission{0.0f};     // seen directly: emissive surfaces, lights, the background
};

/// Accumulators of one tile. Only the planes that the requested AOVs need exist.
class FilmTile {
 public:
  FilmTile() = default;
  FilmTile(size_t pixels, uint32_t aovs);

  /// `pixel`: row-major within the tile. A pixel's samples must come in sample order, from index 0 of one sampler on:
  /// sums depend on the order in the last bit. `layers`: null where none of kLayerAovs is requested.
  void add(size_t pixel, const FilmSample& sample, const LightLayers* layers = nullptr);
  uint32_t samples(size_t pixel) const { return samples_[pixel]; }
  /// Writes a pixel's components: averages, or the values of the closest sample.
  void resolve(size_t pixel, Aov aov, float* out) const;
  int32_t resolve_int(size_t pixel, Aov aov) const;
  PixelNoise noise(size_t pixel) const;
  /// Replaces a pixel by that of another tile of the same shape and AOVs.
  void take(size_t pixel, const FilmTile& from);
  /// Size of the accumulators that these AOVs need.
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
  std::vector<LayerPlane> layers_;  // those that are requested
  std::vector<Closest> closest_;
};

/// Bytes that a Film of this window will take, but for a few per tile.
size_t film_bytes(const PixelRect& data_window, uint32_t aovs);

/// Accumulators of a data window, in tiles. Workers add samples to a private copy of a tile and store it; readers copy
/// a tile at a time. Each holds the lock of that tile only, so neither waits for a whole pass. All const functions, and
/// store_tile(), may be called from any thread.
class Film {
 public:
  static constexpr int kTileSize = 32;
  /// `aovs`: bits of Aov. Color and alpha are always there.
  Film(const PixelRect& data_window, uint32_t aovs);

  const PixelRect& data_window() const { return window_; }
  uint32_t aovs() const { return aovs_; }
  int tile_count() const { return tiles_x_ * tiles_y_; }
  PixelRect tile_rect(int tile) const;
  FilmTile load_tile(int tile) const;
  void store_tile(int tile, const FilmTile& pixels);
  /// Sets the red, green and blue of AOV `denoised`, row-major, which until then is color.
  void store_denoised(std::vector<float> rgb);
  /// Rises with each store: as long as it stays the same, so do the pixels.
  uint64_t revision() const { return revision_.load(); }

  /// Takes a row of a tile: the resolved values of the pixels from (x, y) rightwards, component by component.
  template <class T>
  using TakeRow = std::function<void(int x, int y, std::span<const T> values)>;
  /// Resolves the window tile by tile, without a copy of the frame. `take` is called under the tile's lock. An AOV that
  /// is not requested resolves to its background value.
  void resolve_float(Aov aov, const TakeRow<float>& take) const;
  void resolve_int(Aov aov, const TakeRow<int32_t>& take) const;
  /// The same values as one frame, row-major, y-down.
  std::vector<float> resolve_float(Aov aov) const;
  std::vector<int32_t> resolve_int(Aov aov) const;
  /// Runs on all threads of the caller's TBB arena.
  std::vector<PixelNoise> noise() const;

 private:
  template <class T, class Resolve>
  void resolve_rows(int components, const Resolve& resolve, const TakeRow<T>& take) const;
  void resolve_denoised(const TakeRow<float>& take) const;
  template <class T>
  TakeRow<T> copy_to(std::vector<T>* frame, int components) const;

  PixelRect window_;
  uint32_t aovs_ = 0;
  int tiles_x_ = 0, tiles_y_ = 0;
  std::atomic<uint64_t> revision_{0};
  std::vector<FilmTile> tiles_;
  mutable std::vector<std::mutex> locks_;
  mutable std::mutex denoised_lock_;
  std::shared_ptr<const std::vector<float>> denoised_;
};

}  // namespace alabaster
