#include "delegate/host/scene_fields.h"

#include <algorithm>
#include <array>

#include "delegate/host/open_fields.h"
#include "delegate/host/product_plan.h"
#include "delegate/host/product_writer.h"
#include "delegate/support/lookup.h"
#include "delegate/support/mesh_words.h"
#include "delegate/support/nearest_name.h"

namespace alabaster::hd::host {
namespace {

template <size_t kFirst, size_t kSecond>
constexpr std::array<Field, kFirst + kSecond> joined(const Field (&first)[kFirst], const Field (&second)[kSecond]) {
  std::array<Field, kFirst + kSecond> all{};
  std::copy(std::begin(first), std::end(first), all.begin());
  std::copy(std::begin(second), std::end(second), all.begin() + kFirst);
  return all;
}

using Mesh = MeshDescription;
constexpr Field kFaces[] = {
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
};
constexpr Field kCurves[] = {
    field<&Mesh::curves, &BasisCurvesTopology::type>("type", dirty::kTopology,
                                                     "linear: straight from point to point. cubic: by the basis.",
                                                     words(support::kCurveTypes)),
    field<&Mesh::curves, &BasisCurvesTopology::basis>("basis", dirty::kTopology, "Basis of cubic curves.",
                                                      words(support::kCurveBases)),
    field<&Mesh::curves, &BasisCurvesTopology::wrap>(
        "wrap", dirty::kTopology,
        "periodic: curves are closed. pinned: those of bspline and catmullRom begin and end in their end points.",
        words(support::kCurveWraps)),
    field<&Mesh::curves, &BasisCurvesTopology::curveVertexCounts>(
        "curveVertexCounts", dirty::kTopology, "The number of points of each curve. They stand one after the other."),
};
// Of all that is drawn as a mesh.
constexpr Field kRprim[] = {
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
constexpr auto kMesh = joined(kFaces, kRprim);
constexpr auto kBasisCurves = joined(kCurves, kRprim);
Kind row_of(const Mesh& defaults) {
  std::span<const Field> fields = kRprim;
  if (defaults.type == Token("mesh")) fields = kMesh;
  if (defaults.type == Token("basisCurves")) fields = kBasisCurves;
  return {defaults.type.str().c_str(), fields,  open_rows(defaults), "mesh", dirty::kAll,
          &RenderIndex::InsertRprim,   defaults};
}
constexpr Field kInstancer[] = {
    field<&InstancerDescription::transform>("transform", dirty::kTransform,
                                            "Applies after those of the instances. Setting it takes away its samples."),
    field<&InstancerDescription::transformSamples>("transform:samples", dirty::kTransform,
                                                   "Matrices at times, of what moves."),
    field<&InstancerDescription::parent>("parent", dirty::kInstancer | dirty::kInstanceIndex,
                                         "Path of the instancer that draws this one."),
};
Kind row_of(const InstancerDescription& defaults) {
  return {"instancer", kInstancer, open_rows(defaults), "", dirty::kClean, nullptr, defaults};
}
Kind row_of(const MaterialNetwork& defaults) {
  return {"material",
          {},
          open_rows(defaults),
          "disney_material",
          dirty::kResource | dirty::kParams,
          &RenderIndex::InsertSprim,
          defaults};
}
constexpr Field kLight[] = {
    field<&LightDescription::transform>("transform", dirty::kTransform,
                                        "Light space to world space. Setting it takes away its samples."),
    field<&LightDescription::transformSamples>("transform:samples", dirty::kTransform,
                                               "Matrices at times, of what moves."),
    field<&LightDescription::visible>("visible", dirty::kVisibility, "False: the light is off."),
};
Kind row_of(const LightDescription& defaults) {
  return {"light", kLight, {}, "lights", dirty::kAll, &RenderIndex::InsertSprim, defaults};
}
constexpr Field kCamera[] = {
    field<&CameraDescription::transform>(
        "transform", dirty::kTransform,
        "Camera space to world space. The camera looks along -z, with y up. Setting it takes away its samples."),
    field<&CameraDescription::transformSamples>("transform:samples", dirty::kTransform,
                                                "Matrices at times, of what moves."),
};
Kind row_of(const CameraDescription& defaults) {
  return {"camera", kCamera, open_rows(defaults), "camera", dirty::kAll, &RenderIndex::InsertSprim, defaults};
}
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
Kind row_of(const Settings& defaults) {
  return {"renderSettings",          kSettings, open_rows(defaults), "render_settings", dirty::kParams,
          &RenderIndex::InsertBprim, defaults};
}
Kind row_of(const RenderBufferDescriptor& defaults) {
  return {"renderBuffer", {}, {}, "", dirty::kDescription, &RenderIndex::InsertBprim, defaults};
}

template <size_t... kPlaces>
std::vector<Kind> rows_of(std::index_sequence<kPlaces...>) {
  std::vector<Kind> all{row_of(std::variant_alternative_t<kPlaces, PrimDescription>())...};
  for (size_t type = 1; type < std::size(kRprimTypes); ++type) {
    Mesh defaults;
    defaults.type = kRprimTypes[type];
    all.insert(all.begin() + static_cast<std::ptrdiff_t>(type), row_of(defaults));
  }
  return all;
}
// The types of meshes, then the rest of PrimDescription in its order.
std::span<const Kind> all_kinds() {
  static const auto all = rows_of(std::make_index_sequence<std::variant_size_v<PrimDescription>>());
  return all;
}
constexpr Field kProduct[] = {
    field<&RenderProduct::file>("file", dirty::kParams, "The file to write: .exr, .png, .tif or .jpg."),
    field<&RenderProduct::dataType>(
        "dataType", dirty::kParams,
        "Type of the numbers. The default is half for .exr, else uint8; .jpg takes uint8 alone.",
        words("half", "float", "uint8", "uint16")),
    field<&RenderProduct::compression>(
        "compression", dirty::kParams,
        "Compression of an .exr; zip by default. pxr24, b44, b44a, dwaa and dwab lose bits: a file with them holds no "
        "ids, depths, places or Cryptomatte.",
        words(kCompressions)),
    field<&RenderProduct::tiles>("tiles", dirty::kParams,
                                 "Side of the tiles of an .exr, 16 to 256; 0: it has scanlines.", range(0, kMostTile))
        .in("pixels"),
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

std::string unknown(const std::string& name, const Path& id, const PrimDescription& prim) {
  const Kind& kind = kind_of(prim);
  const auto* material = std::get_if<MaterialNetwork>(&prim);
  const bool is_settings = std::holds_alternative<Settings>(prim);
  const std::string label = is_settings ? "renderSettings prim" : TypeOf(prim).str();
  std::vector<std::string> known;
  if (!material) known = parameter_names(kind.parameters);  // those of materials belong to nodes
  for (const auto& table : {kind.fields, kind.open})
    for (const Field& field : table)
      if (const std::string one = is_pattern(field.name) ? filled_pattern(field.name, name) : field.name; !one.empty())
        known.push_back(one);
  if (is_settings)
    for (const Field& field : kProductFields)
      known.push_back(filled_pattern("products:N:" + std::string(field.name), name));
  std::string near = support::DidYouMean(name, known);
  if (material && near.empty()) near = near_input(name, id, *material);
  return (label == "instancer" ? "an " : "a ") + label + " has no field '" + name + "'" + near;
}

FieldResult set_field(const Path& id, const std::string& name, const Value& value, PrimDescription* prim) {
  const auto set = [&](auto& object) {
    FieldResult result = set_row(kind_of(*prim).fields, &object, name, value);
    if constexpr (requires { object.transformSamples; })
      if (result && name == "transform") object.transformSamples = {};
    return result;
  };
  const FieldResult result = std::visit(set, *prim);
  return result ? result : set_open_field(prim, id, name, value);
}

/// Sets the fields of the prim `id`, or of a camera or settings without an id.
std::string fill_fields(const Fields& fields, const Path& id, PrimDescription* prim) {
  auto* const mesh = std::get_if<Mesh>(prim);
  auto* const material = std::get_if<MaterialNetwork>(prim);
  const bool chooses = material && material->nodes.empty() &&
                       std::none_of(fields.begin(), fields.end(), [](const auto& f) { return f.first == "surface"; });
  std::vector<GeomSubset> none;
  SubsetFields of_subsets(mesh ? &mesh->topology.geomSubsets : &none);
  for (const auto& [name, value] : in_order(fields)) {
    const bool is_of_subset = mesh && mesh->type == Token("mesh") && name.starts_with("subsets:");
    const FieldResult result = is_of_subset ? of_subsets.set(name, value) : set_field(id, name, value, prim);
    if (!result) return unknown(name, id, *prim);
    if (!result->empty()) return *result;
  }
  of_subsets.finish();
  if (chooses) choose_surface(fields, id, material);
  return finish(*prim);
}

template <class T>
std::string read_fields(const Fields& fields, T* object) {
  PrimDescription prim = *object;
  std::string fault = fill_fields(fields, {}, &prim);
  *object = std::get<T>(std::move(prim));
  return fault;
}

}  // namespace

const std::span<const Field> kProductFields = kProduct;

std::span<const Kind> kinds() {
  return all_kinds().first(all_kinds().size() - 1);  // the last is that of render buffers
}
const Kind& kind_of(const PrimDescription& prim) {
  const auto* const mesh = std::get_if<Mesh>(&prim);
  if (!mesh) return all_kinds()[prim.index() + std::size(kRprimTypes) - 1];
  const auto type = std::find(std::begin(kRprimTypes), std::end(kRprimTypes), mesh->type.str());
  return all_kinds()[type == std::end(kRprimTypes) ? 0 : static_cast<size_t>(type - std::begin(kRprimTypes))];
}
std::string_view KindOf(const PrimDescription& prim) {
  return std::holds_alternative<Mesh>(prim) ? kRprimTypes[0] : kind_of(prim).name;
}
Token TypeOf(const PrimDescription& prim) {
  if (const auto* light = std::get_if<LightDescription>(&prim)) return light->type;
  return std::holds_alternative<RenderBufferDescriptor>(prim) ? Token() : Token(kind_of(prim).name);
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

Fields GetFields(const Path& path, const PrimDescription& prim) {
  Fields fields;
  std::visit([&](const auto& object) { append_rows(kind_of(prim).fields, &object, "", &fields); }, prim);
  append_open_fields(prim, path, &fields);
  return fields;
}

SetResult SetPrim(RetainedSceneDelegate* scene, const Path& path, const Token& kind, const Fields& fields) {
  if (path.empty()) return {true, "the path is empty"};
  std::vector<std::string> known(std::begin(kLightTypes), std::end(kLightTypes));
  const bool is_light = std::find(known.begin(), known.end(), kind.str()) != known.end();
  for (const Kind& one : kinds()) {
    PrimDescription made = one.defaults;
    auto* light = std::get_if<LightDescription>(&made);
    if (!light) known.emplace_back(one.name);
    if (light ? !is_light : one.name != kind.str()) continue;
    if (light) light->type = kind;
    SetResult result{true, fill_fields(fields, path, &made)};
    if (result.fault.empty()) scene->Set(path, std::move(made));
    return result;
  }
  return {true, "there is no kind of prim '" + kind.str() + "'" + support::DidYouMean(kind.str(), known)};
}

SetResult EditPrim(RetainedSceneDelegate* scene, const Path& path, const Fields& fields) {
  const auto found = scene->GetPrims().find(path);
  if (found == scene->GetPrims().end() || TypeOf(found->second).empty()) return {false, NoSuchPrim(*scene, path)};
  PrimDescription made = found->second;
  SetResult result{true, fill_fields(fields, path, &made)};
  if (result.fault.empty()) scene->Set(path, std::move(made));
  return result;
}

std::vector<std::pair<Path, Token>> ListPrims(const RetainedSceneDelegate& scene) {
  std::vector<std::pair<Path, Token>> prims;
  for (const auto& [path, prim] : scene.GetPrims())
    if (const Token kind = TypeOf(prim); !kind.empty()) prims.emplace_back(path, kind);
  return prims;
}

std::string NoSuchPrim(const RetainedSceneDelegate& scene, const Path& path) {
  std::vector<std::string> known;
  for (const auto& prim : ListPrims(scene)) known.push_back(prim.first.str());
  return "there is no prim " + path.str() + support::DidYouMean(path.str(), known);
}

std::string DisneySurface(const Path& material, const MaterialNetwork& network) {
  const auto terminal = network.terminals.find("surface");
  if (terminal == network.terminals.end()) return {};
  const auto node = network.nodes.find(terminal->second.upstreamNode);
  const bool is_disney = node != network.nodes.end() && node->second.nodeTypeId == Token("AlabasterDisney");
  return is_disney ? node_name(material, node->first) : std::string();
}

std::string CheckField(const std::string& kind, const std::string& name, const Value& value) {
  if (kind == "product") {
    RenderProduct scratch;
    return set_row(kProductFields, &scratch, name, value).value_or("a product has no field '" + name + "'");
  }
  for (const Kind& one : kinds()) {
    if (kind != one.name) continue;
    PrimDescription scratch = one.defaults;
    if (FieldResult result =
            std::visit([&](auto& object) { return set_row(one.fields, &object, name, value); }, scratch))
      return *result;
    if (std::string_view(one.parameters) == "render_settings") return CheckSetting(name, value);
    return check_parameter(one.parameters, name, value).value_or(unknown(name, {}, scratch));
  }
  return "there is no kind of prim '" + kind + "'";
}

std::string ReadCamera(const Fields& fields, CameraDescription* camera) {
  return read_fields(fields, camera);
}
std::string ReadSettings(const Fields& fields, RenderSettingsDescription* settings) {
  return read_fields(fields, settings);
}

namespace {

DirtyBits bits_of_primvar(const Token& name) {
  if (name == Token("points")) return dirty::kPoints;
  return name == Token("normals") ? dirty::kNormals | dirty::kPrimvar : dirty::kPrimvar;
}

/// The bits that an edit of open fields marks.
template <class T>
DirtyBits open_difference(const T& a, const T& b) {
  if constexpr (requires { a.parameters; })
    if (!(a.parameters == b.parameters)) return dirty::kParams | dirty::kResource;
  return dirty::kClean;
}
DirtyBits open_difference(const Mesh& a, const Mesh& b) {
  DirtyBits bits = dirty::kClean;
  if (!(a.topology.geomSubsets == b.topology.geomSubsets)) bits |= dirty::kTopology;
  if (!(a.primvarSamples == b.primvarSamples)) bits |= dirty::kPoints;
  for (const auto& [name, value] : a.primvars)
    if (const auto* after = support::find_in(b.primvars, name); !after || !(*after == value))
      bits |= bits_of_primvar(name);
  for (const auto& [name, value] : b.primvars)
    if (!a.primvars.contains(name)) bits |= bits_of_primvar(name);
  return bits;
}
DirtyBits open_difference(const InstancerDescription& a, const InstancerDescription& b) {
  DirtyBits bits = dirty::kClean;
  if (!(a.primvars == b.primvars) || !(a.primvarSamples == b.primvarSamples) || a.primvarRoles != b.primvarRoles)
    bits |= dirty::kPrimvar;
  if (!(a.categories == b.categories)) bits |= dirty::kCategories;
  return bits;
}

}  // namespace

DirtyBits difference(const PrimDescription& a, const PrimDescription& b) {
  const Kind& kind = kind_of(a);
  return std::visit(
      [&]<class T>(const T& before) {
        const T& after = std::get<T>(b);
        DirtyBits bits = open_difference(before, after);
        for (const Field& field : kind.fields)
          if ((bits & field.dirty) != field.dirty && !field.equal(&before, &after)) bits |= field.dirty;
        if (bits == dirty::kClean && kind.others != dirty::kClean && !(before == after)) bits = kind.others;
        return bits;
      },
      a);
}

}  // namespace alabaster::hd::host
