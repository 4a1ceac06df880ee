// The render description (.json, schemas/render_description.json): what glTF cannot say. Also the one entrance for any
// scene file: .json, .gltf and .glb.
#pragma once

#include "delegate/gltf/gltf_scene.h"

namespace alabaster::hd::description {

struct SceneFile {
  bool ok = false;
  Path settings;             // the RenderSettings prim: always made (from the file, else from defaults)
  std::string color_config;  // OCIO config that the description names; empty: none
  std::vector<gltf::GltfSummary> gltf;
  std::vector<std::string> notes;  // "no camera: framed the scene", "no light: soft default dome"
};

/// Loads a scene and completes it: frames the scene when it has no camera, adds a soft default dome when it has no
/// light (and reports both). Unknown keys are errors that name the nearest known key and the place (JSON pointer,
/// line).
ALABASTER_API SceneFile LoadScene(const std::string& file, host::RetainedSceneDelegate* scene,
                                  const DiagnosticSink& sink);

/// The text of a schema by name: disney_material, lights, camera, render_settings, render_description. Null if unknown.
/// Embedded at build time from schemas/.
ALABASTER_API const char* SchemaText(const std::string& name);

}  // namespace alabaster::hd::description
