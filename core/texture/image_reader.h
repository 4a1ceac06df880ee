// Rows of an encoded image. Internal to this room.
#pragma once

#include <array>
#include <memory>
#include <span>
#include <vector>

#include "core/texture/texture.h"

namespace alabaster {

struct ImageLayout {
  int width = 0, height = 0;
  size_t channels = 0;          // floats per pixel that read_rows gives
  std::array<size_t, 3> rgb{};  // which of them are colour; all the same for a grey image. Not multiplied by alpha
                                // wherever the format lets us choose
  bool low_precision = false;   // integers of at most 16 bits: display-encoded unless told otherwise
};

class ImageReader {
 public:
  virtual ~ImageReader() = default;
  virtual const ImageLayout& layout() const = 0;
  /// Decodes the rows from `y` on, as many as it likes, into `pixels`; returns how many, 0 + report on failure. To be
  /// called with y = 0, then with y plus the number returned.
  virtual int read_rows(int y, std::vector<float>& pixels, const DiagnosticSink& sink) = 0;
};

/// Opens PNG, JPEG, TIFF, EXR, HDR, WebP, BMP and TGA by their contents, not by their names. Null + report otherwise,
/// or above `max_pixels`.
std::unique_ptr<ImageReader> open_image(const TextureSource& source, size_t max_pixels, const DiagnosticSink& sink);

}  // namespace alabaster
