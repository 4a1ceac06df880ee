// Names in scene files from strangers: where they lead when they are opened, and files that have no end.
#include <OpenImageIO/imageio.h>
#include <sys/resource.h>
#include <sys/stat.h>

#include <nlohmann/json.hpp>

#include "testenv/unit/delegate/cli/run_program.h"
#include "testenv/unit/delegate/description/scene_fixture.h"

namespace alabaster::cli {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

#define EXPECT_HAS(text, part) EXPECT_NE((text).find(part), std::string::npos) << "said: " << (text)

class HostilePaths : public hd::description::SceneFiles {
 protected:
  void SetUp() override {
    SceneFiles::SetUp();
    fs::create_directories(folder_ / "in");
    fs::create_directories(folder_ / "out");
    fs::copy_file(folder_ / "patch.bin", folder_ / "in" / "patch.bin");
    write("in/lit.gltf", hd::description::patch_gltf(true, true));
    write_picture("out/secret.png");
    write_picture("in/tile.1001.png");
  }
  void write_picture(const std::string& name) const {
    const float red[3] = {1, 0, 0};
    const auto out = OIIO::ImageOutput::create("x.png");
    ASSERT_TRUE(out->open(folder_ / name, OIIO::ImageSpec(1, 1, 3, OIIO::TypeUInt8)));
    ASSERT_TRUE(out->write_image(OIIO::TypeFloat, red) && out->close());
  }
  /// The patch with an image as the base colour of its material.
  void write_textured(const std::string& name, const std::string& uri) const {
    json document = json::parse(hd::description::patch_gltf(true, true));
    document["materials"][0]["pbrMetallicRoughness"] = {{"baseColorTexture", {{"index", 0}}}};
    document["textures"] = {{{"source", 0}}};
    document["images"] = {{{"uri", uri}}};
    write(name, document.dump());
  }
  /// Within 20 seconds, or it counts as hanging.
  Outcome run(const std::vector<std::string>& arguments, const std::string& folder = "in",
              const std::function<void()>& prepare = {}) const {
    return run_program(folder_ / folder, arguments, [&] {
      ::alarm(20);
      if (prepare) prepare();
    });
  }
  Outcome render(const std::string& scene, const std::vector<std::string>& more = {}) const {
    std::vector<std::string> all{"render", scene, "--size", "8x6", "--spp", "1"};
    all.insert(all.end(), more.begin(), more.end());
    return run(all);
  }
  std::string text(const std::string& name) const {
    std::ifstream in(folder_ / name);
    return {std::istreambuf_iterator<char>(in), {}};
  }
};

// promise: security.reads
TEST_F(HostilePaths, TheTilesOfAGltfImageAreJudgedByTheirOwnNames) {
  write_textured("in/set.gltf", "tile.<UDIM>.png");
  EXPECT_EQ(render("set.gltf", {"-o", "a.png"}).code, 0);
  fs::create_symlink("../out/secret.png", folder_ / "in" / "tile.1002.png");
  const Outcome rendered = render("set.gltf", {"-o", "b.png"});
  EXPECT_EQ(rendered.code, 3) << rendered.err;
  EXPECT_HAS(rendered.err, "outside the folder");
  EXPECT_FALSE(fs::exists(folder_ / "in" / "b.png"));
  EXPECT_EQ(run({"check", "set.gltf"}).code, 3);
  EXPECT_EQ(render("set.gltf", {"-o", "b.png", "--allow-outside"}).code, 0);
}

// A link that appears once a scene is loaded is seen when the image is opened: this scene names no file that is there.
TEST_F(HostilePaths, AnAbsoluteLinkWithinTheFolderWorks) {
  fs::create_symlink(folder_ / "in" / "tile.1001.png", folder_ / "in" / "absolute.png");
  write_textured("in/linked.gltf", "absolute.png");
  EXPECT_EQ(render("linked.gltf", {"-o", "a.png"}).code, 0);
  fs::create_symlink(folder_ / "out" / "secret.png", folder_ / "in" / "away.png");
  write_textured("in/away.gltf", "away.png");
  EXPECT_EQ(render("away.gltf", {"-o", "a.png"}).code, 3);
}

// promise: security.writes
TEST_F(HostilePaths, AProductIsJudgedOnceItHasItsNumber) {
  write("in/s.json", R"({"gltf": [{"file": "lit.gltf"}], "products": [{"file": "o.####.exr"}]})");
  write("out/precious.exr", "precious");
  fs::create_symlink("../out/precious.exr", folder_ / "in" / "o.0002.exr");
  fs::create_symlink("../out/new.exr", folder_ / "in" / "o.0003.exr");
  for (const char* frames : {"2:2", "3:3", "1:3"}) {
    const Outcome rendered = render("s.json", {"--frames", frames});
    EXPECT_EQ(rendered.code, 3) << rendered.err;
    EXPECT_HAS(rendered.err, "outside the folder");
    EXPECT_FALSE(fs::exists(folder_ / "in" / "o.0001.exr")) << "told before the first frame";
  }
  EXPECT_EQ(text("out/precious.exr"), "precious");
  EXPECT_FALSE(fs::exists(folder_ / "out" / "new.exr"));
  fs::create_symlink(folder_ / "in" / "within.exr", folder_ / "in" / "o.0004.exr");
  EXPECT_EQ(render("s.json", {"--frames", "4:4"}).code, 0);
  EXPECT_TRUE(fs::is_regular_file(folder_ / "in" / "within.exr"));
  // The user's own words lead anywhere.
  EXPECT_EQ(render("s.json", {"--frames", "2:2", "-o", "o.####.exr"}).code, 0);
  EXPECT_NE(text("out/precious.exr"), "precious");
}

// promise: security.no_wait
TEST_F(HostilePaths, NothingThatHasNoEndIsWaitedFor) {
  ASSERT_EQ(::mkfifo((folder_ / "in" / "fifo.png").c_str(), 0600), 0);
  for (const char* name : {"fifo.1001.png", "fifo.bin", "fifo.ies", "fifo.ocio", "fifo.gltf", "fifo.json"})
    fs::create_symlink("fifo.png", folder_ / "in" / name);
  const auto expect_refused = [&](const std::string& scene, const std::vector<std::string>& more = {}) {
    std::vector<std::string> all = more;
    all.insert(all.end(), {"-o", "a.exr"});
    const Outcome rendered = render(scene, all);
    EXPECT_EQ(rendered.code, 3) << scene << ": " << rendered.err;
    EXPECT_TRUE(rendered.err.find("regular file") != std::string::npos ||
                rendered.err.find("this is not a file") != std::string::npos)
        << scene << ": " << rendered.err;
    EXPECT_EQ(run({"check", scene}).code, more.empty() ? 3 : 0);
  };
  write_textured("in/image.gltf", "fifo.png");
  write_textured("in/tile.gltf", "fifo.<UDIM>.png");
  std::string buffer = hd::description::patch_gltf(true, true);
  buffer.replace(buffer.find("patch.bin"), 9, "fifo.bin");
  write("in/buffer.gltf", buffer);
  const std::string begin = R"({"gltf": [{"file": "lit.gltf"}], )";
  write("in/dome.json", begin + R"("lights": [{"name": "d", "type": "domeLight", "texture:file": "fifo.png"}]})");
  write("in/ies.json", begin + R"("lights": [{"name": "d", "type": "sphereLight", "shaping:ies:file": "fifo.ies"}]})");
  write("in/ocio.json", begin + R"("ocio": "fifo.ocio"})");
  write("in/model.json", R"({"gltf": [{"file": "fifo.gltf"}]})");
  for (const char* scene : {"image.gltf", "tile.gltf", "buffer.gltf", "dome.json", "ies.json", "ocio.json",
                            "model.json", "fifo.gltf", "fifo.json"})
    expect_refused(scene);
  expect_refused("lit.gltf", {"--ocio", "fifo.ocio"});
  expect_refused("lit.gltf", {"--dome", "fifo.png"});
}

TEST_F(HostilePaths, ACheckpointThatHasNoEndIsRefused) {
  ASSERT_EQ(::mkfifo((folder_ / "in" / "part").c_str(), 0600), 0);
  for (const Outcome& outcome : {run({"merge", "part", "-o", "a.exr"}), run({"merge", "part"}),
                                 render("lit.gltf", {"-o", "a.exr", "--checkpoint", "part", "--resume"})}) {
    EXPECT_EQ(outcome.code, 3) << outcome.err;
    EXPECT_HAS(outcome.err, "not a regular file");
  }
}

// 120 million instances are counted before they are made, by the limit that holds without the file's own.
// promise: pipeline.memory.limit, security.limits
TEST_F(HostilePaths, AFileCannotRaiseTheMemoryLimit) {
  write("in/plain.json", R"({"gltf": [{"file": "lit.gltf"}], "settings": {"memoryLimit": 1000000}})");
  const Outcome raised = render("plain.json", {"-o", "a.exr", "--stats", "s.json"});
  EXPECT_EQ(raised.code, 0) << raised.err;
  EXPECT_HAS(raised.err, "A file cannot raise the limit");
  const auto limit = [&] { return json::parse(text("in/s.json"))["delegate"][0]["memoryLimit"]; };
  EXPECT_LT(limit().get<double>(), 1e6 * 0x1p20);
  EXPECT_EQ(render("plain.json", {"-o", "a.exr", "--stats", "s.json", "--memory-limit", "700"}).code, 0);
  EXPECT_EQ(limit().get<double>(), 700 * 0x1p20);
  write("in/tight.json", R"({"gltf": [{"file": "lit.gltf"}], "settings": {"memoryLimit": 600}})");
  EXPECT_EQ(render("tight.json", {"-o", "a.exr", "--stats", "s.json"}).code, 0);
  EXPECT_EQ(limit().get<double>(), 600 * 0x1p20);
}

// The limit holds while a model is loaded, too.
TEST_F(HostilePaths, AFileCannotRaiseTheLimitOfLoading) {
  json document = json::parse(hd::description::patch_gltf(true, true));
  document["accessors"].push_back({{"componentType", 5126}, {"count", 1'000'000}, {"type", "VEC3"}});
  document["extensionsUsed"] = {"EXT_mesh_gpu_instancing", "KHR_lights_punctual"};
  document["nodes"][0]["extensions"] = {{"EXT_mesh_gpu_instancing", {{"attributes", {{"TRANSLATION", 2}}}}}};
  for (size_t i = 0; i < 30; ++i) {
    document["scenes"][0]["nodes"].push_back(document["nodes"].size());
    document["nodes"].push_back(document["nodes"][0]);
  }
  write("in/many.gltf", document.dump());
  for (const char* settings : {"{}", R"({"memoryLimit": 1000000})"}) {
    write("in/many.json", std::string(R"({"gltf": [{"file": "many.gltf"}], "settings": )") + settings + "}");
    const Outcome refused = run({"check", "many.json"}, "in", [] {
      // The program's limit is three quarters of the address space. Its message rounds the limit down.
      const rlimit space{rlim_t(3001) << 20, rlim_t(3001) << 20};
      ::setrlimit(RLIMIT_AS, &space);
    });
    EXPECT_EQ(refused.code, 4) << refused.err;
    EXPECT_HAS(refused.err, "more, but of the memory limit of 2250 MiB");
  }
}

}  // namespace
}  // namespace alabaster::cli
