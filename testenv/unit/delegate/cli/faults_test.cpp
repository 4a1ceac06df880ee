// The program with damaged, hostile and impossible input: an error is never exit 0, and outputs harm nothing.
#include <OpenImageIO/imageio.h>
#include <poll.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/sysmacros.h>

#include <nlohmann/json.hpp>

#include "testenv/unit/delegate/cli/run_program.h"
#include "testenv/unit/delegate/description/scene_fixture.h"

namespace alabaster::cli {
namespace {

#define EXPECT_HAS(text, part) EXPECT_NE((text).find(part), std::string::npos) << "said: " << (text)

class FaultsTest : public hd::description::SceneFiles {
 protected:
  Outcome run(const std::vector<std::string>& arguments, const std::function<void()>& prepare = {}) const {
    return run_program(folder_, arguments, prepare);
  }
  Outcome render(const std::string& scene, const std::vector<std::string>& more = {}) const {
    std::vector<std::string> all{"render", scene, "--size", "16x12", "--spp", "1", "-o", "a.exr", "--stats", "s.json"};
    all.insert(all.end(), more.begin(), more.end());
    return run(all);
  }
  nlohmann::json stats() const { return nlohmann::json::parse(std::ifstream(folder_ / "s.json")); }
  bool exists(const std::string& name) const { return std::filesystem::exists(folder_ / name); }
  std::string read(const std::string& name) const {
    std::ifstream in(folder_ / name);
    return {std::istreambuf_iterator<char>(in), {}};
  }
  /// The patch with `image` as the base colour of its material, by way of glTF.
  void write_textured(const std::string& name, const std::string& image) const {
    std::string text = hd::description::patch_gltf(true, true);
    const std::string plain = R"("materials": [{"name": "skin"}])";
    text.replace(text.find(plain), plain.size(),
                 R"("materials": [{"name": "skin", "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}],
                    "textures": [{"source": 0}], "images": [)" +
                     image + "]");
    write(name, text);
  }
  /// The rule for an image: input error, or with --keep-going rendered, marked, and a code of its own.
  void expect_fault(const std::string& scene, const std::vector<std::string>& more = {}) const {
    std::filesystem::remove(folder_ / "a.exr");
    const Outcome strict = render(scene, more);
    EXPECT_EQ(strict.code, 3) << strict.err;
    EXPECT_HAS(strict.err, "error: ");
    EXPECT_FALSE(exists("a.exr")) << scene;
    std::vector<std::string> all = more;
    all.push_back("--keep-going");
    const Outcome kept = render(scene, all);
    ASSERT_EQ(kept.code, 6) << kept.err;
    EXPECT_HAS(kept.err, "error: ");
    EXPECT_EQ(stats()["status"], "degraded");
    EXPECT_EQ(stats()["faults"].size(), 1u);
    const auto exr = OIIO::ImageInput::open(folder_ / "a.exr");
    ASSERT_TRUE(exr) << OIIO::geterror();
    EXPECT_NE(exr->spec().get_string_attribute("alabaster/sceneFaults"), "");
  }
};

// promise: pipeline.exit.degraded, pipeline.faults, pipeline.stats.faults, pipeline.stats.status
TEST_F(FaultsTest, AnImageThatCannotBeReadIsOneFaultWhereverItIsNamed) {
  const std::string good = "\x89PNG\r\n\x1a\n";
  write("cut.png", good + std::string("\0\0\0\x0dIHDR", 8));
  write("text.png", "no image");
  write_textured("cut.gltf", R"({"uri": "cut.png"})");
  write_textured("text.gltf", R"({"uri": "text.png"})");
  write_textured("absent.gltf", R"({"uri": "absent.png"})");
  write_textured("data.gltf", R"({"uri": "data:image/png;base64,AAAA"})");
  for (const char* scene : {"cut.gltf", "text.gltf", "absent.gltf", "data.gltf"}) expect_fault(scene);
  for (const char* image : {"cut.png", "text.png", "absent.png"}) {
    expect_fault("lit.gltf", {"--dome", image});
    const std::string name = image;
    write("dome.json", R"({"gltf": [{"file": "lit.gltf"}], "lights": [{"name": "d", "type": "domeLight",
                           "texture:file": ")" +
                           name + R"("}]})");
    expect_fault("dome.json");
    write("texture.json", R"({"gltf": [{"file": "lit.gltf"}], "materials": [{"match": "skin",
                              "set": {"baseColor": {"file": ")" +
                              name + R"("}}}]})");
    expect_fault("texture.json");
  }
}

