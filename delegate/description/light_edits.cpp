// Edits of lights as fields of their prims.
#include <algorithm>

#include "delegate/description/load_state.h"
#include "delegate/description/placement.h"
#include "delegate/description/places.h"
#include "delegate/support/json_values.h"
#include "delegate/support/lookup.h"

namespace alabaster::hd::description {
namespace {

using nlohmann::json;
using support::text_in;

/// Adds the field that a key of the entry sets.
void add_field(LoadState& load, const std::string& pointer, const host::FieldRow& row, const json& entry,
               const host::LightDescription& light, host::Fields* fields) {
  const std::string& name = row.name;
  const json& value = entry[name];
  if (!row.lights.empty() && std::find(row.lights.begin(), row.lights.end(), light.type.str()) == row.lights.end())
    load.fail(pointer, "A " + light.type.str() + " has no '" + name + "'; that belongs to " + row.lights[0] + ".");
  if (name == "texture:file" || name == "shaping:ies:file") {
    const std::string file = value, layer = entry.value("texture:layer", text_in(light.parameters, "texture:layer"));
    fields->emplace_back(name, file.empty()             ? AssetPath()
                               : name == "texture:file" ? load.image(pointer, file, layer)
                                                        : load.asset(pointer, file));
  } else {
    fields->emplace_back(name, field_value(value));
  }
}

/// Where the entry puts a light; empty: it leaves the light where it is, at `own`.
std::optional<Matrix4d> light_placement(LoadState& load, const std::string& pointer, const json& entry,
                                        const Matrix4d& own) {
  const bool aimed = entry.contains("position") || entry.contains("target") || entry.contains("up");
  if (!aimed) return placement_of(load, pointer, entry).transform;
  if (entry.contains("transform")) load.fail(pointer, "Give either a transform or position, target and up.");
  const Vec3d position = entry.contains("position") ? to_vec3d(entry["position"]) : own.translation();
  Matrix4d m = own;
  if (entry.contains("target"))
    m = aimed_at(load, pointer, position, to_vec3d(entry["target"]), entry.contains("up") ? &entry["up"] : nullptr);
  else if (entry.contains("up"))
    load.fail(pointer + "/up", "'up' needs a 'target'.");
  for (int i = 0; i < 3; ++i) m[3][i] = position[i];
  return m;
}

// Checks the names of meshes for a category of the light's own, which apply_links gives them.
void link(LoadState& load, const std::string& pointer, const json& names, const std::string& category) {
  for (size_t i = 0; i < names.size(); ++i) {
    const std::string place = pointer + "/" + std::to_string(i);
    for (const Path& path : find_prims(load, "mesh", names[i], place))
      if (!matches(names[i], path, *load.scene))
        load.warn(place, "Applies to all of mesh '" + path.str() + "', of which the name means a part.");
  }
  load.links[Token(category)] = names.get<std::vector<std::string>>();
}

}  // namespace

void read_light(LoadState& load, PrimEdit* edit) {
  static const auto* const rows = new std::vector(host::ParameterRows("lights"));
  const std::string& pointer = edit->pointer;
  const json& entry = edit->entry;
  host::LightDescription light;
  if (edit->is_new)
    edit->kind = light.type = entry["type"].get<std::string>();
  else if (entry.contains("type"))
    load.fail(pointer, "Either match existing lights, or give the name and type of a new one.");
  else
    light = load.scene->GetLights().at(edit->path);
  for (const host::FieldRow& row : *rows)
    if (entry.contains(row.name)) add_field(load, pointer_append(pointer, row.name), row, entry, light, &edit->fields);
  for (const char* const name : {"lightLink", "shadowLink"})
    if (const auto names = entry.find(name); names != entry.end()) {
      const std::string category = std::string(name) + " of " + edit->path.str();
      link(load, pointer_append(pointer, name), *names, category);
      edit->fields.emplace_back(name, category);
    }
  // A point light has no radius unless one is given.
  if (entry.value("treatAsPoint", false) && !light.parameters.contains("radius") && !entry.contains("radius"))
    edit->fields.emplace_back("radius", 0.0f);
  if (const auto placed = light_placement(load, pointer, entry, light.transform))
    edit->fields.emplace_back("transform", *placed);
}

void remove_lights(host::RetainedSceneDelegate* scene, bool domes) {
  std::vector<Path> found;
  for (const auto& [path, light] : scene->GetLights())
    if ((light.type == Token("domeLight")) == domes) found.push_back(path);
  for (const Path& path : found) scene->Remove(path);
}

void apply_links(LoadState& load) {
  if (load.links.empty()) return;
  std::map<Path, std::set<Token>> linked;
  for (const auto& [category, patterns] : load.links)
    for (const std::string& pattern : patterns)
      for (const Path& path : find_prims(load, "mesh", pattern, "")) linked[path].insert(category);
  for (const auto& [path, mesh] : load.scene->GetMeshes()) {
    std::vector<Token> categories = mesh.categories;
    std::erase_if(categories, [&](const Token& category) { return load.links.contains(category); });
    const std::set<Token> own = support::value_in(linked, path);
    categories.insert(categories.end(), own.begin(), own.end());
    if (!(categories == mesh.categories)) load.edit("", path, {}, {{"categories", std::move(categories)}});
  }
}

}  // namespace alabaster::hd::description
