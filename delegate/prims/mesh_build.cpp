#include "delegate/prims/mesh_build.h"

#include <tbb/parallel_for.h>

#include <algorithm>

#include "delegate/prims/motion.h"

namespace alabaster::hd::prims {
namespace {

// By the mesh's slots; empty if no material of it displaces.
Displacements displacements_of(const MeshRecord& mesh, const Records& records) {
  Displacements all;
  bool any = false;
  for (const Path& path : mesh.materials) {
    const auto found = records.find(path);
    const auto* record = found == records.end() ? nullptr : std::get_if<MaterialRecord>(&found->second);
    all.push_back(record ? record->material->displacement : std::nullopt);
    any |= all.back().has_value();
  }
  return any ? all : Displacements();
}

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

bool is_refined(const PulledMesh& mesh) {
  // One that deforms is the same mesh at all times.
  return mesh.point_samples.times.size() < 2 && mesh.style.refineLevel > 0 && !mesh.topology.scheme.empty() &&
         !(mesh.topology.scheme == Token("none"));
}

// Where the instances of a mesh stand at the frame's time. Faults of instancers are the translation's to report.
std::vector<Matrix4d> placements_of(const Path& path, const MeshRecord& mesh, support::Placements& placements) {
  if (mesh.instancer.empty()) return {mesh.transform};
  std::vector<Matrix4d> all;
  for (const support::Placement& placed : placements.place(path, mesh.instancer, mesh.instance_indices))
    if (placed.used) all.push_back(mesh.transform * placed.matrix);
  return all;
}

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

// Reports, kept back until it is known that the mesh is built: a cancelled one reports again next time.
class KeptReports {
 public:
  explicit KeptReports(std::vector<alabaster::Diagnostic>* kept) : kept_(kept) {}
  void operator()(const alabaster::Diagnostic& d) const { kept_->push_back(d); }

 private:
  std::vector<alabaster::Diagnostic>* kept_;
};

// Cage, refinement, displacement, BVH.
class MeshBuilder {
 public:
  struct Source {
    const PulledMesh& mesh;
    const FaceSlots& slots;
    PointEdits* edits;  // null: it is built for the first time
  };
  MeshBuilder(const Source& source, const Path& id, SceneParam& param, const CancelToken& cancel)
      : mesh_(source.mesh),
        slots_(source.slots),
        edits_(source.edits),
        where_(id.str()),
        param_(param),
        cancel_(cancel) {}

  MeshBuild build(const MeshRequest& request, KnownFaults* known) {
    return reported(known, [&] { return build_silently(request); });
  }

  // The same shape with other slots. Nothing was reported when it was built: its faces are those of the topology.
  MeshBuild assign_slots(const MeshBuild& shape, KnownFaults* known) {
    return reported(known, [&] {
      MeshBuild out = shape;
      const std::vector<int32_t>& face = shape.prototype->mesh.triangle_face;
      struct Held {
        MemoryReservation memory;
        TriangleSlots slots;
      };
      const std::vector<int32_t> of_faces =
          slots_of_faces(slots_, mesh_.topology.faceVertexCounts.size(), where_, sink_);
      auto held = std::make_shared<Held>();
      held->memory = MemoryReservation(param_.memory(), MemoryUse::meshes,
                                       of_faces.empty() ? 0 : face.size() * sizeof(int32_t), where_);
      held->slots.reserve(of_faces.empty() ? 0 : face.size());
      if (!of_faces.empty())
        for (const int32_t f : face) held->slots.push_back(of_faces[static_cast<size_t>(f)]);
      out.slots = std::shared_ptr<const TriangleSlots>(held, &held->slots);
      return out;
    });
  }

 private:
  template <class Make>
  MeshBuild reported(KnownFaults* known, const Make& make) {
    MeshBuild out;
    try {
      out = make();
    } catch (const MemoryRefused& e) {
      out.fault = SceneFault{false, e.what()};
      sink_({alabaster::Severity::error, "mesh.memory", where_, out.fault->text});
    }
    for (const alabaster::Diagnostic& d : reports_)
      if (d.severity == alabaster::Severity::error && !out.fault) out.fault = SceneFault{true, d.text};
    out.reported = !reports_.empty();
    known->report(param_.sink(), std::move(reports_));
    return out;
  }

