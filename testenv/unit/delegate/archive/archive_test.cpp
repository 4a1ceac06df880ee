// Scene archives: nothing is lost, and hostile files are refused.
#include "delegate/archive/archive.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>

#include "delegate/description/render_description.h"
#include "delegate/host/scene_fields.h"
#include "delegate/support/lookup.h"
#include "testenv/support/build_paths.h"
#include "testenv/support/gltf_testing.h"

namespace alabaster::hd::archive {
namespace {

using ::alabaster::hd::gltf::testing::TemporaryFolder;
using host::RetainedSceneDelegate;

std::string bytes_of(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

/// Files by their real paths, images in memory by their bytes, and products by their names alone: these come to lie
/// beside the archive.
void normalize(std::map<Token, Value>* values) {
  for (auto& [name, value] : *values)
    if (const auto* asset = value.get<AssetPath>()) {
      AssetPath real = *asset;
      real.resolved = asset->bytes ? std::string(asset->bytes->begin(), asset->bytes->end())
                                   : std::filesystem::canonical(asset->resolved).string();
      real.bytes = nullptr;
      real.within.clear();
      value = real;
    }
}
host::Prims normalized(const RetainedSceneDelegate& scene) {
  host::Prims prims = scene.GetPrims();
  for (auto& [path, prim] : prims) {
    if (auto* light = std::get_if<host::LightDescription>(&prim)) normalize(&light->parameters);
    if (auto* network = std::get_if<MaterialNetwork>(&prim))
      for (auto& [node_path, node] : network->nodes) normalize(&node.parameters);
    if (auto* settings = std::get_if<RenderSettingsDescription>(&prim))
      for (RenderProduct& product : settings->products)
        product.file = std::filesystem::path(product.file).filename(), product.within.clear();
  }
  return prims;
}

// promise: pipeline.archive
TEST(Archive, BundledScenesComeBackWhole) {
  const TemporaryFolder folder;
  const std::filesystem::path scenes = testing::source_file("testenv/scenes");
  int count = 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(scenes)) {
    if (entry.path().extension() != ".json") continue;
    RetainedSceneDelegate scene, again;
    const description::SceneFile file = description::LoadScene(entry.path().string(), &scene, {});
    if (!file.ok) continue;  // another kind of JSON
    ++count;
    const std::string archive = (folder.path() + "/scene.alab");
    ASSERT_EQ(WriteArchive(archive, scene.GetPrims()), "") << entry.path();
    ASSERT_TRUE(ReadArchive(archive, &again, {}, {.allow_outside = true}).ok) << entry.path();
    EXPECT_TRUE(normalized(scene) == normalized(again)) << entry.path();
    const std::string first = bytes_of(archive);
    ASSERT_EQ(WriteArchive(archive, again.GetPrims()), "");
    EXPECT_TRUE(first == bytes_of(archive)) << entry.path() << ": written again, it has other bytes";
  }
  EXPECT_GT(count, 5);
}

/// A scene with a value of each form that archives have.
void fill(RetainedSceneDelegate* scene) {
  host::MeshDescription mesh;
  mesh.topology.faceVertexCounts = {4};
  mesh.topology.faceVertexIndices = {0, 1, 2, 3};
  const float nan = std::numeric_limits<float>::quiet_NaN();
  mesh.primvars["points"] = {
      Interpolation::vertex, "point", Array<Vec3f>{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, nan}}, {}};
  mesh.primvars["st"] = {Interpolation::faceVarying, {}, Array<Vec2f>{{0, 0}, {1, 0}}, {0, 1, 1, 0}};
  mesh.primvars["holdout"] = {Interpolation::constant, {}, true, {}};
  mesh.primvars["half"] = {Interpolation::constant, {}, Array<Half>{Half(0.5f)}, {}};
  mesh.primvarSamples["points"] = {{-0.5, 0.5}, {Array<Vec3f>{{0, 0, 0}}, Array<Vec3f>{{0, 0, 1}}}};
  mesh.transformSamples = {{0, 0.1}, {Matrix4d(), Matrix4d().setTranslation(Vec3d(1, 2, 3))}};
  mesh.categories = {"key", "rim"};
  mesh.doubleSided = false, mesh.cullStyle = CullStyle::frontUnlessDoubleSided;
  mesh.topology.geomSubsets = {{"/mesh/lid", "/wax", {0}}};
  mesh.instancer = "/many";
  scene->SetMesh("/mesh", mesh);
  host::InstancerDescription instancer;
  instancer.primvars["hydra:instanceTranslations"] = Array<Vec3f>{{0, 0, 0}, {1, 0, 0}};
  instancer.indices["/mesh"] = {1, 0};
  instancer.categories = {{"a"}, {"a", "b"}};
  scene->SetInstancer("/many", instancer);
  MaterialNetwork network;
  network.nodes["/wax/surface"] = {"AlabasterDisney", {{"roughness", 0.25f}}, {{"baseColor", {{"/wax/image", "rgb"}}}}};
  network.nodes["/wax/image"] = {"AlabasterTexture", {{"wrapS", Token("clamp")}}, {}};
  network.terminals["surface"] = {"/wax/surface", "out"};
  scene->SetMaterial("/wax", network);
  host::LightDescription light{.type = "sphereLight", .transform = {}, .parameters = {{"exposure", 0.1}}};
  light.parameters["lightLink"] = Token("key");
  scene->SetLight("/lamp", light);
  CameraDescription camera;
  camera.parameters["clipPlanes"] = Array<Vec4f>{{0, 0, 1, 0}};
  camera.parameters["clippingRange"] = Vec2f(0.1f, 100);
  scene->SetCamera("/camera", camera);
  RenderSettingsDescription settings;
  settings.width = 7, settings.crop = Rect2i{0, 1, 2, 3}, settings.windowPolicy = WindowPolicy::fit;
  settings.settings["samples"] = int64_t(12);
  RenderProduct product;
  product.file = "a.exr", product.denoise = false, product.vars = {{"z", "depth", "float"}, {"a", "color", "half"}};
  settings.products = {product};
  scene->SetRenderSettings("/render", settings);
}

std::string write(const TemporaryFolder& folder, const RetainedSceneDelegate& scene) {
  std::string file = (folder.path() + "/scene.alab");
  EXPECT_EQ(WriteArchive(file, scene.GetPrims()), "");
  return file;
}

// promise: pipeline.archive
TEST(Archive, EveryFormOfValueComesBack) {
  const TemporaryFolder folder;
  RetainedSceneDelegate scene, again;
  fill(&scene);
  const std::string file = write(folder, scene);
  std::string said;
  ASSERT_TRUE(ReadArchive(file, &again, [&](const Diagnostic& d) { said = d.text; }).ok) << said;
  const auto &before = scene.GetMeshes().at("/mesh"), &after = again.GetMeshes().at("/mesh");
  EXPECT_EQ(before.primvarSamples, after.primvarSamples);
  EXPECT_EQ(before.topology, after.topology);
  EXPECT_EQ(before.primvars.at("half"), after.primvars.at("half"));
  EXPECT_TRUE(std::isnan((*after.primvars.at("points").value.get<Array<Vec3f>>())[3].z));
  host::Prims given = normalized(scene), read = normalized(again);
  given.erase("/mesh"), read.erase("/mesh");  // a NaN differs from itself
  EXPECT_TRUE(given == read);
  const std::string first = bytes_of(file);
  write(folder, again);
  EXPECT_TRUE(first == bytes_of(file));
}

// promise: pipeline.archive.checks, pipeline.archive.versions
TEST(Archive, CutAndChangedFilesAreRefusedOrRead) {
  const TemporaryFolder folder;
  RetainedSceneDelegate scene;
  fill(&scene);
  const std::string file = write(folder, scene), whole = bytes_of(file);
  const auto reads = [&](const std::string& bytes) {
    std::ofstream(file, std::ios::binary) << bytes;
    RetainedSceneDelegate again;
    int errors = 0;
    const bool ok = ReadArchive(file, &again, [&](const Diagnostic& d) { errors += d.severity == Severity::error; }).ok;
    EXPECT_EQ(ok, errors == 0);
    return ok;
  };
  for (size_t length = 0; length < whole.size(); length += 1 + length / 64)
    EXPECT_FALSE(reads(whole.substr(0, length)));
  for (size_t at = 0; at < whole.size(); at += 3) {
    std::string changed = whole;
    changed[at] = char(changed[at] ^ 0x15);
    reads(changed);
  }
  std::string newer = whole;
  const size_t version = newer.find("\"version\":\"2\"");
  ASSERT_NE(version, std::string::npos);
  newer[version + 11] = '9';
  EXPECT_FALSE(reads(newer));
  EXPECT_TRUE(reads(whole));
}

// promise: pipeline.archive.images
TEST(Archive, ImagesAreNamedOrStored) {
  const TemporaryFolder folder;
  std::ofstream((folder.path() + "/image.png")) << "not really an image";
  RetainedSceneDelegate scene;
  fill(&scene);
  MaterialNetwork network = scene.GetMaterials().at("/wax");
  const std::string image = std::filesystem::canonical((folder.path() + "/image.png")).string();
  network.nodes["/wax/image"].parameters["file"] = AssetPath{"image.png", image, nullptr};
  scene.SetMaterial("/wax", network);
  const auto asset_after = [&](const WriteOptions& options, const DiagnosticSink& sink) {
    RetainedSceneDelegate again;
    const std::string file = (folder.path() + "/scene.alab");
    EXPECT_EQ(WriteArchive(file, scene.GetPrims(), {}, options), "");
    if (sink) std::ofstream((folder.path() + "/image.png")) << "another one";
    EXPECT_TRUE(ReadArchive(file, &again, sink).ok);
    return *again.GetMaterials().at("/wax").nodes.at("/wax/image").parameters.at("file").get<AssetPath>();
  };
  EXPECT_EQ(std::filesystem::canonical(asset_after({}, {}).resolved), image);
  const AssetPath stored = asset_after({.embed_images = true}, {});
  ASSERT_TRUE(stored.bytes);
  EXPECT_EQ(std::string(stored.bytes->begin(), stored.bytes->end()), "not really an image");
  std::string warned;
  asset_after({}, [&](const Diagnostic& d) { warned = d.code; });
  EXPECT_EQ(warned, "archive.image");
}

// promise: pipeline.archive.images
TEST(Archive, AChangedAddedOrRemovedTileIsReported) {
  const TemporaryFolder folder;
  const std::string root = std::filesystem::canonical(folder.path()).string(), file = root + "/scene.alab";
  const auto write = [&](int tile, const char* text) {
    std::ofstream(root + "/t." + std::to_string(tile) + ".png") << text;
  };
  write(1001, "one"), write(1002, "two");
  RetainedSceneDelegate scene;
  MaterialNetwork network;
  network.nodes["/wax/image"].nodeTypeId = "AlabasterTexture";
  network.nodes["/wax/image"].parameters["file"] = AssetPath{"t.<UDIM>.png", root + "/t.<UDIM>.png", nullptr};
  scene.SetMaterial("/wax", network);
  ASSERT_EQ(WriteArchive(file, scene.GetPrims()), "");
  const auto said = [&] {
    std::string codes;
    RetainedSceneDelegate again;
    EXPECT_TRUE(ReadArchive(file, &again, [&](const Diagnostic& d) { codes += d.code; }).ok);
    return codes;
  };
  EXPECT_EQ(said(), "");
  write(1002, "TWO");
  EXPECT_EQ(said(), "archive.image");
  write(1002, "two");
  EXPECT_EQ(said(), "");
  write(1011, "three");
  EXPECT_EQ(said(), "archive.image") << "added";
  std::filesystem::remove(root + "/t.1011.png"), std::filesystem::remove(root + "/t.1001.png");
  EXPECT_EQ(said(), "archive.image") << "removed";
}

// A hostile archive writes and reads nothing beyond its folder.
// promise: pipeline.archive.images
TEST(Archive, FilesOutsideAreRefused) {
  const TemporaryFolder folder;
  std::filesystem::create_directory(folder.path() + "/below");
  std::ofstream(folder.path() + "/secret.png") << "text";
  const std::string file = folder.path() + "/below/scene.alab";
  const auto fault_of = [&](const RetainedSceneDelegate& scene, bool allowed) {
    EXPECT_EQ(WriteArchive(file, scene.GetPrims()), "");
    std::string said;
    RetainedSceneDelegate again;
    ReadArchive(file, &again, [&](const Diagnostic& d) { said += d.text; }, {.allow_outside = allowed});
    return said;
  };
  RetainedSceneDelegate writes, reads;
  RenderSettingsDescription settings;
  settings.products.resize(1);
  settings.products[0].file = "../gone.exr";
  writes.SetRenderSettings("/render", settings);
  EXPECT_NE(fault_of(writes, false).find("outside"), std::string::npos);
  EXPECT_EQ(fault_of(writes, true), "");
  host::LightDescription dome{.type = "domeLight", .transform = {}, .parameters = {}};
  dome.parameters["texture:file"] = AssetPath{"secret.png", folder.path() + "/secret.png", nullptr};
  reads.SetLight("/dome", dome);
  EXPECT_NE(fault_of(reads, false).find("outside"), std::string::npos);
  EXPECT_EQ(fault_of(reads, true), "");
}

/// Loads a description that has a scene's archive twice: the second one lies below /copy.
void load_twice(const TemporaryFolder& folder, const RetainedSceneDelegate& scene, RetainedSceneDelegate* both) {
  write(folder, scene);
  const std::string file =
      folder.write("twice.json", R"({"models": [{"file": "scene.alab"}, {"file": "scene.alab"}]})");
  ASSERT_TRUE(description::LoadScene(file, both, {}).ok);
}

// Each would be lost by a reader that takes names for suffixes, completes networks or forgets what is empty.
TEST(Archive, UnusualNamesComeBack) {
  const TemporaryFolder folder;
  RetainedSceneDelegate scene, again;
  host::MeshDescription mesh;
  mesh.primvars["a"] = {Interpolation::constant, {}, 1.0f, {}};
  mesh.primvars["a:b"] = {Interpolation::uniform, {}, Array<float>{}, {}};
  mesh.primvars["indices"] = {Interpolation::constant, {}, Token("x"), {}};
  mesh.topology.geomSubsets = {{"/a:b/c", {}, {0, 1}}, {"/a", "/m", {}}};
  scene.SetMesh("/a b/\xc3\xa4.1", mesh);
  MaterialNetwork network;
  network.nodes["/m/node.001"] = {"AlabasterTexture", {{"wrapS", Token("clamp")}}, {}};
  network.nodes["/other/d"] = {"AlabasterDisplacement", {{"scale", 2.0f}}, {{"displacement", {{"/m/node.001", "r"}}}}};
  network.terminals["displacement"] = {"/other/d", "displacement"};
  scene.SetMaterial("/m", network);
  MaterialNetwork elsewhere;
  elsewhere.nodes["/n"] = {"AlabasterDisney", {}, {}};
  elsewhere.terminals["surface"] = {"/n", "out"};
  scene.SetMaterial("/elsewhere", elsewhere);
  scene.SetMaterial("/none", {});
  scene.SetCamera("/plain", {});
  scene.SetInstancer("/empty", {});
  EXPECT_TRUE(normalized(scene) == normalized((ReadArchive(write(folder, scene), &again, {}), again)));
  RetainedSceneDelegate copy;
  load_twice(folder, scene, &copy);
  EXPECT_EQ(copy.GetMaterials().at("/copy/elsewhere").terminals.at("surface").upstreamNode, Path("/copy/n"));
}

TEST(Archive, ASecondModelHasARoot) {
  const TemporaryFolder folder;
  RetainedSceneDelegate scene, again;
  fill(&scene);
  load_twice(folder, scene, &again);
  EXPECT_EQ(again.GetMeshes().at("/copy/mesh").instancer, Path("/copy/many"));
  EXPECT_EQ(again.GetMeshes().at("/copy/mesh").topology.geomSubsets[0].materialId, Path("/copy/wax"));
  EXPECT_TRUE(again.GetInstancers().at("/copy/many").indices.contains("/copy/mesh"));
  EXPECT_EQ(again.GetMaterials().at("/copy/wax").terminals.at("surface").upstreamNode, Path("/copy/wax/surface"));
}

/// An archive with a list of prims and one tensor of eight bytes, "t", of the type.
std::string made_archive(const TemporaryFolder& folder, const std::string& prims, const std::string& type = "U8",
                         const std::string& extra = "") {
  const size_t element = type == "U8" || type == "BOOL" ? 1 : 4;
  std::string header = R"({"__metadata__":{"format":"alabaster scene","version":"1")" + extra + R"(},"t":{"dtype":")" +
                       type + R"(","shape":[)" + std::to_string(8 / element) +
                       R"(],"data_offsets":[0,8]},"scene.json":{"dtype":"U8","shape":[)" +
                       std::to_string(prims.size()) + R"(],"data_offsets":[8,)" + std::to_string(8 + prims.size()) +
                       "]}}";
  header.resize((header.size() + 7) / 8 * 8, ' ');
  std::string file(8, '\0');
  for (size_t i = 0; i < 8; ++i) file[i] = char(header.size() >> (8 * i) & 255);
  return folder.write("made.alab", file + header + "12345678" + prims);
}

