// Rows of an encoded image. Internal to this room.
#pragma once

#include <optional>

#include "core/files/input_file.h"
#include "core/images/image_file.h"
#include "core/memory/memory_budget.h"
#include "core/texture/texture.h"

namespace alabaster {

struct ImageLimits {
  size_t max_pixels = 0;
  MemoryReservation* memory = nullptr;  // holds what the opened file takes; may be null
};

class ImageReader {
 public:
  /// Opens PNG, JPEG, TIFF, EXR, HDR, WebP and TGA by their contents, not by their names. False + report otherwise, or
  /// above the limit. Throws MemoryRefused. Called once.
  bool open(const TextureSource& source, const ImageLimits& limits, const DiagnosticSink& sink);
  const ImageLayout& layout() const { return input_->layout(); }
  /// As ImageInput::read_rows; 0 + report on failure.
  int read_rows(int y, ImageRows& rows, const DiagnosticSink& sink);

 private:
  bool fail(const DiagnosticSink& sink, const char* code, const std::string& text) const;
  bool load_bytes(const TextureSource& source, const ImageLimits& limits, const DiagnosticSink& sink);
  bool clean_bytes(const ImageLimits& limits, const DiagnosticSink& sink);
  bool check_exr(size_t max_pixels, const DiagnosticSink& sink) const;
  bool open_input(const DiagnosticSink& sink);

  std::string path_, format_;
  std::optional<InputFile> file_;
  std::shared_ptr<const std::vector<uint8_t>> bytes_;  // null: file_ is read
  std::unique_ptr<ImageInput> input_;                  // reads them
};

}  // namespace alabaster
