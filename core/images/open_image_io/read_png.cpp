// PNG by libpng. A file that essential_png() let through (core/texture/image_streams.h) may still be cut off or damaged
// within its compressed data.
#include <png.h>

#include <algorithm>
#include <bit>
#include <cstring>

#include "core/images/open_image_io/functions.h"

namespace alabaster {
namespace {

class PngInput final : public ImageInput {
 public:
  PngInput() = default;
  PngInput(const PngInput&) = delete;
  PngInput& operator=(const PngInput&) = delete;
  ~PngInput() override { png_destroy_read_struct(&png_, &info_, nullptr); }

  bool open(const ImageSource& source, ImageFault& fault) {
    left_ = source.bytes;
    png_ = png_create_read_struct(PNG_LIBPNG_VER_STRING, this, keep_error, ignore_warning);
    info_ = png_ ? png_create_info_struct(png_) : nullptr;
    if (!info_) throw std::bad_alloc();
    png_set_read_fn(png_, this, give_bytes);
    if (!guarded([this] { read_header(); })) {
      fault = {"texture.damaged", std::string(error_) + "; export or copy the image again"};
      return false;
    }
    describe();
    return true;
  }

  int read_rows(int y, ImageRows& to, std::string& fault) override {
    const int rows = std::min(rows_at_once_, layout_.height - y);
    const size_t size = size_t(rows) * row_bytes_;
    std::vector<uint8_t>& bytes = layout_.bytes ? to.bytes : native_;
    bytes.resize(size);
    if (!(is_interlaced_ ? copy_rows(y, size, bytes.data()) : read_next(rows, bytes.data()))) {
      fault = error_;
      return 0;
    }
    if (layout_.bytes) return rows;
    to.floats.resize(size / sizeof(uint16_t));
    constexpr size_t kAtOnce = size_t(1) << 24;
    for (size_t i = 0; i < to.floats.size(); i += kAtOnce)
      OIIO::convert_pixel_values(OIIO::TypeUInt16, native_.data() + i * sizeof(uint16_t), OIIO::TypeFloat,
                                 to.floats.data() + i, int(std::min(kAtOnce, to.floats.size() - i)));
    return rows;
  }

 private:
  // Grey of less than eight bits becomes bytes, indices become colours, and a transparent colour an alpha.
  void read_header() {
    png_read_info(png_, info_);
    png_set_expand(png_);
    if constexpr (std::endian::native == std::endian::little) png_set_swap(png_);
    passes_ = png_set_interlace_handling(png_);
    png_read_update_info(png_, info_);
  }

  void describe() {
    layout_.width = int(png_get_image_width(png_, info_));
    layout_.height = int(png_get_image_height(png_, info_));
    layout_.channels = png_get_channels(png_, info_);
    layout_.bytes = png_get_bit_depth(png_, info_) == 8;
    layout_.low_precision = true;
    if (layout_.channels >= 3) layout_.rgb = {0, 1, 2};
    if (layout_.channels % 2 == 0) layout_.alpha = layout_.channels - 1;
    row_bytes_ = png_get_rowbytes(png_, info_);
    is_interlaced_ = passes_ > 1;
    const size_t as_floats = size_t(layout_.width) * layout_.channels * sizeof(float);
    rows_at_once_ = int(std::clamp(kMostRowBytes / as_floats, size_t(1), size_t(kRowsAtOnce)));
    layout_.working_bytes = (row_bytes_ + (layout_.bytes ? 0 : as_floats)) * size_t(rows_at_once_) +
                            (is_interlaced_ ? row_bytes_ * size_t(layout_.height) : 0);
  }

  bool read_next(int rows, uint8_t* to) {
    return guarded([&] {
      for (int i = 0; i < rows; ++i) png_read_row(png_, to + size_t(i) * row_bytes_, nullptr);
    });
  }

  bool copy_rows(int y, size_t size, uint8_t* to) {
    if (whole_.empty()) {
      whole_.resize(row_bytes_ * size_t(layout_.height));
      const bool good = guarded([this] {
        for (int pass = 0; pass < passes_; ++pass)
          for (size_t at = 0; at < whole_.size(); at += row_bytes_) png_read_row(png_, whole_.data() + at, nullptr);
      });
      if (!good) return false;
    }
    std::memcpy(to, whole_.data() + size_t(y) * row_bytes_, size);
    return true;
  }

  /// False with error_ where libpng gives up, which leaves `work` by longjmp: nothing in it may need a destructor.
  template <class Work>
  bool guarded(const Work& work) {
    if (setjmp(png_jmpbuf(png_)) != 0) return false;
    work();
    return true;
  }
  static void keep_error(png_structp png, png_const_charp text) {
    auto* const input = static_cast<PngInput*>(png_get_error_ptr(png));
    std::snprintf(input->error_, sizeof input->error_, "PNG: %s", text);
    png_longjmp(png, 1);
  }
  static void ignore_warning(png_structp, png_const_charp) {}
  static void give_bytes(png_structp png, png_bytep to, size_t count) {
    auto* const input = static_cast<PngInput*>(png_get_io_ptr(png));
    if (count > input->left_.size()) png_error(png, "the file is cut off");
    std::memcpy(to, input->left_.data(), count);
    input->left_ = input->left_.subspan(count);
  }

  png_structp png_ = nullptr;
  png_infop info_ = nullptr;
  char error_[160] = "";
  std::span<const uint8_t> left_;
  int passes_ = 1, rows_at_once_ = 1;
  size_t row_bytes_ = 0;
  bool is_interlaced_ = false;
  std::vector<uint8_t> native_, whole_;  // rows of 16 bits; all rows of an interlaced image
};

}  // namespace

std::unique_ptr<ImageInput> open_png(const ImageSource& source, ImageFault& fault) {
  auto input = std::make_unique<PngInput>();
  if (!input->open(source, fault)) return nullptr;
  return input;
}

}  // namespace alabaster
