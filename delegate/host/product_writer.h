// Writes render products: EXR with AOVs as layers, PNG, TIFF and JPEG, colour-managed and with metadata. Files appear
// whole or not at all.
#pragma once

#include <map>
#include <memory>
#include <span>

#include "delegate/api/render_delegate.h"

namespace alabaster {
class ColorConfig;
}

namespace alabaster::hd::host {

/// Resolved pixels of one AOV as RenderBuffer::Map gives them: rows bottom-up, `components` values per pixel, either
/// floats or ints. The memory belongs to the caller.
struct AovPixels {
  int components = 0;
  std::span<const float> floats;
  std::span<const int32_t> ints;
};

struct ProductImage {
  Framing framing;                        // display window and data window
  std::map<std::string, AovPixels> aovs;  // by AOV name; each dataWindow.width() * height() pixels
  Dictionary metadata;                    // written as attributes ("alabaster/samples", "capDate", ...)
  /// Of AOVs whose numbers stand for names, what command "names" answers. Files that hold such an AOV have them.
  Dictionary names = {};
  bool incomplete = false;  // becomes attribute "alabaster/incomplete" = 1

  /// Index in `floats` or `ints` of the first value of a row; row 0 is the uppermost.
  size_t row_begin(const AovPixels& pixels, int row) const {
    const size_t below = static_cast<size_t>(framing.dataWindow.height() - 1 - row);
    return below * static_cast<size_t>(framing.dataWindow.width()) * static_cast<size_t>(pixels.components);
  }
};

/// Attributes for `metadata`: the date, the camera, all settings, and the statistics of the picture in `stats`.
ALABASTER_API Dictionary ProductMetadata(const RenderDelegate& delegate, const Dictionary& stats, const Path& camera);

/// Sides of the tiles of an EXR. Smaller ones would be mostly table, and a row of larger ones takes much memory.
inline constexpr int kLeastTile = 16, kMostTile = 256;

struct OutputColors {
  std::string ocio;  // config path; empty: $OCIO or the built-in one
  /// The configuration itself, held since it was read: its file may change or vanish. Null: it is read from `ocio`.
  std::shared_ptr<const ColorConfig> held = {};
  std::string within = {};  // as of an AssetPath: where the file of `ocio` must lie

  /// The configuration. Null after a report if it cannot be read.
  std::shared_ptr<const ColorConfig> config(const DiagnosticSink& sink) const;
};

/// Names of the AOVs that products can hold.
ALABASTER_API const std::vector<std::string>& ProductAovs();
/// The AOV under its own name in the data type that suits it: ids and counts int, distances float, all else half. That
/// of "lpe:EXPRESSION" is the one that shows these light paths; where there is none, the variable has this name.
ALABASTER_API RenderVar UsualRenderVar(const std::string& name);
/// What is rendered for variables: the AOVs that show their light paths, and Cryptomatte as layers of two ranks each,
/// for `ranks` (setting cryptoRanks) in all. Layers that nobody named get the names of their AOVs.
ALABASTER_API void ResolveRenderVars(int ranks, std::vector<RenderVar>* vars);
/// Why no AOV shows the light paths of a variable "lpe:EXPRESSION"; empty: one does, or it is no such variable.
ALABASTER_API std::string LightPathsFault(const RenderVar& var);

enum class ProductStatus {
  done,
  invalid,  // the product contradicts itself, or its kind of file cannot hold it
  colors,   // the colour configuration cannot be read, or lacks its space, display, view or look
  outside,  // the file lies outside of RenderProduct::within
  output,   // the file cannot be written, or no image can
  out_of_memory,
};

/// True if the product can be written. Else it has been reported, and `text` says why not.
struct ProductCheck {
  ProductStatus status = ProductStatus::done;
  std::string text;
  explicit operator bool() const { return status == ProductStatus::done; }
};

/// Checks a product before anything is rendered: extension, data type, AOVs, that its kind of file holds the pixels of
/// `window` (RenderSettingsDescription::window()), folder and its permissions, and that the config knows its colour
/// space, or its display and view.
ALABASTER_API ProductCheck CheckProduct(const RenderProduct& product, const Rect2i& window, const OutputColors& colors,
                                        const DiagnosticSink& sink);

/// Writes all products at once and returns the files that were written, in the order of `products`. A failure is
/// reported (file, reason, remedy) and leaves no partial file under the final name; a picture that its file cannot take
/// is kept in a new folder of the temporary one, where that can, and the report names it. `sink` is called by one
/// thread at a time. Incomplete images are written fast, because somebody waits: not compressed, and not flushed to the
/// disk.
ALABASTER_API std::vector<std::string> WriteProducts(const std::vector<RenderProduct>& products,
                                                     const ProductImage& image, const OutputColors& colors,
                                                     const DiagnosticSink& sink);

/// The config's origin, spaces, displays, views and looks as lines of text: the output of `alabaster ocio`. Empty after
/// a report if it cannot be read.
ALABASTER_API std::string DescribeColors(const OutputColors& colors, const DiagnosticSink& sink);
struct ColorDisplay {
  std::string name;
  std::vector<std::string> views;  // the default view first
};
/// The config's displays, the default one first. Empty after a report if it cannot be read.
ALABASTER_API std::vector<ColorDisplay> ListDisplays(const OutputColors& colors, const DiagnosticSink& sink);
/// The config as the text of an .ocio file. Empty after a report if it cannot be read.
ALABASTER_API std::string SerializeColors(const OutputColors& colors, const DiagnosticSink& sink);

}  // namespace alabaster::hd::host
