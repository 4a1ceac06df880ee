// Gives back the arrays that a host lends with an argument, in the order in which it has them.
#include "delegate/c_api/values.h"

namespace alabaster::hd::c_api {
namespace {

template <class T>
std::span<const T> all_of(const T* first, size_t count) {
  return {first, first ? count : 0};
}

void give_back(const AlabasterValue& in) {
  if (in.type == ALABASTER_SAMPLES)
    for (const auto& sample : all_of(static_cast<const AlabasterSample*>(in.data), in.count)) give_back(sample.value);
  if (!in.release) return;
  const CallbackScope scope;
  in.release(in.owner);
}
void give_back(const ParameterList& in) {
  for (const auto& parameter : all_of(in.first, in.count)) give_back(parameter.value);
}
void give_back(const AlabasterDelegateOptions& in) {
  give_back(ParameterList{in.settings, in.setting_count});
}
void give_back(const AlabasterFrame& in) {
  for (const auto* value : {&in.render_tags, &in.roots, &in.excluded}) give_back(*value);
  give_back(ParameterList{in.free_camera, in.free_camera_count});
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
template void ValueReader::give_back_all<AlabasterDelegateOptions>(const void*);
template void ValueReader::give_back_all<AlabasterFrame>(const void*);

}  // namespace alabaster::hd::c_api
