// Encoded images. OpenImageIO reads and writes them, from behind a library of our own, libalabaster_images, which is
// loaded with the first image: Debian's OpenImageIO brings more than 200 libraries (OpenCV, GDAL, ffmpeg), and a host
// that renders without textures into its own memory does not need them.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "core/color/code_points.h"
#include "core/memory/memory_budget.h"

namespace alabaster {

// Reading ------------------------------------------------------------------------------------------
struct ImageSource {
  std::string path;
  std::string format;               // OpenImageIO's name: "png", "openexr", ...
  std::span<const uint8_t> bytes;   // the encoded image, if it is in memory
  int descriptor = -1;              // else of its open file; `path` is only its name
  int orientation = 1;              // Exif's number, of a format that has none of its own
  size_t part = 0;                  // of an EXR
  std::array<int32_t, 4> window{};  // of an EXR's picture: least x, least y, greatest x, greatest y
  /// Names of an EXR's channels of red, green, blue and alpha; empty: there is none.
  std::array<std::string, 4> channels = {};
};

struct ImageLayout {
  int width = 0, height = 0;
  size_t channels = 0;                            // values per pixel that read_rows gives
  static constexpr size_t kNoChannel = SIZE_MAX;  // it is 0
  std::array<size_t, 3> rgb{};                    // which of them are colour; all the same for a grey image
  std::optional<size_t> alpha;                    // which of them, if any, is alpha
  bool bytes = false;                             // values are bytes, which stand for multiples of 1/255; else floats
  bool low_precision = false;                     // integers of at most 16 bits: display-encoded unless told otherwise
  bool halves = false;                            // colours are 16-bit floats in the file
  bool associated = false;                        // colours are multiplied by alpha
  bool flat = true;                               // neither a volume nor deep samples
  size_t working_bytes = 0;                       // that the decoder and the rows of one read_rows() take, roughly
};

/// Pixels from the top left of the picture, in one of the two. Outside of its data window an EXR is black and
/// transparent.
struct ImageRows {
  std::vector<float> floats;
  std::vector<uint8_t> bytes;  // where ImageLayout::bytes says so
};

class ImageInput {
 public:
  virtual ~ImageInput() = default;
  const ImageLayout& layout() const { return layout_; }
  /// Decodes one or more rows from `y` on. Returns the number of rows, or 0 with the fault. The first call has y = 0,
  /// and each later call adds the number returned before.
  virtual int read_rows(int y, ImageRows& rows, std::string& fault) = 0;

 protected:
  ImageLayout layout_;
};

struct ImageFault {
  std::string code;  // "texture.format", "texture.damaged"
  std::string text;  // with the remedy
};

// Writing ------------------------------------------------------------------------------------------
enum class FileKind { exr, png, tiff, jpeg };
enum class ChannelStore { half, float32, uint32, uint8, uint16 };

struct ImageAttribute {
  std::string name;
  std::variant<int, float, double, std::string, std::array<float, 2>, std::array<float, 3>, std::array<float, 8>,
               std::array<int, 2>, std::array<int, 3>, std::array<double, 16>>
      value;
};

struct ImageChannel {
  std::string name;
  ChannelStore store = ChannelStore::half;
};

struct ImageDescription {
  FileKind kind = FileKind::exr;
  int width = 0, height = 0;
  std::vector<ImageChannel> channels;  // interleaved, each in its own type
  float pixel_aspect = 1;
  std::array<int, 2> origin{};   // exr: of the data window
  std::array<int, 4> display{};  // exr: x, y, width, height of the display window
  /// Attributes of an EXR. Other formats have no free ones (PNG has only texts), so one description holds them all,
  /// but for "Software" and "DateTime".
  std::vector<ImageAttribute> attributes;
  std::optional<CodePoints> encoding;  // told by a PNG
  bool fast = false;                   // not compressed, where the format lets us choose
  std::string compression = "zip";     // exr: OpenImageIO's name
  int tiles = 0;                       // exr: pixels of a side of its tiles; 0: scanlines
};

/// Gives rows to an encoder. May throw; the exception passes through.
class RowSource {
 public:
  virtual ~RowSource() = default;
  virtual size_t row_bytes() const = 0;
  /// Writes rows [begin, end), counted from the top, to `out`.
  virtual void encode(int begin, int end, uint8_t* out) const = 0;
};

// The library --------------------------------------------------------------------------------------
struct ImageFunctions {
  /// Null with the fault if the image cannot be opened. `source.bytes` and its descriptor must outlive the result.
  std::unique_ptr<ImageInput> (*open)(const ImageSource& source, ImageFault& fault);
  /// Encodes a file in memory: OpenImageIO's own PNG writer does not notice a full disk, and its JPEG writer ends the
  /// process on one. Empty on success, else the reason.
  std::string (*encode)(const ImageDescription& image, const RowSource& rows, std::vector<unsigned char>& file);
  /// True if the zlib stream is that of `size` bytes.
  bool (*inflates_to)(std::span<const uint8_t> stream, uint64_t size);
};

/// Loads libalabaster_images if it is not loaded yet (0.2 to 0.6 s): from the folder of this library or program, from
/// `lib` beside that folder, or where the system finds libraries. Null, with the reason and the remedy in *fault, if it
/// cannot be loaded or is of another build. Throws MemoryRefused where memory is short. It stays loaded as long as this
/// library. Any thread.
const ImageFunctions* image_functions(std::string* fault);

}  // namespace alabaster
