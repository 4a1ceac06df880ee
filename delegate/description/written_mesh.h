// The triangles of a mesh as a glTF file holds them. Internal to this room.
#pragma once

#include <stdexcept>

#include "delegate/host/retained_scene_delegate.h"

namespace alabaster::hd::description {

/// A part of a scene that files cannot hold. The text names the prim, and says why.
struct NotWritten : std::runtime_error {
  NotWritten(const Path& id, const std::string& why) : std::runtime_error(id.str() + " " + why) {}
};

/// The number of the set TEXCOORD_n for each primvar of texture coordinates.
using UvSets = std::map<Token, int>;

/// The primvars of a mesh that are texture coordinates.
std::vector<Token> uv_names(const host::MeshDescription& mesh);

struct TriangleList {
  std::vector<Vec3f> points;
  std::vector<Vec3f> normals;             // empty: none
  std::vector<Vec4f> tangents;            // empty: none
  std::vector<Vec4f> colors;              // with opacities; empty: none
  std::map<int, std::vector<Vec2f>> uvs;  // by the number of the set; v counts downwards
  std::vector<uint32_t> indices;
  bool is_cage = false;  // polygons are runs of triangles (support/ngon_encoding.h)
};

/// True if the mesh is a cage of a subdivision surface.
bool is_cage(const host::MeshDescription& mesh);

/// The sides that all rays see. Throws NotWritten where the camera's rays see others.
bool is_double_sided(const Path& id, const host::MeshDescription& mesh);

/// The primvars that a mesh without a material shows.
struct OwnLook {
  bool has_color = false, has_opacity = false;
  bool operator==(const OwnLook&) const = default;
};
OwnLook own_look(const host::MeshDescription& mesh);

/// The points of a cage keep their numbers, its faces their order and their first corners. Throws NotWritten.
/// `look`: of a mesh without a material, else the default.
TriangleList triangles_of(const Path& id, const host::MeshDescription& mesh, const UvSets& sets, const OwnLook& look);

}  // namespace alabaster::hd::description
