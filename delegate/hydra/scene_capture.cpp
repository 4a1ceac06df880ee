#include "delegate/hydra/scene_capture.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <stdexcept>

#include "delegate/hydra/captured_files.h"

namespace alabaster::hydra {
namespace {

// Removes what an earlier call left behind under the temporary name.
std::string write_whole(const std::string& file, const std::string& bytes) {
  const std::string temporary = file + ".partial";
  {
    std::ofstream out(temporary, std::ios::binary | std::ios::trunc);
    out.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    if (!out.flush()) return std::remove(temporary.c_str()), "cannot write " + temporary + "; is the folder writable?";
  }
  if (std::rename(temporary.c_str(), file.c_str()) == 0) return {};
  std::remove(temporary.c_str());
  return "cannot rename " + temporary + " to " + file;
}

}  // namespace

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
  mesh.visible = scene.GetVisible(id);
  mesh.renderTag = scene.GetRenderTag(id);
  mesh.doubleSided = scene.GetDoubleSided(id);
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
  const std::lock_guard lock(mutex_);
  auto& held = instancers_[id];
  held.transform = transform, held.parent = parent, held.primvars = std::move(primvars);
}

void SceneCapture::TakeMaterial(hd::SceneDelegate& scene, const hd::Path& id) {
  auto network = scene.GetMaterialResource(id);
  const std::lock_guard lock(mutex_);
  materials_[id] = std::move(network);
}

void SceneCapture::TakeLight(hd::SceneDelegate& scene, const hd::Path& id, const hd::Token& type) {
  hd::host::LightDescription light{.type = type, .transform = scene.GetTransform(id), .parameters = {}};
  for (const std::string& name : LightParameterNames(type.str()))
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
  if (!file.ends_with(".json")) return file + " must end in .json";
  const std::string stem = file.substr(0, file.size() - 5);
  const std::string name = stem.substr(stem.rfind('/') + 1);
  try {
    for (const hd::Path& id : linked_)
      if (lights_.at(id).visible)
        throw std::runtime_error(id.str() + " is linked to a part of the scene, which is not written");
    // Only those that the pass draws.
    auto meshes = meshes_;
    std::erase_if(meshes, [&tags = state.renderTags](const auto& mesh) {
      return std::find(tags.begin(), tags.end(), mesh.second.renderTag) == tags.end();
    });
    const CapturedGltf gltf = MakeGltf(meshes, instancers_, name + ".bin");
    const std::string description = MakeDescription({meshes, materials_, lights_, state, settings}, name);
    for (const auto& [ending, text] :
         {std::pair{".bin", &gltf.buffer}, std::pair{".gltf", &gltf.document}, std::pair{".json", &description}})
      if (std::string fault = write_whole(stem + ending, *text); !fault.empty()) return fault;
  } catch (const std::exception& e) {
    return e.what();
  }
  return {};
}

}  // namespace alabaster::hydra
