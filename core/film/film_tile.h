// Where the samples of a tile's pixels are summed. A sample belongs to one pixel only, because the pixel filter is
// importance-sampled. So tiles need no merging.
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <utility>
#include <vector>

#include "core/color/rgb.h"
#include "core/film/aov.h"
#include "core/film/id_counts.h"
#include "core/film/pixel_noise.h"
#include "core/film/sample_sum.h"
#include "core/math/vector.h"

namespace alabaster {

/// Samples of a pixel, by their numbers, half open.
struct SampleRange {
  uint32_t begin = 0, end = 0;
  bool operator==(const SampleRange&) const = default;
};

/// Planes of a film besides its AOVs.
struct FilmExtras {
  bool rays = false;  // the rays that each pixel has cost
  /// The samples that it is to get. Where they do not begin at 0 the film is a part of another one, and keeps what that
  /// needs to append() it. `end` counts for such a film only.
  SampleRange range;
  size_t light_groups = 0;  // that Aov::light_group shows
  bool operator==(const FilmExtras&) const = default;
};

/// Vectors of a sample's first hit, by their AOVs from eye_point on. Those that no AOV shows may be of another sample.
struct HitVectors {
  static constexpr size_t index(Aov aov) { return static_cast<size_t>(aov) - static_cast<size_t>(Aov::eye_point); }
  const std::array<float, 3>& of(Aov aov) const { return values[index(aov)]; }
  void set(Aov aov, const Vec3f& v) { values[index(aov)] = {v.x, v.y, v.z}; }
  static constexpr size_t kCount =
      static_cast<size_t>(primvar_aov(kMostPrimvarAovs)) - static_cast<size_t>(Aov::eye_point);
  std::array<std::array<float, 3>, kCount> values{};
};

/// The result of one camera sample. Values of the first hit keep their defaults where no bound AOV shows them.
struct FilmSample {
  Rgb color{0.0f};
  float alpha = 0;
  float distance = 0;         // to the first hit, infinity if none; the least decides which sample is closest
  float depth = 1;            // Hydra's 0..1 clip depth (1 = far, background)
  float camera_depth = 0;     // along -z, world units; 0 if no hit
  float camera_distance = 0;  // Camera::distance(); the same
  Vec3f normal{0, 0, 0};      // world, shading; 0 if no hit
  Rgb albedo{0.0f};
  float ambient_occlusion = 0;  // 1: nothing occludes
  int32_t prim_id = -1, instance_id = -1, element_id = -1, material_id = -1;
  int32_t matte = -1;        // that kPrimCountAovs count: the prim's, or its instance's
  bool is_held_out = false;  // by the surface of these ids, which counts for no id
  bool is_caught = false;    // by a shadow catcher, which gets this light of lights, shadowed and not:
  Rgb shadowed{0.0f}, unshadowed{0.0f};
  bool nonfinite = false;               // the colour was not finite, and was made black
  const HitVectors* vectors = nullptr;  // of a hit, where any of kVectorAovs is drawn
  const Rgb* light_groups = nullptr;    // by plane, where any is drawn (LightByGroup)
};

/// A sample's colour, split by how the light left the first surface that scattered it, and by how it came there: direct
/// from a light, or by way of other surfaces. The layers add up to color but for float rounding.
struct LightLayers {
  enum Part {
    kDirectDiffuse,  // by the diffuse and sheen lobes
    kIndirectDiffuse,
    kDirectSpecular,  // reflected by the specular and clearcoat lobes
    kIndirectSpecular,
    kTransmission,       // through a clear surface
    kDirectUnscattered,  // through the body below, without a scattering event
    kIndirectUnscattered,
    kDirectSingle,  // through the body, one scattering event
    kIndirectSingle,
    kDirectMultiple,  // through the body, two scattering events or more
    kIndirectMultiple,
    kSeen,  // seen directly: emissive surfaces, lights, the background
    kParts
  };
  std::array<Rgb, kParts> parts{};

  Rgb& operator[](Part part) { return parts[part]; }
  const Rgb& operator[](Part part) const { return parts[part]; }
  void add(const LightLayers& other, float share) {
    for (size_t i = 0; i < kParts; ++i) parts[i] += other.parts[i] * share;
  }
  void scale(float factor) {
    for (Rgb& light : parts) light *= factor;
  }

