#include "delegate/hydra/lights.h"

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

// Blender 4.2 to 5.0 sends a world of one colour as an image of it, too, and the two would multiply.
hd::Value world_of_blender(const std::string& name, const hd::Value& value) {
  if (name != "texture:file") return value;
  const std::string file = value.text_or("");
  const std::string word = file.substr(file.rfind('/') + 1);
  return word.starts_with("color_") && file.find("/image_cache/") != std::string::npos ? hd::Value() : value;
}

}  // namespace

Host HostOf(const std::string& word) {
  return word == "blender" ? Host::blender : Host::any;
}

hd::Value LightParameter(const LightRules& rules, const hd::Token& type, const hd::Token& name,
                         const HostParameter& get) {
  hd::Value value = get(name);
  if (value.empty()) value = get("inputs:" + name.str());
  const bool is_dome = type == hd::Token("domeLight");
  if (is_dome && value.empty() && name == hd::Token("visibleToCamera")) return rules.domes_are_seen;
  if (rules.host != Host::blender) return value;
  if (type == hd::Token("distantLight")) return sun_of_blender(name.str(), value);
  return is_dome ? world_of_blender(name.str(), value) : value;
}

}  // namespace alabaster::hydra
