#include "delegate/gltf/gltf_material.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "core/material/disney_material.h"
#include "core/material/fresnel.h"
#include "core/subsurface/medium.h"
#include "delegate/gltf/gltf_names.h"
#include "delegate/support/nearest_name.h"

namespace alabaster::hd::gltf {
namespace {

using Extension = const tinygltf::Value*;  // null: the material does not have it

Extension find_extension(const tinygltf::Material& material, const char* name) {
  const auto found = material.extensions.find(name);
  return found == material.extensions.end() ? nullptr : &found->second;
}

double number_or(Extension extension, const char* name, double fallback, double low = 0, double high = 1) {
  if (!extension || !extension->Has(name)) return fallback;
  return std::clamp(extension->Get(name).GetNumberAsDouble(), low, high);
}

Vec3f color_or(Extension extension, const char* name, const Vec3f& fallback, float high = 1) {
  if (!extension || !extension->Has(name)) return fallback;
  Vec3f color;
  for (int c = 0; c < 3; ++c) color[c] = std::clamp(float(extension->Get(name).Get(c).GetNumberAsDouble()), 0.0f, high);
  return color;
}

Vec3f to_color(const std::vector<double>& values, const Vec3f& fallback) {
  if (values.size() < 3) return fallback;
  Vec3f color;
  for (int c = 0; c < 3; ++c) color[c] = std::clamp(float(values[size_t(c)]), 0.0f, 1.0f);
  return color;
}

Token wrap_token(int wrap) {
  if (wrap == TINYGLTF_TEXTURE_WRAP_CLAMP_TO_EDGE) return "clamp";
  return wrap == TINYGLTF_TEXTURE_WRAP_MIRRORED_REPEAT ? "mirror" : "repeat";
}

constexpr float kUnlimited = std::numeric_limits<float>::max();

// True if the volume has an extinction, as scattering requires.
bool attenuates(Extension volume) {
  return number_or(volume, "attenuationDistance", 0, 0, double(kUnlimited)) > 0 &&
         color_or(volume, "attenuationColor", Vec3f(1)) != Vec3f(1);
}

const MaterialParameter* find_disney_parameter(const std::string& name) {
  for (const MaterialParameter& parameter : material_parameters())
    if (name == parameter.name) return &parameter;
  return nullptr;
}

std::string suggestion(const std::string& name) {
  std::vector<std::string> names;
  for (const MaterialParameter& parameter : material_parameters()) names.emplace_back(parameter.name);
  const std::string nearest = support::NearestName(name, names);
  return nearest.empty() ? "" : "; did you mean '" + nearest + "'?";
}

TextureUse use_in(Extension extension, const char* name) {
  TextureUse use;
  if (!extension || !extension->Has(name)) return use;
  const tinygltf::Value& info = extension->Get(name);
  use.index = info.Get("index").GetNumberAsInt();
  if (info.Has("texCoord")) use.coordinates = info.Get("texCoord").GetNumberAsInt();
  if (info.Has("extensions") && info.Get("extensions").Has("KHR_texture_transform"))
    use.transform = &info.Get("extensions").Get("KHR_texture_transform");
  return use;
}

TextureUse use_of(const tinygltf::TextureInfo& info) {
  const auto transform = info.extensions.find("KHR_texture_transform");
  return {info.index, info.texCoord, transform == info.extensions.end() ? nullptr : &transform->second};
}

class MaterialTranslator {
 public:
  MaterialTranslator(const Document& document, size_t index, const Path& id, Report& report)
      : document_(document),
        material_(document.model.materials[index]),
        id_(id),
        report_(report),
        element_(element_name("materials", index)) {}

  MaterialNetwork run() {
    surface_.nodeTypeId = "AlabasterDisney";
    set_base();
    set_dielectric();
    set_emission();
    set_subsurface();
    set_sheen();
    set_disney_extension();
    set_textures();
    report_unread();
    MaterialNetwork network;
    const Path surface_id = id_.append("surface");
    network.nodes = std::move(textures_);
    network.nodes[surface_id] = std::move(surface_);
    network.terminals["surface"] = {surface_id, "surface"};
    return network;
  }

