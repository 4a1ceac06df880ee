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

ImageLayout layout_of(const OIIO::ImageSpec& spec) {
  ImageLayout layout;
  layout.width = spec.width;
  layout.height = spec.height;
  layout.channels = size_t(std::max(spec.nchannels, 0));
  layout.flat = spec.depth <= 1 && !spec.deep;
  // Renderers' EXRs hold many layers: the plain R, G, B, A are the picture. Without names, one or two channels are grey
  // and grey with alpha.
  const int r = spec.channelindex("R"), g = spec.channelindex("G"), b = spec.channelindex("B");
  if (r >= 0 && g >= 0 && b >= 0)
    layout.rgb = {size_t(r), size_t(g), size_t(b)};
  else if (spec.nchannels >= 3)
    layout.rgb = {0, 1, 2};
  if (const int a = spec.channelindex("A"); a >= 0)
    layout.alpha = size_t(a);
  else if (spec.alpha_channel >= 0)
    layout.alpha = size_t(spec.alpha_channel);
  const OIIO::TypeDesc format = spec.format;
  layout.bytes = format == OIIO::TypeUInt8 && spec.channelformats.empty();
  layout.low_precision = !format.is_floating_point() && format.basesize() <= 2;
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
    if (!input_->open(name, spec, request)) {
      fault = {"texture.damaged", failure_text(input_->geterror()) + "; export or copy the image again"};
      return false;
    }
    // After a damaged strip, the TIFF reader's tasks write to a variable that is gone; this attribute of the input's
    // own specification keeps them on this thread.
    const_cast<OIIO::ImageSpec&>(input_->spec()).attribute("tiff:multithread", 0);
    layout_ = layout_of(input_->spec());
    layout_.working_bytes = working_bytes(input_->spec(), source.format);
    return true;
  }

  int read_rows(int y, ImageRows& to, std::string& fault) override {
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

 private:
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
    return input_->read_tiles(0, 0, spec.x, spec.x + spec.width, begin, end, spec.z, spec.z + 1, 0, spec.nchannels,
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
      return input_->read_scanlines(0, 0, begin, end, spec.z, 0, spec.nchannels, OIIO::TypeFloat, pixels.data());
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
      good = input_->read_scanlines(0, 0, y, y + step, spec.z, 0, spec.nchannels, OIIO::TypeUnknown,
                                    to + size_t(y - begin) * spec.scanline_bytes(true));
    return good;
  }

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
  if (source.format == "png") return open_png(source, fault);
  auto input = std::make_unique<Input>();
  if (!input->open(source, fault)) return nullptr;
  return input;
}

}  // namespace alabaster
