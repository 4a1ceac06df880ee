#include <algorithm>
#include <cmath>

#include "delegate/prims/motion.h"
#include "delegate/prims/prims.h"

namespace alabaster::hd::prims {

void update_by_instance(std::map<Token, PulledPrimvar> now, size_t points, const char* each, const Path& where,
                        SceneParam* param, std::shared_ptr<const OtherPrimvars>* held) {
  std::erase_if(now, [&](const auto& named) {
    const auto& [name, primvar] = named;
    const NumberArray numbers = numbers_of(primvar.value);
    const size_t given = primvar.indices.empty() ? numbers.count : primvar.indices.size();
    std::string fault;
    const auto is_number = [](float n) { return std::isfinite(n); };
    if (!numbers.data) return true;  // a text
    if (points > 0 && given != points)
      fault =
          " has " + std::to_string(given) + " values, " + std::to_string(points) + " are needed (one per " + each + ")";
    else if (!std::all_of(numbers.data, numbers.data + numbers.count * numbers.width, is_number))
      fault = " has values that are not finite";
    if (!fault.empty())
      alabaster::report(param->sink(), alabaster::Severity::warning, "instancer.primvar", where.str(),
                        "primvar " + name.str() + fault + "; ignored");
    return !fault.empty();
  });
  if (*held && (*held)->by_name == now) return;
  OtherPrimvars all{std::move(now)};
  hold_arrays(&all, &param->buffers(), where.str());
  *held = all.by_name.empty() ? nullptr : std::make_shared<const OtherPrimvars>(std::move(all));
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
    std::map<Token, PulledPrimvar> primvars;  // but for those that say where instances stand
    for (const PrimvarDescriptor& descriptor : scene.GetPrimvarDescriptors(GetId()))
      if (descriptor.interpolation == Interpolation::instance && !descriptor.name.str().starts_with("hydra:"))
        primvars[descriptor.name] = pull_primvar(scene, GetId(), descriptor, &param);
    update_by_instance(std::move(primvars), record_.points ? record_.points->size() : 0, "instance", GetId(), &param,
                       &record_.primvars);
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