// The patch has no texture coordinates, so it is looked up at (0, 0).
TEST_F(FaultsTest, ASetOfImagesNeedsOneWhereTheMeshHasTextureCoordinates) {
  const auto write_tile = [&](const char* name) {
    const float grey[3] = {0.5f, 0.5f, 0.5f};
    const auto out = OIIO::ImageOutput::create("x.png");
    ASSERT_TRUE(out->open(folder_ / name, OIIO::ImageSpec(1, 1, 3, OIIO::TypeUInt8)));
    ASSERT_TRUE(out->write_image(OIIO::TypeFloat, grey) && out->close());
  };
  write("set.json", R"({"gltf": [{"file": "lit.gltf"}], "materials": [{"match": "skin",
                        "set": {"baseColor": {"file": "skin.<UDIM>.png"}}}]})");
  expect_fault("set.json");
  write_tile("skin.1012.png");
  expect_fault("set.json");
  write_tile("skin.1001.png");
  EXPECT_EQ(render("set.json").code, 0);
  write("skin.1002.png", "no image");
  expect_fault("set.json");
}

TEST_F(FaultsTest, AnImageThatNothingUsesDoesNotCount) {
  write_textured("unused.gltf", R"({"uri": "absent.png"})");
  std::string text = read("unused.gltf");
  const std::string bound = R"("material": 0)";
  text.replace(text.find(bound), bound.size(), R"("mode": 4)");
  write("unused.gltf", text);
  EXPECT_EQ(render("unused.gltf").code, 0);
}

// promise: pipeline.faults
TEST_F(FaultsTest, ALightOutOfReachIsAFaultAndOneWithoutSizeAWarning) {
  write("far.json", R"({"gltf": [{"file": "lit.gltf"}],
                        "lights": [{"name": "k", "type": "sphereLight", "position": [1e300, 0, 0]}]})");
  expect_fault("far.json");
  write("flat.json", R"({"gltf": [{"file": "lit.gltf"}],
                         "lights": [{"name": "k", "type": "rectLight", "width": 0, "position": [0, 0, 3]}]})");
  const Outcome flat = render("flat.json", {"--quiet"});
  EXPECT_EQ(flat.code, 0);
  EXPECT_HAS(flat.err, "warning: /lights/k: ");
}

// A cage of 24 faces at level 8 has three million triangles, which 700 MB more than the program itself do not hold.
TEST_F(FaultsTest, AMeshThatMemoryDoesNotHoldIsNoPicture) {
#if defined(__SANITIZE_THREAD__) || defined(__SANITIZE_ADDRESS__)
  GTEST_SKIP() << "a sanitizer reserves more address space than this test's limits; builds without one run it";
#endif
  write("fine.json", R"({"gltf": [{"file": "patch.gltf"}],
                         "meshes": [{"match": "*", "scheme": "catmullClark", "refineLevel": 8}]})");
  int ended_well = 0, ended_badly = 0;
  for (const rlim_t megabytes : {600, 800, 1000, 1400, 2000, 8000}) {
    std::filesystem::remove(folder_ / "s.json");
    Program program(folder_,
                    {"render", "fine.json", "--size", "16x12", "--spp", "1", "-o", "a.exr", "--stats", "s.json",
                     "--threads", "1", "--keep-going"},
                    [&] {
                      const rlimit limit{megabytes << 20, megabytes << 20};
                      setrlimit(RLIMIT_AS, &limit);
                    });
    const int code = program.wait();
    (code == 0 ? ended_well : ended_badly) += 1;
    EXPECT_NE(code, -1) << megabytes << ": " << program.err();
    const bool said = program.err().find("error: ") != std::string::npos;
    EXPECT_EQ(said, code != 0) << megabytes << ", exit " << code << ": " << program.err();
    EXPECT_TRUE(!exists("s.json") || (stats()["status"] == "done") == (code == 0)) << megabytes;
  }
  EXPECT_GT(ended_well, 0);
  EXPECT_GT(ended_badly, 0);
}

