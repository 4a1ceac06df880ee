#include "delegate/hydra/plugin/hydra_param.h"

#include <pxr/imaging/hd/light.h>
#include <pxr/imaging/hd/renderIndex.h>

namespace alabaster::hydra {

void HydraParam::set_domes_visible(bool visible) {
  if (visible == domes_visible_) return;
  domes_visible_ = visible;
  for (const auto& [id, index] : lights_) index->GetChangeTracker().MarkSprimDirty(id, pxr::HdLight::DirtyParams);
}

void HydraParam::write_scene(const hd::RenderPassState& state) const {
  if (!capture_ || scene_file_.empty()) return;
  std::map<hd::Token, hd::Value> settings;
  for (const hd::RenderSettingDescriptor& setting : delegate_->GetRenderSettingDescriptors())
    settings[setting.key] = delegate_->GetRenderSetting(setting.key);
  const std::string fault = capture_->Write(scene_file_, state, settings);
  if (!fault.empty()) sink_({hd::Severity::error, "hydra.writeScene", scene_file_, fault});
}

}  // namespace alabaster::hydra
