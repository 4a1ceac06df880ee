#include <algorithm>

#include "delegate/description/schema_check.h"
#include "delegate/description/written_parts.h"
#include "delegate/support/preview_surface.h"

namespace alabaster::hd::description {
namespace {

using nlohmann::json;

const json& properties() {
  static const json all = expanded_schema("disney_material")["properties"];
  return all;
}

const MaterialNode* find_node(const MaterialNetwork& network, const Path& path, const char* type) {
  const auto found = network.nodes.find(path);
  return found != network.nodes.end() && found->second.nodeTypeId == Token(type) ? &found->second : nullptr;
}

const Value* find(const MaterialNode& node, const char* name) {
  const auto found = node.parameters.find(name);
  return found == node.parameters.end() ? nullptr : &found->second;
}

std::string word(const MaterialNode& node, const char* name, const char* otherwise) {
  const Value* const held = find(node, name);
  return held ? held->text_or(otherwise) : otherwise;
}

/// The number that a vector holds in all of its components, if there is one.
std::optional<double> same_in_all(const Value* value, double otherwise) {
  if (!value) return otherwise;
  std::array<double, 4> numbers{};
  const size_t count = value->components(&numbers);
  if (count == 0 || std::any_of(numbers.begin(), numbers.begin() + static_cast<ptrdiff_t>(count),
                                [&](double n) { return n != numbers[0]; }))
    return std::nullopt;
  return numbers[0];
}

/// Writes the parts of one material.
class MaterialWriter {
 public:
  MaterialWriter(const Path& id, const MaterialNetwork& network, const UvSets& sets, WrittenFiles* files)
      : id_(id), network_(network), sets_(sets), files_(*files) {}

  WrittenMaterial run() {
    const auto terminal = network_.terminals.find("surface");
    const MaterialNode* const surface = terminal == network_.terminals.end()
                                            ? nullptr
                                            : find_node(network_, terminal->second.upstreamNode, "AlabasterDisney");
    if (!surface) refuse("is neither a UsdPreviewSurface nor made of AlabasterDisney nodes, which alone are written");
    WrittenMaterial made;
    for (const char* input : {"normal", "coatNormal"})
      if (const MaterialConnection* map = connection(*surface, input)) made.normals[input] = normals(*map, input);
    const bool keeps = !made.normals.empty();
    made.entry[keeps ? "set" : "replace"] = parameters(*surface, keeps);
    if (const MaterialConnection* bump = connection(*surface, "bump")) {
      if (made.normals.contains("normal")) refuse("has textures for bump and for normal, which are not written");
      made.entry["bump"] = heights(*bump, "bump");
    }
    if (const auto moved = network_.terminals.find("displacement"); moved != network_.terminals.end())
      made.entry["displacement"] = displacement(moved->second);
    return made;
  }

 private:
  [[noreturn]] void refuse(const std::string& why) const { throw NotWritten(id_, why); }

  /// The connection of an input, or null. Throws where there are several.
  const MaterialConnection* connection(const MaterialNode& node, const Token& name) const {
    const auto found = node.inputConnections.find(name);
    if (found == node.inputConnections.end() || found->second.empty()) return nullptr;
    if (found->second.size() > 1) refuse("has two textures for " + name.str() + ", which are not written");
    return &found->second.front();
  }

  // `all`: a material of glTF has values of its own for some, which the defaults replace.
  json parameters(const MaterialNode& surface, bool all) const {
    json made = json::object();
    if (all)
      for (const char* name : {"baseColor", "metallic", "roughness", "ior", "coat", "coatRoughness"})
        made[name] = properties().at(name).at("default");
    for (const auto& [name, property] : properties().items()) {
      const Value* const constant = find(surface, name.c_str());
      if (const MaterialConnection* connected = connection(surface, name)) {
        made[name] = texture(*connected, false);
        if (constant) made[name]["scale"] = to_json(*constant);
      } else if (constant) {
        made[name] = to_json(*constant, property);
      }
    }
    return made;
  }

