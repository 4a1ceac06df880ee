#include "delegate/prims/mesh_build.h"

#include <algorithm>

#include "core/geometry/used_points.h"

#include "delegate/prims/motion.h"
#include "delegate/prims/tubes.h"

namespace alabaster::hd::prims {
namespace {

// How many edges of the length asked for a piece of the surface is long in the picture, where it appears largest, if it
// were seen face-on: so silhouettes are as fine as what faces the camera.
class EdgeMeasure {
 public:
  EdgeMeasure(const MeshRequest& request, const std::vector<Vec3f>& points) {
    const Dicing& d = request.dicing;
    const Matrix4d& view = d.camera.camera_to_world;
    eye_ = Vec3d(view[3][0], view[3][1], view[3][2]);
    const Camera camera(d.camera, d.width, d.height, eye_);
    const Vec2f middle(static_cast<float>(d.width) / 2, static_cast<float>(d.height) / 2);
    cone_ = camera.pixel_cone(camera.generate_ray(middle, {0.5f, 0.5f}).dir);
    cone_ = {cone_.width * d.edge_length, cone_.spread * d.edge_length};
    Bounds bounds;
    for (const Vec3f& p : points) bounds.extend(p);
    const auto distance = [&](const Matrix4d& m) {
      double nearest = kUnbounded;
      for (const Vec3f& corner : bounds.corners())
        nearest = std::min(nearest, length(transform_point(Vec3d(corner), m) - eye_));
      return nearest;
    };
    std::vector<std::pair<double, size_t>> order;
    for (size_t i = 0; i < request.placements.size(); ++i) order.emplace_back(distance(request.placements[i]), i);
    std::sort(order.begin(), order.end());
    constexpr size_t kMeasured = 8;  // the nearest instances of many
    order.resize(std::min(order.size(), kMeasured));
    for (const auto& [unused, i] : order) placements_.push_back(request.placements[i]);
  }

  float operator()(const Vec3f& a, const Vec3f& b) const {
    double most = 0;
    for (const Matrix4d& m : placements_) {
      const Vec3d p = transform_point(Vec3d(a), m), q = transform_point(Vec3d(b), m);
      const double l = length(q - p), distance = std::max(length((p + q) * 0.5 - eye_), l / 2);
      most = std::max(most, l / (double(cone_.width) + double(cone_.spread) * distance));
    }
    return static_cast<float>(most);
  }

 private:
  Vec3d eye_;
  PixelCone cone_;  // of an edge length
  std::vector<Matrix4d> placements_;
};

std::vector<Vec3f> read_points(const Value& value) {
  const auto* array = value.get<Array<Vec3f>>();
  return array ? std::vector<Vec3f>(array->begin(), array->end()) : std::vector<Vec3f>();
}

bool is_usable_point(const Vec3f& p) {
  return is_finite(p) && max_abs_component(p) <= kTraceLimit;
}

// The shape at each sample. Null if nothing deforms, or the samples are faulty (reported).
std::shared_ptr<Deformation> deform(const PulledMesh& pulled, const Cage& cage, const RefinementOptions& options,
                                    const Mesh& mesh, const alabaster::DiagnosticSink& sink) {
  const auto& [times, values] = pulled.point_samples;
  std::string fault = times_fault(times, values.size());
  const bool has_normals = !cage.normals.empty() && pulled.normal_samples.times == times &&
                           pulled.normal_samples.values.size() == values.size();
  auto deformation = std::make_shared<Deformation>();
  deformation->times = times;
  for (size_t i = 0; i < values.size() && fault.empty(); ++i) {
    MeshPose posed{read_points(values[i]), cage.normals.values};
    if (has_normals) posed.normals = read_points(pulled.normal_samples.values[i]);
    if (posed.points.size() != cage.points.size())
      fault = "sample " + std::to_string(i) + " has " + std::to_string(posed.points.size()) + " points, the mesh has " +
              std::to_string(cage.points.size());
    else if (posed.normals.size() != cage.normals.values.size())
      fault = "sample " + std::to_string(i) + " has another number of normals than the mesh";
    else if (!std::all_of(posed.points.begin(), posed.points.end(), is_usable_point))
      fault = "a point of sample " + std::to_string(i) + " is not finite, or beyond 1e17";
    else
      deformation->poses.push_back(pose_mesh(cage, options, std::move(posed)));
    // Displaced normals are told apart by their values, which may coincide in one pose alone.
    if (fault.empty() && deformation->poses.back().normals.size() != mesh.normals.size())
      fault = "sample " + std::to_string(i) + " has other hard edges than the mesh";
  }
  if (fault.empty()) return deformation;
  alabaster::report(sink, alabaster::Severity::error, "motion.points", options.where,
                    "the samples of the points cannot be used: " + fault + "; the mesh is drawn without deformation");
  return nullptr;
}

// Cage, refinement, displacement, BVH.
class MeshBuilder {
 public:
  MeshBuilder(const MeshJob& job, SceneParam* param, const CancelToken& cancel)
      : job_(job),
        mesh_(job.source.get()),
        named_(&job.request.primvars),
        edits_(job.edits.get()),
        where_(job.path.str()),
        param_(*param),
        cancel_(cancel) {}

  MeshResult run() {
    BuiltMesh out = job_.shape ? assign_slots(*job_.shape) : build();
    for (const alabaster::Diagnostic& d : reports_)
      if (d.severity == alabaster::Severity::error && !out.fault) out.fault = d.text;
    out.reported = !reports_.empty();
    return {std::move(out), std::move(reports_)};
  }

