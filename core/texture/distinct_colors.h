// The colours of a row's texels, each once. Neighbours often have the same one, and a conversion costs more than to
// find that out: a picture of one bit a texel, a thousand times smaller as a file, is read as fast as it is decoded.
// Internal to this room.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/images/image_file.h"

namespace alabaster {

class DistinctColors {
 public:
  static constexpr size_t kMostTexels = size_t(1) << 14;  // of one find()

  /// Texels `first` to `first` + `count` - 1 of the rows. A colour may still come more than once.
  void find(const ImageRows& rows, const ImageLayout& layout, size_t first, size_t count);

  /// For each texel, the number of its colour.
  const std::vector<uint32_t>& places() const { return places_; }
  /// RGBA, opaque, in the file's encoding until the caller converts them.
  std::vector<float>& rgba() { return rgba_; }
  const std::vector<float>& rgba() const { return rgba_; }
  /// The same as the file has them, where that is bytes.
  const std::vector<std::array<uint8_t, 3>>& bytes() const { return bytes_; }

 private:
  void find_bytes(const uint8_t* texel, const ImageLayout& layout);
  void find_floats(const float* texel, const ImageLayout& layout);

  struct Known {
    uint32_t color = 0, place = 0;
    uint64_t round = 0;  // of find()
  };
  std::array<Known, 4096> known_{};
  uint64_t round_ = 0;
  std::vector<uint32_t> places_;
  std::vector<float> rgba_;
  std::vector<std::array<uint8_t, 3>> bytes_;
};

}  // namespace alabaster