struct BadRow {
  const char *prims, *type, *says;
};
const BadRow kBadRows[] = {
    {R"({"prims":[)", "U8", "is not JSON"},
    {R"({"prims":3})", "U8", "no list of prims"},
    {R"({"prims":[{"path":"/a","kind":"camera","fields":[]},{"path":"/a","kind":"mesh","fields":[]}]})", "U8",
     "two prims"},
    {R"({"prims":[{"path":"/a\u0000","kind":"camera","fields":[]}]})", "U8", "zero character"},
    {R"({"prims":[{"path":"/a","kind":"camera","fields":[["fStop",{"float":1e300}]]}]})", "U8", "too large"},
    {R"({"prims":[{"path":"/a","kind":"renderSettings","fields":[["samples",{"int64":18446744073709551615}]]}]})", "U8",
     "not a whole number"},
    {R"({"prims":[{"path":"/a","kind":"mesh","fields":[["categories",{"token[]":"a"}]]}]})", "U8", "expected a list"},
    {R"({"prims":[{"path":"/a","kind":"mesh","fields":[["material",{"path":3}]]}]})", "U8", "expected a text"},
    {R"({"prims":[{"path":"/a","kind":"mesh","fields":[["primvars:x",{"bool[]":"t"}]]}]})", "BOOL", "neither 0 nor 1"},
    {R"({"prims":[{"path":"/a","kind":"domeLight","fields":[["texture:file",{"asset":{"authored":"a","bytes":"t"}}]]}]})",
     "F32", "not an array of bytes"},
};

