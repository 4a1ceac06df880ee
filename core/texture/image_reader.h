// Rows of an encoded image. Internal to this room.
#pragma once

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>

#include <array>
#include <memory>
#include <optional>
#include <vector>

#include "core/texture/texture.h"

namespace alabaster {

struct ImageLayout {
  int width = 0, height = 0;
  size_t channels = 0;          // floats per pixel that read_rows gives
  std::array<size_t, 3> rgb{};  // which of them are colour; all the same for a grey image. Not multiplied by alpha
                                // wherever the format lets us choose
  std::optional<size_t> alpha;  // which of them, if any, is alpha
  bool bytes = false;           // a channel is a multiple of 1/255
  bool low_precision = false;   // integers of at most 16 bits: display-encoded unless told otherwise
};

class ImageReader {
 public:
  /// Opens PNG, JPEG, TIFF, EXR, HDR, WebP, BMP and TGA by their contents, not by their names. False + report
  /// otherwise, or above `max_pixels`. Called once.
  bool open(const TextureSource& source, size_t max_pixels, const DiagnosticSink& sink);
  const ImageLayout& layout() const { return layout_; }
  /// Decodes the rows from `y` on, as many as it likes, into `pixels`; returns how many, 0 + report on failure. To be
  /// called with y = 0, then with y plus the number returned.
  int read_rows(int y, std::vector<float>& pixels, const DiagnosticSink& sink);

 private:
  bool fail(const DiagnosticSink& sink, const char* code, const std::string& text) const;
  bool load_bytes(const TextureSource& source, const DiagnosticSink& sink);
  bool open_input(const DiagnosticSink& sink);

  std::string path_, format_;
  std::shared_ptr<const std::vector<uint8_t>> bytes_;  // null: the file is read from disk
  // The input reads through the proxy and must be closed before it goes.
  std::unique_ptr<OIIO::Filesystem::IOMemReader> proxy_;
  std::unique_ptr<OIIO::ImageInput> input_;
  ImageLayout layout_;
};

}  // namespace alabaster
