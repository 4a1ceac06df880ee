#include "delegate/hydra/materials.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/subsurface/medium.h"
#include "delegate/hydra/material_images.h"

namespace alabaster::hydra {
namespace {

using hd::MaterialConnection;
using hd::MaterialNetwork;
using hd::MaterialNode;
using hd::Path;
using hd::Value;
using hd::Vec3f;

constexpr const char* kStandardSurface = "ND_standard_surface_surfaceshader";

/// An input that is a parameter of AlabasterDisney as it stands, with its default.
struct Input {
  const char* name;
  const char* parameter;
  Value initial;
};
const Input kInputs[] = {{"metalness", "metallic", 0.0f},
                         {"specular", "specular", 1.0f},
                         {"specular_color", "specularColor", Vec3f(1)},
                         {"specular_roughness", "roughness", 0.2f},
                         {"specular_IOR", "ior", 1.5f},
                         {"specular_anisotropy", "anisotropic", 0.0f},
                         {"specular_rotation", "anisotropicRotation", 0.0f},
                         {"transmission", "specTrans", 0.0f},
                         {"thin_walled", "thin", false}};
const Input kSheen[] = {
    {"sheen", "sheen", 0.0f}, {"sheen_color", "sheenColor", Vec3f(1)}, {"sheen_roughness", "sheenRoughness", 0.3f}};
const Input kCoat[] = {{"coat", "coat", 0.0f}, {"coat_roughness", "coatRoughness", 0.1f}};

/// An input that is read at its default alone.
struct Unread {
  const char* name;
  Vec3f initial;
};
const Unread kUnread[] = {{"diffuse_roughness", Vec3f(0)}};
const Unread kUnreadOfTransmission[] = {{"transmission_scatter", Vec3f(0)}, {"transmission_dispersion", Vec3f(0)}};
const Unread kUnreadOfCoat[] = {{"coat_color", Vec3f(1)},
                                {"coat_anisotropy", Vec3f(0)},
                                {"coat_affect_color", Vec3f(0)},
                                {"coat_affect_roughness", Vec3f(0)}};

Vec3f color_of(const Value& value, const Vec3f& otherwise) {
  std::array<double, 4> c{};
  const size_t count = value.components(&c);
  if (count == 1) return Vec3f(static_cast<float>(c[0]));
  return count >= 3 ? Vec3f(static_cast<float>(c[0]), static_cast<float>(c[1]), static_cast<float>(c[2])) : otherwise;
}

/// The AlabasterDisney that is made of a Standard Surface.
class StandardSurface {
 public:
  StandardSurface(const MaterialNetwork& from, const MaterialNode& surface, const WarnMaterial& warn)
      : surface_(surface), warn_(warn), images_(from, &to_, warn) {
    disney_.nodeTypeId = "AlabasterDisney";
  }

  MaterialNetwork run(const Path& id) {
    for (const Input& input : kInputs) read(input);
    read_base();
    read_transmission();
    if (is_used("sheen")) {
      for (const Input& input : kSheen) read(input);
      disney_.parameters["sheenTint"] = 0.0f;
    }
    if (is_used("coat")) {
      for (const Input& input : kCoat) read(input);
      for (const Unread& input : kUnreadOfCoat) warn_of(input);
    }
    if (const float thickness = plain("thin_film_thickness", 0); thickness > 0) {
      disney_.parameters["iridescence"] = 1.0f;
      disney_.parameters["iridescenceThickness"] = thickness;
      disney_.parameters["iridescenceIor"] = plain("thin_film_IOR", 1.5f);
    }
    if (is_used("emission")) read_weighted("emission", 0, "emission_color", Vec3f(1), "emission");
    read_opacity();
    read_normal("normal", "normal");
    read_normal("coat_normal", "coatNormal");
    for (const Unread& input : kUnread) warn_of(input);
    to_.terminals["surface"] = {id, "out"};
    to_.nodes[id] = std::move(disney_);
    return std::move(to_);
  }

 private:
  Value constant(const char* name) const { return input_value(surface_, name); }
  float number(const char* name, float otherwise) const {
    return static_cast<float>(constant(name).number_or(double(otherwise)));
  }
  bool is_connected(const char* name) const { return upstream(surface_, name) != nullptr; }
  /// The constant of an input that has no texture here.
  float plain(const char* name, float otherwise) const {
    if (is_connected(name))
      warn_("material.standard_surface", std::string("a texture of ") + name + " is not read; its constant is used");
    return number(name, otherwise);
  }
  bool is_used(const char* weight) const { return is_connected(weight) || number(weight, 0) > 0; }

  /// The connection of an input in nodes that are read; none: it is a constant, or (reported) cannot be read.
  std::optional<MaterialConnection> connection(const char* name) {
    const MaterialConnection* const given = upstream(surface_, name);
    return given ? images_.read(name, *given) : std::nullopt;
  }

  bool connect(const char* name, const char* parameter) {
    const auto found = connection(name);
    if (found) disney_.inputConnections[parameter] = {*found};
    return found.has_value();
  }

  void read(const Input& input) {
    if (connect(input.name, input.parameter)) return;
    const Value given = constant(input.name);
    disney_.parameters[input.parameter] = given.empty() ? input.initial : given;
  }

