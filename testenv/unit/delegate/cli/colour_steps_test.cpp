// One colour in each of its places, and a second step that has the colours of the first.
#include <OpenImageIO/imageio.h>

#include <map>

#include "testenv/unit/delegate/cli/run_program.h"
#include "testenv/unit/delegate/description/scene_fixture.h"

namespace alabaster::cli {
namespace {

// Renders in a space of its own, without a linear Rec. 709 by name and without a role that joins it to others.
constexpr const char* kWideConfig = R"(ocio_profile_version: 2
roles: {scene_linear: wide, default: raw}
file_rules:
  - !<Rule> {name: Default, colorspace: default}
displays:
  Monitor:
    - !<View> {name: Plain, colorspace: sRGB - Texture}
colorspaces:
  - !<ColorSpace> {name: wide}
  - !<ColorSpace>
    name: sRGB - Texture
    to_scene_reference: !<GroupTransform>
      children:
        - !<ExponentWithLinearTransform> {gamma: [2.4, 2.4, 2.4, 1], offset: [0.055, 0.055, 0.055, 0]}
        - !<MatrixTransform> {matrix: [0.6, 0.3, 0.1, 0, 0.1, 0.9, 0, 0, 0, 0.2, 0.8, 0, 0, 0, 0, 1]}
  - !<ColorSpace> {name: raw, isdata: true}
)";

class ColourSteps : public hd::description::SceneFiles {
 protected:
  void SetUp() override {
    SceneFiles::SetUp();
    write("wide.ocio", kWideConfig);
  }
  Outcome run(const std::vector<std::string>& arguments) const { return run_program(folder_, arguments); }
  std::vector<float> middle(const std::string& name) const {
    const auto image = OIIO::ImageInput::open(folder_ / name);
    EXPECT_TRUE(image) << name;
    if (!image) return {};
    const OIIO::ImageSpec& spec = image->spec();
    std::vector<float> all(size_t(spec.width * spec.height * spec.nchannels));
    EXPECT_TRUE(image->read_image(0, 0, 0, spec.nchannels, OIIO::TypeDesc::FLOAT, all.data()));
    const size_t at = size_t((spec.height / 2 * spec.width + spec.width / 2) * spec.nchannels);
    return {all[at], all[at + 1], all[at + 2]};
  }
  // The colour that the camera sees of a square with this material, and with vertex colours if `colors` is not empty.
  std::vector<float> seen(const std::string& material, const std::string& settings = "") {
    write("square.gltf", R"({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0, 1]}],
      "nodes": [{"mesh": 0}, {"camera": 0, "translation": [0, 0, 2]}],
      "cameras": [{"type": "perspective", "perspective": {"yfov": 0.5, "znear": 0.1}}],
      "extensionsUsed": ["KHR_materials_emissive_strength", "KHR_materials_unlit"],
      "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "material": 0}]}], "materials": [)" +
                             material + R"(],
      "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [-9, -9, 0],
        "max": [9, 9, 0]}], "bufferViews": [{"buffer": 0, "byteLength": 36}], "buffers": [{"byteLength": 36,
        "uri": "data:application/octet-stream;base64,AAAQwQAAEMEAAAAAAAAQQQAAEMEAAAAAAAAAAAAAEEEAAAAA"}]})");
    write("square.json", R"({"models": [{"file": "square.gltf"}], "ocio": "wide.ocio")" + settings + "}");
    const Outcome done =
        run({"render", "square.json", "-o", "a.exr", "--size", "4x4", "--spp", "1", "--studio", "off"});
    EXPECT_EQ(done.code, 0) << done.err;
    return middle("a.exr");
  }
};

void expect_near(const std::vector<float>& is, const std::vector<float>& right) {
  ASSERT_EQ(is.size(), right.size());
  for (size_t i = 0; i < right.size(); ++i) EXPECT_NEAR(is[i], right[i], 0.004 * right[i]);
}

TEST_F(ColourSteps, FactorsAreConvertedAsTexturesAre) {
  const std::string unlit = R"({"extensions": {"KHR_materials_unlit": {}}, "pbrMetallicRoughness":
    {"baseColorFactor": [1, 0.25, 0.0625, 1]}})";
  const std::vector<float> right{0.68125f, 0.325f, 0.1f};
  expect_near(seen(unlit), right);
  expect_near(seen(R"({"emissiveFactor": [1, 0.25, 0.0625], "extensions":
    {"KHR_materials_emissive_strength": {"emissiveStrength": 4}}, "pbrMetallicRoughness": {"baseColorFactor":
    [0, 0, 0, 1]}})"),
              {4 * right[0], 4 * right[1], 4 * right[2]});
  EXPECT_EQ(run({"convert", "square.gltf", "-o", "square.alab"}).code, 0);
  ASSERT_EQ(run({"render", "square.alab", "-o", "b.exr", "--ocio", "wide.ocio", "--size", "4x4", "--spp", "1",
                 "--studio", "off"})
                .code,
            0);
  expect_near(middle("b.exr"), {4 * right[0], 4 * right[1], 4 * right[2]});
}

TEST_F(ColourSteps, AnEditIsInTheRenderingSpace) {
  expect_near(
      seen(R"({"name": "glow", "emissiveFactor": [1, 0.25, 0.0625]})",
           R"(, "materials": [{"match": "glow", "set": {"emission": [1, 0.25, 0.0625], "baseColor": [0, 0, 0]}}])"),
      {1, 0.25f, 0.0625f});
}

