#include "core/light/light_description.h"

#include <limits>

namespace alabaster {

std::span<const Parameter<LightDescription>> light_parameters() {
  using P = LightDescription;
  static constexpr Parameter<P> kTable[] = {
      {"intensity", &P::intensity, 0, kUnbounded},
      {"exposure", &P::exposure, -64, 64},
      {"color", &P::color, 0, kUnbounded},
      {"enableColorTemperature", &P::enable_color_temperature},
      {"colorTemperature", &P::color_temperature, 1000, 10000},
      {"normalize", &P::normalize},
      {"width", &P::width, 0, kUnbounded},
      {"height", &P::height, 0, kUnbounded},
      {"radius", &P::radius, 0, kUnbounded},
      {"length", &P::length, 0, kUnbounded},
      {"treatAsPoint", &P::treat_as_point},
      {"angle", &P::angle, 0, 360},
      {"coneInner", &P::cone_inner, 0, 180},
      {"coneOuter", &P::cone_outer, 0, 180},
      {"shaping:cone:angle", &P::cone_angle, 0, 180},
      {"shaping:cone:softness", &P::cone_softness, 0, 1},
      {"shaping:focus", &P::focus, 0, kUnbounded},
      {"shaping:focusTint", &P::focus_tint, 0, kUnbounded},
      {"shaping:ies:angleScale", &P::ies_angle_scale},
      {"shaping:ies:normalize", &P::ies_normalize},
      {"visibleToCamera", &P::visible_to_camera},
  };
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

Rgb emission(const LightDescription& description) {
  const Rgb& color = description.color;
  return finite_or_black(description.enable_color_temperature ? color * description.color_of_temperature : color,
                         description.intensity * std::exp2(static_cast<double>(description.exposure)));
}

double representable_importance(const Rgb& radiance, double scale) {
  if (is_black(radiance) || !(scale > 0)) return 0;
  return std::clamp(static_cast<double>(luminance(radiance)) * scale, 0x1p-1000, 0x1p+960);
}

}  // namespace alabaster
