// Sequences of frames and times of an animation, from outside.
#include <OpenImageIO/imageio.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <thread>

#include "testenv/unit/delegate/cli/picture_values.h"
#include "testenv/unit/delegate/cli/run_program.h"
#include "testenv/unit/delegate/description/scene_fixture.h"
#include "testenv/unit/delegate/gltf/gltf_builder.h"

namespace alabaster::cli {
namespace {

using nlohmann::json;

// A patch that moves to the right by a whole patch per second, and is gone after four.
class FramesTest : public hd::description::SceneFiles {
 protected:
  void SetUp() override {
    SceneFiles::SetUp();
    const float times[2] = {0, 4}, places[6] = {0, 0, 0, 8, 0, 0};
    std::ofstream bin(folder_ / "move.bin", std::ios::binary);
    bin.write(reinterpret_cast<const char*>(times), sizeof times);
    bin.write(reinterpret_cast<const char*>(places), sizeof places);
    bin.close();
    write("moving.gltf", moving(true).dump());
    write("framed.gltf", moving(false).dump());
  }
  static json moving(bool with_camera) {
    json document = json::parse(hd::description::patch_gltf(with_camera, with_camera));
    document["buffers"].push_back({{"uri", "move.bin"}, {"byteLength", 32}});
    document["bufferViews"].push_back({{"buffer", 1}, {"byteLength", 8}});
    document["bufferViews"].push_back({{"buffer", 1}, {"byteOffset", 8}, {"byteLength", 24}});
    document["accessors"].push_back({{"bufferView", 2}, {"componentType", 5126}, {"count", 2}, {"type", "SCALAR"}});
    document["accessors"].push_back({{"bufferView", 3}, {"componentType", 5126}, {"count", 2}, {"type", "VEC3"}});
    document["animations"] = {{{"name", "slide"},
                               {"samplers", {{{"input", 2}, {"output", 3}}}},
                               {"channels", {{{"sampler", 0}, {"target", {{"node", 0}, {"path", "translation"}}}}}}}};
    return document;
  }
  int render(const std::string& scene, std::vector<std::string> more, std::string* said = nullptr) const {
    more.insert(more.begin(), {"render", scene, "--size", "16x12", "--spp", "2"});
    Program program(folder_, more);
    const int code = program.wait();
    if (said) *said = program.err();
    return code;
  }
  std::vector<float> pixels(const std::string& file) const { return pixels_of(folder_ / file); }
  // The share of the picture that the patch covers.
  double coverage(const std::string& file) const {
    const std::vector<float> all = pixels(file);
    double sum = 0;
    for (size_t i = 3; i < all.size(); i += 4) sum += double(all[i]);
    return sum / double(std::max<size_t>(all.size() / 4, 1));
  }
};

// promise: pipeline.stats.renders
TEST_F(FramesTest, EveryFrameIsAFileOfItsOwnAndTheSameAsRenderedAlone) {
  std::string said;
  ASSERT_EQ(render("moving.gltf", {"--frames", "0:9:4", "--fps", "8", "-o", "f.##.exr", "--stats", "s.json"}, &said), 0)
      << said;
  EXPECT_NE(said.find("frame 4 at 0.5 s (2 of 3)"), std::string::npos) << said;
  EXPECT_GT(coverage("f.00.exr"), coverage("f.04.exr"));
  EXPECT_GT(coverage("f.04.exr"), coverage("f.08.exr"));
  const json stats = json::parse(std::ifstream(folder_ / "s.json"));
  EXPECT_EQ(stats["frames"], (json{0, 4, 8}));
  ASSERT_EQ(stats["renders"].size(), 3u);
  double noisiest = 0;
  for (size_t i = 0; i < 3; ++i) {
    const json& one = stats["renders"][i];
    EXPECT_EQ(one["frame"], stats["frames"][i]);
    EXPECT_EQ(one["resolution"], stats["resolutions"][i]);
    EXPECT_EQ(one["error"]["relativeRmse"], stats["delegate"][i]["error.relativeRmse"]);
    noisiest = std::max(noisiest, one["error"]["relativeRmse"].get<double>());
  }
  EXPECT_EQ(stats["error"]["relativeRmse"], noisiest);
  EXPECT_EQ(stats["files"], (json{"f.00.exr", "f.04.exr", "f.08.exr"}));
  ASSERT_EQ(render("moving.gltf", {"--time", "0.5", "--set", "frame=4", "-o", "alone.exr"}), 0);
  EXPECT_EQ(pixels("f.04.exr"), pixels("alone.exr"));
}

// A lamp that hangs on a node which moves above a floor: the mean of the pictures at times of the shutter.
TEST_F(FramesTest, ALightBelowAMovingNodeMovesWithinTheShutter) {
  hd::gltf::testing::GltfBuilder b;
  b.attribute<float>("POSITION", {-2, 0, -2, -2, 0, 2, 2, 0, 2, -2, 0, -2, 2, 0, 2, 2, 0, -2}, "VEC3");
  b.json["extensionsUsed"] = {"KHR_lights_punctual"};
  b.json["extensions"]["KHR_lights_punctual"]["lights"] = {{{"type", "point"}, {"intensity", 3}}};
  b.json["cameras"] = {{{"type", "perspective"}, {"perspective", {{"yfov", 0.6}, {"znear", 0.1}}}}};
  const float turn = std::sqrt(0.5f);
  b.json["nodes"] = {{{"mesh", 0}},
                     {{"children", {2}}},
                     {{"translation", {1, 0.6, 0}}, {"extensions", {{"KHR_lights_punctual", {{"light", 0}}}}}},
                     {{"camera", 0}, {"translation", {0, 6, 0}}, {"rotation", {-turn, 0, 0, turn}}}};
  b.json["scenes"][0]["nodes"] = {0, 1, 3};
  b.animate(1, "rotation", {0, 2}, {0, 0, 0, 1, 0, turn, 0, turn}, "VEC4");
  const std::string file = write("lamp.glb", b.bytes());
  const auto blocks = [&](const std::vector<std::string>& more) {
    std::vector<std::string> words{"render", file, "--size", "24x24", "-o", "lamp.exr"};
    words.insert(words.end(), more.begin(), more.end());
    const Outcome done = run_program(folder_, words);
    EXPECT_EQ(done.code, 0) << done.err;
    const std::vector<float> all = pixels("lamp.exr");
    std::vector<double> means(16);
    for (size_t i = 0; i < all.size() / 4; ++i) means[i / 24 / 6 * 4 + i % 24 / 6] += double(all[4 * i]) / 36;
    return means;
  };
  const std::vector<double> blurred = blocks({"--time", "1", "--shutter", "-1:1", "--fps", "1", "--spp", "1024"});
  std::vector<double> stills(16), middle;
  constexpr int kStills = 16;
  for (int i = 0; i < kStills; ++i) {
    middle = blocks({"--time", std::to_string((i + 0.5) * 2 / kStills), "--spp", "4"});
    for (size_t k = 0; k < 16; ++k) stills[k] += middle[k] / kStills;
  }
  double largest = 0;
  for (size_t k = 0; k < 16; ++k) {
    EXPECT_NEAR(blurred[k] / stills[k], 1, 0.02) << "block " << k;
    largest = std::max(largest, std::abs(middle[k] / stills[k] - 1));
  }
  EXPECT_GT(largest, 0.3) << "as at the end";
}

// promise: pipeline.name.frames
TEST_F(FramesTest, EveryFileHasTheNumberOfItsFrame) {
  const auto frame_of = [&](const std::string& file) {
    const auto input = OIIO::ImageInput::open(folder_ / file);
    return input ? input->spec().get_int_attribute("alabaster/frame", -1) : -2;
  };
  ASSERT_EQ(render("moving.gltf", {"--frames", "1:5:2", "-o", "f.#.exr", "--checkpoint", "f.#.ckpt"}), 0);
  for (const int frame : {1, 3, 5}) EXPECT_EQ(frame_of("f." + std::to_string(frame) + ".exr"), frame);
  Program merge(folder_, {"merge", "f.3.ckpt", "-o", "merged.exr"});
  ASSERT_EQ(merge.wait(), 0) << merge.err();
  EXPECT_EQ(frame_of("merged.exr"), 3);
  ASSERT_EQ(render("moving.gltf", {"--set", "frame=7", "-o", "set.exr"}), 0);
  EXPECT_EQ(frame_of("set.exr"), 7);
  ASSERT_EQ(render("moving.gltf", {"-o", "none.exr"}), 0);
  EXPECT_EQ(frame_of("none.exr"), 0);
}

// promise: pipeline.frames.lists
TEST_F(FramesTest, ListsAreThoseOfUsdrecordAndNamesHaveEveryKindOfPlace) {
  const std::vector<std::pair<std::string, std::vector<std::string>>> names{
      {"a.%04d.exr", {"a.0007.exr", "a.0003.exr", "a.0001.exr", "a.-001.exr"}},
      {"b.$F3.exr", {"b.007.exr", "b.003.exr", "b.001.exr", "b.-01.exr"}},
      {"c.$F.exr", {"c.7.exr", "c.3.exr", "c.1.exr", "c.-1.exr"}},
      {"w.#.100%done.$Fx.exr", {"w.7.100%done.$Fx.exr", "w.3.100%done.$Fx.exr", "w.1.100%done.$Fx.exr"}},
      {"d#.%d.##.exr", {"d#.%d.07.exr", "d#.%d.03.exr", "d#.%d.01.exr", "d#.%d.-1.exr"}}};
  for (const auto& [name, files] : names) {
    ASSERT_EQ(render("moving.gltf", {"--frames", "7,3:-1x-2", "-o", name}), 0) << name;
    for (const std::string& file : files) EXPECT_FALSE(pixels(file).empty()) << file;
  }
  std::string said;
  ASSERT_EQ(render("moving.gltf", {"--frames", "1.0:2.00", "-o", "g.#.exr"}), 0);
  ASSERT_EQ(render("moving.gltf", {"--frames", "1:2x0.5", "-o", "e.####.#.exr", "--stats", "e.json"}, &said), 0)
      << said;
  for (const char* file : {"e.0001.0.exr", "e.0001.5.exr", "e.0002.0.exr"}) EXPECT_FALSE(pixels(file).empty()) << file;
  EXPECT_EQ(json::parse(std::ifstream(folder_ / "e.json"))["frames"], (json{1, 1.5, 2}));
  EXPECT_EQ(render("moving.gltf", {"--frames", "1:2x0.5", "-o", "e.####.exr"}, &said), 2);
  EXPECT_NE(said.find("need 1 digits after the point"), std::string::npos) << said;
  EXPECT_EQ(render("moving.gltf", {"--frames", "1,2,1", "-o", "f.#.exr"}, &said), 2);
  EXPECT_NE(said.find("names a frame twice"), std::string::npos) << said;
}

// promise: pipeline.frames.start
TEST_F(FramesTest, TheStartFrameShowsTheModelsAtZeroSeconds) {
  std::string said;
  ASSERT_EQ(render("moving.gltf",
                   {"--frames", "1001:1005x4", "--start-frame", "1001", "--fps", "8", "-o", "s.####.exr"}, &said),
            0);
  EXPECT_NE(said.find("frame 1005 at 0.5 s (2 of 2)"), std::string::npos) << said;
  ASSERT_EQ(render("moving.gltf", {"--time", "0.5", "--set", "frame=1005", "-o", "alone.exr"}), 0);
  EXPECT_EQ(pixels("s.1005.exr"), pixels("alone.exr"));
  EXPECT_EQ(said.find("after the last key"), std::string::npos) << said;
  ASSERT_EQ(render("moving.gltf", {"--frames", "1001:1002", "-o", "l.####.exr"}, &said), 0);
  EXPECT_NE(said.find("--start-frame 1001 makes the first one its start"), std::string::npos) << said;
}

// promise: pipeline.frames.skip
TEST_F(FramesTest, FramesThatAreThereAreSkippedIfTheyAreWholeAndOfTheirSize) {
  std::vector<std::string> words{"--frames", "0:3", "--crop", "2,2,14,10", "-o", "k.#.exr", "-o", "k.#.png"};
  ASSERT_EQ(render("moving.gltf", words), 0);
  const auto bytes = [&](const std::string& file) {
    std::ifstream in(folder_ / file, std::ios::binary);
    return std::string(std::istreambuf_iterator<char>(in), {});
  };
  const std::string cut = bytes("k.1.png"), whole = bytes("k.3.exr");
  std::ofstream(folder_ / "k.1.png", std::ios::binary) << cut.substr(0, cut.size() / 2);
  std::ofstream(folder_ / "k.3.exr", std::ios::binary) << whole.substr(0, whole.size() - 9);
  std::filesystem::copy_file(folder_ / "k.0.exr", folder_ / "k.2.exr",
                             std::filesystem::copy_options::overwrite_existing);
  words.insert(words.end(), {"--skip-existing", "--stats", "k.json"});
  std::string said;
  ASSERT_EQ(render("moving.gltf", words, &said), 0) << said;
  EXPECT_NE(said.find("frame 0 is there (1 of 4)"), std::string::npos) << said;
  EXPECT_EQ(json::parse(std::ifstream(folder_ / "k.json"))["frames"], (json{1, 3}))
      << "2 is a whole picture, whatever it shows";
  EXPECT_GT(bytes("k.1.png").size(), cut.size() / 2);
  EXPECT_FALSE(pixels("k.3.exr").empty());
  words[3] = "0,0,8,8";
  ASSERT_EQ(render("moving.gltf", words), 0);
  EXPECT_EQ(json::parse(std::ifstream(folder_ / "k.json"))["frames"], (json{0, 1, 2, 3})) << "another size";
  words[1] = "0,4";
  ASSERT_EQ(render("moving.gltf", words), 0);
  EXPECT_EQ(json::parse(std::ifstream(folder_ / "k.json"))["frames"], json::array({4}));
}

// promise: pipeline.frames.turntable
TEST_F(FramesTest, ATurntableIsATurnOfTheCameraAboutTheObjects) {
  const auto scene = [&](const std::string& name, const std::string& eye, const std::string& lamp,
                         const std::string& target = "[0, 0, 0]") {
    write(name, R"({"gltf": [{"file": "framed.gltf"}], "settings": {"studio": "off"},
                    "camera": {"lookAt": {"eye": )" +
                    eye + R"(, "target": )" + target + R"(}},
                    "lights": [{"name": "key", "type": "sphereLight", "position": )" +
                    lamp + R"(, "radius": 0.5, "intensity": 90}]})");
  };
  scene("turn.json", "[0, 1, 8]", "[0, 2, 3]");
  scene("quarter.json", "[5.65685425, 1, 5.65685425]", "[0, 2, 3]");
  scene("lights.json", "[5.65685425, 1, 5.65685425]", "[2.12132034, 2, 2.12132034]");
  std::string said;
  const auto mean_difference = [&](const std::string& a, const std::string& b) {
    const std::vector<float> p = pixels(a), q = pixels(b);
    double sum = 0;
    for (size_t i = 0; i < p.size(); ++i) sum += std::abs(double(p[i]) - double(q[i]));
    return sum / double(std::max<size_t>(p.size(), 1));
  };
  ASSERT_EQ(render("turn.json", {"--turntable", "8", "-o", "t.#.exr"}, &said), 0) << said;
  EXPECT_NE(said.find("frame 2 turned by 45 degrees (2 of 8)"), std::string::npos) << said;
  ASSERT_EQ(render("turn.json", {"--set", "frame=1", "-o", "alone.exr"}), 0);
  EXPECT_EQ(pixels("t.1.exr"), pixels("alone.exr"));
  ASSERT_EQ(render("quarter.json", {"--set", "frame=2", "-o", "quarter.exr"}), 0);
  EXPECT_LT(mean_difference("t.2.exr", "quarter.exr"), 1e-4);
  // About what the camera looks at, wherever the objects are.
  scene("beside.json", "[1, 1, 8]", "[0, 2, 3]", "[1, 0, 0]");
  scene("beside_quarter.json", "[6.65685425, 1, 5.65685425]", "[0, 2, 3]", "[1, 0, 0]");
  ASSERT_EQ(render("beside.json", {"--turntable", "8", "--frames", "2", "-o", "a.#.exr"}), 0);
  ASSERT_EQ(render("beside_quarter.json", {"--set", "frame=2", "-o", "beside.exr"}), 0);
  EXPECT_LT(mean_difference("a.2.exr", "beside.exr"), 1e-4);
  ASSERT_EQ(render("turn.json", {"--turntable", "8", "--turntable-lights", "--frames", "2", "-o", "l.#.exr"}), 0);
  ASSERT_EQ(render("lights.json", {"--set", "frame=2", "-o", "lights.exr"}), 0);
  EXPECT_LT(mean_difference("l.2.exr", "lights.exr"), 1e-4);
  EXPECT_GT(mean_difference("l.2.exr", "t.2.exr"), 1e-3);
  EXPECT_EQ(render("turn.json", {"--turntable-lights", "-o", "x.exr"}), 2);
  ASSERT_EQ(render("turn.json", {"--turntable", "8", "--frames", "3,1", "-o", "b.#.exr"}), 0);
  EXPECT_EQ(pixels("t.1.exr"), pixels("b.1.exr"));
}

// The patch moves by a quarter of a unit in a frame.
// promise: pipeline.frames.motion
TEST_F(FramesTest, MotionIsUpToTheNextFrameWithoutAShutter) {
  const auto motion = [&](const std::string& file) {
    const std::vector<float> all = pixels(file);  // RGBA, motion.XY
    std::array<double, 3> sum{};
    for (size_t i = 0; i + 5 < all.size(); i += 6)
      if (all[i + 3] == 1) sum[0] += double(all[i + 4]), sum[1] += double(all[i + 5]), sum[2] += 1;
    return std::array{sum[0] / sum[2], sum[1] / sum[2]};
  };
  const double pixels_per_unit = 12 / (2 * 5 * std::tan(0.25));
  ASSERT_EQ(render("moving.gltf", {"--frames", "1,2", "--fps", "8", "-o", "m.#.exr", "--aov", "motion"}), 0);
  ASSERT_EQ(render("moving.gltf", {"--frames", "1,2", "--fps", "8", "-o", "c.#.exr"}), 0);
  for (const char* frame : {"1", "2"}) {
    EXPECT_NEAR(motion("m." + std::string(frame) + ".exr")[0], 0.25 * pixels_per_unit, 1e-3) << frame;
    EXPECT_NEAR(motion("m." + std::string(frame) + ".exr")[1], 0, 1e-5) << frame;
    const std::vector<float> with = pixels("m." + std::string(frame) + ".exr"),
                             without = pixels("c." + std::string(frame) + ".exr");
    for (size_t i = 0; i < without.size() / 4; ++i)
      for (size_t c = 0; c < 4; ++c) ASSERT_EQ(with[6 * i + c], without[4 * i + c]) << frame << " " << i;
  }
  write("product.json", R"({"gltf": [{"file": "moving.gltf", "time": 0}],
                            "products": [{"file": "p.exr", "aovs": ["color", "motion"]}]})");
  ASSERT_EQ(render("product.json", {"--fps", "8", "--shutter", "0:0.1"}), 0);
  EXPECT_NEAR(motion("p.exr")[0], 0.25 * pixels_per_unit, 1e-3) << "an open shutter";
  ASSERT_EQ(render("moving.gltf", {"--time", "1", "--shutter", "0:0.1", "-o", "s.exr", "--aov", "motion", "--set",
                                   "motionShutter=camera"}),
            0);
  EXPECT_NEAR(motion("s.exr")[0], 0.1 / 24 * 2 * pixels_per_unit, 1e-3);
}

// A patch before a camera that turns by 20 degrees from frame to frame, about the patch's middle. The patch keeps its
// pose.
// promise: pipeline.frames.turntable_motion
TEST_F(FramesTest, ATurntableMovesItsCamera) {
  write("turn.json", R"({"gltf": [{"file": "framed.gltf"}], "settings": {"studio": "off"},
                         "camera": {"lookAt": {"eye": [0, 0, 8], "target": [0, 0, 0]}}})");
  ASSERT_EQ(render("turn.json", {"--turntable", "18", "--frames", "1", "--time", "0", "-o", "t.#.exr", "--aov",
                                 "motion", "--aov", "Peye"}),
            0);
  const std::vector<float> all = pixels("t.1.exr");  // RGBA, Peye.XYZ, motion.XY, by names
  const auto input = OIIO::ImageInput::open(folder_ / "t.1.exr");
  ASSERT_TRUE(input);
  const auto channel = [&](const char* name) { return size_t(input->spec().channelindex(name)); };
  const size_t count = size_t(input->spec().nchannels);
  const double turn = 20 * M_PI / 180;
  size_t seen = 0;
  double scale = 0;
  for (size_t i = 0; i + count <= all.size(); i += count) {
    if (all[i + channel("A")] < 1) continue;
    const double x = double(all[i + channel("Peye.X")]), z = 8 + double(all[i + channel("Peye.Z")]);
    // The camera turns against the clock, so the patch turns with it.
    const double x1 = x * std::cos(turn) - z * std::sin(turn), z1 = x * std::sin(turn) + z * std::cos(turn) - 8;
    const double motion = x1 / -z1 - x / 8;
    if (std::abs(x) < 0.3) continue;
    const double found = double(all[i + channel("motion.X")]) / motion;
    EXPECT_NEAR(found, seen++ > 0 ? scale : found, 2e-3 * std::abs(found)) << "pixels per slope";
    scale = found;
  }
  EXPECT_GT(seen, 4u);
  EXPECT_GT(scale, 8) << "16 pixels";
  ASSERT_EQ(render("turn.json", {"--turntable", "8", "--frames", "1", "--shutter", "0:0.5", "-o", "b.#.exr"}), 0);
  ASSERT_EQ(render("turn.json", {"--turntable", "8", "--frames", "1", "-o", "c.#.exr"}), 0);
  EXPECT_NE(pixels("b.1.exr"), pixels("c.1.exr")) << "an open shutter blurs the turn";
}

// promise: pipeline.stats.failed, pipeline.stats.exit_code
TEST_F(FramesTest, EachFrameHasStatisticsAndSoHasARunThatFails) {
  ASSERT_EQ(render("moving.gltf", {"--frames", "0:4:4", "-o", "f.#.exr", "--stats", "f.##.json"}), 0);
  for (const char* file : {"f.00.json", "f.04.json"}) {
    const json stats = json::parse(std::ifstream(folder_ / file));
    EXPECT_EQ(stats["status"], "done");
    EXPECT_EQ(stats["renders"].size(), 1u);
  }
  EXPECT_EQ(json::parse(std::ifstream(folder_ / "f.04.json"))["files"], json::array({"f.4.exr"}));
  write("broken.gltf", "{");
  EXPECT_EQ(render("broken.gltf", {"-o", "b.exr", "--stats", "b.json"}), 3);
  json stats = json::parse(std::ifstream(folder_ / "b.json"));
  EXPECT_EQ(stats["status"], "failed");
  EXPECT_EQ(stats["exitCode"], 3);
  EXPECT_EQ(render("broken.gltf", {"-o", "b.exr", "--stats", "broken.gltf"}), 3);
  EXPECT_EQ(std::filesystem::file_size(folder_ / "broken.gltf"), 1u) << "an input";
  EXPECT_EQ(render("moving.gltf",
                   {"-o", "b.exr", "--stats", "b.json", "--set", "memoryLimit=1", "--crop", "0,0,20000,20000"}),
            4);
  stats = json::parse(std::ifstream(folder_ / "b.json"));
  EXPECT_EQ(stats["status"], "failed");
  EXPECT_EQ(stats["exitCode"], 4);
}

TEST_F(FramesTest, StatisticsHaveTheFrameOfAnArchive) {
  Program convert(folder_, {"convert", "moving.gltf", "--set", "frame=7", "-o", "moving.alab"});
  ASSERT_EQ(convert.wait(), 0) << convert.err();
  ASSERT_EQ(render("moving.alab", {"-o", "f.exr", "--stats", "s.json"}), 0);
  EXPECT_EQ(json::parse(std::ifstream(folder_ / "s.json"))["frames"], json::array({7}));
}

TEST_F(FramesTest, WithoutATimeThePoseIsThatOfTheFile) {
  ASSERT_EQ(render("moving.gltf", {"-o", "rest.exr"}), 0);
  ASSERT_EQ(render("moving.gltf", {"-o", "late.exr", "--time", "1e3"}), 0);
  EXPECT_GT(coverage("rest.exr"), 0.1);
  EXPECT_EQ(coverage("late.exr"), 0);
}

TEST_F(FramesTest, ACameraThatWasFramedStandsStill) {
  ASSERT_EQ(render("framed.gltf", {"--frames", "0:24:24", "--fps", "6", "-o", "a.####.exr", "--studio", "off"}), 0);
  EXPECT_GT(coverage("a.0000.exr"), 0.1);
  EXPECT_EQ(coverage("a.0024.exr"), 0);
}

TEST_F(FramesTest, DescriptionsHaveATimeForEachModel) {
  const std::string camera = R"("camera": {"lookAt": {"eye": [0, 0, 8], "target": [0, 0, 0]}})";
  write("scene.json", R"({"gltf": [{"file": "framed.gltf", "time": 3.5}], "settings": {"studio": "off"},
                          "products": [{"file": "shot.####.exr"}], )" +
                          camera + "}");
  ASSERT_EQ(render("scene.json", {"--frames", "0:12:12"}), 0);
  EXPECT_EQ(coverage("shot.0000.exr"), 0);  // 3.5 seconds, 7 units
  write("still.json", R"({"gltf": [{"file": "framed.gltf", "animation": "slide"}], "settings": {"studio": "off"},
                          "products": [{"file": "still.exr"}], )" +
                          camera + "}");
  ASSERT_EQ(render("still.json", {}), 0);
  EXPECT_GT(coverage("still.exr"), 0.05);
  std::string said;
  EXPECT_EQ(render("still.json", {"--frames", "1:2"}, &said), 2);
  EXPECT_NE(said.find("All frames would go to"), std::string::npos) << said;
  write("two.json",
        R"({"gltf": [{"file": "framed.gltf"}, {"file": "patch.gltf"}], "products": [{"file": "two.exr"}]})");
  EXPECT_EQ(render("two.json", {"--animation", "slide"}, &said), 2);
  EXPECT_NE(said.find("There are several models"), std::string::npos) << said;
}