// OpenImageIO brings 200 libraries. Without the memory for them none is to be installed.
TEST_F(FaultsTest, LibrariesThatMemoryDoesNotHoldAreNotMissing) {
#if defined(__SANITIZE_THREAD__) || defined(__SANITIZE_ADDRESS__)
  GTEST_SKIP() << "a sanitizer reserves more address space than this test's limits; builds without one run it";
#endif
  write("fine.json", R"({"gltf": [{"file": "patch.gltf"}]})");
  int refused = 0;
  for (const rlim_t megabytes : {70, 100, 140, 200}) {
    const Outcome outcome = run({"render", "fine.json", "--size", "16x12", "--spp", "1", "-o", "a.exr"}, [&] {
      const rlimit limit{megabytes << 20, megabytes << 20};
      setrlimit(RLIMIT_AS, &limit);
    });
    if (outcome.err.find("a.exr: ") == std::string::npos) continue;  // it did not get as far, or further
    ++refused;
    EXPECT_EQ(outcome.code, 4) << megabytes;
    EXPECT_HAS(outcome.err, "memory is short");
    EXPECT_EQ(outcome.err.find("install"), std::string::npos) << outcome.err;
  }
  EXPECT_GT(refused, 0);
}

// Each by arithmetic, so the machine's memory does not matter.
// promise: pipeline.exit.failed, pipeline.memory.files, security.memory
TEST_F(FaultsTest, TheMemoryLimitIsNamedByWhatWouldExceedIt) {
  write("fine.json", R"({"gltf": [{"file": "patch.gltf"}],
                         "meshes": [{"match": "*", "scheme": "catmullClark", "refineLevel": 8}]})");
  const Outcome fine = render("fine.json", {"--memory-limit", "16"});
  EXPECT_EQ(fine.code, 4) << fine.err;
  EXPECT_HAS(fine.err, "a mesh of 196608 triangles needs ");
  EXPECT_HAS(fine.err, "of the memory limit of 16 MiB ");
  EXPECT_HAS(fine.err, "raise memoryLimit");
  EXPECT_FALSE(exists("a.exr"));
  EXPECT_EQ(render("fine.json", {"--memory-limit", "16", "--keep-going"}).code, 4);
  EXPECT_FALSE(exists("a.exr")) << "nothing is drawn without the mesh";
  EXPECT_EQ(run({"check", "fine.json", "--memory-limit", "16"}).code, 4);
  EXPECT_EQ(render("fine.json", {"--memory-limit", "512"}).code, 0);

  const Outcome large =
      run({"render", "patch.gltf", "--size", "4096x4096", "--spp", "1", "-o", "a.exr", "--memory-limit", "64"});
  EXPECT_EQ(large.code, 4) << large.err;
  EXPECT_HAS(large.err, "a frame of 4096 x 4096 pixels needs ");

  // One accessor that costs the file nothing, decoded again for each primitive that uses it.
  std::string zeros = R"({"asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
      "accessors": [{"componentType": 5126, "type": "VEC3", "count": 1300000}], "meshes": [{"primitives": [)";
  for (int i = 0; i < 60; ++i) zeros += R"({"attributes": {"POSITION": 0}},)";
  zeros.back() = ']';
  write("zeros.gltf", zeros + "}]}");
  const Outcome decoded = render("zeros.gltf", {"--memory-limit", "512"});
  EXPECT_EQ(decoded.code, 4) << decoded.err;
  EXPECT_HAS(decoded.err, "the geometry of its meshes needs 1786 MiB more");

  std::string values = R"({"settings": {"memoryLimit": 100}, "gltf": [0)";
  for (int i = 0; i < 1000000; ++i) values += ",0";
  write("values.json", values + "]}");
  const Outcome listed = render("values.json", {"--memory-limit", "100"});
  EXPECT_EQ(listed.code, 4) << listed.err;
  EXPECT_HAS(listed.err, "JSON of 1000004 values needs ");
}

TEST_F(FaultsTest, UsageIsTwoAndInputIsThree) {
  EXPECT_EQ(render("patch.gltf", {"-o", "b.png", "--view", "Flim"}).code, 2);
  EXPECT_EQ(render("patch.gltf", {"--time-limit", "1e-300"}).code, 2);
  write("view.json", R"({"gltf": [{"file": "patch.gltf"}], "products": [{"file": "b.png", "view": "Flim"}]})");
  EXPECT_EQ(run({"render", "view.json", "--size", "16x12", "--spp", "1"}).code, 3);
  write("thin.json", R"({"gltf": [{"file": "patch.gltf"}], "settings": {"pixelAspectRatio": 1e30}})");
  EXPECT_EQ(render("thin.json").code, 3);
  const Outcome large = run({"render", "patch.gltf", "--size", "65536x65536", "--spp", "1", "-o", "a.exr"});
  EXPECT_EQ(large.code, 3) << large.err;
  EXPECT_FALSE(exists("a.exr"));
}

TEST_F(FaultsTest, MorePixelsThanAFormatHoldsAreRefusedBeforeTheRender) {
  const auto sized = [&](const std::string& file, const std::string& size) {
    return run({"render", "lit.gltf", "-o", "a.exr", "-o", file, "--size", size, "--spp", "1"});
  };
  for (const Outcome& outcome : {sized("a.jpg", "65501x2"), sized("a.jpg", "2x65501"), sized("a.png", "65536x2")}) {
    EXPECT_EQ(outcome.code, 2) << outcome.err;
    EXPECT_HAS(outcome.err, "write an .exr or .tif file");
  }
  const Outcome cropped =
      run({"render", "lit.gltf", "-o", "a.jpg", "--size", "8x8", "--crop=-65000,0,520,2", "--spp", "1"});
  EXPECT_EQ(cropped.code, 2) << cropped.err;
  EXPECT_FALSE(exists("a.exr"));
  write("wide.json", R"({"gltf": [{"file": "lit.gltf"}], "settings": {"resolution": [65501, 2], "samples": 1},
                         "products": [{"file": "a.jpg"}]})");
  for (const char* command : {"render", "check"}) {
    const Outcome outcome = run({command, "wide.json"});
    EXPECT_EQ(outcome.code, 3) << outcome.err;
    EXPECT_HAS(outcome.err, "65500 x 65500");
  }
  EXPECT_EQ(sized("a.jpg", "65500x1").code, 0);
}

