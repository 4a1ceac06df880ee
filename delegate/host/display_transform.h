// Pixels as a display shows them: for viewports, which keep one and hand it to RenderBuffer::ResolveTo.
#pragma once

#include <atomic>

#include "delegate/host/product_writer.h"

namespace alabaster {
class ColorTransform;
}

namespace alabaster::hd::host {

/// Converts pixels of the rendering space for a display, view, look and exposure, as the files of products are. The
/// configuration is read once. Nothing of it re-renders.
class ALABASTER_API DisplayTransform final : public PixelTransform {
 public:
  /// `product`: its display, view, look and exposure count; empty names mean the config's defaults. Null after a report
  /// if a name is unknown or the config cannot be read.
  static std::unique_ptr<DisplayTransform> Create(const RenderProduct& product, const OutputColors& colors,
                                                  const DiagnosticSink& sink);
  ~DisplayTransform() override;

  /// Stops, from -126 to 127; anything else leaves it as it was and is false. Any thread; the next Apply uses it.
  bool SetExposure(float stops);
  /// The results lie in 0 to 1 and are not rounded to levels. Premultiplied pixels come out over black, as in a JPEG;
  /// alpha stays.
  void Apply(std::span<float> rgba) const override;

 private:
  explicit DisplayTransform(std::shared_ptr<const ColorTransform> transform);
  std::shared_ptr<const ColorTransform> transform_;
  std::atomic<float> scale_{1};
};

}  // namespace alabaster::hd::host
