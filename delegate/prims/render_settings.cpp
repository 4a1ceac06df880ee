#include "core/session/render_settings.h"
#include "delegate/prims/parameters.h"
#include "delegate/prims/prims.h"
#include "delegate/support/parameters.h"

namespace alabaster::hd::prims {

DirtyBits RenderSettingsPrim::post_record(SceneDelegate& scene, SceneParam& param, DirtyBits bits) {
  if (!(bits & (dirty::kParams | dirty::kDescription))) return dirty::kClean;
  const RenderSettingsDescription description = scene.GetRenderSettings(GetId());
  // Values are reported here, once for each edit. DelegateState::render_settings() reads them when a render starts.
  RenderSettings unused;
  for (const SettingParameter& row : setting_parameters())
    if (const auto given = description.settings.find(row.name); given != description.settings.end())
      report_fault(param.sink(), GetId().str(), row.name, support::set_parameter(row, given->second, &unused),
                   given->second);
  param.post(GetId(), SettingsRecord{description});
  changed_();
  return dirty::kClean;
}

}  // namespace alabaster::hd::prims
