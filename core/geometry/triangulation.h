// Polygons into triangles.
#pragma once

#include <array>
#include <vector>

#include "core/math/vector.h"

namespace alabaster {

/// Normal of a polygon by Newell's method (Tampieri, Graphics Gems III): its length is twice the enclosed area.
Vec3d polygon_normal(const std::vector<Vec3d>& corners);

/// Appends corners.size() - 2 triangles of corner indices, winding as the polygon does. A polygon that is convex in its
/// own plane becomes a fan from corner 0; any other simple one is cut by ears, so that nothing folds over; a
/// self-intersecting one gives some triangulation. The time is linear in the corners, whatever they are.
void triangulate_polygon(const std::vector<Vec3d>& corners, std::vector<std::array<int, 3>>* triangles);

}  // namespace alabaster