  // The layers that are sums.
  Rgb direct_subsurface() const { return parts[kDirectUnscattered] + parts[kDirectSingle] + parts[kDirectMultiple]; }
  Rgb indirect_subsurface() const {
    return parts[kIndirectUnscattered] + parts[kIndirectSingle] + parts[kIndirectMultiple];
  }
  Rgb diffuse() const { return parts[kDirectDiffuse] + parts[kIndirectDiffuse]; }
  Rgb specular() const { return parts[kDirectSpecular] + parts[kIndirectSpecular] + parts[kTransmission]; }
  Rgb unscattered() const { return parts[kDirectUnscattered] + parts[kIndirectUnscattered]; }
  Rgb single() const { return parts[kDirectSingle] + parts[kIndirectSingle]; }
  Rgb multiple() const { return parts[kDirectMultiple] + parts[kIndirectMultiple]; }
  Rgb subsurface() const { return unscattered() + single() + multiple(); }
  Rgb sum() const { return diffuse() + specular() + subsurface() + parts[kSeen]; }
};

/// A sample's colour, split by the group of the light where it began. The groups add up to color but for float
/// rounding.
class LightByGroup {
 public:
  /// `planes`: by the scene's number of a group, the plane of the film that shows it; kMostLightGroups: none does.
  explicit LightByGroup(std::vector<uint8_t> planes) : plane_of_(std::move(planes)) {}
  using Planes = std::array<Rgb, kMostLightGroups + 1>;  // the last takes what none shows
  void add(uint32_t group, const Rgb& light) { add(group, light, &light_); }
  void add(uint32_t group, const Rgb& light, Planes* to) const { (*to)[plane_of_[group]] += light; }
  void add(const Planes& lights, const Rgb& factor) {
    for (size_t i = 0; i < lights.size(); ++i) light_[i] += lights[i] * factor;
  }
  void scale(float factor) {
    for (Rgb& light : light_) light *= factor;
  }
  void clear() { light_.fill(Rgb(0.0f)); }
  const Rgb* planes() const { return light_.data(); }
  /// Black planes for the light at an entry of walks, until it is asked for the next one; a path and its branches have
  /// one entry at a time each.
  Planes* at_entry(bool of_branch) {
    entries_[of_branch].fill(Rgb(0.0f));
    return &entries_[of_branch];
  }

 private:
  std::vector<uint8_t> plane_of_;
  Planes light_{};
  std::array<Planes, 2> entries_{};
};

/// Accumulators of one tile. Only the planes that the requested AOVs need exist.
class FilmTile {
 public:
  /// Without pixels.
  FilmTile() = default;
  FilmTile(size_t pixels, AovSet aovs, const FilmExtras& extras = {});
  /// Takes all samples away, but keeps the memory.
  void clear();

  /// `pixel`: row-major within the tile. A pixel's samples must come in sample order, because its noise is that of the
  /// first half against the second. `layers`: null where none of kLayerAovs is requested. `rays`: that the sample took,
  /// counted if the tile does so.
  void add(size_t pixel, const FilmSample& sample, const LightLayers* layers = nullptr, uint32_t rays = 0);
  uint32_t rays(size_t pixel) const { return rays_[pixel]; }
  /// Adds the samples of a part that follow this tile's, which begin at 0. Both have the same shape and AOVs, and this
  /// tile has a sample. Every pixel has all samples of its range in both. The tile becomes, to the bit, what it were if
  /// it had got all samples itself.
  void append(const FilmTile& next);
  uint32_t samples(size_t pixel) const { return samples_[pixel]; }
  /// The number of the sample that comes next.
  uint32_t next_sample(size_t pixel) const { return begin_ + samples_[pixel]; }
  bool empty() const { return samples_.empty(); }
  /// The least and the most of a pixel; 0 without pixels.
  uint32_t least_samples() const;
  uint32_t most_samples() const;
  size_t pixels_without_sample() const { return samples_.size() - covered_; }
  /// Writes the components of `count` pixels: averages, or the values of the closest sample.
  void resolve(size_t pixel, Aov aov, float* out, size_t count = 1) const;
  void resolve_light_group(size_t pixel, size_t group, float* out, size_t count = 1) const;
  void resolve_int(size_t pixel, Aov aov, int32_t* out, size_t count = 1) const;
  /// Of an AOV of ids: the values of a pair of ranks (IdCounts::rank()).
  void resolve_ranks(size_t pixel, Aov aov, int pair, const IdKeys& keys, float* out, size_t count = 1) const;
  PixelNoise noise(size_t pixel) const;
  /// Replaces a pixel by that of another tile of the same shape, AOVs and extras.
  void take(size_t pixel, const FilmTile& from);
  /// Size of the accumulators that these AOVs and extras need.
  static size_t bytes_per_pixel(AovSet aovs, const FilmExtras& extras = {});

