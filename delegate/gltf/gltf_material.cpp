#include "delegate/gltf/gltf_material.h"

#include "core/material/disney_material.h"
#include "delegate/gltf/gltf_material_parts.h"
#include "delegate/support/nearest_name.h"

namespace alabaster::hd::gltf {
namespace {

std::string suggestion(const std::string& name) {
  std::vector<std::string> names;
  for (const MaterialParameter& parameter : material_parameters()) names.emplace_back(parameter.name);
  const std::string nearest = support::NearestName(name, names);
  return nearest.empty() ? "; schemas/disney_material.json lists them" : "; did you mean '" + nearest + "'?";
}

// The parameter of "baseColorTexture"; empty for other keys.
std::string textured_parameter(const std::string& key) {
  constexpr std::string_view kEnd = "Texture";
  return key.size() > kEnd.size() && key.ends_with(kEnd) ? key.substr(0, key.size() - kEnd.size()) : "";
}

bool is_color(const tinygltf::Value& value) {
  return value.IsArray() && value.ArrayLen() == 3 && value.Get(0).IsNumber() && value.Get(1).IsNumber() &&
         value.Get(2).IsNumber();
}

// True if the value has the parameter's type.
bool set_value(const MaterialParameter& parameter, const tinygltf::Value& value, MaterialBuilder* material) {
  if (parameter.is_color()) {
    if (!is_color(value)) return false;
    material->set(parameter.name,
                  Vec3f(float(value.Get(0).GetNumberAsDouble()), float(value.Get(1).GetNumberAsDouble()),
                        float(value.Get(2).GetNumberAsDouble())));
  } else if (std::holds_alternative<bool DisneyParameters::*>(parameter.member)) {
    if (!value.IsBool()) return false;
    material->set(parameter.name, value.Get<bool>());
  } else {
    if (!value.IsNumber()) return false;
    material->set(parameter.name, value.GetNumberAsDouble());
  }
  return true;
}

const char* type_of(const MaterialParameter& parameter) {
  if (parameter.is_color()) return "must be three numbers";
  return std::holds_alternative<bool DisneyParameters::*>(parameter.member) ? "must be true or false"
                                                                            : "must be a number";
}

// The constants of this extension replace those of the other extensions, its textures all that is connected to the same
// parameter.
void set_disney_extension(MaterialBuilder* material) {
  const Extension disney = material->extension("ALAB_materials_disney");
  if (!disney) return;
  for (const std::string& key : disney->Keys()) {
    const std::string place = "extensions.ALAB_materials_disney." + key, textured = textured_parameter(key);
    const MaterialParameter* parameter = find_material_parameter(textured.empty() ? key : textured);
    if (!parameter || (!textured.empty() && !parameter->is_textured())) {
      material->error("material.disney", place, "is not a parameter" + suggestion(key));
    } else if (textured.empty()) {
      if (!set_value(*parameter, disney->Get(key), material))
        material->error("material.disney", place, type_of(*parameter) + std::string("; correct the value"));
    } else {
      material->disconnect(parameter->name);
      material->connect(
          parameter->name, use_in(disney, key.c_str()),
          parameter->texels == Texels::colors ? color_reading() : number_reading(parameter->is_color() ? "rgb" : "r"));
    }
  }
}

}  // namespace

MaterialNetwork translate_material(const Document& document, size_t index, const VertexColors& vertex, const Path& id,
                                   Report& report) {
  const tinygltf::Material& source = document.model.materials[index];
  MaterialBuilder material(document, source, id, element_name("materials", index), report);
  const BaseColor base = base_color_of(source);
  if (material.extension("KHR_materials_unlit")) {
    set_unlit(base, vertex, &material);
  } else {
    set_base(base, vertex, &material);
    set_emission(&material);
    set_dielectric(&material);
    set_anisotropy(&material);
    set_clearcoat(&material);
    set_sheen(&material);
    set_iridescence(&material);
    set_transmission(&material);
    set_scatter(&material);
  }
  set_opacity(base, vertex, &material);
  set_disney_extension(&material);
  return material.finish();
}

}  // namespace alabaster::hd::gltf
