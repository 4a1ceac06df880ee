// Cameras and punctual lights.
#pragma once

#include "delegate/gltf/gltf_document.h"
#include "delegate/host/retained_scene_delegate.h"

namespace alabaster::hd::gltf {

/// glTF gives an angle where the contract has a lens: the film is 24 mm high, and the focal length follows from yfov.
/// Without an aspectRatio the film is 36 mm wide; vertical framing then agrees with glTF under every window policy that
/// keeps the height. Orthographic apertures are twice the magnifications, in metres. Without a far plane
/// clippingRange.y is 1e30.
host::CameraDescription translate_camera(const tinygltf::Camera& camera, const Matrix4d& transform);

/// KHR_lights_punctual. Photometric values are kept as radiometric ones: the intensity of point and spot lights
/// (candela) becomes radiant intensity, and that of directional lights (lux) irradiance; choose the exposure
/// accordingly. `range`, a cut-off for game engines, is not used;
/// the reader says so.
host::LightDescription translate_light(const tinygltf::Light& light, const Matrix4d& transform);

}  // namespace alabaster::hd::gltf
