#include <algorithm>
#include <span>
#include <utility>

#include "delegate/prims/motion.h"
#include "delegate/prims/parameters.h"
#include "delegate/prims/prims.h"
#include "delegate/support/color_space.h"
#include "delegate/support/float_values.h"
#include "delegate/support/parameters.h"

namespace alabaster::hd::prims {
namespace {

constexpr DirtyBits kPrimvarBits = dirty::kPrimvar | dirty::kNormals;

PulledPrimvar pull_primvar(SceneDelegate& scene, const Path& id, const Token& name,
                           const std::vector<PrimvarDescriptor>& descriptors, SceneParam* param = nullptr) {
  for (const PrimvarDescriptor& descriptor : descriptors)
    if (descriptor.name == name) return prims::pull_primvar(scene, id, descriptor, param);
  return {};
}

// A name for the whole mesh; empty: none.
std::string pull_name(SceneDelegate& scene, const Path& id, const std::string& primvar,
                      const std::vector<PrimvarDescriptor>& descriptors, const char* otherwise,
                      const alabaster::DiagnosticSink& sink) {
  const PulledPrimvar pulled = pull_primvar(scene, id, primvar, descriptors);
  if (!pulled.present) return {};
  std::string name = pulled.value.text_or("");
  if (name.empty() || pulled.interpolation != Interpolation::constant)
    alabaster::report(sink, alabaster::Severity::warning, "mesh." + primvar, id.str(),
                      "primvar " + primvar + " must be a constant name; " + otherwise);
  return pulled.interpolation == Interpolation::constant ? name : std::string();
}

template <class T>
void take_only_element(Value* value) {
  if (const auto* elements = value->get<Array<T>>(); elements && elements->size() == 1) *value = Value((*elements)[0]);
}

// Each option is a constant primvar. A number stands for true unless it is 0.
void pull_options(SceneDelegate& scene, const Path& id, const std::vector<PrimvarDescriptor>& descriptors,
                  const alabaster::DiagnosticSink& sink, MeshOptions* options) {
  *options = {.double_sided = options->double_sided, .camera_cull = options->camera_cull};
  for (const auto& row : mesh_parameters()) {
    const Value otherwise = support::get_parameter(row, *options);
    const PulledPrimvar pulled = pull_primvar(scene, id, row.name, descriptors);
    if (!pulled.present) continue;
    Value value = pulled.value;
    take_only_element<float>(&value);
    take_only_element<Vec3f>(&value);
    const bool is_constant = pulled.interpolation == Interpolation::constant;
    const support::ParameterFault fault =
        is_constant ? support::set_parameter(row, value, options) : support::ParameterFault::type;
    if (fault == support::ParameterFault::type)
      alabaster::report(sink, alabaster::Severity::warning, "mesh." + std::string(row.name), id.str(),
                        "primvar " + std::string(row.name) + " must be a constant of the type in schemas/mesh.json; " +
                            otherwise.to_string() + " is used");
    else
      report_fault(sink, id.str(), row.name, fault, value);
  }
}

TimeSamples<Value> pull_samples(SceneDelegate& scene, const Path& id, const Token& name) {
  TimeSamples<Value> samples = scene.SamplePrimvar(id, name);
  for (Value& value : samples.values) value = support::FloatValues(value);
  return samples;
}

MeshTopology frozen(MeshTopology topology) {
  topology.invisiblePoints = {};  // nothing is drawn of them
  for (auto* array :
       {&topology.faceVertexCounts, &topology.faceVertexIndices, &topology.holeIndices, &topology.invisibleFaces})
    *array = array->frozen();
  for (GeomSubset& subset : topology.geomSubsets) subset.indices = subset.indices.frozen();
  return topology;
}

SubdivTags frozen(SubdivTags tags) {
  for (auto* array : {&tags.creaseIndices, &tags.creaseLengths, &tags.cornerIndices}) *array = array->frozen();
  for (auto* array : {&tags.creaseWeights, &tags.cornerWeights}) *array = array->frozen();
  return tags;
}

// A front that the camera passes leaves the back as the only side there is to see.
void set_sides(CullStyle style, bool double_sided, MeshOptions* options) {
  const bool front = style == CullStyle::front || (style == CullStyle::frontUnlessDoubleSided && !double_sided);
  options->double_sided = double_sided || front || style == CullStyle::nothing;
  options->camera_cull = front ? CameraCull::front : style == CullStyle::back ? CameraCull::back : CameraCull::none;
}

template <class T>
void update(T* held, T now, bool* changed) {
  if (*held == now) return;
  *held = std::move(now);
  *changed = true;
}

}  // namespace

PulledPrimvar pull_primvar(SceneDelegate& scene, const Path& id, const PrimvarDescriptor& descriptor,
                           SceneParam* param) {
  PulledPrimvar pulled{.present = true, .interpolation = descriptor.interpolation, .value = {}, .indices = {}};
  if (param && descriptor.role == Token(support::kLinearRec709)) pulled.to_rendering = param->rec709_to_rendering();
  pulled.value = support::FloatValues(scene.GetPrimvar(id, descriptor.name, &pulled.indices));
  pulled.indices = descriptor.indexed ? pulled.indices.frozen() : Array<int32_t>();
  return pulled;
}

// A value that is dirty but equal to what is held changes nothing: the descriptor set may differ elsewhere.
void MeshPrim::pull_shape(SceneDelegate& scene, DirtyBits bits) {
  const bool has_faces = !is_curves_ && spheres_.empty();
  if (bits & dirty::kTopology && is_curves_) {
    BasisCurvesTopology curves = scene.GetBasisCurvesTopology(GetId());
    curves.curveVertexCounts = curves.curveVertexCounts.frozen();
    update(&pulled_.curves, std::move(curves), &shape_changed_);
  } else if (bits & dirty::kTopology && has_faces) {
    MeshTopology topology = frozen(scene.GetMeshTopology(GetId()));
    subsets_ = std::exchange(topology.geomSubsets, {});
    update(&pulled_.topology, std::move(topology), &shape_changed_);
  }
  if (bits & dirty::kSubdivTags && has_faces)
    update(&pulled_.tags, frozen(scene.GetSubdivTags(GetId())), &shape_changed_);
  if (bits & dirty::kDisplayStyle && has_faces) update(&pulled_.style, scene.GetDisplayStyle(GetId()), &shape_changed_);
  if (bits & dirty::kPoints) {
    PulledPrimvar points;  // pulled even when no descriptor names them
    points.present = true;
    points.value = support::FloatValues(scene.GetPrimvar(GetId(), "points", &points.indices));
    points.indices = points.indices.frozen();
    update(&pulled_.points, std::move(points), &shape_changed_);
    update(&pulled_.point_samples, pull_samples(scene, GetId(), "points"), &shape_changed_);
  }
  if (bits & (dirty::kPoints | dirty::kNormals))
    update(&pulled_.normal_samples, pull_samples(scene, GetId(), "normals"), &shape_changed_);
}

// Those of other names are held beside the shape: they count as a change of it where something reads them.
void MeshPrim::pull_primvars(SceneDelegate& scene, SceneParam& param) {
  const alabaster::DiagnosticSink& sink = param.sink();
  const std::vector<PrimvarDescriptor> descriptors = scene.GetPrimvarDescriptors(GetId());
  const auto is_of_shape = [](const Token& name) {
    return std::any_of(std::begin(kPulledPrimvars), std::end(kPulledPrimvars),
                       [&](const auto& one) { return name == Token(one.name); });
  };
  for (const auto& [name, primvar] : std::span(kPulledPrimvars).subspan(1))  // all but the points
    update(&(pulled_.*primvar), pull_primvar(scene, GetId(), name, descriptors, &param), &shape_changed_);
  std::map<Token, PulledPrimvar> uvs;
  OtherPrimvars others;
  for (const PrimvarDescriptor& descriptor : descriptors) {
    if (descriptor.role == Token("textureCoordinate") || descriptor.name == Token("st")) {
      uvs[descriptor.name] = pull_primvar(scene, GetId(), descriptor.name, descriptors);
    } else if (!is_of_shape(descriptor.name)) {
      PulledPrimvar other = prims::pull_primvar(scene, GetId(), descriptor, &param);
      if (numbers_of(other.value).data) others.by_name[descriptor.name] = std::move(other);
    }
  }
  update(&pulled_.uvs, std::move(uvs), &shape_changed_);
  if (others.by_name.empty()) {
    record_.other_primvars = nullptr;
  } else if (!record_.other_primvars || !(*record_.other_primvars == others)) {
    hold_arrays(&others, &param.buffers(), GetId().str());
    record_.other_primvars = std::make_shared<const OtherPrimvars>(std::move(others));
  }
  record_.subsurface_set =
      pull_name(scene, GetId(), "subsurfaceSet", descriptors, "the object scatters on its own", sink);
  record_.light_group = pull_name(scene, GetId(), "lightGroup", descriptors, "its light has no group", sink);
  record_.crypto_object = pull_name(scene, GetId(), "cryptoObject", descriptors, "its matte has its own name", sink);
  record_.crypto_asset = pull_name(scene, GetId(), "cryptoAsset", descriptors, "its asset has its own name", sink);
  pull_options(scene, GetId(), descriptors, sink, &record_.options);
}

void MeshPrim::pull(SceneDelegate& scene, SceneParam& param, DirtyBits bits) {
  pull_shape(scene, bits);
  if (bits & kPrimvarBits) pull_primvars(scene, param);
  if (bits & dirty::kVisibility) record_.visible = scene.GetVisible(GetId());
  if (bits & dirty::kRenderTag) record_.render_tag = scene.GetRenderTag(GetId());
  if (bits & dirty::kPrimId) record_.display_name = scene.GetDisplayName(GetId());
  if (bits & dirty::kCategories) record_.categories = scene.GetCategories(GetId());
  if (bits & (dirty::kDoubleSided | dirty::kCullStyle))
    set_sides(scene.GetCullStyle(GetId()), scene.GetDoubleSided(GetId()), &record_.options);
  if (bits & dirty::kTransform) {
    record_.transform = scene.GetTransform(GetId());
    record_.motion = checked_motion(scene.SampleTransform(GetId()), GetId(), param.sink());
  }
  if (bits & dirty::kMaterialId) material_ = scene.GetMaterialId(GetId());
  if (bits & dirty::kInstancer) record_.instancer = scene.GetInstancerId(GetId());
  if (bits & (dirty::kInstancer | dirty::kInstanceIndex))
    record_.instance_indices =
        record_.instancer.empty() ? Array<int32_t>() : scene.GetInstanceIndices(record_.instancer, GetId()).frozen();
}

void MeshPrim::update_slots(SceneParam& param) {
  FaceSlots slots = face_slots(subsets_);
  if (record_.slots && *record_.slots == slots) return;
  hold_arrays(&slots, &param.buffers(), GetId().str());
  record_.slots = std::make_shared<const FaceSlots>(std::move(slots));
}

// Leaves `shape` the constant ones.
void MeshPrim::update_values_by_point(PulledMesh* shape, SceneParam& param) {
  OtherPrimvars others = record_.other_primvars ? *record_.other_primvars : OtherPrimvars();
  const size_t count = places_.points->size();
  update_by_instance(take_values_by_point(shape, &others), count, "point", GetId(), &param, &by_point_);
  of_sphere_ = others.by_name.empty() ? nullptr : std::make_shared<const OtherPrimvars>(std::move(others));
}

// The sphere of points stands in the places that an instancer of their own gives it, which the points' own instancer
// places.
void MeshPrim::post_points(SceneParam& param) {
  InstancerRecord places;
  places.transform = record_.transform, places.motion = {record_.motion.times, record_.motion.values};
  places.points = places_.points, places.moving_points = places_.moving;
  places.parent = record_.instancer, places.indices_in_parent = record_.instance_indices;
  places.primvars = by_point_;
  MeshRecord sphere = record_;
  sphere.other_primvars = of_sphere_;
  sphere.transform = Matrix4d(), sphere.motion = {};
  sphere.instancer = spheres_, sphere.instance_indices = places_.drawn;
  param.post(sphere.instancer, std::move(places));
  param.post(GetId(), std::move(sphere));
}

DirtyBits MeshPrim::post_record(SceneDelegate& scene, SceneParam& param, DirtyBits bits) {
  pull(scene, param, bits);
  if (shape_changed_) hold_arrays(&pulled_, &param.buffers(), GetId().str());
  PulledMesh shape = pulled_;
  if (!spheres_.empty()) {
    if (shape_changed_) places_ = place_points(pulled_, GetId().str(), param.sink());
    if (shape_changed_ || bits & kPrimvarBits) update_values_by_point(&shape, param);
    make_sphere_of(&shape);
  }
  if (shape_changed_) record_.source = std::make_shared<const PulledMesh>(std::move(shape));
  shape_changed_ = false;
  if (bits & dirty::kTopology) update_slots(param);
  record_.prim_id = GetPrimId();
  record_.materials = slot_materials(subsets_, material_);
  if (!spheres_.empty())
    post_points(param);
  else
    param.post(GetId(), record_);
  return dirty::kClean;
}

}  // namespace alabaster::hd::prims
