#include "delegate/hydra/scene_capture.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "delegate/description/render_description.h"
#include "delegate/description/write_scene.h"

namespace alabaster::hydra {
namespace {

// A direction that normalizing leaves as it is. To normalize once is not enough, because the rounded result may have
// another length than 1, and some results follow each other in a circle.
hd::Vec3f settled(hd::Vec3f n) {
  constexpr int kAttempts = 64;
  for (int i = 0; i < kAttempts; ++i) {
    const hd::Vec3f once = n.normalized();
    if (once == n) break;
    n = once;
    if (i % 4 == 3) n[i / 4 % 3] = std::nextafter(n[i / 4 % 3], 0.0f);
  }
  return n;
}

// Names of the parameters that schemas/lights.json has for lights of this type.
std::vector<std::string> light_parameter_names(const std::string& type) {
  static const auto schema = nlohmann::json::parse(hd::description::SchemaText("lights"));
  std::vector<std::string> all;
  for (const auto& [name, property] : schema.at("properties").items()) {
    const nlohmann::json types = property.value("appliesTo", nlohmann::json{type});
    if (std::find(types.begin(), types.end(), type) != types.end()) all.push_back(name);
  }
  return all;
}

// Samples of what moves; of what stands still there are none.
void take_samples(hd::SceneDelegate& scene, const hd::Path& id, std::initializer_list<const char*> names,
                  std::map<hd::Token, hd::TimeSamples<hd::Value>>* taken) {
  for (const char* name : names)
    if (auto samples = scene.SamplePrimvar(id, name); samples.values.size() > 1) (*taken)[name] = std::move(samples);
}

}  // namespace

hd::Value UnitNormals(const hd::Value& normals) {
  const auto* const given = normals.get<hd::Array<hd::Vec3f>>();
  if (!given) return normals;
  std::vector<hd::Vec3f> unit(given->begin(), given->end());
  for (hd::Vec3f& n : unit) n = settled(n);
  return hd::Array<hd::Vec3f>(std::move(unit));
}

void SceneCapture::TakeMesh(hd::SceneDelegate& scene, const hd::Path& id) {
  hd::host::MeshDescription mesh;
  mesh.topology = scene.GetMeshTopology(id);
  mesh.subdivTags = scene.GetSubdivTags(id);
  mesh.displayStyle = scene.GetDisplayStyle(id);
  for (const hd::PrimvarDescriptor& primvar : scene.GetPrimvarDescriptors(id)) {
    auto& held = mesh.primvars[primvar.name];
    held.interpolation = primvar.interpolation;
    held.role = primvar.role;
    held.value = scene.GetPrimvar(id, primvar.name, &held.indices);
  }
  hd::Array<int32_t> none;
  mesh.primvars["points"].value = scene.GetPrimvar(id, "points", &none);
  mesh.transform = scene.GetTransform(id);
  mesh.transformSamples = scene.SampleTransform(id);
  take_samples(scene, id, {"points", "normals"}, &mesh.primvarSamples);
  mesh.visible = scene.GetVisible(id);
  mesh.renderTag = scene.GetRenderTag(id);
  mesh.doubleSided = scene.GetDoubleSided(id);
  mesh.cullStyle = scene.GetCullStyle(id);
  mesh.material = scene.GetMaterialId(id);
  mesh.instancer = scene.GetInstancerId(id);
  const auto indices = mesh.instancer.empty() ? hd::Array<int32_t>() : scene.GetInstanceIndices(mesh.instancer, id);
  const std::lock_guard lock(mutex_);
  if (!mesh.instancer.empty()) instancers_[mesh.instancer].indices[id] = indices;
  meshes_[id] = std::move(mesh);
}

void SceneCapture::TakeInstancer(hd::SceneDelegate& scene, const hd::Path& id) {
  std::map<hd::Token, hd::Value> primvars;
  for (const hd::PrimvarDescriptor& primvar : scene.GetPrimvarDescriptors(id)) {
    hd::Array<int32_t> none;
    primvars[primvar.name] = scene.GetPrimvar(id, primvar.name, &none);
  }
  const hd::Matrix4d transform = scene.GetInstancerTransform(id);
  const hd::Path parent = scene.GetInstancerId(id);
  const auto indices = parent.empty() ? hd::Array<int32_t>() : scene.GetInstanceIndices(parent, id);
  auto motion = scene.SampleInstancerTransform(id);
  std::map<hd::Token, hd::TimeSamples<hd::Value>> samples;
  take_samples(
      scene, id,
      {"hydra:instanceTransforms", "hydra:instanceTranslations", "hydra:instanceRotations", "hydra:instanceScales"},
      &samples);
  const std::lock_guard lock(mutex_);
  if (!parent.empty()) instancers_[parent].indices[id] = indices;
  auto& held = instancers_[id];
  held.transform = transform, held.parent = parent, held.primvars = std::move(primvars);
  held.transformSamples = std::move(motion), held.primvarSamples = std::move(samples);
}

void SceneCapture::TakeMaterial(hd::SceneDelegate& scene, const hd::Path& id) {
  auto network = scene.GetMaterialResource(id);
  const std::lock_guard lock(mutex_);
  materials_[id] = std::move(network);
}

void SceneCapture::TakeLight(hd::SceneDelegate& scene, const hd::Path& id, const hd::Token& type) {
  hd::host::LightDescription light{.type = type, .transform = scene.GetTransform(id), .parameters = {}};
  for (const std::string& name : light_parameter_names(type.str()))
    if (hd::Value value = scene.GetLightParamValue(id, name); !value.empty()) light.parameters[name] = std::move(value);
  light.visible = scene.GetVisible(id);
  bool is_linked = false;
  for (const char* link : {"lightLink", "shadowLink"})
    is_linked |= !scene.GetLightParamValue(id, link).text_or("").empty();
  const std::lock_guard lock(mutex_);
  lights_[id] = std::move(light);
  is_linked ? void(linked_.insert(id)) : void(linked_.erase(id));
}

void SceneCapture::Remove(const hd::Path& id) {
  const std::lock_guard lock(mutex_);
  meshes_.erase(id), instancers_.erase(id), materials_.erase(id), lights_.erase(id), linked_.erase(id);
  for (auto& [instancer, held] : instancers_) held.indices.erase(id);
}

std::string SceneCapture::Write(const std::string& file, const hd::RenderPassState& state,
                                const std::map<hd::Token, hd::Value>& settings) const {
  const std::lock_guard lock(mutex_);
  for (const hd::Path& id : linked_)
    if (lights_.at(id).visible) return id.str() + " is linked to a part of the scene, which is not written";
  return hd::description::WriteScene(file, {meshes_, instancers_, materials_, lights_, {}}, state, settings);
}

}  // namespace alabaster::hydra
