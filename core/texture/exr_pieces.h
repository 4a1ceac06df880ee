// The compressed pieces of an EXR. Internal to this room.
#pragma once

#include "core/texture/exr_header.h"

namespace alabaster {

/// False, with the reason, where a piece of the part holds less than its pixels, or is missing. OpenEXR
/// 3.1 shows memory as it was for what a piece lacks: it compares sizes in PIZ, PXR24 and B44 alone. Sources: "OpenEXR
/// File Layout", openexr.com, and ImfDwaCompressor.cpp for what DWA counts.
bool check_exr_pieces(const FileBytes& file, const ExrPart& part, const ImageFunctions& images, ImageFault* fault);

}  // namespace alabaster
