#include "delegate/host/retained_scene_delegate.h"

#include <algorithm>
#include <utility>

#include "delegate/host/scene_fields.h"
#include "delegate/support/lookup.h"

namespace alabaster::hd::host {
namespace {

using support::find_in;
using support::value_in;

/// A member of the prim of that path; without one, the member's default.
template <class T, class Member>
Member member_of(const std::map<Path, T>& prims, const Path& id, Member T::*member) {
  const T* prim = find_in(prims, id);
  return prim ? prim->*member : T().*member;
}

/// Copies an array of one of the types that Sync takes as they are, with the elements from `first` on replaced. False:
/// it is of another type, `part` is, or it ends before them.
bool replace_part(Value* array, size_t first, const Value& part) {
  bool fits = false;
  const auto try_type = [&]<class T>(const Array<T>&) {
    const auto *now = array->get<Array<T>>(), *elements = part.get<Array<T>>();
    if (fits || !now || !elements || first > now->size() || elements->size() > now->size() - first) return;
    std::vector<T> values(now->begin(), now->end());
    std::copy(elements->begin(), elements->end(), values.begin() + static_cast<std::ptrdiff_t>(first));
    *array = Array<T>(std::move(values));
    fits = true;
  };
  try_type(Array<Vec3f>()), try_type(Array<Quatf>()), try_type(Array<Matrix4d>());
  return fits;
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
  RenderIndex* index = nullptr;
  bool is_whole = false;  // there is an index, and it has all prims
  RetainedSceneDelegate* scene = nullptr;

  /// Calls visit(map) with the prims of each kind, in the order in which they enter an index.
  template <class Visit>
  void for_each_kind(const Visit& visit) {
    visit(settings), visit(buffers), visit(cameras), visit(materials), visit(lights), visit(instancers), visit(meshes);
  }

  // Each enters a prim into the index. False: memory ran out.
  bool insert(const Path& id, const MeshDescription&) { return index->InsertRprim("mesh", scene, id); }
  bool insert(const Path& id, const InstancerDescription&) { return index->InsertInstancer(scene, id); }
  bool insert(const Path& id, const MaterialNetwork&) { return index->InsertSprim("material", scene, id); }
  bool insert(const Path& id, const CameraDescription&) { return index->InsertSprim("camera", scene, id); }
  bool insert(const Path& id, const RenderBufferDescriptor&) { return index->InsertBprim("renderBuffer", scene, id); }
  bool insert(const Path& id, const RenderSettingsDescription&) {
    return index->InsertBprim("renderSettings", scene, id);
  }
  bool insert(const Path& id, const LightDescription& light) {
    const std::vector<Token> known = index->GetRenderDelegate()->GetSupportedSprimTypes();
    if (std::find(known.begin(), known.end(), light.type) == known.end()) return true;
    return index->InsertSprim(light.type, scene, id);
  }

  /// Stores `value`, in the place of a prim of another kind that has this path.
  template <class T>
  void set(std::map<Path, T>& map, const Path& id, T value) {
    const auto found = map.find(id);
    if (found != map.end()) {
      if (index) index->GetChangeTracker().MarkDirty(id, difference(found->second, value));
      found->second = std::move(value);
      return;
    }
    bool is_of_another_kind = false;
    for_each_kind([&](const auto& prims) { is_of_another_kind |= prims.contains(id); });
    if (is_of_another_kind) scene->Remove(id);
    const auto entered = map.emplace(id, std::move(value)).first;
    if (!index) return;
    const bool has_others = std::exchange(is_whole, false);
    is_whole = insert(id, entered->second) && has_others;
  }
  void mark(const Path& id, DirtyBits bits) {
    if (index && index->Has(id)) index->GetChangeTracker().MarkDirty(id, bits);
  }
  /// Prototypes whose indices differ pull them again; so do those that came or went.
  void mark_prototypes(const InstancerDescription& a, const InstancerDescription& b) {
    for (const auto& [prototype, indices] : a.indices) {
      const auto* other = find_in(b.indices, prototype);
      if (!other || !(*other == indices)) mark(prototype, dirty::kInstanceIndex);
    }
    for (const auto& [prototype, indices] : b.indices)
      if (!find_in(a.indices, prototype)) mark(prototype, dirty::kInstanceIndex);
  }
};

RetainedSceneDelegate::RetainedSceneDelegate() : state_(std::make_unique<State>()) {
  state_->scene = this;
}
RetainedSceneDelegate::~RetainedSceneDelegate() {
  Depopulate();
}

void RetainedSceneDelegate::SetMesh(const Path& id, MeshDescription mesh) {
  state_->set(state_->meshes, id, std::move(mesh));
}

void RetainedSceneDelegate::SetInstancer(const Path& id, InstancerDescription instancer) {
  const InstancerDescription before = value_in(state_->instancers, id);
  state_->set(state_->instancers, id, std::move(instancer));
  state_->mark_prototypes(before, state_->instancers[id]);
}

bool RetainedSceneDelegate::SetInstanceValues(const Path& instancer, size_t first,
                                              const std::map<Token, Value>& elements) {
  const auto found = state_->instancers.find(instancer);
  if (found == state_->instancers.end()) return false;
  if (elements.empty()) return true;
  InstancerDescription& held = found->second;
  std::map<Token, Value> primvars = held.primvars;
  std::map<Token, TimeSamples<Value>> samples = held.primvarSamples;
  for (const auto& [primvar, part] : elements) {
    const auto now = primvars.find(primvar);
    if (now == primvars.end() || !replace_part(&now->second, first, part)) return false;
    // Instances that move stand still where they are set: their elements are the same at all times.
    if (const auto moving = samples.find(primvar); moving != samples.end())
      for (Value& sample : moving->second.values)
        if (!replace_part(&sample, first, part)) return false;
  }
  held.primvars.swap(primvars);
  held.primvarSamples.swap(samples);
  state_->mark(instancer, dirty::kPrimvar);
  return true;
}

void RetainedSceneDelegate::SetMaterial(const Path& id, MaterialNetwork network) {
  state_->set(state_->materials, id, std::move(network));
}

void RetainedSceneDelegate::SetLight(const Path& id, LightDescription light) {
  const auto* before = find_in(state_->lights, id);
  if (before && !(before->type == light.type)) Remove(id);  // another type is another prim
  state_->set(state_->lights, id, std::move(light));
}

void RetainedSceneDelegate::SetCamera(const Path& id, CameraDescription camera) {
  state_->set(state_->cameras, id, std::move(camera));
}

void RetainedSceneDelegate::SetRenderBuffer(const Path& id, RenderBufferDescriptor buffer) {
  state_->set(state_->buffers, id, std::move(buffer));
}

void RetainedSceneDelegate::SetRenderSettings(const Path& id, RenderSettingsDescription settings) {
  state_->set(state_->settings, id, std::move(settings));
}

bool RetainedSceneDelegate::Remove(const Path& id) {
  State& s = *state_;
  const InstancerDescription instancer = value_in(s.instancers, id);  // first: memory may run out
  bool is_here = false;
  s.for_each_kind([&](const auto& prims) { is_here |= prims.contains(id); });
  if (!is_here) return false;
  if (s.index) s.index->Remove(id);
  s.for_each_kind([&](auto& prims) { prims.erase(id); });
  s.mark_prototypes(instancer, {});
  return true;
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
  PopulateRest();
}

bool RetainedSceneDelegate::PopulateRest() {
  State& s = *state_;
  if (!s.index || s.is_whole) return true;
  bool whole = true;
  s.for_each_kind([&](const auto& prims) {
    for (const auto& [id, value] : prims)
      if (!s.index->Has(id)) whole = s.insert(id, value) && whole;
  });
  return s.is_whole = whole;
}

void RetainedSceneDelegate::Depopulate() {
  State& s = *state_;
  if (!s.index) return;
  s.is_whole = false;
  auto remove_all = [&](const auto& prims) {
    for (const auto& entry : prims) s.index->Remove(entry.first);
  };
  remove_all(s.meshes), remove_all(s.instancers), remove_all(s.lights), remove_all(s.materials);
  remove_all(s.cameras), remove_all(s.buffers), remove_all(s.settings);
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
  if (const auto* light = find_in(state_->lights, id)) return light->transform;
  if (const auto* camera = find_in(state_->cameras, id)) return camera->transform;
  return member_of(state_->meshes, id, &MeshDescription::transform);
}
bool RetainedSceneDelegate::GetVisible(const Path& id) {
  if (const auto* light = find_in(state_->lights, id)) return light->visible;
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
  if (const auto* mesh = find_in(state_->meshes, id))
    for (const auto& [name, primvar] : mesh->primvars)
      descriptors.push_back({name, primvar.interpolation, primvar.role, !primvar.indices.empty()});
  if (const auto* instancer = find_in(state_->instancers, id))
    for (const auto& [name, value] : instancer->primvars)
      descriptors.push_back({name, Interpolation::instance, Token(), false});
  return descriptors;
}

Value RetainedSceneDelegate::GetPrimvar(const Path& id, const Token& name, Array<int32_t>* indices) {
  if (indices) *indices = {};
  if (const auto* instancer = find_in(state_->instancers, id)) return value_in(instancer->primvars, name);
  const auto* mesh = find_in(state_->meshes, id);
  const PrimvarValue* primvar = mesh ? find_in(mesh->primvars, name) : nullptr;
  if (!primvar) return {};
  if (indices) *indices = primvar->indices;
  return primvar->value;
}

TimeSamples<Matrix4d> RetainedSceneDelegate::SampleTransform(const Path& id) {
  if (const auto* camera = find_in(state_->cameras, id)) return camera->transformSamples;
  return member_of(state_->meshes, id, &MeshDescription::transformSamples);
}
TimeSamples<Value> RetainedSceneDelegate::SamplePrimvar(const Path& id, const Token& name) {
  if (const auto* instancer = find_in(state_->instancers, id)) return value_in(instancer->primvarSamples, name);
  const auto* mesh = find_in(state_->meshes, id);
  return mesh ? value_in(mesh->primvarSamples, name) : TimeSamples<Value>();
}
TimeSamples<Matrix4d> RetainedSceneDelegate::SampleInstancerTransform(const Path& id) {
  return member_of(state_->instancers, id, &InstancerDescription::transformSamples);
}

Path RetainedSceneDelegate::GetInstancerId(const Path& id) {
  if (const auto* instancer = find_in(state_->instancers, id)) return instancer->parent;
  return member_of(state_->meshes, id, &MeshDescription::instancer);
}
Matrix4d RetainedSceneDelegate::GetInstancerTransform(const Path& id) {
  return member_of(state_->instancers, id, &InstancerDescription::transform);
}
Array<int32_t> RetainedSceneDelegate::GetInstanceIndices(const Path& instancerId, const Path& prototypeId) {
  const auto* instancer = find_in(state_->instancers, instancerId);
  return instancer ? value_in(instancer->indices, prototypeId) : Array<int32_t>();
}
std::vector<std::vector<Token>> RetainedSceneDelegate::GetInstanceCategories(const Path& id) {
  return member_of(state_->instancers, id, &InstancerDescription::categories);
}

MaterialNetwork RetainedSceneDelegate::GetMaterialResource(const Path& id) {
  return value_in(state_->materials, id);
}
Value RetainedSceneDelegate::GetLightParamValue(const Path& id, const Token& name) {
  const auto* light = find_in(state_->lights, id);
  return light ? value_in(light->parameters, name) : Value();
}
Value RetainedSceneDelegate::GetCameraParamValue(const Path& id, const Token& name) {
  const auto* camera = find_in(state_->cameras, id);
  return camera ? value_in(camera->parameters, name) : Value();
}
RenderBufferDescriptor RetainedSceneDelegate::GetRenderBufferDescriptor(const Path& id) {
  return value_in(state_->buffers, id);
}
RenderSettingsDescription RetainedSceneDelegate::GetRenderSettings(const Path& id) {
  return value_in(state_->settings, id);
}

}  // namespace alabaster::hd::host
