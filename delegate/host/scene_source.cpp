#include "delegate/host/scene_source.h"

#include "delegate/support/lookup.h"

namespace alabaster::hd::host {

std::string ApplyEdits(SceneEdits edits, RetainedSceneDelegate* scene) {
  for (auto& [path, prim] : edits.prims) {
    scene->Set(path, std::move(prim));
    scene->SetName(path, support::value_in(edits.names, path));
  }
  for (const auto& [path, fields] : edits.changes) {
    const SetResult result = EditPrim(scene, path, fields);
    if (result.found && !result.fault.empty()) return path.str() + ": " + result.fault;
  }
  for (const Path& path : edits.removed) scene->Remove(path);
  return {};
}

}  // namespace alabaster::hd::host