// The faults that mark a picture are a text in it, which a JPEG holds 65533 bytes of.
TEST_F(FaultsTest, ManyFaultsDoNotEndAJpeg) {
  std::string images, textures, materials, primitives;
  for (int i = 0; i < 100; ++i) {
    const std::string n = std::to_string(i), comma = i > 0 ? "," : "";
    images += comma + R"({"uri": ")" + std::string(900, 'd') + n + R"(.png"})";
    textures += comma + R"({"source": )" + n + "}";
    materials += comma + R"({"pbrMetallicRoughness": {"baseColorTexture": {"index": )" + n + "}}}";
    primitives += comma + R"({"attributes": {"POSITION": 0}, "indices": 1, "material": )" + n + "}";
  }
  std::string text = hd::description::patch_gltf(true, true);
  const std::string plain = R"("materials": [{"name": "skin"}])",
                    one = R"([{"attributes": {"POSITION": 0}, "indices": 1, "material": 0}])";
  text.replace(text.find(one), one.size(), "[" + primitives + "]");
  text.replace(text.find(plain), plain.size(),
               R"("materials": [)" + materials + R"(], "textures": [)" + textures + R"(], "images": [)" + images + "]");
  write("many.gltf", text);
  const Outcome outcome =
      run({"render", "many.gltf", "-o", "a.jpg", "--size", "8x8", "--spp", "1", "--keep-going", "--quiet"});
  EXPECT_EQ(outcome.code, 6) << outcome.err;
  EXPECT_TRUE(exists("a.jpg"));
}

