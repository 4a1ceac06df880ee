// A polygon mesh as a host gives it: the cage of a subdivision surface, or the mesh itself.
// Terms and meanings are OpenUSD's (UsdGeomMesh) and OpenSubdiv's.
#pragma once

#include <string>
#include <variant>
#include <vector>

#include "core/diagnostics/report.h"
#include "core/math/vector.h"

namespace alabaster {

enum class SubdivisionScheme { none, catmull_clark, loop, bilinear };
enum class BoundaryRule { none, edge_only, edge_and_corner };
enum class FaceVaryingRule { all, none, boundaries, corners_only, corners_plus1, corners_plus2 };
enum class CreaseMethod { uniform, chaikin };
enum class TriangleSubdivision { catmull_clark, smooth };

/// One value for the mesh, or one per face, point, point, or face corner. Varying values are interpolated linearly over
/// the faces of a refined cage, those of vertices as its surface is.
enum class Interpolation { constant, uniform, varying, vertex, face_varying };

/// `indices` empty means identity. In a sanitized cage none is constant or uniform: they have become vertex and
/// face_varying with indices.
template <class T>
struct Primvar {
  Interpolation interpolation = Interpolation::vertex;
  std::vector<T> values;
  std::vector<int> indices;
  bool empty() const { return values.empty(); }
};

/// Texture coordinates, v up, under the name that textures ask for.
struct UvPrimvar : Primvar<Vec2f> {
  std::string name;
};

/// One to four numbers each, for materials and AOVs that read them by name.
struct NamedPrimvar {
  std::variant<Primvar<float>, Primvar<Vec2f>, Primvar<Vec3f>, Primvar<Vec4f>> values;
  std::string name;
};

struct Cage {
  SubdivisionScheme scheme = SubdivisionScheme::none;
  bool left_handed = false;  // winding of the faces
  std::vector<int> face_vertex_counts;
  std::vector<int> face_vertex_indices;
  std::vector<int> hole_indices;     // faces that are not drawn but still shape the limit surface
  std::vector<int> invisible_faces;  // not drawn; nothing else differs from a cage that shows them

  std::vector<int> crease_indices;  // polylines of points, concatenated
  std::vector<int> crease_lengths;
  std::vector<float> crease_sharpnesses;  // one per crease, or one per edge
  std::vector<int> corner_indices;
  std::vector<float> corner_sharpnesses;
  BoundaryRule boundary_rule = BoundaryRule::edge_and_corner;
  FaceVaryingRule face_varying_rule = FaceVaryingRule::corners_plus1;
  CreaseMethod crease_method = CreaseMethod::uniform;
  TriangleSubdivision triangle_subdivision = TriangleSubdivision::catmull_clark;

  std::vector<Vec3f> points;
  Primvar<Vec3f> normals;              // authored; ignored when refined
  Primvar<Vec4f> tangents;             // authored, for normal maps: direction of u, and +1 or -1; ignored when refined
  std::vector<UvPrimvar> uvs;          // of different names
  std::vector<NamedPrimvar> primvars;  // of different names; colours are in the rendering space
  std::vector<int> face_material;      // material slot per face; empty: all 0

  /// Unrefined, it has normals that are computed.
  bool has_smooth_normals() const {
    return normals.empty() && (scheme == SubdivisionScheme::catmull_clark || scheme == SubdivisionScheme::loop);
  }
};

/// Calls visit(primvar) for those that are refined with the surface and not empty, always in the same order.
template <class CageOrConst, class Visit>
void for_each_refined(CageOrConst& cage, const Visit& visit) {
  for (auto& uv : cage.uvs) visit(uv);
  for (auto& primvar : cage.primvars) std::visit(visit, primvar.values);
}

/// Makes a cage safe for everything after it (Embree and OpenSubdiv trust their input): drops or repairs what is broken
/// and reports each kind of fault once with its count and first element. Never throws. Returns false when nothing is
/// left to draw. Checked: counts >= 3 and their sum; indices in range; finite points (a face that uses a non-finite
/// point is dropped); faces and valences above 1000; holes, invisible faces, creases and corners in range, finite and
/// non-negative sharpness, crease pairs; primvar sizes; material slots; Loop with other faces than triangles (falls
/// back to catmull_clark).
bool sanitize_cage(Cage& cage, const std::string& where, const DiagnosticSink& sink);

}  // namespace alabaster
