// Edits of lights as fields of their prims.
#include <algorithm>

#include "delegate/description/load_state.h"
#include "delegate/description/placement.h"
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
    fields->emplace_back(name, value.is_number() ? Value(value.get<float>()) : support::value_of(value));
  }
}

/// Where the entry puts a light; empty: it leaves the light where it is, at `own`.
std::optional<Matrix4d> placement_of(LoadState& load, const std::string& pointer, const json& entry,
                                     const Matrix4d& own) {
  const bool aimed = entry.contains("position") || entry.contains("target") || entry.contains("up");
  if (entry.contains("transform")) {
    if (aimed) load.fail(pointer, "Give either a transform or position, target and up.");
    const auto transform = to_transform(entry["transform"]);
    if (!transform) load.fail(pointer + "/transform", "The transform cannot be inverted or is not affine.");
    return transform;
  }
  if (!aimed) return std::nullopt;
  Matrix4d m = own;
  const Vec3d position = entry.contains("position") ? to_vec3d(entry["position"]) : m.translation();
  if (entry.contains("target")) {
    const Vec3d up = entry.contains("up") ? to_vec3d(entry["up"]) : up_vector(load.result->info.up);
    const auto aim = look_at(position, to_vec3d(entry["target"]), up, !entry.contains("up"));
    if (!aim) load.fail(pointer, "The light has no direction: position and target coincide, or up lies along the aim.");
    m = *aim;
  } else if (entry.contains("up")) {
    load.fail(pointer + "/up", "'up' needs a 'target'.");
  }
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

/// Gives `light`, which is new unless there is one of the path, what the entry says.
void change_light(LoadState& load, const std::string& pointer, const json& entry, const Path& path,
                  const host::LightDescription& light, const Token& new_kind) {
  static const auto* const rows = new std::vector(host::ParameterRows("lights"));
  host::Fields fields;
  for (const host::FieldRow& row : *rows)
    if (entry.contains(row.name)) add_field(load, pointer_append(pointer, row.name), row, entry, light, &fields);
  for (const char* const name : {"lightLink", "shadowLink"})
    if (const auto names = entry.find(name); names != entry.end()) {
      const std::string category = std::string(name) + " of " + path.str();
      link(load, pointer_append(pointer, name), *names, category);
      fields.emplace_back(name, category);
    }
  // A point light has no radius unless one is given.
  if (entry.value("treatAsPoint", false) && !light.parameters.contains("radius") && !entry.contains("radius"))
    fields.emplace_back("radius", 0.0f);
  if (const auto placed = placement_of(load, pointer, entry, light.transform))
    fields.emplace_back("transform", *placed);
  load.edit(pointer, path, new_kind, fields);
}

// The dome of the options, which is the last light, takes their place.
void remove_domes(host::RetainedSceneDelegate* scene) {
  std::vector<Path> domes;
  for (const auto& [path, light] : scene->GetLights())
    if (light.type == Token("domeLight")) domes.push_back(path);
  for (const Path& path : domes) scene->Remove(path);
}

void apply_light_entry(LoadState& load, const std::string& pointer, const json& entry) {
  if (entry.contains("match")) {
    if (entry.contains("name") || entry.contains("type"))
      load.fail(pointer, "Either match existing lights, or give the name and type of a new one.");
    for (const Path& path : find_prims(load, "light", entry["match"], pointer + "/match"))
      change_light(load, pointer, entry, path, load.scene->GetLights().at(path), {});
    return;
  }
  const Path path = new_path(load, "light", "/lights", pointer, entry["name"]);
  host::LightDescription light;
  light.type = entry["type"].get<std::string>();
  change_light(load, pointer, entry, path, light, light.type);
  add_name(load, "light", path);
}

}  // namespace

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
    if (categories == mesh.categories) continue;
    host::MeshDescription changed = mesh;
    changed.categories = std::move(categories);
    load.scene->SetMesh(path, std::move(changed));
  }
}

void place_lights(LoadState& load) {
  load.for_each_entry("lights", [&](const std::string& pointer, const json& entry) {
    if (!entry.contains("match")) return;
    for (const Path& path : find_prims(load, "light", entry["match"], pointer + "/match")) {
      const auto placed = placement_of(load, pointer, entry, load.scene->GetLights().at(path).transform);
      if (placed) load.edit(pointer, path, {}, {{"transform", *placed}});
    }
  });
}

void apply_lights(LoadState& load) {
  const json* lights = load.part("lights");
  const std::string dome =
      lights && !load.options.dome.empty() ? "/lights/" + std::to_string(lights->size() - 1) : std::string();
  load.for_each_entry("lights", [&](const std::string& pointer, const json& entry) {
    if (pointer == dome) remove_domes(load.scene), load.names.erase("light");
    apply_light_entry(load, pointer, entry);
  });
  apply_links(load);
}

}  // namespace alabaster::hd::description
