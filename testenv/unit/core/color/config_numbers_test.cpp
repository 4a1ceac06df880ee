// Configurations under a host's locale that writes "0,5".
#include "core/color/config_numbers.h"

#include <OpenColorIO/OpenColorIO.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <array>
#include <filesystem>
#include <fstream>
#include <locale>
#include <sstream>

#include "core/color/builtin_config.h"
#include "core/color/color_config.h"

namespace alabaster {
namespace {

namespace OCIO = OCIO_NAMESPACE;
namespace fs = std::filesystem;

/// "1.234,5", without a locale of the system.
struct Comma : std::numpunct<char> {
  char do_decimal_point() const override { return ','; }
  char do_thousands_sep() const override { return '.'; }
  std::string do_grouping() const override { return "\3"; }
};

class CommaLocale {
 public:
  CommaLocale() : before_(std::locale::global(std::locale(std::locale::classic(), new Comma))) {}
  ~CommaLocale() { std::locale::global(before_); }
  CommaLocale(const CommaLocale&) = delete;
  CommaLocale& operator=(const CommaLocale&) = delete;

 private:
  std::locale before_;
};

/// A configuration with every transform of OpenColorIO 2.1 that has numbers.
constexpr const char* kAllNumbers = R"(ocio_profile_version: 2
description: gamma 2.2, or so
search_path: luts
luma: [0.2126, 0.7152, 0.0722]
roles: {default: lin, scene_linear: lin, color_picking: 2.2}
displays:
  screen:
    - !<View> {name: 1.5, colorspace: 2.2}
colorspaces:
  - !<ColorSpace>
    name: lin
    allocation: lg2
    allocationvars: [-8.5, 5.25, 0.00390625]
  - !<ColorSpace>
    name: 2.2
    from_scene_reference: !<GroupTransform>
      children:
        - !<MatrixTransform>
          matrix: [0.9, 0.05, 0.05, 0,  # 1.5
            0.1, 0.8, 0.1, 0, 0.02, 0.08, 0.9, 0, 0, 0, 0, 1]
          offset:
            - 0.001
            - -2.5E-3
            - +.25e-2
            - 0
        - !<CDLTransform> {slope: [1.1, 1.05, 0.95], offset: [0.01, -0.015, 2.5e-3], power: [1.1, 0.9, 1], sat: 0.85}
        - !<ExponentTransform> {value: [1.05, 1.1, 1.15, 1.]}
        - !<LogAffineTransform> {base: 2.5, log_side_slope: [0.3, 0.31, 0.32], log_side_offset: 0.61, lin_side_slope: 1.1, lin_side_offset: 0.055}
        - !<LogCameraTransform> {base: 10, log_side_slope: 0.2, log_side_offset: 0.4, lin_side_slope: 5.5, lin_side_offset: 0.05, lin_side_break: 0.01}
        - !<LogTransform> {base: 1.7, direction: inverse}
        - !<RangeTransform> {min_in_value: 0.01, max_in_value: 0.98, min_out_value: 0.02, max_out_value: 0.97}
        - !<ExposureContrastTransform> {style: linear, exposure: 0.25, contrast: 0.9, gamma: 1.1, pivot: 0.18}
        - !<FixedFunctionTransform> {style: ACES_DarkToDim10}
        - !<GradingPrimaryTransform>
          style: linear
          offset: {rgb: [0.01, 0.02, 0.03], master: 0.005}
          contrast: {rgb: [1.1, 1.05, 1], master: 1.01}
          pivot: {contrast: 0.2}
          saturation: 0.95
        - !<GradingRGBCurveTransform>
          style: linear
          red: {control_points: [-2.5, -2.25, 0, 0.5, 3.5, 3.75]}
        - !<GradingToneTransform>
          style: linear
          midtones: {rgb: [1.1, 0.9, 1], master: 1.05, center: 0.2, width: 7.5}
        - !<ExponentWithLinearTransform> {gamma: 2.4, offset: 0.055, direction: inverse}
)";

OCIO::ConstConfigRcPtr parsed(const std::string& yaml) {
  std::istringstream text(yaml);
  return OCIO::Config::CreateFromStream(text);
}

std::array<float, 3> converted(const OCIO::ConstConfigRcPtr& config, const char* from, const char* to) {
  std::array<float, 3> rgb = {0.31f, 0.52f, 0.73f};
  config->getProcessor(from, to)->getDefaultCPUProcessor()->applyRGB(rgb.data());
  return rgb;
}

TEST(ConfigNumbers, AreTheSameInALocaleWithCommas) {
  const auto plain = parsed(kAllNumbers);
  const auto usual = parsed(builtin_config_text());
  const CommaLocale comma;
  EXPECT_FALSE(streams_read_decimal_points());
  EXPECT_ANY_THROW(parsed(kAllNumbers)) << "else nothing needs to be done";
  const auto read = parsed(with_whole_numbers(kAllNumbers));
  EXPECT_EQ(converted(read, "lin", "2.2"), converted(plain, "lin", "2.2"));
  EXPECT_STREQ(read->getDescription(), "gamma 2.2, or so");
  EXPECT_STREQ(read->getView("screen", 0), "1.5");
  std::array<double, 3> luma{}, wanted{};
  read->getDefaultLumaCoefs(luma.data()), plain->getDefaultLumaCoefs(wanted.data());
  EXPECT_EQ(luma, wanted);
  const auto built_in = parsed(with_whole_numbers(builtin_config_text()));
  for (const char* space : {"ACEScg", "sRGB - Texture"})
    EXPECT_EQ(converted(built_in, "Linear Rec.709", space), converted(usual, "Linear Rec.709", space)) << space;
}

TEST(ConfigNumbers, OtherTextIsUnchanged) {
  EXPECT_EQ(with_whole_numbers("name: 2.2\nocio_profile_version: 2.1\n# gamma: 2.2\n"),
            "name: 2.2\nocio_profile_version: 2.1\n# gamma: 2.2\n");
  EXPECT_EQ(with_whole_numbers("gamma: 2.2.2, a_gamma: 2.2, gamma2.2: 1.5"),
            "gamma: 2.2.2, a_gamma: 2.2, gamma2.2: 1.5");
  EXPECT_EQ(with_whole_numbers("{gamma: -2.25e+2, offset: .5}"), "{gamma: -225e0, offset: 5e-1}");
  EXPECT_EQ(with_whole_numbers("matrix: [1.5, [2.5"), "matrix: [15e-1, [25e-1");
  EXPECT_EQ(with_whole_numbers("gamma:"), "gamma:");
  EXPECT_EQ(with_whole_numbers("gamma: 1.5e99999999"), "gamma: 1.5e99999999");
}

TEST(ConfigNumbers, ConfigFileIsReadWithItsFolder) {
  const fs::path folder = fs::temp_directory_path() / ("config_numbers_" + std::to_string(getpid()));
  fs::create_directories(folder / "luts");
  std::ofstream(folder / "luts" / "a.spi1d") << "Version 1\nFrom 0.0 1.0\nLength 2\nComponents 1\n{\n0.0\n0.45\n}\n";
  for (const char* name : {"plain.ocio", "comma.ocio"})
    std::ofstream(folder / name) << R"(ocio_profile_version: 2
search_path: luts
roles: {default: lin, scene_linear: lin}
displays:
  screen:
    - !<View> {name: view, colorspace: graded}
colorspaces:
  - !<ColorSpace> {name: lin}
  - !<ColorSpace>
    name: graded
    from_scene_reference: !<GroupTransform>
      children:
        - !<ExponentTransform> {value: 1.25}
        - !<FileTransform> {src: a.spi1d}
)";
  std::string faults;
  const auto shown = [&](const char* name) {
    const DiagnosticSink sink = [&](const Diagnostic& d) { faults += d.text; };
    std::array<float, 4> rgba = {0.31f, 0.52f, 0.73f, 1};
    const auto config = ColorConfig::load((folder / name).string(), sink);
    const auto transform = config ? config->display_transform({"screen", "view", "", 0}, sink) : nullptr;
    if (transform) transform->apply(rgba.data(), 1);
    return rgba;
  };
  const auto plain = shown("plain.ocio");
  {
    const CommaLocale comma;
    EXPECT_EQ(shown("comma.ocio"), plain);
  }
  EXPECT_EQ(faults, "");
  EXPECT_NE(plain[0], 0.31f);
  fs::remove_all(folder);
}

}  // namespace
}  // namespace alabaster
