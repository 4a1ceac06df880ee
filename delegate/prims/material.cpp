#include "core/material/disney_material.h"

#include "delegate/prims/parameters.h"
#include "delegate/prims/prims.h"
#include "delegate/support/nearest_name.h"

namespace alabaster::hd::prims {
namespace {

/// Reads one network; everything it cannot draw is reported once, with what is drawn instead.
class MaterialReader {
 public:
  MaterialReader(const Path& id, const MaterialNetwork& network, SceneParam& param)
      : id_(id), network_(network), param_(param) {}

  /// *fault receives an image that cannot be read.
  std::shared_ptr<const DisneyMaterial> read(std::optional<SceneFault>* fault) {
    fault_ = fault;
    auto material = std::make_shared<DisneyMaterial>();
    material->name = id_.str();
    const MaterialNode* surface = find_surface();
    if (surface) {
      for (const auto& [name, value] : surface->parameters) read_parameter(name, value, &material->constants);
      for (const auto& [input, connections] : surface->inputConnections)
        if (!connections.empty()) read_connection(*surface, input, connections.front(), material.get());
    }
    if (!material->scatters()) material->scatter_distance_map = nullptr;  // nothing to multiply
    return material;
  }

 private:
  void warn(const char* code, const std::string& text) const {
    alabaster::report(param_.sink(), alabaster::Severity::warning, code, id_.str(), text);
  }

  const MaterialNode* find_surface() const {
    const auto terminal = network_.terminals.find("surface");
    if (terminal == network_.terminals.end()) {
      warn("material.surface", "the network has no terminal 'surface'; the default material is used");
      return nullptr;
    }
    const auto node = network_.nodes.find(terminal->second.upstreamNode);
    if (node == network_.nodes.end()) {
      warn("material.surface", "terminal 'surface' names " + terminal->second.upstreamNode.str() +
                                   ", which is not a node of the network; the default material is used");
      return nullptr;
    }
    if (!(node->second.nodeTypeId == Token("AlabasterDisney"))) {
      warn("material.node", "node type '" + node->second.nodeTypeId.str() +
                                "' is not known; the default material is used (known: AlabasterDisney)");
      return nullptr;
    }
    return &node->second;
  }

  void read_parameter(const Token& name, const Value& value, DisneyParameters* constants) const {
    std::vector<std::string> names;
    for (const auto& parameter : material_parameters()) {
      if (name.str() == parameter.name) {
        report_fault(param_.sink(), id_.str(), name.str(), set_parameter(parameter, value, constants), value);
        return;
      }
      names.emplace_back(parameter.name);
    }
    const std::string nearest = support::NearestName(name.str(), names);
    warn("material.parameter", "parameter '" + name.str() + "' is not known and is ignored" +
                                   (nearest.empty() ? std::string() : "; did you mean '" + nearest + "'?"));
  }

  void read_connection(const MaterialNode& surface, const Token& input, const MaterialConnection& connection,
                       DisneyMaterial* material) const {
    const auto node = network_.nodes.find(connection.upstreamNode);
    if (node == network_.nodes.end() || !(node->second.nodeTypeId == Token("AlabasterTexture"))) {
      const std::string what = node == network_.nodes.end()
                                   ? connection.upstreamNode.str() + ", which does not exist"
                                   : "a node of unknown type '" + node->second.nodeTypeId.str() + "'";
      return warn("material.node", input.str() + " is connected to " + what + "; its constant is used");
    }
    std::string textured;
    for (const MaterialParameter& parameter : material_parameters()) {
      if (!parameter.map) continue;
      textured += (textured.empty() ? "" : " and ") + std::string(parameter.name);
      if (input != Token(parameter.name)) continue;
      auto& map = material->*parameter.map;
      map = read_texture(node->second, parameter.texels);
      // A constant that nobody gave must not scale the texture.
      if (map && !surface.parameters.count(input)) set_parameter(parameter, 1.0f, &material->constants);
      return;
    }
    warn("material.connection", "only " + textured + " can be textured; the connection of " + input.str() +
                                    " is ignored and its constant used");
  }

  std::shared_ptr<const Texture> read_texture(const MaterialNode& node, Texels texels) const {
    const auto parameter = [&](const char* name) {
      const auto found = node.parameters.find(name);
      return found == node.parameters.end() ? Value() : found->second;
    };
    const Value file = parameter("file");
    TextureSource source;
    source.path = file.text_or("");
    if (const auto* asset = file.get<AssetPath>()) source.bytes = asset->bytes;
    if (source.path.empty() && !source.bytes) {
      warn("material.texture.file", "a texture has no file; it is ignored");
      return nullptr;
    }
    source.color_space = parameter("sourceColorSpace").text_or("auto");
    if (source.color_space.empty()) source.color_space = "auto";
    if (source.color_space == "auto" && texels == Texels::numbers) source.color_space = "raw";
    source.wrap_s = wrap(parameter("wrapS"));
    source.wrap_t = wrap(parameter("wrapT"));
    const std::string st = parameter("st").text_or("st");
    if (!st.empty() && st != "st")
      warn("material.texture.st", "texture coordinates come from primvar 'st'; '" + st + "' is ignored");
    return param_.texture(source, fault_);
  }

  Wrap wrap(const Value& value) const {
    const std::string word = value.text_or("repeat");
    if (word == "mirror") return Wrap::mirror;
    if (word == "clamp") return Wrap::clamp;
    if (word == "black") return Wrap::black;
    if (!word.empty() && word != "repeat")
      warn("material.texture.wrap", "wrap mode '" + word + "' is not known; repeat is used");
    return Wrap::repeat;
  }

  const Path& id_;
  const MaterialNetwork& network_;
  SceneParam& param_;
  std::optional<SceneFault>* fault_ = nullptr;
};

}  // namespace

DirtyBits MaterialPrim::post_record(SceneDelegate& scene, SceneParam& param, DirtyBits bits) {
  if (!(bits & (dirty::kResource | dirty::kParams))) return dirty::kClean;
  MaterialNetwork network = scene.GetMaterialResource(GetId());
  if (network_ && *network_ == network) return dirty::kClean;
  std::optional<SceneFault> fault;
  param.post(GetId(), MaterialRecord{MaterialReader(GetId(), network, param).read(&fault)});
  param.set_fault(GetId(), std::move(fault));
  network_ = std::move(network);  // last: a network counts as known once it is posted
  return dirty::kClean;
}

}  // namespace alabaster::hd::prims
