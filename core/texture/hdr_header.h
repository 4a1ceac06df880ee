// Headers of Radiance pictures. Internal to this room.
#pragma once

#include <array>
#include <optional>

#include "core/texture/exr_header.h"

namespace alabaster {

struct HdrHeader {
  std::array<float, 3> scale{1, 1, 1};  // by which values are multiplied
  std::optional<std::array<float, 8>> chromaticities;
  int orientation = 1;  // Exif's number
};

/// False, with the reason, where its colours are no RGB, or a value is none. Source: Ward, "Radiance file formats":
/// EXPOSURE and COLORCORR, which may stand there repeatedly, have multiplied the values.
bool read_hdr_header(const FileBytes& file, HdrHeader* header, ImageFault* fault);

}  // namespace alabaster
