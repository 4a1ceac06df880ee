// The program from outside: exit codes, messages, files.
#include <OpenImageIO/imageio.h>

#include <nlohmann/json.hpp>

#include "testenv/unit/delegate/cli/run_program.h"
#include "testenv/unit/delegate/description/scene_fixture.h"

namespace alabaster::cli {
namespace {

class ProgramTest : public hd::description::SceneFiles {
 protected:
  struct Outcome {
    int code;
    std::string out, err;
  };
  Outcome run(const std::vector<std::string>& arguments) const {
    Program program(folder_, arguments);
    const int code = program.wait();
    return {code, program.out(), program.err()};
  }
  /// A render that takes no time worth mentioning.
  std::vector<std::string> quick(const std::vector<std::string>& more) const {
    std::vector<std::string> all{"render", "patch.gltf", "--size", "32x24", "--spp", "2"};
    all.insert(all.end(), more.begin(), more.end());
    return all;
  }
  bool exists(const std::string& name) const { return std::filesystem::exists(folder_ / name); }
  /// No temporary file was left behind.
  size_t file_count() const {
    return static_cast<size_t>(std::distance(std::filesystem::directory_iterator(folder_), {}));
  }
};

#define EXPECT_HAS(text, part) EXPECT_NE((text).find(part), std::string::npos) << "said: " << (text)

TEST_F(ProgramTest, VersionHelpAndSchema) {
  const Outcome version = run({"--version"});
  EXPECT_EQ(version.code, 0);
  EXPECT_HAS(version.out, "0.1.0");
  EXPECT_HAS(version.out, "Embree");
  EXPECT_EQ(run({"--help"}).code, 0);
  const Outcome schema = run({"schema", "lights"});
  EXPECT_EQ(schema.code, 0);
  EXPECT_EQ(schema.out, hd::description::SchemaText("lights"));
  const Outcome unknown = run({"schema", "lamps"});
  EXPECT_EQ(unknown.code, 2);
  EXPECT_HAS(unknown.err, "render_description");
}

TEST_F(ProgramTest, UsageErrorsEndWithTwo) {
  EXPECT_EQ(run({}).code, 2);
  EXPECT_EQ(run({"render"}).code, 2);
  const Outcome flag = run({"render", "patch.gltf", "-o", "a.exr", "--sp", "3"});
  EXPECT_EQ(flag.code, 2);
  EXPECT_HAS(flag.err, "--sp");
  const Outcome size = run({"render", "patch.gltf", "-o", "a.exr", "--size", "huge"});
  EXPECT_EQ(size.code, 2);
  EXPECT_HAS(size.err, "1280x720");
  const Outcome nothing = run({"render", "patch.gltf"});
  EXPECT_EQ(nothing.code, 2);
  EXPECT_HAS(nothing.err, "add -o FILE");
  const Outcome spp = run({"render", "patch.gltf", "-o", "a.exr", "--spp", "0"});
  EXPECT_EQ(spp.code, 2);
  EXPECT_HAS(spp.err, "from 1 to 1048576");
  const Outcome set = run({"render", "patch.gltf", "-o", "a.exr", "--set", "materials/skin.rougness=1"});
  EXPECT_EQ(set.code, 2);
  EXPECT_HAS(set.err, "Did you mean 'roughness'?");
  const Outcome camera = run({"render", "lit.gltf", "-o", "a.exr", "--camera", "frnt"});
  EXPECT_EQ(camera.code, 2);
  EXPECT_HAS(camera.err, "Did you mean 'front'?");
  const Outcome aov = run({"render", "patch.gltf", "-o", "a.png", "--aov", "depth"});
  EXPECT_EQ(aov.code, 2);
  EXPECT_HAS(aov.err, "EXR");
}

TEST_F(ProgramTest, InputErrorsEndWithThree) {
  const Outcome missing = run({"render", "absent.glb", "-o", "a.exr"});
  EXPECT_EQ(missing.code, 3);
  EXPECT_HAS(missing.err, "absent.glb: There is no such file");
  write("bad.json", "{\n  \"gltf\": [],\n  \"cammera\": {}\n}");
  const Outcome key = run({"render", "bad.json", "-o", "a.exr"});
  EXPECT_EQ(key.code, 3);
  EXPECT_HAS(key.err, "bad.json:3 /cammera: Unknown key 'cammera'. Did you mean 'camera'?");
  write("broken.gltf", "{");
  EXPECT_EQ(run({"render", "broken.gltf", "-o", "a.exr"}).code, 3);
  EXPECT_FALSE(exists("a.exr"));
}

TEST_F(ProgramTest, OutputErrorsEndWithFiveBeforeRendering) {
  const Outcome folder = run(quick({"-o", "absent/a.exr"}));
  EXPECT_EQ(folder.code, 5);
  EXPECT_HAS(folder.err, "absent");
  EXPECT_EQ(run(quick({"-o", "a.xyz"})).code, 5);
  EXPECT_EQ(run(quick({"-o", "a.png", "--view", "no such view"})).code, 5);
  EXPECT_EQ(run(quick({"-o", "a.exr", "--stats", "absent/s.json"})).code, 5);
}

TEST_F(ProgramTest, RendersFilesAndStatistics) {
  const size_t before = file_count();
  const Outcome done =
      run(quick({"-o", "a.exr", "-o", "b.png", "--aov", "depth", "--aov", "primId", "--stats", "s.json"}));
  ASSERT_EQ(done.code, 0) << done.err;
  EXPECT_HAS(done.err, "note: no camera: framed the scene");
  EXPECT_HAS(done.err, "note: no light: added a soft dome");
  EXPECT_HAS(done.err, "wrote a.exr");
  EXPECT_EQ(file_count(), before + 5) << "a.exr, b.png, s.json, stdout.txt, stderr.txt and nothing else";
  const auto exr = OIIO::ImageInput::open(folder_ / "a.exr");
  ASSERT_TRUE(exr) << OIIO::geterror();
  EXPECT_EQ(exr->spec().width, 32);
  EXPECT_EQ(exr->spec().height, 24);
  EXPECT_EQ(exr->spec().get_int_attribute("alabaster/incomplete", 0), 0);
  std::ifstream file(folder_ / "s.json");
  const nlohmann::json stats = nlohmann::json::parse(file);
  EXPECT_EQ(stats["status"], "done");
  EXPECT_EQ(stats["settings"]["samples"], 2);
  EXPECT_EQ(stats["rays"]["camera"], 32 * 24 * 2);
  EXPECT_GT(stats["seconds"]["load"]["wall"], 0);
  EXPECT_GT(stats["seconds"]["render"]["wall"], 0);
  EXPECT_GT(stats["peakMemoryBytes"], 1 << 20);
  EXPECT_EQ(stats["files"].size(), 2u);
}

TEST_F(ProgramTest, QuietSaysNothing) {
  const Outcome done = run(quick({"-o", "a.exr", "--quiet"}));
  EXPECT_EQ(done.code, 0);
  EXPECT_EQ(done.err, "");
  EXPECT_EQ(done.out, "");
}

TEST_F(ProgramTest, ProductsOfTheDescriptionAreWritten) {
  write("scene.json", R"({"gltf": [{"file": "lit.gltf"}], "settings": {"resolution": [16, 12], "samples": 1},
    "products": [{"file": "one.exr"}, {"file": "two.exr", "resolution": [8, 6]}]})");
  const Outcome done = run({"render", "scene.json"});
  ASSERT_EQ(done.code, 0) << done.err;
  const auto one = OIIO::ImageInput::open(folder_ / "one.exr"), two = OIIO::ImageInput::open(folder_ / "two.exr");
  ASSERT_TRUE(one && two);
  EXPECT_EQ(one->spec().width, 16);
  EXPECT_EQ(two->spec().width, 8);
}

TEST_F(ProgramTest, CropIsADataWindow) {
  ASSERT_EQ(run(quick({"-o", "a.exr", "--crop", "4,5,20,15"})).code, 0);
  const auto exr = OIIO::ImageInput::open(folder_ / "a.exr");
  ASSERT_TRUE(exr);
  EXPECT_EQ(exr->spec().x, 4);
  EXPECT_EQ(exr->spec().y, 5);
  EXPECT_EQ(exr->spec().width, 16);
  EXPECT_EQ(exr->spec().height, 10);
  EXPECT_EQ(exr->spec().full_width, 32);
}

TEST_F(ProgramTest, InfoNamesWhatIsInTheScene) {
  const Outcome info = run({"info", "lit.gltf"});
  ASSERT_EQ(info.code, 0) << info.err;
  EXPECT_HAS(info.out, "meshes: 1 (2 triangles as modelled, 2 as rendered)");
  EXPECT_HAS(info.out, "skin");
  EXPECT_HAS(info.out, "sphereLight");
  EXPECT_HAS(info.out, "requires:");
  EXPECT_HAS(info.out, "memory");
}

TEST_F(ProgramTest, OcioListsAndExports) {
  const Outcome list = run({"ocio"});
  EXPECT_EQ(list.code, 0);
  EXPECT_HAS(list.out, "sRGB");
  const Outcome config = run({"ocio", "--export"});
  EXPECT_EQ(config.code, 0);
  EXPECT_HAS(config.out, "ocio_profile_version");
  EXPECT_EQ(run({"ocio", "--ocio", "absent.ocio"}).code, 3);
}

// The promise is 0.2 s on an idle machine. One of three attempts must keep it: a loaded machine may stall the others.
TEST_F(ProgramTest, InterruptWritesWhatThereIsAtOnce) {
  double best = 1e9;
  for (int attempt = 0; attempt < 3 && best >= 0.2; ++attempt) {
    Program program(
        folder_, {"render", "patch.gltf", "--size", "64x48", "--spp", "1000000", "-o", "a.exr", "--stats", "s.json"});
    ASSERT_TRUE(program.wait_for("samples", 30)) << program.err();
    std::this_thread::sleep_for(std::chrono::milliseconds(300));
    const auto start = std::chrono::steady_clock::now();
    program.interrupt();
    const int code = program.wait();
    best = std::min(best, std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
    ASSERT_EQ(code, 130) << program.err();
    EXPECT_HAS(program.err(), "interrupted: wrote what there is to a.exr");
    const auto exr = OIIO::ImageInput::open(folder_ / "a.exr");
    ASSERT_TRUE(exr) << OIIO::geterror();
    EXPECT_EQ(exr->spec().get_int_attribute("alabaster/incomplete", 0), 1);
    std::ifstream file(folder_ / "s.json");
    EXPECT_EQ(nlohmann::json::parse(file)["status"], "interrupted");
  }
  EXPECT_LT(best, 0.2);
}

TEST_F(ProgramTest, InterruptedRenderKeepsThePreviousFileWholeWhenNothingIsThere) {
  write("a.exr", "an earlier picture");
  Program program(folder_, {"render", "patch.gltf", "--spp", "1000000", "-o", "a.exr"});
  program.interrupt();
  EXPECT_NE(program.wait(), 0);
  std::ifstream file(folder_ / "a.exr");
  std::string text;
  std::getline(file, text);
  EXPECT_EQ(text, "an earlier picture");
}

}  // namespace
}  // namespace alabaster::cli
