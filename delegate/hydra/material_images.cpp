#include "delegate/hydra/material_images.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "delegate/support/lookup.h"
#include "delegate/support/surface_formulas.h"

namespace alabaster::hydra {
namespace {

using hd::MaterialConnection;
using hd::MaterialNode;
using hd::Path;
using hd::Value;
using hd::Vec2f;

constexpr size_t kLongest = 32;  // nodes on the way to an image: networks may be circles

bool starts_with(const MaterialNode& node, const char* prefix) {
  return node.nodeTypeId.str().starts_with(prefix);
}

Vec2f pair_or(const MaterialNode& node, const char* name, const Vec2f& otherwise) {
  return input_value(node, name).get_or(otherwise);
}

// MaterialX's address modes in our words.
const char* wrap_of(const Value& mode) {
  const std::string word = mode.text_or("periodic");
  if (word == "constant") return "black";
  if (word == "clamp") return "clamp";
  return word == "mirror" ? "mirror" : "repeat";
}

// Blender writes the images that it holds in memory as EXR files of linear colours and calls them srgb_texture, too:
// auto reads these as linear and files of 8 or 16 bits as sRGB. Without a space MaterialX converts nothing.
const char* space_of(const Value& space) {
  const std::string word = space.text_or("");
  if (word == "srgb_texture" || word == "sRGB") return "auto";
  return word == "lin_rec709" ? "linear" : "raw";
}

/// Coordinates uv' = R (scale uv) + offset, with v up.
struct Placement {
  Vec2f scale{1, 1}, offset{0, 0};
  float angle = 0;  // radians, counterclockwise