 private:
  void set(const char* name, double value) { surface_.parameters[name] = float(value); }
  void set(const char* name, const Vec3f& value) { surface_.parameters[name] = value; }

  void set_base() {
    const auto& pbr = material_.pbrMetallicRoughness;
    base_color_ = to_color(pbr.baseColorFactor, Vec3f(1));
    set("baseColor", base_color_);
    double metallic = std::clamp(pbr.metallicFactor, 0.0, 1.0), roughness = std::clamp(pbr.roughnessFactor, 0.0, 1.0);
    if (pbr.metallicRoughnessTexture.index >= 0) {
      // The factors scale a texture whose values are unknown here. Without it they would turn most objects into rough
      // metal.
      metallic = 0;
      roughness *= 0.5;
      report_.warning("material.texture", element_ + ".pbrMetallicRoughness.metallicRoughnessTexture",
                      "is not supported; metallic 0 and half the roughness factor are used instead");
    }
    set("metallic", metallic);
    set("roughness", roughness);
  }

  void set_textures() {
    connect_texture("baseColor", uses_.base_color, "sRGB");
    connect_texture("scatterDistance", uses_.scatter_distance, "raw");
  }

  void connect_texture(const char* input, const TextureUse& use, const char* color_space) {
    if (use.index < 0) return;
    const tinygltf::Texture& texture = document_.model.textures[size_t(use.index)];
    // A texture without an image is passed on, too: the renderer tells what the picture lacks.
    const AssetPath none{element_name("textures", size_t(use.index)), "", nullptr};
    const AssetPath& image = texture.source < 0 ? none : document_.images[size_t(texture.source)];
    int wrap_s = TINYGLTF_TEXTURE_WRAP_REPEAT, wrap_t = TINYGLTF_TEXTURE_WRAP_REPEAT;
    if (texture.sampler >= 0) {
      wrap_s = document_.model.samplers[size_t(texture.sampler)].wrapS;
      wrap_t = document_.model.samplers[size_t(texture.sampler)].wrapT;
    }
    MaterialNode& node = textures_[id_.append(input)];
    node.nodeTypeId = "AlabasterTexture";
    node.parameters["file"] = image;
    node.parameters["sourceColorSpace"] = Token(color_space);
    node.parameters["wrapS"] = wrap_token(wrap_s);
    node.parameters["wrapT"] = wrap_token(wrap_t);
    place_texture(use, &node);
    surface_.inputConnections[input] = {{id_.append(input), "rgb"}};
  }

  static void place_texture(const TextureUse& use, MaterialNode* node) {
    int set = use.coordinates;
    if (use.transform) {
      const tinygltf::Value& transform = *use.transform;
      if (transform.Has("texCoord")) set = transform.Get("texCoord").GetNumberAsInt();
      node->parameters["stOffset"] = pair_or(transform, "offset", Vec2f(0, 0));
      node->parameters["stScale"] = pair_or(transform, "scale", Vec2f(1, 1));
      node->parameters["stRotation"] =
          float(transform.Has("rotation") ? transform.Get("rotation").GetNumberAsDouble() : 0.0);
    }
    node->parameters["st"] = Token(uv_set_name(set));
  }

  static Vec2f pair_or(const tinygltf::Value& value, const char* name, const Vec2f& fallback) {
    if (!value.Has(name)) return fallback;
    const tinygltf::Value& pair = value.Get(name);
    return {float(pair.Get(0).GetNumberAsDouble()), float(pair.Get(1).GetNumberAsDouble())};
  }

  void set_dielectric() {
    double ior = number_or(find_extension(material_, "KHR_materials_ior"), "ior", 1.5, 0, 1e3);
    if (ior < 1) {
      report_.warning("material.ior", element_, "an ior below 1 is not supported; 1.5 is used");
      ior = 1.5;
    }
    set("ior", ior);
    if (Extension specular = find_extension(material_, "KHR_materials_specular")) {
      set("specular", number_or(specular, "specularFactor", 1));
      set("specularColor", color_or(specular, "specularColorFactor", Vec3f(1), kUnlimited));
    }
    if (Extension clearcoat = find_extension(material_, "KHR_materials_clearcoat")) {
      const double roughness = number_or(clearcoat, "clearcoatRoughnessFactor", 0);
      set("clearcoat", number_or(clearcoat, "clearcoatFactor", 0));
      set("clearcoatGloss", std::clamp((0.1 - roughness * roughness) / 0.099, 0.0, 1.0));
    }
  }

