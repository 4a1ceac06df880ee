#include "delegate/prims/motion.h"
#include "delegate/prims/prims.h"

namespace alabaster::hd::prims {

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
