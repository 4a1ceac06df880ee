#include "core/color/known_code_points.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <string>

namespace alabaster {
namespace {

namespace ocio = OCIO_NAMESPACE;

/// From CIE XYZ, D65 to values of a display: OpenColorIO's own transforms. H.273's curves for television are read in
/// several ways, so that displays with a gamma have none of these names.
constexpr struct {
  CodePoints codes;
  const char* style;
} kKnown[] = {
    {kSrgbCodePoints, "DISPLAY - CIE-XYZ-D65_to_sRGB"},
    {{9, 16}, "DISPLAY - CIE-XYZ-D65_to_REC.2100-PQ"},
    {{9, 18}, "DISPLAY - CIE-XYZ-D65_to_REC.2100-HLG-1000nit"},
    {{12, 16}, "DISPLAY - CIE-XYZ-D65_to_ST2084-P3-D65"},
};

/// A few colours within Rec. 709, in CIE XYZ.
constexpr std::array<float, 12> kColors = {0.9505f, 1,     1.089f, 0.019f, 0.02f, 0.022f,
                                           0.39f,   0.36f, 0.24f,  0.2f,   0.3f,  0.1f};
using Values = std::array<float, kColors.size()>;

Values values_of(const ocio::ConstConfigRcPtr& config, const ocio::ConstTransformRcPtr& transform,
                 ocio::TransformDirection direction) {
  Values values = kColors;
  ocio::PackedImageDesc image(values.data(), long(values.size() / 3), 1, 3);
  config->getProcessor(transform, direction)->getDefaultCPUProcessor()->apply(image);
  return values;
}

bool has(std::string text, const char* part) {
  std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return char(std::tolower(c)); });
  return text.find(part) != std::string::npos;
}

/// Spaces that hold a tone map cannot be measured.
bool is_srgb_by_name(const ocio::ColorSpace& space, const std::string& display) {
  const std::string name = space.getName(), encoding = space.getEncoding();
  const bool is_coded = !space.isData() && encoding != "log" && encoding != "scene-linear" && !has(name, "linear");
  return is_coded && (has(name, "srgb") || has(display, "srgb"));
}

}  // namespace

std::optional<CodePoints> known_code_points(const ocio::ConstConfigRcPtr& config, const char* display,
                                            const char* view) {
  std::string name = config->getDisplayViewColorSpaceName(display, view);
  if (name == ocio::OCIO_VIEW_USE_DISPLAY_NAME) name = display;
  const auto space = config->getColorSpace(name.c_str());
  if (!space || space->isData()) return std::nullopt;
  if (space->getReferenceSpaceType() == ocio::REFERENCE_SPACE_SCENE)
    return is_srgb_by_name(*space, display) ? std::optional(kSrgbCodePoints) : std::nullopt;
  const auto from = space->getTransform(ocio::COLORSPACE_DIR_FROM_REFERENCE);
  const auto to = space->getTransform(ocio::COLORSPACE_DIR_TO_REFERENCE);
  if (!from && !to) return std::nullopt;
  const Values values =
      from ? values_of(config, from, ocio::TRANSFORM_DIR_FORWARD) : values_of(config, to, ocio::TRANSFORM_DIR_INVERSE);
  for (const auto& [codes, style] : kKnown) {
    const auto known = ocio::BuiltinTransform::Create();
    known->setStyle(style);
    const Values expected = values_of(config, known, ocio::TRANSFORM_DIR_FORWARD);
    const auto is_near = [](float a, float b) { return std::abs(a - b) < 2e-3f; };
    if (std::equal(values.begin(), values.end(), expected.begin(), is_near)) return codes;
  }
  return std::nullopt;
}

}  // namespace alabaster
