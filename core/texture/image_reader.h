// Rows of an encoded image. Internal to this room.
#pragma once

#include "core/images/image_file.h"
#include "core/texture/texture.h"

namespace alabaster {

class ImageReader {
 public:
  /// Opens PNG, JPEG, TIFF, EXR, HDR, WebP, BMP and TGA by their contents, not by their names. False + report
  /// otherwise, or above `max_pixels`. Called once.
  bool open(const TextureSource& source, size_t max_pixels, const DiagnosticSink& sink);
  const ImageLayout& layout() const { return input_->layout(); }
  /// As ImageInput::read_rows; 0 + report on failure.
  int read_rows(int y, std::vector<float>& pixels, const DiagnosticSink& sink);

 private:
  bool fail(const DiagnosticSink& sink, const char* code, const std::string& text) const;
  bool load_bytes(const TextureSource& source, size_t max_pixels, const DiagnosticSink& sink);
  bool check_exr(size_t max_pixels, const DiagnosticSink& sink) const;
  bool open_input(const DiagnosticSink& sink);

  std::string path_, format_;
  std::shared_ptr<const std::vector<uint8_t>> bytes_;  // null: the file is read from disk
  std::unique_ptr<ImageInput> input_;                  // reads bytes_
};

}  // namespace alabaster
