#include "core/material/node_inputs.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "delegate/looks/looks.h"
#include "delegate/prims/parameters.h"
#include "delegate/prims/prims.h"
#include "delegate/support/color_space.h"
#include "delegate/support/lookup.h"
#include "delegate/support/nearest_name.h"
#include "delegate/support/parameters.h"

namespace alabaster::hd::prims {
namespace {

/// The parameters of a node: a fault of one is reported, and its default used.
struct NodeReader {
  const Path& id;
  const MaterialNode& node;
  SceneParam& param;
  const alabaster::DiagnosticSink& sink;

  Value parameter(const char* name) const { return support::value_in(node.parameters, name); }

  void warn(const char* code, const std::string& text) const {
    alabaster::report(sink, alabaster::Severity::warning, code, id.str(), text);
  }

  /// The values of a table of core/material/node_inputs.h.
  template <class Inputs, class Rows>
  Inputs inputs(const Rows& rows) const {
    Inputs read;
    for (const auto& row : rows) {
      const Value value = parameter(row.name);
      if (value.empty()) continue;
      std::array<double, 4> numbers{};
      value.components(&numbers);
      const bool finite = std::all_of(numbers.begin(), numbers.end(), [](double n) { return std::isfinite(float(n)); });
      if (!finite || support::set_parameter(row, value, &read) != support::ParameterFault::none)
        warn("material.input", std::string(row.name) + " cannot be '" + value.to_string() + "'; the default is used");
    }
    return read;
  }
  TextureInputs texture_inputs() const { return inputs<TextureInputs>(alabaster::texture_inputs()); }
  /// What stands for an image that cannot be read, as other formats have it (delegate/looks).
  std::optional<Vec4f> fallback() const {
    std::array<double, 4> n{};
    const size_t count = parameter("fallback").components(&n);
    if (count == 0) return std::nullopt;
    if (count == 1) return Vec4f(float(n[0]));
    return Vec4f(float(n[0]), float(n[1]), float(n[2]), count == 4 ? float(n[3]) : 1);
  }
};

void set_scale(const TextureInputs& in, TextureLookup* lookup) {
  lookup->scale = {in.scale.x, in.scale.y, in.scale.z}, lookup->alpha_scale = in.scale.w;
  lookup->bias = {in.bias.x, in.bias.y, in.bias.z}, lookup->alpha_bias = in.bias.w;
}

/// A node of type AlabasterTexture.
struct TextureNodeReader : NodeReader {
  std::optional<std::string>* fault;  // receives an image that cannot be read
  const CancelToken& cancel;
  const std::vector<Value>& of_alpha;  // files whose alpha the material uses

  /// Empty without an image.
  std::optional<TextureLookup> read(Texels texels) const {
    TextureSource source = source_of(parameter("file"));
    source.may_be_set = true;
    if (source.path.empty() && !source.bytes) {
      warn("material.texture.file", "a texture has no file; it is ignored");
      return std::nullopt;
    }
    source.layer = parameter("layer").text_or("");
    source.color_space = parameter("sourceColorSpace").text_or("auto");
    if (source.color_space.empty()) source.color_space = "auto";
    if (source.color_space == "auto" && texels == Texels::numbers) source.color_space = "raw";
    // The opacity multiplies the colour once more.
    source.is_straight =
        texels == Texels::colors && std::find(of_alpha.begin(), of_alpha.end(), parameter("file")) != of_alpha.end();
    const TextureInputs in = texture_inputs();
    source.wrap_s = in.wrap_s, source.wrap_t = in.wrap_t, source.filter = in.filter;
    TextureLookup lookup;
    std::optional<std::string> missing;
    const bool may_miss = fallback() && source.fault.empty();  // one that may not be read is a fault all the same
    lookup.image =
        param.texture(source, may_miss ? &missing : fault, may_miss ? alabaster::DiagnosticSink() : sink, cancel);
    if (missing) warn("material.texture.fallback", *missing + "; its fallback is used");
    if (!lookup.image) return std::nullopt;
    if (const std::string set = parameter("st").text_or(""); !set.empty()) lookup.primvar = set;
    lookup.transform = UvTransform(in.st_offset, in.st_rotation, in.st_scale);
    set_scale(in, &lookup);
    lookup.is_linear = texels == Texels::colors;
    return lookup;
  }
};

/// Reads one network; everything it cannot draw is reported once, with what is drawn instead.
class MaterialReader {
 public:
  MaterialReader(const Path& id, const MaterialNetwork& network, SceneParam& param,
                 const alabaster::DiagnosticSink& sink, const CancelToken& cancel)
      : id_(id), network_(network), param_(param), sink_(sink), cancel_(cancel) {}

