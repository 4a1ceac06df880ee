#include "core/color/blackbody.h"
#include "core/light/ies_profile.h"

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

std::shared_ptr<const IesProfile> pull_profile(SceneDelegate& scene, const Path& id, SceneParam& param,
                                               std::optional<SceneFault>* fault) {
  const std::string path = scene.GetLightParamValue(id, "shaping:ies:file").text_or("");
  if (path.empty()) return nullptr;
  auto profile = IesProfile::load(path, param.sink());
  if (!profile) *fault = SceneFault{true, "the IES profile '" + path + "' could not be read"};
  return profile;
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
  if (bits & dirty::kVisibility) visible_ = scene.GetVisible(GetId());
  if (bits & (dirty::kParams | dirty::kResource)) {
    const ColorConfig& colors = param.colors();
    light_.color_of_temperature = blackbody(light_.color_temperature, colors.chromaticities(colors.rendering_space()));
    const bool infinite = light_.type == LightType::dome || light_.type == LightType::distant;
    std::optional<SceneFault> fault;
    light_.ies = infinite ? nullptr : pull_profile(scene, GetId(), param, &fault);
    const bool image = light_.type == LightType::dome || light_.type == LightType::rect;
    light_.texture = image ? pull_texture(scene, GetId(), param, &fault) : nullptr;
    param.set_fault(GetId(), std::move(fault));
  }
  param.post(GetId(), LightRecord{light_, visible_});
  return dirty::kClean;
}

}  // namespace alabaster::hd::prims
