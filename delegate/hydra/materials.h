// MaterialX's Standard Surface and its image nodes, as Hydra delivers them, in the nodes that the renderer reads.
// Source: the Autodesk Standard Surface specification 1.0.1 and MaterialX 1.38's node library. No type of OpenUSD.
#pragma once

#include <functional>

#include "delegate/api/scene_types.h"

namespace alabaster::hydra {

/// Receives a diagnostic's code and text.
using WarnMaterial = std::function<void(const char* code, const std::string& text)>;

/// The network itself unless its terminal "surface" names a node ND_standard_surface_surfaceshader:
/// UsdPreviewSurface is the delegate's own business, and AlabasterDisney loses nothing but empty "colorSpace:NAME".
/// Warns once of each input that is left out. README.md has the table.
hd::MaterialNetwork TranslateMaterial(const hd::MaterialNetwork& network, const WarnMaterial& warn);

/// The distance of AlabasterDisney that walks with these mean free paths below a surface of that albedo: Chiang, Kutz,
/// Burley 2016, eq. 2 and 3.
hd::Vec3f ScatterDistance(const hd::Vec3f& mean_free_path, const hd::Vec3f& albedo);

}  // namespace alabaster::hydra