  /// *fault receives an image that cannot be read.
  std::shared_ptr<const DisneyMaterial> read(std::optional<std::string>* fault) {
    fault_ = fault;
    auto material = std::make_shared<DisneyMaterial>();
    material->name = id_.str();
    const MaterialNode* surface = find_surface();
    if (surface) {
      find_alphas(*surface);
      std::vector<const MaterialParameter*> of_file;
      for (const auto& [name, value] : surface->parameters)
        if (!read_color_space(name, value, &of_file)) read_parameter(name, value, &material->constants);
      for (const auto& [input, connections] : surface->inputConnections)
        read_connections(*surface, input, connections, material.get());
      if (const auto to_rendering = of_file.empty() ? nullptr : param_.rec709_to_rendering())
        for (const MaterialParameter* row : of_file) convert_color(*row, *to_rendering, &material->constants);
    }
    material->settle_opacity_mode();
    read_displacement(material.get());
    check_distances(*material);
    if (!material->scatters()) drop_distances(material.get());
    return material;
  }

 private:
  void warn(const char* code, const std::string& text) const {
    alabaster::report(sink_, alabaster::Severity::warning, code, id_.str(), text);
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
                                "' is not known; the default material is used (known: " + looks::LookTypes() + ")");
      return nullptr;
    }
    return &node->second;
  }

  /// The node at terminal "displacement", if there is one.
  void read_displacement(DisneyMaterial* material) {
    const auto terminal = network_.terminals.find("displacement");
    if (terminal == network_.terminals.end()) return;
    const auto node = network_.nodes.find(terminal->second.upstreamNode);
    if (node == network_.nodes.end() || !(node->second.nodeTypeId == Token("AlabasterDisplacement")))
      return warn("material.displacement",
                  "terminal 'displacement' must name a node of type AlabasterDisplacement; "
                  "meshes are not displaced");
    const auto connections = node->second.inputConnections.find("displacement");
    if (connections == node->second.inputConnections.end() || connections->second.empty())
      return warn("material.displacement", "nothing is connected to the input 'displacement' of " + node->first.str() +
                                               "; meshes are not displaced");
    const MaterialConnection& connection = connections->second.front();
    std::optional<TextureLookup> lookup = read_lookup(connection.upstreamNode, "displacement", Texels::numbers);
    if (!lookup) return;
    if (!lookup->image) return warn("material.displacement", "a primvar does not displace; connect a texture");
    const NodeReader reader{node->first, node->second, param_, sink_};
    const auto in = reader.inputs<DisplacementInputs>(displacement_inputs());
    const bool is_vector = in.space != DisplacementSpace::normal;
    material->displacement =
        Displacement{std::move(*lookup), in.space, channel_of(connection, is_vector ? Reads::color : Reads::number),
                     in.scale, in.midlevel};
  }

  // The space of a colour's constant. False: it is another parameter.
  bool read_color_space(const Token& name, const Value& value, std::vector<const MaterialParameter*>* of_file) const {
    const std::string_view text = name.str();
    if (!text.ends_with(support::kColorSpace)) return false;
    const MaterialParameter* const row =
        find_material_parameter(text.substr(0, text.size() - std::string_view(support::kColorSpace).size()));
    if (!row || !row->is_color()) return false;
    if (value.text_or("") == support::kLinearRec709)
      of_file->push_back(row);
    else
      warn("material.colorSpace", name.str() + " must be lin_rec709; the colour is taken to be in the rendering space");
    return true;
  }

