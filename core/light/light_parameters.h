// Common to all lights: the parameters that a scene gives, and the samples and hits that every light returns.
//
// Units follow UsdLux: `intensity` is a radiance (nits when the scene is calibrated so) scaled by 2^exposure; see
// emission(). Everything after construction is in render space; pdfs are per solid angle at the reference point.
#pragma once

#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "core/color/rgb.h"
#include "core/math/bounds.h"
#include "core/math/ray.h"
#include "core/math/transform.h"
#include "core/parameter/parameter.h"
#include "core/texture/texture.h"

namespace alabaster {

class IesProfile;
class LightImage;

/// The parameters `diffuse` and `specular` of a light.
struct LobeScales {
  float diffuse = 1, specular = 1;

  bool operator==(const LobeScales&) const = default;
  /// For choices that do not know the lobes.
  double mean() const { return 0.5 * (static_cast<double>(diffuse) + static_cast<double>(specular)); }
  /// For light that is sent on by lobes of which specular ones have the share `specular_lobes`.
  Rgb of(const Rgb& specular_lobes) const { return (Rgb(1.0f) - specular_lobes) * diffuse + specular_lobes * specular; }
};

inline constexpr float kInfinity = std::numeric_limits<float>::infinity();

/// Result of sample(): finite, with pdf > 0 and some radiance. Else sample() returns none.
struct LightSample {
  Vec3f wi{0, 0, 1};   // unit, from the reference point to the light
  float distance = 0;  // to the sampled point; infinity for distant and dome
  Rgb radiance{0.0f};  // arriving along wi; for a delta light: irradiance on a plane facing it (pdf = 1)
  float pdf = 0;       // per solid angle; 1 for delta lights
  bool delta = false;
  bool on_mesh = false;  // the point lies on geometry: on which, and where, as TriangleHit has it
  uint32_t instance = 0, triangle = 0;
  Vec2f place{0, 0};
  bool of_constant_dome = false;        // of a light that ConstantDomes (light_set.h) may leave to BSDF sampling
  uint32_t shadow_link = 0, group = 0;  // those of LightParameters
  const LobeScales* scales = nullptr;   // null: of 1

