#include "delegate/host/retained_scene_delegate.h"

#include <algorithm>

#include "delegate/host/array_turns.h"
#include "delegate/host/scene_fields.h"

namespace alabaster::hd::host {
namespace {

template <class Map>
auto find(const Map& map, const typename Map::key_type& id) -> const typename Map::mapped_type* {
  const auto found = map.find(id);
  return found == map.end() ? nullptr : &found->second;
}

template <class Map>
typename Map::mapped_type get(const Map& map, const typename Map::key_type& key) {
  const auto* found = find(map, key);
  return found ? *found : typename Map::mapped_type{};
}

/// A member of the prim of that path; without one, the member's default.
template <class T, class Member>
Member member_of(const std::map<Path, T>& prims, const Path& id, Member T::*member) {
  const T* prim = find(prims, id);
  return prim ? prim->*member : T().*member;
}

}  // namespace

struct RetainedSceneDelegate::State {
  std::map<Path, MeshDescription> meshes;
  std::map<Path, InstancerDescription> instancers;
  std::map<Path, MaterialNetwork> materials;
  std::map<Path, LightDescription> lights;
  std::map<Path, CameraDescription> cameras;
  std::map<Path, RenderBufferDescriptor> buffers;
  std::map<Path, RenderSettingsDescription> settings;
  std::map<std::pair<Path, Token>, EditedArray> edited;  // primvars of instancers
  RenderIndex* index = nullptr;

