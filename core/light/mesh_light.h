// The emissive triangles of a mesh.
// Units, frames, pdfs and the treatment of bad values, common to all lights: light_parameters.h, light.h.
#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "core/diagnostics/cancel.h"
#include "core/light/light_parameters.h"
#include "core/memory/memory_budget.h"
#include "core/sampling/distribution.h"

namespace alabaster {

/// Emissive triangles of one instance: one is chosen by area times luminance, then a point uniformly on it. Triangles
/// without area, with points that are not finite, or that emit nothing are never chosen.
class MeshLight {
 public:
  struct Triangle {
    Vec3f p0, p1, p2;        // render space
    Rgb radiance;            // negative or not finite counts as black; of a textured triangle the mean
    bool one_sided = false;  // emits only to the side from which it winds counter-clockwise
  };
  /// The radiance of a textured light at a point: of triangle `triangle_id`, p0 (1-b.x-b.y) + p1 b.x + p2 b.y.
  using Emission = std::function<Rgb(uint32_t triangle_id, const Vec2f& b)>;
  /// `triangle_ids[i]`: which triangle of the mesh `triangles[i]` is. Same length.
  /// `emission` empty: each triangle emits its radiance all over. Throws BuildCancelled.
  MeshLight(uint32_t instance, std::vector<Triangle> triangles, const std::vector<uint32_t>& triangle_ids,
            Emission emission = {}, const CancelToken& cancel = {});
  std::optional<LightSample> sample(const Vec3f& p, const Vec2f& u, const Vec3f& n = Vec3f(0, 0, 0)) const;
  /// pdf of sampling the point where a ray from `p` with unit `wi` met triangle `triangle_id` at distance t; 0 for
  /// triangles that are never chosen or not of this light.
  float pdf(uint32_t triangle_id, const Vec3f& wi, float t) const;
  double importance(const Vec3f& p) const;
  LightExtent extent() const;
  bool is_below(const Vec3f&, const Vec3f&) const { return false; }
  std::shared_ptr<const LightImage> image() const { return nullptr; }
  uint32_t instance() const { return instance_; }
  /// The same light as that of another instance. Copies share what they hold.
  MeshLight of_instance(uint32_t instance) const {
    MeshLight other = *this;
    other.instance_ = instance;
    return other;
  }
  /// On the heap.
  size_t memory_bytes() const;
  /// Bytes that making a light takes at most: of so many triangles, in a mesh of so many.
  static size_t build_bytes(size_t triangles, size_t of_mesh);
  /// Keeps what counts its memory; copies share it.
  void hold(MemoryReservation memory);

 private:
  struct Emitter {
    std::vector<Triangle> triangles;
    Emission emission;
    std::vector<uint32_t> triangle_ids;
    std::vector<uint32_t> index_of_triangle;  // mesh triangle -> entry, or ~0u
    Distribution1D distribution;              // by area times luminance
    double power = 0;                         // sum of area times luminance
    Vec3d center{0, 0, 0};                    // of the bounds of the triangles that give light
    double squared_radius = 0;

    void measure(const CancelToken& cancel);
    void index(const std::vector<uint32_t>& ids, const CancelToken& cancel);
    float pdf(size_t entry, const Vec3d& wi, double distance) const;
  };

  uint32_t instance_;
  std::shared_ptr<const Emitter> emitter_;
  std::shared_ptr<const MemoryReservation> memory_;
};

}  // namespace alabaster
