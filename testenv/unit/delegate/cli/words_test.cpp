// Answers of the program to wrong words, and the commands that it proposes: each works as it stands.
#include <sys/ioctl.h>

#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <utility>

#include "delegate/cli/command_words.h"
#include "testenv/unit/delegate/cli/run_program.h"
#include "testenv/unit/delegate/description/scene_fixture.h"

namespace alabaster::cli {
namespace {

#define EXPECT_HAS(text, part) EXPECT_NE((text).find(part), std::string::npos) << "said: " << (text)

using Words = std::vector<std::string>;

class WordsTest : public hd::description::SceneFiles {
 protected:
  Outcome run(const Words& arguments) const { return run_program(folder_, arguments); }

  /// Runs a command in a shell, as a person who copies it; its exit code.
  int paste(const std::string& command) const {
    const std::string programs = std::filesystem::path(testing::kProgram).parent_path().string();
    const std::string line = "cd '" + folder_.string() + "' && PATH='" + programs + "':$PATH && " + command +
                             " > pasted.txt 2> pasted_errors.txt < /dev/null";
    const int status = std::system(line.c_str());
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }

  /// The first command that a text proposes, without the prompt of its line.
  static std::string proposed(const std::string& text, const std::string& before = "\n  ") {
    const size_t at = text.find(before + "alabaster ");
    if (at == std::string::npos) return {};
    const size_t begin = at + before.size();
    return text.substr(begin, text.find('\n', begin) - begin);
  }

  /// Expects bad usage, a word in the report, and a proposal that is `command` and works.
  void expect_proposal(const Words& arguments, const std::string& said, const std::string& command) const {
    const Outcome outcome = run(arguments);
    EXPECT_EQ(outcome.code, 2) << outcome.err;
    EXPECT_HAS(outcome.err, said);
    EXPECT_EQ(proposed(outcome.err), command) << outcome.err;
    EXPECT_EQ(paste(proposed(outcome.err)), 0) << outcome.err;
  }

