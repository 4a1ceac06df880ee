#include "delegate/hydra/lights.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace alabaster::hydra {
namespace {

hd::Value scaled(const hd::Value& value, double factor) {
  return value.empty() ? value : hd::Value(static_cast<float>(value.number_or(0) * factor));
}

// Blender 4.2 to 5.0 halves the angle of a sun and sends a quarter of its energy. Its normalized light has the
// irradiance of the energy, as in Cycles.
hd::Value sun_of_blender(const std::string& name, const hd::Value& value) {
  if (name == "intensity") return scaled(value, 4);
  return name == "angle" ? scaled(value, 2) : value;
}

// The flux through a cone whose light falls by a smoothstep of the angle, from `inner` to `outer` radians, over 2 pi.
double flux(double inner, double outer) {
  constexpr int kSteps = 256;
  double sum = 0;
  for (int i = 0; i < kSteps; ++i) {
    const double angle = (i + 0.5) / kSteps * outer;
    const double t = std::clamp((outer - angle) / std::max(outer - inner, 1e-6), 0.0, 1.0);
    sum += t * t * (3 - 2 * t) * std::sin(angle);
  }
  return sum * outer / kSteps;
}

// Blender sends its blend of a spot as the softness. Cycles falls by a smoothstep of the cosine, from the cone's to
// where the blend ends; this is the softness that gives the same flux.
hd::Value softness_of_blender(const hd::Value& value, const hd::Value& angle) {
  const double blend = value.number_or(0), outer = angle.number_or(180) * std::numbers::pi / 180;
  if (value.empty() || !(blend > 0 && blend <= 1) || !(outer > 0 && outer <= std::numbers::pi / 2)) return value;
  const double wanted = (1 - std::cos(outer)) * (1 - 0.5 * blend);
  double low = 0, high = outer;
  for (int i = 0; i < 30; ++i) {
    const double inner = 0.5 * (low + high);
    (flux(inner, outer) < wanted ? low : high) = inner;
  }
  return static_cast<float>(1 - low / outer);
}

// Blender 4.2 to 5.0 sends a world of one colour as an image of it, too, and the two would multiply.
hd::Value world_of_blender(const std::string& name, const hd::Value& value) {
  if (name != "texture:file") return value;
  const std::string file = value.text_or("");
  const std::string word = file.substr(file.rfind('/') + 1);
  return word.starts_with("color_") && file.find("/image_cache/") != std::string::npos ? hd::Value() : value;
}

}  // namespace

Host HostOf(const std::string& word) {
  if (word == "blender_usd") return Host::blender_usd;
  return word == "blender" ? Host::blender : Host::any;
}

hd::Value TranslateLightParameter(const LightRules& rules, const hd::Token& type, const hd::Token& name,
                                  const HostParameter& get) {
  const auto find = [&](const hd::Token& asked) {
    hd::Value found = get(asked);
    return found.empty() ? get("inputs:" + asked.str()) : found;
  };
  hd::Value value = find(name);
  const bool is_dome = type == hd::Token("domeLight");
  if (is_dome && value.empty() && name == hd::Token("visibleToCamera")) return rules.domes_visible_to_camera;
  if (rules.host == Host::any) return value;
  if (name == hd::Token("shaping:cone:softness")) return softness_of_blender(value, find("shaping:cone:angle"));
  if (type == hd::Token("distantLight")) return sun_of_blender(name.str(), value);
  return is_dome && rules.host == Host::blender ? world_of_blender(name.str(), value) : value;
}

}  // namespace alabaster::hydra