  // The keys that all textures have. `scaled`: its scale and bias are written elsewhere.
  json texture(const MaterialConnection& from, bool scaled) const {
    const MaterialNode* const node = find_node(network_, from.upstreamNode, "AlabasterTexture");
    if (!node) refuse("reads " + from.upstreamNode.str() + ", which is no AlabasterTexture and is not written");
    const auto has = [&](const char* name, double otherwise) {
      return same_in_all(find(*node, name), otherwise) != otherwise;
    };
    for (const auto& [name, otherwise] :
         {std::pair("stScale", 1.0), std::pair("stOffset", 0.0), std::pair("stRotation", 0.0)})
      if (has(name, otherwise)) refuse(std::string("has a texture with ") + name + ", which is not written");
    if (!scaled && (has("scale", 1) || has("bias", 0)))
      refuse("has a texture with scale or bias, which is not written");
    if (word(*node, "filter", "linear") != "linear") refuse("has a texture with filter, which is not written");
    if (word(*node, "wrapS", "repeat") != word(*node, "wrapT", "repeat"))
      refuse("has a texture with two ways to wrap, which is not written");
    const Value* const file = find(*node, "file");
    json made = {{"file", files_.name_of(id_, file ? *file : Value())},
                 {"colorSpace", word(*node, "sourceColorSpace", "auto")},
                 {"wrap", word(*node, "wrapS", "repeat")},
                 {"st", uv_set(word(*node, "st", "st"))}};
    if (const std::string channel = from.upstreamOutput.str(); channel != "rgb") made["channel"] = channel;
    return made;
  }

  // The name that the reader gives to the set.
  std::string uv_set(const std::string& name) const {
    const auto found = sets_.find(name);
    if (found == sets_.end()) return name;  // no mesh has it
    return found->second == 0 ? "st" : "st" + std::to_string(found->second);
  }

  NormalMap normals(const MaterialConnection& from, const std::string& input) const {
    const json plain = texture(from, true);
    const MaterialNode& node = network_.nodes.at(from.upstreamNode);
    NormalMap map{plain["file"], plain["wrap"], 0, 1};
    const std::string what = "has a texture for " + input;
    const auto vector = [&](const char* name, const Vec4f& otherwise) {
      const Value* const held = find(node, name);
      return held ? held->get_or(otherwise) : otherwise;
    };
    const Vec4f scale = vector("scale", Vec4f(1));
    const float s = scale.x / 2;
    if (scale != Vec4f(2 * s, 2 * s, 2, 1) || vector("bias", Vec4f(0)) != Vec4f(-s, -s, -1, 0))
      refuse(what + " whose scale and bias are not glTF's, which is not written");
    if (plain["colorSpace"] != "raw" || plain.contains("channel") || map.wrap == "black")
      refuse(what + " that is not raw, has one channel or wraps to black, which is not written");
    if (map.file.find("<UDIM>") != std::string::npos) refuse(what + " of several images, which is not written");
    const Value* const file = find(node, "file");
    if (!file || !WrittenFiles::is_gltf_image(*file))
      refuse(what + " that is neither PNG, JPEG nor WebP, which glTF cannot hold; convert the image");
    const auto set = sets_.find(word(node, "st", "st"));
    if (set == sets_.end()) refuse(what + " by texture coordinates that no mesh has, which is not written");
    map.set = set->second;
    map.scale = double(s);
    return map;
  }

  json heights(const MaterialConnection& from, const char* what) const {
    json made = texture(from, true);
    const MaterialNode& node = network_.nodes.at(from.upstreamNode);
    const std::optional<double> scale = same_in_all(find(node, "scale"), 1);
    if (!scale || same_in_all(find(node, "bias"), 0) != 0.0)
      refuse(std::string("has a ") + what + " with several scales or a bias, which is not written");
    made["scale"] = *scale;
    if (!made.contains("channel"))
      refuse(std::string("has a ") + what + " by rgb, which is not written; name a channel");
    return made;
  }

  json displacement(const MaterialConnection& from) const {
    const MaterialNode* const node = find_node(network_, from.upstreamNode, "AlabasterDisplacement");
    const MaterialConnection* const image = node ? connection(*node, "displacement") : nullptr;
    if (!image) refuse("displaces its meshes by no AlabasterDisplacement of a texture, which alone is written");
    json made = texture(*image, false);
    const std::string space = word(*node, "space", "normal");
    made["space"] = space;
    if (space == "normal" && !made.contains("channel"))
      refuse("displaces its meshes by rgb, which is not written; name a channel");
    if (space != "normal" && made.contains("channel"))
      refuse("displaces its meshes by one channel along several axes, which is not written");
    for (const auto& [name, otherwise] : {std::pair("scale", 1.0f), std::pair("midlevel", 0.0f)})
      if (const Value* const held = find(*node, name)) made[name] = to_json(*held);
    return made;
  }

  const Path& id_;
  const MaterialNetwork& network_;
  const UvSets& sets_;
  WrittenFiles& files_;
};

}  // namespace

WrittenMaterial written_material(const Path& id, const MaterialNetwork& network, const UvSets& sets,
                                 WrittenFiles* files) {
  // The faults of a UsdPreviewSurface were warnings when it was synced.
  return MaterialWriter(id, support::TranslatePreviewSurface(network, [](auto&&...) {}), sets, files).run();
}

}  // namespace alabaster::hd::description
