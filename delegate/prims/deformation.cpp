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

std::shared_ptr<MeshPrototype> deformed(const Mesh& mesh, const Deformation& deformation, const Shutter& shutter,
                                        SceneParam* param, const CancelToken& cancel) {
  const std::shared_ptr<MemoryBudget>& budget = param->memory();
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
  prototype->object = build_object_scene(param->device(), out, [cancel] { return cancel.is_cancelled(); });
  cancel.check();
  if (!prototype->object) throw MemoryRefused("Embree built no hierarchy of its poses; lower its refineLevel");
  return prototype;
}

std::shared_ptr<const MeshEnds> points_at_ends(const Deformation& deformation, const Shutter& time, SceneParam* param) {
  MeshEnds ends;
  ends.memory = MemoryReservation(param->memory(), MemoryUse::meshes,
                                  2 * deformation.poses.front().points.size() * sizeof(Vec3f), "a mesh in AOV motion");
  ends.points = {pose_at(deformation, time.open).points, pose_at(deformation, time.close).points};
  return std::make_shared<const MeshEnds>(std::move(ends));
}

}  // namespace

DeformedMeshes Deformations::in(const Shutter& shutter, const MotionTime& motion, const BuiltMeshes& meshes,
                                SceneParam* param, const CancelToken& cancel) {
  DeformedMeshes drawn;
  std::set<Path> deforming;
  // By meshes of equal geometry.
  std::map<const Deformation*, std::shared_ptr<const MeshPrototype>> shared;
  std::map<const Deformation*, std::shared_ptr<const MeshEnds>> shared_ends;
  meshes.for_each([&](const Path& path, const BuiltMesh& mesh) {
    if (!mesh.deformation || !mesh.prototype) return;
    deforming.insert(path);
    Built& built = built_[path];
    if (built.from != mesh.deformation || built.motion != motion) built.ends = nullptr;
    if (built.from != mesh.deformation || !(built.shutter == shutter) || !built.prototype) {
      cancel.check();
      built.from = mesh.deformation, built.shutter = shutter, built.prototype = shared[mesh.deformation.get()];
      const auto deform = [&] {
        built.prototype = deformed(mesh.prototype->mesh, *built.from, shutter, param, cancel);
      };
      if (!built.prototype) param->run([&] { in_name_of(path.str(), deform); });
    }
    shared[mesh.deformation.get()] = built.prototype;
    drawn.traced[path] = built.prototype;
    if (!motion) return;
    auto& ends = shared_ends[mesh.deformation.get()];
    if (!built.ends && !ends) in_name_of(path.str(), [&] { ends = points_at_ends(*mesh.deformation, *motion, param); });
    if (!built.ends) built.ends = ends, built.motion = motion;
    drawn.ends[path] = ends = built.ends;
  });
  std::erase_if(built_, [&](const auto& entry) { return !deforming.contains(entry.first); });
  return drawn;
}

}  // namespace alabaster::hd::prims
