// Reading and writing by OpenImageIO. Internal to this room.
#pragma once

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>

#include "core/images/image_file.h"

namespace alabaster {

std::unique_ptr<ImageInput> open_image(const ImageSource& source, ImageFault& fault);
std::string encode_image(const ImageDescription& image, const RowSource& rows, std::vector<unsigned char>& file);

}  // namespace alabaster
