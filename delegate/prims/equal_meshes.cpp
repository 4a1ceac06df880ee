#include "delegate/prims/equal_meshes.h"

#include <algorithm>
#include <array>
#include <map>
#include <numeric>
#include <string>

#include "core/digest/digest.h"

namespace alabaster::hd::prims {
namespace {

template <class T>
void add_array(const Array<T>& array, Digest* digest) {
  digest->add_array(array.data(), array.size());
}

// Other types are reported, and no mesh with a report shares its shape.
void add_value(const Value& value, Digest* digest) {
  const auto add = [&](const auto* array) {
    if (array) add_array(*array, digest);
    return array != nullptr;
  };
  const bool known = add(value.get<Array<float>>()) || add(value.get<Array<Vec2f>>()) ||
                     add(value.get<Array<Vec3f>>()) || add(value.get<Array<Vec4f>>());
  digest->add(known);
}

void add_primvar(const PulledPrimvar& primvar, Digest* digest) {
  digest->add(primvar.present);
  digest->add(primvar.interpolation);
  add_value(primvar.value, digest);
  add_array(primvar.indices, digest);
}

void add_samples(const TimeSamples<Value>& samples, Digest* digest) {
  digest->add(samples.times);
  for (const Value& value : samples.values) add_value(value, digest);
}

// Tells equal values of different bits apart, such as both zeros.
std::string digest_of(const PulledMesh& mesh) {
  Digest digest;
  const MeshTopology& topology = mesh.topology;
  for (const auto* array :
       {&topology.faceVertexCounts, &topology.faceVertexIndices, &topology.holeIndices, &topology.invisibleFaces,
        &mesh.tags.creaseIndices, &mesh.tags.creaseLengths, &mesh.tags.cornerIndices, &mesh.curves.curveVertexCounts})
    add_array(*array, &digest);
  for (const auto* array : {&mesh.tags.creaseWeights, &mesh.tags.cornerWeights}) add_array(*array, &digest);
  for (const auto& [name, primvar] : kPulledPrimvars) add_primvar(mesh.*primvar, &digest);
  for (const auto& [name, uvs] : mesh.uvs) add_primvar(uvs, &digest);
  add_samples(mesh.point_samples, &digest);
  add_samples(mesh.normal_samples, &digest);
  return digest.text();
}

bool have_equal_values(const PulledMesh& a, const PulledMesh& b) {
  const auto are_equal = [&](const PulledPrimvarName& named) { return a.*named.primvar == b.*named.primvar; };
  return &a == &b ||
         (a.topology == b.topology && a.curves == b.curves && a.tags == b.tags && a.style == b.style &&
          a.uvs == b.uvs && std::all_of(std::begin(kPulledPrimvars), std::end(kPulledPrimvars), are_equal) &&
          a.point_samples == b.point_samples && a.normal_samples == b.normal_samples);
}

// Displacement is a material's, and is made with the slots.
bool are_built_alike(const MeshJob& a, const MeshJob& b) {
  return a.request == b.request && (a.request.displacements.empty() || *a.slots == *b.slots) &&
         have_equal_values(*a.source, *b.source);
}

using Counts = std::array<size_t, 3>;
Counts counts_of(const MeshJob& job) {
  const PulledMesh& mesh = *job.source;
  return {mesh.topology.faceVertexCounts.size(), mesh.topology.faceVertexIndices.size(), mesh.points.value.count()};
}

}  // namespace

std::vector<size_t> find_equal_meshes(const MeshJobs& built, const MeshJobs& to_build, const CancelToken& cancel) {
  std::map<Counts, std::vector<size_t>> by_counts;  // numbers of those of `built`, and then of `to_build`
  for (size_t i = 0; i < to_build.size(); ++i)
    if (!to_build[i]->edits && !to_build[i]->shape) by_counts[counts_of(*to_build[i])];
  const auto job = [&](size_t i) -> const MeshJob& {
    return *(i < built.size() ? built[i] : to_build[i - built.size()]);
  };
  for (size_t i = 0; i < built.size() + to_build.size(); ++i)
    if (const auto alike = by_counts.find(counts_of(job(i))); alike != by_counts.end() && !job(i).edits)
      alike->second.push_back(i);
  std::vector<size_t> first(to_build.size());
  std::iota(first.begin(), first.end(), built.size());
  for (const auto& [counts, numbers] : by_counts) {
    std::multimap<std::string, size_t> digests;
    for (const size_t i : numbers) {
      if (numbers.size() == 1) break;
      cancel.check();
      const std::string digest = digest_of(*job(i).source);
      const auto [begin, end] = digests.equal_range(digest);
      const auto found =
          std::find_if(begin, end, [&](const auto& other) { return are_built_alike(job(other.second), job(i)); });
      if (found == end)
        digests.emplace(digest, i);
      else if (i >= built.size())
        first[i - built.size()] = found->second;
    }
  }
  return first;
}

}  // namespace alabaster::hd::prims
