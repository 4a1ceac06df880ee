#include "delegate/description/write_scene.h"

#include <algorithm>
#include <set>

#include "core/math/float_environment.h"
#include "core/math/transform.h"
#include "delegate/description/description_reader.h"
#include "delegate/description/schema_check.h"
#include "delegate/description/written_gltf.h"
#include "delegate/description/written_parts.h"
#include "delegate/support/gltf_limits.h"
#include "delegate/support/instancing.h"
#include "delegate/support/selection.h"

namespace alabaster::hd::description {
namespace {

using nlohmann::json;

// More nodes than a document of support::kMostGltfValues has room for.
constexpr size_t kMostPlaces = 400000;

void check_size(const std::string& document) {
  const auto is_value = [](char c) { return c == '{' || c == '[' || c == ','; };
  if (static_cast<size_t>(std::count_if(document.begin(), document.end(), is_value)) > support::kMostGltfValues)
    throw std::runtime_error("the scene has more meshes and nodes than readers of glTF take; select a part of it");
}

std::string without_slashes(const Path& id) {
  constexpr size_t kLongest = 100;  // readers shorten names
  std::string name = id.str();
  if (!is_utf8(name)) throw NotWritten(id, "has a name that is not UTF-8, as names in files are; rename it");
  for (char& c : name)
    if (c == '/' || static_cast<unsigned char>(c) <= ' ' || c == 0x7f) c = '_';
  if (name.size() > kLongest) {
    size_t begin = name.size() - kLongest;
    while (begin < name.size() && (static_cast<unsigned char>(name[begin]) & 0xc0) == 0x80) ++begin;
    name.erase(0, begin);
  }
  // Readers take digits and a '_' at the beginning for a number of theirs.
  return name.empty() || (name[0] >= '0' && name[0] <= '9') ? "_" + name : name;
}

/// Names of prims of one kind in these files.
class Names {
 public:
  std::string give(const Path& id) {
    const std::string plain = without_slashes(id);
    std::string name = plain;
    for (int copy = 2; !taken_.insert(name).second; ++copy) name = plain + "_" + std::to_string(copy);
    return name;
  }

 private:
  std::set<std::string> taken_;
};

// Arrays are worth an extension from here on.
constexpr size_t kManyInstances = 64;

// The points of an instancer as arrays, if there are many and that is all that they are.
std::optional<InstanceList> instance_list(const support::PlacementSource& source, const Matrix4d& before) {
  if (source.indices.size() < kManyInstances || !source.points || !source.points->transforms.empty() ||
      before != Matrix4d())
    return std::nullopt;
  const support::InstanceArrays& points = *source.points;
  InstanceList list;
  for (const int32_t index : source.indices) {
    if (!source.has_point(index)) continue;
    const auto i = static_cast<size_t>(index);
    if (!is_valid_affine(points[i])) continue;
    const auto add = [&](const auto& from, const auto& otherwise, auto* to) {
      if (!from.empty()) to->push_back(i < from.size() ? from[i] : otherwise);
    };
    add(points.translations, Vec3f(0), &list.translations);
    add(points.scales, Vec3f(1), &list.scales);
    if (points.rotations.empty()) continue;
    const Quatf q = i < points.rotations.size() ? points.rotations[i] : Quatf();
    list.rotations.emplace_back(q.v.x, q.v.y, q.v.z, q.r);
  }
  if (list.translations.empty() && list.scales.empty() && list.rotations.empty()) return std::nullopt;
  return list;
}

struct DrawnMesh {
  Path id;
  const host::MeshDescription* mesh;
  PlacedMesh placed;
};

/// Collects the parts of one scene.
class SceneWriter {
 public:
  SceneWriter(const std::string& file, const SceneParts& scene, const RenderPassState& state)
      : scene_(scene), state_(state), files_(file) {}

