// Meshes and their places as a glTF document. Internal to this room.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <set>

#include "delegate/description/written_mesh.h"

namespace alabaster::hd::description {

struct GltfText {
  std::string document, buffer;
};

/// A texture of normals in tangent space.
struct NormalMap {
  std::string file;  // relative to the document, or absolute
  std::string wrap;
  int set = 0;       // of texture coordinates
  double scale = 1;  // of x and y
};
/// Those of a material: "normal" and "coatNormal".
using NormalMaps = std::map<std::string, NormalMap>;

/// Many places as arrays: each is scaled, turned and moved (EXT_mesh_gpu_instancing).
struct InstanceList {
  std::vector<Vec3f> translations, scales;  // empty: none of them moves or scales
  std::vector<Vec4f> rotations;             // x, y, z, w; empty: none of them turns
};

struct PlacedMesh {
  std::string name, material;
  std::optional<OwnLook> look;  // of a mesh without a material of the scene
  bool double_sided = true;
  std::vector<Matrix4d> places;           // one at least
  std::optional<InstanceList> instances;  // before each of the places
};

/// Tells our documents from those of others.
inline constexpr const char* kGenerator = "Alabaster WriteScene";

/// Takes the meshes one by one. LoadGltf gives them paths that sort as they were taken.
class GltfWriter {
 public:
  /// `normals`: of materials by name.
  GltfWriter(size_t mesh_count, const std::map<std::string, NormalMaps>& normals);
  void add(const PlacedMesh& placed, const TriangleList& triangles);
  /// `buffer_name`: of the file beside the document.
  GltfText finish(const std::string& buffer_name);

 private:
  template <class T>
  size_t write(const std::vector<T>& values, const char* type);
  size_t write_points(const std::vector<Vec3f>& points);
  size_t material(const PlacedMesh& placed);
  nlohmann::json make_material(const PlacedMesh& placed);
  nlohmann::json texture(const NormalMap& map);
  nlohmann::json instance_extension(const InstanceList& instances);
  void place(size_t node, const PlacedMesh& placed, const Matrix4d& matrix, const nlohmann::json& extensions);

  const std::map<std::string, NormalMaps>& normals_;
  std::vector<size_t> first_nodes_;  // of each mesh
  size_t added_ = 0;
  nlohmann::json document_, nodes_, roots_;
  std::set<std::string> extensions_;
  std::string bytes_;
};

}  // namespace alabaster::hd::description
