// The lights of a Hydra host in the contract's terms. No type of OpenUSD.
#pragma once

#include <functional>

#include "delegate/api/scene_types.h"

namespace alabaster::hydra {

/// The program that fills the scene, where its lights need mending. README.md has the table.
enum class Host {
  any,
  blender,      // HydraRenderEngine with export method HYDRA
  blender_usd,  // the same with export method USD
};
/// "blender" or "blender_usd" (setting alabaster:host); any for all other words.
Host HostOf(const std::string& word);

struct LightRules {
  Host host = Host::any;
  bool domes_are_seen = true;  // by the camera: Hydra's setting domeLightCameraVisibility
  bool operator==(const LightRules&) const = default;
};

/// A parameter of a light of the host's; empty if it has none of that name.
using HostParameter = std::function<hd::Value(const hd::Token& name)>;

/// Parameter `name` of a light of type `type` (distantLight, ...). Hosts name parameters as UsdLux's schema does, with
/// or without "inputs:".
hd::Value LightParameter(const LightRules& rules, const hd::Token& type, const hd::Token& name,
                         const HostParameter& get);

}  // namespace alabaster::hydra
