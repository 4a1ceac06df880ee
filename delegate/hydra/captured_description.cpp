#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "delegate/description/render_description.h"
#include "delegate/hydra/captured_files.h"
#include "delegate/support/preview_surface.h"

namespace alabaster::hydra {
namespace {

using hd::Value;
using nlohmann::json;

// A float becomes the double that it is: the reader gets the same float back.
json to_json(const Value& value) {
  if (const auto* held = value.get<bool>()) return *held;
  if (const auto* held = value.get<int32_t>()) return *held;
  if (const auto* held = value.get<int64_t>()) return *held;
  if (const auto* held = value.get<hd::Array<hd::Vec4f>>()) {
    json all = json::array();
    for (const hd::Vec4f& v : *held) all.push_back({v.x, v.y, v.z, v.w});
    return all;
  }
  std::array<double, 4> numbers{};
  const size_t count = value.components(&numbers);
  if (count == 1) return numbers[0];
  if (count > 1) return std::vector<double>(numbers.begin(), numbers.begin() + static_cast<ptrdiff_t>(count));
  return value.text_or("");
}

json to_json(const hd::Matrix4d& matrix) {
  return std::vector<double>(&matrix.x[0][0], &matrix.x[0][0] + 16);
}

// A parameter of a texture's node, or the value that it has without one.
std::string word_of(const hd::MaterialNode& node, const char* name, const char* otherwise) {
  const auto found = node.parameters.find(name);
  return found == node.parameters.end() ? otherwise : found->second.text_or(otherwise);
}

json texture_of(const hd::Path& material, const hd::MaterialNetwork& network, const hd::MaterialConnection& connection,
                const Value& scale) {
  const auto found = network.nodes.find(connection.upstreamNode);
  if (found == network.nodes.end() || !(found->second.nodeTypeId == hd::Token("AlabasterTexture")))
    throw std::runtime_error(material.str() + " reads " + connection.upstreamNode.str() +
                             ", which is no AlabasterTexture and is not written");
  const hd::MaterialNode& node = found->second;
  for (const char* name : {"stScale", "stOffset", "stRotation", "filter", "bias", "scale"})
    if (node.parameters.contains(name))
      throw std::runtime_error(material.str() + " has a texture with " + name + ", which is not written");
  if (word_of(node, "wrapS", "repeat") != word_of(node, "wrapT", "repeat"))
    throw std::runtime_error(material.str() + " has a texture with two ways to wrap, which is not written");
  json texture = {{"file", word_of(node, "file", "")},
                  {"colorSpace", word_of(node, "sourceColorSpace", "auto")},
                  {"wrap", word_of(node, "wrapS", "repeat")},
                  {"st", word_of(node, "st", "st")}};
  if (const std::string channel = connection.upstreamOutput.str(); channel != "rgb") texture["channel"] = channel;
  if (!scale.empty()) texture["scale"] = to_json(scale);
  return texture;
}

// The parameters of its surface, connected ones as textures.
json to_json(const hd::Path& id, const hd::MaterialNetwork& given) {
  // The faults of a UsdPreviewSurface were warnings when it was synced.
  const hd::MaterialNetwork network = hd::support::TranslatePreviewSurface(given, [](auto&&...) {});
  const auto terminal = network.terminals.find("surface");
  const auto node =
      terminal == network.terminals.end() ? network.nodes.end() : network.nodes.find(terminal->second.upstreamNode);
  if (node == network.nodes.end() || !(node->second.nodeTypeId == hd::Token("AlabasterDisney")))
    throw std::runtime_error(
        id.str() + " is neither a UsdPreviewSurface nor made of AlabasterDisney nodes, which alone are written");
  if (network.terminals.contains("displacement"))
    throw std::runtime_error(id.str() + " displaces its meshes, which is not written");
  json parameters = json::object();
  for (const auto& [name, value] : node->second.parameters) parameters[name.str()] = to_json(value);
  for (const auto& [name, connections] : node->second.inputConnections) {
    if (connections.empty()) continue;
    if (name == hd::Token("normal") || name == hd::Token("coatNormal") || name == hd::Token("bump"))
      throw std::runtime_error(id.str() + " has a texture for " + name.str() + ", which is not written");
    if (connections.size() > 1)
      throw std::runtime_error(id.str() + " has two textures for " + name.str() + ", which are not written");
    const auto scale = node->second.parameters.find(name);
    parameters[name.str()] =
        texture_of(id, network, connections.front(), scale == node->second.parameters.end() ? Value() : scale->second);
  }
  return {{"match", PlainName(id)}, {"replace", parameters}};
}

json to_json(const hd::Path& id, const hd::host::LightDescription& light) {
  json made = {{"name", PlainName(id)}, {"type", light.type.str()}, {"transform", to_json(light.transform)}};
  for (const auto& [name, value] : light.parameters) made[name.str()] = to_json(value);
  return made;
}

// Descriptions hold the film in millimetres: the number that the reader multiplies to just this length, if there is
// one.
float millimetres_of(float length) {
  constexpr float kMetresPerMillimetre = 0.001f;
  float low = length / kMetresPerMillimetre, high = low;
  for (int i = 0; i < 4; ++i, low = std::nextafter(low, 0.0f), high = std::nextafter(high, 2 * high)) {
    if (low * kMetresPerMillimetre == length) return low;
    if (high * kMetresPerMillimetre == length) return high;
  }
  return length / kMetresPerMillimetre;
}

json camera_of(const hd::RenderPassState& state) {
  if (!state.freeCamera) throw std::runtime_error("the pass has no camera");
  if (!state.freeCamera->transformSamples.times.empty())
    throw std::runtime_error("the camera moves, which is not written");
  json camera = {{"transform", to_json(state.freeCamera->transform)}};
  for (const auto& [name, value] : state.freeCamera->parameters) {
    const bool is_film = name == hd::Token("focalLength") || name.str().find("Aperture") != std::string::npos;
    camera[name.str()] = is_film ? json(millimetres_of(value.get_or(0.0f))) : to_json(value);
  }
  return camera;
}

json settings_of(const hd::RenderPassState& state, const std::map<hd::Token, Value>& given) {
  static constexpr const char* kPolicies[] = {"matchVertically", "matchHorizontally", "fit", "crop", "dontConform"};
  const hd::Rect2i& window = state.framing.dataWindow;
  json settings = {{"resolution", {window.width(), window.height()}},
                   {"windowPolicy", kPolicies[static_cast<size_t>(state.windowPolicy)]},
                   {"studio", "off"}};
  for (const std::string& name : RenderSettingNames())
    if (const auto found = given.find(name); found != given.end()) settings[name] = to_json(found->second);
  return settings;
}

}  // namespace

std::string PlainName(const hd::Path& id) {
  std::string name = id.str();
  std::replace(name.begin(), name.end(), '/', '_');
  return name;
}

const std::vector<std::string>& RenderSettingNames() {
  static const auto names = [] {
    const json schema = json::parse(hd::description::SchemaText("render_settings"));
    std::vector<std::string> all;
    for (const auto& [name, property] : schema.at("properties").items()) all.push_back(name);
    return all;
  }();
  return names;
}

std::vector<std::string> LightParameterNames(const std::string& type) {
  static const json schema = json::parse(hd::description::SchemaText("lights"));
  std::vector<std::string> all;
  for (const auto& [name, property] : schema.at("properties").items()) {
    const json types = property.value("appliesTo", json{type});
    if (std::find(types.begin(), types.end(), type) != types.end()) all.push_back(name);
  }
  return all;
}

std::string MakeDescription(const CapturedScene& scene, const std::string& stem) {
  json description = {{"gltf", {{{"file", stem + ".gltf"}}}},
                      {"products", {{{"file", stem + ".exr"}, {"dataType", "float"}}}},
                      {"camera", camera_of(scene.state)},
                      {"settings", settings_of(scene.state, scene.settings)}};
  for (const auto& [id, network] : scene.materials) {
    const bool is_bound = std::any_of(scene.meshes.begin(), scene.meshes.end(),
                                      [&id = id](const auto& mesh) { return mesh.second.material == id; });
    if (is_bound) description["materials"].push_back(to_json(id, network));
  }
  for (const auto& [id, light] : scene.lights)
    if (light.visible) description["lights"].push_back(to_json(id, light));
  return description.dump(1);
}

}  // namespace alabaster::hydra
