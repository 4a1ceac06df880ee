// The one symbol of libalabaster_images. Internal to this room.
#pragma once

#include <cstdint>

#include "core/images/image_file.h"

namespace alabaster {

/// Bumped whenever image_file.h changes a layout or a meaning.
inline constexpr uint32_t kImageInterface = 6;

/// Null if the interfaces differ.
using ImageLibraryEntry = const ImageFunctions*(uint32_t interface);
inline constexpr const char* kImageLibraryEntry = "alabaster_image_functions";

}  // namespace alabaster
