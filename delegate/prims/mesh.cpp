#include <algorithm>

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
  }
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
  if (bits & dirty::kTransform) record_.transform = scene.GetTransform(GetId());
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
  return true;
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