// promise: pipeline.limits
TEST_F(FaultsTest, InputsBeyondTheirLimitsAreRefused) {
  constexpr size_t kMiB = 1 << 20;
  const auto description = [&](size_t bytes) {
    const std::string text = R"({"models": [{"file": "patch.gltf"}])";
    write("long.json", text + std::string(bytes - text.size() - 1, ' ') + "}");
    return run({"check", "long.json"});
  };
  EXPECT_EQ(description(64 * kMiB).code, 0);
  const Outcome large = description(64 * kMiB + 1);
  EXPECT_EQ(large.code, 3);
  EXPECT_HAS(large.err, "larger than 64 MiB");
  const auto document = [&](size_t values) {
    std::string list = "0";
    for (size_t i = 1; i < values; ++i) list += ",0";
    std::string text = hd::description::patch_gltf(false, false);
    write("values.gltf", text.insert(text.find('{') + 1, R"("extras": [)" + list + "],"));
    return run({"check", "values.gltf"});
  };
  EXPECT_EQ(document(9'990'000).code, 0);
  const Outcome many = document(10'000'001);
  EXPECT_EQ(many.code, 3);
  EXPECT_HAS(many.err, "too many values");
}

// promise: pipeline.stats.scene
TEST_F(FaultsTest, NamesThatAreNotUtf8ReachTheStatistics) {
  std::filesystem::copy_file(folder_ / "lit.gltf", folder_ / "a\xff.gltf");
  const Outcome outcome = render("a\xff.gltf");
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_EQ(stats()["scene"], "a\xef\xbf\xbd.gltf");
}

// promise: security.no_codes
TEST_F(FaultsTest, NamesSendNoCodesToTerminals) {
  std::string text = hd::description::patch_gltf(true, true);
  text.replace(text.find(R"("name": "patch")"), 15,
               "\"name\": \"p\xc2\x9b"
               "31m\"");
  write("codes.gltf", text);
  const Outcome info = run({"info", "codes.gltf"}), wrong = run({"check", "lit.gltf", "\x1b[31m.gltf"});
  EXPECT_EQ(info.code, 0);
  EXPECT_HAS(info.out, "p\\x9b31m");
  EXPECT_EQ(info.out.find("\xc2\x9b"), std::string::npos);
  EXPECT_EQ(wrong.code, 2);
  EXPECT_EQ(wrong.err.find('\x1b'), std::string::npos) << wrong.err;
}

TEST_F(FaultsTest, EmptyArgumentsAreErrors) {
  const Outcome size = render("patch.gltf", {"--size", ""});
  EXPECT_EQ(size.code, 2);
  EXPECT_HAS(size.err, "the value of --size is empty");
  EXPECT_EQ(render("patch.gltf", {"--camera="}).code, 2);
  EXPECT_EQ(run({"info", ""}).code, 2);
}

// promise: security.nesting
TEST_F(FaultsTest, DeepValuesAreRefused) {
  const Outcome deep = render("patch.gltf", {"--set", "samples=" + std::string(60000, '[')});
  EXPECT_EQ(deep.code, 2);
  EXPECT_LT(deep.err.size(), 8000u) << "nobody reads 60000 brackets";
  EXPECT_EQ(run({"tradeoff", "patch.gltf", "--only", std::string(50000, '(')}).code, 2);
}

