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

/// One of `bytes`, `halves` and `floats` holds the colours, one of the others the alpha, if some texel is not opaque.
struct PackedImage {
  bool is_grey = false;  // one element per colour instead of three
  PackedTexels<uint8_t> bytes, alpha_bytes;
  PackedTexels<uint16_t> halves, alpha_halves;
  PackedTexels<uint32_t> floats, alpha_floats;
};

/// Takes the rows of an image with the colours that they become in the rendering space. A byte of the file stays a byte
/// if equal bytes become equal values in all the image. A palette holds these, so the conversion need not be known.
/// The palette's values are halves, and so are the colours of other bytes and of a file of halves. Everything else
/// becomes halves where these are equal to it in all the image, else floats. Non-finite alpha is 1.
class TexelPacker {
 public:
  /// `memory` outlives it, and holds what it takes in addition to what the caller has it hold. `floats`: they may be
  /// used. Throws MemoryRefused.
  TexelPacker(const ImageLayout& layout, MemoryReservation* memory, bool floats = true);
  /// The texels of `rows` from `first` on whose colours were found, and then converted.
  void add(const DistinctColors& colors, const ImageRows& rows, size_t first);
  /// True once texels have come that halves do not hold. Without the right to floats it stays false.
  bool needs_floats() const { return needs_floats_; }
  /// After the last row, once.
  PackedImage take();

 private:
  enum class Storage { palette, halves, floats };
  using Color = std::array<uint16_t, 3>;  // bits of halves
  struct Palette {
    std::array<std::array<uint16_t, 256>, 3> values{};
    std::array<std::array<bool, 256>, 3> known{};
  };
  bool fits_palette(const std::array<uint8_t, 3>& bytes, const Color& color);
  void choose_storage(const DistinctColors& colors, const ImageRows& rows, size_t first);
  bool fits_half(float value) const;
  bool fit_halves(const std::vector<float>& rgba) const;
  bool fit_halves(const ImageRows& rows, size_t first, size_t count) const;
  void leave_palette();
  void leave_halves();
  void widen();
  void add_alpha(const ImageRows& rows, size_t first, size_t count);
  size_t width() const { return is_grey_ ? 1 : 3; }  // elements for each colour
  size_t element_bytes() const { return storage_ == Storage::palette ? 1 : storage_ == Storage::halves ? 2 : 4; }
  size_t texels() const { return size_t(layout_.width) * size_t(layout_.height); }
  void hold(size_t bytes) {
    memory_.resize(memory_.bytes() + bytes,
                   "an image of " + std::to_string(layout_.width) + " x " + std::to_string(layout_.height) + " pixels");
  }

  const ImageLayout layout_;
  MemoryReservation& memory_;
  const bool may_be_floats_;
  bool needs_floats_ = false;
  Storage storage_;
  size_t count_ = 0;  // texels so far
  bool is_grey_ = true;
  std::vector<Color> colors_;  // of what is added
  std::vector<std::array<uint32_t, 3>> float_colors_;
  std::optional<Palette> palette_;  // Storage::palette
  // width() elements for each texel, in that of storage_:
  std::vector<uint8_t> bytes_;
  std::vector<uint16_t> halves_;
  std::vector<uint32_t> floats_;
  // From the first texel on that is not opaque: bytes of an image of bytes, else what storage_ says.
  std::vector<uint8_t> alpha_bytes_;
  std::vector<uint16_t> alpha_halves_;
  std::vector<uint32_t> alpha_floats_;
};

}  // namespace alabaster
