// What is compared: a base that spares nothing, and what differs from it in one thing.
#pragma once

#include <string>
#include <vector>

#include "delegate/api/render_delegate.h"
#include "delegate/host/retained_scene_delegate.h"

namespace alabaster::tradeoff {

/// One way to render the scene.
struct Configuration {
  std::string name;         // "walk", "maxDepth=4"
  std::string group;        // the knob: "base", "subsurface", "maxDepth"
  hd::Dictionary settings;  // every setting that is not the renderer's default, but for samples and seed
  int coarser = 0;          // by how many levels subdivided meshes are refined less than the scene asks

  /// The same for the same settings, whatever made them: a measurement that bears it may be used again.
  std::string fingerprint() const;
};

struct SceneTraits {
  bool subsurface = false;  // some material has a scatterDistance
  int refine_level = 0;     // the highest of a mesh that is subdivided
};
SceneTraits traits_of(const hd::host::RetainedSceneDelegate& scene);

struct ConfigurationList {
  Configuration reference;              // the yardstick: nothing is more accurate
  std::vector<Configuration> measured;  // the base first
  std::vector<std::string> skipped;     // "inversion: the scene has no subsurface"
};

/// `scene_settings`: what the scene itself asks. `known`: the renderer's settings; a knob that it does not have is left
/// out. Of the measured, the base and those whose name `only` finds (std::regex; throws std::regex_error).
ConfigurationList make_configurations(const SceneTraits& traits, const hd::Dictionary& scene_settings,
                                      const std::vector<hd::RenderSettingDescriptor>& known, const std::string& only);

}  // namespace alabaster::tradeoff
