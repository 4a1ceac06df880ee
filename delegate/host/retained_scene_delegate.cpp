#include "delegate/host/retained_scene_delegate.h"

#include <algorithm>

#include "delegate/host/array_turns.h"

namespace alabaster::hd::host {
namespace {

const PrimvarValue* find_primvar(const MeshDescription& mesh, const Token& name) {
  const auto found = mesh.primvars.find(name);
  return found == mesh.primvars.end() ? nullptr : &found->second;
}

bool same_primvar(const MeshDescription& a, const MeshDescription& b, const Token& name) {
  const PrimvarValue *x = find_primvar(a, name), *y = find_primvar(b, name);
  return x && y ? *x == *y : x == y;
}

bool same_primvars_but(const MeshDescription& a, const MeshDescription& b, const Token& left_out) {
  auto others = [&](const MeshDescription& mesh) { return mesh.primvars.size() - mesh.primvars.count(left_out); };
  if (others(a) != others(b)) return false;
  for (const auto& [name, value] : a.primvars)
    if (!(name == left_out) && !same_primvar(a, b, name)) return false;
  return true;
}

template <class T>
bool transform_differs(const T& a, const T& b) {
  return a.transform != b.transform || !(a.transformSamples == b.transformSamples);
}

DirtyBits difference(const MeshDescription& a, const MeshDescription& b) {
  DirtyBits bits = dirty::kClean;
  if (!(a.topology == b.topology)) bits |= dirty::kTopology;
  if (!(a.subdivTags == b.subdivTags)) bits |= dirty::kSubdivTags;
  if (!(a.displayStyle == b.displayStyle)) bits |= dirty::kDisplayStyle;
  if (!same_primvar(a, b, "points") || !(a.primvarSamples == b.primvarSamples)) bits |= dirty::kPoints;
  if (!same_primvar(a, b, "normals")) bits |= dirty::kNormals | dirty::kPrimvar;
  if (!same_primvars_but(a, b, "points")) bits |= dirty::kPrimvar;
  if (transform_differs(a, b)) bits |= dirty::kTransform;
  if (a.visible != b.visible) bits |= dirty::kVisibility;
  if (a.doubleSided != b.doubleSided) bits |= dirty::kDoubleSided;
  if (!(a.renderTag == b.renderTag)) bits |= dirty::kRenderTag;
  if (!(a.categories == b.categories)) bits |= dirty::kCategories;
  if (a.cullStyle != b.cullStyle) bits |= dirty::kCullStyle;
  if (!(a.material == b.material)) bits |= dirty::kMaterialId;
  if (!(a.instancer == b.instancer)) bits |= dirty::kInstancer | dirty::kInstanceIndex;
  return bits;
}

DirtyBits difference(const InstancerDescription& a, const InstancerDescription& b) {
  DirtyBits bits = dirty::kClean;
  if (transform_differs(a, b)) bits |= dirty::kTransform;
  if (!(a.primvars == b.primvars) || !(a.primvarSamples == b.primvarSamples)) bits |= dirty::kPrimvar;
  if (!(a.parent == b.parent)) bits |= dirty::kInstancer | dirty::kInstanceIndex;
  if (!(a.categories == b.categories)) bits |= dirty::kCategories;
  return bits;
}

DirtyBits difference(const MaterialNetwork& a, const MaterialNetwork& b) {
  return a == b ? dirty::kClean : dirty::kResource | dirty::kParams;
}

template <class T>  // LightDescription, CameraDescription
DirtyBits parameter_difference(const T& a, const T& b) {
  DirtyBits bits = dirty::kClean;
  if (a.transform != b.transform) bits |= dirty::kTransform;
  if (!(a.parameters == b.parameters)) bits |= dirty::kParams | dirty::kResource;
  return bits;
}
DirtyBits difference(const LightDescription& a, const LightDescription& b) {
  return parameter_difference(a, b) | (a.visible != b.visible ? dirty::kVisibility : dirty::kClean);
}
DirtyBits difference(const CameraDescription& a, const CameraDescription& b) {
  return parameter_difference(a, b) | (transform_differs(a, b) ? dirty::kTransform : dirty::kClean);
}
DirtyBits difference(const RenderBufferDescriptor& a, const RenderBufferDescriptor& b) {
  return a == b ? dirty::kClean : dirty::kDescription;
}
DirtyBits difference(const RenderSettingsDescription& a, const RenderSettingsDescription& b) {
  return a == b ? dirty::kClean : dirty::kParams;
}

template <class Map>
auto find(const Map& map, const typename Map::key_type& id) -> const typename Map::mapped_type* {
  const auto found = map.find(id);
  return found == map.end() ? nullptr : &found->second;
}

template <class Map>
typename Map::mapped_type get(const Map& map, const Path& id) {
  const auto* found = find(map, id);
  return found ? *found : typename Map::mapped_type{};
}

Value parameter(const std::map<Token, Value>* parameters, const Token& name) {
  if (!parameters) return {};
  const auto found = parameters->find(name);
  return found == parameters->end() ? Value() : found->second;
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
  const auto* mesh = find(state_->meshes, id);
  return mesh ? mesh->topology : MeshTopology();
}

SubdivTags RetainedSceneDelegate::GetSubdivTags(const Path& id) {
  const auto* mesh = find(state_->meshes, id);
  return mesh ? mesh->subdivTags : SubdivTags();
}

DisplayStyle RetainedSceneDelegate::GetDisplayStyle(const Path& id) {
  const auto* mesh = find(state_->meshes, id);
  return mesh ? mesh->displayStyle : DisplayStyle();
}

Matrix4d RetainedSceneDelegate::GetTransform(const Path& id) {
  if (const auto* mesh = find(state_->meshes, id)) return mesh->transform;
  if (const auto* light = find(state_->lights, id)) return light->transform;
  if (const auto* camera = find(state_->cameras, id)) return camera->transform;
  return {};
}

bool RetainedSceneDelegate::GetVisible(const Path& id) {
  if (const auto* light = find(state_->lights, id)) return light->visible;
  const auto* mesh = find(state_->meshes, id);
  return !mesh || mesh->visible;
}

bool RetainedSceneDelegate::GetDoubleSided(const Path& id) {
  const auto* mesh = find(state_->meshes, id);
  return !mesh || mesh->doubleSided;
}

CullStyle RetainedSceneDelegate::GetCullStyle(const Path& id) {
  const auto* mesh = find(state_->meshes, id);
  return mesh ? mesh->cullStyle : CullStyle::dontCare;
}

Token RetainedSceneDelegate::GetRenderTag(const Path& id) {
  const auto* mesh = find(state_->meshes, id);
  return mesh ? mesh->renderTag : Token("geometry");
}

std::vector<Token> RetainedSceneDelegate::GetCategories(const Path& id) {
  const auto* mesh = find(state_->meshes, id);
  return mesh ? mesh->categories : std::vector<Token>();
}

Path RetainedSceneDelegate::GetMaterialId(const Path& id) {
  const auto* mesh = find(state_->meshes, id);
  return mesh ? mesh->material : Path();
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
  if (const auto* instancer = find(state_->instancers, id)) return parameter(&instancer->primvars, name);
  const auto* mesh = find(state_->meshes, id);
  const PrimvarValue* primvar = mesh ? find_primvar(*mesh, name) : nullptr;
  if (!primvar) return {};
  if (indices) *indices = primvar->indices;
  return primvar->value;
}

Path RetainedSceneDelegate::GetInstancerId(const Path& primId) {
  if (const auto* mesh = find(state_->meshes, primId)) return mesh->instancer;
  const auto* instancer = find(state_->instancers, primId);
  return instancer ? instancer->parent : Path();
}

Matrix4d RetainedSceneDelegate::GetInstancerTransform(const Path& instancerId) {
  const auto* instancer = find(state_->instancers, instancerId);
  return instancer ? instancer->transform : Matrix4d();
}

TimeSamples<Matrix4d> RetainedSceneDelegate::SampleTransform(const Path& id) {
  if (const auto* mesh = find(state_->meshes, id)) return mesh->transformSamples;
  const auto* camera = find(state_->cameras, id);
  return camera ? camera->transformSamples : TimeSamples<Matrix4d>();
}

TimeSamples<Value> RetainedSceneDelegate::SamplePrimvar(const Path& id, const Token& name) {
  const auto sampled = [&](const auto* prim) {
    const auto found = prim->primvarSamples.find(name);
    return found == prim->primvarSamples.end() ? TimeSamples<Value>() : found->second;
  };
  if (const auto* mesh = find(state_->meshes, id)) return sampled(mesh);
  const auto* instancer = find(state_->instancers, id);
  return instancer ? sampled(instancer) : TimeSamples<Value>();
}

TimeSamples<Matrix4d> RetainedSceneDelegate::SampleInstancerTransform(const Path& instancerId) {
  const auto* instancer = find(state_->instancers, instancerId);
  return instancer ? instancer->transformSamples : TimeSamples<Matrix4d>();
}

Array<int32_t> RetainedSceneDelegate::GetInstanceIndices(const Path& instancerId, const Path& prototypeId) {
  const auto* instancer = find(state_->instancers, instancerId);
  return instancer ? get(instancer->indices, prototypeId) : Array<int32_t>();
}

std::vector<std::vector<Token>> RetainedSceneDelegate::GetInstanceCategories(const Path& instancerId) {
  const auto* instancer = find(state_->instancers, instancerId);
  return instancer ? instancer->categories : std::vector<std::vector<Token>>();
}

MaterialNetwork RetainedSceneDelegate::GetMaterialResource(const Path& id) {
  return get(state_->materials, id);
}

Value RetainedSceneDelegate::GetLightParamValue(const Path& id, const Token& name) {
  const auto* light = find(state_->lights, id);
  return parameter(light ? &light->parameters : nullptr, name);
}

Value RetainedSceneDelegate::GetCameraParamValue(const Path& id, const Token& name) {
  const auto* camera = find(state_->cameras, id);
  return parameter(camera ? &camera->parameters : nullptr, name);
}

RenderBufferDescriptor RetainedSceneDelegate::GetRenderBufferDescriptor(const Path& id) {
  return get(state_->buffers, id);
}

RenderSettingsDescription RetainedSceneDelegate::GetRenderSettings(const Path& id) {
  return get(state_->settings, id);
}

}  // namespace alabaster::hd::host