// promise: pipeline.archive.checks
TEST(Archive, WrongPrimsAreRefusedWithTheCause) {
  const TemporaryFolder folder;
  for (const BadRow& row : kBadRows) {
    RetainedSceneDelegate scene;
    std::string said;
    EXPECT_FALSE(
        ReadArchive(made_archive(folder, row.prims, row.type), &scene, [&](const Diagnostic& d) { said = d.text; }).ok);
    EXPECT_NE(said.find(row.says), std::string::npos) << row.prims << ": " << said;
  }
  // Deep JSON, of the header and of the list.
  for (const size_t depth : {size_t(200), size_t(1000000)}) {
    RetainedSceneDelegate scene;
    const std::string deep = std::string(depth, '[') + std::string(depth, ']');
    EXPECT_FALSE(ReadArchive(made_archive(folder, R"({"prims":[]})", "U8", R"(,"a":)" + deep), &scene, {}).ok);
    EXPECT_FALSE(ReadArchive(made_archive(folder, R"({"prims":)" + deep + "}"), &scene, {}).ok);
  }
}

TEST(Archive, OneMemoryOfTwoTypesIsTwoTensors) {
  const TemporaryFolder folder;
  RetainedSceneDelegate scene, again;
  const auto held = std::make_shared<std::vector<int32_t>>(std::vector<int32_t>{0, 1, 2});
  host::MeshDescription mesh;
  mesh.topology.faceVertexIndices = Array<int32_t>(held, held->data(), 3);
  mesh.primvars["x"] = {Interpolation::vertex, {}, Value::array(ALABASTER_FLOAT, held, held->data(), 3), {}};
  scene.SetMesh("/a", mesh);
  ASSERT_TRUE(ReadArchive(write(folder, scene), &again, {}).ok);
  EXPECT_EQ(again.GetMeshes(), scene.GetMeshes());
}

