#include <algorithm>

#include "delegate/description/description_reader.h"
#include "delegate/description/name_match.h"
#include "delegate/description/placement.h"
#include "delegate/description/schema_check.h"

namespace alabaster::hd::description {
namespace {

using nlohmann::json;

const json& light_parameters() {
  static const json properties = expanded_schema("lights")["properties"];
  return properties;
}

bool set_parameter(const Reader& reader, const std::string& pointer, const std::string& name, const json& value,
                   host::LightDescription* light) {
  const json& schema = light_parameters()[name];
  if (const auto types = schema.find("appliesTo"); types != schema.end())
    if (std::find(types->begin(), types->end(), light->type.str()) == types->end())
      return reader.fail(pointer, "A " + light->type.str() + " has no '" + name + "'; that belongs to " +
                                      (*types)[0].get<std::string>() + ".");
  if (name == "texture:file" || name == "shaping:ies:file") {
    const std::string file = value;
    const AssetPath asset = file.empty()             ? AssetPath()
                            : name == "texture:file" ? reader.image(pointer, file)
                                                     : reader.asset(pointer, file);
    if (!file.empty() && asset.resolved.empty()) return false;
    light->parameters[name] = asset;
    return true;
  }
  light->parameters[name] = value.is_number() ? Value(value.get<float>()) : to_value(value);
  return true;
}

bool place_light(const Reader& reader, const std::string& pointer, const json& entry, host::LightDescription* light) {
  const bool aimed = entry.contains("position") || entry.contains("target") || entry.contains("up");
  if (entry.contains("transform")) {
    if (aimed) return reader.fail(pointer, "Give either a transform or position, target and up.");
    const auto transform = to_transform(entry["transform"]);
    if (!transform) return reader.fail(pointer + "/transform", "The transform cannot be inverted or is not affine.");
    light->transform = *transform;
  }
  if (!aimed) return true;
  Matrix4d& m = light->transform;
  const Vec3d position = entry.contains("position") ? to_vec3d(entry["position"]) : m.translation();
  if (entry.contains("target")) {
    const Vec3d up = entry.contains("up") ? to_vec3d(entry["up"]) : Vec3d(0, 1, 0);
    const auto aim = look_at(position, to_vec3d(entry["target"]), up, !entry.contains("up"));
    if (!aim)
      return reader.fail(pointer,
                         "The light has no direction: position and target coincide, or up lies along the aim.");
    m = *aim;
  } else if (entry.contains("up")) {
    return reader.fail(pointer + "/up", "'up' needs a 'target'.");
  }
  for (int i = 0; i < 3; ++i) m[3][i] = position[i];
  return true;
}

// Puts the meshes that the names match in a category of the light's own.
bool link(const Reader& reader, const std::string& pointer, const json& names, const std::string& category) {
  for (size_t i = 0; i < names.size(); ++i)
    if (find_prims(reader, PrimKind::mesh, names[i], pointer + "/" + std::to_string(i)).empty()) return false;
  reader.state().links.push_back({Token(category), names.get<std::vector<std::string>>()});
  apply_link(reader.state().links.back(), &reader.scene());
  return true;
}

bool change_light(const Reader& reader, const std::string& pointer, const json& entry, const Path& path,
                  host::LightDescription light) {
  for (const auto& [name, value] : entry.items())
    if (light_parameters().contains(name))
      if (!set_parameter(reader, pointer_append(pointer, name), name, value, &light)) return false;
  for (const char* const name : {"lightLink", "shadowLink"})
    if (const auto names = entry.find(name); names != entry.end()) {
      const std::string category = std::string(name) + " of " + path.str();
      if (!link(reader, pointer_append(pointer, name), *names, category)) return false;
      light.parameters[name] = category;
    }
  // A point light has no radius unless one is given.
  if (entry.value("treatAsPoint", false) && !light.parameters.contains("radius")) light.parameters["radius"] = 0.0f;
  if (!place_light(reader, pointer, entry, &light)) return false;
  reader.scene().SetLight(path, std::move(light));
  return true;
}

bool apply_entry(const Reader& reader, const std::string& pointer, const json& entry) {
  if (entry.contains("match")) {
    if (entry.contains("name") || entry.contains("type"))
      return reader.fail(pointer, "Either match existing lights, or give the name and type of a new one.");
    const auto paths = find_prims(reader, PrimKind::light, entry["match"], pointer + "/match");
    for (const Path& path : paths)
      if (!change_light(reader, pointer, entry, path, reader.scene().GetLights().at(path))) return false;
    return !paths.empty();
  }
  const Path path = Path("/lights").append(entry["name"]);
  if (reader.scene().GetLights().contains(path) || reader.state().archive_paths.contains(path))
    return reader.fail(pointer + "/name",
                       "There is already a " +
                           std::string(reader.scene().GetLights().contains(path) ? "light" : "prim") + " '" +
                           path.str() + "'; choose another name.");
  host::LightDescription light;
  light.type = entry["type"].get<std::string>();
  return change_light(reader, pointer, entry, path, std::move(light));
}

}  // namespace

void apply_link(const MeshLink& link, host::RetainedSceneDelegate* scene) {
  for (const auto& [path, mesh] : scene->GetMeshes()) {
    const Path& mesh_path = path;
    const MeshTopology& topology = mesh.topology;
    std::vector<Token> categories = mesh.categories;
    std::erase(categories, link.category);
    const auto is_match = [&](const std::string& pattern) {
      return matches(pattern, mesh_path, true) || !matching_subsets(pattern, topology).empty();
    };
    if (std::any_of(link.patterns.begin(), link.patterns.end(), is_match)) categories.push_back(link.category);
    if (categories == mesh.categories) continue;
    host::MeshDescription changed = mesh;
    changed.categories = std::move(categories);
    scene->SetMesh(path, std::move(changed));
  }
}

bool place_lights(const Reader& reader) {
  const auto entries = reader.value().find("lights");
  if (entries == reader.value().end()) return true;
  for (size_t i = 0; i < entries->size(); ++i) {
    const json& entry = (*entries)[i];
    const std::string pointer = "/lights/" + std::to_string(i);
    if (!entry.contains("match")) continue;
    for (const Path& path : find_prims(reader, PrimKind::light, entry["match"], pointer + "/match")) {
      host::LightDescription light = reader.scene().GetLights().at(path);
      if (!place_light(reader, pointer, entry, &light)) return false;
      reader.scene().SetLight(path, std::move(light));
    }
  }
  return true;
}

bool apply_lights(const Reader& reader) {
  const auto entries = reader.value().find("lights");
  if (entries == reader.value().end()) return true;
  for (size_t i = 0; i < entries->size(); ++i)
    if (!apply_entry(reader, "/lights/" + std::to_string(i), (*entries)[i])) return false;
  return true;
}

}  // namespace alabaster::hd::description