// promise: pipeline.output.input, security.outputs
TEST_F(FaultsTest, AnInputIsNeverOverwritten) {
  const std::string before = read("patch.gltf");
  EXPECT_EQ(run({"render", "patch.gltf", "--size", "16x12", "--spp", "1", "-o", "a.exr", "--stats", "patch.gltf"}).code,
            2);
  EXPECT_EQ(read("patch.gltf"), before);
  std::filesystem::create_symlink("patch.bin", folder_ / "b.exr");
  EXPECT_EQ(render("patch.gltf", {"-o", "b.exr"}).code, 2);
  EXPECT_EQ(read("patch.bin").size(), 60u);
  write_image("sky.png");
  EXPECT_EQ(render("patch.gltf", {"-o", "sky.png", "--dome", "sky.png"}).code, 2);
  write("self.json", R"({"gltf": [{"file": "patch.gltf"}], "products": [{"file": "sky.png"}],
                         "lights": [{"name": "d", "type": "domeLight", "texture:file": "sky.png"}]})");
  EXPECT_EQ(run({"render", "self.json", "--size", "16x12", "--spp", "1"}).code, 3);
  EXPECT_HAS(read("sky.png"), "RADIANCE");
  write_image("skin.1001.png");
  write("set.json", R"({"gltf": [{"file": "patch.gltf"}], "materials": [{"match": "skin",
                        "set": {"baseColor": {"file": "skin.<UDIM>.png"}}}]})");
  EXPECT_EQ(render("set.json", {"-o", "skin.1001.png"}).code, 2) << "one of a set";
  EXPECT_HAS(read("skin.1001.png"), "RADIANCE");
}

// promise: pipeline.warnings
TEST_F(FaultsTest, UnsupportedFeaturesAreWarningsThatQuietKeeps) {
  std::string text = hd::description::patch_gltf(false, false);
  const std::string plain = R"({"name": "skin"})";
  text.replace(text.find(plain), plain.size(), R"({"name": "skin", "extensions": {"EXT_ours": {}}})");
  text.replace(text.find('{'), 1, R"({"extensionsUsed": ["EXT_ours"], )");
  write("ours.gltf", text);
  const Outcome quiet = render("ours.gltf", {"--quiet"});
  EXPECT_EQ(quiet.code, 0);
  EXPECT_HAS(quiet.err, "warning: ours.gltf: extensionsUsed: EXT_ours is not supported");
}

// promise: pipeline.warnings, security.no_codes
TEST_F(FaultsTest, FloodsOfMessagesEndInACountAndControlCharactersAreShown) {
  std::string many = R"({"materials": [)";
  for (int i = 0; i < 5000; ++i) many += R"({"match": 1},)";
  many.back() = ']';
  write("flood.json", many + "}");
  const Outcome flood = render("flood.json");
  EXPECT_EQ(flood.code, 3);
  EXPECT_LT(std::count(flood.err.begin(), flood.err.end(), '\n'), 110);
  EXPECT_HAS(flood.err, " more ");
  std::string domes = R"({"gltf": [{"file": "patch.gltf"}], "lights": [)";
  for (int i = 0; i < 120; ++i)
    domes += R"({"type": "domeLight", "name": "d)" + std::to_string(i) + R"(", "texture:file": "absent.png"},)";
  domes.back() = ']';
  write("domes.json", domes + "}");
  const Outcome unwritten = run(
      {"render", "domes.json", "--size", "16x12", "--spp", "1", "-o", "a.exr", "--keep-going", "--stats", "/dev/full"});
  EXPECT_EQ(unwritten.code, 5);
  EXPECT_HAS(unwritten.err, "The statistics could not be written");
  write("escape.json", "{\"\\u001b[31mred\\u0007\\u009b1m\\nerror: forged\": 1}");
  const Outcome escape = render("escape.json");
  EXPECT_EQ(escape.code, 3);
  EXPECT_EQ(escape.err.find('\x1b'), std::string::npos) << escape.err;
  EXPECT_EQ(escape.err.find("\nerror: forged"), std::string::npos) << escape.err;
  EXPECT_HAS(escape.err, "\\x1b[31mred\\x07\\x9b1m");
}

