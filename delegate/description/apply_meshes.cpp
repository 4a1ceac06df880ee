#include <algorithm>
#include <set>

#include "delegate/description/apply_motion.h"
#include "delegate/description/description_reader.h"
#include "delegate/description/name_match.h"
#include "delegate/support/json_values.h"

namespace alabaster::hd::description {
namespace {

using nlohmann::json;

size_t point_count(const host::MeshDescription& mesh) {
  const auto primvar = mesh.primvars.find("points");
  const auto* points = primvar == mesh.primvars.end() ? nullptr : primvar->second.value.get<Array<Vec3f>>();
  return points ? points->size() : 0;
}

/// The index of a point of the mesh.
int32_t point_of(LoadState& load, const std::string& pointer, const json& index, const Path& path) {
  const size_t count = point_count(load.scene->GetMeshes().at(path));
  if (index.get<uint64_t>() >= count)
    load.fail(pointer, "Point " + index.dump() + " does not exist: mesh '" + path.str() + "' has " +
                           std::to_string(count) + " points, counted from 0.");
  return index.get<int32_t>();
}

/// The fields of creases or corners, which replace the mesh's own.
void sharpen(LoadState& load, const std::string& pointer, const json& list, const Path& path, host::Fields* fields) {
  const bool creases = pointer.ends_with("/creases");
  std::vector<int32_t> indices, lengths;
  std::vector<float> weights;
  for (size_t i = 0; i < list.size(); ++i) {
    const std::string entry = pointer + "/" + std::to_string(i);
    if (!creases) indices.push_back(point_of(load, entry + "/point", list[i]["point"], path));
    const json points = list[i].value("points", json::array());
    for (size_t j = 0; j < points.size(); ++j)
      indices.push_back(point_of(load, entry + "/points/" + std::to_string(j), points[j], path));
    lengths.push_back(static_cast<int32_t>(points.size()));
    weights.push_back(list[i].value("sharpness", 10.0f));
  }
  fields->emplace_back(creases ? "creaseIndices" : "cornerIndices", std::move(indices));
  fields->emplace_back(creases ? "creaseWeights" : "cornerWeights", std::move(weights));
  if (creases) fields->emplace_back("creaseLengths", std::move(lengths));
}

void check_scheme(LoadState& load, const std::string& pointer, const std::string& scheme, const Path& path) {
  const Array<int32_t>& counts = load.scene->GetMeshes().at(path).topology.faceVertexCounts;
  if (scheme == "loop" && std::any_of(counts.begin(), counts.end(), [](int32_t n) { return n != 3; }))
    load.fail(pointer, "Loop subdivision takes only triangles, but mesh '" + path.str() +
                           "' has other faces; use catmullClark.");
}

// A pose finds the same material as the load did.
Path find_material(LoadState& load, const std::string& pointer, const std::string& pattern) {
  Path& known = load.mesh_materials[pattern];
  if (load.posing) return known;
  const auto found = find_prims(load, PrimKind::material, pattern, pointer);
  if (found.size() > 1)
    load.fail(pointer, "Several materials match: '" + found[0].str() + "', '" + found[1].str() +
                           "'. Give the full path of one.");
  return known = found[0];
}

// Hides faces, or shows them again.
Array<int32_t> with_faces(const Array<int32_t>& invisible, const Array<int32_t>& faces, bool visible) {
  std::set<int32_t> hidden(invisible.begin(), invisible.end());
  for (const int32_t face : faces) {
    if (visible)
      hidden.erase(face);
    else
      hidden.insert(face);
  }
  return std::vector<int32_t>(hidden.begin(), hidden.end());
}

// Faces have materials and may be hidden; all else belongs to the mesh.
void warn_of_parts(const LoadState& load, const std::string& pointer, const json& entry, const Path& path) {
  for (const auto& [key, value] : entry.items())
    if (key != "match" && key != "material" && key != "visible")
      load.warn(pointer_append(pointer, key), "Applies to all of mesh '" + path.str() +
                                                  "', of which the match names a part: only material and visible "
                                                  "belong to parts.");
}

/// A mesh, or the parts of it, that an entry changes.
struct Target {
  const Path& path;
  const MeshTopology& topology;
  std::vector<size_t> parts;  // subsets; empty: the whole mesh
};

// A mesh's subsets with paths beside its own are the primitives of a glTF mesh, which a change of the mesh means, too.
void set_material(const Target& target, const Path& material, host::Fields* fields) {
  const std::string folder = target.path.str().substr(0, target.path.str().rfind('/') + 1);
  const auto& subsets = target.topology.geomSubsets;
  if (target.parts.empty()) fields->emplace_back("material", material);
  for (size_t i = 0; i < subsets.size(); ++i) {
    const std::string& id = subsets[i].id.str();
    const bool beside = id.starts_with(folder) && id.find('/', folder.size()) == std::string::npos;
    const bool named = std::find(target.parts.begin(), target.parts.end(), i) != target.parts.end();
    if (target.parts.empty() ? beside : named) fields->emplace_back("subsets:" + id + ":material", material);
  }
}

void set_visible(const Target& target, bool visible, host::Fields* fields) {
  if (target.parts.empty()) {
    fields->emplace_back("visible", visible);
    return;
  }
  Array<int32_t> invisible = target.topology.invisibleFaces;
  for (const size_t part : target.parts)
    invisible = with_faces(invisible, target.topology.geomSubsets[part].indices, visible);
  fields->emplace_back("invisibleFaces", invisible);
}

constexpr const char* kPrimvars[] = {"subsurfaceSet", "holdout", "visibleToCamera"};  // of each mesh one value

/// Adds the fields that a key of the entry sets.
void add_fields(LoadState& load, const std::string& pointer, const std::string& name, const json& value,
                const Target& target, host::Fields* fields) {
  if (name == "match" || name == "motion") return;
  if (name == "creases" || name == "corners") return sharpen(load, pointer, value, target.path, fields);
  if (name == "material") return set_material(target, find_material(load, pointer, value), fields);
  if (name == "visible") return set_visible(target, value, fields);
  if (name == "scheme") check_scheme(load, pointer, value, target.path);
  if (std::find(std::begin(kPrimvars), std::end(kPrimvars), name) == std::end(kPrimvars)) {
    fields->emplace_back(name, support::value_of(value));
  } else {
    const Value set = support::value_of(value);
    fields->emplace_back("primvars:" + name, value.is_string() ? Token(set.text_or("")) : set);
    fields->emplace_back("primvars:" + name + ":interpolation", "constant");
  }
}

void change_mesh(LoadState& load, const std::string& pointer, const json& entry, const Path& path) {
  const std::string pattern = entry["match"];
  Target target{path, load.scene->GetMeshes().at(path).topology, {}};
  if (!matches(pattern, path, true)) target.parts = matching_subsets(pattern, target.topology);
  if (!target.parts.empty()) warn_of_parts(load, pointer, entry, path);
  host::Fields fields;
  for (const auto& [name, value] : entry.items())
    add_fields(load, pointer_append(pointer, name), name, value, target, &fields);
  load.edit(pointer, path, fields);
  if (entry.value("refineLevel", 0) > 0 && load.scene->GetMeshes().at(path).topology.scheme == Token("none"))
    load.warn(pointer + "/refineLevel", "Has no effect on mesh '" + path.str() +
                                            "', which is not a subdivision surface; set its scheme as well.");
}

void move_meshes(LoadState& load, const std::string& pointer, const json& motion, const std::vector<Path>& paths) {
  const TimeSamples<Matrix4d> samples = to_motion(load, pointer, motion);
  for (const Path& path : paths)
    if (!load.scene->GetMeshes().at(path).instancer.empty())
      load.fail(pointer, "Mesh '" + path.str() +
                             "' is drawn several times, and moves only with all of its model: give the motion to the "
                             "model.");
  move_prims(paths, samples, load.scene);
}

}  // namespace

void apply_meshes(LoadState& load) {
  load.for_each_entry("meshes", [&](const std::string& pointer, const json& entry) {
    const auto paths = find_prims(load, PrimKind::mesh, entry["match"], pointer + "/match");
    for (const Path& path : paths) change_mesh(load, pointer, entry, path);
    if (entry.contains("motion")) move_meshes(load, pointer + "/motion", entry["motion"], paths);
  });
}

}  // namespace alabaster::hd::description