// The patch moves two units a second, and half of it has left the picture at half a second.
TEST_F(FramesTest, AnOpenShutterBlursWhatMovesInIt) {
  const auto covered = [&](const std::string& time, const std::string& shutter) {
    std::vector<std::string> more{"--time", time, "--set", "samples=64", "-o", "a.exr"};
    if (!shutter.empty()) more.insert(more.end(), {"--shutter", shutter, "--fps", "10"});
    EXPECT_EQ(render("moving.gltf", more), 0);
    return coverage("a.exr");
  };
  const double before = covered("0.5", ""), after = covered("0.7", "");
  EXPECT_GT(before, after + 0.05);
  EXPECT_NEAR(covered("0.5", "0:2"), 0.5 * (before + after), 0.02);
  EXPECT_NEAR(covered("0.6", "-1:1"), 0.5 * (before + after), 0.02);
  ASSERT_EQ(render("moving.gltf", {"--time", "0.5", "-o", "still.exr"}), 0);
  ASSERT_EQ(render("moving.gltf", {"--time", "0.5", "--shutter", "0:0", "-o", "closed.exr"}), 0);
  EXPECT_EQ(pixels("still.exr"), pixels("closed.exr"));
  ASSERT_EQ(render("lit.gltf", {"-o", "still.exr"}), 0);
  ASSERT_EQ(render("lit.gltf", {"--shutter", "-1:1", "-o", "open.exr"}), 0);
  EXPECT_EQ(pixels("still.exr"), pixels("open.exr")) << "nothing moves";
  std::string said;
  for (const char* bad : {"1:0", "1", "0:nan", "a:b"})
    EXPECT_EQ(render("moving.gltf", {"--shutter", bad, "-o", "a.exr"}, &said), 2) << bad;
  EXPECT_NE(said.find("is not a shutter"), std::string::npos) << said;
}

