#include <algorithm>

#include "delegate/prims/motion.h"
#include "delegate/prims/prims.h"

namespace alabaster::hd::prims {
namespace {

constexpr DirtyBits kPrimvarBits = dirty::kPrimvar | dirty::kNormals;

PulledPrimvar pull_primvar(SceneDelegate& scene, const Path& id, const Token& name,
                           const std::vector<PrimvarDescriptor>& descriptors) {
  PulledPrimvar pulled;
  for (const PrimvarDescriptor& descriptor : descriptors) {
    if (!(descriptor.name == name)) continue;
    pulled.present = true;
    pulled.interpolation = descriptor.interpolation;
    pulled.value = scene.GetPrimvar(id, name, &pulled.indices);
    if (!descriptor.indexed) pulled.indices = {};
  }
  return pulled;
}

// A name for the whole mesh; empty: none.
std::string pull_subsurface_set(SceneDelegate& scene, const Path& id, const std::vector<PrimvarDescriptor>& descriptors,
                                const alabaster::DiagnosticSink& sink) {
  const PulledPrimvar pulled = pull_primvar(scene, id, "subsurfaceSet", descriptors);
  if (!pulled.present) return {};
  std::string name = pulled.value.text_or("");
  if (name.empty() || pulled.interpolation != Interpolation::constant)
    alabaster::report(sink, alabaster::Severity::warning, "mesh.subsurfaceSet", id.str(),
                      "primvar subsurfaceSet must be a constant name; the object scatters on its own");
  return pulled.interpolation == Interpolation::constant ? name : std::string();
}

template <class T>
void update(T* held, T now, bool* changed) {
  if (*held == now) return;
  *held = std::move(now);
  *changed = true;
}

std::vector<Vec3f> read_points(const Value& value) {
  const auto* array = value.get<Array<Vec3f>>();
  return array ? std::vector<Vec3f>(array->begin(), array->end()) : std::vector<Vec3f>();
}

bool is_usable_point(const Vec3f& p) {
  return is_finite(p) && max_abs_component(p) <= kTraceLimit;
}

// Purposes other than the final picture's are never drawn.
bool is_drawn_tag(const Token& tag) {
  return !(tag == Token("guide") || tag == Token("proxy") || tag == Token("hidden"));
}

}  // namespace

// A value that is dirty but equal to what is held changes nothing: the descriptor set may differ elsewhere.
void MeshPrim::pull_shape(SceneDelegate& scene, DirtyBits bits, const alabaster::DiagnosticSink& sink) {
  if (bits & dirty::kTopology) {
    MeshTopology topology = scene.GetMeshTopology(GetId());
    shape_changed_ |= !same_shape(pulled_.topology, topology);
    pulled_.topology = std::move(topology);
  }
  if (bits & dirty::kSubdivTags) update(&pulled_.tags, scene.GetSubdivTags(GetId()), &shape_changed_);
  if (bits & dirty::kDisplayStyle) update(&pulled_.style, scene.GetDisplayStyle(GetId()), &shape_changed_);
  if (bits & dirty::kPoints) {
    PulledPrimvar points;  // pulled even when no descriptor names them
    points.present = true;
    Array<int32_t> unused;
    points.value = scene.GetPrimvar(GetId(), "points", &unused);
    update(&pulled_.points, std::move(points), &shape_changed_);
    update(&pulled_.point_samples, scene.SamplePrimvar(GetId(), "points"), &shape_changed_);
  }
  if (bits & (dirty::kPoints | dirty::kNormals))
    update(&pulled_.normal_samples, scene.SamplePrimvar(GetId(), "normals"), &shape_changed_);
  if (bits & kPrimvarBits) {
    const std::vector<PrimvarDescriptor> descriptors = scene.GetPrimvarDescriptors(GetId());
    const std::pair<const char*, PulledPrimvar*> named[] = {{"normals", &pulled_.normals},
                                                            {"tangents", &pulled_.tangents},
                                                            {"displayColor", &pulled_.display_color},
                                                            {"displayOpacity", &pulled_.display_opacity}};
    for (const auto& [name, held] : named)
      update(held, pull_primvar(scene, GetId(), name, descriptors), &shape_changed_);
    std::map<Token, PulledPrimvar> uvs;
    for (const PrimvarDescriptor& descriptor : descriptors)
      if (descriptor.role == Token("textureCoordinate") || descriptor.name == Token("st"))
        uvs[descriptor.name] = pull_primvar(scene, GetId(), descriptor.name, descriptors);
    update(&pulled_.uvs, std::move(uvs), &shape_changed_);
    record_.subsurface_set = pull_subsurface_set(scene, GetId(), descriptors, sink);
  }
}

void MeshPrim::pull(SceneDelegate& scene, DirtyBits bits, const alabaster::DiagnosticSink& sink) {
  pull_shape(scene, bits, sink);
  if (bits & dirty::kVisibility) visible_ = scene.GetVisible(GetId());
  if (bits & dirty::kRenderTag) tag_visible_ = is_drawn_tag(scene.GetRenderTag(GetId()));
  if (bits & dirty::kDoubleSided) record_.double_sided = scene.GetDoubleSided(GetId());
  if (bits & dirty::kTransform) {
    record_.transform = scene.GetTransform(GetId());
    record_.motion = checked_motion(scene.SampleTransform(GetId()), GetId(), sink);
  }
  if (bits & dirty::kMaterialId) material_ = scene.GetMaterialId(GetId());
  if (bits & dirty::kInstancer) record_.instancer = scene.GetInstancerId(GetId());
  if (bits & (dirty::kInstancer | dirty::kInstanceIndex))
    record_.instance_indices =
        record_.instancer.empty() ? Array<int32_t>() : scene.GetInstanceIndices(record_.instancer, GetId());
}

// Cage -> triangles -> BVH. False: cancelled, nothing changed.
bool MeshPrim::build(SceneParam& param) {
  const std::string& where = GetId().str();
  Cage cage = make_cage(pulled_, where, param.sink());
  std::shared_ptr<MeshPrototype> prototype;
  std::shared_ptr<const Deformation> deformation;
  bool finished = true;
  std::optional<SceneFault> fault;
  const alabaster::DiagnosticSink sink = [&](const alabaster::Diagnostic& d) {
    if (d.severity == alabaster::Severity::error) fault = SceneFault{true, d.text};
    if (param.sink()) param.sink()(d);
  };
  param.run([&] {
    if (param.cancelled()) {
      finished = false;
      return;
    }
    if (!sanitize_cage(cage, where, sink)) return;
    prototype = std::make_shared<MeshPrototype>();
    RefinementOptions options;
    options.level = std::clamp(pulled_.style.refineLevel, 0, 8);
    options.where = where;
    {
      const SyncClock::Running running(&param.clock, SyncPhase::refine);
      prototype->mesh = build_mesh(cage, options, sink);
      deformation = deform(cage, options, sink);
    }
    const SyncClock::Running running(&param.clock, SyncPhase::bvh);
    if (!prototype->mesh.triangles.empty())
      prototype->object = build_object_scene(param.device(), prototype->mesh, [&param] { return param.cancelled(); });
    finished = !param.cancelled() || prototype->object;
    if (finished && !prototype->mesh.triangles.empty() && !prototype->object) {
      fault = SceneFault{
          false, "not enough memory to trace " + std::to_string(prototype->mesh.triangles.size()) + " triangles"};
      alabaster::report(param.sink(), alabaster::Severity::error, "mesh.memory", where,
                        fault->text + "; lower its refineLevel, or render on a machine with more memory");
    }
  });
  if (!finished) return false;
  param.set_fault(GetId(), std::move(fault));
  record_.prototype = prototype && prototype->object ? std::move(prototype) : nullptr;
  record_.deformation = record_.prototype ? std::move(deformation) : nullptr;
  return true;
}

// The shape at each sample. Null if nothing deforms, or the samples are faulty (reported).
std::shared_ptr<const Deformation> MeshPrim::deform(const Cage& cage, const RefinementOptions& options,
                                                    const alabaster::DiagnosticSink& sink) const {
  const auto& [times, values] = pulled_.point_samples;
  if (times.size() < 2 && values.size() < 2) return nullptr;
  std::string fault = times_fault(times, values.size());
  const bool has_normals = !cage.normals.empty() && pulled_.normal_samples.times == times &&
                           pulled_.normal_samples.values.size() == values.size();
  auto deformation = std::make_shared<Deformation>();
  deformation->times = times;
  for (size_t i = 0; i < values.size() && fault.empty(); ++i) {
    MeshPose posed{read_points(values[i]), cage.normals.values};
    if (has_normals) posed.normals = read_points(pulled_.normal_samples.values[i]);
    if (posed.points.size() != cage.points.size())
      fault = "sample " + std::to_string(i) + " has " + std::to_string(posed.points.size()) + " points, the mesh has " +
              std::to_string(cage.points.size());
    else if (posed.normals.size() != cage.normals.values.size())
      fault = "sample " + std::to_string(i) + " has another number of normals than the mesh";
    else if (!std::all_of(posed.points.begin(), posed.points.end(), is_usable_point))
      fault = "a point of sample " + std::to_string(i) + " is not finite, or beyond 1e17";
    else
      deformation->poses.push_back(pose_mesh(cage, options, std::move(posed)));
  }
  if (fault.empty()) return deformation;
  alabaster::report(sink, alabaster::Severity::error, "motion.points", GetId().str(),
                    "the samples of the points cannot be used: " + fault + "; the mesh is drawn without deformation");
  return nullptr;
}

DirtyBits MeshPrim::post_record(SceneDelegate& scene, SceneParam& param, DirtyBits bits) {
  DirtyBits left = dirty::kClean;
  pull(scene, bits, param.sink());
  if (shape_changed_) {
    if (build(param))
      shape_changed_ = false;
    else
      left = dirty::kPrimId;  // any bit: the index asks again, and what was pulled is held
  }
  record_.visible = visible_ && tag_visible_;
  record_.prim_id = GetPrimId();
  record_.materials = slot_materials(pulled_.topology, material_);
  param.post(GetId(), record_);
  return left;
}

}  // namespace alabaster::hd::prims