  void set_emission() {
    const Vec3f factor = to_color(material_.emissiveFactor, Vec3f(0));
    if (factor == Vec3f(0)) return;
    if (material_.emissiveTexture.index >= 0)
      return report_.warning(
          "material.texture", element_ + ".emissiveTexture",
          "is not supported, so the material does not emit; remove the texture for uniform emission");
    const Extension strength = find_extension(material_, "KHR_materials_emissive_strength");
    set("emission", factor * float(number_or(strength, "emissiveStrength", 1, 0, double(kUnlimited))));
  }

  void set_subsurface() {
    const Extension volume = find_extension(material_, "KHR_materials_volume");
    const Extension scatter = find_extension(material_, "KHR_materials_volume_scatter");
    if (!scatter) return;
    if (!volume)
      return report_.warning("material.scatter", element_ + ".extensions.KHR_materials_volume_scatter",
                             "requires KHR_materials_volume; the surface is opaque");
    const double distance = number_or(volume, "attenuationDistance", 0, 0, double(kUnlimited));
    const Vec3f attenuation = color_or(volume, "attenuationColor", Vec3f(1));
    if (!attenuates(volume))
      return report_.warning(
          "material.scatter", element_ + ".extensions.KHR_materials_volume",
          "has no extinction, which scattering requires; set attenuationDistance and attenuationColor");
    // The draft renamed the key; the later name takes precedence.
    const char* key = scatter->Has("multiscatterColorFactor") ? "multiscatterColorFactor" : "multiscatterColor";
    const Vec3f albedo = color_or(scatter, key, Vec3f(0));
    Vec3f d;
    const double g = set_anisotropy(scatter);
    for (int c = 0; c < 3; ++c) d[c] = scatter_distance(double(attenuation[c]), distance, double(albedo[c]), g);
    base_color_ = albedo;
    set("baseColor", albedo);
    set("scatterDistance", d);
    if (material_.pbrMetallicRoughness.baseColorTexture.index >= 0 && uses_.base_color.index < 0)
      report_.warning("material.scatter", element_ + ".pbrMetallicRoughness.baseColorTexture",
                      "is left out because the scattering volume has one colour");
    if (scatter->Has("multiscatterColorTexture"))
      report_.info("material.scatter", element_ + ".extensions.KHR_materials_volume_scatter.multiscatterColorTexture",
                   "colours the medium; the scatter distance is that of the factor's colour everywhere");
    if (!find_extension(material_, "KHR_materials_diffuse_transmission"))
      report_.info("material.scatter", element_,
                   "is drawn as a dense medium although it has no KHR_materials_diffuse_transmission");
  }

  double set_anisotropy(Extension scatter) {
    const double authored = number_or(scatter, "scatterAnisotropy", 0, -1, 1), g = std::clamp(authored, -0.9, 0.9);
    if (g != authored)
      report_.warning("material.scatter", element_ + ".extensions.KHR_materials_volume_scatter.scatterAnisotropy",
                      "is outside -0.9 to 0.9; the nearest value is used");
    if (g != 0) set("scatterAnisotropy", g);
    return g;
  }

  void set_sheen() {
    const Extension extension = find_extension(material_, "KHR_materials_sheen");
    const Vec3f color = color_or(extension, "sheenColorFactor", Vec3f(0));
    const float sheen = std::max({color.x, color.y, color.z});
    if (sheen <= 0) return;
    // minimise |color / sheen - (white + t (hue - white))| over t in [0, 1], with the hue that the lobe mixes with
    const Rgb hue = tint({base_color_.x, base_color_.y, base_color_.z});
    const Vec3f colored = Vec3f(hue.r, hue.g, hue.b) - Vec3f(1), wanted = color / sheen - Vec3f(1);
    const float t = colored.length2() > 1e-8f ? colored.dot(wanted) / colored.length2() : 0.0f;
    set("sheen", double(sheen));
    set("sheenTint", double(std::clamp(t, 0.0f, 1.0f)));
  }

