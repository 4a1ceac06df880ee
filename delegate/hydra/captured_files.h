// The files of a captured scene as text. Internal to this room.
#pragma once

#include "delegate/host/retained_scene_delegate.h"

namespace alabaster::hydra {

/// Names of the settings of schemas/render_settings.json.
const std::vector<std::string>& RenderSettingNames();
/// Names of the parameters that schemas/lights.json has for lights of this type.
std::vector<std::string> LightParameterNames(const std::string& type);

/// The name of a prim in these files: names of glTF hold no '/'.
std::string PlainName(const hd::Path& id);

struct CapturedGltf {
  std::string document, buffer;
};
/// Throws std::runtime_error, which names the prim, where glTF cannot hold the meshes.
CapturedGltf MakeGltf(const std::map<hd::Path, hd::host::MeshDescription>& meshes,
                      const std::map<hd::Path, hd::host::InstancerDescription>& instancers,
                      const std::string& buffer_name);

struct CapturedScene {
  const std::map<hd::Path, hd::host::MeshDescription>& meshes;
  const std::map<hd::Path, hd::MaterialNetwork>& materials;
  const std::map<hd::Path, hd::host::LightDescription>& lights;
  const hd::RenderPassState& state;
  const std::map<hd::Token, hd::Value>& settings;
};
/// A render description of the meshes of `stem`.gltf, which writes `stem`.exr, with the materials, lights, camera and
/// settings of the scene. Throws std::runtime_error where it cannot hold them.
std::string MakeDescription(const CapturedScene& scene, const std::string& stem);

}  // namespace alabaster::hydra
