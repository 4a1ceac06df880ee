// A control variate of walks. A walk's twin in a half-space (core/subsurface/half_space_twin.h) comes out at the entry.
// What it brings out there, in the light that falls on the entry, is taken away from the path; its expectation is added
// at the vertex (core/subsurface/random_walk.md).
#pragma once

#include <array>
#include <optional>

#include "core/color/rgb.h"
#include "core/film/film_tile.h"
#include "core/math/vector.h"

namespace alabaster {

struct ControlVariate {
  ControlVariate(const Rgb& of_half_space, const std::array<float, 4>& numbers)
      : albedo(of_half_space), light_numbers(numbers) {}
  Rgb albedo;                                // of the half-space
  Rgb light{0.0f};                           // that the exit lobe sends on at the vertex, of throughput one
  LightByGroup::Planes* by_group = nullptr;  // the same; null: not asked for
  /// The numbers that sampled it: exits are lit with the same, so that their light differs little.
  std::array<float, 4> light_numbers;
  /// Those of a constant dome's direction, where it gives most light: paths go on that way, and meet it if it was met.
  std::optional<Vec2f> dome_sample = {};
};

}  // namespace alabaster
