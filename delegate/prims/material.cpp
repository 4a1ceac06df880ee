#include "core/material/disney_material.h"

#include <cmath>
#include <map>

#include "delegate/prims/parameters.h"
#include "delegate/prims/prims.h"
#include "delegate/support/nearest_name.h"

namespace alabaster::hd::prims {
namespace {

/// A node of type AlabasterTexture.
struct TextureNodeReader {
  const Path& id;
  const MaterialNode& node;
  SceneParam& param;
  std::optional<SceneFault>* fault;  // receives an image that cannot be read

  /// Empty without an image.
  std::optional<TextureLookup> read(Texels texels) const {
    TextureSource source;
    const Value file = parameter("file");
    source.path = file.text_or("");
    source.may_be_set = true;
    if (const auto* asset = file.get<AssetPath>()) source.bytes = asset->bytes;
    if (source.path.empty() && !source.bytes) {
      warn("material.texture.file", "a texture has no file; it is ignored");
      return std::nullopt;
    }
    source.color_space = parameter("sourceColorSpace").text_or("auto");
    if (source.color_space.empty()) source.color_space = "auto";
    if (source.color_space == "auto" && texels == Texels::numbers) source.color_space = "raw";
    source.wrap_s = word("wrapS", "wrap mode", kWraps);
    source.wrap_t = word("wrapT", "wrap mode", kWraps);
    source.filter = word("filter", "filter", kFilters);
    TextureLookup lookup;
    lookup.image = param.texture(source, fault);
    if (!lookup.image) return std::nullopt;
    if (const std::string set = parameter("st").text_or(""); !set.empty()) lookup.uv_set = set;
    lookup.transform = UvTransform(finite_or("stOffset", Vec2f(0, 0)), float(finite_or("stRotation")),
                                   finite_or("stScale", Vec2f(1, 1)));
    const Vec4f scale = finite_or("scale", Vec4f(1, 1, 1, 1)), bias = finite_or("bias", Vec4f(0, 0, 0, 0));
    lookup.scale = {scale.x, scale.y, scale.z}, lookup.alpha_scale = scale.w;
    lookup.bias = {bias.x, bias.y, bias.z}, lookup.alpha_bias = bias.w;
    lookup.is_linear = texels == Texels::colors;
    return lookup;
  }

 private:
  static constexpr std::pair<const char*, Wrap> kWraps[] = {
      {"repeat", Wrap::repeat}, {"mirror", Wrap::mirror}, {"clamp", Wrap::clamp}, {"black", Wrap::black}};
  static constexpr std::pair<const char*, TextureFilter> kFilters[] = {{"linear", TextureFilter::linear},
                                                                       {"nearest", TextureFilter::nearest}};

  Value parameter(const char* name) const {
    const auto found = node.parameters.find(name);
    return found == node.parameters.end() ? Value() : found->second;
  }

  void warn(const char* code, const std::string& text) const {
    alabaster::report(param.sink(), alabaster::Severity::warning, code, id.str(), text);
  }

  /// The first is the default.
  template <class Enum, size_t N>
  Enum word(const char* name, const char* meaning, const std::pair<const char*, Enum> (&words)[N]) const {
    const std::string given = parameter(name).text_or("");
    for (const auto& [text, value] : words)
      if (given == text) return value;
    if (!given.empty())
      warn("material.texture.word",
           std::string(meaning) + " '" + given + "' is not known; " + words[0].first + " is used");
    return words[0].second;
  }

