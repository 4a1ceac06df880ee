// The six faces of a cube that show all directions, and the latitude-longitude image that a dome light takes.
#pragma once

#include <array>
#include <vector>

#include "core/color/rgb.h"
#include "core/math/vector.h"

namespace alabaster {

/// Faces +x, -x, +y, -y, +z, -z, rows from the top. Each is what a camera at the centre sees: with y up for the faces
/// of x and z, with -z up for +y and z up for -y. These are the faces of a graphics card's cube map, mirrored about
/// their vertical axis, as EXT_lights_image_based has them.
struct CubeMap {
  size_t size = 0;  // texels along an edge
  std::array<std::vector<Rgb>, 6> faces;

  /// Bilinear within a face; a face's outermost half texel is constant across its edge.
  Rgb look(const Vec3d& direction) const;
};

/// 4 by 2 texels for each one of an edge, so that texels are no larger than the cube's where those are largest. Each is
/// the mean of sixteen looks by solid angle. Rows from the top (+y); the middle column is +z, and the one a quarter to
/// its left +x.
std::vector<Rgb> to_lat_long(const CubeMap& cube);

}  // namespace alabaster
