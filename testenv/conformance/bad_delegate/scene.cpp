#include <algorithm>

#include "testenv/conformance/bad_delegate/misbehaviour.h"

namespace bad {

Value Memory::latched(const Path& id, const std::string& question, const Value& answer) {
  const std::lock_guard lock(mutex);
  Value& first_answer = first[id][question];
  if (first_answer.empty()) first_answer = answer;
  return first_answer;
}

MeshTopology Scene::GetMeshTopology(const Path& id) {
  MeshTopology topology = host_->GetMeshTopology(id);
  const size_t faces = topology.faceVertexCounts.size();
  if (is("drops_faces_of_no_subset") && !topology.geomSubsets.empty()) {
    std::set<int32_t> holes;
    for (size_t face = 0; face < faces; ++face) holes.insert(static_cast<int32_t>(face));
    for (const GeomSubset& subset : topology.geomSubsets)
      for (int32_t face : subset.indices) holes.erase(face);
    topology.holeIndices = std::vector<int32_t>(holes.begin(), holes.end());
  }
  if (is("takes_255_subsets") && topology.geomSubsets.size() > 255) topology.geomSubsets.clear();
  if (is("ignores_holes")) topology.holeIndices = {};
  if (is("ignores_orientation")) topology.orientation = "rightHanded";
  int64_t sum = 0;
  for (int32_t count : topology.faceVertexCounts) sum += count;
  if (is("fails_once_a_mesh_is_bad") && sum != static_cast<int64_t>(topology.faceVertexIndices.size()))
    memory_->poisoned = true;
  return topology;
}

bool Scene::GetVisible(const Path& id) {
  const bool visible = host_->GetVisible(id);
  return is("ignores_visibility") ? memory_->latched(id, "visible", visible).get_or(visible) : visible;
}

Token Scene::GetRenderTag(const Path& id) {
  const Token tag = host_->GetRenderTag(id);
  return is("keeps_old_purposes") ? Token(memory_->latched(id, "tag", tag).get_or(tag)) : tag;
}

Path Scene::GetMaterialId(const Path& id) {
  const Path material = host_->GetMaterialId(id);
  if (is("ignores_rebinding")) return Path(memory_->latched(id, "material", material).get_or(material));
  const std::lock_guard lock(memory_->mutex);
  return is("resolves_materials_in_sync") && !memory_->materials.contains(material) ? Path() : material;
}

std::vector<PrimvarDescriptor> Scene::GetPrimvarDescriptors(const Path& id) {
  std::vector<PrimvarDescriptor> all = host_->GetPrimvarDescriptors(id);
  if (is("keeps_interpolations"))
    for (PrimvarDescriptor& one : all)
      one.interpolation = static_cast<Interpolation>(
          memory_->latched(id, one.name.str(), static_cast<int32_t>(one.interpolation)).get_or(0));
  if (!is("keeps_removed_primvars")) return all;
  const std::lock_guard lock(memory_->mutex);
  auto& known = memory_->primvars[id];
  for (const PrimvarDescriptor& one : all) known[one.name].first = one;
  all.clear();
  for (const auto& [name, held] : known) all.push_back(held.first);
  return all;
}

Value Scene::GetPrimvar(const Path& id, const Token& name, Array<int32_t>* indices) {
  Value value = host_->GetPrimvar(id, name, indices);
  if (is("keeps_removed_primvars")) {
    const std::lock_guard lock(memory_->mutex);
    Value& held = memory_->primvars[id][name].second;
    if (value.empty()) return held;
    held = value;
  }
  // T before S instead of S before T.
  const auto* places = value.get<Array<Vec3f>>();
  if (is("reverses_instance_transforms") && name == Token("hydra:instanceTranslations") && places) {
    const Array<Vec3f> scales = host_->GetPrimvar(id, "hydra:instanceScales", nullptr).get_or(Array<Vec3f>());
    std::vector<Vec3f> scaled(places->begin(), places->end());
    for (size_t i = 0; i < scaled.size() && i < scales.size(); ++i) scaled[i] *= scales[i];
    return Array<Vec3f>(scaled);
  }
  return value;
}

TimeSamples<Matrix4d> Scene::SampleTransform(const Path& id) {
  TimeSamples<Matrix4d> samples = host_->SampleTransform(id);
  if (is("ignores_motion_at_first") && memory_->latched(id, "moved", false) == Value(false)) {
    const std::lock_guard lock(memory_->mutex);
    memory_->first[id]["moved"] = true;
    return {};
  }
  if (is("drops_samples_outside_of_the_shutter")) {
    TimeSamples<Matrix4d> inside;
    for (size_t i = 0; i < samples.times.size() && i < samples.values.size(); ++i) {
      if (samples.times[i] < 0 || samples.times[i] > 1) continue;
      inside.times.push_back(samples.times[i]), inside.values.push_back(samples.values[i]);
    }
    return inside;
  }
  return samples;
}

Path Scene::GetInstancerId(const Path& id) {
  const Path instancer = host_->GetInstancerId(id);
  return is("draws_prototypes") && !instancer.empty() ? Path() : instancer;
}

Array<int32_t> Scene::GetInstanceIndices(const Path& id, const Path& prototype) {
  const Array<int32_t> indices = host_->GetInstanceIndices(id, prototype);
  return is("draws_a_ghost_of_no_instance") && indices.empty() ? Array<int32_t>{0} : indices;
}

MaterialNetwork Scene::GetMaterialResource(const Path& id) {
  ++memory_->network_syncs;
  return host_->GetMaterialResource(id);
}

Value Scene::GetLightParamValue(const Path& id, const Token& name) {
  return is("ignores_light_links") && name == Token("lightLink") ? Value() : host_->GetLightParamValue(id, name);
}

Value Scene::GetCameraParamValue(const Path& id, const Token& name) {
  const Value value = host_->GetCameraParamValue(id, name);
  const bool shutter = name == Token("shutterOpen") || name == Token("shutterClose");
  if (!is("ignores_shutter_changes") || !shutter) return value;
  return memory_->latched(id, name.str(), value.empty() ? Value(0.0) : value);
}

}  // namespace bad
