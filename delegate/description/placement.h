// Matrices from a description's transforms, and a camera that shows a whole scene. Row vectors: p' = p * M.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>

#include "delegate/host/retained_scene_delegate.h"

namespace alabaster::hd::description {

Vec3d to_vec3d(const nlohmann::json& value);

/// The matrix of sixteen numbers or of {translate, rotate, scale}, which the schema has accepted. Empty if the renderer
/// would leave out what it places: is_valid_affine (core/math/transform.h).
std::optional<Matrix4d> to_transform(const nlohmann::json& value);

/// A frame at `eye` with -z towards `target` and y as near to `up` as possible. Empty if eye and target coincide. If
/// `up` points along the view, `free_up` allows another one; otherwise the result is empty.
std::optional<Matrix4d> look_at(const Vec3d& eye, const Vec3d& target, const Vec3d& up, bool free_up);

/// The axis that points up: "Y" or "Z". Default cameras and studios are made where it is Y, and then put into the
/// world.
Vec3d up_vector(const Token& up);
Matrix4d to_world(const Matrix4d& placed, const Token& up);
Matrix4d from_world(const Matrix4d& placed, const Token& up);
std::vector<Vec3d> from_world(std::vector<Vec3d> points, const Token& up);

/// World points that enclose the visible scene: the points of every mesh, or the corners of its box for every instance.
std::vector<Vec3d> enclosing_points(host::RetainedSceneDelegate& scene);

/// Half the film's size over the focal length; zero for a parallel projection.
struct Frustum {
  double tan_x = 0.36, tan_y = 0.24;
};

/// A three-quarter view from the front right and a little above, as near as possible with all points in the frame and a
/// margin. `distance` is the one along the view to the points' centre.
struct Framed {
  Matrix4d camera;
  double distance = 1;
};
Framed frame_points(const std::vector<Vec3d>& points, const Frustum& frustum);

}  // namespace alabaster::hd::description