  /// Stores `value`; returns whether `id` is new in `map`.
  template <class T>
  bool set(std::map<Path, T>& map, const Path& id, T value) {
    const auto found = map.find(id);
    if (found == map.end()) {
      map.emplace(id, std::move(value));
      return true;
    }
    if (index) index->GetChangeTracker().MarkDirty(id, difference(found->second, value));
    found->second = std::move(value);
    return false;
  }
  /// A prim of another kind than those of `map` has this path: a Set replaces it.
  template <class T>
  bool is_of_another_kind(const std::map<Path, T>& map, const Path& id) const {
    return !map.contains(id) && contains(id);
  }
  bool contains(const Path& id) const {
    return meshes.contains(id) || instancers.contains(id) || materials.contains(id) || lights.contains(id) ||
           cameras.contains(id) || buffers.contains(id) || settings.contains(id);
  }
  void mark(const Path& id, DirtyBits bits) {
    if (index && index->Has(id)) index->GetChangeTracker().MarkDirty(id, bits);
  }
  /// Gives up the copies of arrays that another one has replaced.
  void forget_edits(const Path& instancer) {
    const auto* description = find(instancers, instancer);
    std::erase_if(edited, [&](const auto& entry) {
      if (!(entry.first.first == instancer)) return false;
      const Value* now = description ? find(description->primvars, entry.first.second) : nullptr;
      return !now || !entry.second.is_latest(*now);
    });
  }
  /// Prototypes whose indices differ pull them again; so do those that came or went.
  void mark_prototypes(const InstancerDescription& a, const InstancerDescription& b) {
    for (const auto& [prototype, indices] : a.indices) {
      const auto* other = find(b.indices, prototype);
      if (!other || !(*other == indices)) mark(prototype, dirty::kInstanceIndex);
    }
    for (const auto& [prototype, indices] : b.indices)
      if (!find(a.indices, prototype)) mark(prototype, dirty::kInstanceIndex);
  }
};

RetainedSceneDelegate::RetainedSceneDelegate() : state_(std::make_unique<State>()) {}
RetainedSceneDelegate::~RetainedSceneDelegate() {
  Depopulate();
}

void RetainedSceneDelegate::SetMesh(const Path& id, MeshDescription mesh) {
  if (state_->is_of_another_kind(state_->meshes, id)) Remove(id);
  if (state_->set(state_->meshes, id, std::move(mesh)) && state_->index) state_->index->InsertRprim("mesh", this, id);
}

void RetainedSceneDelegate::SetInstancer(const Path& id, InstancerDescription instancer) {
  if (state_->is_of_another_kind(state_->instancers, id)) Remove(id);
  const InstancerDescription before = get(state_->instancers, id);
  const bool is_new = state_->set(state_->instancers, id, std::move(instancer));
  if (is_new && state_->index) state_->index->InsertInstancer(this, id);
  state_->mark_prototypes(before, state_->instancers[id]);
  state_->forget_edits(id);
}

bool RetainedSceneDelegate::SetInstanceValues(const Path& instancer, const Token& primvar, size_t first,
                                              const Value& elements) {
  const auto found = state_->instancers.find(instancer);
  if (found == state_->instancers.end()) return false;
  const auto held = found->second.primvars.find(primvar);
  if (held == found->second.primvars.end()) return false;
  // Instances that move stand still where they are set: their elements are the same at all times.
  TimeSamples<Value> samples;
  if (const auto moving = found->second.primvarSamples.find(primvar); moving != found->second.primvarSamples.end())
    samples = moving->second;
  for (Value& sample : samples.values)
    if ((sample = EditedArray::copy(sample, first, elements)).empty()) return false;
  Value edited = state_->edited[{instancer, primvar}].edit(held->second, first, elements);
  if (edited.empty()) return false;
  held->second = std::move(edited);
  if (!samples.values.empty()) found->second.primvarSamples[primvar] = std::move(samples);
  state_->mark(instancer, dirty::kPrimvar);
  return true;
}

void RetainedSceneDelegate::SetMaterial(const Path& id, MaterialNetwork network) {
  if (state_->is_of_another_kind(state_->materials, id)) Remove(id);
  if (state_->set(state_->materials, id, std::move(network)) && state_->index)
    state_->index->InsertSprim("material", this, id);
}

void RetainedSceneDelegate::SetLight(const Path& id, LightDescription light) {
  const Token type = light.type;
  if (state_->is_of_another_kind(state_->lights, id)) Remove(id);
  const auto* before = find(state_->lights, id);
  if (before && !(before->type == type)) Remove(id);  // another type is another prim
  if (state_->set(state_->lights, id, std::move(light)) && state_->index) state_->index->InsertSprim(type, this, id);
}

void RetainedSceneDelegate::SetCamera(const Path& id, CameraDescription camera) {
  if (state_->is_of_another_kind(state_->cameras, id)) Remove(id);
  if (state_->set(state_->cameras, id, std::move(camera)) && state_->index)
    state_->index->InsertSprim("camera", this, id);
}

void RetainedSceneDelegate::SetRenderBuffer(const Path& id, RenderBufferDescriptor buffer) {
  if (state_->is_of_another_kind(state_->buffers, id)) Remove(id);
  if (state_->set(state_->buffers, id, std::move(buffer)) && state_->index)
    state_->index->InsertBprim("renderBuffer", this, id);
}

void RetainedSceneDelegate::SetRenderSettings(const Path& id, RenderSettingsDescription settings) {
  if (state_->is_of_another_kind(state_->settings, id)) Remove(id);
  if (state_->set(state_->settings, id, std::move(settings)) && state_->index)
    state_->index->InsertBprim("renderSettings", this, id);
}

void RetainedSceneDelegate::Remove(const Path& id) {
  State& s = *state_;
  if (s.index) s.index->Remove(id);
  const InstancerDescription instancer = get(s.instancers, id);
  s.meshes.erase(id);
  s.instancers.erase(id);
  s.materials.erase(id);
  s.lights.erase(id);
  s.cameras.erase(id);
  s.buffers.erase(id);
  s.settings.erase(id);
  s.mark_prototypes(instancer, {});
  s.forget_edits(id);
}

const std::map<Path, MeshDescription>& RetainedSceneDelegate::GetMeshes() const {
  return state_->meshes;
}
const std::map<Path, InstancerDescription>& RetainedSceneDelegate::GetInstancers() const {
  return state_->instancers;
}
const std::map<Path, MaterialNetwork>& RetainedSceneDelegate::GetMaterials() const {
  return state_->materials;
}
const std::map<Path, LightDescription>& RetainedSceneDelegate::GetLights() const {
  return state_->lights;
}
const std::map<Path, CameraDescription>& RetainedSceneDelegate::GetCameras() const {
  return state_->cameras;
}
const std::map<Path, RenderSettingsDescription>& RetainedSceneDelegate::GetAllRenderSettings() const {
  return state_->settings;
}

void RetainedSceneDelegate::Populate(RenderIndex* index) {
  Depopulate();
  State& s = *state_;
  s.index = index;
  if (index) PopulateRest();
}

bool RetainedSceneDelegate::PopulateRest() {
  State& s = *state_;
  if (!s.index) return true;
  bool whole = true;
  const auto insert = [&](const auto& map, const auto& insert_one) {
    for (const auto& [id, value] : map)
      if (!s.index->Has(id)) whole = insert_one(id, value) && whole;
  };
  insert(s.settings, [&](const Path& id, const auto&) { return s.index->InsertBprim("renderSettings", this, id); });
  insert(s.buffers, [&](const Path& id, const auto&) { return s.index->InsertBprim("renderBuffer", this, id); });
  insert(s.cameras, [&](const Path& id, const auto&) { return s.index->InsertSprim("camera", this, id); });
  insert(s.materials, [&](const Path& id, const auto&) { return s.index->InsertSprim("material", this, id); });
  const std::vector<Token> known = s.index->GetRenderDelegate()->GetSupportedSprimTypes();
  insert(s.lights, [&](const Path& id, const LightDescription& light) {
    const bool is_known = std::find(known.begin(), known.end(), light.type) != known.end();
    return !is_known || s.index->InsertSprim(light.type, this, id);
  });
  insert(s.instancers, [&](const Path& id, const auto&) { return s.index->InsertInstancer(this, id); });
  insert(s.meshes, [&](const Path& id, const auto&) { return s.index->InsertRprim("mesh", this, id); });
  return whole;
}

void RetainedSceneDelegate::Depopulate() {
  State& s = *state_;
  if (!s.index) return;
  auto remove_all = [&](const auto& map) {
    for (const auto& [id, value] : map) s.index->Remove(id);
  };
  remove_all(s.meshes);
  remove_all(s.instancers);
  remove_all(s.lights);
  remove_all(s.materials);
  remove_all(s.cameras);
  remove_all(s.buffers);
  remove_all(s.settings);
  s.index = nullptr;
}

MeshTopology RetainedSceneDelegate::GetMeshTopology(const Path& id) {
  return member_of(state_->meshes, id, &MeshDescription::topology);
}
SubdivTags RetainedSceneDelegate::GetSubdivTags(const Path& id) {
  return member_of(state_->meshes, id, &MeshDescription::subdivTags);
}
DisplayStyle RetainedSceneDelegate::GetDisplayStyle(const Path& id) {
  return member_of(state_->meshes, id, &MeshDescription::displayStyle);
}
Matrix4d RetainedSceneDelegate::GetTransform(const Path& id) {
  if (const auto* light = find(state_->lights, id)) return light->transform;
  if (const auto* camera = find(state_->cameras, id)) return camera->transform;
  return member_of(state_->meshes, id, &MeshDescription::transform);
}
bool RetainedSceneDelegate::GetVisible(const Path& id) {
  if (const auto* light = find(state_->lights, id)) return light->visible;
  return member_of(state_->meshes, id, &MeshDescription::visible);
}
bool RetainedSceneDelegate::GetDoubleSided(const Path& id) {
  return member_of(state_->meshes, id, &MeshDescription::doubleSided);
}
CullStyle RetainedSceneDelegate::GetCullStyle(const Path& id) {
  return member_of(state_->meshes, id, &MeshDescription::cullStyle);
}
Token RetainedSceneDelegate::GetRenderTag(const Path& id) {
  return member_of(state_->meshes, id, &MeshDescription::renderTag);
}
std::vector<Token> RetainedSceneDelegate::GetCategories(const Path& id) {
  return member_of(state_->meshes, id, &MeshDescription::categories);
}
Path RetainedSceneDelegate::GetMaterialId(const Path& id) {
  return member_of(state_->meshes, id, &MeshDescription::material);
}

std::vector<PrimvarDescriptor> RetainedSceneDelegate::GetPrimvarDescriptors(const Path& id) {
  std::vector<PrimvarDescriptor> descriptors;
  if (const auto* mesh = find(state_->meshes, id))
    for (const auto& [name, primvar] : mesh->primvars)
      descriptors.push_back({name, primvar.interpolation, primvar.role, !primvar.indices.empty()});
  if (const auto* instancer = find(state_->instancers, id))
    for (const auto& [name, value] : instancer->primvars)
      descriptors.push_back({name, Interpolation::instance, Token(), false});
  return descriptors;
}

Value RetainedSceneDelegate::GetPrimvar(const Path& id, const Token& name, Array<int32_t>* indices) {
  if (indices) *indices = {};
  if (const auto* instancer = find(state_->instancers, id)) return get(instancer->primvars, name);
  const auto* mesh = find(state_->meshes, id);
  const PrimvarValue* primvar = mesh ? find(mesh->primvars, name) : nullptr;
  if (!primvar) return {};
  if (indices) *indices = primvar->indices;
  return primvar->value;
}

TimeSamples<Matrix4d> RetainedSceneDelegate::SampleTransform(const Path& id) {
  if (const auto* camera = find(state_->cameras, id)) return camera->transformSamples;
  return member_of(state_->meshes, id, &MeshDescription::transformSamples);
}
TimeSamples<Value> RetainedSceneDelegate::SamplePrimvar(const Path& id, const Token& name) {
  if (const auto* instancer = find(state_->instancers, id)) return get(instancer->primvarSamples, name);
  const auto* mesh = find(state_->meshes, id);
  return mesh ? get(mesh->primvarSamples, name) : TimeSamples<Value>();
}
TimeSamples<Matrix4d> RetainedSceneDelegate::SampleInstancerTransform(const Path& id) {
  return member_of(state_->instancers, id, &InstancerDescription::transformSamples);
}

Path RetainedSceneDelegate::GetInstancerId(const Path& id) {
  if (const auto* instancer = find(state_->instancers, id)) return instancer->parent;
  return member_of(state_->meshes, id, &MeshDescription::instancer);
}
Matrix4d RetainedSceneDelegate::GetInstancerTransform(const Path& id) {
  return member_of(state_->instancers, id, &InstancerDescription::transform);
}
Array<int32_t> RetainedSceneDelegate::GetInstanceIndices(const Path& instancerId, const Path& prototypeId) {
  const auto* instancer = find(state_->instancers, instancerId);
  return instancer ? get(instancer->indices, prototypeId) : Array<int32_t>();
}
std::vector<std::vector<Token>> RetainedSceneDelegate::GetInstanceCategories(const Path& id) {
  return member_of(state_->instancers, id, &InstancerDescription::categories);
}

MaterialNetwork RetainedSceneDelegate::GetMaterialResource(const Path& id) {
  return get(state_->materials, id);
}
Value RetainedSceneDelegate::GetLightParamValue(const Path& id, const Token& name) {
  const auto* light = find(state_->lights, id);
  return light ? get(light->parameters, name) : Value();
}
Value RetainedSceneDelegate::GetCameraParamValue(const Path& id, const Token& name) {
  const auto* camera = find(state_->cameras, id);
  return camera ? get(camera->parameters, name) : Value();
}
RenderBufferDescriptor RetainedSceneDelegate::GetRenderBufferDescriptor(const Path& id) {
  return get(state_->buffers, id);
}
RenderSettingsDescription RetainedSceneDelegate::GetRenderSettings(const Path& id) {
  return get(state_->settings, id);
}

}  // namespace alabaster::hd::host
