// The camera of a render as the matrices for which OpenEXR has attributes.
#pragma once

#include "core/camera/camera.h"

namespace alabaster::hd::rendering {

/// For row vectors: p' = p M, then divided by its fourth coordinate. As RenderMan and Arnold write them, which readers
/// of other programs expect. A camera that moves has those of its shutter's opening.
struct CameraMatrices {
  Matrix4d world_to_camera;  // x right, y up, z into the picture; world units
  /// x and y from -1 to 1 over the display window, y up. z from 0 at the near plane to 1 at the far one; without a near
  /// plane 0 is at distance 1, without a far one 1 is at infinity (orthographic: z counts from the near plane).
  Matrix4d world_to_ndc;
};
/// `camera`: with apertures that are conformed to the display window.
CameraMatrices camera_matrices(const CameraParameters& camera);

}  // namespace alabaster::hd::rendering
