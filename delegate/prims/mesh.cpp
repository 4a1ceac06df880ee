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
  if (bits & dirty::kVisibility) record_.visible = scene.GetVisible(GetId());
  if (bits & dirty::kRenderTag) record_.render_tag = scene.GetRenderTag(GetId());
  if (bits & dirty::kCategories) record_.categories = scene.GetCategories(GetId());
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

DirtyBits MeshPrim::post_record(SceneDelegate& scene, SceneParam& param, DirtyBits bits) {
  pull(scene, bits, param.sink());
  if (shape_changed_) record_.source = std::make_shared<const PulledMesh>(pulled_);
  shape_changed_ = false;
  record_.prim_id = GetPrimId();
  record_.materials = slot_materials(pulled_.topology, material_);
  param.post(GetId(), record_);
  return dirty::kClean;
}

}  // namespace alabaster::hd::prims
