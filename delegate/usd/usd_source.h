// A stage of OpenUSD (.usd, .usda, .usdc, .usdz) as a source of prims: a child process reads it (usd_child.h). Of a
// file of MaterialX (.mtlx), whose materials are below /MaterialX/Materials.
#pragma once

#include <memory>

#include "delegate/host/scene_source.h"

namespace alabaster::hd::usd {

std::unique_ptr<host::SceneSource> MakeStageSource();

/// True of the extension of a stage, in small letters.
bool is_stage(const std::string& extension);

}  // namespace alabaster::hd::usd