// Images that many materials name are read and held once.
// promise: pipeline.archive.stored
TEST(Archive, StoredImagesAreShared) {
  const TemporaryFolder folder;
  const auto image = std::make_shared<const std::vector<uint8_t>>(1 << 20);
  RetainedSceneDelegate scene, again;
  for (int i = 0; i < 40; ++i) {
    const Path path("/m" + std::to_string(i));
    MaterialNetwork network;
    network.nodes[path.append("t")] = {"AlabasterTexture", {{"file", AssetPath{"a.png", "", image}}}, {}};
    scene.SetMaterial(path, network);
  }
  ASSERT_TRUE(ReadArchive(write(folder, scene), &again, {}, {.memory_limit = 4 << 20}).ok);
  const auto bytes = [&](const char* path) {
    return again.GetMaterials().at(path).nodes.at(Path(path).append("t")).parameters.at("file").get<AssetPath>()->bytes;
  };
  EXPECT_EQ(bytes("/m1"), bytes("/m39"));
}

TEST(Archive, ConfigsAreFilesOrNames) {
  const TemporaryFolder folder;
  RetainedSceneDelegate scene;
  const std::string file = folder.path() + "/scene.alab";
  ASSERT_EQ(WriteArchive(file, scene.GetPrims(), {{}, {"built-in", "built-in", nullptr}}), "");
  EXPECT_EQ(ReadArchive(file, &scene, {}).info.color_config.resolved, "built-in");
}

