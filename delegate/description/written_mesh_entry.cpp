#include <algorithm>

#include "delegate/description/written_parts.h"
#include "delegate/support/float_values.h"

namespace alabaster::hd::description {
namespace {

using nlohmann::json;

int32_t point_of(const Path& id, const host::MeshDescription& mesh, int32_t index) {
  const auto points = mesh.primvars.find("points");
  const auto* held = points == mesh.primvars.end() ? nullptr : points->second.value.get<Array<Vec3f>>();
  if (held && (index < 0 || static_cast<size_t>(index) >= held->size()))
    throw NotWritten(id, "has creases or corners at points that it lacks, which is not written; mend its subdivTags");
  return index;
}

json creases_of(const Path& id, const host::MeshDescription& mesh) {
  const SubdivTags& tags = mesh.subdivTags;
  json creases = json::array();
  size_t first = 0;
  for (size_t i = 0; i < tags.creaseLengths.size(); ++i) {
    const auto length = static_cast<size_t>(std::max(tags.creaseLengths[i], 0));
    if (first + length > tags.creaseIndices.size()) throw NotWritten(id, "has too few points of its creases");
    json points = json::array();
    for (size_t k = 0; k < length; ++k) points.push_back(point_of(id, mesh, tags.creaseIndices[first + k]));
    creases.push_back({{"points", std::move(points)}, {"sharpness", tags.creaseWeights[i]}});
    first += length;
  }
  if (first != tags.creaseIndices.size())
    throw NotWritten(id,
                     "has more points of creases than their lengths say, which is not written; mend its subdivTags");
  return creases;
}

json corners_of(const Path& id, const host::MeshDescription& mesh) {
  const SubdivTags& tags = mesh.subdivTags;
  json corners = json::array();
  for (size_t i = 0; i < std::min(tags.cornerIndices.size(), tags.cornerWeights.size()); ++i)
    corners.push_back({{"point", point_of(id, mesh, tags.cornerIndices[i])}, {"sharpness", tags.cornerWeights[i]}});
  return corners;
}

void set_cage(const Path& id, const host::MeshDescription& mesh, json* made) {
  (*made)["scheme"] = mesh.topology.scheme.str();
  (*made)["refineLevel"] = mesh.displayStyle.refineLevel;
  const SubdivTags& tags = mesh.subdivTags;
  if (!tags.creaseLengths.empty()) (*made)["creases"] = creases_of(id, mesh);
  if (!tags.cornerIndices.empty()) (*made)["corners"] = corners_of(id, mesh);
  if (!tags.interpolateBoundary.empty()) (*made)["interpolateBoundary"] = tags.interpolateBoundary.str();
  if (!tags.faceVaryingLinearInterpolation.empty())
    (*made)["faceVaryingLinearInterpolation"] = tags.faceVaryingLinearInterpolation.str();
}

// Empty if the mesh has no such primvar.
Value constant(const Path& id, const host::MeshDescription& mesh, const char* name) {
  const auto found = mesh.primvars.find(name);
  if (found == mesh.primvars.end()) return {};
  if (found->second.interpolation != Interpolation::constant)
    throw NotWritten(id, std::string("has a primvar ") + name + " that is not constant, which is not written");
  return support::FloatValues(found->second.value);
}

}  // namespace

json written_mesh(const Path& id, const host::MeshDescription& mesh) {
  json made = json::object();
  if (is_cage(mesh)) set_cage(id, mesh, &made);
  if (json motion = written_motion(id, mesh.transform, mesh.transformSamples); !motion.empty()) {
    if (!mesh.instancer.empty()) throw NotWritten(id, "moves within its instances, which is not written");
    made["motion"] = std::move(motion);
  }
  if (const Value set = constant(id, mesh, "subsurfaceSet"); !set.empty()) {
    if (set.text_or("").empty()) throw NotWritten(id, "has a subsurfaceSet that is no name, which is not written");
    made["subsurfaceSet"] = set.text_or("");
  }
  for (const char* name : {"holdout", "visibleToCamera"})
    if (const Value flag = constant(id, mesh, name); !flag.empty()) {
      const auto* numbers = flag.get<Array<float>>();
      if (!numbers || numbers->size() != 1)
        throw NotWritten(id, std::string("has a primvar ") + name + " that is no bool, which is not written");
      made[name] = (*numbers)[0] != 0;
    }
  return made;
}

}  // namespace alabaster::hd::description
