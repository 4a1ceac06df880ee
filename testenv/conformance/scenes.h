// Meshes, materials and scenes of the suite. Materials are UsdPreviewSurface, which every delegate should know.
#pragma once

#include "testenv/conformance/host.h"

namespace conformance {

inline const Vec3f kRed(0.75f, 0.125f, 0.125f), kGreen(0.125f, 0.75f, 0.125f), kBlue(0.125f, 0.125f, 0.75f),
    kBlack(0, 0, 0);

/// A rectangle of n x n faces that looks along +z.
Mesh rectangle(double x0, double y0, double x1, double y1, int n = 1, double z = 0);
Mesh cube(double half);
/// Emits `color` and reflects nothing that these scenes have: its pixels are exact after one sample.
MaterialNetwork glow(const Vec3f& color);
/// Emits the mesh's displayColor.
MaterialNetwork glow_of_display_color();
MaterialNetwork matte(const Vec3f& color);
Matrix4d moved(double x, double y, double z = 0);

/// A cube on a floor under a dome and a quad light: every pixel has noise.
void add_noisy_scene(Host& host);
/// /left in red and /right in green, which glow and meet in the middle, with materials /red and /green.
void add_halves(Host& host);

/// |a - b| of every component below `tolerance`.
bool near(const Vec3f& a, const Vec3f& b, float tolerance = 2e-3f);

}  // namespace conformance
