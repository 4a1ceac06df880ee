// One glTF primitive as a mesh description.
#pragma once

#include "delegate/gltf/gltf_document.h"
#include "delegate/host/retained_scene_delegate.h"

namespace alabaster::hd::gltf {

/// The nodes that use a mesh give it these.
struct PrimitiveShape {
  int refine_level = 2;                  // of cages
  std::vector<double> weights;           // of morph targets; those missing are zero
  std::vector<Matrix4d> joint_matrices;  // of the skin; empty: none
};

/// Primitives that are one mesh.
struct MeshPart {
  std::vector<size_t> primitives;  // rising
  host::MeshDescription mesh;      // with a subset for each primitive if there are several
};

/// A warning. Each mesh that shares the parts gets it.
struct MeshFault {
  std::string code, element, text;  // the element is below the mesh: ".primitives[0]"
};

struct TranslatedMesh {
  std::vector<MeshPart> parts;
  std::vector<MeshFault> faults;
};

/// The meshes that `meshes[index]` is drawn as: topology and primvars, morphed and skinned, without transform, paths
/// and instancer. Primitives whose open edges coincide are one mesh (gltf_surfaces.h), as glTF splits one surface by
/// materials, unless they differ in FB_ngon_encoding. Those without triangles are left out (a fault), and points that
/// no triangle uses. Where one lacks an attribute of another, its normals are those of its triangles, its texture
/// coordinates are 0, and its colours 1, or those of the default material if it has none. Where one lacks tangents the
/// mesh has none. A mesh is double-sided if all its materials are.
///
/// Primvars: points, normals, tangents (Vec4f: the fourth number is the sign of the bitangent), st, st1, st2, ... (v
/// upwards), displayColor (linear) and displayOpacity. Primitives with FB_ngon_encoding become catmullClark cages,
/// whose normals come from refinement; all others get scheme none and keep their normals, or are flat without.
TranslatedMesh translate_mesh(const Document& document, size_t index, const PrimitiveShape& shape);

/// The triangle list of indices drawn in `mode` 4, 5 or 6 (glTF 2.0, section 3.7.2.1: triangles, strip, fan).
std::vector<uint32_t> triangle_list(const std::vector<uint32_t>& indices, int mode);

}  // namespace alabaster::hd::gltf
