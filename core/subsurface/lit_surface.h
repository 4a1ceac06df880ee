// Where light falls on the surface of a body: walks that enter where it is dark are guided to it. random_walk.md
// derives the direction. Noise depends on it, the expectation of no picture does.
#pragma once

#include <array>
#include <functional>
#include <optional>
#include <utility>
#include <vector>

#include "core/math/vector.h"
#include "core/subsurface/built_once.h"

namespace alabaster {

/// A point of a body's surface and the light that falls on it. Render space.
struct LitPoint {
  Vec3f p;
  Vec3f inward;      // unit normal
  float irradiance;  // luminance, any unit
  float area;        // of the surface that the point stands for, square of p's unit
};

class LitSurface {
 public:
  static constexpr size_t kPoints = 16;

  /// Keeps kPoints of the points, with a probability in proportion to irradiance x area: each then stands for as much
  /// light. Empty where a body is lit too evenly for a direction to be worth its cost, and in the dark.
  static std::optional<LitSurface> choose(const std::vector<LitPoint>& points);

  /// The unit direction in which a particle at `p` is most likely to meet light, where light falls off as
  /// exp(-kappa distance); render space. Zero if no lit point faces p, and where light is so far
  /// away that hardly any comes.
  Vec3f direction_from(const Vec3f& p, float kappa) const;
  /// True if outward normal `n` turns to the side that most light falls on: light is near, no walk need look for it.
  bool faces_light(const Vec3f& n) const { return dot(n, facing_) > 0.1f; }

 private:
  // Arrays of one component each, so that the loop over the points takes several at once.
  using Component = std::array<float, kPoints>;
  Component x_{}, y_{}, z_{}, nx_{}, ny_{}, nz_{};
  float area_of_each_ = 0;  // that a point stands for, at the irradiance of what is lit
  Vec3f facing_{0, 0, 0};   // mean of the points' outward normals
};

/// The lit surface of a body, found by the first walk that asks: an edit of a light pays for the bodies that the camera
/// then sees. Any thread.
class LazyLitSurface {
 public:
  using Find = std::function<std::optional<LitSurface>()>;
  /// `find` must give the same at each call, and is not called once the surface is found.
  explicit LazyLitSurface(Find find) : find_(std::move(find)) {}

  /// Null: walks are not guided to light.
  const LitSurface* get() {
    const std::optional<LitSurface>& found = surface_.get(find_);
    return found ? &*found : nullptr;
  }
  bool is_found() const { return surface_.is_built(); }

 private:
  Find find_;
  BuiltOnce<std::optional<LitSurface>> surface_;
};

}  // namespace alabaster
