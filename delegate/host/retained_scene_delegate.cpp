#include "delegate/host/retained_scene_delegate.h"

#include <algorithm>
#include <utility>

#include "delegate/host/open_fields.h"
#include "delegate/support/float_values.h"
#include "delegate/support/lookup.h"

namespace alabaster::hd::host {
namespace {

using support::find_in;
using support::value_in;

/// Copies an array with the elements from `first` on replaced. Numbers of two types become the floats that Sync makes
/// of them. False: an element has another number of components, or the array ends before them.
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
  try_type(Array<float>()), try_type(Array<Vec2f>()), try_type(Array<Vec4f>());
  if (fits || !array->is_array() || !part.is_array()) return fits;
  Value floats = support::FloatValues(*array);
  const Value elements = support::FloatValues(part);
  if (floats.type() == array->type() && elements.type() == part.type()) return false;  // tried above
  if (!replace_part(&floats, first, elements)) return false;
  *array = std::move(floats);
  return true;
}

std::vector<PrimvarDescriptor> descriptors_of(const MeshDescription& mesh) {
  std::vector<PrimvarDescriptor> descriptors;
  for (const auto& [name, primvar] : mesh.primvars)
    descriptors.push_back({name, primvar.interpolation, primvar.role, !primvar.indices.empty()});
  return descriptors;
}
std::vector<PrimvarDescriptor> descriptors_of(const InstancerDescription& instancer) {
  std::vector<PrimvarDescriptor> descriptors;
  for (const auto& [name, values] : instancer.primvars)
    descriptors.push_back({name, Interpolation::instance, value_in(instancer.primvarRoles, name), false});
  return descriptors;
}

Value value_of(const PrimvarValue& primvar, Array<int32_t>* indices) {
  if (indices) *indices = primvar.indices;
  return primvar.value;
}
Value value_of(const Value& primvar, Array<int32_t>*) {
  return primvar;
}
template <class Primvar>
Value primvar_of(const std::map<Token, Primvar>& primvars, const Token& name, Array<int32_t>* indices) {
  const Primvar* primvar = find_in(primvars, name);
  return primvar ? value_of(*primvar, indices) : Value();
}

using Indices = std::map<Path, Array<int32_t>>;
const Indices& indices_of(const PrimDescription* prim) {
  static const Indices none;
  const auto* instancer = prim ? std::get_if<InstancerDescription>(prim) : nullptr;
  return instancer ? instancer->indices : none;
}

/// Another type of light or mesh is another prim.
bool is_same_prim(const PrimDescription& a, const PrimDescription& b) {
  return TypeOf(a) == TypeOf(b);
}

}  // namespace

struct RetainedSceneDelegate::State {
  Prims prims;
  std::map<Path, std::string> names;
  RenderIndex* index = nullptr;
  bool is_whole = false;  // there is an index, and it has all prims
  RetainedSceneDelegate* scene = nullptr;

  /// Enters a prim into the index. False: memory ran out.
  bool insert(const Path& id, const PrimDescription& prim) const {
    const Kind& kind = kind_of(prim);
    if (!kind.insert) return index->InsertInstancer(scene, id);
    const Token type = std::holds_alternative<RenderBufferDescriptor>(prim) ? Token(kind.name) : TypeOf(prim);
    const bool is_light = std::holds_alternative<LightDescription>(prim);
    const std::vector<Token>& known = index->GetRenderDelegate()->GetSupportedSprimTypes();
    if (is_light && std::find(known.begin(), known.end(), type) == known.end()) return true;
    return (index->*kind.insert)(type, scene, id);
  }
  void mark(const Path& id, DirtyBits bits) const {
    if (index && index->Has(id)) index->GetChangeTracker().MarkDirty(id, bits);
  }
  /// Prototypes whose indices differ pull them again; so do those that came or went.
  void mark_prototypes(const PrimDescription* before, const PrimDescription* after) const {
    const Indices &a = indices_of(before), &b = indices_of(after);
    for (const auto& [prototype, indices] : a) {
      const auto* other = find_in(b, prototype);
      if (!other || !(*other == indices)) mark(prototype, dirty::kInstanceIndex);
    }
    for (const auto& [prototype, indices] : b)
      if (!find_in(a, prototype)) mark(prototype, dirty::kInstanceIndex);
  }

  /// What `get` takes of the prim of that path; of a T with the defaults where there is none of a kind that has it.
  template <class T, class Get>
  auto pull(const Path& id, const Get& get) const {
    using Result = std::decay_t<decltype(get(T()))>;
    const auto take = [&get]<class Prim>(const Prim& prim) -> Result {
      if constexpr (std::is_invocable_r_v<Result, const Get&, const Prim&>)
        return get(prim);
      else
        return get(T());
    };
    const auto* prim = find_in(prims, id);
    return prim ? std::visit(take, *prim) : take(T());
  }
  template <class T>
  T held(const Path& id) const {
    const T* prim = FindPrim<T>(prims, id);
    return prim ? *prim : T();
  }
};