  const Words quick_{"patch.gltf", "-o", "a.png", "--size", "16x12"};
  const std::string quick_text_ = "patch.gltf -o a.png --size 16x12";
  Words quick(const Words& begin, const Words& end) const {
    Words all = begin;
    all.insert(all.end(), quick_.begin(), quick_.end());
    all.insert(all.end(), end.begin(), end.end());
    return all;
  }
};

TEST_F(WordsTest, TheProgramAloneShowsFiveExamplesAndTheHelp) {
  const Outcome alone = run({});
  EXPECT_EQ(alone.code, 2);
  EXPECT_EQ(alone.out, "");
  size_t examples = 0;
  std::istringstream lines(alone.err);
  for (std::string line; std::getline(lines, line);) examples += line.starts_with("  alabaster ");
  EXPECT_EQ(examples, 5u) << alone.err;
  for (const char* part : {"render model.glb -o ", "--set ", "alabaster info ", "alabaster view ", "alabaster check ",
                           "alabaster --help", "alabaster render --help"})
    EXPECT_HAS(alone.err, part);
}

TEST_F(WordsTest, AMisspeltCommandNamesTheNearest) {
  expect_proposal(quick({"rendr"}, {"--spp", "1"}), "no command 'rendr'. Did you mean 'render'?",
                  "alabaster render " + quick_text_ + " --spp 1");
  expect_proposal({"inspect", "lit.gltf"}, "Did you mean 'info'?", "alabaster info lit.gltf");
  expect_proposal({"help", "render"}, "no command 'help'", "alabaster render --help");
  expect_proposal({"help"}, "no command 'help'", "alabaster --help");
  const Outcome unknown = run({"qqqqqqq"});
  EXPECT_EQ(unknown.code, 2);
  EXPECT_HAS(unknown.err, "The commands are render, merge, farm, ");
  EXPECT_HAS(run({"patch.bin"}).err, "'patch.bin' is a file, but no scene");
}

TEST_F(WordsTest, ASceneInThePlaceOfACommandIsRendered) {
  expect_proposal(quick({}, {"--spp", "1"}), "'patch.gltf' is a scene", "alabaster render " + quick_text_ + " --spp 1");
  expect_proposal({"--spp", "1", "patch.gltf", "--size", "16x12"}, "The command is missing",
                  "alabaster render patch.gltf --spp 1 --size 16x12 -o patch.png");
  write("scene.json", R"({"models": [{"file": "patch.gltf"}], "settings": {"samples": 1, "resolution": [16, 12]}})");
  expect_proposal({"scene.json"}, "'scene.json' is a scene", "alabaster render scene.json -o scene.png");
  std::filesystem::copy(folder_ / "patch.gltf", folder_ / "my patch.gltf");
  expect_proposal({"my patch.gltf", "--size", "16x12", "--spp", "1"}, "is a scene",
                  "alabaster render 'my patch.gltf' --size 16x12 --spp 1 -o 'my patch.png'");
}

TEST_F(WordsTest, AMisspeltOptionNamesTheNearest) {
  const struct {
    Words wrong;
    std::string option, right;
  } cases[] = {{{"--sample", "1"}, "--spp", "--spp 1"},
               {{"--sp=1"}, "--spp", "--spp 1"},
               {{"-spp", "1"}, "--spp", "--spp 1"},
               {{"--spp", "1", "--sead", "3"}, "--seed", "--spp 1 --seed 3"},
               {{"--spp", "1", "--tagret-error", "0.5"}, "--target-error", "--spp 1 --target-error 0.5"},
               {{"--spp", "1", "--target", "0.5"}, "--target-error", "--spp 1 --target-error 0.5"},
               {{"--spp", "1", "--quite"}, "--quiet", "--spp 1 --quiet"},
               {{"--spp", "1", "--noise", "0.9"}, "--target-error", "--spp 1 --target-error 0.9"},
               {{"--spp", "1", "--env", "0.5"}, "--dome", "--spp 1 --dome 0.5"}};
  for (const auto& [wrong, option, right] : cases)
    expect_proposal(quick({"render"}, wrong), "Did you mean '" + option + "'?",
                    "alabaster render " + quick_text_ + " " + right);
  const Outcome sides =
      run({"render", "--sample", "1", "patch.gltf", "-o", "a.png", "--width", "16", "--height", "12"});
  EXPECT_EQ(proposed(sides.err), "alabaster render --spp 1 patch.gltf -o a.png --size 1280x720");
  const Outcome unknown = run(quick({"render"}, {"--qqqqqqqqq"}));
  EXPECT_EQ(unknown.code, 2);
  EXPECT_HAS(unknown.err, "'alabaster render' has no option '--qqqqqqqqq'.");
  EXPECT_HAS(unknown.err, "alabaster render --help");
}

TEST_F(WordsTest, ASettingWithoutAnOptionIsProposedAsAValueOfSet) {
  const struct {
    Words wrong;
    std::string setting, right;
  } cases[] = {{{"--glossy-filter", "0.5"}, "glossyFilter", "--set glossyFilter=0.5"},
               {{"--glossy-filter=0.5"}, "glossyFilter", "--set glossyFilter=0.5"},
               {{"--glosy-fliter", "0.5"}, "glossyFilter", "--set glossyFilter=0.5"},
               {{"--refine", "2"}, "refineEdgeLength", "--set refineEdgeLength=2"},
               {{"--filter", "gaussian"}, "filter", "--set filter=gaussian"},
               {{"--set", "energy=bounded", "--textureFilter", "0.5"},
                "textureFilter",
                "--set energy=bounded --set textureFilter=0.5"},
               {{"--walk-guiding"}, "walkGuiding", "--set walkGuiding=true"},
               {{"--walk-guiding", "false"}, "walkGuiding", "--set walkGuiding=false"}};
  for (const auto& [wrong, setting, right] : cases) {
    Words words{"--spp", "1"};
    words.insert(words.end(), wrong.begin(), wrong.end());
    expect_proposal(quick({"render"}, words), "Did you mean '--set " + setting + "=VALUE'?",
                    "alabaster render " + quick_text_ + " --spp 1 " + right);
  }
  expect_proposal(quick({"render", "--spp", "1", "--adaptive"}, {}), "Did you mean '--set adaptive=VALUE'?",
                  "alabaster render --spp 1 --set adaptive=true " + quick_text_);
  expect_proposal({"check", "patch.gltf", "--samples", "4"}, "Did you mean '--set samples=VALUE'?",
                  "alabaster check patch.gltf --set samples=4");
  EXPECT_HAS(run({"schema", "--glossy-filter", "0.5"}).err, "'alabaster schema' has no option '--glossy-filter'. Its");
}

TEST_F(WordsTest, ACommandWhoseProgramIsNotThereSaysHowToBuildIt) {
  namespace fs = std::filesystem;
  fs::copy_file(testing::kProgram, folder_ / "alabaster");
  const auto run_copy = [&] {
    const int status =
        std::system(("cd '" + folder_.string() + "' && ./alabaster tradeoff patch.gltf 2> said.txt").c_str());
    std::stringstream said;
    said << std::ifstream(folder_ / "said.txt").rdbuf();
    return std::pair(WEXITSTATUS(status), said.str());
  };
  const auto missing = run_copy();
  EXPECT_EQ(missing.first, 2);
  EXPECT_HAS(missing.second, "cmake --build build/release --target alabaster-tradeoff");
  std::ofstream(folder_ / "alabaster-tradeoff") << "not a program";
  const auto broken = run_copy();
  EXPECT_EQ(broken.first, 4);
  EXPECT_HAS(broken.second, "alabaster-tradeoff: It could not be started: ");
}

TEST_F(WordsTest, TheWindowNamesTheNearestOptionToo) {
  if (!std::filesystem::exists(std::filesystem::path(testing::kProgram).parent_path() / "alabaster-view"))
    GTEST_SKIP() << "alabaster-view is not built";
  const Outcome misspelt = run({"view", "patch.gltf", "--camra", "front"});
  EXPECT_EQ(misspelt.code, 2);
  EXPECT_HAS(misspelt.err,
             "'alabaster view' has no option '--camra'. Did you mean '--camera'?\n  alabaster view "
             "patch.gltf --camera front\n");
  const Outcome missing = run({"view"});
  EXPECT_EQ(missing.code, 2);
  EXPECT_HAS(missing.err, "alabaster view: SCENE is required. For example:\n  alabaster view model.glb\n");
  EXPECT_EQ(run({"view", "--help"}).code, 0);
}

TEST_F(WordsTest, EachWordOfOtherProgramsNamesOurs) {
  for (const Alias& alias : kCommandAliases)
    EXPECT_HAS(run({alias.word, "patch.gltf"}).err, std::string("Did you mean '") + alias.ours + "'?");
  for (const Alias& alias : kFlagAliases) {
    const Outcome outcome = run({"render", "patch.gltf", std::string("--") + alias.word, "640"});
    EXPECT_EQ(outcome.code, 2) << alias.word;
    EXPECT_HAS(outcome.err, std::string("Did you mean '") + alias.ours + "'?");
    const std::string value = !alias.value ? "640" : std::string(alias.value) == "%:%" ? "640:640" : alias.value;
    EXPECT_HAS(outcome.err, std::string(" ") + alias.ours + " " + value);
  }
}

TEST_F(WordsTest, AMisspeltChoiceNamesTheNearest) {
  const struct {
    Words wrong;
    std::string choice, right;
  } cases[] = {{{"--quality", "previw"}, "preview", "--quality preview"},
               {{"--quality=drafft", "--spp", "1"}, "draft", "--quality=draft --spp 1"},
               {{"--spp", "1", "--subsurface", "wlak"}, "walk", "--spp 1 --subsurface walk"},
               {{"--spp", "1", "--studio", "onn"}, "on", "--spp 1 --studio on"},
               {{"-o", "a.exr", "--spp", "1", "--aov", "nromal"}, "normal", "-o a.exr --spp 1 --aov normal"}};
  for (const auto& [wrong, choice, right] : cases)
    expect_proposal(quick({"render"}, wrong), "id you mean '" + choice + "'?",
                    "alabaster render " + quick_text_ + " " + right);
  expect_proposal({"farm", "patch.gltf", "-o", "a.exr", "--tasks", "2", "--spp", "4", "--engine", "slrum"},
                  "Did you mean 'slurm'?", "alabaster farm patch.gltf -o a.exr --tasks 2 --spp 4 --engine slurm");
  EXPECT_HAS(run({"schema", "light"}).err, "Did you mean 'lights'?");
}

TEST_F(WordsTest, AMissingSceneShowsAnExample) {
  for (const char* command : {"render", "info", "check", "convert", "farm", "tradeoff"}) {
    const Outcome outcome = run({command});
    EXPECT_EQ(outcome.code, 2);
    EXPECT_HAS(outcome.err, "SCENE is required");
    EXPECT_HAS(outcome.err, std::string("\n  alabaster ") + command + " ");
  }
}

TEST_F(WordsTest, ARenderWithoutAnOutputIsProposedWithOne) {
  expect_proposal({"render", "patch.gltf", "--size", "16x12", "--spp", "1"}, "There is nothing to write: add -o FILE",
                  "alabaster render patch.gltf --size 16x12 --spp 1 -o patch.png");
}

TEST_F(WordsTest, InfoNamesWhatMayBeChangedAndHow) {
  write("lit.json", R"({"models": [{"file": "patch.gltf"}], "lights": [{"name": "key [1]*", "type": "sphereLight"}]})");
  const Outcome info = run({"info", "lit.json"});
  ASSERT_EQ(info.code, 0) << info.err;
  for (const char* part : {"  patch: /", "  skin: /", "  key [1]*: /lights/key [1]*", "baseColor", "subsurfaceSet",
                           "texture:file", "lookAt", "can be set:"})
    EXPECT_HAS(info.out, part);
  size_t examples = 0;
  std::istringstream lines(info.out);
  for (std::string line; std::getline(lines, line);) {
    if (!line.starts_with("  to change: ")) continue;
    ++examples;
    EXPECT_EQ(paste("alabaster info lit.json " + line.substr(std::string("  to change: ").size())), 0) << line;
  }
  EXPECT_EQ(examples, 4u) << "of materials, meshes, lights and the camera";
}

TEST_F(WordsTest, InfoTellsWhichPrimsShareANameAndThePathOfEach) {
  write("two.json", R"({"models": [{"file": "patch.gltf"}, {"file": "patch.gltf"}]})");
  const Outcome info = run({"info", "two.json"});
  ASSERT_EQ(info.code, 0) << info.err;
  const std::string several =
      "  to change: --set materials/skin.roughness=0.3\n"
      "  it changes 2 materials of this name; a path selects one:\n    ";
  const size_t at = info.out.find(several);
  ASSERT_NE(at, std::string::npos) << info.out;
  const size_t begin = at + several.size();
  const std::string option = info.out.substr(begin, info.out.find('\n', begin) - begin);
  EXPECT_EQ(option, "--set materials//copy2/gltf/patch/materials/0_skin.roughness=0.3");
  ASSERT_EQ(paste("alabaster info two.json --json " + option), 0);
  std::ifstream file(folder_ / "pasted.txt");
  const auto scene = nlohmann::json::parse(file);
  const auto roughness = [&](size_t i) {
    return scene["materials"][i]["nodes"][0]["parameters"].value("roughness", 0.0);
  };
  EXPECT_FLOAT_EQ(float(roughness(0)), 0.3f);
  EXPECT_NE(roughness(1), roughness(0));
}

// promise: pipeline.info
TEST_F(WordsTest, InfoHasLengthsInMillimetres) {
  const Outcome info = run({"info", "patch.gltf", "--set", "materials/skin.scatterDistance=[3.7,1.4,0.7]mm"});
  ASSERT_EQ(info.code, 0) << info.err;
  EXPECT_HAS(info.out, "size: 2000, 2000, 0 mm\n");
  EXPECT_HAS(info.out, "scatterDistance = [0.0037,0.0014,0.0007] (3.7, 1.4, 0.7 mm)\n");
}

// promise: pipeline.info
TEST_F(WordsTest, InfoHasTheCameraAsSetTakesIt) {
  write("lens.json", R"({"gltf": [{"file": "patch.gltf"}], "camera": {"focalLength": 35, "horizontalAperture": 24.89,
    "focusDistance": 4.5, "lookAt": {"eye": [0, 0, 5], "target": [0, 0, 0]}}})");
  const auto lens = [&](const std::vector<std::string>& more) {
    std::vector<std::string> words{"info", "lens.json", "--json"};
    words.insert(words.end(), more.begin(), more.end());
    return nlohmann::json::parse(run(words).out)["cameras"][0]["parameters"];
  };
  const auto as_described = lens({});
  EXPECT_EQ(as_described["focalLength"], 35);
  EXPECT_EQ(as_described["horizontalAperture"], 24.89);
  EXPECT_EQ(as_described["focusDistance"], 4.5) << "in scene units";
  const auto set = lens({"--set", "camera.focalLength=8.5", "--set", "camera.verticalAperture=18.67"});
  EXPECT_EQ(set["focalLength"], 8.5);
  EXPECT_EQ(set["verticalAperture"], 18.67);
}

