#include "core/camera/camera.h"

#include "delegate/prims/motion.h"
#include "delegate/prims/parameters.h"
#include "delegate/prims/prims.h"

namespace alabaster::hd::prims {
namespace {

void pull_parameters(SceneDelegate& scene, const Path& id, const alabaster::DiagnosticSink& sink,
                     CameraParameters* camera) {
  const CameraParameters defaults;
  for (const auto& parameter : camera_parameters()) {
    const Value value = scene.GetCameraParamValue(id, parameter.name);
    set_parameter(parameter, get_parameter(parameter, defaults), camera);
    if (!value.empty()) report_fault(sink, id.str(), parameter.name, set_parameter(parameter, value, camera), value);
  }
  const std::string projection = scene.GetCameraParamValue(id, "projection").text_or("perspective");
  camera->orthographic = projection == "orthographic";
  if (!camera->orthographic && projection != "perspective")
    alabaster::report(sink, alabaster::Severity::warning, "camera.projection", id.str(),
                      "projection '" + projection + "' is not known; perspective is used");
  const Value range = scene.GetCameraParamValue(id, "clippingRange");
  const auto* near_far = range.get<Vec2f>();
  const bool valid =
      near_far && near_far->x >= 0 && near_far->y >= 0 && (near_far->y == 0 || near_far->y > near_far->x);
  camera->clip_near = valid ? near_far->x : 0;
  camera->clip_far = valid ? near_far->y : 0;
  if (!range.empty() && !valid)
    alabaster::report(sink, alabaster::Severity::warning, "camera.clippingRange", id.str(),
                      "clippingRange must be near and far with 0 <= near < far; nothing is clipped");
  if (camera->shutter_close >= camera->shutter_open) return;
  alabaster::report(sink, alabaster::Severity::error, "camera.shutter", id.str(),
                    "the shutter closes before it opens (shutterOpen " + std::to_string(camera->shutter_open) +
                        ", shutterClose " + std::to_string(camera->shutter_close) + "); it is drawn as at shutterOpen");
  camera->shutter_close = camera->shutter_open;
}

}  // namespace

DirtyBits CameraPrim::post_record(SceneDelegate& scene, SceneParam& param, DirtyBits bits) {
  if (bits & dirty::kTransform) {
    record_.camera.camera_to_world = scene.GetTransform(GetId());
    record_.motion = checked_motion(scene.SampleTransform(GetId()), GetId(), param.sink());
  }
  if (bits & dirty::kParams) {
    pull_parameters(scene, GetId(), param.sink(), &record_.camera);
  }
  param.post(GetId(), record_);
  return dirty::kClean;
}

}  // namespace alabaster::hd::prims