RetainedSceneDelegate::RetainedSceneDelegate() : state_(std::make_unique<State>()) {
  state_->scene = this;
}
RetainedSceneDelegate::~RetainedSceneDelegate() {
  Depopulate();
}

void RetainedSceneDelegate::Set(const Path& id, PrimDescription prim) {
  State& s = *state_;
  if (const auto found = s.prims.find(id); found != s.prims.end()) {
    if (is_same_prim(found->second, prim)) {
      if (s.index) s.index->GetChangeTracker().MarkDirty(id, difference(found->second, prim));
      s.mark_prototypes(&found->second, &prim);
      found->second = std::move(prim);
      return;
    }
    Remove(id);
  }
  const PrimDescription& entered = s.prims.emplace(id, std::move(prim)).first->second;
  if (!s.index) return;
  const bool has_others = std::exchange(s.is_whole, false);
  s.is_whole = s.insert(id, entered) && has_others;
  s.mark_prototypes(nullptr, &entered);
}

bool RetainedSceneDelegate::Remove(const Path& id) {
  State& s = *state_;
  const auto found = s.prims.find(id);
  if (found == s.prims.end()) return false;
  if (s.index) s.index->Remove(id);
  const auto gone = s.prims.extract(found);  // takes no memory, which may have run out
  s.names.erase(id);
  s.mark_prototypes(&gone.mapped(), nullptr);
  return true;
}

const Prims& RetainedSceneDelegate::GetPrims() const {
  return state_->prims;
}

void RetainedSceneDelegate::SetName(const Path& id, std::string name) {
  if (name.empty() || !state_->prims.contains(id))
    state_->names.erase(id);
  else
    state_->names.insert_or_assign(id, std::move(name));
}
std::string RetainedSceneDelegate::GetName(const Path& id) const {
  const std::string* name = find_in(state_->names, id);
  return name ? *name : id.str().substr(id.str().rfind('/') + 1);
}
const std::map<Path, std::string>& RetainedSceneDelegate::GetNames() const {
  return state_->names;
}

bool RetainedSceneDelegate::SetInstanceValues(const Path& instancer, size_t first,
                                              const std::map<Token, Value>& elements) {
  auto* prim = find_in(state_->prims, instancer);
  auto* held = prim ? std::get_if<InstancerDescription>(prim) : nullptr;
  if (!held) return false;
  if (elements.empty()) return true;
  std::map<Token, Value> primvars = held->primvars;
  std::map<Token, TimeSamples<Value>> samples = held->primvarSamples;
  for (const auto& [primvar, part] : elements) {
    const auto now = primvars.find(primvar);
    if (now == primvars.end() || !replace_part(&now->second, first, part)) return false;
    // Instances that move stand still where they are set: their elements are the same at all times.
    if (const auto moving = samples.find(primvar); moving != samples.end())
      for (Value& sample : moving->second.values)
        if (!replace_part(&sample, first, part)) return false;
  }
  held->primvars.swap(primvars);
  held->primvarSamples.swap(samples);
  state_->mark(instancer, dirty::kPrimvar);
  return true;
}

void RetainedSceneDelegate::Populate(RenderIndex* index) {
  Depopulate();
  state_->index = index;
  PopulateRest();
}

bool RetainedSceneDelegate::PopulateRest() {
  State& s = *state_;
  if (!s.index || s.is_whole) return true;
  bool whole = true;
  for (size_t kind = std::variant_size_v<PrimDescription>; kind-- > 0;)
    for (const auto& [id, prim] : s.prims)
      if (prim.index() == kind && !s.index->Has(id)) whole = s.insert(id, prim) && whole;
  return s.is_whole = whole;
}

void RetainedSceneDelegate::Depopulate() {
  State& s = *state_;
  if (!s.index) return;
  s.is_whole = false;
  for (size_t kind = 0; kind < std::variant_size_v<PrimDescription>; ++kind)
    for (const auto& [id, prim] : s.prims)
      if (prim.index() == kind) s.index->Remove(id);
  s.index = nullptr;
}

