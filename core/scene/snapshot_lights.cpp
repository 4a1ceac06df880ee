#include "core/scene/snapshot_lights.h"

#include <algorithm>
#include <map>
#include <utility>

#include "core/scene/mesh_lights.h"
#include "core/scene/world_placement.h"

namespace alabaster {
namespace {

constexpr size_t kSampleAllUpTo = 4;

bool has_no_size(const LightParameters& d) {
  if (d.type == LightType::rect) return d.width == 0 || d.height == 0;
  return (d.type == LightType::disk && d.radius == 0) ||
         (d.type == LightType::cylinder && (d.radius == 0 || d.length == 0));
}

// True if the light can be placed. Says why one gives no light.
bool is_usable(const LightParameters& d, const DiagnosticSink& sink, std::vector<std::string>* left_out) {
  const auto all_poses = [&](const auto& holds) {
    return holds(d.light_to_world) && std::all_of(d.poses.begin(), d.poses.end(), holds);
  };
  const bool near = all_poses([](const Matrix4d& m) { return is_within_reach(m); });
  if (near && all_poses([](const Matrix4d& m) { return is_valid_affine(m); })) {
    if (d.intensity != 0 && has_no_size(d))
      report(sink, Severity::warning, "light.size", d.name, "a light of size zero gives no light; give it a size");
    return true;
  }
  report(sink, near ? Severity::warning : Severity::error, "light.transform", d.name,
         near ? "the transform is not invertible: the light is left out; check its scale"
              : "the transform is not finite, or goes beyond 1e17: the light is left out; move it nearer");
  if (!near) left_out->push_back(d.name);
  return false;
}

// A category that nothing is in.
uint32_t category_of_nothing(const SceneDescription& scene) {
  uint32_t last = 0;
  for (const LightParameters& light : scene.lights) last = std::max({last, light.light_link, light.shadow_link});
  for (const auto& set : scene.category_sets)
    if (!set.empty()) last = std::max(last, set.back());
  return last + 1;
}

class LightCompiler {
 public:
  LightCompiler(const LightSources& sources, SceneSnapshot* snapshot) : sources_(sources), snapshot_(snapshot) {}

  bool run() {
    std::vector<std::shared_ptr<const LightImage>> images;
    const auto keep_image = [&](const Light& light) {
      auto image = image_of(light);
      if (image && std::find(images.begin(), images.end(), image) == images.end()) images.push_back(std::move(image));
    };
    if (sources_.last)
      for (const Light& light : sources_.last->lights.lights()) keep_image(light);
    std::vector<Light> lights;
    LightSet::Traits traits;
    std::vector<uint32_t> light_links;
    const uint32_t nothing = category_of_nothing(sources_.description);
    for (const auto& d : sources_.description.lights) {
      if (!is_usable(d, sources_.sink, &snapshot_->left_out)) continue;
      in_name_of(d.name, [&] {
        lights.push_back(make_light(d, snapshot_->origin, {images, sources_.cancel, memory_of(*sources_.device)}));
      });
      keep_image(lights.back());
      snapshot_->features.motion |= std::holds_alternative<MovingLight>(lights.back());
      traits.visible_to_camera.push_back(d.visible_to_camera);
      traits.shadow_links.push_back(d.shadow_enable ? d.shadow_link : nothing);
      traits.scales.push_back({d.diffuse, d.specular});
      traits.groups.push_back(d.group);
      snapshot_->features.lobe_scales |= traits.scales.back() != LobeScales();
      light_links.push_back(d.light_link);
      snapshot_->features.visible_background |= d.type == LightType::dome && d.visible_to_camera;
    }
    bool same = sources_.last && snapshot_->origin == sources_.last->origin && sources_.described_alike;
    same &= add_mesh_lights(&lights, &traits);
    same = same && lights.size() == sources_.last->lights.size();
    light_links.resize(lights.size(), 0);
    link_lights(lights, traits, light_links);
    snapshot_->lights = LightSet(std::move(lights), std::move(traits), kSampleAllUpTo);
    return same;
  }

