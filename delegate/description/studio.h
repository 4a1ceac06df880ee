// The default look of a scene without lights: a photographer's studio around its objects. A large soft key stands to
// the viewer's left and above, a weak fill to the right, and a strong rim behind, so that translucent things glow. A
// neutral backdrop, a floor that bends up into a wall, catches the shadow. Everything scales with the objects.
#pragma once

#include <optional>
#include <vector>

#include "delegate/host/retained_scene_delegate.h"

namespace alabaster::hd::description {

/// The objects and the camera that a studio is built for, in a space where y is up, and the world's up axis.
struct StudioPlan {
  Token up = "Y";
  Vec3d center;         // of the objects' box
  double radius = 0;    // of a sphere about it that holds the objects; positive
  double floor = 0;     // the objects' lowest height
  Matrix4d camera;      // camera to world
  bool inside = false;  // the camera stands in the objects' box
  bool below = false;   // it stands below the floor
};

/// The plan for objects that these points enclose, in the world; empty if they have no size.
std::optional<StudioPlan> plan_studio(const std::vector<Vec3d>& points, const Matrix4d& camera, const Token& up);

/// Adds key, fill and rim, and with `dome` a dim dome.
void add_studio_lights(const StudioPlan& plan, bool dome, host::RetainedSceneDelegate* scene);
void add_studio_backdrop(const StudioPlan& plan, host::RetainedSceneDelegate* scene);

/// The default light of a scene that has no studio: a dome light, turned so that its key stands to the upper left of
/// `camera` (camera to world). Its image is in memory, as Radiance RGBE.
host::LightDescription soft_dome(const Matrix4d& camera, const Token& up);

}  // namespace alabaster::hd::description
