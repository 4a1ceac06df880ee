// Rows of an encoded image. Internal to this room.
#pragma once

#include <optional>

#include "core/color/chromaticities.h"
#include "core/files/input_file.h"
#include "core/images/image_file.h"
#include "core/memory/memory_budget.h"
#include "core/texture/exr_header.h"
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
  /// By which the values of the file are multiplied.
  const std::array<float, 3>& scale() const { return scale_; }
  /// The primaries that the file gives to its linear values, if it does.
  const std::optional<Chromaticities>& chromaticities() const { return chromaticities_; }
  /// As ImageInput::read_rows; 0 + report on failure.
  int read_rows(int y, ImageRows& rows, const DiagnosticSink& sink);

 private:
  bool fail(const DiagnosticSink& sink, const char* code, const std::string& text) const;
  bool load_bytes(const TextureSource& source, const ImageLimits& limits, const DiagnosticSink& sink);
  bool clean_bytes(const ImageLimits& limits, const DiagnosticSink& sink);
  FileBytes file_bytes() const;
  bool check_exr(const TextureSource& source, size_t max_pixels, const DiagnosticSink& sink);
  bool check_hdr(const DiagnosticSink& sink);
  bool open_input(const DiagnosticSink& sink);

  std::string path_, format_;
  ImageSource chosen_;  // what is read of the file
  bool is_cube_ = false;
  std::array<float, 3> scale_{1, 1, 1};
  std::optional<Chromaticities> chromaticities_;
  std::optional<InputFile> file_;
  std::shared_ptr<const std::vector<uint8_t>> bytes_;  // null: file_ is read
  std::unique_ptr<ImageInput> input_;                  // reads them
};

}  // namespace alabaster