  void read_parameter(const Token& name, const Value& value, DisneyParameters* constants) const {
    if (const MaterialParameter* row = find_material_parameter(name.str()))
      return report_fault(sink_, id_.str(), name.str(), support::set_parameter(*row, value, constants), value);
    std::vector<std::string> names;
    for (const auto& parameter : material_parameters()) names.emplace_back(parameter.name);
    warn("material.parameter",
         "parameter '" + name.str() + "' is not known and is ignored" + support::DidYouMean(name.str(), names));
  }

  void read_connections(const MaterialNode& surface, const Token& input,
                        const std::vector<MaterialConnection>& connections, DisneyMaterial* material) {
    if (connections.empty()) return;
    if (read_normal_map(input, connections.front(), material)) return;
    const MaterialParameter* row = find_material_parameter(input.str());
    if (!row || !row->is_textured())
      return warn("material.connection", input.str() + " cannot be textured; the connection is ignored" +
                                             (row ? " and the constant used" : ""));
    bool has_constant = surface.parameters.contains(input), connected = false;
    std::vector<std::pair<const Path*, Channel>> lost;
    for (const MaterialConnection& connection : connections) {
      const Channel channel = channel_of(connection, reads_of(*row));
      // Alpha is the same whatever its image's colours mean: it comes from the one that is read for colours.
      MaterialTexture* const texture = texture_of(connection.upstreamNode, input, channel, row->texels, material);
      if (texture)
        texture->uses.push_back({row, channel}), connected = true;
      else
        lost.emplace_back(&connection.upstreamNode, channel);
    }
    // A constant that nobody gave must not scale the texture, nor what stands for it.
    for (const auto& [node, channel] : lost)
      if (const auto texture = texture_node(*node)) connected = connected || texture->fallback();
    if (connected && !has_constant) has_constant = true, support::set_parameter(*row, 1.0f, &material->constants);
    for (const auto& [node, channel] : lost)
      if (channel == Channel::direction)
        turn_by_bias(*node, has_constant, &material->constants);
      else
        replace_image(*row, *node, channel, has_constant, &material->constants);
  }

  // A lost image counts as white, as files mean it that name none: scale and bias may hold a part of the constant. A
  // lost base colour must be seen.
  void replace_image(const MaterialParameter& row, const Path& node_id, Channel channel, bool has_constant,
                     DisneyParameters* constants) const {
    const std::optional<NodeReader> node = texture_node(node_id);
    if (!node || node->parameter("file").text_or("").empty()) return;
    const auto fallback = node->fallback();
    if (!fallback && row.member == decltype(row.member)(&DisneyParameters::base_color)) {
      constants->base_color = kLostColor;
      return;
    }
    if (!has_constant) return;
    const TextureInputs in = node->texture_inputs();
    const Vec4f white = fallback.value_or(in.scale + in.bias);
    const float one = white[channel == Channel::a ? 3 : component_of(channel)];
    const Vec3f all = channel == Channel::rgb ? Vec3f(white.x, white.y, white.z) : Vec3f(one);
    const Value held = support::get_parameter(row, *constants);
    if (row.is_color())
      support::set_parameter(row, held.get_or(Vec3f(1)) * all, constants);
    else
      support::set_parameter(row, held.number_or(1) * double(one), constants);
  }
  static constexpr Rgb kLostColor{1, 0, 1};

  // Without its image, a direction's bias alone turns: the constant, usually 1, would be a whole turn instead of the
  // file's rotation.
  void turn_by_bias(const Path& node_id, bool has_constant, DisneyParameters* constants) const {
    const std::optional<NodeReader> node = texture_node(node_id);
    if (!node) return;
    const float turns = node->texture_inputs().bias.x;
    const float constant = has_constant ? constants->anisotropic_rotation : 1;
    constants->anisotropic_rotation = constant * (turns - std::floor(turns));
  }

  std::optional<NodeReader> texture_node(const Path& id) const {
    const auto node = network_.nodes.find(id);
    if (node == network_.nodes.end() || !(node->second.nodeTypeId == Token("AlabasterTexture"))) return std::nullopt;
    return NodeReader{id, node->second, param_, sink_};
  }

