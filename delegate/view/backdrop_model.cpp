#include "delegate/view/backdrop_model.h"

#include <algorithm>
#include <cstring>
#include <nlohmann/json.hpp>

namespace alabaster::view {
namespace {

using nlohmann::json;

constexpr int kFloat = 5126, kUnsigned = 5125;
constexpr uint32_t kMagic = 0x46546c67, kVersion = 2, kJson = 0x4e4f534a, kBinary = 0x004e4942;

void append(std::vector<uint8_t>* bytes, const void* data, size_t size) {
  const auto* const first = static_cast<const uint8_t*>(data);
  bytes->insert(bytes->end(), first, first + size);
}

void append_word(std::vector<uint8_t>* bytes, size_t number) {
  const auto word = uint32_t(number);
  append(bytes, &word, sizeof word);
}

// The document's buffer view and accessor for an array of numbers of four bytes each.
void add_accessor(json* document, std::vector<uint8_t>* binary, const void* data, size_t count, int type) {
  const bool vectors = type == kFloat;
  const size_t bytes = count * (vectors ? 12 : 4);
  (*document)["bufferViews"].push_back({{"buffer", 0}, {"byteOffset", binary->size()}, {"byteLength", bytes}});
  (*document)["accessors"].push_back({{"bufferView", (*document)["bufferViews"].size() - 1},
                                      {"componentType", type},
                                      {"count", count},
                                      {"type", vectors ? "VEC3" : "SCALAR"}});
  append(binary, data, bytes);
}

hd::Array<hd::Vec3f> vectors(const hd::host::MeshDescription& mesh, const char* name) {
  const auto found = mesh.primvars.find(name);
  return found == mesh.primvars.end() ? hd::Array<hd::Vec3f>() : found->second.value.get_or(hd::Array<hd::Vec3f>());
}

std::vector<uint32_t> triangles(const hd::MeshTopology& topology) {
  std::vector<uint32_t> all;
  size_t first = 0;
  for (const int32_t count : topology.faceVertexCounts) {
    for (int32_t k = 2; k < count; ++k)
      for (const size_t corner : {first, first + size_t(k) - 1, first + size_t(k)})
        all.push_back(uint32_t(topology.faceVertexIndices[corner]));
    first += size_t(count);
  }
  return all;
}

json box_of(const hd::Array<hd::Vec3f>& points, bool upper) {
  hd::Vec3f corner = points[0];
  for (const hd::Vec3f& p : points)
    for (int i = 0; i < 3; ++i) corner[i] = upper ? std::max(corner[i], p[i]) : std::min(corner[i], p[i]);
  return {corner.x, corner.y, corner.z};
}

}  // namespace

std::vector<uint8_t> model_of_mesh(const hd::host::MeshDescription& mesh, const std::string& name) {
  const hd::Array<hd::Vec3f> points = vectors(mesh, "points"), normals = vectors(mesh, "normals");
  const std::vector<uint32_t> indices = triangles(mesh.topology);
  json document{{"asset", {{"version", "2.0"}}}, {"scene", 0}, {"scenes", {{{"nodes", {0}}}}}};
  std::vector<uint8_t> binary;
  add_accessor(&document, &binary, points.data(), points.size(), kFloat);
  document["accessors"][0]["min"] = box_of(points, false), document["accessors"][0]["max"] = box_of(points, true);
  add_accessor(&document, &binary, normals.data(), normals.size(), kFloat);
  add_accessor(&document, &binary, indices.data(), indices.size(), kUnsigned);
  document["buffers"] = {{{"byteLength", binary.size()}}};
  document["materials"] = {{{"name", name}, {"doubleSided", true}}};
  const json primitive{{"attributes", {{"POSITION", 0}, {"NORMAL", 1}}}, {"indices", 2}, {"material", 0}};
  document["meshes"] = {{{"primitives", {primitive}}}};
  json matrix = json::array();
  // glTF's matrices are of columns, for points as columns: the same numbers in the same order.
  for (int i = 0; i < 16; ++i) matrix.push_back(mesh.transform[i / 4][i % 4]);
  document["nodes"] = {{{"name", name}, {"mesh", 0}, {"matrix", matrix}}};

  std::string text = document.dump();
  text.resize((text.size() + 3) / 4 * 4, ' ');
  std::vector<uint8_t> file;
  for (const size_t word : {size_t(kMagic), size_t(kVersion), 12 + 8 + text.size() + 8 + binary.size()})
    append_word(&file, word);
  append_word(&file, text.size());
  append_word(&file, kJson);
  append(&file, text.data(), text.size());
  append_word(&file, binary.size());
  append_word(&file, kBinary);
  append(&file, binary.data(), binary.size());
  return file;
}

}  // namespace alabaster::view
