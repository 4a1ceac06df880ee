// The rows of an image, packed as small as they go without loss. Internal to this room.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "core/images/image_file.h"
#include "core/memory/memory_budget.h"
#include "core/texture/distinct_colors.h"
#include "core/texture/texel_plane.h"

namespace alabaster {

/// One of `bytes` and `halves` holds the colours, one of the others the alpha, if some texel is not opaque.
struct PackedImage {
  bool is_grey = false;  // one element per colour instead of three
  PackedTexels<uint8_t> bytes, alpha_bytes;
  PackedTexels<uint16_t> halves, alpha_halves;
};

/// Takes the rows of an image with the colours that they become in the rendering space. A byte of the file stays a byte
/// if equal bytes become equal values in all the image. A palette holds these, so the conversion need not be known.
/// Everything else becomes halves; the palette's values are halves, too. Non-finite alpha is 1.
class TexelPacker {
 public:
  /// `memory` outlives it, and holds what it takes in addition to what the caller has it hold. Throws MemoryRefused.
  TexelPacker(const ImageLayout& layout, MemoryReservation* memory);
  /// The texels of `rows` from `first` on whose colours were found, and then converted.
  void add(const DistinctColors& colors, const ImageRows& rows, size_t first);
  /// After the last row, once.
  PackedImage take();

 private:
  using Color = std::array<uint16_t, 3>;  // bits of halves
  struct Palette {
    std::array<std::array<uint16_t, 256>, 3> values{};
    std::array<std::array<bool, 256>, 3> known{};
  };
  bool fits_palette(const std::array<uint8_t, 3>& bytes, const Color& color);
  void choose_storage(const DistinctColors& colors);
  void leave_palette();
  void widen();
  void add_alpha(const ImageRows& rows, size_t first, size_t count);
  size_t width() const { return is_grey_ ? 1 : 3; }  // elements for each colour
  size_t texels() const { return size_t(layout_.width) * size_t(layout_.height); }
  void hold(size_t bytes) {
    memory_.resize(memory_.bytes() + bytes,
                   "an image of " + std::to_string(layout_.width) + " x " + std::to_string(layout_.height) + " pixels");
  }

  const ImageLayout layout_;
  MemoryReservation& memory_;
  size_t count_ = 0;  // texels so far
  bool is_grey_ = true;
  std::vector<Color> colors_;  // of what is added
  std::optional<Palette> palette_;
  // width() elements for each texel, in one of them:
  std::vector<uint8_t> bytes_;          // while there is a palette
  std::vector<uint16_t> halves_;        // without one
  std::vector<uint8_t> alpha_bytes_;    // of an image of bytes, from the first texel on that is not opaque
  std::vector<uint16_t> alpha_halves_;  // of another one
};

}  // namespace alabaster