// promise: pipeline.name.set
TEST_F(WordsTest, SetTellsOfTheTextureThatAValueTakesThePlaceOf) {
  write_image("wood.hdr");
  write("wood.json", R"({"gltf": [{"file": "lit.gltf"}], "materials": [{"match": "skin", "set":
    {"baseColor": {"file": "wood.hdr"}}}]})");
  const Outcome plain = run({"check", "wood.json", "--set", "materials/skin.roughness=0.5"});
  EXPECT_EQ(plain.code, 0) << plain.err;
  EXPECT_EQ(plain.err.find("loses"), std::string::npos) << plain.err;
  const Outcome colored = run({"check", "wood.json", "--set", "materials/skin.baseColor=[1,0,0]"});
  EXPECT_EQ(colored.code, 0) << colored.err;
  EXPECT_HAS(colored.err, "baseColor loses its texture 'wood.hdr'");
  const Outcome tinted =
      run({"check", "wood.json", "--set", R"(materials/skin.baseColor={"file": "wood.hdr", "scale": [1, 0.5, 0.5]})"});
  EXPECT_EQ(tinted.code, 0) << tinted.err;
  EXPECT_EQ(tinted.err.find("loses"), std::string::npos) << tinted.err;
}

// promise: pipeline.info
TEST_F(WordsTest, InfoHasTheBoundsOfTheSceneAndOfEachMesh) {
  write("moved.json",
        R"({"models": [{"file": "patch.gltf", "transform": {"translate": [10, 0, 0]}}, {"file": "patch.gltf"}],
    "meshes": [{"match": "/copy2/*", "visible": false}]})");
  const Outcome text = run({"info", "moved.json"});
  ASSERT_EQ(text.code, 0) << text.err;
  EXPECT_HAS(text.out,
             "bounds in scene units (metres in glTF): min (9, -1, 0), max (11, 1, 0), size (2, 2, 0), centre "
             "(10, 0, 0)\n");
  EXPECT_HAS(text.out, "hidden\n    bounds: min (-1, -1, 0), max (1, 1, 0), size (2, 2, 0), centre (0, 0, 0)\n");
  const Outcome json = run({"info", "moved.json", "--json", "--predict", "0.5", "--size", "16x12"});
  ASSERT_EQ(json.code, 0) << json.err;
  const auto scene = nlohmann::json::parse(json.out);
  using Numbers = std::vector<double>;
  EXPECT_EQ(scene["bounds"]["centre"], Numbers({10, 0, 0}));
  EXPECT_EQ(scene["bounds"]["size"], Numbers({2, 2, 0}));
  size_t boxes = 0;
  for (const auto& mesh : scene["meshes"]) boxes += mesh["bounds"]["max"].size() == 3;
  EXPECT_EQ(boxes, scene["meshes"].size());
  EXPECT_EQ(scene["triangles"]["modelled"].is_number(), true);
  const auto& prediction = scene["prediction"];
  EXPECT_EQ(prediction["targetError"], 0.5);
  EXPECT_EQ(prediction["resolution"], std::vector<int>({16, 12}));
  for (const char* key : {"samplesPerPixel", "wallSeconds", "cpuSeconds", "peakMegabytes"}) {
    EXPECT_GT(prediction[key]["value"], 0) << key;
    EXPECT_LE(prediction[key]["low"], prediction[key]["high"]) << key;
  }
}

