#include "delegate/host/scene_fields.h"

#include <algorithm>

#include "delegate/host/open_fields.h"
#include "delegate/support/nearest_name.h"

namespace alabaster::hd::host {
namespace {

using Mesh = MeshDescription;
constexpr Field kMesh[] = {
    field<&Mesh::topology, &MeshTopology::scheme>("scheme", dirty::kTopology,
                                                  words("none", "catmullClark", "loop", "bilinear")),
    field<&Mesh::topology, &MeshTopology::orientation>("orientation", dirty::kTopology,
                                                       words("rightHanded", "leftHanded")),
    field<&Mesh::topology, &MeshTopology::faceVertexCounts>("faceVertexCounts", dirty::kTopology),
    field<&Mesh::topology, &MeshTopology::faceVertexIndices>("faceVertexIndices", dirty::kTopology),
    field<&Mesh::topology, &MeshTopology::holeIndices>("holeIndices", dirty::kTopology),
    field<&Mesh::topology, &MeshTopology::invisibleFaces>("invisibleFaces", dirty::kTopology),
    field<&Mesh::subdivTags, &SubdivTags::interpolateBoundary>("interpolateBoundary", dirty::kSubdivTags,
                                                               words("none", "edgeOnly", "edgeAndCorner")),
    field<&Mesh::subdivTags, &SubdivTags::faceVaryingLinearInterpolation>(
        "faceVaryingLinearInterpolation", dirty::kSubdivTags,
        words("all", "none", "boundaries", "cornersOnly", "cornersPlus1", "cornersPlus2")),
    field<&Mesh::subdivTags, &SubdivTags::creaseMethod>("creaseMethod", dirty::kSubdivTags,
                                                        words("uniform", "chaikin")),
    field<&Mesh::subdivTags, &SubdivTags::triangleSubdivision>("triangleSubdivision", dirty::kSubdivTags,
                                                               words("catmullClark", "smooth")),
    field<&Mesh::subdivTags, &SubdivTags::creaseIndices>("creaseIndices", dirty::kSubdivTags),
    field<&Mesh::subdivTags, &SubdivTags::creaseLengths>("creaseLengths", dirty::kSubdivTags),
    field<&Mesh::subdivTags, &SubdivTags::creaseWeights>("creaseWeights", dirty::kSubdivTags),
    field<&Mesh::subdivTags, &SubdivTags::cornerIndices>("cornerIndices", dirty::kSubdivTags),
    field<&Mesh::subdivTags, &SubdivTags::cornerWeights>("cornerWeights", dirty::kSubdivTags),
    field<&Mesh::displayStyle, &DisplayStyle::refineLevel>("refineLevel", dirty::kDisplayStyle, range(0, 8)),
    field<&Mesh::transform>("transform", dirty::kTransform),
    field<&Mesh::transformSamples>("transform:samples", dirty::kTransform),
    field<&Mesh::visible>("visible", dirty::kVisibility),
    field<&Mesh::doubleSided>("doubleSided", dirty::kDoubleSided),
    field<&Mesh::cullStyle>(
        "cullStyle", dirty::kCullStyle,
        words("dontCare", "nothing", "back", "front", "backUnlessDoubleSided", "frontUnlessDoubleSided")),
    field<&Mesh::material>("material", dirty::kMaterialId),
    field<&Mesh::instancer>("instancer", dirty::kInstancer | dirty::kInstanceIndex),
    field<&Mesh::renderTag>("renderTag", dirty::kRenderTag),
    field<&Mesh::categories>("categories", dirty::kCategories),
};
constexpr Field kInstancer[] = {
    field<&InstancerDescription::transform>("transform", dirty::kTransform),
    field<&InstancerDescription::transformSamples>("transform:samples", dirty::kTransform),
    field<&InstancerDescription::parent>("parent", dirty::kInstancer | dirty::kInstanceIndex),
};
constexpr Field kLight[] = {
    field<&LightDescription::transform>("transform", dirty::kTransform),
    field<&LightDescription::visible>("visible", dirty::kVisibility),
};
constexpr Field kCamera[] = {
    field<&CameraDescription::transform>("transform", dirty::kTransform),
    field<&CameraDescription::transformSamples>("transform:samples", dirty::kTransform),
};
using Settings = RenderSettingsDescription;
constexpr Field kSettings[] = {
    field<&Settings::camera>("camera", dirty::kParams),
    field<&Settings::width>("width", dirty::kParams, range(1, 1 << 20)),
    field<&Settings::height>("height", dirty::kParams, range(1, 1 << 20)),
    field<&Settings::pixelAspectRatio>("pixelAspectRatio", dirty::kParams, range(1e-6, 1e6)),
    field<&Settings::windowPolicy>("windowPolicy", dirty::kParams,
                                   words("matchVertically", "matchHorizontally", "fit", "crop", "dontConform")),
    field<&Settings::crop>("crop", dirty::kParams),
    field<&Settings::frame>("frame", dirty::kParams),
    field<&Settings::includedPurposes>("includedPurposes", dirty::kParams),
};
constexpr Field kProduct[] = {
    field<&RenderProduct::file>("file", dirty::kParams),
    field<&RenderProduct::dataType>("dataType", dirty::kParams, words("half", "float", "uint8", "uint16")),
    field<&RenderProduct::colorSpace>("colorSpace", dirty::kParams),
    field<&RenderProduct::display>("display", dirty::kParams),
    field<&RenderProduct::view>("view", dirty::kParams),
    field<&RenderProduct::look>("look", dirty::kParams),
    field<&RenderProduct::exposure>("exposure", dirty::kParams, range(-64, 64)),
    field<&RenderProduct::denoise>("denoise", dirty::kParams),
    field<&RenderProduct::camera>("camera", dirty::kParams),
    field<&RenderProduct::width>("width", dirty::kParams, range(0, 1 << 20)),
    field<&RenderProduct::height>("height", dirty::kParams, range(0, 1 << 20)),
    field<&RenderProduct::disableMotionBlur>("disableMotionBlur", dirty::kParams),
    field<&RenderProduct::disableDepthOfField>("disableDepthOfField", dirty::kParams),
};

std::string unknown(const std::string& name, const std::string& of, std::span<const Field> table,
                    std::vector<std::string> known) {
  for (const Field& field : table) known.emplace_back(field.name);
  const std::string nearest = support::NearestName(name, known);
  return of + " has no field '" + name + "'" + (nearest.empty() ? "" : "; did you mean '" + nearest + "'?");
}

/// Samples come after the values that they belong to, and categories after the instances that have them.
Fields in_order(const Fields& fields) {
  Fields sorted = fields;
  std::stable_partition(sorted.begin(), sorted.end(), [](const auto& field) {
    return !field.first.ends_with(":samples") && !field.first.starts_with("categories:");
  });
  return sorted;
}

/// Sets the rows and open fields of one kind.
template <class T, class PutOpen>
std::string put_all(std::span<const Field> table, const std::string& kind, const std::vector<std::string>& open_names,
                    const Fields& fields, T* object, const PutOpen& put_one) {
  for (const auto& [name, value] : in_order(fields)) {
    Put put = put_row(table, object, name, value);
    if constexpr (requires { object->transformSamples; })
      if (name == "transform") object->transformSamples = {};
    if (!put) put = put_one(name, value);
    if (!put) return unknown(name, (kind == "instancer" ? "an " : "a ") + kind, table, open_names);
    if (!put->empty()) return *put;
  }
  return {};
}

std::string fill(const Fields& fields, Mesh* mesh) {
  const std::string fault =
      put_all(kMesh, "mesh", {"primvars:points", "primvars:normals", "primvars:st"}, fields, mesh,
              [&](const std::string& name, const Value& value) { return put_open(mesh, name, value); });
  return fault.empty() ? finish(mesh) : fault;
}
std::string fill(const Fields& fields, InstancerDescription* instancer) {
  const std::string fault = put_all(
      kInstancer, "instancer",
      {"primvars:hydra:instanceTransforms", "primvars:hydra:instanceTranslations", "primvars:hydra:instanceRotations",
       "primvars:hydra:instanceScales"},
      fields, instancer, [&](const std::string& name, const Value& value) { return put_open(instancer, name, value); });
  return fault.empty() ? finish(instancer) : fault;
}
std::string fill(const Fields& fields, LightDescription* light) {
  return put_all(kLight, light->type.str(), LightParameterNames(), fields, light,
                 [&](const std::string& name, const Value& value) { return put_open(light, name, value); });
}
std::string fill(const Fields& fields, CameraDescription* camera) {
  return put_all(kCamera, "camera", camera_names(), fields, camera,
                 [&](const std::string& name, const Value& value) { return put_open(camera, name, value); });
}
std::string fill(const Fields& fields, Settings* settings) {
  const std::string fault =
      put_all(kSettings, "renderSettings prim", setting_names(), fields, settings,
              [&](const std::string& name, const Value& value) { return put_open(settings, name, value); });
  return fault.empty() ? finish(*settings) : fault;
}
/// The node of that name, else the first one that is a surface, else the first.
void choose_surface(const Fields& fields, const Path& id, MaterialNetwork* network) {
  Path first, surface;
  for (const auto& field : fields) {
    const size_t dot = field.first.rfind('.');
    if (dot == std::string::npos) continue;
    const Path node = node_path(id, field.first.substr(0, dot));
    const Token type = network->nodes[node].nodeTypeId;
    if (first.empty()) first = node;
    if (surface.empty() && (type == Token("AlabasterDisney") || type == Token("UsdPreviewSurface"))) surface = node;
  }
  if (network->nodes.contains(id.append("surface"))) surface = id.append("surface");
  if (surface.empty()) surface = first;
  if (!surface.empty()) network->terminals["surface"] = {surface, "out"};
}

std::string fill(const Fields& fields, const Path& id, MaterialNetwork* network) {
  const bool is_new = network->nodes.empty();
  const bool is_chosen = std::any_of(fields.begin(), fields.end(), [](const auto& f) { return f.first == "surface"; });
  const std::string fault =
      put_all({}, "material", {"surface", "displacement"}, fields, network,
              [&](const std::string& name, const Value& value) { return put_open(network, id, name, value); });
  if (!fault.empty()) return fault;
  if (is_new && !is_chosen) choose_surface(fields, id, network);
  return finish(*network);
}

template <class Description, class Store, class... Arguments>
std::string set_filled(Description description, const Fields& fields, const Store& store,
                       const Arguments&... arguments) {
  std::string fault = fill(fields, arguments..., &description);
  if (fault.empty()) store(std::move(description));
  return fault;
}

bool is_light(const Token& kind) {
  return std::any_of(std::begin(kLightTypes), std::end(kLightTypes),
                     [&](const char* type) { return kind == Token(type); });
}

template <class T>
DirtyBits row_difference(std::span<const Field> table, const T& a, const T& b) {
  DirtyBits bits = dirty::kClean;
  for (const Field& field : table)
    if ((bits & field.dirty) != field.dirty && !field.equal(&a, &b)) bits |= field.dirty;
  return bits;
}

}  // namespace

const std::span<const Field> kProductFields = kProduct;

Put put_row(std::span<const Field> table, void* object, std::string_view name, const Value& value) {
  for (const Field& field : table)
    if (name == field.name) return field.put(field, object, value);
  return std::nullopt;
}

void get_rows(std::span<const Field> table, const void* object, const std::string& prefix, Fields* fields) {
  for (const Field& field : table)
    if (Value value = field.get(field, object); !value.empty())
      fields->emplace_back(prefix + field.name, std::move(value));
}

namespace {
template <class T, class... Arguments>
Fields all_fields(std::span<const Field> table, const T& object, const Arguments&... arguments) {
  Fields fields;
  get_rows(table, &object, "", &fields);
  get_open(object, arguments..., &fields);
  return fields;
}
}  // namespace

Fields GetFields(const MeshDescription& mesh) {
  return all_fields(kMesh, mesh);
}
Fields GetFields(const InstancerDescription& instancer) {
  return all_fields(kInstancer, instancer);
}
Fields GetFields(const LightDescription& light) {
  return all_fields(kLight, light);
}
Fields GetFields(const CameraDescription& camera) {
  return all_fields(kCamera, camera);
}
Fields GetFields(const RenderSettingsDescription& settings) {
  return all_fields(kSettings, settings);
}
Fields GetFields(const MaterialNetwork& network, const Path& id) {
  return all_fields({}, network, id);
}

SetResult SetPrim(RetainedSceneDelegate* scene, const Path& path, const Token& kind, const Fields& fields) {
  if (path.empty()) return {true, "the path is empty"};
  if (kind == Token("mesh"))
    return {true, set_filled(Mesh(), fields, [&](auto made) { scene->SetMesh(path, std::move(made)); })};
  if (kind == Token("instancer"))
    return {true,
            set_filled(InstancerDescription(), fields, [&](auto made) { scene->SetInstancer(path, std::move(made)); })};
  if (kind == Token("material"))
    return {true, set_filled(
                      MaterialNetwork(), fields, [&](auto made) { scene->SetMaterial(path, std::move(made)); }, path)};
  if (kind == Token("camera"))
    return {true, set_filled(CameraDescription(), fields, [&](auto made) { scene->SetCamera(path, std::move(made)); })};
  if (kind == Token("renderSettings"))
    return {true, set_filled(Settings(), fields, [&](auto made) { scene->SetRenderSettings(path, std::move(made)); })};
  if (is_light(kind)) {
    LightDescription light;
    light.type = kind;
    return {true, set_filled(light, fields, [&](auto made) { scene->SetLight(path, std::move(made)); })};
  }
  std::vector<std::string> kinds = {"mesh", "instancer", "material", "camera", "renderSettings"};
  kinds.insert(kinds.end(), std::begin(kLightTypes), std::end(kLightTypes));
  const std::string nearest = support::NearestName(kind.str(), kinds);
  return {true, "there is no kind of prim '" + kind.str() + "'" +
                    (nearest.empty() ? "" : "; did you mean '" + nearest + "'?")};
}

SetResult EditPrim(RetainedSceneDelegate* scene, const Path& path, const Fields& fields) {
  const auto held = [&](const auto& map) {
    const auto found = map.find(path);
    return found == map.end() ? nullptr : &found->second;
  };
  if (const auto* mesh = held(scene->GetMeshes()))
    return {true, set_filled(*mesh, fields, [&](auto made) { scene->SetMesh(path, std::move(made)); })};
  if (const auto* instancer = held(scene->GetInstancers()))
    return {true, set_filled(*instancer, fields, [&](auto made) { scene->SetInstancer(path, std::move(made)); })};
  if (const auto* network = held(scene->GetMaterials()))
    return {true, set_filled(
                      *network, fields, [&](auto made) { scene->SetMaterial(path, std::move(made)); }, path)};
  if (const auto* light = held(scene->GetLights()))
    return {true, set_filled(*light, fields, [&](auto made) { scene->SetLight(path, std::move(made)); })};
  if (const auto* camera = held(scene->GetCameras()))
    return {true, set_filled(*camera, fields, [&](auto made) { scene->SetCamera(path, std::move(made)); })};
  if (const auto* settings = held(scene->GetAllRenderSettings()))
    return {true, set_filled(*settings, fields, [&](auto made) { scene->SetRenderSettings(path, std::move(made)); })};
  return {false, "there is no prim " + path.str()};
}

std::string ReadCamera(const Fields& fields, CameraDescription* camera) {
  return fill(fields, camera);
}

namespace {

bool same_primvar(const Mesh& a, const Mesh& b, const Token& name) {
  const auto x = a.primvars.find(name), y = b.primvars.find(name);
  if (x == a.primvars.end() || y == b.primvars.end()) return x == a.primvars.end() && y == b.primvars.end();
  return x->second == y->second;
}

bool same_primvars_but(const Mesh& a, const Mesh& b, const Token& left_out) {
  auto others = [&](const Mesh& mesh) { return mesh.primvars.size() - mesh.primvars.count(left_out); };
  if (others(a) != others(b)) return false;
  for (const auto& [name, value] : a.primvars)
    if (!(name == left_out) && !same_primvar(a, b, name)) return false;
  return true;
}

}  // namespace

// A member that has no row yet marks all.
DirtyBits difference(const Mesh& a, const Mesh& b) {
  DirtyBits bits = row_difference(kMesh, a, b);
  if (!(a.topology.geomSubsets == b.topology.geomSubsets) ||
      !(a.topology.invisiblePoints == b.topology.invisiblePoints))
    bits |= dirty::kTopology;
  if (!same_primvar(a, b, "points") || !(a.primvarSamples == b.primvarSamples)) bits |= dirty::kPoints;
  if (!same_primvar(a, b, "normals")) bits |= dirty::kNormals | dirty::kPrimvar;
  if (!same_primvars_but(a, b, "points")) bits |= dirty::kPrimvar;
  return bits == dirty::kClean && !(a == b) ? dirty::kAll : bits;
}

DirtyBits difference(const InstancerDescription& a, const InstancerDescription& b) {
  DirtyBits bits = row_difference(kInstancer, a, b);
  if (!(a.primvars == b.primvars) || !(a.primvarSamples == b.primvarSamples)) bits |= dirty::kPrimvar;
  if (!(a.categories == b.categories)) bits |= dirty::kCategories;
  return bits;
}

DirtyBits difference(const LightDescription& a, const LightDescription& b) {
  const bool same = a.parameters == b.parameters;
  return row_difference(kLight, a, b) | (same ? dirty::kClean : dirty::kParams | dirty::kResource);
}

DirtyBits difference(const CameraDescription& a, const CameraDescription& b) {
  const bool same = a.parameters == b.parameters;
  return row_difference(kCamera, a, b) | (same ? dirty::kClean : dirty::kParams | dirty::kResource);
}

DirtyBits difference(const MaterialNetwork& a, const MaterialNetwork& b) {
  return a == b ? dirty::kClean : dirty::kResource | dirty::kParams;
}
DirtyBits difference(const RenderBufferDescriptor& a, const RenderBufferDescriptor& b) {
  return a == b ? dirty::kClean : dirty::kDescription;
}
DirtyBits difference(const Settings& a, const Settings& b) {
  return a == b ? dirty::kClean : dirty::kParams;
}

}  // namespace alabaster::hd::host