  void set_disney_extension() {
    const Extension disney = find_extension(material_, "ALAB_materials_disney");
    if (!disney) return;
    for (const std::string& key : disney->Keys()) {
      const tinygltf::Value& value = disney->Get(key);
      const std::string place = element_ + ".extensions.ALAB_materials_disney." + key;
      const bool texture = is_texture(key);
      const MaterialParameter* parameter = find_disney_parameter(texture ? key.substr(0, key.size() - 7) : key);
      if (texture && parameter && (key == "baseColorTexture" || key == "scatterDistanceTexture"))
        continue;  // set_textures()
      if (texture || !parameter) {
        report_.error("material.disney", place, "is not a parameter" + suggestion(key));
      } else if (std::holds_alternative<bool DisneyParameters::*>(parameter->member)) {
        if (value.IsBool())
          surface_.parameters[parameter->name] = value.Get<bool>();
        else
          report_.error("material.disney", place, "must be true or false");
      } else if (parameter->is_color() ? !is_color(value) : !value.IsNumber()) {
        report_.error("material.disney", place, parameter->is_color() ? "must be three numbers" : "must be a number");
      } else if (parameter->is_color()) {
        set(parameter->name, {float(value.Get(0).GetNumberAsDouble()), float(value.Get(1).GetNumberAsDouble()),
                              float(value.Get(2).GetNumberAsDouble())});
      } else {
        set(parameter->name, value.GetNumberAsDouble());
      }
    }
  }

  static bool is_color(const tinygltf::Value& value) {
    return value.IsArray() && value.ArrayLen() == 3 && value.Get(0).IsNumber() && value.Get(1).IsNumber() &&
           value.Get(2).IsNumber();
  }

  void report_unread() {
    if (material_.normalTexture.index >= 0)
      report_.warning("material.texture", element_ + ".normalTexture", "is not supported and is ignored");
    if (material_.alphaMode != "OPAQUE")
      report_.warning("material.alpha", element_ + ".alphaMode", "is not supported; the surface is opaque");
    for (const auto& [name, extension] : material_.extensions) {
      if (!extension.IsObject() || name == "ALAB_materials_disney") continue;
      for (const std::string& key : extension.Keys())
        if (is_texture(key) && key != "multiscatterColorTexture")  // set_subsurface() reports that one
          report_.warning("material.texture", element_ + ".extensions." + name + "." + key,
                          "is not supported and is ignored");
    }
  }

  static bool is_texture(const std::string& key) {
    return key.size() > 7 && key.compare(key.size() - 7, 7, "Texture") == 0;
  }

  const Document& document_;
  const tinygltf::Material& material_;
  const Path id_;
  Report& report_;
  const std::string element_;
  Vec3f base_color_{1};
  MaterialNode surface_;
  std::map<Path, MaterialNode> textures_;
  const TextureUses uses_ = textures_of(material_);
};

}  // namespace

TextureUses textures_of(const tinygltf::Material& material) {
  const Extension disney = find_extension(material, "ALAB_materials_disney");
  const Extension scatter = find_extension(material, "KHR_materials_volume_scatter");
  const Extension volume = find_extension(material, "KHR_materials_volume");
  const bool scatters = scatter && volume && attenuates(volume);
  TextureUses uses;
  uses.scatter_distance = use_in(disney, "scatterDistanceTexture");
  uses.base_color = use_in(disney, "baseColorTexture");
  if (uses.base_color.index >= 0) return uses;
  uses.base_color =
      scatters ? use_in(scatter, "multiscatterColorTexture") : use_of(material.pbrMetallicRoughness.baseColorTexture);
  return uses;
}

float scatter_distance(double attenuation_color, double attenuation_distance, double albedo, double g) {
  if (attenuation_color <= 0 || attenuation_distance <= 0) return 0;
  const double sigma_t = -std::log(std::min(attenuation_color, 0.999)) / attenuation_distance;
  return float(1 / (sigma_t * (1 - g) * distance_scale(albedo)));
}

MaterialNetwork translate_material(const Document& document, size_t index, const Path& id, Report& report) {
  return MaterialTranslator(document, index, id, report).run();
}

}  // namespace alabaster::hd::gltf