  // False if the input is none of normals.
  bool read_normal_map(const Token& input, const MaterialConnection& connection, DisneyMaterial* material) const {
    const bool bump = input == Token("bump"), coat = input == Token("coatNormal");
    if (!bump && !coat && !(input == Token("normal"))) return false;
    std::optional<NormalMap>& map = coat ? material->coat_normal_map : material->normal_map;
    if (map) warn("material.bump", "a material has either a normal map or a bump map; the bump map is ignored");
    if (auto lookup = read_lookup(connection.upstreamNode, input, Texels::numbers))
      map = NormalMap{std::move(*lookup), bump, bump ? channel_of(connection, Reads::number) : Channel::rgb};
    return true;
  }

  enum class Reads { number, color, turns };
  static Reads reads_of(const MaterialParameter& row) {
    if (row.is_color()) return Reads::color;
    return row.member == decltype(row.member)(&DisneyParameters::anisotropic_rotation) ? Reads::turns : Reads::number;
  }

  Channel channel_of(const MaterialConnection& connection, Reads reads) const {
    const bool color = reads == Reads::color;
    const std::string& output = connection.upstreamOutput.str();
    const auto found = std::find(kTextureOutputs.begin(), kTextureOutputs.end(), output);
    const auto channel = static_cast<Channel>(found - kTextureOutputs.begin());
    if (found != kTextureOutputs.end() && (channel != Channel::direction || reads == Reads::turns))
      return channel == Channel::rgb && !color ? Channel::r : channel;
    const Channel used = color ? Channel::rgb : Channel::r;
    warn("material.output", connection.upstreamNode.str() + " has no output '" + output + "'; " +
                                (color ? "rgb" : "r") + " is used (known: rgb, r, g, b, a" +
                                (reads == Reads::turns ? ", direction)" : ")"));
    return used;
  }

  /// The material's texture of a node, which several inputs share; null (reported) if it cannot be had.
  MaterialTexture* texture_of(const Path& node_id, const Token& input, Channel channel, Texels texels,
                              DisneyMaterial* material) {
    if (channel == Channel::a) texels = Texels::colors;
    const std::tuple key(node_id, texels, channel == Channel::a && is_primvar(node_id));
    const auto known = textures_.find(key);
    if (known != textures_.end()) return &material->textures[known->second];
    std::optional<TextureLookup> lookup = read_lookup(node_id, input, texels, channel);
    if (!lookup) return nullptr;
    textures_[key] = material->textures.size();
    material->textures.push_back({std::move(*lookup), {}});
    return &material->textures.back();
  }

  bool is_primvar(const Path& node_id) const {
    const auto node = network_.nodes.find(node_id);
    return node != network_.nodes.end() && node->second.nodeTypeId == Token("AlabasterPrimvar");
  }

  // Without a name, displayColor and as alpha displayOpacity.
  static TextureLookup read_primvar(const NodeReader& node, Channel channel) {
    TextureLookup lookup;
    std::string name = node.parameter("varname").text_or("");
    if (name.empty()) name = channel == Channel::a ? kDisplayOpacity : kDisplayColor;
    const bool is_displayed = name == kDisplayColor || name == kDisplayOpacity;
    lookup.primvar = name;
    lookup.fallback = node.fallback().value_or(Vec4f(is_displayed ? 1.0f : 0.0f));
    set_scale(node.texture_inputs(), &lookup);
    return lookup;
  }

  std::optional<TextureLookup> read_lookup(const Path& node_id, const Token& input, Texels texels,
                                           Channel channel = Channel::rgb) const {
    const auto node = network_.nodes.find(node_id);
    if (node != network_.nodes.end() && node->second.nodeTypeId == Token("AlabasterTexture"))
      return TextureNodeReader{{node_id, node->second, param_, sink_}, fault_, cancel_, of_alpha_}.read(texels);
    if (is_primvar(node_id)) return read_primvar({node_id, node->second, param_, sink_}, channel);
    const std::string what = node == network_.nodes.end()
                                 ? node_id.str() + ", which does not exist"
                                 : "a node of unknown type '" + node->second.nodeTypeId.str() + "'";
    warn("material.node", input.str() + " is connected to " + what + "; its constant is used");
    return std::nullopt;
  }

