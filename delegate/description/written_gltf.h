// Meshes and their places as a glTF document. Internal to this room.
#pragma once

#include <nlohmann/json.hpp>

#include "delegate/description/written_mesh.h"

namespace alabaster::hd::description {

struct GltfText {
  std::string document, buffer;
};

struct PlacedMesh {
  std::string name, material;
  bool double_sided = true;
  std::vector<Matrix4d> places;  // one at least
};

/// Takes the meshes one by one. LoadGltf gives them paths that sort as they were taken.
class GltfWriter {
 public:
  explicit GltfWriter(size_t mesh_count);
  void add(const PlacedMesh& placed, const TriangleList& triangles);
  /// `buffer_name`: of the file beside the document.
  GltfText finish(const std::string& buffer_name);

 private:
  template <class T>
  size_t write(const std::vector<T>& values, const char* type);
  size_t write_points(const std::vector<Vec3f>& points);
  size_t material(const std::string& name, bool is_double_sided);
  void place(size_t node, const PlacedMesh& placed, const Matrix4d& matrix);

  std::vector<size_t> first_nodes_;  // of each mesh
  size_t added_ = 0;
  nlohmann::json document_, nodes_, roots_;
  std::string bytes_;
};

}  // namespace alabaster::hd::description