MeshTopology RetainedSceneDelegate::GetMeshTopology(const Path& id) {
  return state_->pull<MeshDescription>(id, [](const MeshDescription& prim) { return prim.topology; });
}
SubdivTags RetainedSceneDelegate::GetSubdivTags(const Path& id) {
  return state_->pull<MeshDescription>(id, [](const MeshDescription& prim) { return prim.subdivTags; });
}
BasisCurvesTopology RetainedSceneDelegate::GetBasisCurvesTopology(const Path& id) {
  return state_->pull<MeshDescription>(id, [](const MeshDescription& prim) { return prim.curves; });
}
DisplayStyle RetainedSceneDelegate::GetDisplayStyle(const Path& id) {
  return state_->pull<MeshDescription>(id, [](const MeshDescription& prim) { return prim.displayStyle; });
}
Matrix4d RetainedSceneDelegate::GetTransform(const Path& id) {
  return state_->pull<MeshDescription>(id,
                                       [](const auto& prim) -> decltype((prim.transform)) { return prim.transform; });
}
bool RetainedSceneDelegate::GetVisible(const Path& id) {
  return state_->pull<MeshDescription>(id, [](const auto& prim) -> decltype((prim.visible)) { return prim.visible; });
}
bool RetainedSceneDelegate::GetDoubleSided(const Path& id) {
  return state_->pull<MeshDescription>(id, [](const MeshDescription& prim) { return prim.doubleSided; });
}
CullStyle RetainedSceneDelegate::GetCullStyle(const Path& id) {
  return state_->pull<MeshDescription>(id, [](const MeshDescription& prim) { return prim.cullStyle; });
}
Token RetainedSceneDelegate::GetRenderTag(const Path& id) {
  return state_->pull<MeshDescription>(id,
                                       [](const auto& prim) -> decltype((prim.renderTag)) { return prim.renderTag; });
}
Token RetainedSceneDelegate::GetDisplayName(const Path& id) {
  const std::string* name = find_in(state_->names, id);
  return name ? Token(*name) : Token();
}
std::vector<Token> RetainedSceneDelegate::GetCategories(const Path& id) {
  return state_->pull<MeshDescription>(id,
                                       [](const auto& prim) -> decltype((prim.categories)) { return prim.categories; });
}
Path RetainedSceneDelegate::GetMaterialId(const Path& id) {
  return state_->pull<MeshDescription>(id, [](const auto& prim) -> decltype((prim.material)) { return prim.material; });
}

std::vector<PrimvarDescriptor> RetainedSceneDelegate::GetPrimvarDescriptors(const Path& id) {
  return state_->pull<MeshDescription>(
      id, [](const auto& prim) -> decltype(descriptors_of(prim)) { return descriptors_of(prim); });
}
Value RetainedSceneDelegate::GetPrimvar(const Path& id, const Token& name, Array<int32_t>* indices) {
  if (indices) *indices = {};
  return state_->pull<MeshDescription>(id, [&](const auto& prim) -> decltype(primvar_of(prim.primvars, name, indices)) {
    return primvar_of(prim.primvars, name, indices);
  });
}

TimeSamples<Matrix4d> RetainedSceneDelegate::SampleTransform(const Path& id) {
  return state_->pull<MeshDescription>(
      id, [](const auto& prim) -> decltype((prim.transformSamples)) { return prim.transformSamples; });
}
TimeSamples<Value> RetainedSceneDelegate::SamplePrimvar(const Path& id, const Token& name) {
  return state_->pull<MeshDescription>(id, [&](const auto& prim) -> decltype(value_in(prim.primvarSamples, name)) {
    return value_in(prim.primvarSamples, name);
  });
}
TimeSamples<Matrix4d> RetainedSceneDelegate::SampleInstancerTransform(const Path& id) {
  return RetainedSceneDelegate::SampleTransform(id);
}

Path RetainedSceneDelegate::GetInstancerId(const Path& id) {
  if (const auto* instancer = FindPrim<InstancerDescription>(state_->prims, id)) return instancer->parent;
  return state_->pull<MeshDescription>(id,
                                       [](const auto& prim) -> decltype((prim.instancer)) { return prim.instancer; });
}
Matrix4d RetainedSceneDelegate::GetInstancerTransform(const Path& id) {
  return RetainedSceneDelegate::GetTransform(id);
}
Array<int32_t> RetainedSceneDelegate::GetInstanceIndices(const Path& instancerId, const Path& prototypeId) {
  return value_in(indices_of(find_in(state_->prims, instancerId)), prototypeId);
}
std::vector<std::vector<Token>> RetainedSceneDelegate::GetInstanceCategories(const Path& id) {
  return state_->pull<InstancerDescription>(id, [](const InstancerDescription& prim) { return prim.categories; });
}

MaterialNetwork RetainedSceneDelegate::GetMaterialResource(const Path& id) {
  return state_->held<MaterialNetwork>(id);
}
Value RetainedSceneDelegate::GetLightParamValue(const Path& id, const Token& name) {
  return state_->pull<LightDescription>(id, [&](const auto& prim) -> decltype(value_in(prim.parameters, name)) {
    return value_in(prim.parameters, name);
  });
}
Value RetainedSceneDelegate::GetCameraParamValue(const Path& id, const Token& name) {
  return RetainedSceneDelegate::GetLightParamValue(id, name);
}
RenderBufferDescriptor RetainedSceneDelegate::GetRenderBufferDescriptor(const Path& id) {
  return state_->held<RenderBufferDescriptor>(id);
}
RenderSettingsDescription RetainedSceneDelegate::GetRenderSettings(const Path& id) {
  return state_->held<RenderSettingsDescription>(id);
}

}  // namespace alabaster::hd::host
