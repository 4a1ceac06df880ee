// Environments that files hold as the faces of a cube. Internal to this room.
#pragma once

#include <memory>

#include "core/images/image_file.h"

namespace alabaster {

/// The latitude-longitude image of a cube's six faces, one below the other (OpenEXR's envmap). Null, with the fault, if
/// `cube` has not that shape.
std::unique_ptr<ImageInput> as_lat_long(std::unique_ptr<ImageInput> cube, ImageFault* fault);

}  // namespace alabaster
