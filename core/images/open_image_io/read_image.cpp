#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>

#include "core/images/open_image_io/functions.h"

namespace alabaster {
namespace {

/// The rows that are read at once.
int rows_at_once(const OIIO::ImageSpec& spec) {
  if (spec.tile_width > 0) return spec.tile_height;
  const size_t row_bytes = size_t(spec.width) * size_t(std::max(spec.nchannels, 1)) * sizeof(float);
  return int(std::clamp(kMostRowBytes / row_bytes, size_t(1), size_t(kRowsAtOnce)));
}

/// The rows as floats and in the file's type; and all of the image in that, where a reader decodes it as a whole: WebP,
/// TGA, TIFF of one strip.
size_t working_bytes(const OIIO::ImageSpec& spec, const std::string& format) {
  if (spec.width <= 0 || spec.height <= 0) return 0;  // it is not read
  const size_t row = size_t(spec.width) * size_t(std::max(spec.nchannels, 1)) * (sizeof(float) + spec.format.size());
  const bool by_rows = format == "jpeg" || format == "openexr" || format == "hdr";
  // OpenImageIO's own buffer, see read_scanlines().
  const bool converted_there = spec.tile_width == 0 && !spec.channelformats.empty();
  const size_t scanline = std::max(spec.scanline_bytes(true), OIIO::imagesize_t(1));
  const size_t buffer = converted_there ? std::max(kMostRowBytes, 256 * scanline) : 0;
  return row * size_t(std::max(rows_at_once(spec), 1)) + buffer + (by_rows ? 0 : spec.image_bytes(true));
}

/// The channels of an EXR by their names, of other formats by their number: one or two are grey and grey with alpha.
void set_channels(const OIIO::ImageSpec& spec, const ImageSource& source, ImageLayout* layout) {
  const bool is_named =
      std::any_of(source.channels.begin(), source.channels.end(), [](const auto& name) { return !name.empty(); });
  if (is_named) {
    const auto place_of = [&](size_t i) {
      const int place = source.channels[i].empty() ? -1 : spec.channelindex(source.channels[i]);
      return place < 0 ? ImageLayout::kNoChannel : size_t(place);
    };
    layout->rgb = {place_of(0), place_of(1), place_of(2)};
    if (place_of(3) != ImageLayout::kNoChannel) layout->alpha = place_of(3);
    return;
  }
  if (spec.nchannels >= 3) layout->rgb = {0, 1, 2};
  if (spec.alpha_channel >= 0) layout->alpha = size_t(spec.alpha_channel);
}

ImageLayout layout_of(const OIIO::ImageSpec& spec, const ImageSource& source) {
  ImageLayout layout;
  layout.width = spec.width;
  layout.height = spec.height;
  layout.channels = size_t(std::max(spec.nchannels, 0));
  layout.flat = spec.depth <= 1 && !spec.deep;
  set_channels(spec, source, &layout);
  const auto is_half = [&spec](size_t channel) {
    return channel == ImageLayout::kNoChannel || spec.channelformat(int(channel)) == OIIO::TypeHalf;
  };
  layout.halves = std::all_of(layout.rgb.begin(), layout.rgb.end(), is_half) &&
                  is_half(layout.alpha.value_or(ImageLayout::kNoChannel));
  const OIIO::TypeDesc format = spec.format;
  layout.bytes = format == OIIO::TypeUInt8 && spec.channelformats.empty();
  layout.low_precision = !format.is_floating_point() && format.basesize() <= 2;
  const bool is_straight = spec.get_int_attribute("oiio:UnassociatedAlpha") != 0;
  layout.associated = layout.alpha && (source.format == "openexr" || (source.format == "tiff" && !is_straight));
  return layout;
}

// OpenImageIO 2.4 and 2.5 read before the buffer if a damaged file makes a reader seek to a negative place.
class MemoryReader final : public OIIO::Filesystem::IOMemReader {
 public:
  using IOMemReader::IOMemReader;
  size_t pread(void* to, size_t size, int64_t offset) override {
    return offset < 0 ? 0 : IOMemReader::pread(to, size, offset);
  }
};

class Input final : public ImageInput {
 public:
  bool open(const ImageSource& source, ImageFault& fault) {
    if (source.format == "openexr")
      if (const std::string reason = openexr_fault(); !reason.empty())
        return fault = {"texture.unreadable", reason}, false;
    input_ = OIIO::ImageInput::create(source.format);
    if (!input_) {
      static_cast<void>(OIIO::geterror());
      fault = {"texture.format", "OpenImageIO was built without a reader for " + source.format + "; convert the image"};
      return false;
    }
    OIIO::ImageSpec request;
    request["oiio:UnassociatedAlpha"] = 1;
    std::string name = source.path;
    if (!input_->supports("ioproxy")) {
      if (source.descriptor < 0) {
        fault = {"texture.format", source.format + " images cannot be embedded; use PNG or JPEG, or a file"};
        return false;
      }
      name = "/proc/self/fd/" + std::to_string(source.descriptor);
    } else {
      if (source.descriptor < 0)
        proxy_ = std::make_unique<MemoryReader>(source.bytes.data(), source.bytes.size());
      else if (!open_file(source.descriptor, fault))
        return false;
      input_->set_ioproxy(proxy_.get());
    }
    OIIO::ImageSpec spec;
    part_ = int(source.part);
    if (!input_->open(name, spec, request) || !input_->seek_subimage(part_, 0)) {
      fault = {"texture.damaged", failure_text(input_->geterror()) + "; export or copy the image again"};
      return false;
    }
    // After a damaged strip, the TIFF reader's tasks write to a variable that is gone; this attribute of the input's
    // own specification keeps them on this thread.
    const_cast<OIIO::ImageSpec&>(input_->spec()).attribute("tiff:multithread", 0);
    layout_ = layout_of(input_->spec(), source);
    layout_.working_bytes = working_bytes(input_->spec(), source.format);
    return source.format != "openexr" || set_window(source.window, fault);
  }

