// Lights: a closed set, in UsdLux's terms. A light keeps its radiance: emission() of its parameters
// (light_parameters.h), divided by its size where they say `normalize`.
//
// delegate/manual/contributing.md, "Extending", lists the steps to add a light.
//
// The functions (see rect_disk_light.h): a constructor from (LightParameters, render origin), and those of IsLight. n
// is the normal of a lobe at p, or zero. A light whose surface is in the ray-traced scene (MeshLight) has pdf() in
// place of intersect().
//
// importance(p) guides the choice of light (light_choice.h): an estimate of the irradiance, as luminance, that the
// light gives at p on a plane facing it, unoccluded. It decides only the noise, as long as it is finite, positive
// wherever sample(p, .) may give light, and unchanged when all lengths change by 2^k. Constant domes take no part in
// the choice (light_set.h).
//
// Everything is in render space. pdfs are per solid angle at the reference point.
#pragma once

#include <concepts>
#include <variant>

#include "core/light/mesh_light.h"
#include "core/light/moving_light.h"

namespace alabaster {

template <class T>
concept IsIntersected = requires(const T& light, const Ray& ray, const Vec3f& n) {
  { light.intersect(ray, n) } -> std::same_as<std::optional<LightHit>>;
};
template <class T>
concept IsLight = requires(const T& light, const Vec3f& p, const Vec2f& u, const Vec3f& n) {
  requires IsIntersected<T> || std::same_as<T, MeshLight>;
  { light.sample(p, u, n) } -> std::same_as<std::optional<LightSample>>;
  { light.importance(p) } -> std::same_as<double>;
  { light.extent() } -> std::convertible_to<LightExtent>;
  { light.is_below(p, n) } -> std::same_as<bool>;  // the plane through p with normal n hides it
  { light.image() } -> std::convertible_to<std::shared_ptr<const LightImage>>;  // null: it has none
};
template <IsLight... Lights>
using LightOf = std::variant<Lights...>;
using Light = LightOf<RectDiskLight, CylinderLight, SphereLight, DistantLight, DomeLight, MeshLight, MovingLight>;

/// The light of these parameters, placed in the render space whose origin this is in the world. It shares images where
/// it can.
Light make_light(const LightParameters& parameters, const Vec3d& render_origin, const LightImages& images = {});

/// True for a dome without an image.
inline bool is_constant_dome(const Light& light) {
  const auto* dome = std::get_if<DomeLight>(&light);
  return dome && !dome->image();
}

/// The image that it is made of, or null.
std::shared_ptr<const LightImage> image_of(const Light& light);

}  // namespace alabaster