// Light links are of one scene: two archives of equal categories do not share them.
TEST(Archive, CategoriesOfASecondModelAreItsOwn) {
  const TemporaryFolder folder;
  RetainedSceneDelegate scene, again;
  fill(&scene);
  load_twice(folder, scene, &again);
  const std::string key = again.GetLights().at("/copy/lamp").parameters.at("lightLink").text_or("");
  EXPECT_NE(key, "key");
  EXPECT_EQ(again.GetMeshes().at("/copy/mesh").categories.at(0).str(), key);
  EXPECT_EQ(again.GetInstancers().at("/copy/many").categories.at(1).size(), 2u);
}

// promise: pipeline.archive.facts
TEST(Archive, FactsAndNamesComeBack) {
  const TemporaryFolder folder;
  RetainedSceneDelegate scene, again;
  fill(&scene);
  SceneInfo info;
  info.up = "Z", info.metersPerUnit = 0.01, info.timeCodesPerSecond = 24, info.range = {1, 48};
  info.names = {{"/mesh", "Head"}};
  const std::string file = folder.path() + "/scene.alab";
  ASSERT_EQ(WriteArchive(file, scene.GetPrims(), info), "");
  const ReadResult read = ReadArchive(file, &again, {});
  EXPECT_TRUE(read.ok && read.info == info);
  EXPECT_EQ(again.GetName("/mesh"), "Head");
  EXPECT_EQ(again.GetName("/lamp"), "lamp");
  // What no scene can have.
  const auto says = [&](const std::string& facts) {
    std::string said;
    RetainedSceneDelegate none;
    const std::string made = made_archive(folder, R"({"prims":[],)" + facts + "}");
    EXPECT_FALSE(ReadArchive(made, &none, [&](const Diagnostic& d) { said = d.text; }).ok) << facts;
    return said;
  };
  EXPECT_EQ(says(R"("upAxis":"X")"), "its up axis is neither Y nor Z: write one of these as upAxis");
  EXPECT_EQ(says(R"("upAxis":3)"), "its up axis is neither Y nor Z: write one of these as upAxis");
  EXPECT_EQ(says(R"("metersPerUnit":0)"), "its metersPerUnit is no number above 0: write one, or leave it out");
  EXPECT_EQ(says(R"("timeCodesPerSecond":"24")"),
            "its timeCodesPerSecond is no number above 0: write one, or leave it out");
  EXPECT_NE(says(R"("range":[2,1])").find("range"), std::string::npos);
}

