// A ball beside what the camera looks at, on whose floor it throws the light of a small lamp.
#pragma once

#include "testenv/support/scene_builder.h"

namespace alabaster::testing {

inline DisneyParameters metal(float roughness) {
  DisneyParameters p;
  p.base_color = Rgb(0.9f);
  p.metallic = 1;
  p.roughness = roughness;
  return p;
}

/// Above the floor, on the camera's side of the ball. Types but distant ones are spheres.
inline LightParameters small_light(LightType type = LightType::sphere) {
  LightParameters light;
  light.type = type;
  light.color = Rgb(type == LightType::distant ? 3.0f : 200.0f);
  light.radius = 0.1f;
  light.light_to_world = Matrix4d().setTranslation(Vec3d(0, 3, 4));
  return light;
}

/// Adds the ball first, then the floor, which lies in y = 0 about the origin.
inline void add_ball_on_floor(const DisneyParameters& ball, const DisneyParameters& floor, const LightParameters& light,
                              SceneBuilder* builder) {
  builder->add(builder->prototype(sphere_mesh(1, 24, true)), builder->material(ball),
               Matrix4d().setTranslation(Vec3d(0, 1, -1.2)));
  builder->add(builder->prototype(plane_mesh(20)), builder->material(floor)).add(light);
}

}  // namespace alabaster::testing
