#include "core/light/light_set.h"

#include <algorithm>

namespace alabaster {
namespace {

// Share of the samples that goes to the uniform choice. Defensive mixing (Hesterberg 1995): an estimator has at most
// 1/(1-share) times the second moment it would have by power alone, and 1/share times that of a uniform choice.
constexpr double kUniformShare = 0.25;

std::vector<float> choice_weights(const std::vector<Light>& lights, float scene_radius) {
  std::vector<double> powers;
  double total = 0;
  size_t shining = 0;
  for (const Light& light : lights) {
    powers.push_back(std::visit([&](const auto& l) { return static_cast<double>(l.power(scene_radius)); }, light));
    total += powers.back();
    shining += powers.back() > 0 ? 1 : 0;
  }
  std::vector<float> weights;
  for (double power : powers)
    weights.push_back(power > 0 ? static_cast<float>((1 - kUniformShare) * power / total +
                                                     kUniformShare / static_cast<double>(shining))
                                : 0.0f);
  return weights;
}

}  // namespace

LightSet::LightSet(std::vector<Light> lights, std::vector<bool> visible_to_camera, float scene_radius)
    : lights_(std::move(lights)), visible_to_camera_(std::move(visible_to_camera)) {
  visible_to_camera_.resize(lights_.size(), true);
  const bool usable = std::isfinite(scene_radius) && scene_radius > 0;
  choice_ = Distribution1D(choice_weights(lights_, usable ? scene_radius : 1));
  has_power_ = choice_.sum() > 0;
  for (size_t i = 0; i < lights_.size(); ++i)
    if (const auto* mesh = std::get_if<MeshLight>(&lights_[i]))
      mesh_light_of_instance_.emplace_back(mesh->instance(), static_cast<uint32_t>(i));
  std::sort(mesh_light_of_instance_.begin(), mesh_light_of_instance_.end());
}

std::optional<LightSample> LightSet::sample(const Vec3f& p, float u_light, const Vec2f& u) const {
  if (!has_power_) return std::nullopt;
  const auto chosen = choice_.sample(u_light);
  auto s = std::visit([&](const auto& light) { return light.sample(p, u); }, lights_[chosen.index]);
  if (s) s->pdf *= choice_.probability(chosen.index);
  return s;
}

std::optional<LightHit> LightSet::intersect(size_t i, const Ray& ray) const {
  return std::visit(
      [&](const auto& light) -> std::optional<LightHit> {
        if constexpr (std::is_same_v<std::decay_t<decltype(light)>, MeshLight>)
          return std::nullopt;
        else
          return light.intersect(ray);
      },
      lights_[i]);
}

float LightSet::mesh_light_pdf(uint32_t instance, uint32_t triangle, const Vec3f& wi, float t) const {
  const auto found = std::lower_bound(mesh_light_of_instance_.begin(), mesh_light_of_instance_.end(),
                                      std::pair<uint32_t, uint32_t>(instance, 0));
  if (found == mesh_light_of_instance_.end() || found->first != instance) return 0;
  return std::get<MeshLight>(lights_[found->second]).pdf(triangle, wi, t) * choice_probability(found->second);
}

}  // namespace alabaster
