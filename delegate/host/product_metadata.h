// Names of attributes of product files. Internal to this room.
#pragma once

namespace alabaster::hd::host {

/// OpenEXR's own attributes of a camera: matrices for row vectors (delegate/rendering/camera_matrices.h). Statistics
/// have them after "camera.".
inline constexpr const char* kCameraMatrices[] = {"worldToCamera", "worldToNDC"};

}  // namespace alabaster::hd::host