class MergeColours : public ColourSteps {
 protected:
  void SetUp() override {
    ColourSteps::SetUp();
    write("show.json",
          R"({"models": [{"file": "patch.gltf"}], "ocio": "wide.ocio", "settings": {"resolution": [8, 8]}})");
    for (const std::string part : {"0", "1"})
      ASSERT_EQ(
          run({"render", "show.json", "--samples", part == "0" ? "0:2" : "2:4", "--checkpoint", "part" + part}).code,
          0);
  }
};

TEST_F(MergeColours, AMergeHasTheConfigurationOfItsParts) {
  ASSERT_EQ(run({"render", "show.json", "-o", "one.exr", "--spp", "4"}).code, 0);
  const Outcome merged = run({"merge", "part0", "part1", "-o", "merged.exr"});
  ASSERT_EQ(merged.code, 0) << merged.err;
  EXPECT_EQ(middle("merged.exr"), middle("one.exr"));
  const auto space = [&](const char* name) {
    return OIIO::ImageInput::open(folder_ / name)->spec().get_string_attribute("colorSpace");
  };
  EXPECT_EQ(space("merged.exr"), space("one.exr"));
}

TEST_F(MergeColours, AChangedOrMissingConfigurationIsRefusedByName) {
  write("wide.ocio", std::string(kWideConfig) + "# changed\n" + "description: other\n");
  const Outcome changed = run({"merge", "part0", "part1", "-o", "merged.exr"});
  EXPECT_EQ(changed.code, 3) << changed.err;
  EXPECT_NE(changed.err.find("wide.ocio"), std::string::npos) << changed.err;
  std::filesystem::remove(folder_ / "wide.ocio");
  const Outcome missing = run({"merge", "part0", "part1", "-o", "merged.exr"});
  EXPECT_EQ(missing.code, 3) << missing.err;
  EXPECT_NE(missing.err.find("wide.ocio"), std::string::npos) << missing.err;
  EXPECT_EQ(run({"merge", "part0", "part1", "-o", "merged.exr", "--ocio", "built-in"}).code, 0);
}

TEST_F(MergeColours, AFileIsShownAsTheProductOfItsNameIs) {
  seen(R"({"emissiveFactor": [0.5, 0.25, 0.125]})");
  write("two.json", R"({"models": [{"file": "square.gltf"}], "settings": {"resolution": [8, 8]}, "products": [
    {"file": "f.exr", "dataType": "float", "colorSpace": "ACEScg"}, {"file": "f.png", "view": "Raw", "exposure": -1},
    {"file": "g.png", "exposure": 1}]})");
  for (const char* part : {"part0", "part1"}) std::filesystem::remove(folder_ / part);
  for (const std::string part : {"0", "1"})
    ASSERT_EQ(run({"render", "two.json", "--samples", part == "0" ? "0:2" : "2:4", "--checkpoint", "part" + part}).code,
              0);
  ASSERT_EQ(run({"render", "two.json", "--spp", "4"}).code, 0);
  std::map<std::string, std::vector<float>> whole;
  for (const std::string file : {"f.exr", "f.png", "g.png"}) whole[file] = middle(file);
  ASSERT_EQ(run({"merge", "part0", "part1", "-o", "f.exr", "-o", "g.png", "-o", "f.png"}).code, 0);
  for (const auto& [file, right] : whole) EXPECT_EQ(middle(file), right) << file;
  EXPECT_NE(whole["f.png"], whole["g.png"]);
}

TEST_F(MergeColours, PartsThatShowTheFrameDifferentlyAreRefused) {
  for (const char* part : {"part0", "part1"}) std::filesystem::remove(folder_ / part);
  ASSERT_EQ(run({"render", "show.json", "--samples", "0:2", "--checkpoint", "part0", "-o", "a.png"}).code, 0);
  ASSERT_EQ(
      run({"render", "show.json", "--samples", "2:4", "--checkpoint", "part1", "-o", "b.png", "--exposure", "1"}).code,
      0);
  for (const std::vector<std::string>& parts : {std::vector<std::string>{"part0", "part1"}, {"part1", "part0"}}) {
    const Outcome merged = run({"merge", parts[0], parts[1], "-o", "merged.png"});
    EXPECT_EQ(merged.code, 3) << merged.err;
    EXPECT_NE(merged.err.find(parts[1]), std::string::npos) << merged.err;
    EXPECT_EQ(run({"merge", parts[0], parts[1], "-o", "merged.png", "--exposure", "1"}).code, 0);
  }
}

TEST_F(MergeColours, PartsOfTwoConfigurationsAreRefusedByName) {
  std::filesystem::remove(folder_ / "part1");
  ASSERT_EQ(run({"render", "show.json", "--samples", "2:4", "--checkpoint", "part1", "--ocio", "built-in"}).code, 0);
  const Outcome merged = run({"merge", "part0", "part1", "-o", "merged.exr"});
  EXPECT_EQ(merged.code, 3) << merged.err;
  EXPECT_NE(merged.err.find("part1"), std::string::npos) << merged.err;
}

}  // namespace
}  // namespace alabaster::cli
