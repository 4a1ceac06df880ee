#include "core/light/light_parameters.h"

#include <limits>

namespace alabaster {

std::span<const Parameter<LightParameters>> light_parameters() {
  using P = LightParameters;
  constexpr auto bit = [](LightType type) { return 1u << static_cast<uint32_t>(type); };
  constexpr uint32_t kRect = bit(LightType::rect), kSphere = bit(LightType::sphere), kDisk = bit(LightType::disk);
  constexpr uint32_t kCylinder = bit(LightType::cylinder), kDistant = bit(LightType::distant);
  constexpr uint32_t kShaped = kSphere | kRect | kDisk | kCylinder;
  // The second line of a row is its unit and its description. clang-format would give each element a line.
  // clang-format off
  static constexpr Parameter<P> kTable[] = {
      {"intensity", &P::intensity, 0, kUnbounded, {},
       "radiance", "Radiance of the light before exposure and normalize; the radiant intensity of a point light; the "
       "irradiance of a distant light of angle 0."},
      {"exposure", &P::exposure, -64, 64, {},
       "stops", "Multiplies intensity by 2 to this power."},
      {"diffuse", &P::diffuse, 0, 1000, {},
       "none", "Multiplies what diffuse lobes send on of the light, and bodies that it scatters in. Not what is seen of "
       "the light itself."},
      {"specular", &P::specular, 0, 1000, {},
       "none", "Multiplies what specular lobes send on of the light: highlights, coats and clear walls. Sheen is "
       "diffuse."},
      {"color", &P::color, 0, kUnbounded, {},
       "none", "Colour in the rendering space; multiplies intensity."},
      {"enableColorTemperature", &P::enable_color_temperature, -kUnbounded, kUnbounded, {},
       "none", "Multiplies color by that of a blackbody of colorTemperature and luminance 1."},
      {"colorTemperature", &P::color_temperature, 1000, 10000, {},
       "kelvin", "Colour temperature; only with enableColorTemperature. 6500 is nearly white."},
      {"normalize", &P::normalize, -kUnbounded, kUnbounded, {},
       "none", "Keeps the power constant when the size changes: divides by the area, or by the projected solid angle "
       "(distant). A point light has the limit of a small sphere: a quarter of the intensity.", kShaped | kDistant},
      {"width", &P::width, 0, kUnbounded, {},
       "scene unit", "Width along the light's x axis.", kRect},
      {"height", &P::height, 0, kUnbounded, {},
       "scene unit", "Height along the light's y axis.", kRect},
      {"radius", &P::radius, 0, kUnbounded, {},
       "scene unit", "Radius of the sphere, disk or cylinder; a sphere of radius 0 is a "
       "point.", kSphere | kDisk | kCylinder},
      {"length", &P::length, 0, kUnbounded, {},
       "scene unit", "Length along the light's x axis.", kCylinder},
      {"treatAsPoint", &P::treat_as_point, -kUnbounded, kUnbounded, {},
       "none", "Makes a point light, whose intensity is radiant intensity, or four times that with "
       "normalize.", kSphere},
      {"angle", &P::angle, 0, 360, {},
       "degrees", "Angular diameter; 0 gives parallel light.", kDistant},
      {"coneInner", &P::cone_inner, 0, 180, {},
       "degrees", "Half angle around -z within which a spot has full intensity, as KHR_lights_punctual has "
       "it.", kShaped},
      {"coneOuter", &P::cone_outer, 0, 180, {},
       "degrees", "Half angle around -z outside which a spot is dark.", kShaped},
      {"shaping:cone:angle", &P::cone_angle, 0, 180, {},
       "degrees", "Half angle around -z outside which the light is dark; below 180 it replaces coneInner and "
       "coneOuter.", kShaped},
      {"shaping:cone:softness", &P::cone_softness, 0, 1, {},
       "none", "Share of shaping:cone:angle, from its edge inwards, over which the light falls smoothly to "
       "dark.", kShaped},
      {"shaping:focus", &P::focus, 0, kUnbounded, {},
       "none", "Gathers the light about the z axis: the power to which the cosine of the angle to it is "
       "raised.", kShaped},
      {"shaping:focusTint", &P::focus_tint, 0, kUnbounded, {},
       "none", "Colour that multiplies the light where the focus has taken it away.", kShaped},
      {"shaping:ies:angleScale", &P::ies_angle_scale, -kUnbounded, kUnbounded, {},
       "none", "Stretches the vertical angles of the profile by this factor, about -z, or if it is negative about z; "
       "0 leaves them.", kShaped},
      {"shaping:ies:normalize", &P::ies_normalize, -kUnbounded, kUnbounded, {},
       "none", "Divides the profile by its mean over all directions, so that it shapes the light and keeps its "
       "power.", kShaped},
      {"visibleToCamera", &P::visible_to_camera, -kUnbounded, kUnbounded, {},
       "none", "True if camera rays see the light itself."},
      {"shadow:enable", &P::shadow_enable, -kUnbounded, kUnbounded, {},
       "none", "False: nothing casts a shadow of the light, as with a shadowLink that holds nothing."},
  };
  // clang-format on
  return kTable;
}

// Sums over the lights and the vertices of a path stay finite.
constexpr double kMostRadiance = 1e35;

Rgb finite_or_black(const Rgb& color, double scale) {
  Rgb scaled;
  for (int i = 0; i < 3; ++i) {
    const double channel = std::max(0.0, color[i] * scale);
    if (!(channel <= std::numeric_limits<float>::max()) || !std::isfinite(color[i] * scale)) return Rgb(0.0f);
    scaled[i] = static_cast<float>(std::min(channel, kMostRadiance));
  }
  return scaled;
}

Rgb emission(const LightParameters& parameters) {
  const Rgb& color = parameters.color;
  return finite_or_black(parameters.enable_color_temperature ? color * parameters.color_of_temperature : color,
                         parameters.intensity * std::exp2(static_cast<double>(parameters.exposure)));
}

double representable_importance(const Rgb& radiance, double scale) {
  if (is_black(radiance) || !(scale > 0)) return 0;
  return std::clamp(static_cast<double>(luminance(radiance)) * scale, 0x1p-1000, 0x1p+960);
}

}  // namespace alabaster
