// Loads glTF 2.0 (.gltf, .glb): reads a document, checks all of it before using any of it, and adds it to a
// RetainedSceneDelegate.
//
// Paths begin with `root` and /gltf/<stem>, followed by /nodes/<index>_<name>/<mesh primitive index>,
// /materials/<index>_<name>, and /cameras/<index>_<name> or /lights/<index>_<name> with the index and name of the
// camera's or light's node. A mesh used by several nodes lies below the first of them, placed by that node's
// /instancer. Units are metres, as in glTF, for cameras and lights too.
#pragma once

#include "delegate/host/retained_scene_delegate.h"

namespace alabaster::hd::gltf {

struct GltfOptions {
  Path root = "/";     // prims are created below it
  Matrix4d transform;  // applied after the node transforms
  size_t max_file_bytes = size_t(4) << 30;
  int refine_level = 2;  // of meshes with FB_ngon_encoding (cages); other meshes are drawn as they are
};

struct GltfSummary {
  bool ok = false;  // false: nothing was added, for the reason reported
  std::vector<Path> meshes, materials, cameras, lights;
  std::vector<std::string> extensionsUsed, extensionsRequired, extensionsIgnored;
  std::vector<std::string> files;  // that were read: the document and its buffers
};

/// Adds the document's scene to `scene`. Never throws. Errors name the file, the element ("buffers[0].uri") and a
/// remedy. A harmless fault is a warning, and everything else is loaded.
ALABASTER_API GltfSummary LoadGltf(const std::string& file, const GltfOptions& options,
                                   host::RetainedSceneDelegate* scene, const DiagnosticSink& sink);

}  // namespace alabaster::hd::gltf