TEST_F(FramesTest, AFileWithoutAnimationIsWarnedOf) {
  std::string said;
  EXPECT_EQ(render("lit.gltf", {"--time", "1", "-o", "a.exr"}, &said), 0);
  EXPECT_NE(said.find("warning: lit.gltf: It has no animation"), std::string::npos) << said;
}

// Two nodes of a mesh whose morph weights differ in frames 0 and 2, and agree in frame 1, where they share its shape.
TEST_F(FramesTest, NodesWhoseWeightsAgreeInOneFrameAreDrawnOnce) {
  hd::gltf::testing::GltfBuilder b;
  b.triangle();
  b.primitive()["targets"] = {{{"POSITION", b.add<float>({0, 0, 0, 0, 0, 0, 1, 1, 0}, "VEC3")}}};
  b.json["nodes"] = {
      {{"mesh", 0}, {"translation", {-1, 0, 0}}}, {{"mesh", 0}}, {{"camera", 0}, {"translation", {0, 0.5, 5}}}};
  b.json["scenes"][0]["nodes"] = {0, 1, 2};
  b.json["cameras"] = {{{"type", "perspective"}, {"perspective", {{"yfov", 0.5}, {"znear", 0.1}}}}};
  b.animate(1, "weights", {0, 1, 2}, {1, 0, 1}, "SCALAR", "STEP");
  write("agree.glb", b.bytes());
  for (const std::string shutter : {"0:0", "0:0.5"}) {
    const std::vector<std::string> same{"--fps", "1", "--shutter", shutter, "--aov", "depth", "--studio", "off"};
    std::vector<std::string> all{"--frames", "0:2", "-o", "f.#.exr"};
    all.insert(all.end(), same.begin(), same.end());
    ASSERT_EQ(render("agree.glb", all), 0);
    for (const std::string frame : {"0", "1", "2"}) {
      std::vector<std::string> alone{"--time", frame, "--set", "frame=" + frame, "-o", "alone.exr"};
      alone.insert(alone.end(), same.begin(), same.end());
      ASSERT_EQ(render("agree.glb", alone), 0);
      EXPECT_EQ(pixels("f." + frame + ".exr"), pixels("alone.exr")) << frame << ", shutter " << shutter;
    }
  }
}

