// The configurations that a study compares: a base, others that each differ from it in one setting, and the presets of
// quality. Rows are what users choose.
#pragma once

#include <string>
#include <vector>

#include "delegate/api/render_delegate.h"
#include "delegate/host/retained_scene_delegate.h"

namespace alabaster::tradeoff {

/// One way to render the scene.
struct Configuration {
  std::string name;         // "walk", "maxDepth=4"
  std::string group;        // the setting: "base", "subsurface", "maxDepth"
  hd::Dictionary settings;  // every setting that differs from the renderer's default, except samples and seed
  int coarser = 0;          // levels of subdivision fewer than the scene asks for
  std::string flags = {};   // of `alabaster render`, for a user who chooses it; empty: none

  /// Identifies the settings: a stored measurement with the same fingerprint may be used again.
  std::string fingerprint() const;
  /// Samples per pixel from which the settings have an effect.
  uint64_t first_samples() const;
};

struct SceneTraits {
  bool subsurface = false;  // light goes below some surface
  bool textures = false;    // some material has an image
  int refine_level = 0;     // the highest of any subdivided mesh
};
/// `delegate` has been synced with the scene.
SceneTraits traits_of(const hd::host::RetainedSceneDelegate& scene, hd::RenderDelegate* delegate);

struct ConfigurationList {
  Configuration reference;              // the most accurate; all others are measured against it
  std::vector<Configuration> measured;  // the base first
  std::vector<std::string> skipped;     // "inversion: the scene has no subsurface"
};

/// `scene_settings` are the scene's own. `known` are the renderer's settings; a setting that is not among them is left
/// out. The base is always measured. The others are those that `only` matches (a NamePattern; a faulty one matches
/// nothing); if it is empty, all but those that users hardly choose (the walk's shortcuts, the inversion, coarser
/// meshes).
ConfigurationList make_configurations(const SceneTraits& traits, const hd::Dictionary& scene_settings,
                                      const std::vector<hd::RenderSettingDescriptor>& known, const std::string& only);

}  // namespace alabaster::tradeoff
