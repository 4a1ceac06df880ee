// Small rules between a Hydra host and the contract: dirty bits, settings, statistics. No type of OpenUSD.
#pragma once

#include <span>

#include "delegate/api/render_delegate.h"

namespace alabaster::hydra {

/// A bit of the host's and those of the contract that it stands for. Hosts number theirs differently in each release.
struct BitPair {
  uint32_t host = 0;
  hd::DirtyBits ours = hd::dirty::kClean;
};
/// Bits that the table lacks are dropped.
hd::DirtyBits TranslateBits(uint32_t host, std::span<const BitPair> table);

/// A render setting under its own name and in the type of its default.
struct Setting {
  hd::Token key;
  hd::Value value;
};
/// Takes "alabaster:samples" for "samples", Hydra's "convergedSamplesPerPixel" too, and numbers of any type: hosts send
/// whole numbers as long and others as double. Other keys lose that prefix, and keep their values.
Setting TranslateSetting(const hd::Token& key, const hd::Value& value,
                         const std::vector<hd::RenderSettingDescriptor>& known);

/// The value of a setting that a scene gives, where the host has `host`. A scene cannot loosen the host's memoryLimit
/// and timeLimit, so of these it is the tighter one.
hd::Value WithinHostLimits(const hd::Token& key, const hd::Value& scene, const hd::Value& host);

/// A RenderVar of a product as the host has it.
struct HostRenderVar {
  std::string prim;                      // its name
  std::string source_name, source_type;  // of UsdRenderVar
  std::string data_type;                 // of Sdf: color3h, int, ...
  std::string layer;                     // that Houdini names (driver:parameters:aov:name)
};
/// The variable, with the layer that the program's reader of stages gives it (delegate/manual/usd.md, RenderSettings).
hd::RenderVar TranslateRenderVar(const HostRenderVar& theirs);

/// The statistics, with percentDone and fractionDone as double: hosts read them unchecked (Blender).
hd::Dictionary HostStatistics(hd::Dictionary statistics);

}  // namespace alabaster::hydra