// Those of version 1 have no names: a reader takes them from the paths that glTF's prims have.
// promise: pipeline.archive.versions
TEST(Archive, AnOlderOneHasTheNamesOfItsPaths) {
  const TemporaryFolder folder;
  RetainedSceneDelegate scene;
  const std::string file = made_archive(folder, R"({"prims":[
    {"path":"/gltf/bust/materials/2_skin","kind":"material","fields":[]},
    {"path":"/gltf/bust/nodes/3_head/0","kind":"mesh","fields":[]},{"path":"/body","kind":"camera","fields":[]}]})");
  ASSERT_TRUE(ReadArchive(file, &scene, {}).ok);
  EXPECT_EQ(scene.GetName("/gltf/bust/materials/2_skin"), "skin");
  EXPECT_EQ(scene.GetName("/gltf/bust/nodes/3_head/0"), "head");
  EXPECT_EQ(scene.GetName("/body"), "body");
}

constexpr const char* kAnswer = R"({"prims":[{"path":"/a","kind":"camera","fields":[["focalLength",{"float":2}]]},
  {"path":"/b","fields":[["focalLength",{"float":3}]]}],"removed":["/c"]})";

TEST(Archive, AnAnswerChangesAndRemovesPrims) {
  const TemporaryFolder folder;
  RetainedSceneDelegate scene;
  CameraDescription camera;
  camera.parameters["fStop"] = 8.0f;
  for (const char* path : {"/a", "/b", "/c", "/d"}) scene.SetCamera(path, camera);
  const std::string file = made_archive(folder, kAnswer);
  EXPECT_FALSE(ReadArchive(file, &scene, {}).ok);
  EXPECT_EQ(scene.GetCameras().size(), 4u) << "nothing is done by halves";
  ASSERT_TRUE(ReadArchive(file, &scene, {}, {.is_answer = true}).ok);
  const auto& all = scene.GetCameras();
  EXPECT_EQ(support::keys_of(all), (std::vector<Path>{"/a", "/b", "/d"}));
  EXPECT_FALSE(all.at("/a").parameters.contains("fStop")) << "it is set anew";
  EXPECT_EQ(all.at("/b").parameters.at("focalLength").number_or(0), 3);
  EXPECT_EQ(all.at("/b").parameters.at("fStop").number_or(0), 8) << "it is changed";
}