  int read_rows(int y, ImageRows& to, std::string& fault) override {
    if (is_window_whole_) return read_data(y, to, fault);
    const int64_t top = left_top_[1], bottom = top + input_->spec().height;
    const int left = layout_.height - y;
    if (y < top || y >= bottom) {
      const int rows = std::min(window_rows(), y < top ? int(std::min<int64_t>(top - y, left)) : left);
      to.floats.assign(size_t(std::min(rows, left)) * row_values(), 0.0f);
      return std::min(rows, left);
    }
    return read_window(int(y - top), int(std::min<int64_t>(bottom - y, left)), to, fault);
  }

 private:
  bool set_window(const std::array<int32_t, 4>& window, ImageFault& fault) {
    const OIIO::ImageSpec& spec = input_->spec();
    const auto side = [&](size_t axis) { return int64_t(window[axis + 2]) - window[axis] + 1; };
    constexpr int64_t kMost = INT32_MAX;
    if (side(0) <= 0 || side(1) <= 0 || side(0) > kMost || side(1) > kMost) return layout_.width = 0, true;
    layout_.width = int(side(0)), layout_.height = int(side(1));
    const int64_t x = int64_t(spec.x) - window[0], y = int64_t(spec.y) - window[1];
    is_window_whole_ = layout_.width == spec.width && layout_.height == spec.height && x == 0 && y == 0;
    if (is_window_whole_) return true;
    layout_.working_bytes += row_values() * sizeof(float) * size_t(window_rows());
    left_top_ = {int(std::clamp(x, -kMost, kMost)), int(std::clamp(y, -kMost, kMost))};
    if (x < layout_.width && y < layout_.height && x + spec.width > 0 && y + spec.height > 0) return true;
    fault = {"texture.format",
             "its data window lies outside of its display window, so the picture is empty; export it again"};
    return false;
  }
  size_t row_values() const { return size_t(layout_.width) * layout_.channels; }
  int window_rows() const {
    return int(std::clamp(kMostRowBytes / (row_values() * sizeof(float)), size_t(1), size_t(kRowsAtOnce)));
  }

  // Rows of the data window from `y` on, at most `most`. Tiles are read from the first of their rows on.
  int read_window(int y, int most, ImageRows& to, std::string& fault) {
    const OIIO::ImageSpec& spec = input_->spec();
    const int begin = spec.tile_width > 0 ? y - y % spec.tile_height : y;
    const int rows = std::min(read_data(begin, data_, fault) - (y - begin), most);
    if (rows <= 0) return 0;
    to.floats.assign(size_t(rows) * row_values(), 0.0f);
    const int64_t first = std::max(0, -left_top_[0]),
                  end = std::min<int64_t>(spec.width, int64_t(layout_.width) - left_top_[0]);
    const size_t data_values = size_t(spec.width) * layout_.channels;
    for (int row = 0; row < rows; ++row) {
      const float* const from = &data_.floats[size_t(y - begin + row) * data_values];
      std::copy(from + size_t(first) * layout_.channels, from + size_t(end) * layout_.channels,
                &to.floats[size_t(row) * row_values() + size_t(first + left_top_[0]) * layout_.channels]);
    }
    return rows;
  }

  int read_data(int y, ImageRows& to, std::string& fault) {
    const OIIO::ImageSpec& spec = input_->spec();
    const int rows = std::min(rows_at_once(spec), spec.height - y);
    const size_t values = size_t(rows) * size_t(spec.width) * layout_.channels;
    const int begin = spec.y + y, end = begin + rows;
    if (layout_.bytes)
      to.bytes.resize(values);
    else
      to.floats.resize(values);
    const bool good = spec.tile_width > 0 ? read_tiles(begin, end, to)
                      : layout_.bytes     ? read_native(begin, end, to.bytes.data())
                                          : read_scanlines(begin, end, to.floats);
    if (good && is_inverted(spec)) invert(values, to);
    // Some readers fill up a file that is cut off and mention it only in the error text.
    if (good && !input_->has_error()) return rows;
    fault = input_->geterror();
    if (fault.empty()) fault = "the pixels cannot be decoded";
    return 0;
  }

