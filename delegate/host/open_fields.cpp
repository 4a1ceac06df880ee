#include "delegate/host/open_fields.h"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "delegate/support/color_space.h"
#include "delegate/support/lookup.h"
#include "delegate/support/nearest_name.h"
#include "delegate/support/parameters.h"

namespace alabaster::hd::host {
namespace {

// Names ---------------------------------------------------------------------------------------------

/// The rest of `name` after `prefix`; nullopt: it begins otherwise, or no name follows.
std::optional<std::string> after(const std::string& name, std::string_view prefix) {
  if (!name.starts_with(prefix) || name.size() == prefix.size() || name[prefix.size()] == ':') return std::nullopt;
  return name.substr(prefix.size());
}

struct Suffixed {
  std::string name, suffix;
};
/// `text` without that of `suffixes` which it ends with, after a colon. None: the suffix is "".
Suffixed split_suffix(const std::string& text, std::initializer_list<const char*> suffixes) {
  const size_t colon = text.rfind(':');
  if (colon != std::string::npos && colon > 0)
    for (const char* suffix : suffixes)
      if (text.compare(colon + 1, std::string::npos, suffix) == 0) return {text.substr(0, colon), suffix};
  return {text, ""};
}

template <class T>
std::string read_into(const std::string& name, const Value& value, const Limits& limits, T* out) {
  if (is_default(value)) return *out = T(), "";
  const std::string must = read(value, limits, out);
  return must.empty() ? must : fault_text(name, must, value, words_of(limits));
}

// Primvars ------------------------------------------------------------------------------------------
constexpr Limits kRoles = words("none", "color", support::kLinearRec709, "vector", "normal", "point",
                                "textureCoordinate", "faceIndex", "pointIndex");
constexpr Limits kVarTypes = words("half", "float", "int");
constexpr Limits kInterpolations = words("constant", "uniform", "varying", "vertex", "faceVarying", "instance");

/// "" if it may be a primvar's value: samples are a field of their own.
std::string check_primvar(const std::string& name, const Value& value) {
  if (value.type() != ALABASTER_SAMPLES) return {};
  return fault_text(name, "a value; samples are '" + name + ":samples'", value);
}

template <class Samples>
std::string set_samples(const std::string& name, const Value& value, const Token& key, Samples* samples) {
  if (value.empty()) return samples->erase(key), "";
  return read_into(name, value, {}, &(*samples)[key]);
}

/// "" if it may be the samples of a number.
std::string check_numbers_at_times(const std::string& name, const Value& value) {
  TimeSamples<Value> samples;
  if (value.empty()) return {};
  const bool are_samples = read(value, {}, &samples).empty();
  const bool are_numbers = std::none_of(samples.values.begin(), samples.values.end(),
                                        [](const Value& one) { return std::isnan(one.number_or(NAN)); });
  return are_samples && are_numbers ? "" : fault_text(name, "samples: numbers at times", value);
}

// Parameters ----------------------------------------------------------------------------------------

bool is_text_or_asset(const Value& value) {
  return !value.is_array() && (value.type() == ALABASTER_TOKEN || value.type() == ALABASTER_STRING ||
                               value.type() == ALABASTER_PATH || value.type() == ALABASTER_ASSET);
}
bool fits(const OtherParameter& row, const Value& value) {
  const auto is_value = [&](const char* word) { return word && value.text_or("") == word; };
  if (row.words[0]) return is_text_or_asset(value) && std::any_of(row.words.begin(), row.words.end(), is_value);
  if (row.type.type == ALABASTER_STRING) return is_text_or_asset(value);
  std::array<double, 4> numbers{};
  const size_t count = value.components(&numbers);
  return value.type() == row.type.type && value.is_array() == row.type.is_array &&
         std::all_of(numbers.begin(), numbers.begin() + count, [&](double one) { return one >= row.low; });
}
constexpr FieldType kText = {ALABASTER_STRING, false};
constexpr uint32_t bit(LightType type) {
  return 1u << static_cast<uint32_t>(type);
}
constexpr uint32_t kWithImages = bit(LightType::dome) | bit(LightType::rect);
constexpr uint32_t kWithProfiles =
    bit(LightType::sphere) | bit(LightType::rect) | bit(LightType::disk) | bit(LightType::cylinder);
constexpr OtherParameter kOfTextures[] = {
    {"file", kText, "a file", "Image file; <UDIM> in its name stands for the numbers of a set of images."},
    {"layer", kText, "a layer", "Layer of an EXR; empty: the picture."},
    {"sourceColorSpace", kText, "a colour space",
     "auto (sRGB or linear by the image's type for colours, raw for numbers), sRGB, raw, linear, or a name of the "
     "OpenColorIO configuration.",
     "auto"},
    {"st", kText, "a primvar", "Primvar that the image is looked up by.", "st"}};
constexpr OtherParameter kOfDisplacements[] = {{"displacement", {ALABASTER_PATH, false}, "connected to a texture"}};
constexpr OtherParameter kOfMeshes[] = {
    {"subsurfaceSet", kText, "a name",
     "Set of objects that scatter light below the surface as one body, their union; byMaterial makes a set for each "
     "material. Without it each object scatters by itself."},
    {"lightGroup", kText, "a name",
     "Group that the light of the mesh belongs to where it emits: AOV lightGroup:NAME shows it."},
    {"cryptoObject", kText, "a name",
     "Name of the mesh in the layers of AOV cryptoObject; meshes with one name have one matte. Without it the mesh's "
     "own."},
    {"cryptoAsset", kText, "a name", "The same in those of AOV cryptoAsset. Without it the first words of its path."}};
constexpr OtherParameter kOfLights[] = {
    {"texture:file", kText, "a file",
     "Image that multiplies the light. Dome: latitude-longitude around the scene (y up, USD's orientation). Rect: "
     "upright as seen from the front, with the y axis of the light up.",
     "", kWithImages},
    {"texture:layer", kText, "a layer",
     "Layer of an EXR that the image is: a part, or what stands before R, G and B in the names of its channels. "
     "Without it, the picture (RGBA, beauty, Combined, ...).",
     "", kWithImages},
    {"shaping:ies:file", kText, "a file",
     "Photometric profile of a luminaire (IES LM-63, type C): its candela multiply the light by direction. Straight "
     "down in the profile is the light's -z, horizontal angle 0 its x axis, 90 its y axis.",
     "", kWithProfiles},
    {"lightGroup", kText, "a name",
     "Group that the light belongs to: AOV lightGroup:NAME shows the light of all lights and meshes of that name, "
     "wherever it goes."},
    {"color:colorSpace", kText, "lin_rec709"},
    {"lightLink", kText, "a category"},
    {"shadowLink", kText, "a category"}};
constexpr OtherParameter kOfCameras[] = {
    {"projection",
     kText,
     nullptr,
     "Kind of projection.",
     "perspective",
     0,
     "none",
     -kUnbounded,
     {"perspective", "orthographic"}},
    {"clippingRange",
     {ALABASTER_FLOAT2, false},
     nullptr,
     "Near and far distance between which surfaces are visible; 0, 0 is unlimited. Light and shadows are those of the "
     "whole scene.",
     "",
     0,
     "scene unit",
     0},
    {"clipPlanes",
     {ALABASTER_FLOAT4, true},
     nullptr,
     "Further planes a, b, c, d that cut what the camera sees: surfaces are invisible where a x + b y + c z + d < 0. "
     "Coordinates are the camera's, which looks along -z with y up, in scene units."}};

template <class Row>
bool is_switch(const Row& row) {
  return std::visit([]<class M, class T>(M T::*) { return std::is_same_v<M, bool>; }, row.member);
}

/// "": the value fits the row of that name. nullopt: there is none. Parameters of prims may be out of range: curves of
/// hosts overshoot. The renderer uses the nearest value in range and warns.
enum class Range { refused, left_to_the_renderer };
template <class Rows>
FieldResult check(const Rows& rows, const std::string& name, const Value& value,
                  Range range = Range::left_to_the_renderer) {
  for (const auto& row : rows) {
    if (name != row.name) continue;
    if (value.empty()) return "";
    auto scratch = []<class T, class... W>(const Parameter<T, W...>&) { return T(); }(row);
    // A colour of four numbers is refused here. The renderer accepts it from Hydra hosts and drops the alpha.
    std::array<double, 4> unused;
    const bool has_alpha = row.is_color() && value.components(&unused) == 4;
    const bool is_flag = value.type() == ALABASTER_BOOL && !is_switch(row);
    const support::ParameterFault fault =
        has_alpha || is_flag ? support::ParameterFault::type : support::set_parameter(row, value, &scratch);
    const bool is_left = fault == support::ParameterFault::range && range == Range::left_to_the_renderer;
    if (fault == support::ParameterFault::none || is_left) return "";
    const FieldRow shown = row_of(row, scratch);
    return fault_text(name, MustBe(shown), value, shown.words);
  }
  return std::nullopt;
}
FieldResult check_other(std::span<const OtherParameter> rows, const std::string& name, const Value& value) {
  for (const OtherParameter& row : rows)
    if (name == row.name)
      return value.empty() || fits(row, value)
                 ? ""
                 : fault_text(name, row.must ? row.must : MustBe(row_of(row)), value, row_of(row).words);
  return std::nullopt;
}

template <class Rows>
std::vector<std::string> names_of(const Rows& rows, std::span<const OtherParameter> others) {
  std::vector<std::string> names;
  for (const auto& row : rows) names.emplace_back(row.name);
  for (const OtherParameter& other : others) names.emplace_back(other.name);
  return names;
}

template <class Map>
void store(Map* map, const typename Map::key_type& key, const Value& value) {
  if (value.empty())
    map->erase(key);
  else
    (*map)[key] = value;
}

// Products ------------------------------------------------------------------------------------------

FieldResult set_var_field(RenderProduct* product, const std::string& text, const std::string& name,
                          const Value& value) {
  const auto [layer, suffix] = split_suffix(text, {"dataType"});
  auto found = std::find_if(product->vars.begin(), product->vars.end(),
                            [&, &wanted = layer](const RenderVar& var) { return var.name == wanted; });
  if (value.empty() && suffix.empty()) {
    if (found != product->vars.end()) product->vars.erase(found);
    return "";
  }
  if (found == product->vars.end()) found = product->vars.insert(found, {layer, {}, "half"});
  if (suffix.empty()) return read_into(name, value, {}, &found->aov);
  if (is_default(value)) return found->dataType = "half", "";
  return read_into(name, value, kVarTypes, &found->dataType);
}

FieldResult set_product_field(RenderSettingsDescription* settings, const std::string& rest, const std::string& name,
                              const Value& value) {
  constexpr size_t kMostProducts = 4096;
  size_t number = 0;
  const auto [end, error] = std::from_chars(rest.data(), rest.data() + rest.size(), number);
  if (error != std::errc() || end == rest.data() + rest.size() || *end != ':') return std::nullopt;
  if (number >= kMostProducts)
    return "'" + name + "': there are at most " + std::to_string(kMostProducts) + " products";
  if (number >= settings->products.size()) settings->products.resize(number + 1);
  RenderProduct* product = &settings->products[number];
  const std::string field(end + 1, rest.data() + rest.size());
  if (const auto var = after(field, "vars:")) return set_var_field(product, *var, name, value);
  if (field == "file" && is_default(value))
    return settings->products.erase(settings->products.begin() + std::ptrdiff_t(number)), "";
  const FieldResult result = set_row(kProductFields, product, field, value);
  return result && !result->empty() ? "'" + name + result->substr(1 + field.size()) : result;  // the whole name
}

// Materials -----------------------------------------------------------------------------------------

/// The connection to "NODE.OUTPUT", or to "NODE", whose output is then `otherwise`.
MaterialConnection connection_of(const Path& material, const std::string& text, const char* otherwise) {
  const size_t dot = text.rfind('.');
  if (dot == std::string::npos || text.find('/', dot) != std::string::npos)
    return {node_path(material, text), otherwise};
  return {node_path(material, text.substr(0, dot)), text.substr(dot + 1)};
}
std::string connection_text(const Path& material, const MaterialConnection& connection) {
  return node_name(material, connection.upstreamNode) + "." + connection.upstreamOutput.str();
}

std::vector<MaterialConnection> connections_of(const Path& id, const Value& value) {
  std::vector<MaterialConnection> connections;
  if (const auto* path = value.get<Path>()) connections = {connection_of(id, path->str(), "")};
  if (const auto* all = value.get<Array<Path>>())
    for (const Path& path : *all) connections.push_back(connection_of(id, path.str(), ""));
  return connections;
}

constexpr const char* kTerminals[] = {"surface", "displacement", "volume"};
constexpr const char* kOtherDisneyInputs[] = {"normal", "coatNormal", "bump"};

// Tables --------------------------------------------------------------------------------------------
constexpr Field open(const char* name, FieldType type, const char* text, const Limits& limits = {}) {
  return {name, dirty::kClean, text, limits, type};
}
constexpr FieldType array_of(int32_t type) {
  return {type, true};
}
constexpr FieldType kWord = {ALABASTER_TOKEN, false}, kPath = {ALABASTER_PATH, false}, kAny = {},
                    kSamples = {ALABASTER_SAMPLES, false};
constexpr Field kMeshes[] = {
    open("primvars:widths", array_of(ALABASTER_FLOAT), "Diameters. Without them, 1."),  // of curves and points
    open("primvars:points", array_of(ALABASTER_FLOAT3), "Positions of the vertices."),
    open("primvars:normals", array_of(ALABASTER_FLOAT3), "Normals for shading."),
    open("primvars:st", kAny, "Texture coordinates (float2), v up."),
    open("primvars:NAME", kAny,
         "Another primvar: displayColor, displayOpacity, tangents and others of delegate/manual/usd.md."),
    open("primvars:NAME:interpolation", kWord, "How values are spread over the mesh. The default is vertex.",
         kInterpolations),
    open("primvars:NAME:indices", array_of(ALABASTER_INT),
         "Places in the values. Without them the values stand in the order of the elements."),
    open("primvars:NAME:role", kWord, "Meaning of the values.", kRoles),
    open("primvars:NAME:samples", kSamples,
         "Values at times, of points and normals that deform. Setting the primvar takes them away."),
    // Of faces.
    open("subsets:ID:faces", array_of(ALABASTER_INT), "Faces with a material of their own."),
    open("subsets:ID:material", kPath, "Path of the material of these faces."),
};
constexpr Field kInstancers[] = {
    open("primvars:hydra:instanceTransforms", array_of(ALABASTER_MATRIX),
         "Matrices M of the instances. Point p of instance i is p * prototype * M * S * R * T * transform."),
    open("primvars:hydra:instanceTranslations", array_of(ALABASTER_FLOAT3), "Translations T of the instances."),
    open("primvars:hydra:instanceRotations", array_of(ALABASTER_QUATERNION),
         "Rotations R of the instances; the real part first."),
    open("primvars:hydra:instanceScales", array_of(ALABASTER_FLOAT3), "Scales S of the instances."),
    open("primvars:NAME", kAny,
         "Values by instance, one to four numbers for each: materials read them by a node AlabasterPrimvar "
         "(artists.md). They replace those of the mesh, and those of outer instancers."),
    open("primvars:NAME:role", kWord, "Meaning of the values.", kRoles),
    open("primvars:NAME:samples", kSamples, "Values at times, of transforms, translations, rotations and scales."),
    open("prototypes:PATH", array_of(ALABASTER_INT),
         "The instances of that mesh or inner instancer, as places in the primvars."),
    open("categories:NAME", array_of(ALABASTER_INT), "The instances that have the category."),
};
constexpr Field kMaterials[] = {
    open("NODE.type", kWord,
         "AlabasterDisney, AlabasterTexture, AlabasterPrimvar, AlabasterDisplacement, UsdPreviewSurface and others of "
         "delegate/manual/usd.md."),
    open("NODE.INPUT", kAny,
         "A path \"OTHER.OUTPUT\", or an array of these, connects the input; any other value is its constant, by which "
         "connected textures are multiplied. The inputs normal, coatNormal and bump of AlabasterDisney are connected. "
         "Names of inputs are checked for types that begin with Alabaster, constants for AlabasterDisney; the renderer "
         "warns of others."),
    open("surface", kPath,
         "The surface node. Without it, the node \"surface\", else the first AlabasterDisney or UsdPreviewSurface."),
    open("displacement", kPath, "The node that displaces the meshes of the material."),
};
constexpr Field kCameras[] = {
    open("focalLength:samples", kSamples,
         "Focal lengths at times, of a lens that zooms. Setting focalLength takes them away."),
    open("fStop:samples", kSamples, "F-numbers at times. Setting fStop takes them away."),
    open("focusDistance:samples", kSamples,
         "Distances at times, of a focus that moves. Setting focusDistance takes them away."),
};
constexpr Field kOpenSettings[] = {
    open("products:N:FIELD", kAny, "A field of a file to write, N from 0: page product."),
    open("products:N:vars:LAYER", kWord, "The AOV of a layer of the file."),
    open("products:N:vars:LAYER:dataType", kWord, "Type of the layer's numbers. The default is half.", kVarTypes),
};

constexpr const char* kInstancePrimvars[] = {"hydra:instanceTransforms", "hydra:instanceTranslations",
                                             "hydra:instanceRotations", "hydra:instanceScales"};

template <class Names>
bool is_among(const std::string& name, const Names& names) {
  return std::any_of(std::begin(names), std::end(names), [&](const char* one) { return name == one; });
}

std::string unknown_input(const std::string& node, const std::string& input, const std::vector<std::string>& known) {
  return "node '" + node + "' has no input '" + input + "'" + support::DidYouMean(input, known);
}

std::string check_input(const std::string& node, const Token& type, const std::string& input, const Value& value) {
  const auto known = [&](const std::vector<std::string>& names) {
    return std::count(names.begin(), names.end(), input) > 0 ? "" : unknown_input(node, input, names);
  };
  if (type == Token("AlabasterTexture")) return known(parameter_names("texture_node"));
  if (type == Token("AlabasterPrimvar")) return known({"varname", "fallback", "scale", "bias"});
  if (type == Token("AlabasterDisplacement")) return known(parameter_names("displacement_node"));
  if (!(type == Token("AlabasterDisney"))) return {};
  if (is_among(input, kOtherDisneyInputs))
    return value.empty() ? "" : fault_text(node + "." + input, "connected: a path \"NODE.OUTPUT\"", value);
  if (const FieldResult checked = check(material_parameters(), input, value))
    return checked->empty() ? "" : "'" + node + "." + checked->substr(1);
  if (input.ends_with(support::kColorSpace))
    return value.text_or("") == support::kLinearRec709 ? "" : fault_text(node + "." + input, "lin_rec709", value);
  std::vector<std::string> names = names_of(material_parameters(), {});
  names.insert(names.end(), std::begin(kOtherDisneyInputs), std::end(kOtherDisneyInputs));
  return unknown_input(node, input, names);
}

}  // namespace

std::string node_name(const Path& material, const Path& node) {
  const std::string below = material.str() + "/";
  return node.str().starts_with(below) ? node.str().substr(below.size()) : node.str();
}

Path node_path(const Path& material, const std::string& name) {
  return name.starts_with('/') ? Path(name) : material.append(name);
}

std::string without_inputs_namespace(const std::string& name) {
  return after(name, "inputs:").value_or(name);
}

FieldResult check_parameter(std::string_view schema, const std::string& name, const Value& value) {
  FieldResult result;
  visit_table(schema, [&](const auto& rows, const auto&, auto others) {
    result = check(rows, name, value, Range::refused);
    if (!result) result = check_other(others, name, value);
  });
  return result;
}

std::string CheckSetting(const std::string& name, const Value& value) {
  if (const FieldResult checked = check(setting_parameters(), name, value, Range::refused)) return *checked;
  return "there is no setting '" + name + "'" + support::DidYouMean(name, parameter_names("render_settings"));
}

FieldResult SubsetFields::set(const std::string& name, const Value& value) {
  const auto [text, suffix] = split_suffix(after(name, "subsets:").value_or(""), {"faces", "material"});
  if (suffix.empty()) return std::nullopt;
  for (; known_ < subsets_.size(); ++known_) places_.emplace(subsets_[known_].id, known_);
  const Path id(text);
  if (value.empty() && !places_.contains(id)) return "";
  const auto [place, is_new] = places_.emplace(id, subsets_.size());
  if (is_new) subsets_.push_back({id, {}, {}}), ++known_;
  GeomSubset& subset = subsets_[place->second];
  if (suffix == "material") return read_into(name, value, {}, &subset.materialId);
  if (!value.empty()) return read_into(name, value, {}, &subset.indices);
  removes_ = true;
  return subset.id = Path(), places_.erase(place), "";
}

void SubsetFields::finish() {
  if (removes_) std::erase_if(subsets_, [](const GeomSubset& subset) { return subset.id.empty(); });
}

namespace {

template <class T>
FieldResult set_open(T*, const Path&, const std::string&, const Value&) {
  return std::nullopt;
}

FieldResult set_open(MeshDescription* mesh, const Path&, const std::string& name, const Value& value) {
  // A parameter is a constant primvar.
  FieldResult parameter = check(mesh_parameters(), name, value);
  if (!parameter) parameter = check_other(kOfMeshes, name, value);
  if (parameter && parameter->empty() && value.empty()) mesh->primvars.erase(name);
  if (parameter && parameter->empty() && !value.empty())
    mesh->primvars[name] = {Interpolation::constant, {}, value, {}};
  if (parameter) return parameter;
  const auto rest = after(name, "primvars:");
  if (!rest) return std::nullopt;
  const auto [text, suffix] = split_suffix(*rest, {"indices", "interpolation", "role", "samples"});
  const Token key(text);
  if (suffix == "samples") return set_samples(name, value, key, &mesh->primvarSamples);
  if (suffix.empty()) mesh->primvarSamples.erase(key);
  if (suffix.empty() && value.empty()) return mesh->primvars.erase(key), "";
  if (value.empty() && !mesh->primvars.contains(key)) return "";
  PrimvarValue& primvar = mesh->primvars[key];
  if (suffix == "indices") return read_into(name, value, {}, &primvar.indices);
  if (suffix == "role") return read_into(name, value, kRoles, &primvar.role);
  if (suffix == "interpolation") {
    if (is_default(value)) return primvar.interpolation = Interpolation::vertex, "";
    return read_into(name, value, kInterpolations, &primvar.interpolation);
  }
  primvar.value = value;
  return check_primvar(name, value);
}

FieldResult set_open(InstancerDescription* instancer, const Path&, const std::string& name, const Value& value) {
  if (const auto prototype = after(name, "prototypes:")) {
    if (value.empty()) return instancer->indices.erase(Path(*prototype)), "";
    return read_into(name, value, {}, &instancer->indices[Path(*prototype)]);
  }
  if (const auto category = after(name, "categories:")) {
    Array<int32_t> instances;
    if (const std::string fault = read_into(name, value, {}, &instances); !fault.empty()) return fault;
    for (auto& of_one : instancer->categories) std::erase(of_one, Token(*category));
    size_t count = 0;
    for (const auto& primvar : instancer->primvars) count = std::max(count, primvar.second.count());
    for (const int32_t instance : instances) {
      if (instance < 0 || size_t(instance) >= count)
        return "'" + name + "' has no instance " + std::to_string(instance) + "; there are " + std::to_string(count);
      if (size_t(instance) >= instancer->categories.size()) instancer->categories.resize(size_t(instance) + 1);
      auto& of_one = instancer->categories[size_t(instance)];
      if (std::find(of_one.begin(), of_one.end(), Token(*category)) == of_one.end()) of_one.emplace_back(*category);
    }
    while (!instancer->categories.empty() && instancer->categories.back().empty()) instancer->categories.pop_back();
    return "";
  }
  const auto rest = after(name, "primvars:");
  if (!rest) return std::nullopt;
  const auto [text, suffix] = split_suffix(*rest, {"samples", "role", "indices", "interpolation"});
  const Token key(text);
  const bool is_place = is_among(text, kInstancePrimvars);
  if (!is_place && text.starts_with("hydra:")) return std::nullopt;
  if (!suffix.empty() && suffix != (is_place ? "samples" : "role")) return std::nullopt;
  if (suffix == "samples") return set_samples(name, value, key, &instancer->primvarSamples);
  if (suffix == "role") {
    if (value.empty()) return instancer->primvarRoles.erase(key), "";
    return read_into(name, value, kRoles, &instancer->primvarRoles[key]);
  }
  instancer->primvarSamples.erase(key);
  if (value.empty()) instancer->primvarRoles.erase(key);
  store(&instancer->primvars, key, value);
  return check_primvar(name, value);
}

FieldResult set_open(LightDescription* light, const Path&, const std::string& given, const Value& value) {
  const std::string name = without_inputs_namespace(given);
  FieldResult checked = check(light_parameters(), name, value);
  if (!checked) checked = check_other(kOfLights, name, value);
  if (!checked || !checked->empty()) return checked;
  store(&light->parameters, Token(name), value);
  light->parameters.erase(Token(name + support::kColorSpace));
  return checked;
}

FieldResult set_open(CameraDescription* camera, const Path&, const std::string& name, const Value& value) {
  FieldResult checked = check(camera_parameters(), name, value);
  if (!checked) checked = check_other(kOfCameras, name, value);
  if (!checked)
    for (const Field& row : kCameras)
      if (name == row.name) checked = check_numbers_at_times(name, value);
  if (!checked || !checked->empty()) return checked;
  store(&camera->parameters, Token(name), value);
  camera->parameters.erase(Token(name + ":samples"));
  return checked;
}

FieldResult set_open(RenderSettingsDescription* settings, const Path&, const std::string& name, const Value& value) {
  if (const auto rest = after(name, "products:")) return set_product_field(settings, *rest, name, value);
  const std::string fault = CheckSetting(name, value);
  if (fault.starts_with("there is no setting") && !fault.ends_with('?')) return std::nullopt;  // a field may be near
  if (fault.empty()) store(&settings->settings, name, value);
  return fault;
}

FieldResult set_open(MaterialNetwork* network, const Path& id, const std::string& name, const Value& value) {
  if (is_among(name, kTerminals)) {
    Path node;
    if (const std::string fault = read_into(name, value, {}, &node); !fault.empty()) return fault;
    if (node.empty()) return network->terminals.erase(Token(name)), "";
    network->terminals[name] = connection_of(id, node.str(), "out");
    return "";
  }
  const size_t dot = name.rfind('.');
  if (dot == std::string::npos || dot == 0 || dot + 1 == name.size()) return std::nullopt;
  const Path path = node_path(id, name.substr(0, dot));
  const std::string input = name.substr(dot + 1);
  if (input == "type" && value.empty()) return network->nodes.erase(path), "";
  MaterialNode& node = network->nodes[path];
  if (input == "type") return read_into(name, value, {}, &node.nodeTypeId);
  if (value.empty()) node.inputConnections.erase(Token(input));
  if (value.type() == ALABASTER_PATH) {
    node.inputConnections[input] = connections_of(id, value);
    return "";
  }
  store(&node.parameters, Token(input), value);
  node.parameters.erase(Token(input + support::kColorSpace));
  return value.type() == ALABASTER_SAMPLES ? fault_text(name, "a value that does not move", value) : "";
}

void add(const std::string& name, Value value, Fields* fields) {
  if (!value.empty()) fields->emplace_back(name, std::move(value));
}
void add_samples(const std::string& name, const TimeSamples<Value>* samples, Fields* fields) {
  if (samples) add(name + ":samples", write(*samples, {}), fields);
}
template <class T>
void append_open(const T& prim, const Path&, Fields* fields) {
  if constexpr (requires { prim.parameters; })
    for (const auto& [name, value] : prim.parameters) add(name.str(), value, fields);
}

void append_open(const MeshDescription& mesh, const Path&, Fields* fields) {
  for (const auto& [key, primvar] : mesh.primvars) {
    const std::string name = "primvars:" + key.str();
    add(name, primvar.value, fields);
    add(name + ":interpolation", write(primvar.interpolation, kInterpolations), fields);
    if (!primvar.role.empty()) add(name + ":role", primvar.role, fields);
    if (!primvar.indices.empty()) add(name + ":indices", primvar.indices, fields);
    add_samples(name, support::find_in(mesh.primvarSamples, key), fields);
  }
  for (const GeomSubset& subset : mesh.topology.geomSubsets) {
    add("subsets:" + subset.id.str() + ":faces", subset.indices, fields);
    add("subsets:" + subset.id.str() + ":material", subset.materialId, fields);
  }
}

void append_open(const InstancerDescription& instancer, const Path&, Fields* fields) {
  for (const auto& [key, value] : instancer.primvars) {
    add("primvars:" + key.str(), value, fields);
    add_samples("primvars:" + key.str(), support::find_in(instancer.primvarSamples, key), fields);
  }
  for (const auto& [key, role] : instancer.primvarRoles) add("primvars:" + key.str() + ":role", role, fields);
  for (const auto& [prototype, indices] : instancer.indices) add("prototypes:" + prototype.str(), indices, fields);
  std::map<Token, std::vector<int32_t>> by_category;
  for (size_t i = 0; i < instancer.categories.size(); ++i)
    for (const Token& category : instancer.categories[i]) by_category[category].push_back(int32_t(i));
  for (const auto& [category, instances] : by_category) add("categories:" + category.str(), instances, fields);
}

void append_open(const RenderSettingsDescription& settings, const Path&, Fields* fields) {
  for (const auto& [name, value] : settings.settings) add(name, value, fields);
  for (size_t i = 0; i < settings.products.size(); ++i) {
    const RenderProduct& product = settings.products[i];
    const std::string prefix = "products:" + std::to_string(i) + ":";
    append_rows(kProductFields, &product, prefix, fields);
    for (const RenderVar& var : product.vars) {
      add(prefix + "vars:" + var.name, var.aov, fields);
      add(prefix + "vars:" + var.name + ":dataType", var.dataType, fields);
    }
  }
}

void append_open(const MaterialNetwork& network, const Path& id, Fields* fields) {
  for (const auto& [path, node] : network.nodes) {
    const std::string name = node_name(id, path);
    add(name + ".type", node.nodeTypeId, fields);
    for (const auto& [input, value] : node.parameters) add(name + "." + input.str(), value, fields);
    for (const auto& [input, connections] : node.inputConnections) {
      std::vector<Path> upstream;
      for (const MaterialConnection& one : connections) upstream.emplace_back(connection_text(id, one));
      add(name + "." + input.str(), std::move(upstream), fields);
    }
  }
  for (const auto& [terminal, connection] : network.terminals)
    add(terminal.str(), Path(connection_text(id, connection)), fields);
  if (!network.terminals.contains("surface")) fields->emplace_back("surface", Value());  // else SetPrim chooses one
}

std::string last_name(const Path& path) {
  return path.str().substr(path.str().rfind('/') + 1);
}

template <class T>
std::string finished(const T&) {
  return {};
}

std::string finished(const MeshDescription& mesh) {
  if (const auto points = mesh.primvars.find("points"); points != mesh.primvars.end()) {
    if (!points->second.indices.empty())
      return "'primvars:points:indices' is given: faceVertexIndices alone name the points of a face";
    if (points->second.interpolation != Interpolation::vertex && points->second.interpolation != Interpolation::varying)
      return "'primvars:points:interpolation' must be vertex: there is one point for each vertex";
  }
  for (const auto& [name, primvar] : mesh.primvars) {
    const std::string base = name.str().substr(0, name.str().rfind(':')), end = name.str().substr(base.size());
    const std::string suffix = support::NearestName(end, {":indices", ":interpolation", ":role", ":samples"});
    if (!end.empty() && !suffix.empty() && mesh.primvars.contains(base))
      return "a primvar has no '" + end + "'; did you mean 'primvars:" + base + suffix + "'?";
    if (primvar.value.empty())
      return "'primvars:" + name.str() + "' has no value, but its indices, role or interpolation are given";
  }
  for (const auto& [name, samples] : mesh.primvarSamples)
    if (!mesh.primvars.contains(name) || !(name == Token("points") || name == Token("normals")))
      return "'primvars:" + name.str() + "' has samples; points and normals alone may have them, beside their values";
  return {};
}

std::string finished(const RenderSettingsDescription& settings) {
  for (size_t i = 0; i < settings.products.size(); ++i) {
    const std::string product = "'products:" + std::to_string(i) + "'";
    if (settings.products[i].file.empty()) return product + " has no file";
    for (const RenderVar& var : settings.products[i].vars)
      if (var.aov.empty()) return product + ": layer '" + var.name + "' has no AOV";
  }
  return {};
}

std::string finished(const InstancerDescription& instancer) {
  for (const auto& [name, samples] : instancer.primvarSamples)
    if (!instancer.primvars.contains(name)) return "'primvars:" + name.str() + "' has samples, but no value";
  return {};
}

std::string finished(const MaterialNetwork& network) {
  for (const auto& [terminal, connection] : network.terminals)
    if (!network.nodes.contains(connection.upstreamNode))
      return terminal.str() + " names " + connection.upstreamNode.str() + ", which is no node of the material";
  for (const auto& [path, node] : network.nodes) {
    const std::string name = last_name(path);
    if (node.nodeTypeId.empty()) {
      std::vector<std::string> typed;
      for (const auto& other : network.nodes)
        if (!other.second.nodeTypeId.empty()) typed.push_back(last_name(other.first));
      const std::string nearest = support::NearestName(name, typed);
      return "node '" + name + "' has no type: set '" + name + ".type'" +
             (nearest.empty() ? "" : "; did you mean node '" + nearest + "'?");
    }
    for (const auto& [input, value] : node.parameters)
      if (const std::string fault = check_input(name, node.nodeTypeId, input.str(), value); !fault.empty())
        return fault;
    for (const auto& [input, connections] : node.inputConnections)
      if (const std::string fault = check_input(name, node.nodeTypeId, input.str(), {}); !fault.empty()) return fault;
  }
  return {};
}

}  // namespace

std::span<const Field> open_rows(const PrimDescription& prim) {
  const auto* const mesh = std::get_if<MeshDescription>(&prim);
  const std::span<const Field> all(kMeshes);
  if (mesh) return mesh->type == Token("mesh") ? all.subspan(1) : all.first(all.size() - 2);
  if (std::holds_alternative<InstancerDescription>(prim)) return kInstancers;
  if (std::holds_alternative<MaterialNetwork>(prim)) return kMaterials;
  if (std::holds_alternative<RenderSettingsDescription>(prim)) return kOpenSettings;
  if (std::holds_alternative<CameraDescription>(prim)) return kCameras;
  return {};
}
FieldResult set_open_field(PrimDescription* prim, const Path& id, const std::string& name, const Value& value) {
  return std::visit([&](auto& object) { return set_open(&object, id, name, value); }, *prim);
}
void append_open_fields(const PrimDescription& prim, const Path& id, Fields* fields) {
  std::visit([&](const auto& object) { append_open(object, id, fields); }, prim);
}
std::string finish(const PrimDescription& prim) {
  return std::visit([](const auto& object) { return finished(object); }, prim);
}

const std::span<const OtherParameter> kOtherOfTextures = kOfTextures, kOtherOfDisplacements = kOfDisplacements,
                                      kOtherOfMeshes = kOfMeshes, kOtherOfLights = kOfLights,
                                      kOtherOfCameras = kOfCameras;

std::vector<std::string> LightParameterNames() {
  return parameter_names("lights");
}
std::vector<std::string> parameter_names(std::string_view schema) {
  std::vector<std::string> names;
  visit_table(schema, [&](const auto& rows, const auto&, auto others) { names = names_of(rows, others); });
  return names;
}

}  // namespace alabaster::hd::host