  /// Length of a shadow ray along wi. It stops short of a point on a mesh, so that the light does not shade itself;
  /// lights that are no geometry need no such margin.
  float shadow_length() const { return on_mesh ? distance * (1 - 0x1p-12f) : distance; }
};

/// Result of intersect(). ray.dir need not be unit. ray.tmax is ignored: LightSet compares with it.
struct LightHit {
  float t = 0;         // along the ray, in units of |dir|; infinity for distant and dome
  Rgb radiance{0.0f};  // emitted towards the ray's origin
  float pdf = 0;       // of sample() for this direction from the ray's origin
};

/// Where a light is, and how strong. Far from a finite light importance(p) is at most about power / d^2; everywhere for
/// an infinite one it is `power`.
struct LightExtent {
  BoundsDouble box;  // of a finite light
  double power = 0;
  bool finite = true;
  /// Orientation cone (Conty Estevez, Kulla 2018): normals lie within normals_angle of `axis`; light leaves within
  /// emission_angle of a normal, in proportion to its cosine (radians). By default it leaves everywhere.
  Vec3d axis{0, 0, 1};
  double normals_angle = kPiDouble, emission_angle = 0.5 * kPiDouble;
};

enum class LightType { rect, sphere, distant, dome, disk, cylinder };

/// A light as the scene gives it, before placement in render space. light_parameters() has the names of the members,
/// which are those of UsdLux without "inputs:".
///
/// Bad values do not spread. A light gives no light and is never sampled if its transform is not finite, not affine or
/// not invertible, if a size other than a sphere's is zero, or if its emission is not finite or not representable.
/// Negative channels count as black. The sign of a size is ignored.
struct LightParameters {
  LightType type = LightType::rect;
  Matrix4d light_to_world;           // lights emit down their local -z (rect, disk, distant); scale applies to sizes
  std::vector<Matrix4d> poses = {};  // of what moves: light_to_world over the shutter, even ones; empty: stands still
  Rgb color{1.0f};
  float intensity = 1;
  float exposure = 0;               // stops
  float diffuse = 1, specular = 1;  // multiply what diffuse and specular lobes send on of the light
  bool enable_color_temperature = false;
  float color_temperature = 6500;  // kelvin
  Rgb color_of_temperature{1.0f};  // that of blackbody(), in the rendering space; multiplies color where enabled
  /// Power independent of size, by UsdLux's size factors: the radiance is divided by the world-space area (rect
  /// w*h, disk pi r^2, sphere 4 pi r^2, cylinder 2 pi r l) or, distant, by pi sin^2(angle/2) (beyond a hemisphere
  /// pi (2 - sin^2)), which makes color*intensity the irradiance on a plane facing the light. A point light has the
  /// limit of a sphere, radiant intensity I/4. Ignored by domes.
  bool normalize = false;
  float width = 1, height = 1;  // rect
  float radius = 0.5f;  // disk; sphere and cylinder, which keep their volume under a transform that scales unevenly
  float length = 1;     // cylinder, along x
  /// sphere: a point light. The radius then does not count, and `intensity` is radiant intensity (candela-like), as it
  /// is for radius 0: irradiance at distance d is intensity / d^2.
  bool treat_as_point = false;
  float angle = 0.53f;  // distant: angular diameter in degrees; 0: delta, color*intensity is then irradiance
  /// Shaping of lights that have a place, about their local -z (light_shaping.h); half angles in degrees. A cone_angle
  /// below 180 or a softness replaces inner and outer.
  float cone_inner = 180, cone_outer = 180;   // falloff between them as KHR_lights_punctual defines
  float cone_angle = 180, cone_softness = 0;  // UsdLuxShapingAPI; dark beyond the angle, the softness is its soft share
  float focus = 0;                            // radiance times lerp(focus_tint, white, |cos|^focus)
  Rgb focus_tint{0.0f};
  std::shared_ptr<const IesProfile> ies;   // its candela multiply the radiance; 0 degrees is -z, the horizontal +x
  float ies_angle_scale = 0;               // of its vertical angles: stretches them about -z, negative: about +z
  bool ies_normalize = false;              // divides it by its mean, so that it keeps the power
  std::shared_ptr<const Texture> texture;  // rect (rect_disk_light.h); dome: lat-long, USD's orientation (dome_light.h)
  bool visible_to_camera = false;
  bool shadow_enable = true;  // false: nothing casts its shadows
  // Categories of the scene (SceneDescription); 0: everything.
  uint32_t light_link = 0;   // it lights those that are in it alone
  uint32_t shadow_link = 0;  // those that are in it alone cast its shadows
  uint32_t group = 0;        // of SceneDescription::light_groups, from 1 on; 0: of none
  std::string name = {};     // prim path, for reports
  bool operator==(const LightParameters&) const = default;
};
/// The rows of schemas/lights.json. Parameters that name files have theirs in delegate/host/open_fields.cpp.
std::span<const Parameter<LightParameters>> light_parameters();

/// color * colour of the temperature * intensity * 2^exposure, negative channels cut to zero; black if that is not
/// finite. `normalize` does not count here: the constructor of a light divides by the light's size.
Rgb emission(const LightParameters& parameters);

/// Light given as double to the float that is stored: black if any channel is not finite or beyond float, else at most
/// 1e35.
Rgb finite_or_black(const Rgb& color, double scale);

/// Luminance of radiance * scale for the choice of light: 0 where either is 0 or the scale is NaN, else positive. Where
/// the product would over- or underflow the result is clamped, so that even sums of it are finite.
double representable_importance(const Rgb& radiance, double scale);

/// True if all that lies within `reach` of a plane's side `height` is below the plane, whatever the rounding of the
/// directions to it: `height` and `reach` along the plane's unit normal, `distance` to the middle.
inline bool is_wholly_below(double height, double reach, double distance) {
  constexpr double kRounding = 0x1p-16;
  return height + reach < -kRounding * (distance + reach);
}

inline Vec3f to_float(const Vec3d& v) {
  return {static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)};
}

}  // namespace alabaster
