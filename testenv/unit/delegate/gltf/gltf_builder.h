// Makes small glTF documents in code.
#pragma once

#include <gtest/gtest.h>

#include "testenv/support/gltf_testing.h"

namespace alabaster::hd::gltf::testing {

template <class T>
constexpr int component_type() {
  if constexpr (std::is_same_v<T, int8_t>) return 5120;
  if constexpr (std::is_same_v<T, uint8_t>) return 5121;
  if constexpr (std::is_same_v<T, int16_t>) return 5122;
  if constexpr (std::is_same_v<T, uint16_t>) return 5123;
  if constexpr (std::is_same_v<T, uint32_t>) return 5125;
  return 5126;
}

class GltfBuilder {
 public:
  Json json = {{"asset", {{"version", "2.0"}}},
               {"scene", 0},
               {"scenes", {{{"nodes", {0}}}}},
               {"nodes", {{{"mesh", 0}}}},
               {"meshes", {{{"primitives", {{{"attributes", Json::object()}}}}}}}};

  std::vector<Json> more_buffers;  // after the one that holds all data

  Json& primitive() { return json["meshes"][0]["primitives"][0]; }
  Json& node(size_t n = 0) { return json["nodes"][n]; }

  /// Adds bytes as a buffer view; returns its index.
  template <class T>
  size_t view(const std::vector<T>& values) {
    binary_.resize((binary_.size() + 3) / 4 * 4);
    const size_t offset = binary_.size(), bytes = values.size() * sizeof(T);
    binary_.append(reinterpret_cast<const char*>(values.data()), bytes);
    json["bufferViews"].push_back({{"buffer", 0}, {"byteOffset", offset}, {"byteLength", bytes}});
    return json["bufferViews"].size() - 1;
  }
  /// Adds an accessor over values of its own; returns its index.
  template <class T>
  size_t add(const std::vector<T>& values, const std::string& type, bool normalized = false) {
    const size_t components = type == "SCALAR" ? 1 : type == "MAT4" ? 16 : size_t(type.back() - '0');
    json["accessors"].push_back({{"bufferView", view(values)},
                                 {"componentType", component_type<T>()},
                                 {"count", values.size() / components},
                                 {"type", type}});
    if (normalized) json["accessors"].back()["normalized"] = true;
    return json["accessors"].size() - 1;
  }
  /// Adds an accessor of zeros but for the values at some elements.
  size_t add_sparse(size_t count, const std::vector<uint16_t>& elements, const std::vector<float>& values,
                    const std::string& type) {
    const size_t indices = view(elements), replacements = view(values);
    json["accessors"].push_back({{"componentType", 5126},
                                 {"count", count},
                                 {"type", type},
                                 {"sparse",
                                  {{"count", elements.size()},
                                   {"indices", {{"bufferView", indices}, {"componentType", 5123}}},
                                   {"values", {{"bufferView", replacements}}}}}});
    return json["accessors"].size() - 1;
  }
  /// Adds an attribute to the first primitive.
  template <class T>
  void attribute(const std::string& name, const std::vector<T>& values, const std::string& type,
                 bool normalized = false) {
    primitive()["attributes"][name] = add(values, type, normalized);
  }
  /// The triangle (0,0,0), (1,0,0), (0,1,0), for the first primitive.
  void triangle() { attribute<float>("POSITION", {0, 0, 0, 1, 0, 0, 0, 1, 0}, "VEC3"); }

  /// Adds a channel to the first animation.
  void animate(size_t node, const std::string& path, const std::vector<float>& times, const std::vector<float>& values,
               const std::string& type, const std::string& interpolation = "LINEAR") {
    Json& animation = json["animations"][0];
    const size_t input = add(times, "SCALAR"), output = add(values, type);
    animation["samplers"].push_back({{"input", input}, {"output", output}, {"interpolation", interpolation}});
    animation["channels"].push_back(
        {{"sampler", animation["samplers"].size() - 1}, {"target", {{"node", node}, {"path", path}}}});
  }

  Json document() const {
    Json document = json;
    document["buffers"] = {{{"byteLength", binary_.size()}}};
    for (const Json& buffer : more_buffers) document["buffers"].push_back(buffer);
    return document;
  }
  const std::string& binary() const { return binary_; }
  std::string bytes() const { return make_glb(document().dump(), binary_); }
  Loaded load(const GltfOptions& options = {}) const {
    const TemporaryFolder folder;
    return testing::load(folder.write("made.glb", bytes()), options);
  }
  Loaded load_at(double seconds) const {
    GltfOptions options;
    options.time = seconds;
    return load(options);
  }

 private:
  std::string binary_;
};

/// The only mesh of a scene; a failure if there is another number of them.
inline const host::MeshDescription& only_mesh(const Loaded& loaded) {
  static const host::MeshDescription none;
  EXPECT_EQ(loaded.scene->GetMeshes().size(), 1u) << loaded.said();
  return loaded.scene->GetMeshes().size() == 1 ? loaded.scene->GetMeshes().begin()->second : none;
}

inline Vec3d transformed(const Vec3d& p, const Matrix4d& m) {
  Vec3d result;
  m.multVecMatrix(p, result);
  return result;
}

/// The points of a mesh in the world.
inline std::vector<Vec3d> world_points(const host::MeshDescription& mesh) {
  std::vector<Vec3d> points;
  for (const Vec3f& p : primvar<Array<Vec3f>>(mesh, "points")) points.push_back(transformed(Vec3d(p), mesh.transform));
  return points;
}

template <class V>
void expect_near(const V& a, const V& b, double tolerance = 1e-6) {
  EXPECT_LT(double((a - b).length()), tolerance) << Value(a).to_string() << " is not " << Value(b).to_string();
}

}  // namespace alabaster::hd::gltf::testing
