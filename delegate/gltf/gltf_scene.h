// Reads glTF 2.0 (.gltf, .glb): checks all of a document before using any of it.
//
// Paths begin with /gltf/<stem>, followed by /nodes/<index>_<name>/<mesh primitive index>, or for several
// primitives that are one mesh /mesh_<index of the first>, whose subsets have the paths of the primitives,
// /materials/<index>_<name>, and /cameras/<index>_<name> or /lights/<index>_<name> with the index and name of the
// camera's or light's node. A mesh used by several nodes, or by one with EXT_mesh_gpu_instancing, lies below the first
// of them, placed by that node's /instancer; nodes with a skin or with morph weights of their own have meshes of their
// own. The artist's name of a prim is that of its material or node. Units are metres, as in glTF, for cameras and
// lights too.
#pragma once

#include "delegate/host/scene_source.h"

namespace alabaster::hd::gltf {

/// A document that is posed by its animation. It keeps what poses need: the nodes, the animation, and the buffers if
/// the animation deforms a mesh; nothing without an animation. After the last key a pose is held. Times are seconds.
/// Errors name the file, the element ("buffers[0].uri") and a remedy. A harmless fault is a warning, and everything
/// else is read.
ALABASTER_API std::unique_ptr<host::SceneSource> MakeGltfSource();

/// Makes a control mesh of the triangles of a loaded mesh, whose vertices glTF splits at seams: all that lie at one
/// position, to the bit, become one point. Other primvars become face-varying, and tangents go. Triangles with fewer
/// than three points are left out; returns how many.
ALABASTER_API size_t WeldVertices(host::MeshDescription* mesh);

}  // namespace alabaster::hd::gltf
