#include "delegate/looks/patterns.h"

#include <algorithm>
#include <numbers>
#include <vector>

#include "core/color/chromaticities.h"
#include "delegate/looks/formulas.h"
#include "delegate/support/lookup.h"

namespace alabaster::hd::looks {
namespace {

using support::first_in;
using support::text_in;
using support::value_in;

constexpr int kDeepest = 32;  // nodes on the way to an image: networks may be circles

bool is_a(const MaterialNode& node, std::string_view prefix) {
  return node.nodeTypeId.str().starts_with(prefix);
}

std::string fault_of(const Path& id, const MaterialNode& node, const char* why) {
  return "a node of type '" + node.nodeTypeId.str() + "' (" + id.str() + "), " + why;
}

Pattern signal_or(std::optional<Signal> signal, const Path& id, const MaterialNode& node) {
  if (signal) return {std::move(signal), ""};
  return {std::nullopt, fault_of(id, node, "whose arithmetic of textures is not read")};
}

// Colours ---------------------------------------------------------------------------------------------

struct ColorSpace {
  std::array<const char*, 3> names;  // the first is the one that configurations of OpenColorIO have
  Chromaticities chromaticities;
  float gamma;  // 0: sRGB's curve
};
constexpr Chromaticities kAp1{0.713f, 0.293f, 0.165f, 0.83f, 0.128f, 0.044f, 0.32168f, 0.33767f};
constexpr Chromaticities kP3{0.68f, 0.32f, 0.265f, 0.69f, 0.15f, 0.06f, 0.3127f, 0.329f};
// MaterialX's names, and those of OpenUSD's ColorSpaceAPI.
constexpr ColorSpace kColorSpaces[] = {{{"linear", "lin_rec709", "lin_rec709_scene"}, kRec709, 1},
                                       {{"srgb_texture", "sRGB", "srgb_rec709_scene"}, kRec709, 0},
                                       {{"g22_rec709", "g22_rec709_scene"}, kRec709, 2.2f},
                                       {{"g18_rec709", "g18_rec709_scene"}, kRec709, 1.8f},
                                       {{"acescg", "lin_ap1", "lin_ap1_scene"}, kAp1, 1},
                                       {{"srgb_displayp3", "srgb_p3d65_scene"}, kP3, 0},
                                       {{"lin_displayp3", "lin_p3d65_scene"}, kP3, 1}};

const ColorSpace* color_space_of(const std::string& name) {
  const auto* const found = std::find_if(std::begin(kColorSpaces), std::end(kColorSpaces), [&](const auto& one) {
    return std::any_of(one.names.begin(), one.names.end(), [&](const char* known) { return known && name == known; });
  });
  return found == std::end(kColorSpaces) ? nullptr : found;
}

float decoded(float value, float gamma) {
  if (gamma == 1 || value <= 0) return value;
  if (gamma > 0) return std::pow(value, gamma);
  return value <= 0.04045f ? value / 12.92f : std::pow((value + 0.055f) / 1.055f, 2.4f);
}

// OpenUSD's companion of a parameter, or this contract's own.
std::string space_of(const MaterialNode& node, const std::string& name) {
  const std::string space = text_in(node.parameters, ("colorSpace:" + name).c_str());
  return space.empty() ? text_in(node.parameters, (name + ":colorSpace").c_str()) : space;
}

bool to_rec709(const std::string& space, Vec4f* color) {
  if (space.empty() || space == "raw" || space == "data") return true;
  const ColorSpace* const found = color_space_of(space);
  if (!found) return false;
  Vec4f& c = *color;
  for (int i = 0; i < 3; ++i) c[i] = decoded(c[i], found->gamma);
  if (found->chromaticities == kRec709) return true;
  const auto rows = rgb_to_rgb(found->chromaticities, kRec709).value();
  const Vec4f given = c;
  for (size_t i = 0; i < 3; ++i) c[int(i)] = rows[i][0] * given.x + rows[i][1] * given.y + rows[i][2] * given.z;
  return true;
}

// Blender writes the images that it holds in memory as EXR files of linear colours and calls them srgb_texture, too:
// auto reads these as linear and files of 8 or 16 bits as sRGB. Without a space MaterialX converts nothing.
std::string space_of_file(const MaterialNode& node, const char* file) {
  const std::string space = space_of(node, file);
  const ColorSpace* const found = color_space_of(space);
  const std::string name = found ? found->names.front() : space;
  return name.empty() ? "raw" : name == "srgb_texture" ? "auto" : name;
}

// Images ----------------------------------------------------------------------------------------------

/// What a type of image node calls its inputs.
struct ImageType {
  const char* prefix;
  const char *file, *wrap_s, *wrap_t, *st, *fallback;
  const char* wrap;  // where it is not given
};
constexpr ImageType kImageTypes[] = {
    {"UsdUVTexture", "file", "wrapS", "wrapT", "st", "fallback", "black"},
    {"ND_UsdUVTexture", "file", "wrapS", "wrapT", "st", "fallback", "repeat"},
    {"ND_image_", "file", "uaddressmode", "vaddressmode", "texcoord", "default", "repeat"},
    {"ND_tiledimage_", "file", "", "", "texcoord", "default", "repeat"},
    {"ND_gltf_image_", "file", "uaddressmode", "vaddressmode", "texcoord", "default", "repeat"},
    {"ND_gltf_colorimage", "file", "", "", "texcoord", "default", "repeat"},
    {"ND_gltf_normalmap_", "file", "uaddressmode", "vaddressmode", "texcoord", "default", "repeat"},
    {"arnold:image", "filename", "swrap", "twrap", "uvcoords", "missing_texture_color", "repeat"},
};

const ImageType* image_type_of(const MaterialNode& node) {
  const auto* const found = std::find_if(std::begin(kImageTypes), std::end(kImageTypes),
                                         [&](const ImageType& type) { return is_a(node, type.prefix); });
  return found == std::end(kImageTypes) ? nullptr : found;
}

std::string wrap_of(const Value& mode, const char* otherwise) {
  const std::string word = mode.text_or(otherwise);
  if (word == "constant" || word == "useMetadata") return "black";  // files carry none
  return word == "periodic" || word == "file" ? "repeat" : word;
}

bool holds_numbers(const std::string& type) {
  return type.find("_float") != std::string::npos || type.find("_vector") != std::string::npos;
}

bool packs_normals(const MaterialNode& node) {
  return is_a(node, "ND_normalmap") || is_a(node, "arnold:normal_map") || is_a(node, "ND_gltf_normalmap");
}

// Coordinates -----------------------------------------------------------------------------------------

Vec2f pair_of(const MaterialNode& node, const char* name, float otherwise) {
  std::array<double, 4> numbers{};
  const size_t count = value_in(node.parameters, name).components(&numbers);
  if (count == 0) return Vec2f(otherwise);
  return {static_cast<float>(numbers[0]), static_cast<float>(numbers[count == 1 ? 0 : 1])};
}

/// A whole number from 0 to `most`; 0 where it is none.
int index_of(const MaterialNode& node, int most) {
  const double index = support::number_in(node.parameters, "index");
  return index >= 0 && index <= double(most) ? static_cast<int>(index) : 0;
}

float radians_of(const MaterialNode& node, const char* name) {
  const auto degrees = static_cast<float>(value_in(node.parameters, name).number_or(0));
  return degrees * std::numbers::pi_v<float> / 180;
}

// MaterialX's rotations turn clockwise, and its scale divides.
bool apply_place2d(const MaterialNode& node, const Vec2f& scale, float radians, const Vec2f& offset, const Vec2f& pivot,
                   Placement* placed) {
  bool good = true;
  placed->offset -= pivot;
  if (value_in(node.parameters, "operationorder").number_or(0) == 0) {
    good = placed->multiply(scale);
    placed->rotate(radians);
    placed->offset += offset;
  } else {
    placed->offset += offset;
    placed->rotate(radians);
    good = placed->multiply(scale);
  }
  placed->offset += pivot;
  return good;
}

/// Applies one node. False if it is none that places coordinates.
bool apply(const MaterialNode& node, Placement* placed) {
  if (is_a(node, "ND_convert_") || is_a(node, "ND_dot_")) return true;
  if (is_a(node, "UsdTransform2d") || is_a(node, "ND_UsdTransform2d")) {
    const bool good = placed->multiply(pair_of(node, "scale", 1));
    placed->rotate(radians_of(node, "rotation"));
    placed->offset += pair_of(node, "translation", 0);
    return good;
  }
  if (is_a(node, "ND_place2d_"))
    return apply_place2d(node, Vec2f(1) / pair_of(node, "scale", 1), -radians_of(node, "rotate"),
                         -pair_of(node, "offset", 0), pair_of(node, "pivot", 0), placed);
  if (is_a(node, "ND_rotate2d_")) return placed->rotate(-radians_of(node, "amount")), true;
  if (is_a(node, "ND_rotate3d_")) {
    const float angle = radians_of(node, "amount");
    if (angle != 0 && value_in(node.parameters, "axis").get_or(Vec3f(0)) != Vec3f(0, 0, 1)) return false;
    return placed->rotate(-angle), true;
  }
  if (value_in(node.parameters, "in2").empty()) return false;  // it comes from another node
  const Vec2f operand = pair_of(node, "in2", 0);
  if (is_a(node, "ND_multiply_")) return placed->multiply(operand);
  if (is_a(node, "ND_divide_")) return placed->multiply(Vec2f(1) / operand);
  if (is_a(node, "ND_add_")) return placed->offset += operand, true;
  if (is_a(node, "ND_subtract_")) return placed->offset -= operand, true;
  return false;
}

/// The name of the coordinates that a node gives; none: it gives no coordinates.
std::optional<std::string> coordinates_of(const MaterialNode& node) {
  const auto named = [&](const char* parameter) {
    const std::string name = text_in(node.parameters, parameter);
    return name.empty() ? "st" : name;
  };
  if (is_a(node, "UsdPrimvarReader_float2") || is_a(node, "ND_UsdPrimvarReader_vector2")) return named("varname");
  if (is_a(node, "ND_geompropvalue_")) return named("geomprop");
  if (!is_a(node, "ND_texcoord_")) return std::nullopt;
  const int index = index_of(node, 99);
  return index == 0 ? "st" : "st" + std::to_string(index);
}

}  // namespace

const MaterialNode* Patterns::find(const MaterialConnection* connection) const {
  return connection ? support::find_in(network_.nodes, connection->upstreamNode) : nullptr;
}

std::optional<Vec4f> Patterns::constant(const MaterialNode& node, const std::string& name) const {
  const Value value = value_in(node.parameters, name.c_str());
  if (value.empty()) return std::nullopt;
  std::array<double, 4> n{};
  const size_t count = value.components(&n);
  if (count == 0) {
    warn_("material.input", name + " cannot be '" + value.to_string() + "'; the default is used");
    return std::nullopt;
  }
  if (count == 1) return Vec4f(static_cast<float>(n[0]));
  Vec4f read(static_cast<float>(n[0]), static_cast<float>(n[1]), static_cast<float>(n[2]),
             count == 4 ? static_cast<float>(n[3]) : 1);
  if (const std::string space = space_of(node, name); count >= 3 && !to_rec709(space, &read))
    warn_("material.colorSpace", name + " is in '" + space + "', which is not known for constants; lin_rec709 is used");
  return read;
}

Pattern Patterns::read(const MaterialConnection& connection, int depth) {
  const auto key = std::pair(connection.upstreamNode, connection.upstreamOutput);
  if (const auto found = known_.find(key); found != known_.end()) return found->second;
  const MaterialNode* const node = find(&connection);
  Pattern read;
  if (!node)
    read.fault = connection.upstreamNode.str() + ", which does not exist";
  else if (depth > kDeepest)
    read.fault = fault_of(connection.upstreamNode, *node, "which comes to no image");
  else
    read = read_node(connection.upstreamNode, *node, connection.upstreamOutput.str(), depth);
  return known_[key] = read;
}

Pattern Patterns::read_normals(const MaterialConnection& connection) {
  const MaterialNode* const node = find(&connection);
  const bool gives = !node || packs_normals(*node) || is_a(*node, "UsdUVTexture") || is_a(*node, "ND_UsdUVTexture") ||
                     node->nodeTypeId == Token("AlabasterTexture");
  if (!gives)
    return {std::nullopt, fault_of(connection.upstreamNode, *node, "which gives no normals in tangent space")};
  return read(connection, 0);
}

Pattern Patterns::input(const MaterialNode& node, const char* name, float otherwise, int depth) {
  if (const MaterialConnection* const from = first_in(node.inputConnections, name)) return read(*from, depth + 1);
  const auto given = constant(node, name);
  return {Signal{given.value_or(Vec4f(otherwise)), {}}, ""};
}

Pattern Patterns::read_node(const Path& id, const MaterialNode& node, const std::string& output, int depth) {
  if (node.nodeTypeId == Token("AlabasterTexture") || node.nodeTypeId == Token("AlabasterPrimvar"))
    return {Signal{Vec4f(1), {{id, node, output.empty() ? "rgb" : output}}}, ""};
  if (packs_normals(node)) return unpack_normals(id, node, depth);
  if (image_type_of(node)) return read_image(id, node, output, depth);
  if (is_a(node, "UsdPrimvarReader_") || is_a(node, "ND_UsdPrimvarReader_"))
    return read_primvar(node, text_in(node.parameters, "varname"), "fallback");
  if (is_a(node, "ND_geompropvalue_")) return read_primvar(node, text_in(node.parameters, "geomprop"), "default");
  if (is_a(node, "ND_geomcolor_")) return read_primvar(node, "displayColor", "");
  if (is_a(node, "ND_constant_")) return input(node, "value", 0, depth);
  if (is_a(node, "ND_convert_") || is_a(node, "ND_dot_")) return input(node, "in", 0, depth);
  if (is_a(node, "ND_combine")) return combine(node, depth);

  // A channel of the input: vectors have outx, outy, outz and outw.
  if (is_a(node, "ND_separate") || is_a(node, "ND_extract_")) {
    Pattern in = input(node, "in", 0, depth);
    size_t channel = std::string_view("rgbaxyzw").find(output.empty() ? '-' : output.back());
    if (is_a(node, "ND_extract_")) channel = size_t(index_of(node, 3));
    if (in.signal && channel != std::string_view::npos) in.signal = channel_of(*in.signal, int(channel % 4));
    return in;
  }

  // Arithmetic of two inputs a and b.
  const bool inverts = is_a(node, "ND_invert_"), mixes = is_a(node, "ND_mix_");
  const bool multiplies = is_a(node, "ND_multiply_"), divides = is_a(node, "ND_divide_");
  const bool adds = is_a(node, "ND_add_"), subtracts = is_a(node, "ND_subtract_"), raises = is_a(node, "ND_power_");
  const bool least = is_a(node, "ND_min_"), most = is_a(node, "ND_max_");
  if (!(inverts || mixes || multiplies || divides || adds || subtracts || raises || least || most))
    return {std::nullopt, fault_of(id, node, "which is not read")};
  const float neutral = multiplies || divides || raises || inverts ? 1 : 0;
  const Pattern a = input(node, inverts ? "amount" : mixes ? "bg" : "in1", inverts ? 1 : 0, depth);
  const Pattern b = input(node, inverts ? "in" : mixes ? "fg" : "in2", inverts ? 0 : neutral, depth);
  if (!a.signal || !b.signal) return a.signal ? b : a;
  if (mixes) {
    const Pattern share = input(node, "mix", 0, depth);
    if (!share.signal) return share;
    if (!share.signal->is_textured()) return signal_or(mixture(*a.signal, *b.signal, share.signal->constant), id, node);
    if (a.signal->is_textured() || b.signal->is_textured()) return signal_or(std::nullopt, id, node);
    return signal_or(affine(*share.signal, b.signal->constant - a.signal->constant, a.signal->constant), id, node);
  }
  const Vec4f &ka = a.signal->constant, &kb = b.signal->constant;
  const bool of_a = !b.signal->is_textured(), of_b = !a.signal->is_textured();
  const Vec4f one(1), none(0);
  if (multiplies) return signal_or(product(*a.signal, *b.signal), id, node);
  if (divides && of_a) return signal_or(affine(*a.signal, one / kb, none), id, node);
  if (adds && (of_a || of_b))
    return signal_or(of_a ? affine(*a.signal, one, kb) : affine(*b.signal, one, ka), id, node);
  if ((subtracts || inverts) && of_a) return signal_or(affine(*a.signal, one, -kb), id, node);
  if ((subtracts || inverts) && of_b) return signal_or(affine(*b.signal, -one, ka), id, node);
  if (!(of_a && of_b)) return signal_or(std::nullopt, id, node);
  Vec4f folded;
  for (int i = 0; i < 4; ++i)
    folded[i] = raises ? std::pow(ka[i], kb[i]) : least ? std::min(ka[i], kb[i]) : std::max(ka[i], kb[i]);
  return {Signal{folded, {}}, ""};
}

// Constants, or the channels of one image in their order.
Pattern Patterns::combine(const MaterialNode& node, int depth) {
  Vec4f constant(1);
  std::vector<Factor> whole;
  std::string fault;
  for (int i = 0; i < 4; ++i) {
    const std::string name = "in" + std::to_string(i + 1);
    if (!node.parameters.contains(name) && !node.inputConnections.contains(name)) break;
    Pattern in = input(node, name.c_str(), 0, depth);
    if (!in.signal) return in;
    constant[i] = in.signal->constant.x;
    std::vector<Factor>& factors = in.signal->factors;
    if (i == 3) break;  // nothing reads a combined alpha
    for (Factor& factor : factors) factor.output = factor.output == std::string(1, "rgb"[i]) ? "rgb" : "";
    if (i == 0) whole = factors;
    if (factors != whole || std::any_of(whole.begin(), whole.end(), [](const Factor& f) { return f.output.empty(); }))
      fault = "a node of type '" + node.nodeTypeId.str() + "' of several textures, which is not read";
  }
  if (!fault.empty()) return {std::nullopt, fault};
  return {Signal{constant, whole}, ""};
}

// Texels from 0 to 1 are normals from -1 to 1; `scale` steepens what lies in the plane.
Pattern Patterns::unpack_normals(const Path& id, const MaterialNode& node, int depth) {
  const bool is_image = image_type_of(node) != nullptr, arnold = is_a(node, "arnold:");
  Pattern in = is_image ? read_image(id, node, "", depth) : input(node, arnold ? "input" : "in", 0.5f, depth);
  if (!in.signal || !in.signal->is_textured()) return in;
  // An image's own scale places it.
  const Vec2f s = is_image ? Vec2f(1) : pair_of(node, arnold ? "strength" : "scale", 1);
  in.signal = affine(*in.signal, Vec4f(2 * s.x, 2 * s.y, 2, 1), Vec4f(-s.x, -s.y, -1, 0));
  if (!in.signal) return {std::nullopt, "normals of several textures, which are not read"};
  in.signal->factors.front().node.parameters["sourceColorSpace"] = "raw";
  return in;
}

Pattern Patterns::read_primvar(const MaterialNode& node, const std::string& name, const char* fallback) const {
  const std::string& type = node.nodeTypeId.str();
  const auto ends = [&](const char* word) { return type.ends_with(word); };
  if (name.empty()) return {std::nullopt, "a node of type '" + type + "', which names no primvar"};
  if (ends("_string") || ends("_matrix") || ends("_boolean") || ends("matrix44") || ends("filename"))
    return {std::nullopt, "primvar '" + name + "' by a node of type '" + type + "', but primvars are read as numbers"};
  MaterialNode reader{"AlabasterPrimvar", {}, {}};  // of displayColor, with displayOpacity as its alpha
  if (name != "displayColor") reader.parameters["varname"] = Token(name);
  if (const auto missing = constant(node, fallback)) reader.parameters["fallback"] = *missing;
  return {
      Signal{Vec4f(1), {{name, std::move(reader), ends("_float") || ends("_int") || ends("_integer") ? "r" : "rgb"}}},
      ""};
}

Pattern Patterns::read_image(const Path& id, const MaterialNode& node, const std::string& output, int depth) {
  const ImageType& type = *image_type_of(node);
  const bool usd = is_a(node, "UsdUVTexture") || is_a(node, "ND_UsdUVTexture");
  const std::string& name = node.nodeTypeId.str();
  const Value file = value_in(node.parameters, type.file);
  if (file.text_or("").empty()) return {std::nullopt, id.str() + ", which has no file"};
  MaterialNode texture{"AlabasterTexture", {{"file", file}}, {}};
  auto& to = texture.parameters;
  const auto copy = [&](const char* from, const char* ours) {
    if (const Value value = value_in(node.parameters, from); !value.empty()) to[ours] = value;
  };
  if (usd)
    for (const char* same : {"sourceColorSpace", "scale", "bias"}) copy(same, same);
  copy(type.fallback, "fallback");
  if (name == "arnold:image")
    to["sourceColorSpace"] =
        text_in(node.parameters, "color_space").empty() ? "auto" : text_in(node.parameters, "color_space");
  else if (!usd || !space_of(node, type.file).empty())
    to["sourceColorSpace"] = holds_numbers(name) ? "raw" : space_of_file(node, type.file);
  to["wrapS"] = wrap_of(value_in(node.parameters, type.wrap_s), type.wrap);
  to["wrapT"] = wrap_of(value_in(node.parameters, type.wrap_t), type.wrap);
  if (text_in(node.parameters, "filtertype") == "closest") to["filter"] = "nearest";
  read_coordinates(id, node, &texture);

  std::string channel = output == "outa" ? "a" : "rgb";
  if (usd && !output.empty() && output != "rgba") channel = output;
  if (!usd && name.find("_float") != std::string::npos) channel = "r";
  Signal read{Vec4f(1), {{id, std::move(texture), channel}}};
  if (!is_a(node, "ND_gltf_") && name != "arnold:image") return {std::move(read), ""};
  for (const char* multiplied : {"factor", "color", "geomcolor", "multiply"}) {
    const Pattern by = input(node, multiplied, 1, depth);
    if (!by.signal) return by;
    const auto both = product(std::move(read), channel == "a" ? channel_of(*by.signal, 3) : *by.signal);
    if (!both) return signal_or(std::nullopt, id, node);
    read = *both;
  }
  return {std::move(read), ""};
}

// The coordinates come from a primvar, maybe through arithmetic. Nodes are met from the image to the primvar, and
// applied the other way round.
void Patterns::read_coordinates(const Path& id, const MaterialNode& image, MaterialNode* texture) const {
  std::vector<const MaterialNode*> steps;
  const MaterialConnection* at = first_in(image.inputConnections, image_type_of(image)->st);
  const MaterialNode* node = find(at);
  while (node && !coordinates_of(*node) && steps.size() < size_t(kDeepest)) {
    steps.push_back(node);
    at = nullptr;
    for (const char* from : {"in1", "in", "texcoord"})
      if (!at) at = first_in(node->inputConnections, from);
    node = find(at);
  }
  std::string unread = at && !node ? at->upstreamNode.str() + ", which does not exist" : "";
  if (node) texture->parameters["st"] = coordinates_of(*node).value_or("st");
  Placement placed;
  for (auto step = steps.rbegin(); step != steps.rend(); ++step)
    if (!apply(**step, &placed)) unread = "a node of type '" + (*step)->nodeTypeId.str() + "', which is not read";
  if (is_a(image, "ND_tiledimage_")) {
    const bool tiled = placed.multiply(pair_of(image, "uvtiling", 1));
    placed.offset -= pair_of(image, "uvoffset", 0);
    const Vec2f size = pair_of(image, "realworldtilesize", 1) / pair_of(image, "realworldimagesize", 1);
    if (!placed.multiply(size) || !tiled) unread = "a rotation and uneven tiles, which are not read";
  }
  if (!unread.empty()) warn_("material.texture.st", "the coordinates of " + id.str() + " pass " + unread);
  // ND_gltf_*: place2d with all of it inverted, v of the offset twice.
  if (is_a(image, "ND_gltf_")) {
    const Vec2f offset = pair_of(image, "offset", 0);
    Vec2f pivot = pair_of(image, "pivot", 0);
    if (!image.parameters.contains("pivot")) pivot = Vec2f(0, 1);
    apply_place2d(image, pair_of(image, "scale", 1), radians_of(image, "rotate"), {offset.x, -offset.y}, pivot,
                  &placed);
  }
  if (!placed.is_identity()) place_image(placed, texture);
}

}  // namespace alabaster::hd::looks
