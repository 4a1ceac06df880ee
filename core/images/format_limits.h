// Limits of the files that are written, which are checked before anything is rendered.
#pragma once

#include <climits>

#include "core/images/image_file.h"

namespace alabaster {

/// Pixels that such a file has a side, at most. libjpeg, as OpenImageIO 2.4 calls it, ends the process beyond that;
/// OpenImageIO 2.5 refuses larger PNGs.
constexpr int most_pixels(FileKind kind) {
  return kind == FileKind::jpeg ? 65500 : kind == FileKind::png ? 65535 : INT_MAX;
}
/// Bytes of the texts in a JPEG together, at most. Each of its blocks ends at 65533, and several repeat a text.
inline constexpr size_t kMostJpegText = 10000;
/// Bytes of the name of a channel or attribute in an EXR, at most. OpenEXR cuts longer ones off, and what it cannot
/// tell apart then is one.
inline constexpr size_t kLongestExrName = 255;

}  // namespace alabaster