// A scene of many meshes that are open in the same way, and of a material for each.
TEST_F(WordsTest, LikeWarningsAreShownThriceAndCounted) {
  std::string models = R"({"file": "patch.gltf"})";
  for (int i = 1; i < 7; ++i) models += R"(, {"file": "patch.gltf"})";
  write("many.json", R"({"models": [)" + models + R"(], "settings": {"resolution": [8, 8], "samples": 1},
    "materials": [{"match": "*", "set": {"scatterDistance": [0.1, 0.1, 0.1]}}]})");
  const auto lines = [](const std::string& text, const std::string& part) {
    size_t count = 0;
    for (size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++count;
    return count;
  };
  const Outcome render = run({"render", "many.json", "-o", "a.png"});
  ASSERT_EQ(render.code, 0) << render.err;
  EXPECT_EQ(lines(render.err, "subsurface scattering in a mesh that is not closed: "), 3u) << render.err;
  EXPECT_EQ(lines(render.err, "and 4 more warnings 'mesh.open: subsurface scattering"), 1u) << render.err;
  EXPECT_LT(render.err.find("more warnings"), render.err.find("wrote a.png")) << render.err;
  EXPECT_EQ(lines(run({"check", "many.json"}).err, "subsurface scattering in a mesh that is not closed: "), 7u);
}