  std::string write(const std::map<Token, Value>& settings) {
    find_meshes();
    number_uv_sets();
    std::map<std::string, NormalMaps> normals;
    json materials = make_materials(&normals);
    GltfText gltf = make_gltf(normals);
    check_size(gltf.document);
    files_.add(".bin", std::move(gltf.buffer));
    files_.add(".gltf", std::move(gltf.document));
    json description = {{"gltf", {{{"file", files_.beside(".gltf")}}}},
                        {"products", {{{"file", files_.beside(".exr")}, {"dataType", "float"}}}},
                        {"camera", written_camera(state_, scene_.cameras)},
                        {"settings", written_settings(state_, settings)}};
    if (const auto config = settings.find("ocio"); config != settings.end())
      if (const std::string name = files_.name_of("setting ocio", config->second); !name.empty())
        description["ocio"] = name;
    const auto add = [&](const char* key, json entries) {
      if (!entries.empty()) description[key] = std::move(entries);
    };
    add("materials", std::move(materials));
    add("meshes", meshes());
    add("lights", lights());
    std::string text = description.dump(1);
    if (text.size() > kMaxDescriptionBytes)
      return "the description would be larger than " + std::to_string(kMaxDescriptionBytes >> 20) +
             " MiB, which readers refuse; select a part of the scene";
    check(text);
    files_.add(".json", std::move(text));
    return files_.write();
  }

 private:
  bool has_material(const host::MeshDescription& mesh) const {
    return !mesh.material.empty() && scene_.materials.contains(mesh.material);
  }

  // Those that the pass draws, with their names and places.
  void find_meshes() {
    const support::Selection selection(state_.renderTags, state_.collection);
    host::RetainedSceneDelegate instancers;  // answers the questions that the renderer asks
    for (const auto& [id, instancer] : scene_.instancers) instancers.SetInstancer(id, instancer);
    std::map<Path, support::InstancerRecord> records;
    for (const auto& [id, instancer] : scene_.instancers) records[id] = support::pull_instancer(instancers, id, {});
    support::Placements placements(
        [&](const Path& id) {
          const auto found = records.find(id);
          return found == records.end() ? nullptr : &found->second;
        },
        {});
    Names names;
    for (const auto& [id, mesh] : scene_.meshes) {
      if (!selection.includes(id, mesh.visible, mesh.renderTag) || mesh.topology.faceVertexCounts.empty()) continue;
      DrawnMesh drawn{id, &mesh, {}};
      set_places(id, mesh, &placements, &drawn.placed);
      if (drawn.placed.places.empty()) continue;
      drawn.placed.name = names.give(id);
      set_look(mesh, &drawn.placed);
      drawn.placed.double_sided = is_double_sided(id, mesh);
      drawn_.push_back(std::move(drawn));
    }
  }

  // Leaves the places empty where the mesh stands nowhere. The renderer leaves out places that it cannot invert.
  void set_places(const Path& id, const host::MeshDescription& mesh, support::Placements* placements,
                  PlacedMesh* placed) {
    const auto add = [&](const Matrix4d& place) {
      if (is_valid_affine(place)) placed->places.push_back(place);
    };
    if (mesh.instancer.empty()) return add(mesh.transform);
    const auto instancer = scene_.instancers.find(mesh.instancer);
    if (instancer == scene_.instancers.end()) return;
    check_instancers(mesh.instancer);
    const auto indices = instancer->second.indices.find(id);
    if (indices == instancer->second.indices.end()) return;
    const support::PlacementSource source = placements->source(id, mesh.instancer, indices->second);
    placed->instances = instance_list(source, mesh.transform);
    const size_t count = placed->instances ? source.bases->size() : source.size();
    if (count + placed_ > kMostPlaces)
      throw NotWritten(id, "and other meshes have more than " + std::to_string(kMostPlaces) +
                               " instances that are not placed by translations, rotations and scales alone, which is "
                               "not written; select a part of the scene");
    for (size_t i = 0; i < count; ++i) {
      const support::Placement place = placed->instances ? (*source.bases)[i] : source[i];
      if (place.used) add(mesh.transform * place.matrix);
    }
    placed_ += placed->places.size();
  }

  // Checks an instancer and those that place it. Placements leave out instancers that place each other.
  void check_instancers(Path id) const {
    for (std::set<Path> seen; !id.empty() && seen.insert(id).second;) {
      const auto found = scene_.instancers.find(id);
      if (found == scene_.instancers.end()) return;
      const host::InstancerDescription& instancer = found->second;
      bool moves = instancer.transformSamples.values.size() > 1;
      for (const auto& [name, samples] : instancer.primvarSamples) moves |= samples.values.size() > 1;
      if (moves) throw NotWritten(id, "moves, which is not written; set it without samples");
      id = instancer.parent;
    }
  }