  bool is_identity() const { return scale == Vec2f(1, 1) && offset == Vec2f(0, 0) && angle == 0; }
  /// False where the result is none of these: uneven scale after a rotation.
  bool multiply(const Vec2f& factor) {
    if (angle != 0 && factor.x != factor.y) return false;
    scale *= factor, offset *= factor;
    return true;
  }
  void rotate(float radians) {
    const float c = std::cos(radians), s = std::sin(radians);
    offset = Vec2f(c * offset.x - s * offset.y, s * offset.x + c * offset.y);
    angle += radians;
  }
};

Vec2f operand(const MaterialNode& node) {
  std::array<double, 4> numbers{};
  const Value value = input_value(node, "in2");
  const size_t count = value.components(&numbers);
  return {static_cast<float>(numbers[0]), static_cast<float>(numbers[count == 1 ? 0 : 1])};
}

/// Applies one node of arithmetic. False if it is none that places coordinates.
bool apply(const MaterialNode& node, Placement* placement) {
  if (starts_with(node, "ND_convert_")) return true;
  const bool is_product = starts_with(node, "ND_multiply_"), is_sum = starts_with(node, "ND_add_");
  if ((is_product || is_sum) && input_value(node, "in2").empty()) return false;  // it comes from another node
  if (is_product) return placement->multiply(operand(node));
  if (is_sum) return placement->offset += operand(node), true;
  if (!starts_with(node, "ND_rotate3d_")) return false;
  const auto degrees = static_cast<float>(input_value(node, "amount").number_or(0));
  if (degrees == 0) return true;
  if (input_value(node, "axis").get_or(hd::Vec3f(0)) != hd::Vec3f(0, 0, 1)) return false;
  placement->rotate(degrees * std::numbers::pi_v<float> / 180);
  return true;
}

}  // namespace

Value input_value(const MaterialNode& node, const char* name) {
  return hd::support::value_in(node.parameters, name);
}

const MaterialConnection* upstream(const MaterialNode& node, const char* input) {
  return hd::support::first_in(node.inputConnections, input);
}

const MaterialNode* MaterialImages::find(const Path& id) const {
  return hd::support::find_in(from_.nodes, id);
}

// Conversions pass their input on; separations choose a channel of it.
std::optional<MaterialImages::Found> MaterialImages::find_image(const char* input,
                                                                const MaterialConnection& connection) {
  const MaterialConnection* at = &connection;
  std::string channel;
  for (size_t i = 0; at && i < kLongest; ++i) {
    const MaterialNode* const node = find(at->upstreamNode);
    if (!node) break;
    if (starts_with(*node, "ND_image_") || starts_with(*node, "ND_tiledimage_")) {
      const bool is_number = starts_with(*node, "ND_image_float") || starts_with(*node, "ND_tiledimage_float");
      return Found{at->upstreamNode, node, channel.empty() ? is_number ? "r" : "rgb" : channel};
    }
    if (starts_with(*node, "ND_separate")) {
      const std::string& output = at->upstreamOutput.str();
      // Vectors have outx, outy, outz and outw.
      const std::string names = "rgbaxyzw";
      const size_t at_name = output.size() == 4 ? names.find(output.back()) : std::string::npos;
      if (at_name != std::string::npos) channel = names[at_name % 4];
    } else if (starts_with(*node, "ND_extract_")) {
      const auto index = static_cast<int>(input_value(*node, "index").number_or(0));
      channel = std::string(1, "rgba"[std::clamp(index, 0, 3)]);
    } else if (!starts_with(*node, "ND_convert_") && !starts_with(*node, "ND_dot_")) {
      warn_("material.node", std::string(input) + " is connected to a node of type '" + node->nodeTypeId.str() +
                                 "', which is not read; its constant is used");
      return std::nullopt;
    }
    at = upstream(*node, "in");
  }
  warn_("material.node", std::string(input) + " is connected to no image; its constant is used");
  return std::nullopt;
}

std::optional<MaterialConnection> MaterialImages::read(const char* input, const MaterialConnection& connection) {
  const auto found = find_image(input, connection);
  Path id;
  if (!found || !add(*found, "", &id)) return std::nullopt;
  return MaterialConnection{id, found->channel};
}

// Texels from 0 to 1 are normals from -1 to 1; `scale` of the node steepens what lies in the plane.
std::optional<MaterialConnection> MaterialImages::read_normals(const char* input,
                                                               const MaterialConnection& connection) {
  const MaterialNode* const map = find(connection.upstreamNode);
  if (!map || !starts_with(*map, "ND_normalmap")) {
    warn_("material.node", std::string(input) + " is connected to no ND_normalmap; the mesh's normals are used");
    return std::nullopt;
  }
  const MaterialConnection* const in = upstream(*map, "in");
  const auto found = in ? find_image(input, *in) : std::nullopt;
  Path id;
  MaterialNode* const texture = found ? add(*found, "_" + std::string(input), &id) : nullptr;
  if (!texture) return std::nullopt;
  const auto scale = static_cast<float>(input_value(*map, "scale").number_or(1));
  texture->parameters["scale"] = hd::Vec4f(2 * scale, 2 * scale, 2, 1);
  texture->parameters["bias"] = hd::Vec4f(-scale, -scale, -1, 0);
  texture->parameters["sourceColorSpace"] = "raw";
  return MaterialConnection{id, "rgb"};
}

MaterialNode* MaterialImages::add(const Found& found, const std::string& use, Path* id) {
  *id = found.id.str() + use;
  const Value file = input_value(*found.image, "file");
  if (file.text_or("").empty()) {
    warn_("material.texture.file", found.id.str() + " has no file; its input's constant is used");
    return nullptr;
  }
  MaterialNode texture{"AlabasterTexture", {{"file", file}}, {}};
  texture.parameters["sourceColorSpace"] = space_of(input_value(*found.image, "colorSpace:file"));
  texture.parameters["wrapS"] = wrap_of(input_value(*found.image, "uaddressmode"));
  texture.parameters["wrapT"] = wrap_of(input_value(*found.image, "vaddressmode"));
  if (input_value(*found.image, "filtertype").text_or("") == "closest") texture.parameters["filter"] = "nearest";
  read_coordinates(*found.image, &texture);
  return &(to_->nodes[*id] = std::move(texture));
}

// Input `texcoord` comes from a primvar, maybe through arithmetic. Nodes are met from the image to the primvar, and
// applied the other way round.
void MaterialImages::read_coordinates(const MaterialNode& image, MaterialNode* texture) {
  std::vector<const MaterialNode*> steps;
  const MaterialConnection* at = upstream(image, "texcoord");
  const MaterialNode* node = at ? find(at->upstreamNode) : nullptr;
  while (node && !starts_with(*node, "ND_geompropvalue_") && !starts_with(*node, "ND_texcoord_") &&
         steps.size() < kLongest) {
    steps.push_back(node);
    at = upstream(*node, starts_with(*node, "ND_multiply_") || starts_with(*node, "ND_add_") ? "in1" : "in");
    node = at ? find(at->upstreamNode) : nullptr;
  }
  if (node && starts_with(*node, "ND_geompropvalue_"))
    texture->parameters["st"] = input_value(*node, "geomprop").text_or("st");
  Placement placement;
  for (auto step = steps.rbegin(); step != steps.rend(); ++step)
    if (!apply(**step, &placement))
      warn_("material.texture.st",
            "texture coordinates pass a node of type '" + (*step)->nodeTypeId.str() + "', which is not read");
  if (starts_with(image, "ND_tiledimage_")) {
    placement.multiply(pair_or(image, "uvtiling", Vec2f(1)));
    placement.offset -= pair_or(image, "uvoffset", Vec2f(0));
  }
  if (!placement.is_identity()) hd::support::place_image(placement.scale, placement.angle, placement.offset, texture);
}

}  // namespace alabaster::hydra