TEST_F(WordsTest, ARenderTellsSizesAndOneNextCommand) {
  const Outcome done = run(quick({"render"}, {"--spp", "4"}));
  ASSERT_EQ(done.code, 0) << done.err;
  EXPECT_HAS(done.err, "rendering 16x12, 4 samples per pixel\n");
  EXPECT_HAS(done.err, "noise: ");
  EXPECT_HAS(done.err, "wrote a.png, 16x12 pixels\n");
  EXPECT_HAS(done.err, "time: ");
  const std::string next = proposed(done.err, "\nnext: ");
  EXPECT_EQ(paste(next), 0) << done.err;
  EXPECT_EQ(done.err.find("next: "), done.err.rfind("next: ")) << "one: " << done.err;
  EXPECT_EQ(run(quick({"render"}, {"--spp", "4", "--quiet"})).err, "");
}

TEST_F(WordsTest, TheNextCommandIsThatOfTheGreatestNeed) {
  const auto next = [this](const Words& arguments, const std::function<void()>& prepare = {}) {
    const std::string command = proposed(run_program(folder_, arguments, prepare).err, "\nnext: ");
    EXPECT_EQ(paste(command), 0) << command;
    return command;
  };
  const auto no_denoiser = [] { setenv("ALABASTER_OIDN", "/nowhere", 1); };
  write("lamp.json", R"({"models": [{"file": "patch.gltf"}], "settings": {"resolution": [64, 48], "samples": 2},
    "camera": {"lookAt": {"eye": [0, 0, 5], "target": [0, 0, 0]}},
    "lights": [{"name": "key", "type": "rectLight", "intensity": 30, "position": [2, 2, 0.5], "target": [0, 0, 0]}]})");
  const Outcome denoisable = run_program(folder_, {"render", "lamp.json", "-o", "a.exr"},
                                         [] { setenv("ALABASTER_OIDN", testing::kFakeOidn, 1); });
  EXPECT_EQ(proposed(denoisable.err, "\nnext: "),
            "alabaster render lamp.json -o a.exr --denoise  # the same without its noise");
  EXPECT_EQ(next({"render", "lamp.json", "-o", "a.exr"}, no_denoiser),
            "alabaster render lamp.json -o a.exr --target-error 0.05  # until the noise is 5 %");
  EXPECT_EQ(next({"render", "lamp.json", "-o", "a.exr", "--spp=2"}, no_denoiser),
            "alabaster render lamp.json -o a.exr --target-error 0.05  # until the noise is 5 %");
  EXPECT_EQ(next({"render", "lamp.json", "-o", "a.exr", "--target-error", "0.04"}, no_denoiser),
            "alabaster info lamp.json  # the materials and meshes, and how to change them");
}

