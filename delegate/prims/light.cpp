#include "core/light/light.h"

#include "delegate/prims/parameters.h"
#include "delegate/prims/prims.h"

namespace alabaster::hd::prims {
namespace {

std::shared_ptr<const Texture> pull_texture(SceneDelegate& scene, const Path& id, SceneParam& param,
                                            std::optional<SceneFault>* fault) {
  const Value file = scene.GetLightParamValue(id, "texture:file");
  TextureSource source;
  source.path = file.text_or("");
  if (const auto* asset = file.get<AssetPath>()) source.bytes = asset->bytes;
  if (source.path.empty() && !source.bytes) return nullptr;
  source.wrap_t = Wrap::clamp;  // round the horizon, but not over the poles
  return param.texture(source, fault);
}

}  // namespace

DirtyBits LightPrim::post_record(SceneDelegate& scene, SceneParam& param, DirtyBits bits) {
  if (bits & dirty::kTransform) light_.light_to_world = scene.GetTransform(GetId());
  if (bits & dirty::kParams) {
    const alabaster::LightDescription defaults;
    for (const auto& parameter : light_parameters()) {
      const Value value = scene.GetLightParamValue(GetId(), parameter.name);
      set_parameter(parameter, get_parameter(parameter, defaults), &light_);
      if (value.empty()) continue;
      report_fault(param.sink(), GetId().str(), parameter.name, set_parameter(parameter, value, &light_), value);
    }
  }
  if ((bits & (dirty::kParams | dirty::kResource)) && light_.type == LightType::dome) {
    std::optional<SceneFault> fault;
    light_.texture = pull_texture(scene, GetId(), param, &fault);
    param.set_fault(GetId(), std::move(fault));
  }
  param.post(GetId(), LightRecord{light_});
  return dirty::kClean;
}

}  // namespace alabaster::hd::prims