TEST(Archive, AnAnswerWithARefusedChangeDoesNothing) {
  const TemporaryFolder folder;
  for (const char* change : {R"(["transform",{"token":"long"}])", R"(["products:0:file",{"string":"/etc/a.exr"}])"}) {
    RetainedSceneDelegate scene;
    scene.SetCamera("/b", {});
    const std::string answer =
        std::string(R"({"prims":[{"path":"/a","kind":"camera","fields":[]},{"path":"/b","fields":[)") + change + "]}]}";
    std::string said;
    const DiagnosticSink sink = [&](const Diagnostic& d) { said = d.text; };
    EXPECT_FALSE(ReadArchive(made_archive(folder, answer), &scene, sink, {.is_answer = true}).ok) << change;
    EXPECT_TRUE(said.starts_with("/b: ")) << said;
    EXPECT_EQ(support::keys_of(scene.GetCameras()), std::vector<Path>{"/b"}) << change;
  }
}

/// A descriptor of memory that holds the bytes, with these seals.
class Memory {
 public:
  Memory(const std::string& bytes, int seals) : descriptor_(memfd_create("answer", MFD_CLOEXEC | MFD_ALLOW_SEALING)) {
    EXPECT_EQ(::write(descriptor_, bytes.data(), bytes.size()), ssize_t(bytes.size()));
    EXPECT_EQ(fcntl(descriptor_, F_ADD_SEALS, seals), 0);
  }
  ~Memory() { close(descriptor_); }
  Memory(const Memory&) = delete;
  Memory& operator=(const Memory&) = delete;
  int descriptor() const { return descriptor_; }