  MeshBuild build_silently(const MeshRequest& request) {
    MeshBuild out;
    const size_t faces = mesh_.topology.faceVertexCounts.size();
    const MemoryReservation cage_memory(param_.memory(), MemoryUse::meshes,
                                        memory_bytes(mesh_) + faces * sizeof(int32_t), "a copy of its cage");
    Cage cage = make_cage(mesh_, request.primvars, where_, sink_);
    cage.face_material = slots_of_faces(slots_, faces, where_, sink_);
    if (!sanitize_cage(cage, where_, sink_)) return out;
    cancel_.check();
    auto prototype = std::make_shared<MeshPrototype>();
    RefinementOptions options;
    options.level = std::clamp(mesh_.style.refineLevel, 0, 8);
    options.where = where_;
    options.cancel = cancel_;
    options.memory = &(prototype->memory = MemoryReservation(param_.memory(), MemoryUse::meshes));
    prototype->interior.count_in(param_.memory());
    if (edits_) prototype->interior.share_topology(edits_->shells);
    const auto before = edits_ ? edits_->before.lock() : nullptr;
    options.before = before ? &before->mesh : nullptr;
    if (!request.displacements.empty())
      options.displace = [&](Mesh* refined) { displace(request.displacements, where_, sink_, refined, cancel_); };
    if (!request.placements.empty()) options.segments = EdgeMeasure(request, cage.points);
    {
      const SyncClock::Running running(&param_.clock, SyncPhase::refine);
      prototype->mesh = build_mesh(cage, options, sink_);
      const auto& [times, values] = mesh_.point_samples;
      if (const size_t samples = std::max(times.size(), values.size()); samples > 1) {
        const Mesh& mesh = prototype->mesh;
        const size_t pose = (mesh.points.capacity() + mesh.normals.capacity()) * sizeof(Vec3f);
        MemoryReservation memory(param_.memory(), MemoryUse::meshes, samples * pose,
                                 "its shape at " + std::to_string(samples) + " times");
        options.memory = nullptr;
        const auto deformation = deform(mesh_, cage, options, mesh, sink_);
        if (deformation) deformation->memory = std::move(memory);
        out.deformation = deformation;
      }
    }
    cancel_.check();
    if (!prototype->mesh.triangles.empty()) add_bvh(std::move(prototype), &out);
    return out;
  }

  void add_bvh(std::shared_ptr<MeshPrototype> prototype, MeshBuild* out) {
    const SyncClock::Running running(&param_.clock, SyncPhase::bvh);
    const CancelToken cancel = cancel_;
    prototype->object =
        edits_ ? edits_->object.build(param_.device(), prototype->mesh, cancel)
               : build_object_scene(param_.device(), prototype->mesh, [cancel] { return cancel.is_cancelled(); });
    if (prototype->object) {
      out->prototype = std::move(prototype);
      if (edits_) edits_->before = out->prototype;
      return;
    }
    cancel_.check();
    out->deformation = nullptr;
    out->fault = SceneFault{
        false, "not enough memory to trace " + std::to_string(prototype->mesh.triangles.size()) + " triangles"};
    sink_({alabaster::Severity::error, "mesh.memory", where_,
           out->fault->text + "; raise memoryLimit, lower its refineLevel, or render on a machine with more memory"});
  }

