#include "core/color/color_config.h"

#include <OpenColorIO/OpenColorIO.h>
#include <OpenImageIO/imageio.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <limits>
#include <random>
#include <sstream>

#include "core/color/builtin_config.h"
#include "core/color/chromaticities.h"
#include "core/color/config_inputs.h"
#include "testenv/support/reports.h"

namespace alabaster {
namespace {

namespace OCIO = OCIO_NAMESPACE;
namespace fs = std::filesystem;

using testing::Reports;

struct Folder {
  fs::path path = fs::temp_directory_path() / ("alabaster_color_" + std::to_string(::getpid()));
  Folder() { fs::create_directories(path); }
  ~Folder() { fs::remove_all(path); }
  std::string operator/(const std::string& name) const { return (path / name).string(); }
  std::string write(const std::string& name, const std::string& text) const {
    std::ofstream(path / name) << text;
    return *this / name;
  }
};

std::shared_ptr<const ColorConfig> builtin() {
  return ColorConfig::load("built-in", [](const Diagnostic& d) { ADD_FAILURE() << d.text; });
}

/// A hand-made configuration that renders in AP1, like ACEScg, and has the given roles.
std::string foreign_config(const std::string& extra_roles, const std::string& extra_spaces = "") {
  return "ocio_profile_version: 2\nsearch_path: luts\nroles:\n  default: AP1\n  scene_linear: AP1\n" + extra_roles +
         "file_rules:\n  - !<Rule> {name: Default, colorspace: AP1}\n"
         "displays:\n  Screen:\n    - !<View> {name: Plain, colorspace: AP1}\n"
         "    - !<View> {name: Film, colorspace: LutSpace}\n"
         "looks:\n  - !<Look> {name: Warm, process_space: AP1, transform: !<CDLTransform> {slope: [2, 1, 1]}}\n"
         "colorspaces:\n  - !<ColorSpace> {name: AP0}\n"
         "  - !<ColorSpace>\n    name: AP1\n    to_scene_reference: !<BuiltinTransform> {style: ACEScg_to_ACES2065-1}\n"
         "  - !<ColorSpace>\n    name: LutSpace\n    from_scene_reference: !<FileTransform> {src: missing.cube}\n" +
         extra_spaces;
}

TEST(ColorConfig, BuiltinValidatesAndOffersWhatIsPromised) {
  std::istringstream text{std::string(builtin_config_text())};
  const auto raw = OCIO::Config::CreateFromStream(text);
  EXPECT_NO_THROW(raw->validate());

  const auto config = builtin();
  ASSERT_TRUE(config);
  EXPECT_EQ(config->origin(), "built-in");
  EXPECT_EQ(config->rendering_space(), "Linear Rec.709");
  EXPECT_EQ(config->displays(), (std::vector<std::string>{"sRGB", "Rec.709", "P3-D65", "Rec.2100-PQ"}));
  EXPECT_EQ(config->default_display(), "sRGB");
  for (const std::string& display : config->displays()) {
    EXPECT_EQ(config->views(display), (std::vector<std::string>{"ACES", "Un-tone-mapped", "Raw"}));
    EXPECT_EQ(config->default_view(display), "ACES");
    for (const std::string& view : config->views(display)) {
      Reports reports;
      EXPECT_TRUE(config->display_transform({display, view, "", 0}, reports.sink)) << reports.text();
    }
  }
  for (const char* name :
       {"auto", "sRGB", "srgb_texture", "raw", "data", "linear", "lin_rec709", "ACEScg", "ACES2065-1", "scene_linear"})
    EXPECT_TRUE(config->to_rendering_space(name, {})) << name;
  EXPECT_FALSE(config->to_rendering_space("nonsense", {}));
  EXPECT_FALSE(config->to_rendering_space("", {}));
}

TEST(ColorConfig, BuiltinColoursHaveKnownValues) {
  const auto config = builtin();
  // IEC 61966-2-1: 0.5 encoded is 0.21404 linear; and back.
  std::array<float, 4> pixel = {0.5f, 0, 1, 0.25f};
  config->to_rendering_space("sRGB", {})->apply(pixel.data(), 1);
  EXPECT_NEAR(pixel[0], std::pow((0.5 + 0.055) / 1.055, 2.4), 2e-5);
  EXPECT_NEAR(pixel[1], 0, 1e-6);
  EXPECT_NEAR(pixel[2], 1, 2e-5);
  EXPECT_EQ(pixel[3], 0.25f);
  config->from_rendering_space("sRGB", {})->apply(pixel.data(), 1);
  EXPECT_NEAR(pixel[0], 0.5, 2e-5);

  // The Un-tone-mapped sRGB view of the rendering space is the sRGB curve.
  std::array<float, 4> grey = {0.18f, 0.18f, 0.18f, 1};
  config->display_transform({"sRGB", "Un-tone-mapped", "", 0}, {})->apply(grey.data(), 1);
  EXPECT_NEAR(grey[0], 1.055 * std::pow(0.18, 1 / 2.4) - 0.055, 2e-4);

  // White of linear Rec.709 is white of ACEScg, and red goes by the Bradford matrix (the sum of the row is checked by
  // the white): AP1 red of Rec.709 red is 0.6131 (S-2014-004 with CAT).
  std::array<float, 8> two = {1, 1, 1, 1, 1, 0, 0, 1};
  config->from_rendering_space("ACEScg", {})->apply(two.data(), 2);
  for (size_t c = 0; c < 3; ++c) EXPECT_NEAR(two[c], 1, 1e-4);
  EXPECT_NEAR(two[4], 0.6131, 2e-4);

  // By MaterialX 1.39.5 (cmlib_ng.mtlx): gammas, and the red of Display P3.
  const std::tuple<const char*, double, double> reds[] = {{"g22_rec709", std::pow(0.5, 2.2), 0},
                                                          {"g18_rec709", std::pow(0.5, 1.8), 0},
                                                          {"lin_displayp3", 0.5 * 1.22493, 0.5 * -0.04206},
                                                          {"srgb_displayp3", 0.21404 * 1.22493, 0.21404 * -0.04206}};
  for (const auto& [space, r, g] : reds) {
    std::array<float, 4> red = {0.5f, 0, 0, 1};
    config->to_rendering_space(space, {})->apply(red.data(), 1);
    EXPECT_NEAR(red[0], r, 1e-4) << space;
    EXPECT_NEAR(red[1], g, 1e-4) << space;
  }
}

TEST(ColorConfig, ExposureIsStopsInLinearLight) {
  const auto config = builtin();
  std::array<float, 4> a = {0.1f, 0.2f, 0.3f, 1}, b = {0.4f, 0.8f, 1.2f, 1};
  config->display_transform({"sRGB", "ACES", "", 2}, {})->apply(a.data(), 1);
  config->display_transform({"sRGB", "ACES", "", 0}, {})->apply(b.data(), 1);
  for (size_t c = 0; c < 3; ++c) EXPECT_FLOAT_EQ(a[c], b[c]);
  Reports reports;
  EXPECT_FALSE(config->display_transform({"", "", "", std::numeric_limits<float>::quiet_NaN()}, reports.sink));
  EXPECT_FALSE(config->display_transform({"", "", "", 1e9f}, reports.sink));
  EXPECT_EQ(reports.all.size(), 2u);
}

TEST(ColorConfig, AnyPixelGivesFiniteColourAndKeepsItsAlpha) {
  const auto config = builtin();
  const float nan = std::numeric_limits<float>::quiet_NaN(), inf = std::numeric_limits<float>::infinity();
  for (const std::string& display : config->displays())
    for (const std::string& view : config->views(display)) {
      std::vector<float> pixels = {nan, 1,   1,     0.5f,  inf,   0, 0,      0.25f, -inf, 0,
                                   0,   nan, 1e30f, 1e30f, 1e30f, 0, -1e30f, 0,     0,    1};
      config->display_transform({display, view, "", 3}, {})->apply(pixels.data(), 5);
      for (size_t i = 0; i < 5; ++i)
        for (size_t c = 0; c < 3; ++c) EXPECT_TRUE(std::isfinite(pixels[4 * i + c])) << display << view << i;
      EXPECT_EQ(pixels[3], 0.5f);
      EXPECT_EQ(pixels[7], 0.25f);
      EXPECT_TRUE(std::isnan(pixels[11]));
      if (view == "ACES") {
        for (size_t c = 0; c < 3; ++c)
          EXPECT_GT(pixels[12 + c], 0.7f) << "the brightest pixel is bright on " << display;
      }
    }
  // No conversion scrubs too.
  std::array<float, 4> data = {nan, 1e30f, -inf, 1};
  const auto raw = config->to_rendering_space("raw", {});
  EXPECT_TRUE(raw->is_noop());
  raw->apply(data.data(), 1);
  EXPECT_EQ(data, (std::array<float, 4>{0, 1e30f, 0, 1}));
}

TEST(ColorConfig, BlocksOfAnyLengthAreConvertedAlike) {
  const auto transform = builtin()->to_rendering_space("sRGB", {});
  std::vector<float> many(4 * 5000, 0.5f);
  transform->apply(many.data(), 5000);
  for (size_t i = 0; i < 5000; ++i) ASSERT_EQ(many[4 * i + 2], many[2]) << i;
  EXPECT_EQ(many.back(), 0.5f);
}

// promise: pipeline.colour.rendering_space
TEST(ColorConfig, ReportsSayWhatIsWrongAndWhatToDo) {
  const Folder folder;
  struct Case {
    std::string path, expected;
  };
  const Case cases[] = {
      {folder / "none.ocio", "no such file"},
      {folder.path.string(), "not a file"},
      {"ocio://default", "2.2"},
      {folder.write("bad.ocio", "this is: [not a config"), "can read"},
      {folder.write("new.ocio", "ocio_profile_version: 3\n"), "can read"},
      {folder.write("binary.ocio", std::string("\0\xff\x01", 3)), "can read"},
      {folder.write("empty.ocio", ""), "can read"},
      {folder.write("norole.ocio",
                    "ocio_profile_version: 2\nroles:\n  default: a\nfile_rules:\n  - !<Rule> {name: "
                    "Default, colorspace: a}\ncolorspaces:\n  - !<ColorSpace> {name: a}\n"),
       "scene_linear"},
  };
  for (const Case& c : cases) {
    Reports reports;
    ::testing::internal::CaptureStderr();
    EXPECT_FALSE(ColorConfig::load(c.path, reports.sink));
    EXPECT_EQ(::testing::internal::GetCapturedStderr(), "");
    ASSERT_EQ(reports.all.size(), 1u) << c.path;
    EXPECT_EQ(reports.all[0].where, c.path);
    EXPECT_NE(reports.all[0].text.find(c.expected), std::string::npos) << reports.text();
    EXPECT_NE(reports.all[0].text.find("built-in"), std::string::npos) << "the remedy";
    EXPECT_FALSE(ColorConfig::load(c.path, {}));
  }
}

TEST(ColorConfig, UnknownNamesListTheKnown) {
  const auto config = builtin();
  struct Case {
    DisplayRequest request;
    std::string expected;
  };
  for (const auto& [request, expected] :
       {Case{{"TV", "", "", 0}, "Rec.2100-PQ"}, Case{{"sRGB", "Filmic", "", 0}, "Un-tone-mapped"},
        Case{{"", "", "Warm", 0}, "looks: none"}}) {
    Reports reports;
    EXPECT_FALSE(config->display_transform(request, reports.sink));
    ASSERT_EQ(reports.all.size(), 1u);
    EXPECT_NE(reports.text().find(expected), std::string::npos) << reports.text();
  }
  Reports reports;
  EXPECT_FALSE(config->to_rendering_space("AdobeRGB", reports.sink));
  EXPECT_NE(reports.text().find("ACEScg"), std::string::npos) << reports.text();
}

TEST(ColorConfig, EnvironmentNamesAConfigUnlessEmpty) {
  const Folder folder;
  const std::string path = folder.write("f.ocio", foreign_config("  aces_interchange: AP0\n"));
  const char* saved = std::getenv("OCIO");
  const std::string old = saved ? saved : "";
  ::setenv("OCIO", path.c_str(), 1);
  const auto named = ColorConfig::load("", {});
  ::setenv("OCIO", "", 1);
  const auto empty = ColorConfig::load("", {});
  ::setenv("OCIO", "/no/such/file.ocio", 1);
  Reports reports;
  const auto missing = ColorConfig::load("", reports.sink);
  const std::string norole =
      folder.write("norole.ocio",
                   "ocio_profile_version: 2\nroles: {default: a}\nfile_rules:\n  - !<Rule> "
                   "{name: Default, colorspace: a}\ncolorspaces:\n  - !<ColorSpace> {name: a}\n");
  ::setenv("OCIO", norole.c_str(), 1);
  Reports roles;
  EXPECT_FALSE(ColorConfig::load("", roles.sink));
  EXPECT_NE(roles.text().find("add one, or set $OCIO, which names it, to a .ocio file"), std::string::npos)
      << roles.text();
  saved ? ::setenv("OCIO", old.c_str(), 1) : ::unsetenv("OCIO");
  ASSERT_TRUE(named);
  EXPECT_EQ(named->origin(), path);
  EXPECT_EQ(named->rendering_space(), "AP1");
  ASSERT_TRUE(empty);
  EXPECT_EQ(empty->origin(), "built-in");
  EXPECT_FALSE(missing);
  EXPECT_NE(reports.text().find("$OCIO"), std::string::npos);
}

// promise: pipeline.colour.interchange
TEST(ColorConfig, CommonNamesWorkInForeignConfigsThroughEitherInterchangeRole) {
  const Folder folder;
  const std::string xyz =
      "  - !<ColorSpace>\n    name: XYZ\n    from_scene_reference: !<BuiltinTransform> {style: UTILITY - "
      "ACES-AP0_to_CIE-XYZ-D65_BFD}\n";
  const auto reference = builtin();
  for (const std::string& role :
       {std::string("  aces_interchange: AP0\n"), std::string("  cie_xyz_d65_interchange: XYZ\n")}) {
    Reports reports;
    const auto config = ColorConfig::load(folder.write("f.ocio", foreign_config(role, xyz)), reports.sink);
    ASSERT_TRUE(config);
    // sRGB texels in AP1, as converted by the built-in config by way of its own rendering space.
    std::array<float, 4> here = {0.8f, 0.3f, 0.1f, 1}, there = here;
    config->to_rendering_space("sRGB", reports.sink)->apply(here.data(), 1);
    reference->to_rendering_space("sRGB", {})->apply(there.data(), 1);
    reference->from_rendering_space("ACEScg", {})->apply(there.data(), 1);
    for (size_t c = 0; c < 3; ++c) EXPECT_NEAR(here[c], there[c], 2e-5) << role;
    config->from_rendering_space("sRGB", reports.sink)->apply(here.data(), 1);
    EXPECT_NEAR(here[0], 0.8f, 1e-4);
    const auto xy = config->chromaticities("");
    EXPECT_FLOAT_EQ(xy[0], 0.713f) << "AP1 is recognised";
    EXPECT_FLOAT_EQ(xy[6], 0.32168f);
    EXPECT_EQ(reports.text(), "");
  }
}

// promise: pipeline.colour.interchange
TEST(ColorConfig, WithoutInterchangeRolesRec709IsAssumedAndSaid) {
  const Folder folder;
  Reports reports;
  const auto config = ColorConfig::load(folder.write("f.ocio", foreign_config("")), reports.sink);
  ASSERT_TRUE(config) << reports.text();
  std::array<float, 4> pixel = {0.5f, 0.5f, 0.5f, 1};
  config->to_rendering_space("sRGB", reports.sink)->apply(pixel.data(), 1);
  EXPECT_NEAR(pixel[0], 0.21404, 1e-4);
  ASSERT_EQ(reports.all.size(), 1u);
  EXPECT_EQ(reports.all[0].severity, Severity::warning);
  EXPECT_EQ(config->chromaticities(""), kRec709);
  for (int i = 0; i < 2; ++i) report_unknown_primaries(*config, reports.sink);
  ASSERT_EQ(reports.all.size(), 2u) << "once";
  EXPECT_EQ(reports.all[1].code, "ocio.interchange.missing");
  report_unknown_primaries(*builtin(), reports.sink);
  EXPECT_EQ(reports.all.size(), 2u);
}

// OpenColorIO itself follows each of these until the stack overflows, or never returns.
// promise: pipeline.limits
TEST(ColorConfig, ConfigurationsThatNeverEndAreRefused) {
  const Folder folder;
  ASSERT_EQ(::mkfifo((folder / "fifo.cube").c_str(), 0600), 0);
  folder.write("refers.ctf", "<ProcessList version='1.7' id='r'><Reference path='fifo.cube'/></ProcessList>");
  const auto space = [](const std::string& name, const std::string& transform) {
    return "  - !<ColorSpace>\n    name: " + name + "\n    from_scene_reference: " + transform + "\n";
  };
  const auto through = [](const std::string& name) { return "!<ColorSpaceTransform> {src: " + name + ", dst: AP1}"; };
  const auto screen = [](const std::string& name) {
    return "display_colorspaces:\n  - !<ColorSpace> {name: screen}\nview_transforms:\n  - !<ViewTransform>\n    name: "
           "v\n"
           "    from_scene_reference: !<ColorSpaceTransform> {src: AP1, dst: " +
           name + "}\n";
  };
  std::string chain;
  for (int i = 0; i < 500; ++i) chain += space("c" + std::to_string(i), through("c" + std::to_string(i + 1)));
  std::string many;
  for (int i = 0; i < 5000; ++i) many += "  - !<ColorSpace>\n    name: m" + std::to_string(i) + "\n";
  const std::pair<std::string, const char*> cases[] = {
      {space("self", through("self")), "made of itself"},
      {space("a", through("b")) + space("b", through("a")), "made of itself"},
      {space("group", "!<GroupTransform> {children: [" + through("group") + "]}"), "made of itself"},
      {chain, "through more than 64"},
      {many, "colour spaces, and the limit"},
      {space("named", through("n")) +
           "named_transforms:\n  - !<NamedTransform>\n    name: n\n    transform: " + through("n") + "\n",
       "made of itself"},
      {space("usual", "!<ColorSpaceTransform> {src: AP1, dst: screen}") + screen("usual"), "made of itself"},
      {space("view", "!<DisplayViewTransform> {src: AP1, display: Screen, view: Turned}") + screen("view"),
       "made of itself"},
      {space("look", "!<DisplayViewTransform> {src: AP1, display: Screen, view: Looked}") +
           "looks:\n  - !<Look> {name: l, process_space: look}\n",
       "made of itself"},
      {space("pipe", "!<FileTransform> {src: " + (folder / "fifo.cube") + "}"), "not a regular file"},
      {space("further", "!<FileTransform> {src: " + (folder / "refers.ctf") + "}"), "refers to other files"}};
  for (const auto& [spaces, said] : cases) {
    Reports reports;
    std::string text = foreign_config("  aces_interchange: AP0\n", spaces);
    text.insert(text.find("    - !<View> {name: Film"),
                "    - !<View> {name: Turned, view_transform: v, display_colorspace: screen}\n"
                "    - !<View> {name: Looked, colorspace: AP1, looks: l}\n");
    if (const size_t own = text.find("looks:\n  - !<Look> {name: l,"); own != std::string::npos)
      text.erase(text.find("looks:\n"), text.find("colorspaces:\n") - text.find("looks:\n"));
    EXPECT_FALSE(ColorConfig::load(folder.write("f.ocio", text), reports.sink)) << said;
    EXPECT_NE(reports.text().find(said), std::string::npos) << reports.text();
  }
}

TEST(ColorConfig, AFileIsReadAgainOnlyWhenItHasChanged) {
  const Folder folder;
  const std::string file = folder.write("f.ocio", foreign_config("  aces_interchange: AP0\n"));
  const auto first = ColorConfig::load(file, {});
  ASSERT_TRUE(first);
  EXPECT_EQ(ColorConfig::load(file, {}), first);
  folder.write("f.ocio", foreign_config("  aces_interchange: AP1\n"));  // as long as before, at the same moment
  EXPECT_NE(ColorConfig::load(file, {}), first);
}

TEST(ColorConfig, MissingLutsAndLooksOfForeignConfigs) {
  const Folder folder;
  Reports reports;
  const auto config =
      ColorConfig::load(folder.write("f.ocio", foreign_config("  aces_interchange: AP0\n")), reports.sink);
  ASSERT_TRUE(config) << reports.text();
  EXPECT_FALSE(config->display_transform({"Screen", "Film", "", 0}, reports.sink));
  EXPECT_NE(reports.text().find("missing.cube"), std::string::npos) << reports.text();
  EXPECT_FALSE(config->to_rendering_space("LutSpace", {}));
  EXPECT_EQ(config->chromaticities("LutSpace"), kRec709);
  EXPECT_EQ(config->looks(), std::vector<std::string>{"Warm"});
  std::array<float, 4> pixel = {0.1f, 0.2f, 0.3f, 1};
  const auto look = config->display_transform({"", "", "Warm", 0}, reports.sink);
  ASSERT_TRUE(look) << reports.text();
  look->apply(pixel.data(), 1);
  EXPECT_NEAR(pixel[0], 0.2f, 1e-5);
  EXPECT_NEAR(pixel[1], 0.2f, 1e-5);
  for (const char* text : {"+Warm", "Warm, -Warm", "Warm:+Warm"})
    EXPECT_TRUE(config->display_transform({"", "", text, 0}, {})) << text;
}

TEST(ColorConfig, ChromaticitiesOfTheBuiltinSpaces) {
  const auto config = builtin();
  EXPECT_EQ(config->chromaticities(""), kRec709);
  EXPECT_EQ(config->chromaticities("sRGB"), kRec709);
  EXPECT_EQ(config->chromaticities("raw"), kRec709);
  EXPECT_FLOAT_EQ(config->chromaticities("ACEScg")[2], 0.165f);
  EXPECT_FLOAT_EQ(config->chromaticities("ACES2065-1")[0], 0.7347f);
}

TEST(Chromaticities, MatricesAndBackAgain) {
  // ITU-R BT.709: Y of the primaries are its luma coefficients.
  const XyzColumns rec709 = xyz_d65_columns(kRec709);
  EXPECT_NEAR(rec709[0][1], 0.2126, 1e-4);
  EXPECT_NEAR(rec709[1][1], 0.7152, 1e-4);
  EXPECT_NEAR(rec709[2][1], 0.0722, 1e-4);
  EXPECT_NEAR(rec709[0][0], 0.4124, 1e-4);
  // An unknown space with a D65 white is described by its own xy, whatever the scale.
  const Chromaticities wide = {0.70f, 0.29f, 0.20f, 0.75f, 0.14f, 0.05f, 0.3127f, 0.3290f};
  XyzColumns columns = xyz_d65_columns(wide);
  for (auto& column : columns)
    for (double& v : column) v *= 100;
  const Chromaticities found = chromaticities_of(columns);
  for (size_t i = 0; i < 8; ++i) EXPECT_NEAR(found[i], wide[i], 1e-5);
  EXPECT_EQ(chromaticities_of({}), kRec709);
}

// ---- against OCIO's own tools ---------------------------------------------------------------------------------------

std::vector<float> read_rgba(const std::string& path) {
  const auto in = OIIO::ImageInput::open(path);
  if (!in) return {};
  std::vector<float> pixels(size_t(in->spec().image_pixels()) * 4);
  in->read_image(0, 0, 0, 4, OIIO::TypeFloat, pixels.data());
  return pixels;
}

int run(const std::string& command) {
  return std::system((command + " >/dev/null 2>&1").c_str());
}

class AgainstOcioTools : public ::testing::Test {
 protected:
  void SetUp() override {
    if (run("command -v ocioconvert") != 0) GTEST_SKIP() << "ocioconvert (package opencolorio-tools) is not installed";
    std::mt19937 random(7);
    std::uniform_real_distribution<float> stops(-8, 5);
    pixels_.resize(4 * 64 * 32);
    for (float& v : pixels_) v = std::exp2(stops(random));
    for (size_t i = 3; i < pixels_.size(); i += 4) pixels_[i] = 1;
    OIIO::ImageSpec spec(64, 32, 4, OIIO::TypeFloat);
    const auto out = OIIO::ImageOutput::create("x.exr");
    ASSERT_TRUE(out->open(folder_ / "in.exr", spec) && out->write_image(OIIO::TypeFloat, pixels_.data()) &&
                out->close());
    config_path_ = folder_.write("saved.ocio", builtin()->serialize());
  }
  void compare(const ColorTransform& transform, const std::string& arguments) {
    ASSERT_EQ(run("OCIO='" + config_path_ + "' ocioconvert " + arguments), 0) << arguments;
    const std::vector<float> theirs = read_rgba(folder_ / "out.exr");
    std::vector<float> ours = pixels_;
    transform.apply(ours.data(), ours.size() / 4);
    ASSERT_EQ(ours.size(), theirs.size());
    // The tool's output is float32 too, so only the grouping of operations may round differently.
    for (size_t i = 0; i < ours.size(); ++i)
      ASSERT_NEAR(ours[i], theirs[i], 2e-6f * std::max(1.0f, std::abs(theirs[i]))) << arguments << " value " << i;
  }
  std::string in_out(const std::string& from, const std::string& rest) const {
    return "'" + folder_ / "in.exr" + "' '" + from + "' '" + folder_ / "out.exr" + "' " + rest;
  }