  /// A number or a vector of a texture's placement and values; the default where it is not finite.
  template <class T>
  T finite_or(const char* name, const T& otherwise) const {
    const T value = parameter(name).get_or(otherwise);
    for (unsigned i = 0; i < T::dimensions(); ++i)
      if (!std::isfinite(value[int(i)])) return not_finite(name), otherwise;
    return value;
  }
  double finite_or(const char* name) const {
    const double value = parameter(name).number_or(0);
    return std::isfinite(value) ? value : (not_finite(name), 0.0);
  }
  void not_finite(const char* name) const {
    warn("material.texture.number", std::string(name) + " is not finite; the default is used");
  }
};

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
        read_connections(*surface, input, connections, material.get());
    }
    if (!material->scatters()) drop_scatter_distance(material.get());
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
    if (const MaterialParameter* row = find_material_parameter(name.str()))
      return report_fault(param_.sink(), id_.str(), name.str(), set_parameter(*row, value, constants), value);
    std::vector<std::string> names;
    for (const auto& parameter : material_parameters()) names.emplace_back(parameter.name);
    const std::string nearest = support::NearestName(name.str(), names);
    warn("material.parameter", "parameter '" + name.str() + "' is not known and is ignored" +
                                   (nearest.empty() ? std::string() : "; did you mean '" + nearest + "'?"));
  }

  void read_connections(const MaterialNode& surface, const Token& input,
                        const std::vector<MaterialConnection>& connections, DisneyMaterial* material) {
    if (connections.empty()) return;
    const bool coat = input == Token("coatNormal");
    if (coat || input == Token("normal")) {
      (coat ? material->coat_normal_map : material->normal_map) =
          read_lookup(connections.front().upstreamNode, input, Texels::numbers);
      return;
    }
    const MaterialParameter* row = find_material_parameter(input.str());
    if (!row || !row->is_textured())
      return warn("material.connection", input.str() + " cannot be textured; the connection is ignored" +
                                             (row ? " and the constant used" : ""));
    bool connected = false;
    for (const MaterialConnection& connection : connections) {
      const Channel channel = channel_of(connection, row->is_color());
      // Alpha is the same whatever its image's colours mean: it comes from the one that is read for colours.
      MaterialTexture* const texture =
          texture_of(connection.upstreamNode, input, channel == Channel::a ? Texels::colors : row->texels, material);
      if (!texture) continue;
      texture->uses.push_back({row, channel});
      connected = true;
    }
    // A constant that nobody gave must not scale the texture.
    if (connected && !surface.parameters.count(input)) set_parameter(*row, 1.0f, &material->constants);
  }

  Channel channel_of(const MaterialConnection& connection, bool color) const {
    const std::string& output = connection.upstreamOutput.str();
    constexpr std::pair<const char*, Channel> kOutputs[] = {
        {"rgb", Channel::rgb}, {"r", Channel::r}, {"g", Channel::g}, {"b", Channel::b}, {"a", Channel::a}};
    for (const auto& [name, channel] : kOutputs)
      if (output == name) return channel == Channel::rgb && !color ? Channel::r : channel;
    const Channel used = color ? Channel::rgb : Channel::r;
    warn("material.output", connection.upstreamNode.str() + " has no output '" + output + "'; " +
                                (color ? "rgb" : "r") + " is used (known: rgb, r, g, b, a)");
    return used;
  }

  /// The material's texture of a node, which several inputs share; null (reported) if it cannot be had.
  MaterialTexture* texture_of(const Path& node_id, const Token& input, Texels texels, DisneyMaterial* material) {
    const auto known = textures_.find({node_id, texels});
    if (known != textures_.end()) return &material->textures[known->second];
    std::optional<TextureLookup> lookup = read_lookup(node_id, input, texels);
    if (!lookup) return nullptr;
    textures_[{node_id, texels}] = material->textures.size();
    material->textures.push_back({std::move(*lookup), {}});
    return &material->textures.back();
  }

  std::optional<TextureLookup> read_lookup(const Path& node_id, const Token& input, Texels texels) const {
    const auto node = network_.nodes.find(node_id);
    if (node != network_.nodes.end() && node->second.nodeTypeId == Token("AlabasterTexture"))
      return TextureNodeReader{node_id, node->second, param_, fault_}.read(texels);
    if (node != network_.nodes.end() && node->second.nodeTypeId == Token("AlabasterPrimvar")) return TextureLookup();
    const std::string what = node == network_.nodes.end()
                                 ? node_id.str() + ", which does not exist"
                                 : "a node of unknown type '" + node->second.nodeTypeId.str() + "'";
    warn("material.node", input.str() + " is connected to " + what + "; its constant is used");
    return std::nullopt;
  }

  // Without a constant there is nothing to multiply.
  static void drop_scatter_distance(DisneyMaterial* material) {
    const MaterialParameter* const row = find_material_parameter("scatterDistance");
    for (MaterialTexture& texture : material->textures)
      std::erase_if(texture.uses, [row](const MaterialTexture::Use& use) { return use.parameter == row; });
    std::erase_if(material->textures, [](const MaterialTexture& texture) { return texture.uses.empty(); });
  }

  const Path& id_;
  const MaterialNetwork& network_;
  SceneParam& param_;
  std::optional<SceneFault>* fault_ = nullptr;
  std::map<std::pair<Path, Texels>, size_t> textures_;  // of the material, by node and meaning
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
