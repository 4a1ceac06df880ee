#include <algorithm>
#include <set>

#include "delegate/description/apply_motion.h"
#include "delegate/description/description_reader.h"
#include "delegate/description/name_match.h"

namespace alabaster::hd::description {
namespace {

using nlohmann::json;

size_t point_count(const host::MeshDescription& mesh) {
  const auto primvar = mesh.primvars.find("points");
  const auto* points = primvar == mesh.primvars.end() ? nullptr : primvar->second.value.get<Array<Vec3f>>();
  return points ? points->size() : 0;
}

bool check_point(const Reader& reader, const std::string& pointer, const json& index, const Path& mesh, size_t count) {
  if (index.get<uint64_t>() < count) return true;
  return reader.fail(pointer, "Point " + index.dump() + " does not exist: mesh '" + mesh.str() + "' has " +
                                  std::to_string(count) + " points, counted from 0.");
}

bool set_creases(const Reader& reader, const std::string& pointer, const json& creases, const Path& path,
                 host::MeshDescription* mesh) {
  std::vector<int32_t> indices, lengths;
  std::vector<float> weights;
  for (size_t i = 0; i < creases.size(); ++i) {
    const json& points = creases[i]["points"];
    const std::string inner = pointer + "/" + std::to_string(i) + "/points";
    for (size_t j = 0; j < points.size(); ++j) {
      if (!check_point(reader, inner + "/" + std::to_string(j), points[j], path, point_count(*mesh))) return false;
      indices.push_back(points[j].get<int32_t>());
    }
    lengths.push_back(static_cast<int32_t>(points.size()));
    weights.push_back(creases[i].value("sharpness", 10.0f));
  }
  mesh->subdivTags.creaseIndices = std::move(indices);
  mesh->subdivTags.creaseLengths = std::move(lengths);
  mesh->subdivTags.creaseWeights = std::move(weights);
  return true;
}

bool set_corners(const Reader& reader, const std::string& pointer, const json& corners, const Path& path,
                 host::MeshDescription* mesh) {
  std::vector<int32_t> indices;
  std::vector<float> weights;
  for (size_t i = 0; i < corners.size(); ++i) {
    const json& point = corners[i]["point"];
    if (!check_point(reader, pointer + "/" + std::to_string(i) + "/point", point, path, point_count(*mesh)))
      return false;
    indices.push_back(point.get<int32_t>());
    weights.push_back(corners[i].value("sharpness", 10.0f));
  }
  mesh->subdivTags.cornerIndices = std::move(indices);
  mesh->subdivTags.cornerWeights = std::move(weights);
  return true;
}

bool set_scheme(const Reader& reader, const std::string& pointer, const std::string& scheme, const Path& path,
                host::MeshDescription* mesh) {
  const Array<int32_t>& counts = mesh->topology.faceVertexCounts;
  if (scheme == "loop" && std::any_of(counts.begin(), counts.end(), [](int32_t n) { return n != 3; }))
    return reader.fail(pointer, "Loop subdivision takes only triangles, but mesh '" + path.str() +
                                    "' has other faces; use catmullClark.");
  mesh->topology.scheme = scheme;
  return true;
}

// Empty after an error. A pose finds the same material as the load did.
Path find_material(const Reader& reader, const std::string& pointer, const std::string& pattern) {
  Path& known = reader.state().mesh_materials[pattern];
  if (reader.state().posing) return known;
  const auto found = find_prims(reader, PrimKind::material, pattern, pointer);
  if (found.empty()) return {};
  if (found.size() > 1) {
    reader.fail(pointer, "Several materials match: '" + found[0].str() + "', '" + found[1].str() +
                             "'. Give the full path of one.");
    return {};
  }
  return known = found[0];
}

// Hides faces, or shows them again.
void show_faces(const Array<int32_t>& faces, bool visible, MeshTopology* topology) {
  std::set<int32_t> hidden(topology->invisibleFaces.begin(), topology->invisibleFaces.end());
  for (const int32_t face : faces) {
    if (visible)
      hidden.erase(face);
    else
      hidden.insert(face);
  }
  topology->invisibleFaces = std::vector<int32_t>(hidden.begin(), hidden.end());
}

// Faces have materials and may be hidden; all else belongs to the mesh.
void warn_of_parts(const Reader& reader, const std::string& pointer, const json& entry, const Path& path) {
  for (const auto& [key, value] : entry.items())
    if (key != "match" && key != "material" && key != "visible")
      reader.warn(pointer_append(pointer, key), "Applies to all of mesh '" + path.str() +
                                                    "', of which the match names a part: only material and visible "
                                                    "belong to parts.");
}

// A mesh's subsets with paths beside its own are the primitives of a glTF mesh, which a change of the mesh means, too.
void set_material(const std::string& pattern, const Path& path, const Path& material, host::MeshDescription* mesh) {
  std::vector<GeomSubset>& subsets = mesh->topology.geomSubsets;
  if (!matches(pattern, path, true)) {
    for (const size_t part : matching_subsets(pattern, mesh->topology)) subsets[part].materialId = material;
    return;
  }
  mesh->material = material;
  const std::string folder = path.str().substr(0, path.str().rfind('/') + 1);
  for (GeomSubset& subset : subsets)
    if (subset.id.str().starts_with(folder) && subset.id.str().find('/', folder.size()) == std::string::npos)
      subset.materialId = material;
}

bool change_mesh(const Reader& reader, const std::string& pointer, const json& entry, const Path& path) {
  host::MeshDescription mesh = reader.scene().GetMeshes().at(path);
  const std::string pattern = entry["match"];
  const bool whole = matches(pattern, path, true);
  if (!whole) warn_of_parts(reader, pointer, entry, path);
  if (entry.contains("scheme") && !set_scheme(reader, pointer + "/scheme", entry["scheme"], path, &mesh)) return false;
  mesh.displayStyle.refineLevel = entry.value("refineLevel", mesh.displayStyle.refineLevel);
  if (entry.contains("creases") && !set_creases(reader, pointer + "/creases", entry["creases"], path, &mesh))
    return false;
  if (entry.contains("corners") && !set_corners(reader, pointer + "/corners", entry["corners"], path, &mesh))
    return false;
  if (entry.contains("interpolateBoundary"))
    mesh.subdivTags.interpolateBoundary = entry["interpolateBoundary"].get<std::string>();
  if (entry.contains("faceVaryingLinearInterpolation"))
    mesh.subdivTags.faceVaryingLinearInterpolation = entry["faceVaryingLinearInterpolation"].get<std::string>();
  if (entry.contains("material")) {
    const Path material = find_material(reader, pointer + "/material", entry["material"]);
    if (material.empty()) return false;
    set_material(pattern, path, material, &mesh);
  }
  if (entry.contains("subsurfaceSet"))
    mesh.primvars["subsurfaceSet"] = {
        Interpolation::constant, Token(), Token(entry["subsurfaceSet"].get<std::string>()), {}};
  for (const char* flag : {"holdout", "visibleToCamera"})
    if (entry.contains(flag)) mesh.primvars[flag] = {Interpolation::constant, Token(), entry[flag].get<bool>(), {}};
  if (whole)
    mesh.visible = entry.value("visible", mesh.visible);
  else if (entry.contains("visible"))
    for (const size_t part : matching_subsets(pattern, mesh.topology))
      show_faces(mesh.topology.geomSubsets[part].indices, entry["visible"], &mesh.topology);
  if (entry.value("refineLevel", 0) > 0 && mesh.topology.scheme == Token("none"))
    reader.warn(pointer + "/refineLevel", "Has no effect on mesh '" + path.str() +
                                              "', which is not a subdivision surface; set its scheme as well.");
  reader.scene().SetMesh(path, std::move(mesh));
  return true;
}

bool move_meshes(const Reader& reader, const std::string& pointer, const json& motion, const std::vector<Path>& paths) {
  const auto samples = to_motion(reader, pointer, motion);
  if (!samples) return false;
  for (const Path& path : paths)
    if (!reader.scene().GetMeshes().at(path).instancer.empty())
      return reader.fail(pointer, "Mesh '" + path.str() +
                                      "' is drawn several times, and moves only with all of its model: give the motion "
                                      "to the model.");
  move_prims(paths, *samples, &reader.scene());
  return true;
}

}  // namespace

bool apply_meshes(const Reader& reader) {
  const auto entries = reader.value().find("meshes");
  if (entries == reader.value().end()) return true;
  for (size_t i = 0; i < entries->size(); ++i) {
    const std::string pointer = "/meshes/" + std::to_string(i);
    const auto paths = find_prims(reader, PrimKind::mesh, (*entries)[i]["match"], pointer + "/match");
    if (paths.empty() && !reader.state().posing) return false;
    for (const Path& path : paths)
      if (!change_mesh(reader, pointer, (*entries)[i], path)) return false;
    const auto motion = (*entries)[i].find("motion");
    if (motion != (*entries)[i].end() && !move_meshes(reader, pointer + "/motion", *motion, paths)) return false;
  }
  return true;
}

}  // namespace alabaster::hd::description