 private:
  // The same shape with other slots. Nothing was reported when it was built: its faces are those of the topology.
  BuiltMesh assign_slots(const BuiltMesh& shape) {
    BuiltMesh out = shape;
    const std::vector<int32_t>& face = shape.prototype->mesh.triangle_face;
    struct Held {
      MemoryReservation memory;
      TriangleSlots slots;
    };
    const std::vector<int32_t> of_faces =
        slots_of_faces(*job_.slots, mesh_->topology.faceVertexCounts.size(), where_, sink_);
    auto held = std::make_shared<Held>();
    held->memory = MemoryReservation(param_.memory(), MemoryUse::meshes,
                                     of_faces.empty() ? 0 : face.size() * sizeof(int32_t), where_);
    held->slots.reserve(of_faces.empty() ? 0 : face.size());
    if (!of_faces.empty())
      for (const int32_t f : face) held->slots.push_back(of_faces[static_cast<size_t>(f)]);
    out.slots = std::shared_ptr<const TriangleSlots>(held, &held->slots);
    return out;
  }

  BuiltMesh build() {
    const MeshRequest& request = job_.request;
    BuiltMesh out;
    if (!mesh_->curves.curveVertexCounts.empty()) {
      tubes_ = make_tubes(*mesh_, *named_, where_, sink_, param_.memory(), cancel_);
      mesh_ = &tubes_->mesh, named_ = &tubes_->named;
      if (mesh_->topology.faceVertexCounts.empty() && !reports_.empty()) return out;
    }
    const size_t faces = mesh_->topology.faceVertexCounts.size();
    const MemoryReservation cage_memory(param_.memory(), MemoryUse::meshes,
                                        memory_bytes(*mesh_, *named_) + faces * sizeof(int32_t), "a copy of its cage");
    Cage cage = make_cage(*mesh_, *named_, where_, sink_);
    cage.face_material = slots_of_faces(*job_.slots, faces, where_, sink_);
    if (!sanitize_cage(cage, where_, sink_)) return out;
    if (mesh_->point_samples.values.size() < 2) drop_unused_points(&cage);  // samples have values for all points
    cancel_.check();
    auto prototype = std::make_shared<MeshPrototype>();
    RefinementOptions options;
    options.level = refine_level(*mesh_);
    options.where = where_;
    options.cancel = cancel_;
    options.memory = &(prototype->memory = MemoryReservation(param_.memory(), MemoryUse::meshes));
    prototype->interior.count_in(param_.memory());
    prototype->tangents.count_in(param_.memory());
    if (edits_) prototype->interior.share_topology(edits_->shells);
    const auto before = edits_ ? edits_->before.lock() : nullptr;
    options.before = before ? &before->mesh : nullptr;
    if (!request.displacements.empty())
      options.displace = [&](Mesh* refined) { displace(request.displacements, where_, sink_, refined, cancel_); };
    if (!request.placements.empty()) options.segments = EdgeMeasure(request, cage.points);
    {
      const BuildClock::Running running(&param_.build_clock, BuildPhase::refine);
      prototype->mesh = build_mesh(cage, options, sink_);
      out.deformation = deform_mesh(cage, options, prototype->mesh, cage_memory.bytes());
    }
    cancel_.check();
    if (!prototype->mesh.triangles.empty()) add_bvh(std::move(prototype), &out);
    return out;
  }

  // Null: it does not deform.
  std::shared_ptr<const Deformation> deform_mesh(const Cage& cage, RefinementOptions options, const Mesh& mesh,
                                                 size_t cage_bytes) {
    const auto& [times, values] = mesh_->point_samples;
    const size_t samples = std::max(times.size(), values.size());
    if (samples < 2) return nullptr;
    const size_t pose = (mesh.points.capacity() + mesh.normals.capacity()) * sizeof(Vec3f);
    MemoryReservation memory(param_.memory(), MemoryUse::meshes, samples * pose,
                             "its shape at " + std::to_string(samples) + " times");
    // Each pose is made by a mesh of its own, of another copy of the cage.
    const MemoryReservation copy(param_.memory(), MemoryUse::meshes, cage_bytes, "a copy of its cage");
    MemoryReservation posed(param_.memory(), MemoryUse::meshes);
    options.memory = &posed;
    const auto deformation = deform(*mesh_, cage, options, mesh, sink_);
    if (deformation) deformation->memory = std::move(memory);
    return deformation;
  }

  void add_bvh(std::shared_ptr<MeshPrototype> prototype, BuiltMesh* out) {
    const BuildClock::Running running(&param_.build_clock, BuildPhase::bvh);
    const CancelToken cancel = cancel_;
    prototype->object =
        edits_ ? edits_->object.build(param_.device(), prototype->mesh, cancel)
               : build_object_scene(param_.device(), prototype->mesh, [cancel] { return cancel.is_cancelled(); });
    cancel_.check();
    if (!prototype->object)
      throw MemoryRefused("Embree built no hierarchy of its " + std::to_string(prototype->mesh.triangles.size()) +
                          " triangles; lower its refineLevel");
    out->prototype = std::move(prototype);
    if (edits_) edits_->before = out->prototype;
  }

  const MeshJob& job_;
  const PulledMesh* mesh_;  // as pulled, or the tubes
  const NamedPrimvars* named_;
  std::optional<Tubes> tubes_;
  PointEdits* const edits_;
  const std::string& where_;
  SceneParam& param_;
  const CancelToken cancel_;
  // Reports are kept back until it is known that the mesh is built: a cancelled one reports again next time.
  std::vector<alabaster::Diagnostic> reports_;
  const alabaster::DiagnosticSink sink_ = [this](const alabaster::Diagnostic& d) { reports_.push_back(d); };
};

}  // namespace

MeshResult build_mesh_job(const MeshJob& job, SceneParam* param, const CancelToken& cancel) {
  return MeshBuilder(job, param, cancel).run();
}

}  // namespace alabaster::hd::prims
