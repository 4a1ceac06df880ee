// Colour management: the only room that sees OpenColorIO. Every colour in core is in the rendering space (the config's
// scene_linear role) unless its name says otherwise.
#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/color/code_points.h"
#include "core/color/rgb.h"
#include "core/diagnostics/report.h"

namespace alabaster {

/// An immutable conversion; apply() may be called from any thread.
class ColorTransform {
 public:
  virtual ~ColorTransform() = default;
  /// Converts `count` RGBA pixels in place. Non-finite components become 0 first (OCIO's ACES outputs turn one NaN into
  /// four), and values for a display are clamped to +-65504; alpha is never touched.
  virtual void apply(float* rgba, size_t count) const = 0;
  virtual bool is_noop() const = 0;
};

struct DisplayRequest {
  std::string display;  // empty: the config's default
  std::string view;     // empty: the display's default
  std::string look;     // empty: the view's own
  float exposure = 0;   // stops, applied in scene-linear before the view
};

/// A loaded OCIO configuration. Immutable; share freely between threads.
class ColorConfig {
 public:
  virtual ~ColorConfig() = default;

  /// `path` empty: $OCIO if it is set and non-empty, else the built-in configuration (made of OCIO's built-in
  /// transforms alone), which the path "built-in" names too. On failure returns null and reports the file, the
  /// fault and the remedy. `within`: as of core/files/input_file.h, for `path`; the tables that the configuration names
  /// are found as OpenColorIO finds them, and must be regular files.
  static std::shared_ptr<const ColorConfig> load(const std::string& path, const DiagnosticSink& sink,
                                                 const std::string& within = {});

  /// Where it came from: a path, or "built-in".
  virtual std::string origin() const = 0;
  virtual std::string rendering_space() const = 0;
  virtual std::vector<std::string> color_spaces() const = 0;
  virtual std::vector<std::string> displays() const = 0;
  virtual std::string default_display() const = 0;
  virtual std::vector<std::string> views(const std::string& display) const = 0;
  virtual std::string default_view(const std::string& display) const = 0;
  virtual std::vector<std::string> looks() const = 0;

  /// CIE xy of red, green, blue, white of the rendering space or of `space`, for EXR's chromaticities. Rec.709 where
  /// the config has no way to CIE XYZ.
  virtual std::array<float, 8> chromaticities(const std::string& space) const = 0;

  /// Names that work with every config: "auto" (here the rendering space; load_texture takes sRGB for 8/16-bit images),
  /// "sRGB" / "srgb_texture", "raw" / "data", "linear" / "lin_rec709". Any other name is the config's. All three return
  /// null and report on failure.
  virtual std::shared_ptr<const ColorTransform> to_rendering_space(const std::string& from,
                                                                   const DiagnosticSink& sink) const = 0;
  virtual std::shared_ptr<const ColorTransform> from_rendering_space(const std::string& to,
                                                                     const DiagnosticSink& sink) const = 0;
  virtual std::shared_ptr<const ColorTransform> display_transform(const DisplayRequest& request,
                                                                  const DiagnosticSink& sink) const = 0;

  /// How the values of a view are coded; empty where H.273 has no name for it.
  virtual std::optional<CodePoints> code_points(const std::string& display, const std::string& view) const = 0;

  /// The whole configuration as text, as a file for --ocio holds it.
  virtual std::string serialize() const = 0;
};

/// From linear Rec. 709, which is the space of glTF's colours, to the rendering space: by the transform of sRGB images,
/// so that a colour equals the image that holds it. Null: they are the same, or, after a report, there is no transform.
std::shared_ptr<const RgbMatrix> rec709_to_rendering(const ColorConfig& config, const DiagnosticSink& sink);

}  // namespace alabaster