TEST_F(FaultsTest, StandardOutputIsChecked) {
  const auto closed = [] { close(STDOUT_FILENO); };
  for (const char* command : {"schema", "ocio"}) {
    std::vector<std::string> words{command};
    if (words[0] == "schema") words.emplace_back("lights");
    const Outcome outcome = run(words, closed);
    EXPECT_EQ(outcome.code, 5) << command << outcome.err;
  }
}

TEST_F(FaultsTest, AFullStandardOutputIsAFailure) {
  if (mknod((folder_ / "full").c_str(), S_IFCHR | 0600, makedev(1, 7)) != 0)
    GTEST_SKIP() << "only the superuser makes device nodes";
  const std::string full = folder_ / "full";
  EXPECT_EQ(run({"schema", "lights"}, [&] { dup2(open(full.c_str(), O_WRONLY), STDOUT_FILENO); }).code, 5);
}

// Else an output file could get the number of standard error, and the messages.
TEST_F(FaultsTest, ClosedDescriptorsAreTakenBeforeAnyFileIs) {
  Program program(folder_, {"render", "patch.gltf", "--size", "64x48", "--time-limit", "60", "-o", "a.exr"}, [] {
    close(STDIN_FILENO);
    close(STDERR_FILENO);
  });
  const auto place_of = [&](int descriptor) {
    std::error_code none;
    return std::filesystem::read_symlink("/proc/" + std::to_string(program.pid()) + "/fd/" + std::to_string(descriptor),
                                         none);
  };
  bool taken = false;
  for (int i = 0; i < 500 && !taken; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
    taken = place_of(STDERR_FILENO) == "/dev/null" && place_of(STDIN_FILENO) == "/dev/null";
  }
  EXPECT_TRUE(taken) << place_of(STDERR_FILENO);
  program.send(SIGKILL);
}

// promise: pipeline.signals
TEST_F(FaultsTest, EverySignalThatEndsTheProgramKeepsThePicture) {
  for (const int number : {SIGHUP, SIGTERM, SIGPIPE, SIGXCPU, SIGXFSZ}) {
    std::filesystem::remove(folder_ / "a.exr");
    Program program(folder_, {"render", "patch.gltf", "--size", "64x48", "--spp", "1000000", "-o", "a.exr"},
                    [=] { ::signal(number, SIG_DFL); });
    ASSERT_TRUE(program.wait_for("samples", 30)) << program.err();
    std::this_thread::sleep_for(std::chrono::milliseconds(200));
    program.send(number);
    EXPECT_EQ(program.wait(), 130) << number << program.err();
    const auto exr = OIIO::ImageInput::open(folder_ / "a.exr");
    ASSERT_TRUE(exr) << number << OIIO::geterror();
    EXPECT_EQ(exr->spec().get_int_attribute("alabaster/incomplete", 0), 1);
  }
}

// promise: pipeline.signals.ignored
TEST_F(FaultsTest, ASignalThatTheParentIgnoresStaysIgnored) {
  constexpr int kNumbers[] = {SIGHUP, SIGINT, SIGTERM, SIGPIPE, SIGXCPU, SIGXFSZ};
  Program program(folder_, {"render", "patch.gltf", "--size", "64x48", "--time-limit", "3", "-o", "a.exr"}, [&] {
    for (const int number : kNumbers) ::signal(number, SIG_IGN);
  });
  ASSERT_TRUE(program.wait_for("rendering", 30)) << program.err();
  for (const int number : kNumbers) program.send(number);
  EXPECT_EQ(program.wait(), 0) << program.err();
  const auto exr = OIIO::ImageInput::open(folder_ / "a.exr");
  ASSERT_TRUE(exr) << OIIO::geterror();
  EXPECT_EQ(exr->spec().get_int_attribute("alabaster/incomplete", 0), 0);
}

