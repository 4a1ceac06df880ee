#include "delegate/gltf/gltf_material_builder.h"

namespace alabaster::hd::gltf {
namespace {

Token wrap_token(int wrap) {
  if (wrap == TINYGLTF_TEXTURE_WRAP_CLAMP_TO_EDGE) return "clamp";
  return wrap == TINYGLTF_TEXTURE_WRAP_MIRRORED_REPEAT ? "mirror" : "repeat";
}

float number_at(const tinygltf::Value& transform, const char* name, int index, double fallback) {
  return float(transform.Has(name) ? transform.Get(name).Get(index).GetNumberAsDouble() : fallback);
}

void set_transform(const tinygltf::Value& transform, MaterialNode* node) {
  node->parameters["stOffset"] = Vec2f(number_at(transform, "offset", 0, 0), number_at(transform, "offset", 1, 0));
  node->parameters["stScale"] = Vec2f(number_at(transform, "scale", 0, 1), number_at(transform, "scale", 1, 1));
  if (transform.Has("rotation")) node->parameters["stRotation"] = float(transform.Get("rotation").GetNumberAsDouble());
}

}  // namespace

std::vector<VertexColors> find_vertex_colors(const Document& document) {
  std::vector<VertexColors> found(document.model.materials.size());
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

Reading normal_reading(double scale) {
  const float s = float(scale);
  return {"rgb", "raw", {2 * s, 2 * s, 2, 1}, {-s, -s, -1, 0}};
}

MaterialBuilder::MaterialBuilder(const Document& document, const tinygltf::Material& material, const Path& id,
                                 std::string element, Report& report)
    : document_(document), material_(material), id_(id), element_(std::move(element)), report_(report) {
  surface_.nodeTypeId = "AlabasterDisney";
}

Vec3f MaterialBuilder::color(const char* name) const {
  const auto found = surface_.parameters.find(name);
  return found == surface_.parameters.end() ? Vec3f(1) : found->second.get_or(Vec3f(1));
}

double MaterialBuilder::number(const char* name, double fallback) const {
  const auto found = surface_.parameters.find(name);
  return found == surface_.parameters.end() ? fallback : found->second.number_or(fallback);
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

void MaterialBuilder::connect_primvar(const char* input, const char* primvar, const char* output) {
  MaterialNode node;
  node.nodeTypeId = "AlabasterPrimvar";
  node.parameters["varname"] = Token(primvar);
  connect_node(input, primvar, std::move(node), output);
}

void MaterialBuilder::square(const char* input) {
  set(input, color(input) * color(input));
  const auto found = surface_.inputConnections.find(input);
  if (found == surface_.inputConnections.end()) return;
  std::vector<MaterialConnection>& connections = found->second;
  for (size_t i = 0, n = connections.size(); i < n; ++i) connections.push_back(MaterialConnection(connections[i]));
}

void MaterialBuilder::warn(const char* code, const std::string& place, const std::string& text) const {
  report_.warning(code, element_name(element_, place), text);
}
void MaterialBuilder::inform(const char* code, const std::string& place, const std::string& text) const {
  report_.info(code, element_name(element_, place), text);
}
void MaterialBuilder::error(const char* code, const std::string& place, const std::string& text) const {
  report_.error(code, element_name(element_, place), text);
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