  void set_look(const host::MeshDescription& mesh, PlacedMesh* placed) {
    if (has_material(mesh)) {
      const auto [name, is_new] = material_names_.try_emplace(mesh.material);
      if (is_new) name->second = names_of_materials_.give(mesh.material);
      placed->material = name->second;
      return;
    }
    placed->look = own_look(mesh);
    for (const auto& [look, name] : default_names_)
      if (look == *placed->look) placed->material = name;
    if (!placed->material.empty()) return;
    placed->material = names_of_materials_.give("/default");
    default_names_.emplace_back(*placed->look, placed->material);
  }

  // Sets that have the reader's names keep them. The others get those that are free.
  void number_uv_sets() {
    std::set<Token> names;
    for (const DrawnMesh& drawn : drawn_)
      for (const Token& name : uv_names(*drawn.mesh)) names.insert(name);
    std::set<int> taken;
    constexpr int kSets = 1000;
    for (int set = 0; set < kSets; ++set)
      if (const Token name = set == 0 ? Token("st") : Token("st" + std::to_string(set)); names.erase(name) > 0)
        sets_[name] = set, taken.insert(set);
    int next = 0;
    for (const Token& name : names) {
      while (taken.contains(next)) ++next;
      sets_[name] = next, taken.insert(next);
    }
  }

  GltfText make_gltf(const std::map<std::string, NormalMaps>& normals) const {
    GltfWriter gltf(drawn_.size(), normals);
    for (const DrawnMesh& drawn : drawn_) {
      const auto& primvars = drawn.mesh->primvars;
      if (normals.contains(drawn.placed.material) && !is_cage(*drawn.mesh) && primvars.contains("tangents") &&
          !primvars.contains("normals"))
        throw NotWritten(drawn.id, "has tangents for a texture of normals but no normals, which glTF cannot hold");
      gltf.add(drawn.placed, triangles_of(drawn.id, *drawn.mesh, sets_, drawn.placed.look.value_or(OwnLook())));
    }
    return gltf.finish(files_.beside(".bin"));
  }

  json make_materials(std::map<std::string, NormalMaps>* normals) {
    json all = json::array();
    const auto add = [&](const std::string& name, json entry) {
      entry["match"] = pattern_of(name);
      all.push_back(std::move(entry));
    };
    for (const auto& [id, name] : material_names_) {
      WrittenMaterial written = written_material(id, scene_.materials.at(id), sets_, &files_);
      add(name, std::move(written.entry));
      if (!written.normals.empty()) normals->emplace(name, std::move(written.normals));
    }
    return all;
  }

  json meshes() const {
    json all = json::array();
    for (const DrawnMesh& drawn : drawn_) {
      json entry = written_mesh(drawn.id, *drawn.mesh);
      if (entry.empty()) continue;
      if (entry.value("subsurfaceSet", "") == "byMaterial") check_sides(drawn);
      entry["match"] = pattern_of(drawn.placed.name);
      all.push_back(std::move(entry));
    }
    return all;
  }

  // glTF has two materials for one that is bound to meshes with one side and with two.
  void check_sides(const DrawnMesh& one) const {
    for (const DrawnMesh& other : drawn_)
      if (other.placed.material == one.placed.material && other.placed.double_sided != one.placed.double_sided)
        throw NotWritten(one.id, "and " + other.id.str() +
                                     " differ in their sides and scatter byMaterial, which is not " +
                                     "written; name the subsurfaceSet");
  }

  // The renderer leaves out a light that stands nowhere.
  static bool is_lit(const host::LightDescription& light) { return light.visible && is_valid_affine(light.transform); }

  // The reader's lights sort by their names: these sort as the scene's.
  json lights() {
    std::vector<std::string> names;
    Names given;
    for (const auto& [id, light] : scene_.lights)
      if (is_lit(light)) names.push_back(given.give(id));
    constexpr size_t kFirst = 100000;
    if (!std::is_sorted(names.begin(), names.end()))
      for (size_t i = 0; i < names.size(); ++i) names[i] = "light" + std::to_string(kFirst + i) + names[i];
    json all = json::array();
    for (const auto& [id, light] : scene_.lights) {
      if (!is_lit(light)) continue;
      json entry = written_light(id, light, &files_);
      entry["name"] = names[all.size()];
      for (const char* link : {"lightLink", "shadowLink"})
        if (const auto category = light.parameters.find(link); category != light.parameters.end())
          if (const std::string name = category->second.text_or(""); !name.empty()) entry[link] = linked(id, name);
      all.push_back(std::move(entry));
    }
    // A scene without light gets some from the reader: this one gives none.
    if (all.empty() && !gives_light()) all.push_back({{"name", "no_light"}, {"type", "domeLight"}, {"intensity", 0}});
    return all;
  }

