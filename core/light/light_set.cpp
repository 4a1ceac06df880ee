#include "core/light/light_set.h"

#include <algorithm>
#include <cmath>

namespace alabaster {

LightSet::LightSet(std::vector<Light> lights, Traits traits, size_t sample_all_up_to)
    : sample_all_(lights.size() <= sample_all_up_to),
      lights_(std::move(lights)),
      visible_to_camera_(std::move(traits.visible_to_camera)) {
  visible_to_camera_.resize(lights_.size(), true);
  const auto is_linked = [](uint32_t link) { return link != 0; };
  if (std::any_of(traits.shadow_links.begin(), traits.shadow_links.end(), is_linked)) {
    shadow_links_ = std::move(traits.shadow_links);
    shadow_links_.resize(lights_.size(), 0);
  }
  if (std::any_of(traits.scales.begin(), traits.scales.end(), [](const LobeScales& s) { return s != LobeScales(); })) {
    scales_ = std::move(traits.scales);
    scales_.resize(lights_.size());
  }
  if (std::any_of(traits.groups.begin(), traits.groups.end(), [](uint32_t group) { return group != 0; })) {
    groups_ = std::move(traits.groups);
    groups_.resize(lights_.size(), 0);
  }
  has_traits_ = !shadow_links_.empty() || !scales_.empty() || !groups_.empty();
  for (uint32_t i = 0; i < lights_.size(); ++i) {
    const Light& light = lights_[i];
    if (const auto* mesh = std::get_if<MeshLight>(&light))
      mesh_light_of_instance_.emplace_back(mesh->instance(), i);
    else if (!shadow_links_.empty() && shadow_links_[i] != 0)
      shadow_linked_.push_back(i);
    else
      (is_infinite(i) ? infinite_ : finite_).push_back(i);
    if (is_constant_dome(light)) constant_domes_.push_back(i);
  }
  if (!sample_all_ && lights_.size() > kMostWeighed && lights_.size() < size_t(1) << 24)
    tree_ = LightTree(lights_, scales_);
  std::sort(mesh_light_of_instance_.begin(), mesh_light_of_instance_.end());
}

std::optional<LightSample> LightSet::sample(const Vec3f& p, float u_light, const Vec2f& u, const Vec3f& n,
                                            float time) const {
  if (constant_domes_.size() == lights_.size()) return std::nullopt;
  const auto chosen =
      tree_.empty() ? LightChoice(lights_, scales_, p).choose(u_light) : tree_.choose(lights_, p, u_light);
  if (!chosen) return std::nullopt;
  auto s = sample_light(chosen->index, p, u, n, time);
  if (s) s->pdf *= chosen->probability;
  return s;
}

std::optional<LightSample> LightSet::sample_light(size_t i, const Vec3f& p, const Vec2f& u, const Vec3f& n,
                                                  float time) const {
  auto s = std::visit(
      [&](const auto& light) {
        if constexpr (std::is_same_v<std::decay_t<decltype(light)>, MovingLight>)
          return light.sample(p, u, n, time);
        else
          return light.sample(p, u, n);
      },
      lights_[i]);
  if (has_traits_ && s) [[unlikely]] {
    if (!shadow_links_.empty()) s->shadow_link = shadow_links_[i];
    if (!scales_.empty()) s->scales = &scales_[i];
    if (!groups_.empty()) s->group = groups_[i];
  }
  if (!constant_domes_.empty() && s) s->of_constant_dome = is_constant_dome(lights_[i]);
  return s;
}

std::optional<Vec2f> LightSet::leading_dome_numbers(const Vec3f& p, const std::array<float, 4>& u) const {
  if (constant_domes_.empty()) return std::nullopt;
  const auto importance = [&](size_t i) {
    const double weight = std::visit([&](const auto& light) { return light.importance(p); }, lights_[i]);
    return scales_.empty() ? weight : weight * scales_[i].mean();
  };
  const uint32_t dome = constant_domes_.front();
  double others = 0;
  if (tree_.empty()) {
    for (size_t i = 0; i < lights_.size(); ++i)
      if (i != dome) others += importance(i);
  } else {
    others = tree_.importance(lights_, p);
    for (size_t k = 1; k < constant_domes_.size(); ++k) others += importance(constant_domes_[k]);
  }
  if (!(importance(dome) >= others)) return std::nullopt;
  return sample_all_ ? shifted({u[1], u[2]}, dome) : dome_numbers(0, u);
}

bool LightSet::is_below(size_t i, const Vec3f& p, const Horizon& horizon) const {
  const auto is_below = [&](const auto& light) {
    return light.is_below(p, horizon[0]) || light.is_below(p, horizon[1]);
  };
  return std::visit(is_below, lights_[i]);
}

std::optional<LightHit> LightSet::intersect(size_t i, const Ray& ray, const Vec3f& n) const {
  return std::visit(
      [&](const auto& light) -> std::optional<LightHit> {
        if constexpr (std::is_same_v<std::decay_t<decltype(light)>, MeshLight>)
          return std::nullopt;
        else
          return light.intersect(ray, n);
      },
      lights_[i]);
}

size_t LightSet::memory_bytes() const {
  size_t bytes = lights_.capacity() * sizeof(Light) + tree_.memory_bytes();
  for (const Light& light : lights_) {
    if (const auto image = image_of(light)) bytes += image->memory_bytes();
    if (const auto* mesh = std::get_if<MeshLight>(&light)) bytes += mesh->memory_bytes();
  }
  return bytes;
}

float LightSet::mesh_light_pdf(const Ray& ray, float t, uint32_t instance, uint32_t triangle) const {
  const auto found = std::lower_bound(mesh_light_of_instance_.begin(), mesh_light_of_instance_.end(),
                                      std::pair<uint32_t, uint32_t>(instance, 0));
  if (found == mesh_light_of_instance_.end() || found->first != instance) return 0;
  const float pdf = std::get<MeshLight>(lights_[found->second]).pdf(triangle, ray.dir, t);
  if (!(pdf > 0) || sample_all_) return pdf;
  return pdf * choice_probability(found->second, ray.org);
}

}  // namespace alabaster