  void find_alphas(const MaterialNode& surface) {
    for (const auto& [input, connections] : surface.inputConnections)
      for (const MaterialConnection& connection : connections)
        if (connection.upstreamOutput == Token("a"))
          if (const auto node = texture_node(connection.upstreamNode)) of_alpha_.push_back(node->parameter("file"));
  }

  void check_distances(const DisneyMaterial& material) const {
    const Rgb &distance = material.constants.scatter_distance, &path = material.constants.mean_free_path;
    if (max_component(distance) > 0 && std::min({path.r, path.g, path.b}) > 0)
      warn(
          "material.scatter",
          "scatterDistance is not used, because meanFreePath is given, too; for scatterDistance set meanFreePath to 0");
  }

  // Without a constant there is nothing to multiply.
  static void drop_distances(DisneyMaterial* material) {
    for (const char* name : {"scatterDistance", "meanFreePath"})
      for (MaterialTexture& texture : material->textures)
        std::erase_if(texture.uses,
                      [row = find_material_parameter(name)](const auto& use) { return use.parameter == row; });
    std::erase_if(material->textures, [](const MaterialTexture& texture) { return texture.uses.empty(); });
  }

  const Path& id_;
  const MaterialNetwork& network_;
  SceneParam& param_;
  const alabaster::DiagnosticSink& sink_;
  const CancelToken& cancel_;
  std::optional<std::string>* fault_ = nullptr;
  std::vector<Value> of_alpha_;                                // files whose alpha some input reads
  std::map<std::tuple<Path, Texels, bool>, size_t> textures_;  // of the material, by node, meaning, alpha of a primvar
};

// True if a node names the image; without a name, any.
bool has_images(const MaterialNetwork& network, const std::string& file = {}) {
  for (const auto& [path, node] : network.nodes)
    if (const auto named = node.parameters.find("file"); named != node.parameters.end()) {
      const auto* const asset = named->second.get<AssetPath>();
      if (names_image(named->second.text_or(""), file) || (asset && names_image(asset->authored, file))) return true;
    }
  return false;
}

}  // namespace

DirtyBits MaterialPrim::post_record(SceneDelegate& scene, SceneParam& param, DirtyBits bits) {
  if (!(bits & (dirty::kResource | dirty::kParams))) return dirty::kClean;
  auto network = std::make_shared<const MaterialNetwork>(scene.GetMaterialResource(GetId()));
  if (network_ && *network_ == *network) return dirty::kClean;
  display_name_ = scene.GetDisplayName(GetId());
  post(network, param);
  network_ = std::move(network);  // last: a network counts as known once it is posted
  return dirty::kClean;
}

void MaterialPrim::post(const std::shared_ptr<const MaterialNetwork>& network, SceneParam& param) {
  auto read = [&param, id = GetId(), name = display_name_, network,
               faults = faults_](const CancelToken& cancel) -> Record {
    std::vector<alabaster::Diagnostic> found;
    const alabaster::DiagnosticSink sink = [&](const alabaster::Diagnostic& d) { found.push_back(d); };
    const auto warn = [&](const char* code, const std::string& text) {
      alabaster::report(sink, alabaster::Severity::warning, code, id.str(), text);
    };
    MaterialRecord record;
    record.display_name = name;
    record.material = MaterialReader(id, looks::ReadLook(*network, warn), param, sink, cancel).read(&record.fault);
    const alabaster::DiagnosticSink tell = [&](const alabaster::Diagnostic& d) {
      const bool is_of_file = d.where != id.str() && !d.code.starts_with("material.");  // of the prim or its nodes
      if (is_of_file)
        param.file_faults().add(id, d);
      else if (param.sink())
        param.sink()(d);
    };
    faults->report(tell, std::move(found));
    return record;
  };
  const bool reads_images = has_images(*network);
  param.post_unread(GetId(), std::move(read), reads_images);
  if (!reads_images) return;
  param.set_reread(GetId(), [this, &param](const std::string& file) {
    if (network_ && has_images(*network_, file)) post(network_, param);
  });
}

}  // namespace alabaster::hd::prims