  Folder folder_;
  std::vector<float> pixels_;
  std::string config_path_;
};

TEST_F(AgainstOcioTools, TheSavedConfigPassesOciocheck) {
  EXPECT_EQ(run("ociocheck --iconfig '" + config_path_ + "'"), 0);
}

// Each run of the tool costs half a second of loading, so each view transform and each display is taken once.
TEST_F(AgainstOcioTools, DisplaysAndViews) {
  const auto config = builtin();
  const std::pair<const char*, const char*> pairs[] = {
      {"sRGB", "ACES"}, {"P3-D65", "ACES"}, {"Rec.2100-PQ", "ACES"}, {"Rec.709", "Un-tone-mapped"}};
  for (const auto& [display, view] : pairs)
    compare(*config->display_transform({display, view, "", 0}, {}),
            "--view " + in_out("Linear Rec.709", std::string("'") + display + "' '" + view + "'"));
}

TEST_F(AgainstOcioTools, ColourSpaces) {
  const auto config = builtin();
  compare(*config->from_rendering_space("ACEScg", {}), in_out("Linear Rec.709", "ACEScg"));
  compare(*config->to_rendering_space("ACES2065-1", {}), in_out("ACES2065-1", "'Linear Rec.709'"));
  compare(*config->to_rendering_space("sRGB", {}), in_out("sRGB - Texture", "'Linear Rec.709'"));
}

}  // namespace
}  // namespace alabaster