TEST_F(FramesTest, AnInterruptedSequenceKeepsTheFramesThatAreDone) {
  Program program(folder_, {"render", "moving.gltf", "--size", "64x48", "--spp", "64", "--frames", "0:9999", "-o",
                            "f.####.exr", "--stats", "s.json"});
  for (int wait = 0; wait < 600 && !std::filesystem::exists(folder_ / "f.0001.exr"); ++wait)
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  program.interrupt();
  EXPECT_EQ(program.wait(), 130);
  EXPECT_FALSE(pixels("f.0000.exr").empty());
  EXPECT_EQ(program.err().find("incomplete"), std::string::npos);
  for (const auto& entry : std::filesystem::directory_iterator(folder_)) {
    const auto file = entry.path().extension() == ".exr" ? OIIO::ImageInput::open(entry.path().string()) : nullptr;
    EXPECT_EQ(file ? file->spec().get_int_attribute("alabaster/incomplete", 0) : 0, 0) << entry.path();
  }
  const json stats = json::parse(std::ifstream(folder_ / "s.json"));
  EXPECT_EQ(stats["status"], "interrupted");
  EXPECT_LT(stats["files"].size(), 9999u);
  for (const json& file : stats["files"]) EXPECT_FALSE(pixels(file).empty()) << file;
}

}  // namespace
}  // namespace alabaster::cli