TEST_F(WordsTest, ALongRenderTellsItsTimeAndWhatShortensIt) {
  Program program(folder_, {"render", "patch.gltf", "--size", "64x48", "--spp", "200000", "-o", "a.png"});
  ASSERT_TRUE(program.wait_for("expected time: ", 60)) << program.err();
  program.interrupt();
  EXPECT_EQ(program.wait(), 130);
  EXPECT_HAS(program.err(), "Shorter: --quality preview, --size 32x24, --time-limit 20\n");
}

/// A terminal of some width on which a program writes its errors.
class Terminal {
 public:
  explicit Terminal(unsigned short columns) : master_(posix_openpt(O_RDWR | O_NOCTTY)) {
    if (!exists()) return;
    EXPECT_TRUE(grantpt(master_) == 0 && unlockpt(master_) == 0);
    const char* name = ptsname(master_);
    name_ = name ? name : "";
    const winsize size{24, columns, 0, 0};
    slave_ = open(name_.c_str(), O_RDWR | O_NOCTTY);
    EXPECT_EQ(ioctl(slave_, TIOCSWINSZ, &size), 0);
  }
  ~Terminal() { close(master_); }
  /// Containers may have no pseudo-terminals.
  bool exists() const { return master_ >= 0; }
  Terminal(const Terminal&) = delete;
  Terminal& operator=(const Terminal&) = delete;

