#include "delegate/gltf/gltf_material_builder.h"

#include "core/material/disney_material.h"
#include "delegate/gltf/gltf_material.h"
#include "delegate/support/color_space.h"
#include "delegate/support/lookup.h"

namespace alabaster::hd::gltf {
namespace {

Token wrap_token(int wrap) {
  if (wrap == TINYGLTF_TEXTURE_WRAP_CLAMP_TO_EDGE) return "clamp";
  return wrap == TINYGLTF_TEXTURE_WRAP_MIRRORED_REPEAT ? "mirror" : "repeat";
}

void set_transform(const Json& transform, MaterialNode* node) {
  const auto pair = [&](const char* name, float fallback) {
    const Json& v = at(transform, name);
    return v.is_null() ? Vec2f(fallback) : Vec2f(v[0].get<float>(), v[1].get<float>());
  };
  node->parameters["stOffset"] = pair("offset", 0);
  node->parameters["stScale"] = pair("scale", 1);
  if (transform.contains("rotation")) node->parameters["stRotation"] = transform["rotation"].get<float>();
}

const MaterialRow& row_of(std::string_view layer, std::string_view factor) {
  const auto rows = material_rows();
  return *std::find_if(rows.begin(), rows.end(),
                       [&](const MaterialRow& row) { return layer == row.layer && factor == row.factor; });
}

double number_in(const Json& layer, const MaterialRow& row) {
  return layer.is_null() ? row.fallback : layer.value(row.factor, row.fallback);
}

Vec3f color_in(const Json& layer, const MaterialRow& row) {
  Vec3f color{float(row.fallback)};
  if (const Json& components = at(layer, row.factor); !components.is_null())
    for (int c = 0; c < 3; ++c) color[c] = components[size_t(c)].get<float>();
  return color;
}

}  // namespace

TextureUse texture_in(const Json& object, const char* name) {
  const Json& info = at(object, name);
  if (info.is_null()) return {};
  TextureUse use{info["index"].get<int>(), info.value("texCoord", 0), info.value("scale", 1.0)};
  const Json& transform = extension_of(info, "KHR_texture_transform");
  if (transform.is_null()) return use;
  use.transform = &transform;
  use.coordinates = transform.value("texCoord", use.coordinates);
  return use;
}

std::vector<VertexColors> find_vertex_colors(const Document& document) {
  std::vector<VertexColors> found(document.materials.size());
  for (const tinygltf::Mesh& mesh : document.model.meshes)
    for (const tinygltf::Primitive& primitive : mesh.primitives) {
      const auto color = primitive.attributes.find("COLOR_0");
      if (primitive.material < 0 || color == primitive.attributes.end()) continue;
      VertexColors& of = found[size_t(primitive.material)];
      of.colors = true;
      if (document.accessors[size_t(color->second)].components == 4) of.alphas = true;
    }
  return found;
}

MaterialBuilder::MaterialBuilder(const Document& document, const Json& material, const Path& id, std::string element,
                                 Report& report)
    : document_(document), material_(material), id_(id), element_(std::move(element)), report_(report) {
  surface_.nodeTypeId = "AlabasterDisney";
}

const Json& MaterialBuilder::layer(std::string_view name) const {
  if (name.empty()) return material_;
  return name == kCore ? at(material_, kCore) : extension_of(material_, name);
}

double MaterialBuilder::number(std::string_view of_layer, std::string_view factor) const {
  return number_in(layer(of_layer), row_of(of_layer, factor));
}

Vec3f MaterialBuilder::color(std::string_view of_layer, std::string_view factor) const {
  return color_in(layer(of_layer), row_of(of_layer, factor));
}

bool MaterialBuilder::has_weight(std::string_view of_layer) const {
  if (!has(of_layer)) return false;
  const auto rows = material_rows();
  const auto row =
      std::find_if(rows.begin(), rows.end(), [&](const MaterialRow& one) { return one.layer == of_layer; });
  return row->kind == FactorKind::number ? number_in(layer(of_layer), *row) != 0
                                         : color_in(layer(of_layer), *row) != Vec3f(0);
}

void MaterialBuilder::emit(std::string_view of_layer) {
  const Json& values = layer(of_layer);
  for (const MaterialRow& row : material_rows()) {
    if (!row.parameter || row.layer != of_layer) continue;
    if (row.kind == FactorKind::number)
      set(row.parameter, number_in(values, row));
    else
      set(row.parameter, color_in(values, row));
    if (row.texture) connect(row.parameter, texture_in(values, row.texture), row.reading);
  }
}

void MaterialBuilder::set(const char* name, const Vec3f& value) {
  surface_.parameters[name] = value;
  if (find_material_parameter(name)->texels == Texels::colors)
    surface_.parameters[std::string(name) + support::kColorSpace] = Token(support::kLinearRec709);
}

Vec3f MaterialBuilder::color_set(const char* name) const {
  return support::value_in(surface_.parameters, name).get_or(Vec3f(1));
}

double MaterialBuilder::number_set(const char* name, double fallback) const {
  return support::number_in(surface_.parameters, name, fallback);
}

MaterialNode MaterialBuilder::texture_node(const TextureUse& use, const Reading& reading) const {
  const tinygltf::Texture& texture = document_.model.textures[size_t(use.index)];
  MaterialNode node;
  node.nodeTypeId = "AlabasterTexture";
  // A texture without an image is passed on, too: the renderer tells what the picture lacks.
  const AssetPath none{element_name("textures", size_t(use.index)), "", nullptr};
  node.parameters["file"] = texture.source < 0 ? none : document_.images[size_t(texture.source)];
  node.parameters["sourceColorSpace"] = Token(reading.color_space);
  tinygltf::Sampler sampler;
  if (texture.sampler >= 0) sampler = document_.model.samplers[size_t(texture.sampler)];
  node.parameters["wrapS"] = wrap_token(sampler.wrapS);
  node.parameters["wrapT"] = wrap_token(sampler.wrapT);
  if (sampler.magFilter == TINYGLTF_TEXTURE_FILTER_NEAREST) node.parameters["filter"] = Token("nearest");
  if (use.coordinates > 0) node.parameters["st"] = Token(uv_set_name(use.coordinates));
  if (use.transform) set_transform(*use.transform, &node);
  if (reading.scale != Vec4f(1)) node.parameters["scale"] = reading.scale;
  if (reading.bias != Vec4f(0)) node.parameters["bias"] = reading.bias;
  return node;
}

void MaterialBuilder::connect_node(const char* input, const std::string& name, MaterialNode node, const char* output) {
  Path path = id_.append(name);
  for (int copy = 2; sources_.contains(path) && sources_[path] != node; ++copy)
    path = id_.append(name + "_" + std::to_string(copy));
  for (const auto& [known, source] : sources_)
    if (source == node) path = known;
  sources_[path] = std::move(node);
  surface_.inputConnections[input].push_back({path, output});
}

void MaterialBuilder::connect(const char* input, const TextureUse& use, const Reading& reading) {
  if (use.index >= 0) connect_node(input, input, texture_node(use, reading), reading.output);
}

void MaterialBuilder::connect_normal(const char* input, const TextureUse& use) {
  const float s = float(use.scale);
  connect(input, use, {"rgb", "raw", {2 * s, 2 * s, 2, 1}, {-s, -s, -1, 0}});
}

void MaterialBuilder::connect_primvar(const char* input, const char* primvar, const char* output) {
  MaterialNode node;
  node.nodeTypeId = "AlabasterPrimvar";
  node.parameters["varname"] = Token(primvar);
  connect_node(input, primvar, std::move(node), output);
}

void MaterialBuilder::square(const char* input) {
  set(input, color_set(input) * color_set(input));
  const auto found = surface_.inputConnections.find(input);
  if (found == surface_.inputConnections.end()) return;
  std::vector<MaterialConnection>& connections = found->second;
  for (size_t i = 0, n = connections.size(); i < n; ++i) connections.push_back(MaterialConnection(connections[i]));
}

MaterialNetwork MaterialBuilder::finish() {
  MaterialNetwork network;
  for (const auto& [input, connections] : surface_.inputConnections)
    for (const MaterialConnection& connection : connections)
      network.nodes[connection.upstreamNode] = sources_[connection.upstreamNode];
  const Path surface_id = id_.append("surface");
  network.nodes[surface_id] = std::move(surface_);
  network.terminals["surface"] = {surface_id, "surface"};
  return network;
}

}  // namespace alabaster::hd::gltf