  const PulledMesh& mesh_;
  const FaceSlots& slots_;
  PointEdits* const edits_;
  const std::string& where_;
  SceneParam& param_;
  const CancelToken cancel_;
  std::vector<alabaster::Diagnostic> reports_;
  const alabaster::DiagnosticSink sink_{KeptReports(&reports_)};
};

}  // namespace

const MeshBuild* BuiltMeshes::find(const Path& mesh) const {
  const auto held = held_.find(mesh);
  return held == held_.end() || !held->second.done ? nullptr : &held->second.built;
}

bool BuiltMeshes::incomplete() const {
  return std::any_of(held_.begin(), held_.end(), [](const Entry& entry) { return !entry.second.done; });
}

SceneFaults BuiltMeshes::faults(const Records& records, const Selection& selection) const {
  SceneFaults faults;
  for (const auto& [path, held] : held_)
    if (held.built.fault && selection.includes(path, std::get<MeshRecord>(records.at(path))))
      faults.emplace(path, *held.built.fault);
  return faults;
}

// Drops the meshes that are gone or hidden, and what edits of others left behind; answers with those to build.
std::vector<BuiltMeshes::Entry*> BuiltMeshes::collect(const Records& records, const std::vector<Selection>& selections,
                                                      const MeshView& view,
                                                      const std::shared_ptr<MemoryBudget>& budget) {
  support::Placements placements(
      [&](const Path& path) -> const InstancerRecord* {
        const auto found = records.find(path);
        return found == records.end() ? nullptr : std::get_if<InstancerRecord>(&found->second);
      },
      [](const char*, const Path&, const std::string&) {});
  std::map<Path, Held> needed;
  std::vector<Entry*> to_build;
  for (const auto& [path, record] : records) {
    const auto* mesh = std::get_if<MeshRecord>(&record);
    if (!mesh || !mesh->visible || !mesh->source || !mesh->slots) continue;
    MeshRequest request{displacements_of(*mesh, records), {}, {}, {}};
    if (!view.primvars.empty()) request.primvars = {view.primvars, mesh->other_primvars};
    if (view.dicing.edge_length > 0 && is_refined(*mesh->source)) {
      request.dicing = view.dicing;
      request.placements = placements_of(path, *mesh, placements);
    }
    const auto held = held_.find(path);
    const bool same_shape =
        held != held_.end() && held->second.source == mesh->source && held->second.request == request;
    const bool same_slots = same_shape && held->second.slots == mesh->slots;
    if (same_slots && held->second.done) {
      constexpr int kMostOthers = 16;
      if (held->second.edits && ++held->second.edits_of_others == kMostOthers) held->second.edits->rest();
      needed.insert(held_.extract(held));
      continue;
    }
    if (std::none_of(selections.begin(), selections.end(),
                     [&id = path, &shown = *mesh](const Selection& s) { return s.includes(id, shown); }))
      continue;
    Held made{mesh->source, mesh->slots, std::move(request), {}};
    if (held != held_.end()) {
      made.faults = held->second.faults;
      keep_edits(held->second, budget, &made);
    }
    // Displacement is a material's.
    if (same_shape && held->second.has_shape && made.request.displacements.empty()) {
      made.built = held->second.built;
      made.has_shape = true;
    }
    to_build.push_back(&*needed.emplace(path, std::move(made)).first);
  }
  held_ = std::move(needed);
  view_ = view;
  return to_build;
}

// Where the topology is the same, the triangles mostly are. With motion samples there are several shapes to build.
void BuiltMeshes::keep_edits(const Held& from, const std::shared_ptr<MemoryBudget>& budget, Held* made) {
  const PulledMesh &a = *from.source, &b = *made->source;
  if (!(a.topology == b.topology) || !(a.tags == b.tags) || !(a.style == b.style)) return;
  if (b.point_samples.times.size() > 1 || made->request.dicing.edge_length > 0) return;
  made->edits = from.edits;
  if (!made->edits && from.built.prototype) made->edits = std::make_shared<PointEdits>(budget);
}

void BuiltMeshes::rest() {
  for (auto& [path, held] : held_)
    if (held.edits) held.edits->rest();
}

void BuiltMeshes::build(const Records& records, const std::vector<Selection>& selections, const MeshView& view,
                        SceneParam& param, const CancelToken& cancel) {
  if (incomplete()) rest();  // it may be memory that they lack
  const std::vector<Entry*> to_build = collect(records, selections, view, param.memory());
  if (to_build.empty()) return;
  const auto build_one = [&](Entry* entry) {
    if (cancel.is_cancelled()) return;
    Held& held = entry->second;
    bool cancelled = false;
    const bool built = guarded(param.sink(), entry->first.str(), [&] {
      try {
        MeshBuilder builder({*held.source, *held.slots, held.edits.get()}, entry->first, param, cancel);
        held.built =
            held.has_shape ? builder.assign_slots(held.built, &held.faults) : builder.build(held.request, &held.faults);
      } catch (const BuildCancelled&) {
        cancelled = true;
      }
    });
    const bool refused = held.built.fault && !held.built.fault->input;
    held.done = built && !cancelled && !refused;
    held.has_shape = cancelled ? held.has_shape : held.built.prototype && !held.built.reported;
    if (!built) held.built.fault = SceneFault{false, "the mesh could not be built"};
  };
  param.run([&] { tbb::parallel_for(size_t(0), to_build.size(), [&](size_t i) { build_one(to_build[i]); }); });
  cancel.check();
}

}  // namespace alabaster::hd::prims
