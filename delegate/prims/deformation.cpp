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

DeformedMeshes Deformations::in(const Shutter& shutter, const BuiltMeshes& meshes, SceneParam* param,
                                const CancelToken& cancel) {
  DeformedMeshes drawn;
  std::map<Path, Built> kept;
  meshes.for_each([&](const Path& path, const MeshBuild& mesh) {
    if (!mesh.deformation || !mesh.prototype) return;
    Built& built = kept[path];
    if (const auto held = built_.find(path); held != built_.end()) built = held->second;
    if (built.from != mesh.deformation || !(built.shutter == shutter) || !built.prototype) {
      cancel.check();
      built = {mesh.deformation, shutter, nullptr};
      param->run([&] {
        auto prototype = deformed(mesh.prototype->mesh, *mesh.deformation, shutter, param->memory());
        prototype->object =
            build_object_scene(param->device(), prototype->mesh, [cancel] { return cancel.is_cancelled(); });
        if (prototype->object) built.prototype = std::move(prototype);
      });
      cancel.check();
    }
    if (built.prototype) drawn[path] = built.prototype;
  });
  built_ = std::move(kept);
  return drawn;
}

}  // namespace alabaster::hd::prims