  bool gives_light() const {
    return std::any_of(material_names_.begin(), material_names_.end(),
                       [&](const auto& held) { return description::gives_light(scene_.materials.at(held.first)); });
  }

  // The meshes in a category.
  json linked(const Path& light, const Token& category) const {
    const auto is_in = [&](const std::vector<Token>& all) {
      return std::find(all.begin(), all.end(), category) != all.end();
    };
    for (const auto& [id, instancer] : scene_.instancers)
      if (std::any_of(instancer.categories.begin(), instancer.categories.end(), is_in))
        throw NotWritten(light, "is linked to single instances of " + id.str() +
                                    ", which is not written; give them a mesh of their own");
    json names = json::array();
    for (const DrawnMesh& drawn : drawn_)
      if (is_in(drawn.mesh->categories)) names.push_back(pattern_of(drawn.placed.name));
    return names;
  }

  // Values that the reader would refuse. The entry of a prim names it.
  static void check(const std::string& description) {
    JsonDocument document;
    std::string fault, problem;
    if (!parse_json(description, "", &document, &problem)) throw std::runtime_error(problem);
    const DiagnosticSink sink = [&](const Diagnostic& d) {
      if (!fault.empty() || d.severity != Severity::error) return;
      const std::string pointer = d.where.substr(std::min(d.where.find('/'), d.where.size()));
      const json::json_pointer entry(pointer.substr(0, pointer.find('/', pointer.find('/', 1) + 1)));
      if (document.value.contains(entry) && document.value[entry].is_object())
        for (const char* key : {"match", "name"})
          if (document.value[entry].contains(key)) fault = " of " + document.value[entry][key].get<std::string>();
      fault = pointer + fault + ": " + d.text;
    };
    if (!check_description(document, sink))
      throw std::runtime_error("the scene has a value that descriptions must not have, " + fault);
  }

  const SceneParts& scene_;
  const RenderPassState& state_;
  WrittenFiles files_;
  std::vector<DrawnMesh> drawn_;
  size_t placed_ = 0;  // instances so far
  UvSets sets_;
  Names names_of_materials_;
  std::map<Path, std::string> material_names_;
  std::vector<std::pair<OwnLook, std::string>> default_names_;
};

}  // namespace

std::string WriteScene(const std::string& file, const SceneParts& scene, const RenderPassState& state,
                       const std::map<Token, Value>& settings) try {
  const FloatEnvironment environment;
  if (!file.ends_with(".json")) return file + " must end in .json";
  if (file == ".json" || file.ends_with("/.json")) return file + " needs a name before .json";
  if (file.find('\\') != std::string::npos)
    return file + " has a backslash, which URIs in glTF cannot hold; leave it out";
  if (!is_utf8(file)) return "the name of the file must be UTF-8";
  return SceneWriter(file, scene, state).write(settings);
} catch (const std::bad_alloc&) {
  return "out of memory";  // needs none itself
} catch (const std::exception& e) {
  return e.what();
}

std::string WriteScene(const std::string& file, const host::RetainedSceneDelegate& scene, const RenderPassState& given,
                       const std::map<Token, Value>& settings) try {
  RenderPassState state = given;
  const auto& all = scene.GetAllRenderSettings();
  if (const auto named = settings.find("renderSettingsPrimPath"); state.camera.empty() && !all.empty()) {
    const auto prim = named == settings.end() ? all.begin() : all.find(Path(named->second.text_or("")));
    if (prim != all.end()) state.camera = prim->second.camera;
  }
  return WriteScene(
      file, {scene.GetMeshes(), scene.GetInstancers(), scene.GetMaterials(), scene.GetLights(), scene.GetCameras()},
      state, settings);
} catch (const std::bad_alloc&) {
  return "out of memory";  // needs none itself
}

}  // namespace alabaster::hd::description