  /// The memory of all planes, for a checkpoint: it depends on the number of pixels, the AOVs and the extras alone.
  std::vector<std::span<std::byte>> planes();
  /// Those of the AOVs of ids, which take as many bytes as there are ids: a block of its own in a checkpoint.
  std::vector<IdCounts*> ids();
  /// Bytes that they take beside bytes_per_pixel().
  size_t more_id_bytes() const { return prims_.more_bytes() + materials_.more_bytes(); }
  const std::vector<uint32_t>& samples() const { return samples_; }
  /// To be called when the planes have been read from a file. False if they hold what no samples give.
  bool accept_planes();

 private:
  using UnitSums = std::vector<std::array<UnitSum, 3>>;
  struct LayerPlane {
    Aov aov;
    Rgb (*light)(const LightLayers&);
    std::vector<RgbSum> sums;
  };
  struct VectorPlane {
    Aov aov;
    std::vector<std::array<float, 3>> closest;
  };
  // A value of the closest sample. Each has a plane of its own: a buffer that shows one reads no other.
  template <class T>
  struct ClosestPlane {
    Aov aov;
    T FilmSample::*member;
    std::vector<T> values;
  };
  struct Halves {
    std::array<float, 3> first{};  // sum of color over the first m samples
    float latest = 0, previous = 0, earlier = 0;
  };
  // The sums of color at the powers of two that the number of a part's last sample reaches. The halves of a film need
  // the last four.
  static constexpr size_t kMostMarks = 4;
  static size_t count_marks(const SampleRange& range);
  size_t mark(size_t pixel, uint32_t power) const {
    return pixel * marks_per_pixel_ + static_cast<size_t>(std::countr_zero(power)) % marks_per_pixel_;
  }
  void compare_halves(size_t pixel);
  /// The sum whose noise is the pixel's: of color, and of the light on shadow catchers as if they were white surfaces.
  RgbSum light_sum(size_t pixel) const;
  double shadow_alpha(size_t pixel) const;
  void append_halves(size_t pixel, const FilmTile& next);
  void take_closest(size_t pixel, const FilmTile& from);

  size_t covered_ = 0;  // pixels that have samples
  uint32_t begin_ = 0;  // the first sample
  size_t marks_per_pixel_ = 0;
  std::vector<uint32_t> samples_;
  std::vector<RgbSum> color_;  // premultiplied
  std::vector<UnitSum> alpha_;
  UnitSums normal_, albedo_;
  std::vector<UnitSum> ambient_occlusion_;
  std::vector<uint32_t> caught_;  // samples that shadow catchers have met, and the sums of their light
  std::vector<RgbSum> shadowed_, unshadowed_;
  std::vector<Halves> halves_;
  std::vector<LayerPlane> layers_;  // those that are requested
  std::vector<std::vector<RgbSum>> light_groups_;
  std::vector<VectorPlane> vectors_;         // the same
  std::vector<float> distance_;              // to the closest sample, where any AOV shows that one
  std::vector<ClosestPlane<float>> depths_;  // those that are requested
  std::vector<ClosestPlane<int32_t>> ids_;   // the same
  IdCounts prims_, materials_;               // where an AOV of ids shows them
  std::vector<uint32_t> rays_, nonfinite_;
  std::vector<RgbSum> marks_;
};

}  // namespace alabaster