 private:
  // Category sets that the same lights light share them.
  void link_lights(const std::vector<Light>& lights, const LightSet::Traits& traits,
                   const std::vector<uint32_t>& light_links) {
    const auto& sets = sources_.description.category_sets;
    const auto holds = [](const std::vector<uint32_t>& set, uint32_t category) {
      return category == 0 || std::binary_search(set.begin(), set.end(), category);
    };
    uint32_t shadow_links = 0;
    for (const uint32_t link : traits.shadow_links) shadow_links = std::max(shadow_links, link);
    for (uint32_t link = 1; link <= shadow_links; ++link) {
      auto& casters = snapshot_->shadow_casters.emplace_back();
      for (const auto& set : sets) casters.push_back(holds(set, link));
      if (sets.empty()) casters.push_back(false);  // all instances have set 0
    }
    if (std::all_of(light_links.begin(), light_links.end(), [](uint32_t link) { return link == 0; })) return;
    std::map<uint32_t, std::vector<size_t>> of_link;
    for (size_t i = 0; i < lights.size(); ++i) of_link[light_links[i]].push_back(i);
    std::map<std::vector<size_t>, std::shared_ptr<const LightSet>> known;
    for (const auto& set : sets) {
      std::vector<size_t> lit_by = of_link[0];
      for (const uint32_t category : set)
        if (const auto linked = of_link.find(category); category != 0 && linked != of_link.end())
          lit_by.insert(lit_by.end(), linked->second.begin(), linked->second.end());
      std::sort(lit_by.begin(), lit_by.end());
      auto& linked = known[lit_by];
      if (!linked) linked = choose(lights, traits, lit_by);
      snapshot_->linked_lights.push_back(linked);
    }
    for (const auto& [unused, linked] : known) snapshot_->memory_bytes += linked->memory_bytes();
  }

  static std::shared_ptr<const LightSet> choose(const std::vector<Light>& lights, const LightSet::Traits& traits,
                                                const std::vector<size_t>& chosen) {
    std::vector<Light> some;
    LightSet::Traits of_some;
    for (const size_t i : chosen) {
      some.push_back(lights[i]);
      of_some.visible_to_camera.push_back(i >= traits.visible_to_camera.size() || traits.visible_to_camera[i]);
      of_some.shadow_links.push_back(i < traits.shadow_links.size() ? traits.shadow_links[i] : 0);
      of_some.scales.push_back(i < traits.scales.size() ? traits.scales[i] : LobeScales());
      of_some.groups.push_back(traits.groups[i]);
    }
    return std::make_shared<const LightSet>(std::move(some), std::move(of_some), kSampleAllUpTo);
  }

  // True if all are those of the last snapshot.
  bool add_mesh_lights(std::vector<Light>* lights, LightSet::Traits* traits) {
    const KnownMeshLights known(sources_.last);
    bool same = true;
    for (uint32_t i = 0; i < snapshot_->instances.size(); ++i) {
      const Instance& instance = snapshot_->instances[i];
      if (!emits(instance)) continue;
      snapshot_->features.emissive_meshes = true;
      // The triangles of what moves are nowhere long enough to be sampled: paths find them by their lobes.
      if (!instance.is_still()) continue;
      const MeshLight* const as_before = known.find(instance);
      same = same && as_before && as_before->instance() == i;
      in_name_of(sources_.drawn.alone[i]->name, [&] {
        lights->emplace_back(as_before ? as_before->of_instance(i)
                                       : make_mesh_light(instance, i, memory_of(*sources_.device), sources_.cancel));
      });
      traits->groups.push_back(instance.light_group);
    }
    return same;
  }

  const LightSources& sources_;
  SceneSnapshot* const snapshot_;
};

}  // namespace

bool add_lights(const LightSources& sources, SceneSnapshot* snapshot) {
  return LightCompiler(sources, snapshot).run();
}

}  // namespace alabaster