  void read_weighted(const char* weight, float initial, const char* color, const Vec3f& otherwise,
                     const char* parameter) {
    const float factor = number(weight, initial);
    connect(weight, parameter);
    const auto texture = connection(color);
    if (texture) disney_.inputConnections[parameter].push_back(*texture);
    disney_.parameters[parameter] = texture ? Vec3f(factor) : color_of(constant(color), otherwise) * factor;
    if (is_connected(weight) && !disney_.inputConnections[parameter].empty())
      disney_.parameters[parameter] = texture ? Vec3f(1) : color_of(constant(color), otherwise);
  }

  // Below the surface a mixture of diffuse and subsurface light is one walk through a shorter distance.
  void read_base() {
    read_weighted("base", 1, "base_color", Vec3f(0.8f), "baseColor");
    const float share = number("subsurface", 0);
    if (is_connected("subsurface"))
      warn_("material.subsurface", "a texture of the weight subsurface is not read; its constant is used");
    if (share <= 0) return;
    Vec3f albedo(0.5f);  // under a texture, whose mean is not known
    if (const auto texture = connection("subsurface_color")) {
      disney_.inputConnections["baseColor"] = {*texture};
      disney_.parameters["baseColor"] = Vec3f(1);
    } else if (disney_.inputConnections["baseColor"].empty() || share >= 1) {
      const Vec3f below = color_of(constant("subsurface_color"), Vec3f(1));
      albedo = disney_.parameters["baseColor"].get_or(Vec3f(0)) * (1 - share) + below * share;
      disney_.inputConnections.erase("baseColor");
      disney_.parameters["baseColor"] = albedo;
    }
    if (is_connected("subsurface_radius"))
      warn_("material.subsurface", "a texture of subsurface_radius is not read; its constant is used");
    const Vec3f radius = color_of(constant("subsurface_radius"), Vec3f(1)) * plain("subsurface_scale", 1) * share;
    disney_.parameters["scatterDistance"] = ScatterDistance(radius, albedo);
    disney_.parameters["scatterAnisotropy"] = plain("subsurface_anisotropy", 0);
  }

  // With a depth the colour is that of the interior, else that of the light which passes.
  void read_transmission() {
    if (!is_used("transmission")) return;
    for (const Unread& input : kUnreadOfTransmission) warn_of(input);
    const float depth = plain("transmission_depth", 0);
    Vec3f color = color_of(constant("transmission_color"), Vec3f(1));
    if (depth > 0) {
      if (is_connected("transmission_color"))
        warn_("material.standard_surface",
              "a texture of transmission_color is not read where light is absorbed by depth; its constant is used");
      disney_.parameters["attenuationColor"] = color;
      disney_.parameters["attenuationDistance"] = depth;
      color = Vec3f(1);  // the surface itself takes nothing
    } else if (connect("transmission_color", "baseColor")) {
      disney_.parameters["baseColor"] = Vec3f(1);
      return;
    }
    const float share = is_connected("transmission") ? 1.0f : std::min(number("transmission", 0), 1.0f);
    const Vec3f base = disney_.parameters["baseColor"].get_or(Vec3f(1));
    disney_.parameters["baseColor"] = base * (1 - share) + color * share;
  }

  void read_opacity() {
    if (connect("opacity", "opacity")) return;
    const Vec3f opacity = color_of(constant("opacity"), Vec3f(1));
    if (opacity == Vec3f(1)) return;
    disney_.parameters["opacity"] = (opacity.x + opacity.y + opacity.z) / 3;
  }

  void read_normal(const char* name, const char* input) {
    if (const MaterialConnection* const given = upstream(surface_, name))
      if (const auto map = images_.read_normals(name, *given)) disney_.inputConnections[input] = {*map};
  }

  void warn_of(const Unread& input) const {
    if (is_connected(input.name) || color_of(constant(input.name), input.initial) != input.initial)
      warn_("material.standard_surface", std::string(input.name) + " of Standard Surface is not read");
  }

  const MaterialNode& surface_;
  const WarnMaterial& warn_;
  MaterialNetwork to_;
  MaterialNode disney_;
  MaterialImages images_;
};

// OpenUSD's scene index gives each parameter a companion "colorSpace:NAME", empty where the file gives none.
MaterialNetwork without_empty_color_spaces(MaterialNetwork network, const Path& surface) {
  std::erase_if(network.nodes[surface].parameters, [](const auto& parameter) {
    return parameter.first.str().starts_with("colorSpace:") && parameter.second.text_or("").empty();
  });
  return network;
}

}  // namespace

Vec3f ScatterDistance(const Vec3f& mean_free_path, const Vec3f& albedo) {
  Vec3f distance;
  for (int i = 0; i < 3; ++i)
    distance[i] = std::max(mean_free_path[i], 0.0f) / static_cast<float>(distance_scale(double(albedo[i])));
  return distance;
}

MaterialNetwork TranslateMaterial(const MaterialNetwork& network, const WarnMaterial& warn) {
  const auto terminal = network.terminals.find("surface");
  if (terminal == network.terminals.end()) return network;
  const auto surface = network.nodes.find(terminal->second.upstreamNode);
  if (surface == network.nodes.end()) return network;
  const auto& [id, node] = *surface;
  if (node.nodeTypeId == hd::Token("AlabasterDisney")) return without_empty_color_spaces(network, id);
  return node.nodeTypeId == hd::Token(kStandardSurface) ? StandardSurface(network, node, warn).run(id) : network;
}

}  // namespace alabaster::hydra