 private:
  int descriptor_;
};
constexpr int kAllSeals = F_SEAL_SHRINK | F_SEAL_GROW | F_SEAL_WRITE | F_SEAL_SEAL;

// promise: pipeline.archive.sealed
TEST(Archive, MemoryIsReadIfItIsSealed) {
  const TemporaryFolder folder;
  RetainedSceneDelegate scene;
  fill(&scene);
  const std::string whole = bytes_of(write(folder, scene));
  const auto read = [&](int descriptor, host::SceneEdits* edits) {
    std::string said;
    const bool ok = ReadSealedArchive(descriptor, "answer", edits, [&](const Diagnostic& d) { said = d.text; },
                                      {.folders = {"/nowhere"}})
                        .ok;
    EXPECT_EQ(ok, said.empty());
    return said;
  };
  const std::string refused =
      "the memory is not sealed against shrinking, growing, writing and further seals: add these (F_ADD_SEALS) "
      "to a memfd_create once it is written";
  for (const int missing : {F_SEAL_SHRINK, F_SEAL_GROW, F_SEAL_WRITE, F_SEAL_SEAL}) {
    host::SceneEdits edits;
    EXPECT_EQ(read(Memory(whole, kAllSeals & ~missing).descriptor(), &edits), refused);
  }
  host::SceneEdits none;
  const int file = open((folder.path() + "/scene.alab").c_str(), O_RDONLY | O_CLOEXEC);
  EXPECT_EQ(read(file, &none), refused) << "a file";
  close(file);
  EXPECT_NE(read(Memory(whole.substr(0, 100), kAllSeals).descriptor(), &none), "");
  EXPECT_NE(read(Memory("", kAllSeals).descriptor(), &none), "");
  // Files must lie in the folders that are allowed: the product "a.exr" of this scene does not.
  EXPECT_NE(read(Memory(whole, kAllSeals).descriptor(), &none).find("outside the folder"), std::string::npos);
  scene.Remove("/render");
  host::SceneEdits edits;
  {
    const Memory memory(bytes_of(write(folder, scene)), kAllSeals);
    ASSERT_EQ(read(memory.descriptor(), &edits), "");
  }
  // The arrays lie in the mapped memory, which stays when the descriptor is closed.
  EXPECT_EQ(edits.prims.size(), scene.GetPrims().size());
  RetainedSceneDelegate again;
  EXPECT_EQ(host::ApplyEdits(std::move(edits), &again), "");
  EXPECT_EQ(again.GetInstancers(), scene.GetInstancers());
  EXPECT_EQ(again.GetMeshes().at("/mesh").topology, scene.GetMeshes().at("/mesh").topology);
}

// promise: pipeline.archive.sealed
TEST(Archive, MemoryNamesNoFilesUnlessTheyAreAllowed) {
  const TemporaryFolder folder;
  RetainedSceneDelegate scene;
  fill(&scene);  // with a product, "a.exr"
  const Memory memory(bytes_of(write(folder, scene)), kAllSeals);
  host::SceneEdits none, edits;
  std::string said;
  const DiagnosticSink sink = [&](const Diagnostic& d) { said = d.text; };
  EXPECT_FALSE(ReadSealedArchive(memory.descriptor(), "answer", &none, sink).ok);
  EXPECT_NE(said.find("outside the folder"), std::string::npos) << said;
  const ReadOptions anywhere{.allow_outside = true, .folders = {"/nowhere"}};
  ASSERT_TRUE(ReadSealedArchive(memory.descriptor(), "answer", &edits, sink, anywhere).ok) << said;
  EXPECT_EQ(std::get<RenderSettingsDescription>(edits.prims.at("/render")).products.at(0).file, "/a.exr");
}

}  // namespace
}  // namespace alabaster::hd::archive
