// glTF 2.0 (.gltf, .glb) as a scene: reads a document, checks all of it before trusting any of it, and describes it
// through a RetainedSceneDelegate.
//
// Paths, below the `root` given: /gltf/<stem>/nodes/<index>_<name>/<mesh primitive index>, /materials/<index>_<name>,
// and /cameras/<index>_<name>, /lights/<index>_<name> by the index and name of the node that holds them. A mesh of
// several nodes lies below the first of them, placed by that node's /instancer. Units: metres as in glTF; cameras and
// lights likewise.
#pragma once

#include "delegate/host/retained_scene_delegate.h"

namespace alabaster::hd::gltf {

struct GltfOptions {
  Path root = "/";     // prims are created below it
  Matrix4d transform;  // applied after the node transforms
  size_t max_file_bytes = size_t(4) << 30;
  int refine_level = 2;  // of meshes that carry FB_ngon_encoding (cages); other meshes are drawn as they are
};

struct GltfSummary {
  bool ok = false;  // false: nothing was added; the sink has been told why
  std::vector<Path> meshes, materials, cameras, lights;
  std::vector<std::string> extensionsUsed, extensionsRequired, extensionsIgnored;
};

/// Adds the document's scene to `scene`. Never throws. Errors name file and element ("buffers[0].uri") and a remedy; a
/// harmless fault is a warning and the rest is loaded.
ALABASTER_API GltfSummary LoadGltf(const std::string& file, const GltfOptions& options,
                                   host::RetainedSceneDelegate* scene, const DiagnosticSink& sink);

}  // namespace alabaster::hd::gltf
