#include "delegate/description/written_gltf.h"

#include <algorithm>
#include <limits>
#include <numeric>

namespace alabaster::hd::description {
namespace {

using nlohmann::json;

constexpr const char* kInstancing = "EXT_mesh_gpu_instancing";

// RFC 3986: all but unreserved characters and the slashes of paths are written as %XX.
std::string uri_of(const std::string& file) {
  constexpr const char* kHex = "0123456789ABCDEF";
  constexpr std::string_view kMarks = "-._~/";
  std::string uri;
  for (const char c : file) {
    const auto byte = static_cast<unsigned char>(c);
    const bool is_plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9');
    if (is_plain || kMarks.find(c) != std::string_view::npos)
      uri += c;
    else
      uri.append({'%', kHex[byte >> 4], kHex[byte & 15]});
  }
  return uri;
}

// The reader names a mesh "<number of its first node>_<name>". These numbers sort as texts in the order of the meshes.
std::vector<size_t> numbers_that_sort(size_t count) {
  std::vector<size_t> numbers(count);
  std::iota(numbers.begin(), numbers.end(), size_t(0));
  std::sort(numbers.begin(), numbers.end(),
            [](size_t a, size_t b) { return std::to_string(a) + "_" < std::to_string(b) + "_"; });
  return numbers;
}

}  // namespace

GltfWriter::GltfWriter(size_t mesh_count, const std::map<std::string, NormalMaps>& normals)
    : normals_(normals), first_nodes_(numbers_that_sort(mesh_count)), nodes_(json::array()), roots_(json::array()) {
  for (size_t i = 0; i < mesh_count; ++i) nodes_.push_back(nullptr);
  document_["asset"] = {{"version", "2.0"}, {"generator", kGenerator}};
}

void GltfWriter::add(const PlacedMesh& placed, const TriangleList& triangles) {
  json attributes = {{"POSITION", write_points(triangles.points)}};
  if (!triangles.normals.empty()) attributes["NORMAL"] = write(triangles.normals, "VEC3");
  if (!triangles.tangents.empty()) attributes["TANGENT"] = write(triangles.tangents, "VEC4");
  if (!triangles.colors.empty()) attributes["COLOR_0"] = write(triangles.colors, "VEC4");
  for (const auto& [set, values] : triangles.uvs) attributes["TEXCOORD_" + std::to_string(set)] = write(values, "VEC2");
  json primitive = {{"attributes", std::move(attributes)},
                    {"indices", write(triangles.indices, "SCALAR")},
                    {"material", material(placed)}};
  if (triangles.is_cage) {
    primitive["extensions"]["FB_ngon_encoding"] = json::object();
    extensions_.insert("FB_ngon_encoding");
  }
  document_["meshes"].push_back({{"name", placed.name}, {"primitives", {std::move(primitive)}}});
  const json extensions = placed.instances ? instance_extension(*placed.instances) : json();
  place(first_nodes_[added_], placed, placed.places.front(), extensions);
  for (size_t i = 1; i < placed.places.size(); ++i) {
    nodes_.push_back(nullptr);
    place(nodes_.size() - 1, placed, placed.places[i], extensions);
  }
  ++added_;
}

GltfText GltfWriter::finish(const std::string& buffer_name) {
  if (!extensions_.empty()) document_["extensionsUsed"] = extensions_;
  if (extensions_.contains(kInstancing)) document_["extensionsRequired"] = {kInstancing};
  if (!nodes_.empty()) {
    document_["nodes"] = std::move(nodes_);
    document_["scenes"] = {{{"nodes", std::move(roots_)}}};
    document_["scene"] = 0;
    document_["buffers"] = {{{"uri", uri_of(buffer_name)}, {"byteLength", bytes_.size()}}};
  }
  return {document_.dump(1), std::move(bytes_)};
}

json GltfWriter::instance_extension(const InstanceList& instances) {
  json attributes = json::object();
  if (!instances.translations.empty()) attributes["TRANSLATION"] = write(instances.translations, "VEC3");
  if (!instances.rotations.empty()) attributes["ROTATION"] = write(instances.rotations, "VEC4");
  if (!instances.scales.empty()) attributes["SCALE"] = write(instances.scales, "VEC3");
  extensions_.insert(kInstancing);
  return {{kInstancing, {{"attributes", std::move(attributes)}}}};
}

void GltfWriter::place(size_t node, const PlacedMesh& placed, const Matrix4d& matrix, const json& extensions) {
  nodes_[node] = {{"name", placed.name}, {"mesh", added_}};
  if (matrix != Matrix4d()) nodes_[node]["matrix"] = std::vector<double>(&matrix.x[0][0], &matrix.x[0][0] + 16);
  if (!extensions.is_null()) nodes_[node]["extensions"] = extensions;
  roots_.push_back(node);
}

template <class T>
size_t GltfWriter::write(const std::vector<T>& values, const char* type) {
  const size_t begin = bytes_.size(), length = values.size() * sizeof(T);
  bytes_.append(reinterpret_cast<const char*>(values.data()), length);
  document_["bufferViews"].push_back({{"buffer", 0}, {"byteOffset", begin}, {"byteLength", length}});
  document_["accessors"].push_back({{"bufferView", document_["bufferViews"].size() - 1},
                                    {"componentType", std::is_same_v<T, uint32_t> ? 5125 : 5126},
                                    {"count", values.size()},
                                    {"type", type}});
  return document_["accessors"].size() - 1;
}

size_t GltfWriter::write_points(const std::vector<Vec3f>& points) {
  const size_t accessor = write(points, "VEC3");
  Vec3f low(std::numeric_limits<float>::max()), high(std::numeric_limits<float>::lowest());
  for (const Vec3f& p : points)
    for (int i = 0; i < 3; ++i) low[i] = std::min(low[i], p[i]), high[i] = std::max(high[i], p[i]);
  document_["accessors"][accessor]["min"] = {low.x, low.y, low.z};
  document_["accessors"][accessor]["max"] = {high.x, high.y, high.z};
  return accessor;
}

json GltfWriter::texture(const NormalMap& map) {
  const auto index_of = [&](const char* key, json entry) {
    json& all = document_[key];
    for (size_t i = 0; i < all.size(); ++i)
      if (all[i] == entry) return i;
    all.push_back(std::move(entry));
    return all.size() - 1;
  };
  constexpr int kRepeat = 10497, kMirror = 33648, kClamp = 33071;
  const int wrap = map.wrap == "repeat" ? kRepeat : map.wrap == "mirror" ? kMirror : kClamp;
  const size_t image = index_of("images", {{"uri", uri_of(map.file)}});
  const size_t sampler = index_of("samplers", {{"wrapS", wrap}, {"wrapT", wrap}});
  const size_t used = index_of("textures", {{"source", image}, {"sampler", sampler}});
  return {{"index", used}, {"texCoord", map.set}, {"scale", map.scale}};
}

json GltfWriter::make_material(const PlacedMesh& placed) {
  json made = {{"name", placed.material}, {"doubleSided", placed.double_sided}};
  if (placed.look) {  // the renderer's default: grey, or what the mesh shows
    const double base = placed.look->has_color ? 1 : double(0.8f), roughness = 0.5;
    made["pbrMetallicRoughness"] = {
        {"baseColorFactor", {base, base, base, 1}}, {"metallicFactor", 0}, {"roughnessFactor", roughness}};
    if (placed.look->has_opacity) made["alphaMode"] = "BLEND";
  }
  const auto maps = normals_.find(placed.material);
  if (maps == normals_.end()) return made;
  for (const auto& [input, map] : maps->second) {
    if (input == "normal") {
      made["normalTexture"] = texture(map);
      continue;
    }
    extensions_.insert("KHR_materials_clearcoat");
    made["extensions"]["KHR_materials_clearcoat"] = {{"clearcoatFactor", 1}, {"clearcoatNormalTexture", texture(map)}};
  }
  return made;
}

// In glTF a material says whether its meshes have a back. Two of one name are both what the description matches.
size_t GltfWriter::material(const PlacedMesh& placed) {
  json& all = document_["materials"];
  for (size_t i = 0; i < all.size(); ++i)
    if (all[i]["name"] == placed.material && all[i]["doubleSided"] == placed.double_sided) return i;
  json made = make_material(placed);  // before the list grows
  document_["materials"].push_back(std::move(made));
  return document_["materials"].size() - 1;
}

}  // namespace alabaster::hd::description
