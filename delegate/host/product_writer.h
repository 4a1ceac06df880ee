// Writes render products: EXR with AOVs as layers, PNG, TIFF, JPEG; colour-managed, with metadata. A file is written
// under a temporary name in its own folder and renamed when it is whole.
#pragma once

#include <map>
#include <span>

#include "delegate/api/render_delegate.h"

namespace alabaster::hd::host {

/// Resolved pixels of one AOV: rows y-DOWN, `components` values per pixel (float or int32 by `integer`).
struct AovPixels {
  int components = 0;
  bool integer = false;
  std::vector<float> floats;
  std::vector<int32_t> ints;
};

struct ProductImage {
  Framing framing;                        // display window and data window
  std::map<std::string, AovPixels> aovs;  // by AOV name; each dataWindow.width() * height() pixels
  Dictionary metadata;                    // written as attributes ("alabaster/samples", "capDate", ...)
  bool incomplete = false;                // marks the file: attribute "alabaster/incomplete" = 1
};

struct OutputColors {
  std::string ocio;  // config path; empty: $OCIO or the built-in one
};

/// The AOVs that products can hold.
ALABASTER_API const std::vector<std::string>& ProductAovs();
/// An AOV under its own name in the data type that suits it: ids and counts int, distances float, all else half.
ALABASTER_API RenderVar UsualRenderVar(const std::string& aov);

/// Checks a product before any rendering is done: known ending, folder exists and is writable, data type fits, known
/// AOVs, colour space or display and view known to the config. False + report otherwise.
ALABASTER_API bool CheckProduct(const RenderProduct& product, const OutputColors& colors, const DiagnosticSink& sink);

/// False + report (file, reason, remedy) on failure; no partial file is left under the final name. An incomplete image
/// is written as fast as can be, for somebody waits: not compressed, and not flushed to the disk.
ALABASTER_API bool WriteProduct(const RenderProduct& product, const ProductImage& image, const OutputColors& colors,
                                const DiagnosticSink& sink);
/// Several products at once, each as WriteProduct does. The files that were written, in the order of `products`; `sink`
/// is called by one thread at a time.
ALABASTER_API std::vector<std::string> WriteProducts(const std::vector<RenderProduct>& products,
                                                     const ProductImage& image, const OutputColors& colors,
                                                     const DiagnosticSink& sink);

/// Turns RGB pixels of the rendering space, in place, into what the product's display, view, look and exposure (empty
/// names: the config's defaults) show of them: 0 to 1, not yet rounded to levels. Whatever the file would be; over
/// black, as a JPEG is, if the pixels are premultiplied. False + report on unknown names or a config that cannot be
/// read.
ALABASTER_API bool ApplyDisplay(const RenderProduct& product, const OutputColors& colors, std::span<float> rgb,
                                const DiagnosticSink& sink);

/// What `alabaster ocio` prints: the config's origin, spaces, displays, views, looks; as lines of text.
ALABASTER_API std::string DescribeColors(const OutputColors& colors, const DiagnosticSink& sink);
/// The config as a .ocio text.
ALABASTER_API std::string SerializeColors(const OutputColors& colors, const DiagnosticSink& sink);

}  // namespace alabaster::hd::host
