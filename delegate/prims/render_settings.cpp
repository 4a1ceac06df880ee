#include "delegate/prims/prims.h"

namespace alabaster::hd::prims {

void RenderSettingsPrim::Sync(SceneDelegate* scene, RenderParam* render_param, DirtyBits* bits) {
  SceneParam& param = SceneParam::of(render_param);
  const bool synced = guarded(param.sink(), GetId().str(), [&] {
    if (*bits & (dirty::kParams | dirty::kDescription))
      param.post(GetId(), SettingsRecord{scene->GetRenderSettings(GetId())});
  });
  if (synced) *bits = dirty::kClean;
}

void RenderSettingsPrim::Finalize(RenderParam* param) {
  SceneParam::of(param).remove(GetId());
}

}  // namespace alabaster::hd::prims