  // OpenImageIO inverts TIFF's bytes alone where white is zero.
  bool is_inverted(const OIIO::ImageSpec& spec) const {
    return !layout_.bytes && spec.get_int_attribute("tiff:PhotometricInterpretation", -1) == 0;
  }
  static void invert(size_t values, ImageRows& to) {
    std::transform(to.floats.begin(), to.floats.begin() + long(values), to.floats.begin(),
                   [](float v) { return 1 - v; });
  }

  bool read_tiles(int begin, int end, ImageRows& to) {
    const OIIO::ImageSpec& spec = input_->spec();
    const OIIO::TypeDesc type = layout_.bytes ? OIIO::TypeUInt8 : OIIO::TypeFloat;
    void* const data = layout_.bytes ? static_cast<void*>(to.bytes.data()) : to.floats.data();
    return input_->read_tiles(part_, 0, spec.x, spec.x + spec.width, begin, end, spec.z, spec.z + 1, 0, spec.nchannels,
                              type, data);
  }

  // OpenImageIO's JPEG reader takes the proxy's file, so it is one of OpenImageIO's own kind.
  bool open_file(int descriptor, ImageFault& fault) {
    const int own = ::fcntl(descriptor, F_DUPFD_CLOEXEC, 0);
    file_.reset(own < 0 ? nullptr : ::fdopen(own, "rb"));
    if (!file_ && own >= 0) ::close(own);
    if (file_) proxy_ = std::make_unique<OIIO::Filesystem::IOFile>(file_.get(), OIIO::Filesystem::IOProxy::Read);
    if (!file_) fault = {"texture.unreadable", "too many files are open; close some, or raise their limit (ulimit -n)"};
    return file_ != nullptr;
  }

  // Where OpenImageIO converts the pixels itself it allocates 256 rows at least, however long they are and however few
  // the image has. Asked for an unknown type it hands out its own.
  bool read_scanlines(int begin, int end, std::vector<float>& pixels) {
    const OIIO::ImageSpec& spec = input_->spec();
    if (!spec.channelformats.empty())
      return input_->read_scanlines(part_, 0, begin, end, spec.z, 0, spec.nchannels, OIIO::TypeFloat, pixels.data());
    native_.resize(size_t(end - begin) * spec.scanline_bytes(true));
    if (!read_native(begin, end, native_.data())) return false;
    constexpr size_t kAtOnce = size_t(1) << 24;  // values; a row may hold more than an int counts
    bool good = true;
    for (size_t i = 0; i < pixels.size() && good; i += kAtOnce)
      good = OIIO::convert_pixel_values(spec.format, native_.data() + i * spec.format.size(), OIIO::TypeFloat,
                                        pixels.data() + i, int(std::min(kAtOnce, pixels.size() - i)));
    return good;
  }

  // For rows that end a TIFF OpenImageIO allocates whole strips, of as many rows as the header claims. Single rows it
  // reads without.
  bool read_native(int begin, int end, uint8_t* to) {
    const OIIO::ImageSpec& spec = input_->spec();
    const int step = spec.get_int_attribute("tiff:RowsPerStrip") > end - begin ? 1 : end - begin;
    bool good = true;
    for (int y = begin; y < end && good; y += step)
      good = input_->read_scanlines(part_, 0, y, y + step, spec.z, 0, spec.nchannels, OIIO::TypeUnknown,
                                    to + size_t(y - begin) * spec.scanline_bytes(true));
    return good;
  }

  int part_ = 0;
  std::array<int, 2> left_top_{};  // of the data window in the picture
  bool is_window_whole_ = true;
  ImageRows data_;               // of the data window, where that is another one
  std::vector<uint8_t> native_;  // rows in the file's type
  struct CloseFile {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };
  // The input reads through the proxy, and that from the file: they are closed in this order.
  std::unique_ptr<std::FILE, CloseFile> file_;
  std::unique_ptr<OIIO::Filesystem::IOProxy> proxy_;
  std::unique_ptr<OIIO::ImageInput> input_;
};

}  // namespace

std::unique_ptr<ImageInput> open_image(const ImageSource& source, ImageFault& fault) {
  std::unique_ptr<ImageInput> image;
  const int orientation = source.orientation;
  if (source.format == "png") {
    image = open_png(source, fault);
  } else {
    auto input = std::make_unique<Input>();
    if (!input->open(source, fault)) return nullptr;
    image = std::move(input);
  }
  return image && orientation > 1 && orientation <= 8 ? upright_image(std::move(image), orientation) : std::move(image);
}

}  // namespace alabaster
