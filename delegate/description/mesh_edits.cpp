#include <algorithm>

#include "delegate/description/load_state.h"
#include "delegate/description/places.h"
#include "delegate/gltf/gltf_scene.h"
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
  const auto found = find_prims(load, "material", pattern, pointer);
  if (found.size() > 1)
    load.fail(pointer, "Several materials match: '" + found[0].str() + "', '" + found[1].str() +
                           "'. Give the full path of one.");
  return known = found[0];
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
  const host::MeshDescription& mesh;
  const std::vector<size_t> parts;  // subsets; empty: the whole mesh

  /// Subsets with paths beside the mesh's own are the primitives of a glTF mesh.
  bool is_primitive(const GeomSubset& subset) const {
    const std::string folder = path.str().substr(0, path.str().rfind('/') + 1);
    const std::string& id = subset.id.str();
    return id.starts_with(folder) && id.find('/', folder.size()) == std::string::npos;
  }
  /// The subsets that the entry means: the parts, or all primitives.
  std::vector<const GeomSubset*> subsets() const {
    std::vector<const GeomSubset*> meant;
    for (const size_t part : parts) meant.push_back(&mesh.topology.geomSubsets[part]);
    for (const GeomSubset& subset : mesh.topology.geomSubsets)
      if (parts.empty() && is_primitive(subset)) meant.push_back(&subset);
    return meant;
  }
};

void set_material(const Target& target, const Path& material, host::Fields* fields) {
  if (target.parts.empty()) fields->emplace_back("material", material);
  for (const GeomSubset* subset : target.subsets())
    fields->emplace_back("subsets:" + subset->id.str() + ":material", material);
}

// Where a part of a hidden mesh is shown, the mesh is shown, and its other primitives are hidden.
void set_visible(const Target& target, bool visible, host::Fields* fields) {
  const MeshTopology& topology = target.mesh.topology;
  const bool whole = target.parts.empty(), shows_part = !whole && visible && !target.mesh.visible;
  if (whole || shows_part) fields->emplace_back("visible", visible);
  const std::vector<const GeomSubset*> meant = target.subsets();
  if (meant.empty() || (whole && !visible)) return;
  std::vector<char> hidden(topology.faceVertexCounts.size(), 0);
  const auto set = [&](const Array<int32_t>& faces, bool hide) {
    for (const int32_t face : faces)
      if (face >= 0 && size_t(face) < hidden.size()) hidden[size_t(face)] = hide;
  };
  set(topology.invisibleFaces, true);
  for (const GeomSubset& subset : topology.geomSubsets)
    if (shows_part && target.is_primitive(subset)) set(subset.indices, true);
  for (const GeomSubset* subset : meant) set(subset->indices, !visible);
  std::vector<int32_t> faces;
  for (size_t face = 0; face < hidden.size(); ++face)
    if (hidden[face]) faces.push_back(int32_t(face));
  fields->emplace_back("invisibleFaces", std::move(faces));
}

/// Adds the fields that a key of the entry sets.
void add_fields(LoadState& load, const std::string& pointer, const std::string& name, const json& value,
                const Target& target, host::Fields* fields) {
  if (name == "match" || name == "motion") return;
  if (name == "creases" || name == "corners") return sharpen(load, pointer, value, target.path, fields);
  if (name == "material") return set_material(target, find_material(load, pointer, value), fields);
  if (name == "visible") return set_visible(target, value, fields);
  if (name == "scheme") check_scheme(load, pointer, value, target.path);
  fields->emplace_back(name, support::value_of(value));
}

// glTF splits vertices at seams of normals, texture coordinates and materials, which would cut the refined surface.
void weld_triangles(LoadState& load, const std::string& pointer, const Path& path) {
  host::MeshDescription mesh = load.scene->GetMeshes().at(path);
  if (!is_of_model(load, path.str()) || !(mesh.topology.scheme == Token("none"))) return;
  if (const size_t dropped = gltf::WeldVertices(&mesh); dropped > 0 && !load.posing)
    load.warn(pointer,
              std::to_string(dropped) + " triangles of mesh '" + path.str() + "' have no area and are left out.");
  load.scene->SetMesh(path, std::move(mesh));
}

// What moves by itself, and is not drawn by an instancer.
void move(LoadState& load, const std::string& pointer, const json& motion, const Path& path) {
  if (!load.scene->GetMeshes().at(path).instancer.empty())
    load.fail(pointer, "Mesh '" + path.str() +
                           "' is drawn several times, and moves only with all of its model: give the motion to the "
                           "model.");
  host::PrimDescription moved = load.scene->GetPrims().at(path);
  move_prim(to_motion(load, pointer, motion), &moved);
  load.scene->Set(path, std::move(moved));
}

}  // namespace

void read_mesh(LoadState& load, PrimEdit* edit) {
  const std::string& pointer = edit->pointer;
  const json& entry = edit->entry;
  const Path& path = edit->path;
  if (entry.value("scheme", "none") != "none") weld_triangles(load, pointer + "/scheme", path);
  if (entry.contains("motion")) move(load, pointer + "/motion", entry["motion"], path);
  const Target target{path, load.scene->GetMeshes().at(path), find_parts(load, entry["match"], path)};
  if (!target.parts.empty()) warn_of_parts(load, pointer, entry, path);
  for (const auto& [name, value] : entry.items())
    add_fields(load, pointer_append(pointer, name), name, value, target, &edit->fields);
  edit->may_wait = !target.parts.empty() && entry.size() == 2 && entry.contains("material");
  if (entry.value("refineLevel", 0) > 0 && entry.value("scheme", target.mesh.topology.scheme.str()) == "none")
    load.warn(pointer + "/refineLevel", "Has no effect on mesh '" + path.str() +
                                            "', which is not a subdivision surface; set its scheme as well.");
}

}  // namespace alabaster::hd::description
