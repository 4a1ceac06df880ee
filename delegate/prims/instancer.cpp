#include <algorithm>
#include <cmath>

#include "delegate/prims/motion.h"
#include "delegate/prims/prims.h"

namespace alabaster::hd::prims {

// Those that say where instances stand have been pulled.
void InstancerPrim::pull_primvars(SceneDelegate& scene, SceneParam& param, const support::InstancingReport& report) {
  const std::vector<PrimvarDescriptor> descriptors = scene.GetPrimvarDescriptors(GetId());
  OtherPrimvars now;
  for (const PrimvarDescriptor& descriptor : descriptors)
    if (descriptor.interpolation == Interpolation::instance && !descriptor.name.str().starts_with("hydra:"))
      now.by_name[descriptor.name] = pull_primvar(scene, GetId(), descriptor, &param);
  const size_t points = record_.points ? record_.points->size() : 0;  // 0: as many as are asked for
  std::erase_if(now.by_name, [&](const auto& named) {
    const auto& [name, primvar] = named;
    const NumberArray numbers = numbers_of(primvar.value);
    const size_t given = primvar.indices.empty() ? numbers.count : primvar.indices.size();
    std::string fault;
    const auto is_number = [](float n) { return std::isfinite(n); };
    if (!numbers.data) return true;  // a text
    if (points > 0 && given != points)
      fault = " has " + std::to_string(given) + " values, " + std::to_string(points) + " are needed (one per instance)";
    else if (!std::all_of(numbers.data, numbers.data + numbers.count * numbers.width, is_number))
      fault = " has values that are not finite";
    if (!fault.empty()) report("instancer.primvar", GetId(), "primvar " + name.str() + fault + "; ignored");
    return !fault.empty();
  });
  if (record_.primvars && record_.primvars->by_name == now.by_name) return;
  hold_arrays(&now, &param.buffers(), GetId().str());
  record_.primvars = now.by_name.empty() ? nullptr : std::make_shared<const OtherPrimvars>(std::move(now));
}

DirtyBits InstancerPrim::post_record(SceneDelegate& scene, SceneParam& param, DirtyBits bits) {
  if (bits & dirty::kTransform) {
    record_.transform = scene.GetInstancerTransform(GetId());
    auto [times, values] = checked_motion(scene.SampleInstancerTransform(GetId()), GetId(), param.sink());
    record_.motion = {std::move(times), std::move(values)};
  }
  if (bits & dirty::kPrimvar) {
    const support::InstancingReport report = [&](const char* code, const Path& where, const std::string& text) {
      alabaster::report(param.sink(), alabaster::Severity::warning, code, where.str(), text);
    };
    auto points = support::pull_instance_points(scene, GetId(), report);
    record_.moving_points = support::pull_moving_points(scene, GetId(), points, report);
    if (!times_fault(record_.moving_points.times, record_.moving_points.values.size()).empty()) {
      report("motion.instances", GetId(), "times of samples must be finite and increase; the instances stand still");
      record_.moving_points = {};
    }
    record_.points = std::move(points);
    pull_primvars(scene, param, report);
  }
  if (bits & dirty::kInstancer) record_.parent = scene.GetInstancerId(GetId());
  if (bits & (dirty::kInstancer | dirty::kInstanceIndex))
    record_.indices_in_parent =
        record_.parent.empty() ? Array<int32_t>() : scene.GetInstanceIndices(record_.parent, GetId()).frozen();
  if (bits & dirty::kCategories) {
    auto categories = scene.GetInstanceCategories(GetId());
    record_.categories.reset();
    if (!categories.empty())
      record_.categories = std::make_shared<const std::vector<std::vector<Token>>>(std::move(categories));
  }
  param.post(GetId(), record_);
  return dirty::kClean;
}

}  // namespace alabaster::hd::prims
