#include "delegate/prims/prims.h"

namespace alabaster::hd::prims {

DirtyBits RenderSettingsPrim::post_record(SceneDelegate& scene, SceneParam& param, DirtyBits bits) {
  if (bits & (dirty::kParams | dirty::kDescription))
    param.post(GetId(), SettingsRecord{scene.GetRenderSettings(GetId())});
  return dirty::kClean;
}

}  // namespace alabaster::hd::prims
