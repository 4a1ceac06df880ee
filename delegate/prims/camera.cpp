#include "core/camera/camera.h"

#include <algorithm>
#include <functional>

#include "delegate/prims/motion.h"
#include "delegate/prims/parameters.h"
#include "delegate/prims/prims.h"
#include "delegate/support/lookup.h"

namespace alabaster::hd::prims {
namespace {

using GetParameter = std::function<Value(const Token& name)>;

bool is_plane(const Vec4f& plane) {
  const Vec3f n(plane.x, plane.y, plane.z);
  return is_finite(n) && std::isfinite(plane.w) && n != Vec3f(0, 0, 0);
}

void pull_clipping(const GetParameter& get, const Path& id, const alabaster::DiagnosticSink& sink,
                   CameraParameters* camera) {
  const Value range = get("clippingRange");
  const auto* near_far = range.get<Vec2f>();
  const bool valid =
      near_far && near_far->x >= 0 && near_far->y >= 0 && (near_far->y == 0 || near_far->y > near_far->x);
  camera->clip_near = valid ? near_far->x : 0;
  camera->clip_far = valid ? near_far->y : 0;
  if (!range.empty() && !valid)
    alabaster::report(sink, alabaster::Severity::warning, "camera.clippingRange", id.str(),
                      "clippingRange must be near and far with 0 <= near < far; nothing is clipped");
  const Value planes = get("clipPlanes");
  const auto given = planes.get_or(Array<Vec4f>());
  camera->clip_planes.assign(given.begin(), given.end());
  if (std::erase_if(camera->clip_planes, [](const Vec4f& plane) { return !is_plane(plane); }) > 0 ||
      (!planes.empty() && !planes.get<Array<Vec4f>>()))
    alabaster::report(sink, alabaster::Severity::warning, "camera.clipPlanes", id.str(),
                      "clipPlanes must be an array of four finite numbers each, the first three not all 0; others do "
                      "not clip");
}

// The samples of one row; empty where it stands still, and where they are faulty (reported).
alabaster::TimeSamples<float> pull_samples(const GetParameter& get, const Parameter<CameraParameters>& row,
                                           float CameraParameters::*member, const Path& id,
                                           const alabaster::DiagnosticSink& sink) {
  const std::string name = std::string(row.name) + ":samples";
  const Value value = get(name);
  if (value.empty()) return {};
  const auto* given = value.get<std::shared_ptr<const hd::TimeSamples<Value>>>();
  std::string fault = given ? times_fault((*given)->times, (*given)->values.size()) : "they are no values at times";
  alabaster::TimeSamples<float> samples;
  CameraParameters read;
  auto worst = support::ParameterFault::none;
  Value odd;
  for (size_t i = 0; fault.empty() && i < (*given)->values.size(); ++i) {
    const auto found = support::set_parameter(row, (*given)->values[i], &read);
    if (found == support::ParameterFault::type) fault = "a value is no number";
    if (found == support::ParameterFault::range) worst = found, odd = (*given)->values[i];
    samples.times.push_back((*given)->times[i]), samples.values.push_back(read.*member);
  }
  if (!fault.empty()) {
    alabaster::report(sink, alabaster::Severity::warning, "motion.lens", id.str(),
                      name + " cannot be used: " + fault + "; the lens stands still");
    return {};
  }
  report_fault(sink, id.str(), name, worst, odd);
  return samples.moves() ? samples : alabaster::TimeSamples<float>();
}

void pull_lens(const GetParameter& get, const Path& id, const alabaster::DiagnosticSink& sink,
               CameraParameters* camera) {
  using P = CameraParameters;
  struct Moving {
    float P::*value;
    alabaster::TimeSamples<float> P::*samples;
  };
  constexpr Moving kMoving[] = {
      {&P::focal_length, &P::focal_lengths}, {&P::f_stop, &P::f_stops}, {&P::focus_distance, &P::focus_distances}};
  for (const auto& row : camera_parameters())
    for (const auto& [value, samples] : kMoving)
      if (const auto* member = std::get_if<float P::*>(&row.member); member && *member == value)
        camera->*samples = pull_samples(get, row, value, id, sink);
}

void pull_parameters(const GetParameter& get, const Path& id, const alabaster::DiagnosticSink& sink,
                     CameraParameters* camera) {
  read_parameters(camera_parameters(), get, id.str(), sink, camera);
  pull_lens(get, id, sink, camera);
  const std::string projection = get("projection").text_or("perspective");
  camera->orthographic = projection == "orthographic";
  if (!camera->orthographic && projection != "perspective")
    alabaster::report(sink, alabaster::Severity::warning, "camera.projection", id.str(),
                      "projection '" + projection + "' is not known; perspective is used");
  pull_clipping(get, id, sink, camera);
  const auto is_ever = [](float value, const alabaster::TimeSamples<float>& samples) {
    return value > 0 || std::any_of(samples.values.begin(), samples.values.end(), [](float v) { return v > 0; });
  };
  const bool has_lens = is_ever(camera->f_stop, camera->f_stops);
  if (has_lens && camera->orthographic)
    alabaster::report(sink, alabaster::Severity::warning, "camera.focus", id.str(),
                      "fStop has no effect: an orthographic camera has no lens; set fStop to 0");
  else if (has_lens && !is_ever(camera->focus_distance, camera->focus_distances))
    alabaster::report(sink, alabaster::Severity::warning, "camera.focus", id.str(),
                      "fStop has no effect while focusDistance is 0: set focusDistance to the distance from the camera "
                      "to what is sharp, or fStop to 0");
  if (camera->shutter_close >= camera->shutter_open) return;
  alabaster::report(sink, alabaster::Severity::warning, "camera.shutter", id.str(),
                    "the shutter closes before it opens (shutterOpen " + Value(camera->shutter_open).to_string() +
                        ", shutterClose " + Value(camera->shutter_close).to_string() +
                        "); it is drawn as at shutterOpen");
  camera->shutter_close = camera->shutter_open;
}

}  // namespace

DirtyBits CameraPrim::post_record(SceneDelegate& scene, SceneParam& param, DirtyBits bits) {
  if (bits & dirty::kTransform) {
    record_.camera.camera_to_world = scene.GetTransform(GetId());
    record_.motion = checked_motion(scene.SampleTransform(GetId()), GetId(), param.sink());
  }
  if (bits & dirty::kParams) {
    std::vector<alabaster::Diagnostic> found;
    pull_parameters([&](const Token& name) { return scene.GetCameraParamValue(GetId(), name); }, GetId(),
                    [&](const alabaster::Diagnostic& d) { found.push_back(d); }, &record_.camera);
    faults_.report(param.sink(), std::move(found));
  }
  param.post(GetId(), record_);
  return dirty::kClean;
}

CameraRecord record_of(const CameraDescription& camera, const Path& where, const alabaster::DiagnosticSink& sink,
                       KnownFaults* faults) {
  CameraRecord record;
  std::vector<alabaster::Diagnostic> found;
  const alabaster::DiagnosticSink keep = [&](const alabaster::Diagnostic& d) { found.push_back(d); };
  record.camera.camera_to_world = camera.transform;
  record.motion = checked_motion(camera.transformSamples, where, keep);
  const auto get = [&](const Token& name) { return support::value_in(camera.parameters, name); };
  pull_parameters(get, where, keep, &record.camera);
  faults->report(sink, std::move(found));
  return record;
}

}  // namespace alabaster::hd::prims
