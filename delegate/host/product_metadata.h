// The attributes of product files.
#pragma once

#include "delegate/api/render_delegate.h"

namespace alabaster::hd::host {

/// OpenEXR's own attributes of a camera: matrices for row vectors (delegate/rendering/camera_matrices.h). Statistics
/// have them after "camera.".
inline constexpr const char* kCameraMatrices[] = {"worldToCamera", "worldToNDC"};

/// The date, the camera, all settings, and the statistics of the picture in `stats`.
ALABASTER_API Dictionary product_metadata(const RenderDelegate& delegate, const Dictionary& stats, const Path& camera);

}  // namespace alabaster::hd::host
