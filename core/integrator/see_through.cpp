#include "core/integrator/see_through.h"

#include <cmath>

namespace alabaster {
namespace {

constexpr double kUnit = 0x1p32;
constexpr int64_t kBlack = int64_t(-200) << 32;  // below the smallest float

// As is_behind(), of a hit that a ray along `dir` has found: without a look at the triangle, which is far away.
bool is_found_behind(const Instance& instance, const TriangleHit& hit, const Vec3f& dir) {
  if (instance.stands_alone()) [[likely]]
    return dot(hit.normal, instance.world_to_object.vector(dir)) > 0;
  std::optional<Placement> moved;
  return dot(hit.normal, instance.at(hit, &moved).world_to_object.vector(dir)) > 0;
}

class LinkedTransmittance final : public HitFilter {
 public:
  LinkedTransmittance(const SceneSnapshot& scene, const Vec3f& dir, uint32_t shadow_link)
      : all_(scene, dir), scene_(scene), shadow_link_(shadow_link) {}
  bool stops(const TriangleHit& hit) const noexcept override {
    return scene_.casts_shadow(scene_.instance(hit.instance), shadow_link_) && all_.stops(hit);
  }
  float value() const { return all_.value(); }

 private:
  const Transmittance all_;
  const SceneSnapshot& scene_;
  const uint32_t shadow_link_;
};

}  // namespace

bool is_culled(const Instance& instance, const TriangleHit& hit, const Vec3f& dir) {
  return instance.camera_cull == CameraCull::all ||
         (instance.camera_cull != CameraCull::none &&
          is_found_behind(instance, hit, dir) == (instance.camera_cull == CameraCull::back));
}

float coverage_at(const SceneSnapshot& scene, const Vec3f& dir, const TriangleHit& hit) {
  const Instance& instance = scene.instance(hit.instance);
  if (!instance.see_through) return 1;
  const Mesh& mesh = instance.prototype->mesh;
  const DisneyMaterial& material = instance.material(hit.triangle);
  if (instance.single_sided && !material.is_translucent() && is_found_behind(instance, hit, dir)) return 0;
  if (!material.is_partly_opaque()) return 1;
  const Vec2f uv = mesh.uv_sets.empty() ? Vec2f(0, 0) : interpolated<Vec2f>(mesh.uv_sets.front(), mesh, hit);
  return material.coverage({mesh, hit, uv});
}

bool StochasticStop::stops(const TriangleHit& hit) const noexcept {
  if (depth_ == 0 && is_culled(scene_.instance(hit.instance), hit, dir_)) return false;
  const float coverage = coverage_at(scene_, dir_, hit);
  if (coverage <= 0 || coverage >= 1) return coverage >= 1;
  const uint32_t number = sampler_.number(Dimension::opacity, depth_);
  return to_unit_float(hash_combine(hash_combine(number, hit.instance), hit.triangle)) < coverage;
}

bool Transmittance::stops(const TriangleHit& hit) const noexcept {
  const float coverage = coverage_at(scene_, dir_, hit);
  if (coverage >= 1) return true;
  if (coverage > 0) log_ += static_cast<int64_t>(std::llrint(std::log2(1.0 - double(coverage)) * kUnit));
  return log_ < kBlack;
}

float Transmittance::value() const {
  return log_ == 0 ? 1.0f : static_cast<float>(std::exp2(static_cast<double>(log_) / kUnit));
}

float linked_visibility(const SceneSnapshot& scene, const Ray& ray, uint32_t shadow_link) {
  const LinkedTransmittance transmittance(scene, ray.dir, shadow_link);
  return scene.top->occluded(ray, &transmittance) ? 0.0f : transmittance.value();
}

}  // namespace alabaster
