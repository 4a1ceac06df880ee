// Gives back the arrays that a host's struct lends, in the order in which the struct has them.
#include "delegate/c_api/values.h"

namespace alabaster::hd::c_api {
namespace {

template <class T>
std::span<const T> all_of(const T* first, size_t count) {
  return {first, first ? count : 0};
}

void give_back(const AlabasterValue& in) {
  if (!in.release) return;
  const CallbackScope scope;
  in.release(in.owner);
}
void give_back(const AlabasterMotion& in) {
  for (const auto& value : all_of(in.values, in.count)) give_back(value);
}
void give_back(const ParameterList& in) {
  for (const auto& parameter : all_of(in.first, in.count)) give_back(parameter.value);
}
void give_back(const AlabasterPrimvar& in) {
  give_back(in.value);
  give_back(in.indices);
  give_back(in.motion);
}
void give_back(const AlabasterMesh& in) {
  for (const auto* value :
       {&in.face_vertex_counts, &in.face_vertex_indices, &in.hole_indices, &in.categories, &in.invisible_faces})
    give_back(*value);
  for (const auto& primvar : all_of(in.primvars, in.primvar_count)) give_back(primvar);
  for (const auto& subset : all_of(in.subsets, in.subset_count)) give_back(subset.faces);
  give_back(in.motion);
  if (!in.subdiv_tags) return;
  const AlabasterSubdivTags tags = members_of(*in.subdiv_tags);
  for (const auto* value :
       {&tags.crease_indices, &tags.crease_lengths, &tags.crease_weights, &tags.corner_indices, &tags.corner_weights})
    give_back(*value);
}
void give_back(const AlabasterInstancer& in) {
  for (const auto& primvar : all_of(in.primvars, in.primvar_count)) give_back(primvar);
  for (const auto& prototype : all_of(in.prototypes, in.prototype_count)) give_back(prototype.indices);
  give_back(in.motion);
}
void give_back(const AlabasterMaterial& in) {
  for (const auto& node : all_of(in.nodes, in.node_count))
    give_back(ParameterList{node.parameters, node.parameter_count});
}
void give_back(const AlabasterLight& in) {
  give_back(ParameterList{in.parameters, in.parameter_count});
}
void give_back(const AlabasterCamera& in) {
  give_back(ParameterList{in.parameters, in.parameter_count});
  give_back(in.motion);
}
void give_back(const AlabasterRenderSettings& in) {
  give_back(ParameterList{in.settings, in.setting_count});
}
void give_back(const AlabasterDelegateOptions& in) {
  give_back(ParameterList{in.settings, in.setting_count});
}
void give_back(const AlabasterFrame& in) {
  for (const auto* value : {&in.render_tags, &in.roots, &in.excluded}) give_back(*value);
  if (in.free_camera) give_back(members_of(*in.free_camera));
}

}  // namespace

template <class T>
void ValueReader::give_back_all(const void* given) {
  const T& in = *static_cast<const T*>(given);
  if constexpr (requires { in.size; })
    give_back(members_of(in));
  else
    give_back(in);
}
template void ValueReader::give_back_all<AlabasterValue>(const void*);
template void ValueReader::give_back_all<ParameterList>(const void*);
template void ValueReader::give_back_all<AlabasterPrimvar>(const void*);
template void ValueReader::give_back_all<AlabasterMesh>(const void*);
template void ValueReader::give_back_all<AlabasterInstancer>(const void*);
template void ValueReader::give_back_all<AlabasterMaterial>(const void*);
template void ValueReader::give_back_all<AlabasterLight>(const void*);
template void ValueReader::give_back_all<AlabasterCamera>(const void*);
template void ValueReader::give_back_all<AlabasterRenderSettings>(const void*);
template void ValueReader::give_back_all<AlabasterDelegateOptions>(const void*);
template void ValueReader::give_back_all<AlabasterFrame>(const void*);

}  // namespace alabaster::hd::c_api
