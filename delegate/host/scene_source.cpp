#include "delegate/host/scene_source.h"

#include "delegate/support/lookup.h"

namespace alabaster::hd::host {

std::string ApplyEdits(SceneEdits edits, RetainedSceneDelegate* scene) {
  RetainedSceneDelegate changed;
  for (const auto& [path, fields] : edits.changes) {
    const PrimDescription* before = support::find_in(edits.prims, path);
    if (!before) before = support::find_in(scene->GetPrims(), path);
    if (!before) continue;
    changed.Set(path, *before);
    const SetResult result = EditPrim(&changed, path, fields);
    if (result.found && !result.fault.empty()) return path.str() + ": " + result.fault;
  }
  for (auto& [path, prim] : edits.prims) {
    scene->Set(path, std::move(prim));
    scene->SetName(path, support::value_in(edits.names, path));
  }
  for (const auto& [path, prim] : changed.GetPrims()) scene->Set(path, prim);
  for (const Path& path : edits.removed) scene->Remove(path);
  return {};
}

}  // namespace alabaster::hd::host
