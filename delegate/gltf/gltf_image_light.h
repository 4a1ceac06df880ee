// EXT_lights_image_based: the scene's dome of light, given as the faces of a cube. Its path is
// /lights/image_<index>_<name>, beside those of the lights of nodes.
#pragma once

#include "delegate/gltf/gltf_document.h"
#include "delegate/host/retained_scene_delegate.h"

namespace alabaster::hd::gltf {

/// A dome light with the largest of the light's cube maps as its image, resampled to latitude and longitude and encoded
/// as EXR. Its colours are radiance. The smaller maps and the irradiance coefficients, which an engine without shadow
/// rays needs, are not read. A face that cannot be used leaves an image that is not there, so that the
/// renderer refuses it as it refuses every missing image. `document.image_light` has a value. Throws MemoryRefused.
host::LightDescription translate_image_light(Document* document, const Matrix4d& root, Report& report);

}  // namespace alabaster::hd::gltf
