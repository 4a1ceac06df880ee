// Writes a scene as files that LoadScene reads: to render it elsewhere, to report a picture, or to compare.
#pragma once

#include "delegate/host/retained_scene_delegate.h"

namespace alabaster::hd::description {

/// The prims of a scene, for hosts that hold them in another way than a RetainedSceneDelegate.
struct SceneParts {
  const std::map<Path, host::MeshDescription>& meshes;
  const std::map<Path, host::InstancerDescription>& instancers;
  const std::map<Path, MaterialNetwork>& materials;
  const std::map<Path, host::LightDescription>& lights;
  const std::map<Path, host::CameraDescription>& cameras;
};

/// Writes a render description, which `file` names (NAME.json), and beside it the meshes as NAME.gltf and NAME.bin, and
/// images that are in memory as NAME_image1.png and so on. They replace files of these names, each once it is complete
/// and the description last, but no NAME.gltf of another program and no file that the scene names. The description
/// names the other images by their own files, so a reader needs LoadOptions::allow_outside where these do not lie
/// beside it or below.
///
/// The files hold the picture of a pass of `state`: the meshes that it draws, the materials of these, all lights, its
/// camera (`freeCamera`, else `camera`), window and window policy, and those of `settings` that
/// schemas/render_settings.json has. "ocio" among them names the OpenColorIO config. The description names one product,
/// NAME.exr, with AOV color as floats. Floats are written as they are, so that the picture is the same to the byte,
/// but for the last bits of normals that are not of unit length, of texture coordinates (glTF counts v downwards), of
/// film (in millimetres) and of meshes that move. Primvars that no part of AOV color reads are left out. Meshes,
/// instances and lights whose place cannot be inverted are left out, as the renderer does.
///
/// Returns an empty string, or the reason, which names the prim and a remedy. Where the scene holds what these files
/// cannot (delegate/README.md has the list), nothing is written. Where a file cannot be written, the description stays
/// as it was, but files that were written before it may have been replaced. Never throws.
ALABASTER_API std::string WriteScene(const std::string& file, const SceneParts& scene, const RenderPassState& state,
                                     const std::map<Token, Value>& settings);
/// A state without a camera has that of the render settings which setting "renderSettingsPrimPath" names, else of the
/// first ones.
ALABASTER_API std::string WriteScene(const std::string& file, const host::RetainedSceneDelegate& scene,
                                     const RenderPassState& state, const std::map<Token, Value>& settings);

}  // namespace alabaster::hd::description
