#include "delegate/hydra/scene_capture.h"

#include "delegate/archive/archive.h"
#include "delegate/host/scene_fields.h"
#include "delegate/support/float_values.h"

namespace alabaster::hydra {
namespace {

// Samples of what moves; of what stands still there are none.
void take_samples(hd::SceneDelegate& scene, const hd::Path& id, std::initializer_list<const char*> names,
                  std::map<hd::Token, hd::TimeSamples<hd::Value>>* taken) {
  for (const char* name : names)
    if (auto samples = scene.SamplePrimvar(id, name); samples.values.size() > 1) (*taken)[name] = std::move(samples);
}

// Values by instance have no indices of their own here.
hd::Value flattened(const hd::Value& values, const hd::Array<int32_t>& indices) {
  const hd::Value floats = hd::support::FloatValues(values);
  hd::Value flat = values;
  const auto flatten = [&]<class T>(const hd::Array<T>* array) {
    if (!array) return;
    std::vector<T> all;
    for (const int32_t i : indices)
      if (i >= 0 && static_cast<size_t>(i) < array->size()) all.push_back((*array)[static_cast<size_t>(i)]);
    flat = all;
  };
  flatten(floats.get<hd::Array<float>>()), flatten(floats.get<hd::Array<hd::Vec2f>>());
  flatten(floats.get<hd::Array<hd::Vec3f>>()), flatten(floats.get<hd::Array<hd::Vec4f>>());
  return flat;
}

}  // namespace

/// The indices of prototypes may be taken before their instancer is.
hd::host::InstancerDescription& SceneCapture::instancer(const hd::Path& id) {
  auto& prim = prims_[id];
  if (auto* held = std::get_if<hd::host::InstancerDescription>(&prim)) return *held;
  return prim.emplace<hd::host::InstancerDescription>();
}

void SceneCapture::TakeMesh(hd::SceneDelegate& scene, const hd::Path& id, const hd::Token& type) {
  hd::host::MeshDescription mesh;
  mesh.type = type;
  if (type == hd::Token("basisCurves")) mesh.curves = scene.GetBasisCurvesTopology(id);
  if (type == hd::Token("mesh")) {
    mesh.topology = scene.GetMeshTopology(id);
    mesh.subdivTags = scene.GetSubdivTags(id);
    mesh.displayStyle = scene.GetDisplayStyle(id);
  }
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
  mesh.categories = scene.GetCategories(id);
  const auto indices = mesh.instancer.empty() ? hd::Array<int32_t>() : scene.GetInstanceIndices(mesh.instancer, id);
  const std::lock_guard lock(mutex_);
  if (!mesh.instancer.empty()) instancer(mesh.instancer).indices[id] = indices;
  prims_[id] = std::move(mesh);
}

void SceneCapture::TakeInstancer(hd::SceneDelegate& scene, const hd::Path& id) {
  std::map<hd::Token, hd::Value> primvars;
  std::map<hd::Token, hd::Token> roles;
  for (const hd::PrimvarDescriptor& primvar : scene.GetPrimvarDescriptors(id)) {
    if (primvar.interpolation != hd::Interpolation::instance) continue;
    hd::Array<int32_t> indices;
    const hd::Value value = scene.GetPrimvar(id, primvar.name, &indices);
    primvars[primvar.name] = primvar.indexed ? flattened(value, indices) : value;
    if (!primvar.role.empty()) roles[primvar.name] = primvar.role;
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
  auto categories = scene.GetInstanceCategories(id);
  const std::lock_guard lock(mutex_);
  if (!parent.empty()) instancer(parent).indices[id] = indices;
  auto& held = instancer(id);
  held.transform = transform, held.parent = parent, held.primvars = std::move(primvars);
  held.transformSamples = std::move(motion), held.primvarSamples = std::move(samples);
  held.categories = std::move(categories), held.primvarRoles = std::move(roles);
}

void SceneCapture::TakeMaterial(hd::SceneDelegate& scene, const hd::Path& id) {
  auto network = scene.GetMaterialResource(id);
  const std::lock_guard lock(mutex_);
  prims_[id] = std::move(network);
}

void SceneCapture::TakeLight(hd::SceneDelegate& scene, const hd::Path& id, const hd::Token& type) {
  hd::host::LightDescription light{.type = type, .transform = scene.GetTransform(id), .parameters = {}};
  for (const std::string& name : hd::host::LightParameterNames())
    if (hd::Value value = scene.GetLightParamValue(id, name); !value.empty()) light.parameters[name] = std::move(value);
  light.transformSamples = scene.SampleTransform(id);
  light.visible = scene.GetVisible(id);
  const std::lock_guard lock(mutex_);
  prims_[id] = std::move(light);
}

void SceneCapture::Remove(const hd::Path& id) {
  const std::lock_guard lock(mutex_);
  prims_.erase(id);
  for (auto& [path, prim] : prims_)
    if (auto* held = std::get_if<hd::host::InstancerDescription>(&prim)) held->indices.erase(id);
}

std::string SceneCapture::Write(const std::string& file, const hd::RenderPassState& state,
                                const std::map<hd::Token, hd::Value>& settings) const {
  const std::lock_guard lock(mutex_);
  return hd::archive::WritePass(file, prims_, state, settings);
}

}  // namespace alabaster::hydra
