// Images as functions of uv. Decoded once at commit into the rendering space. Lookups never fail, and lock only where a
// TexelStore reads from its file.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "core/color/color_config.h"
#include "core/color/rgb.h"
#include "core/diagnostics/cancel.h"
#include "core/digest/digest.h"
#include "core/math/vector.h"

namespace alabaster {

class TexelStore;

enum class Wrap { repeat, mirror, clamp, black };
enum class TextureFilter { linear, nearest };

/// Where an image comes from: a file, or encoded bytes held in memory (an image embedded in a scene file).
struct TextureSource {
  std::string path;                                   // file path, or the name to report for `bytes`
  std::shared_ptr<const std::vector<uint8_t>> bytes;  // encoded file contents; null: read `path`
  std::string color_space = "auto";                   // see ColorConfig::to_rendering_space
  Wrap wrap_s = Wrap::repeat, wrap_t = Wrap::repeat;
  TextureFilter filter = TextureFilter::linear;
  bool may_be_set = false;      // "<UDIM>" in the path names a set of files (core/texture/udim.h)
  std::string within = {};      // files must lie in this folder or below (core/files/input_file.h); empty: anywhere
  std::string layer = {};       // of an EXR (core/texture/exr_layers.h); empty: the picture
  bool is_environment = false;  // a cube, as an EXR's header calls it, becomes latitude and longitude
  bool is_straight = false;     // colours that the file multiplies by alpha are divided by it
  std::string fault = {};       // why there is no image to read, if that is known
  bool operator==(const TextureSource&) const = default;
  /// True if both have the same texels: wrap modes and the filter do not count.
  bool is_same_image(const TextureSource& o) const {
    return path == o.path && bytes == o.bytes && color_space == o.color_space && may_be_set == o.may_be_set &&
           within == o.within && layer == o.layer && is_environment == o.is_environment && is_straight == o.is_straight;
  }
};

/// An immutable decoded image. uv: u to the right, v UP (v = 0 is the bottom row). Texel centres at half integers,
/// bilinear unless its source asks for the nearest texel. Texels are what the file's header says: its display window,
/// upright, in linear files with their own primaries and exposure. An infinity is the image's largest value, or 65504
/// if that is larger; a NaN is 0. EXR, and TIFF where its header says so, multiply colours by alpha.
class Texture {
 public:
  virtual ~Texture() = default;
  virtual Rgb rgb(const Vec2f& uv) const = 0;
  /// The mean of rgb() over a footprint about `width` texels wide: from a pyramid of box means, trilinear. It is rgb()
  /// where the footprint is not wider than a texel, for nearest texels, and without prepare_filtering().
  virtual Rgb filtered(const Vec2f& uv, float /*width*/) const { return rgb(uv); }
  /// Makes the pyramid, once; any thread. False, with errno as the reason, if there is no place for it. Throws
  /// BuildCancelled.
  virtual bool prepare_filtering(const CancelToken& /*cancel*/ = {}) const { return true; }
  /// The same texels, looked up as this source of the same image asks. Null: they cannot be shared.
  virtual std::shared_ptr<const Texture> placed(const TextureSource&) const { return nullptr; }
  /// The same for all textures that share texels.
  virtual const void* texels() const { return this; }
  /// 1 for an image without alpha, 0 beyond a black border.
  virtual float alpha(const Vec2f&) const { return 1; }
  /// A set of images, each for a unit square of uv. False: it covers all uv.
  virtual bool is_set() const { return false; }
  /// False where a set has no image: it is black and transparent there.
  virtual bool covers(const Vec2f&) const { return true; }
  virtual int width() const = 0;
  virtual int height() const = 0;
  /// Without tiles in a TexelStore's cache.
  virtual size_t memory_bytes() const = 0;
  /// Texel (x, y), y-down, without filtering.
  virtual Rgb texel(int x, int y) const = 0;
  /// Adds all that lookups depend on.
  virtual void add_to(Digest* digest) const;
};

struct TextureLoading {
  std::shared_ptr<TexelStore> store = nullptr;  // keeps the texels
  size_t max_pixels = size_t(1) << 28;
  CancelToken cancel = {};
};

/// Reads, converts and keeps an image. Null + a report (file, reason, remedy) on failure. Images above `max_pixels`,
/// and those that the store's memory does not hold while they are converted, are refused before memory is allocated.
/// Throws BuildCancelled alone.
std::shared_ptr<const Texture> load_texture(const TextureSource& source, const ColorConfig& colors,
                                            const DiagnosticSink& sink, const TextureLoading& loading = {});

/// True if the file opens as an image, or each of a set does; nothing is decoded. Otherwise a report says why not.
bool is_image(const TextureSource& source, const DiagnosticSink& sink);

/// Width and height of a file's picture, all of which decodes; of an EXR its display window.
std::optional<Vec2i> whole_image_size(const std::string& path);

}  // namespace alabaster
