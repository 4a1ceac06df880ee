#include "delegate/host/scene_fields.h"

#include <algorithm>
#include <tuple>

#include "delegate/host/open_fields.h"
#include "delegate/support/mesh_words.h"
#include "delegate/support/nearest_name.h"
#include "delegate/support/scene_kinds.h"

namespace alabaster::hd::host {
namespace {

constexpr std::string_view kLights = "light";
using Mesh = MeshDescription;
constexpr Field kMesh[] = {
    field<&Mesh::topology, &MeshTopology::scheme>("scheme", dirty::kTopology,
                                                  "Subdivision scheme of the surface; none draws the control mesh.",
                                                  words(support::kSubdivisionSchemes)),
    field<&Mesh::topology, &MeshTopology::orientation>(
        "orientation", dirty::kTopology, "Winding of faces as seen from their front.", words(support::kOrientations)),
    field<&Mesh::topology, &MeshTopology::faceVertexCounts>("faceVertexCounts", dirty::kTopology,
                                                            "The number of vertices of each face."),
    field<&Mesh::topology, &MeshTopology::faceVertexIndices>(
        "faceVertexIndices", dirty::kTopology, "The vertices of all faces, one after the other: places in the points."),
    field<&Mesh::topology, &MeshTopology::holeIndices>("holeIndices", dirty::kTopology,
                                                       "Faces that are holes of a subdivision surface."),
    field<&Mesh::topology, &MeshTopology::invisibleFaces>(
        "invisibleFaces", dirty::kTopology,
        "Faces that are not drawn. Unlike holes they leave the surface around them as it is."),
    field<&Mesh::subdivTags, &SubdivTags::interpolateBoundary>(
        "interpolateBoundary", dirty::kSubdivTags,
        "Rule of the subdivision surface at its boundary. The default is edgeAndCorner.",
        words(support::kBoundaryRules)),
    field<&Mesh::subdivTags, &SubdivTags::faceVaryingLinearInterpolation>(
        "faceVaryingLinearInterpolation", dirty::kSubdivTags,
        "Where faceVarying primvars are interpolated linearly. The default is cornersPlus1.",
        words(support::kFaceVaryingRules)),
    field<&Mesh::subdivTags, &SubdivTags::creaseMethod>(
        "creaseMethod", dirty::kSubdivTags, "How the sharpness of creases varies along them. The default is uniform.",
        words(support::kCreaseMethods)),
    field<&Mesh::subdivTags, &SubdivTags::triangleSubdivision>(
        "triangleSubdivision", dirty::kSubdivTags,
        "Weights of Catmull-Clark subdivision at triangles. The default is catmullClark.",
        words(support::kTriangleSubdivisions)),
    field<&Mesh::subdivTags, &SubdivTags::creaseIndices>("creaseIndices", dirty::kSubdivTags,
                                                         "The vertices of all creases, one after the other."),
    field<&Mesh::subdivTags, &SubdivTags::creaseLengths>("creaseLengths", dirty::kSubdivTags,
                                                         "The number of vertices of each crease."),
    field<&Mesh::subdivTags, &SubdivTags::creaseWeights>("creaseWeights", dirty::kSubdivTags,
                                                         "Sharpness of each crease, or of each of its edges."),
    field<&Mesh::subdivTags, &SubdivTags::cornerIndices>("cornerIndices", dirty::kSubdivTags,
                                                         "Vertices that are corners."),
    field<&Mesh::subdivTags, &SubdivTags::cornerWeights>("cornerWeights", dirty::kSubdivTags,
                                                         "Sharpness of each corner."),
    field<&Mesh::displayStyle, &DisplayStyle::refineLevel>(
        "refineLevel", dirty::kDisplayStyle, "Subdivision levels; 0 draws the control mesh.", range(0, kMaxRefineLevel))
        .in("levels"),
    field<&Mesh::transform>(
        "transform", dirty::kTransform,
        "Object space to world space, or to the space of the instancer. Setting it takes away its samples."),
    field<&Mesh::transformSamples>("transform:samples", dirty::kTransform, "Matrices at times, of what moves."),
    field<&Mesh::visible>("visible", dirty::kVisibility, "False: the mesh is not drawn."),
    field<&Mesh::doubleSided>("doubleSided", dirty::kDoubleSided,
                              "False: rays that hit the back of a face pass through, unless its material's sides "
                              "decides."),
    field<&Mesh::cullStyle>(
        "cullStyle", dirty::kCullStyle,
        "Sides of faces that are not shown. dontCare leaves them to doubleSided; back and front hide them from the "
        "camera alone; backUnlessDoubleSided and frontUnlessDoubleSided do so where the mesh is single-sided.",
        words("dontCare", "nothing", "back", "front", "backUnlessDoubleSided", "frontUnlessDoubleSided")),
    field<&Mesh::material>("material", dirty::kMaterialId,
                           "Path of a material. Without one the mesh has the default material."),
    field<&Mesh::instancer>("instancer", dirty::kInstancer | dirty::kInstanceIndex,
                            "Path of the instancer that draws the mesh."),
    field<&Mesh::renderTag>("renderTag", dirty::kRenderTag,
                            "geometry, render, proxy, guide or hidden: passes draw the meshes whose tag they select."),
    field<&Mesh::categories>("categories", dirty::kCategories,
                             "Names that the parameters lightLink and shadowLink of lights may give."),
};
constexpr Field kInstancer[] = {
    field<&InstancerDescription::transform>("transform", dirty::kTransform,
                                            "Applies after those of the instances. Setting it takes away its samples."),
    field<&InstancerDescription::transformSamples>("transform:samples", dirty::kTransform,
                                                   "Matrices at times, of what moves."),
    field<&InstancerDescription::parent>("parent", dirty::kInstancer | dirty::kInstanceIndex,
                                         "Path of the instancer that draws this one."),
};
constexpr Field kLight[] = {
    field<&LightDescription::transform>("transform", dirty::kTransform, "Light space to world space."),
    field<&LightDescription::visible>("visible", dirty::kVisibility, "False: the light is off."),
};
constexpr Field kCamera[] = {
    field<&CameraDescription::transform>(
        "transform", dirty::kTransform,
        "Camera space to world space. The camera looks along -z, with y up. Setting it takes away its samples."),
    field<&CameraDescription::transformSamples>("transform:samples", dirty::kTransform,
                                                "Matrices at times, of what moves."),
};
using Settings = RenderSettingsDescription;
constexpr Field kSettings[] = {
    field<&Settings::camera>("camera", dirty::kParams, "Path of the camera."),
    field<&Settings::width>("width", dirty::kParams, "Width of the picture.", range(1, 1 << 20)).in("pixels"),
    field<&Settings::height>("height", dirty::kParams, "Height of the picture.", range(1, 1 << 20)).in("pixels"),
    field<&Settings::pixelAspectRatio>("pixelAspectRatio", dirty::kParams, "Width of a pixel over its height.",
                                       range(1e-6, 1e6)),
    field<&Settings::windowPolicy>("windowPolicy", dirty::kParams,
                                   "Adapts the camera's film to a picture of another shape.",
                                   words("matchVertically", "matchHorizontally", "fit", "crop", "dontConform")),
    field<&Settings::crop>(
        "crop", dirty::kParams,
        "The part of the picture to render: minX, minY, maxX, maxY, y-down, half open. Without it, all of it.")
        .in("pixels"),
    field<&Settings::frame>("frame", dirty::kParams,
                            "Number of the frame: selects its noise, and stands in the metadata of files.")
        .in("frames"),
    field<&Settings::includedPurposes>("includedPurposes", dirty::kParams,
                                       "Purposes of USD whose meshes are drawn: default, render, proxy, guide."),
};
constexpr Field kProduct[] = {
    field<&RenderProduct::file>("file", dirty::kParams, "The file to write: .exr, .png, .tif or .jpg."),
    field<&RenderProduct::dataType>(
        "dataType", dirty::kParams,
        "Type of the numbers. The default is half for .exr, else uint8; .jpg takes uint8 alone.",
        words("half", "float", "uint8", "uint16")),
    field<&RenderProduct::colorSpace>(
        "colorSpace", dirty::kParams,
        "Colour space of a file of scene-referred values. Without it, the rendering space for .exr."),
    field<&RenderProduct::display>(
        "display", dirty::kParams,
        "OpenColorIO display of a file of display values. Without it, the default display for .png, .tif and .jpg."),
    field<&RenderProduct::view>("view", dirty::kParams,
                                "OpenColorIO view of the display. Without it, its default view."),
    field<&RenderProduct::look>("look", dirty::kParams, "OpenColorIO look before the view."),
    field<&RenderProduct::exposure>("exposure", dirty::kParams, "Exposure of a file of display values.", range(-64, 64))
        .in("stops"),
    field<&RenderProduct::denoise>("denoise", dirty::kParams,
                                   "Denoises the file: an .exr has the denoised layer beside color, others in its "
                                   "place. Without it, the setting denoise decides."),
    field<&RenderProduct::camera>("camera", dirty::kParams, "Path of a camera of its own."),
    field<&RenderProduct::width>("width", dirty::kParams, "A width of its own; 0: that of the settings.",
                                 range(0, 1 << 20))
        .in("pixels"),
    field<&RenderProduct::height>("height", dirty::kParams, "A height of its own; 0: that of the settings.",
                                  range(0, 1 << 20))
        .in("pixels"),
    field<&RenderProduct::disableMotionBlur>("disableMotionBlur", dirty::kParams,
                                             "True: the scene stands still at the time of the frame."),
    field<&RenderProduct::disableDepthOfField>("disableDepthOfField", dirty::kParams, "True: the camera is a pinhole."),
};

/// Samples come after the values that they belong to, and categories after the instances that have them.
Fields in_order(const Fields& fields) {
  Fields sorted = fields;
  std::stable_partition(sorted.begin(), sorted.end(), [](const auto& field) {
    return !field.first.ends_with(":samples") && !field.first.starts_with("categories:");
  });
  return sorted;
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

using Kinds = std::tuple<Mesh, InstancerDescription, MaterialNetwork, LightDescription, CameraDescription, Settings>;
template <class T, class... Types>
constexpr size_t place_of(const std::tuple<Types...>*) {
  constexpr bool kIsT[] = {std::is_same_v<T, Types>...};
  return static_cast<size_t>(std::find(std::begin(kIsT), std::end(kIsT), true) - std::begin(kIsT));
}
template <class T>
const Kind& kind_of() {
  return kinds()[place_of<T>(static_cast<Kinds*>(nullptr))];
}

std::vector<std::string> parts_of(std::string_view name) {
  std::vector<std::string> parts(1);
  for (const char c : name)
    if (c == ':')
      parts.emplace_back();
    else
      parts.back() += c;
  return parts;
}

/// A pattern with the parts of `name` in the places of its capitals; empty if it has another number of parts.
std::string filled_pattern(std::string_view pattern, const std::string& name) {
  const std::vector<std::string> wanted = parts_of(pattern), given = parts_of(name);
  std::string filled;
  for (size_t i = 0; i < wanted.size() && wanted.size() == given.size(); ++i)
    filled += (i > 0 ? ":" : "") + (is_pattern(wanted[i]) ? given[i] : wanted[i]);
  return filled == name ? std::string() : filled;
}

/// "; did you mean 'surface.baseColor'?" of the parameter that a name without its node means; empty if it means none.
std::string near_input(const std::string& name, const Path& id, const MaterialNetwork& network) {
  const std::string input = support::NearestName(name, parameter_names("disney_material"));
  const auto surface = network.terminals.find("surface");
  const std::string node = surface == network.terminals.end() ? "surface" : node_name(id, surface->second.upstreamNode);
  return input.empty() ? input : "; did you mean '" + node + "." + input + "'?";
}

template <class T>
std::string unknown(const std::string& name, const Path& id, const T& object) {
  const Kind& kind = kind_of<T>();
  std::string label = kind.name;
  if constexpr (std::is_same_v<T, LightDescription>) label = object.type.str();
  if constexpr (std::is_same_v<T, Settings>) label += " prim";
  std::vector<std::string> known;
  if (!kind.fields.empty()) known = parameter_names(kind.parameters);  // those of materials belong to nodes
  for (const auto& table : {kind.fields, kind.open})
    for (const Field& field : table)
      if (const std::string one = is_pattern(field.name) ? filled_pattern(field.name, name) : field.name; !one.empty())
        known.push_back(one);
  if constexpr (std::is_same_v<T, Settings>)
    for (const Field& field : kProductFields)
      known.push_back(filled_pattern("products:N:" + std::string(field.name), name));
  std::string near = support::DidYouMean(name, known);
  if constexpr (std::is_same_v<T, MaterialNetwork>)
    if (near.empty()) near = near_input(name, id, object);
  return (label == "instancer" ? "an " : "a ") + label + " has no field '" + name + "'" + near;
}

template <class T>
FieldResult set_field(const Path& id, const std::string& name, const Value& value, T* object) {
  if (const FieldResult result = set_row(kind_of<T>().fields, object, name, value)) {
    if constexpr (requires { object->transformSamples; })
      if (name == "transform") object->transformSamples = {};
    return result;
  }
  if constexpr (std::is_same_v<T, MaterialNetwork>)
    return set_open_field(object, id, name, value);
  else
    return set_open_field(object, name, value);
}

/// Sets the fields of the prim `id`, or of a camera without an id.
template <class T>
std::string fill_fields(const Fields& fields, const Path& id, T* object) {
  [[maybe_unused]] bool chooses =
      std::none_of(fields.begin(), fields.end(), [](const auto& field) { return field.first == "surface"; });
  if constexpr (std::is_same_v<T, MaterialNetwork>) chooses = chooses && object->nodes.empty();
  std::vector<GeomSubset> none, *subsets = &none;
  if constexpr (std::is_same_v<T, Mesh>) subsets = &object->topology.geomSubsets;
  SubsetFields of_subsets(subsets);
  for (const auto& [name, value] : in_order(fields)) {
    const bool is_of_subset = std::is_same_v<T, Mesh> && name.starts_with("subsets:");
    const FieldResult result = is_of_subset ? of_subsets.set(name, value) : set_field(id, name, value, object);
    if (!result) return unknown(name, id, *object);
    if (!result->empty()) return *result;
  }
  of_subsets.finish();
  if constexpr (std::is_same_v<T, MaterialNetwork>)
    if (chooses) choose_surface(fields, id, object);
  return finish(*object);
}

template <class T>
T description_of(void (RetainedSceneDelegate::*set)(const Path&, T));

template <class T>
DirtyBits row_difference(const T& a, const T& b) {
  DirtyBits bits = dirty::kClean;
  for (const Field& field : kind_of<T>().fields)
    if ((bits & field.dirty) != field.dirty && !field.equal(&a, &b)) bits |= field.dirty;
  return bits;
}

}  // namespace

const std::span<const Field> kProductFields = kProduct;

std::span<const Kind> kinds() {
  static const std::vector<Kind> all = {
      // in the order of Kinds
      {"mesh", kMesh, kOpenOfMeshes, "mesh"},
      {"instancer", kInstancer, kOpenOfInstancers, ""},
      {"material", {}, kOpenOfMaterials, "disney_material"},
      {"light", kLight, {}, "lights"},
      {"camera", kCamera, {}, "camera"},
      {"renderSettings", kSettings, kOpenOfSettings, "render_settings"},
  };
  return all;
}

FieldResult set_row(std::span<const Field> table, void* object, std::string_view name, const Value& value) {
  for (const Field& field : table)
    if (name == field.name) return field.put(field, object, value);
  return std::nullopt;
}

void append_rows(std::span<const Field> table, const void* object, const std::string& prefix, Fields* fields) {
  for (const Field& field : table)
    if (!field.equal(object, field.defaults())) fields->emplace_back(prefix + field.name, field.get(field, object));
}

namespace {
template <class T, class... Id>
Fields all_fields(const T& object, const Id&... id) {
  Fields fields;
  append_rows(kind_of<T>().fields, &object, "", &fields);
  append_open_fields(object, id..., &fields);
  return fields;
}
}  // namespace

Fields GetFields(const MeshDescription& mesh) {
  return all_fields(mesh);
}
Fields GetFields(const InstancerDescription& instancer) {
  return all_fields(instancer);
}
Fields GetFields(const LightDescription& light) {
  return all_fields(light);
}
Fields GetFields(const CameraDescription& camera) {
  return all_fields(camera);
}
Fields GetFields(const RenderSettingsDescription& settings) {
  return all_fields(settings);
}
Fields GetFields(const MaterialNetwork& network, const Path& id) {
  return all_fields(network, id);
}

SetResult SetPrim(RetainedSceneDelegate* scene, const Path& path, const Token& kind, const Fields& fields) {
  if (path.empty()) return {true, "the path is empty"};
  std::vector<std::string> known(std::begin(kLightTypes), std::end(kLightTypes));
  const bool is_light = std::find(known.begin(), known.end(), kind.str()) != known.end();
  for (const Kind& one : kinds())
    if (one.name != kLights) known.emplace_back(one.name);
  SetResult result{true, "there is no kind of prim '" + kind.str() + "'" + support::DidYouMean(kind.str(), known)};
  support::for_each_kind<RetainedSceneDelegate>([&](auto, auto set) {
    using T = decltype(description_of(set));
    const std::string_view name = kind_of<T>().name;
    if (name == kLights ? !is_light : name != kind.str()) return;
    T made{};
    if constexpr (std::is_same_v<T, LightDescription>) made.type = kind;
    result.fault = fill_fields(fields, path, &made);
    if (result.fault.empty()) (scene->*set)(path, std::move(made));
  });
  return result;
}

SetResult EditPrim(RetainedSceneDelegate* scene, const Path& path, const Fields& fields) {
  SetResult result{false, {}};
  support::for_each_kind<RetainedSceneDelegate>([&](auto get, auto set) {
    const auto& all = (scene->*get)();
    const auto found = all.find(path);
    if (result.found || found == all.end()) return;
    auto made = found->second;
    result = {true, fill_fields(fields, path, &made)};
    if (result.fault.empty()) (scene->*set)(path, std::move(made));
  });
  if (!result.found) result.fault = NoSuchPrim(*scene, path);
  return result;
}

std::vector<std::pair<Path, Token>> ListPrims(const RetainedSceneDelegate& scene) {
  std::vector<std::pair<Path, Token>> prims;
  support::for_each_kind<RetainedSceneDelegate>([&](auto get, auto set) {
    using T = decltype(description_of(set));
    for (const auto& [path, prim] : (scene.*get)())
      if constexpr (std::is_same_v<T, LightDescription>)
        prims.emplace_back(path, prim.type);
      else
        prims.emplace_back(path, kind_of<T>().name);
  });
  return prims;
}

std::string NoSuchPrim(const RetainedSceneDelegate& scene, const Path& path) {
  std::vector<std::string> known;
  for (const auto& prim : ListPrims(scene)) known.push_back(prim.first.str());
  return "there is no prim " + path.str() + support::DidYouMean(path.str(), known);
}

std::string ReadCamera(const Fields& fields, CameraDescription* camera) {
  return fill_fields(fields, {}, camera);
}
std::string ReadSettings(const Fields& fields, RenderSettingsDescription* settings) {
  return fill_fields(fields, {}, settings);
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
  DirtyBits bits = row_difference(a, b);
  if (!(a.topology.geomSubsets == b.topology.geomSubsets) ||
      !(a.topology.invisiblePoints == b.topology.invisiblePoints))
    bits |= dirty::kTopology;
  if (!same_primvar(a, b, "points") || !(a.primvarSamples == b.primvarSamples)) bits |= dirty::kPoints;
  if (!same_primvar(a, b, "normals")) bits |= dirty::kNormals | dirty::kPrimvar;
  if (!same_primvars_but(a, b, "points")) bits |= dirty::kPrimvar;
  return bits == dirty::kClean && !(a == b) ? dirty::kAll : bits;
}

DirtyBits difference(const InstancerDescription& a, const InstancerDescription& b) {
  DirtyBits bits = row_difference(a, b);
  if (!(a.primvars == b.primvars) || !(a.primvarSamples == b.primvarSamples)) bits |= dirty::kPrimvar;
  if (!(a.categories == b.categories)) bits |= dirty::kCategories;
  return bits;
}

DirtyBits difference(const LightDescription& a, const LightDescription& b) {
  const bool same = a.parameters == b.parameters;
  return row_difference(a, b) | (same ? dirty::kClean : dirty::kParams | dirty::kResource);
}

DirtyBits difference(const CameraDescription& a, const CameraDescription& b) {
  const bool same = a.parameters == b.parameters;
  return row_difference(a, b) | (same ? dirty::kClean : dirty::kParams | dirty::kResource);
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
