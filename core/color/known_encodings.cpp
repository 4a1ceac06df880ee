#include "core/color/known_encodings.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <string>

#include "core/color/chromaticities.h"

namespace alabaster {
namespace {

namespace ocio = OCIO_NAMESPACE;

constexpr Chromaticities kP3 = {0.680f, 0.320f, 0.265f, 0.690f, 0.150f, 0.060f, 0.3127f, 0.3290f};
constexpr Chromaticities kRec2020 = {0.708f, 0.292f, 0.170f, 0.797f, 0.131f, 0.046f, 0.3127f, 0.3290f};

/// A space that files can name, as OpenColorIO's own transform, or as primaries with a gamma, 0 for the curve of sRGB.
struct Known {
  DisplayEncoding encoding;
  const char* style;
  Chromaticities primaries;
};
// H.273's own curves for television are read in several ways, so gammas are told as such.
const Known kKnown[] = {
    {{}, nullptr, kRec709},
    {{12, 13, 0, {}}, nullptr, kP3},
    {{0, 0, 2.4f, kRec709}, nullptr, kRec709},
    {{0, 0, 2.2f, kRec709}, nullptr, kRec709},
    {{0, 0, 2.6f, kP3}, nullptr, kP3},
    {{0, 0, 2.4f, kRec2020}, nullptr, kRec2020},
    {{9, 16, 0, {}}, "DISPLAY - CIE-XYZ-D65_to_REC.2100-PQ", {}},
    {{12, 16, 0, {}}, "DISPLAY - CIE-XYZ-D65_to_ST2084-P3-D65", {}},
    {{9, 18, 0, {}}, "DISPLAY - CIE-XYZ-D65_to_REC.2100-HLG-1000nit", {}},
};

/// From CIE XYZ, D65 to values of the display.
ocio::ConstTransformRcPtr transform_of(const Known& known) {
  if (known.style) {
    const auto built_in = ocio::BuiltinTransform::Create();
    built_in->setStyle(known.style);
    return built_in;
  }
  const XyzColumns columns = xyz_d65_columns(known.primaries);
  double matrix[16] = {};
  for (size_t i = 0; i < 3; ++i)
    for (size_t j = 0; j < 3; ++j) matrix[4 * j + i] = columns[i][j];
  matrix[15] = 1;
  const auto to_linear = ocio::MatrixTransform::Create();
  to_linear->setMatrix(matrix);
  to_linear->setDirection(ocio::TRANSFORM_DIR_INVERSE);
  const auto group = ocio::GroupTransform::Create();
  group->appendTransform(to_linear);
  if (const double gamma = double(known.encoding.gamma); gamma > 0) {
    const auto power = ocio::ExponentTransform::Create();
    const double exponents[4] = {gamma, gamma, gamma, 1};
    power->setValue(exponents);
    power->setDirection(ocio::TRANSFORM_DIR_INVERSE);
    group->appendTransform(power);
    return group;
  }
  const auto curve = ocio::ExponentWithLinearTransform::Create();
  const double gammas[4] = {2.4, 2.4, 2.4, 1}, offsets[4] = {0.055, 0.055, 0.055, 0};
  curve->setGamma(gammas);
  curve->setOffset(offsets);
  curve->setDirection(ocio::TRANSFORM_DIR_INVERSE);
  group->appendTransform(curve);
  return group;
}

using Probes = std::array<float, 15>;

/// Results of the transform for a few colours within Rec. 709.
Probes values_of(const ocio::ConstConfigRcPtr& config, const ocio::ConstTransformRcPtr& transform,
                 ocio::TransformDirection direction) {
  constexpr double kLinear[5][3] = {{1, 1, 1}, {0.02, 0.02, 0.02}, {0.6, 0.3, 0.2}, {0.1, 0.4, 0.05}, {0.1, 0.1, 0.5}};
  const XyzColumns columns = xyz_d65_columns(kRec709);
  Probes values{};
  for (size_t p = 0; p < 5; ++p)
    for (size_t j = 0; j < 3; ++j)
      values[3 * p + j] =
          float(kLinear[p][0] * columns[0][j] + kLinear[p][1] * columns[1][j] + kLinear[p][2] * columns[2][j]);
  ocio::PackedImageDesc image(values.data(), 5, 1, 3);
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

std::optional<DisplayEncoding> known_encoding(const ocio::ConstConfigRcPtr& config, const char* display,
                                              const char* view) {
  std::string name = config->getDisplayViewColorSpaceName(display, view);
  if (name == ocio::OCIO_VIEW_USE_DISPLAY_NAME) name = display;
  const auto space = config->getColorSpace(name.c_str());
  if (!space || space->isData()) return std::nullopt;
  if (space->getReferenceSpaceType() == ocio::REFERENCE_SPACE_SCENE)
    return is_srgb_by_name(*space, display) ? std::optional(DisplayEncoding()) : std::nullopt;
  const auto from = space->getTransform(ocio::COLORSPACE_DIR_FROM_REFERENCE);
  const auto to = space->getTransform(ocio::COLORSPACE_DIR_TO_REFERENCE);
  if (!from && !to) return std::nullopt;
  const Probes values =
      from ? values_of(config, from, ocio::TRANSFORM_DIR_FORWARD) : values_of(config, to, ocio::TRANSFORM_DIR_INVERSE);
  for (const Known& known : kKnown) {
    const Probes expected = values_of(config, transform_of(known), ocio::TRANSFORM_DIR_FORWARD);
    const auto is_near = [](float a, float b) { return std::abs(a - b) < 2e-3f; };
    if (std::equal(values.begin(), values.end(), expected.begin(), is_near)) return known.encoding;
  }
  return std::nullopt;
}

}  // namespace alabaster