// A background job of a script: SIGINT is ignored, and the engine's SIGTERM is not.
// promise: pipeline.signals.ignored
TEST_F(FaultsTest, ABackgroundJobEndsBySigtermAndNotByCtrlC) {
  Program program(folder_, {"render", "patch.gltf", "--size", "64x48", "--spp", "1000000", "-o", "a.exr"}, [] {
    ::signal(SIGINT, SIG_IGN);
    ::signal(SIGTERM, SIG_DFL);
  });
  ASSERT_TRUE(program.wait_for("samples", 30)) << program.err();
  program.interrupt();
  std::this_thread::sleep_for(std::chrono::milliseconds(500));
  int status = 0;
  EXPECT_EQ(waitpid(program.pid(), &status, WNOHANG), 0) << program.err();
  program.send(SIGTERM);
  EXPECT_EQ(program.wait(), 130) << program.err();
  EXPECT_TRUE(exists("a.exr"));
}

// promise: pipeline.signals.ignored
TEST_F(FaultsTest, AnIgnoredSigpipeIsAnErrorOfWriting) {
  ASSERT_EQ(mkfifo((folder_ / "fifo.exr").c_str(), 0600), 0);
  const int reader = open((folder_ / "fifo.exr").c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC);
  ASSERT_GT(fcntl(reader, F_SETPIPE_SZ, 4096), 0);
  std::thread leaves([&] {
    pollfd first{reader, POLLIN, 0};
    poll(&first, 1, 30000);  // until the program writes more than a pipe holds
    close(reader);
  });
  const Outcome outcome = run({"render", "patch.gltf", "--size", "256x256", "--spp", "1", "-o", "fifo.exr"}, [] {
    ::signal(SIGPIPE, SIG_IGN);
    ::setenv("TMPDIR", ".", 1);
  });
  leaves.join();
  EXPECT_EQ(outcome.code, 5) << outcome.err;
  EXPECT_HAS(outcome.err, "Broken pipe");
}

TEST_F(FaultsTest, ClosedStandardErrorKeepsThePicture) {
  int ends[2] = {-1, -1};
  ASSERT_EQ(pipe2(ends, O_CLOEXEC), 0);
  Program program(folder_, {"render", "patch.gltf", "--size", "64x48", "--spp", "3000", "-o", "a.exr"}, [&] {
    ::signal(SIGPIPE, SIG_DFL);
    dup2(ends[1], STDERR_FILENO);
  });
  close(ends[1]);
  char byte = 0;
  std::string seen;
  while (seen.find("samples") == std::string::npos && ::read(ends[0], &byte, 1) == 1) seen += byte;
  close(ends[0]);
  EXPECT_EQ(program.wait(), 130) << "ended by SIGPIPE as by Ctrl-C";
  EXPECT_TRUE(exists("a.exr"));
}

// promise: pipeline.exit.output, pipeline.output.new
TEST_F(FaultsTest, ALimitOnFileSizeLeavesNothingHalfWritten) {
  const Outcome outcome = run({"render", "patch.gltf", "--size", "256x256", "--spp", "1", "-o", "a.exr"}, [] {
    const rlimit limit{8192, 8192};
    setrlimit(RLIMIT_FSIZE, &limit);
  });
  EXPECT_EQ(outcome.code, 5) << outcome.err;
  EXPECT_FALSE(exists("a.exr"));
  for (const auto& entry : std::filesystem::directory_iterator(folder_))
    EXPECT_NE(entry.path().extension(), ".tmp") << entry.path();
}

}  // namespace
}  // namespace alabaster::cli
