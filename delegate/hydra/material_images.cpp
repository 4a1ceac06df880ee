#include "delegate/hydra/material_images.h"

#include <cmath>
#include <numbers>

namespace alabaster::hydra {
namespace {

using hd::MaterialConnection;
using hd::MaterialNode;
using hd::Path;
using hd::Value;
using hd::Vec2f;

constexpr int kLongest = 32;  // nodes on the way to an image: networks may be circles

bool starts_with(const MaterialNode& node, const char* prefix) {
  return node.nodeTypeId.str().starts_with(prefix);
}

Value parameter(const MaterialNode& node, const char* name) {
  const auto found = node.parameters.find(name);
  return found == node.parameters.end() ? Value() : found->second;
}

Vec2f pair_or(const MaterialNode& node, const char* name, const Vec2f& otherwise) {
  return parameter(node, name).get_or(otherwise);
}

// MaterialX's address modes in our words.
const char* wrap_of(const Value& mode) {
  const std::string word = mode.text_or("periodic");
  if (word == "constant") return "black";
  return word == "clamp" || word == "mirror" ? word.c_str()[0] == 'c' ? "clamp" : "mirror" : "repeat";
}

// The name of a colour space in MaterialX's words; images of colours without one are left to their type.
const char* space_of(const Value& space) {
  const std::string word = space.text_or("");
  if (word == "srgb_texture" || word == "sRGB") return "sRGB";
  if (word == "raw" || word == "Raw" || word == "none") return "raw";
  return word == "lin_rec709" ? "linear" : "auto";
}

// AlabasterTexture places coordinates with v down, from the upper left corner; MaterialX with v up.
void place(const Vec2f& scale, float angle, const Vec2f& translation, MaterialNode* texture) {
  const float c = std::cos(angle), s = std::sin(angle);
  texture->parameters["stScale"] = scale;
  texture->parameters["stRotation"] = angle;
  texture->parameters["stOffset"] = Vec2f(translation.x - s * scale.y, 1 - translation.y - c * scale.y);
}

}  // namespace

const MaterialNode* MaterialImages::find(const Path& id) const {
  const auto found = from_.nodes.find(id);
  return found == from_.nodes.end() ? nullptr : &found->second;
}

const MaterialConnection* MaterialImages::upstream(const MaterialNode& node, const char* input) const {
  const auto found = node.inputConnections.find(input);
  return found == node.inputConnections.end() || found->second.empty() ? nullptr : &found->second.front();
}

// Conversions pass their input on; separations choose a channel of it.
std::optional<MaterialImages::Found> MaterialImages::find_image(const char* input,
                                                                const MaterialConnection& connection) {
  const MaterialConnection* at = &connection;
  std::string channel;
  for (int i = 0; at && i < kLongest; ++i) {
    const MaterialNode* const node = find(at->upstreamNode);
    if (!node) break;
    if (starts_with(*node, "ND_image_") || starts_with(*node, "ND_tiledimage_")) {
      const bool is_number = starts_with(*node, "ND_image_float") || starts_with(*node, "ND_tiledimage_float");
      return Found{at->upstreamNode, node, channel.empty() ? is_number ? "r" : "rgb" : channel};
    }
    if (starts_with(*node, "ND_separate")) {
      const std::string& output = at->upstreamOutput.str();
      if (output.starts_with("out") && output.size() == 4) channel = output.substr(3);
    } else if (starts_with(*node, "ND_extract_")) {
      const auto index = static_cast<int>(parameter(*node, "index").number_or(0));
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
std::optional<MaterialConnection> MaterialImages::read_normals(const char* input, const MaterialConnection& connection) {
  const MaterialNode* const map = find(connection.upstreamNode);
  if (!map || !starts_with(*map, "ND_normalmap")) {
    warn_("material.node", std::string(input) + " is connected to no ND_normalmap; the mesh's normals are used");
    return std::nullopt;
  }
  const MaterialConnection* const in = upstream(*map, "in");
  const auto found = in ? find_image(input, *in) : std::nullopt;
  Path id;
  MaterialNode* const texture = found ? add(*found, "_normals", &id) : nullptr;
  if (!texture) return std::nullopt;
  const auto scale = static_cast<float>(parameter(*map, "scale").number_or(1));
  texture->parameters["scale"] = hd::Vec4f(2 * scale, 2 * scale, 2, 1);
  texture->parameters["bias"] = hd::Vec4f(-scale, -scale, -1, 0);
  texture->parameters["sourceColorSpace"] = "raw";
  return MaterialConnection{id, "rgb"};
}

MaterialNode* MaterialImages::add(const Found& found, const char* use, Path* id) {
  *id = found.id.str() + use;
  const Value file = parameter(*found.image, "file");
  if (file.text_or("").empty()) {
    warn_("material.texture.file", found.id.str() + " has no file; its input's constant is used");
    return nullptr;
  }
  MaterialNode texture{"AlabasterTexture", {{"file", file}}, {}};
  texture.parameters["sourceColorSpace"] = space_of(parameter(*found.image, "colorSpace:file"));
  texture.parameters["wrapS"] = wrap_of(parameter(*found.image, "uaddressmode"));
  texture.parameters["wrapT"] = wrap_of(parameter(*found.image, "vaddressmode"));
  if (parameter(*found.image, "filtertype").text_or("") == "closest") texture.parameters["filter"] = "nearest";
  read_coordinates(*found.image, &texture);
  return &(to_->nodes[*id] = std::move(texture));
}

// Input `texcoord` comes from a primvar, maybe through ND_place2d.
void MaterialImages::read_coordinates(const MaterialNode& image, MaterialNode* texture) {
  if (starts_with(image, "ND_tiledimage_"))
    place(pair_or(image, "uvtiling", Vec2f(1)), 0, pair_or(image, "uvoffset", Vec2f(0)) * -1, texture);
  const MaterialConnection* at = upstream(image, "texcoord");
  const MaterialNode* node = at ? find(at->upstreamNode) : nullptr;
  if (node && starts_with(*node, "ND_place2d")) {
    // uv' = R (uv - pivot - offset) / scale + pivot, with a rotation clockwise
    const Vec2f scale = pair_or(*node, "scale", Vec2f(1)), offset = pair_or(*node, "offset", Vec2f(0));
    const auto degrees = static_cast<float>(parameter(*node, "rotate").number_or(0));
    if (pair_or(*node, "pivot", Vec2f(0)) != Vec2f(0) || scale.x == 0 || scale.y == 0 || degrees != 0)
      warn_("material.place2d", "the pivot and the rotation of ND_place2d are not read");
    const Vec2f inverse(scale.x == 0 ? 1 : 1 / scale.x, scale.y == 0 ? 1 : 1 / scale.y);
    place(inverse, 0, offset * inverse * -1.0f, texture);
    at = upstream(*node, "texcoord");
    node = at ? find(at->upstreamNode) : nullptr;
  }
  if (node && starts_with(*node, "ND_geompropvalue_")) {
    texture->parameters["st"] = parameter(*node, "geomprop").text_or("st");
  } else if (node && !starts_with(*node, "ND_texcoord_")) {
    warn_("material.texture.st", "texture coordinates come from a node of type '" + node->nodeTypeId.str() +
                                     "', which is not read; primvar st is used");
  }
}

}  // namespace alabaster::hydra
