// UsdPreviewSurface and its nodes, in the nodes that the renderer reads. Source: the UsdPreviewSurface specification,
// version 2.6. delegate/manual/usd.md has the table.
#pragma once

#include <functional>

#include "delegate/api/scene_types.h"

namespace alabaster::hd::support {

/// Takes a diagnostic's code and text.
using WarnNetwork = std::function<void(const char* code, const std::string& text)>;

/// The network itself unless its terminal "surface" names a node of type UsdPreviewSurface. Warns once of each input
/// that is left out.
MaterialNetwork TranslatePreviewSurface(const MaterialNetwork& network, const WarnNetwork& warn);

}  // namespace alabaster::hd::support