  /// For the child.
  std::function<void()> attach() const {
    return [this] { dup2(slave_, STDERR_FILENO); };
  }
  /// All that is written until the child ends.
  std::string read_all() {
    close(slave_);
    std::string text;
    char block[4096];
    for (ssize_t n; (n = read(master_, block, sizeof block)) > 0;) text.append(block, size_t(n));
    return text;
  }

 private:
  int master_, slave_ = -1;
  std::string name_;
};

TEST_F(WordsTest, OnATerminalOneLineTellsSamplesNoiseAndTimeLeft) {
  constexpr size_t kColumns = 60;
  Terminal terminal(kColumns);
  if (!terminal.exists()) GTEST_SKIP() << "there is no pseudo-terminal (/dev/pts)";
  Program program(folder_, quick({"render"}, {"--time-limit", "5"}), terminal.attach());
  const std::string text = terminal.read_all();
  EXPECT_EQ(program.wait(), 0) << text;
  bool complete = false;
  size_t bars = 0;
  for (size_t at = text.find('\r'); at != std::string::npos; at = text.find('\r', at + 1)) {
    const std::string line = text.substr(at + 1, text.find_first_of("\r\n\x1b", at + 1) - at - 1);
    EXPECT_LT(line.size(), kColumns) << line;
    bars += line.find(" samples") != std::string::npos;
    complete = complete || (line.find("  noise ") != std::string::npos && line.ends_with(" left"));
  }
  EXPECT_GT(bars, 10u);
  EXPECT_TRUE(complete) << text;
}

TEST_F(WordsTest, ElsewhereLinesOfProgressComeSeldom) {
  const Outcome done = run(quick({"render"}, {"--time-limit", "3"}));
  ASSERT_EQ(done.code, 0) << done.err;
  EXPECT_EQ(done.err.find(" left\n"), std::string::npos) << done.err;
  EXPECT_EQ(done.err.find('\r'), std::string::npos);
}

}  // namespace
}  // namespace alabaster::cli
