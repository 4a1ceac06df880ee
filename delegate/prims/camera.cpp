#include "core/camera/camera.h"

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

void pull_parameters(const GetParameter& get, const Path& id, const alabaster::DiagnosticSink& sink,
                     CameraParameters* camera) {
  read_parameters(camera_parameters(), get, id.str(), sink, camera);
  const std::string projection = get("projection").text_or("perspective");
  camera->orthographic = projection == "orthographic";
  if (!camera->orthographic && projection != "perspective")
    alabaster::report(sink, alabaster::Severity::warning, "camera.projection", id.str(),
                      "projection '" + projection + "' is not known; perspective is used");
  pull_clipping(get, id, sink, camera);
  if (camera->f_stop > 0 && camera->orthographic)
    alabaster::report(sink, alabaster::Severity::warning, "camera.focus", id.str(),
                      "fStop has no effect: an orthographic camera has no lens; set fStop to 0");
  else if (camera->f_stop > 0 && !(camera->focus_distance > 0))
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
