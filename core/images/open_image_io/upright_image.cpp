// Images whose rows do not begin at the top left.
#include <algorithm>
#include <cstring>

#include "core/images/open_image_io/functions.h"

namespace alabaster {
namespace {

class UprightImage final : public ImageInput {
 public:
  UprightImage(std::unique_ptr<ImageInput> stored, int orientation)
      : stored_(std::move(stored)),
        is_transposed_(orientation >= 5),
        is_from_right_(orientation == 2 || orientation == 3 || orientation == 7 || orientation == 8),
        is_from_bottom_(orientation == 3 || orientation == 4 || orientation == 6 || orientation == 7) {
    layout_ = stored_->layout();
    if (is_transposed_) std::swap(layout_.width, layout_.height);
    if (layout_.width <= 0 || layout_.height <= 0) return;
    layout_.working_bytes += row_bytes() * size_t(layout_.height + rows_at_once());
  }

  int read_rows(int y, ImageRows& to, std::string& fault) override {
    if (pixels_.empty() && !read_all(fault)) return 0;
    const int rows = std::min(rows_at_once(), layout_.height - y);
    const size_t values = size_t(rows) * size_t(layout_.width) * layout_.channels;
    uint8_t* out = nullptr;
    if (layout_.bytes)
      to.bytes.resize(values), out = to.bytes.data();
    else
      to.floats.resize(values), out = reinterpret_cast<uint8_t*>(to.floats.data());
    for (int row = y; row < y + rows; ++row)
      for (int x = 0; x < layout_.width; ++x, out += pixel_bytes()) std::memcpy(out, pixel(x, row), pixel_bytes());
    return rows;
  }

 private:
  size_t pixel_bytes() const { return layout_.channels * (layout_.bytes ? 1 : sizeof(float)); }
  size_t row_bytes() const { return pixel_bytes() * size_t(layout_.width); }
  int rows_at_once() const {
    return int(std::clamp(kMostRowBytes / std::max(row_bytes(), size_t(1)), size_t(1), size_t(kRowsAtOnce)));
  }

  /// The pixel at a place of the upright picture.
  const uint8_t* pixel(int x, int y) const {
    const ImageLayout& stored = stored_->layout();
    if (is_transposed_) std::swap(x, y);
    if (is_from_right_) x = stored.width - 1 - x;
    if (is_from_bottom_) y = stored.height - 1 - y;
    return &pixels_[(size_t(y) * size_t(stored.width) + size_t(x)) * pixel_bytes()];
  }

  bool read_all(std::string& fault) {
    const ImageLayout& stored = stored_->layout();
    std::vector<uint8_t> pixels(size_t(stored.width) * size_t(stored.height) * pixel_bytes());
    ImageRows rows;
    for (int y = 0; y < stored.height;) {
      const int count = stored_->read_rows(y, rows, fault);
      if (count == 0) return false;
      const size_t row = size_t(stored.width) * pixel_bytes();
      const void* const from = layout_.bytes ? static_cast<const void*>(rows.bytes.data()) : rows.floats.data();
      std::memcpy(&pixels[size_t(y) * row], from, size_t(count) * row);
      y += count;
    }
    pixels_ = std::move(pixels);
    return true;
  }

  const std::unique_ptr<ImageInput> stored_;
  const bool is_transposed_, is_from_right_, is_from_bottom_;
  std::vector<uint8_t> pixels_;  // as stored
};

}  // namespace

std::unique_ptr<ImageInput> upright_image(std::unique_ptr<ImageInput> image, int orientation) {
  return std::make_unique<UprightImage>(std::move(image), orientation);
}

}  // namespace alabaster
