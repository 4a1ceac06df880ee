// The render description (.json, schemas/render_description.json): what glTF cannot say. Also the one entrance for any
// scene file: .json, .gltf and .glb.
#pragma once

#include "delegate/gltf/gltf_scene.h"

namespace alabaster::hd::description {

/// What a host changes about a scene while it is loaded. Everything goes through the same checks as a file does.
struct LoadOptions {
  /// Each "place=value", value as JSON or as bare text: "samples=16", "materials/skin.roughness=0.3",
  /// "lights/key.intensity=4", "meshes/head.refineLevel=3", "camera.fStop=2.8".
  std::vector<std::string> overrides;
  std::string camera;  // name or path of the camera to look through; empty: the scene's own choice
  /// Replaces every dome light: an image file, or a colour as one or three numbers; then, after a last comma, an
  /// intensity: "sky.hdr", "sky.hdr,0.5", "0.2,0.3,0.4", "0.2,0.3,0.4,2". Empty: the scene's own.
  std::string dome;
};

struct SceneFile {
  bool ok = false;
  Path settings;                       // the RenderSettings prim: always made (from the file, else from defaults)
  std::vector<Path> further_settings;  // one more for each other resolution or crop that products ask for
  std::string color_config;            // OCIO config that the description names; empty: none
  std::vector<gltf::GltfSummary> gltf;
  std::vector<std::string> notes;  // "no camera: framed the scene", "no light: added a soft dome"
};

/// Loads a scene and completes it: frames the scene when it has no camera, adds a soft default dome when it has no
/// light (and reports both). Unknown keys are errors that name the nearest known key and the place (JSON pointer,
/// line). Never throws; not ok when an error was reported, and then what `scene` holds is undefined but harmless.
ALABASTER_API SceneFile LoadScene(const std::string& file, host::RetainedSceneDelegate* scene,
                                  const DiagnosticSink& sink, const LoadOptions& options = {});

/// The text of a schema by name: disney_material, lights, camera, render_settings, render_description; and
/// quality_presets, which is no schema but settings and measurements. Null if unknown.
/// Embedded at build time from schemas/.
ALABASTER_API const char* SchemaText(const std::string& name);

}  // namespace alabaster::hd::description
