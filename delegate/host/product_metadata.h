// The attributes of product files. Internal to this room.
#pragma once

#include "delegate/api/render_delegate.h"

namespace alabaster::hd::host {

/// The date, the camera, all settings, and what `stats` tell about the picture.
Dictionary product_metadata(const RenderDelegate& delegate, const Dictionary& stats, const Path& camera);

}  // namespace alabaster::hd::host
