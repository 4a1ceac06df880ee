// The lights of a Hydra host in the contract's terms. No type of OpenUSD.
#pragma once

#include <functional>

#include "delegate/api/scene_types.h"

namespace alabaster::hydra {

/// A program whose lights are corrected. README.md, "Blender", has the table.
enum class Host {
  any,
  blender,      // HydraRenderEngine with export method HYDRA
  blender_usd,  // the same with export method USD
};
/// "blender" or "blender_usd" (setting alabaster:host); any for all other words.
Host HostOf(const std::string& word);

struct LightRules {
  Host host = Host::any;
  bool domes_visible_to_camera = true;  // Hydra's setting domeLightCameraVisibility
  bool operator==(const LightRules&) const = default;
};

/// The host's value of a parameter of a light; empty if it has none of that name.
using HostParameter = std::function<hd::Value(const hd::Token& name)>;

/// Parameter `name`, without "inputs:", of a light of type `type` (distantLight, ...). `get` is tried with `name`, then
/// with "inputs:" before it, as the schema of UsdLux has it. Empty: the host gives neither.
hd::Value TranslateLightParameter(const LightRules& rules, const hd::Token& type, const hd::Token& name,
                                  const HostParameter& get);

}  // namespace alabaster::hydra
