// Matrices from what people write, and a camera that shows all of a scene. Row vectors: p' = p * M.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>

#include "delegate/host/retained_scene_delegate.h"

namespace alabaster::hd::description {

Vec3d to_vec3d(const nlohmann::json& value);

/// Sixteen numbers, or {translate, rotate, scale}; the schema has been checked. Empty if the matrix is not affine or
/// cannot be inverted.
std::optional<Matrix4d> to_transform(const nlohmann::json& value);

/// A frame at `eye` whose -z points at `target` and whose y leans to `up`. Empty if eye and target coincide or `up`
/// points along the view; with `free_up`, another up is taken instead of the latter.
std::optional<Matrix4d> look_at(const Vec3d& eye, const Vec3d& target, const Vec3d& up, bool free_up);

/// World points that enclose the visible scene: the points of every mesh, or the corners of its box per instance.
std::vector<Vec3d> enclosing_points(const host::RetainedSceneDelegate& scene);

/// Half the film's size over the focal length, or, for a parallel projection, zero.
struct Frustum {
  double tan_x = 0.36, tan_y = 0.24;
};

/// A three-quarter view from the front right, a little above, as near as it can be with all points in the frame and a
/// margin. `distance`: along the view to the points' centre.
struct Framed {
  Matrix4d camera;
  double distance = 1;
};
Framed frame_points(const std::vector<Vec3d>& points, const Frustum& frustum);

}  // namespace alabaster::hd::description
