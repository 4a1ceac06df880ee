#include "delegate/prims/deformation.h"

#include <algorithm>

namespace alabaster::hd::prims {
namespace {

// Each pose costs memory as the mesh does.
constexpr size_t kMostMeshPoses = 33;

std::vector<Vec3f> mixed(const std::vector<Vec3f>& a, const std::vector<Vec3f>& b, float f) {
  std::vector<Vec3f> out(a.size());
  for (size_t i = 0; i < out.size(); ++i) out[i] = a[i] * (1 - f) + b[i] * f;
  return out;
}

MeshPose pose_at(const Deformation& deformation, double time) {
  const auto& times = deformation.times;
  const auto after = static_cast<size_t>(std::upper_bound(times.begin(), times.end(), time) - times.begin());
  if (after == 0) return deformation.poses.front();
  const MeshPose& a = deformation.poses[after - 1];
  if (after == times.size() || time == times[after - 1]) return a;
  const MeshPose& b = deformation.poses[after];
  const auto f = static_cast<float>((time - times[after - 1]) / (times[after] - times[after - 1]));
  return {mixed(a.points, b.points, f), mixed(a.normals, b.normals, f)};
}

// Without its BVH.
std::shared_ptr<MeshPrototype> deformed(const Mesh& mesh, const Deformation& deformation, const Shutter& shutter,
                                        const std::shared_ptr<MemoryBudget>& budget) {
  auto prototype = std::make_shared<MeshPrototype>();
  const size_t count = even_pose_count(deformation.times, shutter, kMostMeshPoses);
  prototype->memory =
      MemoryReservation(budget, MemoryUse::meshes,
                        mesh.memory_bytes() + (count - 1) * (mesh.points.size() + mesh.normals.size()) * sizeof(Vec3f),
                        "a mesh in " + std::to_string(count) + " poses");
  prototype->interior.count_in(budget);
  prototype->tangents.count_in(budget);
  Mesh& out = prototype->mesh = mesh;
  for (size_t i = 0; i < count; ++i) {
    const double share = count > 1 ? static_cast<double>(i) / static_cast<double>(count - 1) : 0;
    MeshPose pose = pose_at(deformation, shutter.time(share));
    for (const auto& triangle : out.triangles)
      for (const uint32_t corner : triangle) out.bounds.extend(pose.points[corner]);
    if (i > 0)
      out.later_poses.push_back(std::move(pose));
    else
      out.points = std::move(pose.points), out.normals = std::move(pose.normals);
  }
  return prototype;
}

}  // namespace

void Deformations::build(const Path& path, const MeshPrototype& still, Built* built, SceneParam* param,
                         const CancelToken& cancel) {
  std::string refusal = "not enough memory to trace it";
  param->run([&] {
    try {
      auto prototype = deformed(still.mesh, *built->from, built->shutter, param->memory());
      prototype->object =
          build_object_scene(param->device(), prototype->mesh, [cancel] { return cancel.is_cancelled(); });
      if (prototype->object) built->prototype = std::move(prototype);
    } catch (const MemoryRefused& e) {
      refusal = e.what();
    } catch (const std::bad_alloc&) {
      // The text says so.
    }
  });
  cancel.check();
  const bool is_reported = built->fault.has_value();
  built->fault = std::nullopt;
  if (built->prototype) return;
  built->fault = SceneFault{false, refusal + "; the mesh is drawn without deformation"};
  if (!is_reported)
    alabaster::report(param->sink(), alabaster::Severity::error, "mesh.memory", path.str(), built->fault->text);
}

bool Deformations::incomplete() const {
  return std::any_of(built_.begin(), built_.end(), [](const auto& entry) { return entry.second.fault.has_value(); });
}

void Deformations::add_faults(const Records& records, const support::Selection& selection, SceneFaults* faults) const {
  for (const auto& [path, built] : built_) {
    const auto* mesh = find_record<MeshRecord>(records, path);
    if (built.fault && mesh && selection.includes(path, mesh->visible, mesh->render_tag))
      faults->emplace(path, *built.fault);
  }
}

DeformedMeshes Deformations::in(const Shutter& shutter, const BuiltMeshes& meshes, SceneParam* param,
                                const CancelToken& cancel) {
  DeformedMeshes drawn;
  std::set<Path> deforming;
  std::map<const Deformation*, std::shared_ptr<const MeshPrototype>> shared;  // by meshes of equal geometry
  meshes.for_each([&](const Path& path, const BuiltMesh& mesh) {
    if (!mesh.deformation || !mesh.prototype) return;
    deforming.insert(path);
    Built& built = built_[path];
    if (built.from != mesh.deformation || !(built.shutter == shutter) || !built.prototype) {
      cancel.check();
      built.from = mesh.deformation, built.shutter = shutter, built.prototype = shared[mesh.deformation.get()];
      if (built.prototype)
        built.fault = std::nullopt;
      else
        build(path, *mesh.prototype, &built, param, cancel);
    }
    shared[mesh.deformation.get()] = built.prototype;
    if (built.prototype) drawn[path] = built.prototype;
  });
  std::erase_if(built_, [&](const auto& entry) { return !deforming.contains(entry.first); });
  return drawn;
}

}  // namespace alabaster::hd::prims
