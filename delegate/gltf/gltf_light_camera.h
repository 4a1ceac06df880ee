// Cameras and punctual lights.
#pragma once

#include "delegate/gltf/gltf_document.h"
#include "delegate/host/retained_scene_delegate.h"

namespace alabaster::hd::gltf {

/// glTF gives angles, the contract a lens: the film is 24 mm high and the focal length follows from yfov. Without an
/// aspectRatio the film is 36 mm wide: vertical framing is then as glTF wants it under every window policy that keeps
/// the height. Orthographic: apertures are twice the magnifications, in metres. No far plane: clippingRange.y is 1e30.
host::CameraDescription translate_camera(const tinygltf::Camera& camera, const Matrix4d& transform);

/// KHR_lights_punctual. Photometric units are carried over one to one: intensity of point and spot (candela) as radiant
/// intensity, of directional (lux) as irradiance; choose the exposure accordingly. `range` is a game engine's cut-off
/// and is not read.
host::LightDescription translate_light(const tinygltf::Light& light, const Matrix4d& transform);

}  // namespace alabaster::hd::gltf
