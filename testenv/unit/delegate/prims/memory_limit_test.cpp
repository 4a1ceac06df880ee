// The memory limit inside a host: errors name who asks for more, and the delegate goes on.
#include <gtest/gtest.h>

#include <chrono>
#include <numeric>
#include <thread>

#include "testenv/support/drawing.h"
#include "testenv/support/failing_memory.h"
#include "testenv/support/stage.h"

namespace alabaster::hd {
namespace {

constexpr double kMiB = 1 << 20;

/// Drawn as a cage of one face: 2 * 4^level triangles.
host::MeshDescription refined_quad(int level) {
  host::MeshDescription mesh = Stage::quad();
  mesh.topology.scheme = "catmullClark";
  mesh.displayStyle.refineLevel = level;
  return mesh;
}

// promise: pipeline.memory.meshes, pipeline.memory.refusal
TEST(MemoryLimit, AMeshThatItDoesNotHoldIsNamedAndThePictureStays) {
  Drawing drawing(16);
  auto* const buffer = static_cast<RenderBuffer*>(drawing.stage.index->GetBprim("/color"));
  ASSERT_TRUE(drawing.draw()) << drawing.errors();
  const std::vector<float> picture = Stage::pixels<float>(buffer);
  const double before = drawing.stage.stat("memoryInUse");
  EXPECT_GT(before, 0);
  drawing.stage.scene.SetMesh("/fine", refined_quad(8));
  drawing.stage.scene.Remove("/quad");
  EXPECT_FALSE(drawing.draw()) << "not the rest of the scene either";
  EXPECT_EQ(drawing.pass->GetState(), PassState::failed);
  EXPECT_EQ(Stage::pixels<float>(buffer), picture);
  EXPECT_EQ(drawing.stage.count("scene.memory"), 1u);
  const std::string errors = drawing.errors();
  EXPECT_EQ(errors.find("/fine: a mesh of 131072 triangles needs "), 0u) << errors;
  EXPECT_NE(errors.find("the next commit builds it again"), std::string::npos) << errors;
  EXPECT_NE(errors.find("of the memory limit of 16 MiB"), std::string::npos) << errors;
  EXPECT_NE(errors.find("lower refineLevel"), std::string::npos) << errors;
  EXPECT_EQ(drawing.stage.stat("scene.faultCount"), 1);
  EXPECT_EQ(drawing.stage.stat("scene.outOfMemory"), 1);
  drawing.stage.scene.Remove("/fine");
  drawing.stage.scene.SetMesh("/quad", Stage::quad());
  EXPECT_TRUE(drawing.draw());
  EXPECT_EQ(drawing.errors(), "");
  EXPECT_EQ(drawing.stage.stat("scene.faultCount"), -1);
  EXPECT_EQ(Stage::pixels<float>(buffer), picture);
  EXPECT_LT(drawing.stage.stat("memoryInUse"), before + kMiB / 2) << "all of it was given back";
}

/// A settings prim with this limit, in MiB.
void set_limit(Stage& stage, const char* path, int mib) {
  RenderSettingsDescription settings;
  settings.settings["memoryLimit"] = mib;
  stage.scene.SetRenderSettings(path, settings);
}

TEST(MemoryLimit, HostsLimitOverridesThatOfTheSettingsPrim) {
  Stage stage;
  const auto limit = [&] { return stage.index->SyncAll(), stage.stat("memoryLimit") / kMiB; };
  const double otherwise = limit();
  set_limit(stage, "/b", 300);
  EXPECT_EQ(limit(), 300);
  set_limit(stage, "/a", 200);
  EXPECT_EQ(limit(), 200) << "the first by path";
  set_limit(stage, "/c", 400);
  EXPECT_EQ(limit(), 200) << "which an edit of another does not change";
  stage.delegate->SetRenderSetting("renderSettingsPrimPath", "/b");
  EXPECT_EQ(limit(), 300);
  stage.delegate->SetRenderSetting("memoryLimit", 500);
  EXPECT_EQ(limit(), 500);
  set_limit(stage, "/b", 301);
  EXPECT_EQ(limit(), 500);
  stage.delegate->SetRenderSetting("memoryLimit", Value());
  EXPECT_EQ(limit(), 301) << "the host has taken its limit back";
  set_limit(stage, "/b", 302);
  EXPECT_EQ(limit(), 302);
  stage.scene.SetRenderSettings("/b", {});
  EXPECT_EQ(limit(), otherwise) << "the prim names none any more";
  stage.delegate->SetRenderSetting("renderSettingsPrimPath", Value());
  EXPECT_EQ(limit(), 200);
  stage.scene.Remove("/a");
  EXPECT_EQ(limit(), otherwise) << "/b, which names none";
  stage.scene.Remove("/b");
  EXPECT_EQ(limit(), 400);
  stage.scene.Remove("/c");
  EXPECT_EQ(limit(), otherwise);
}

// Arrays of meshes are counted in their Sync.
TEST(MemoryLimit, LimitOfASettingsPrimAppliesToMeshesOfTheSameSync) {
  Stage stage;
  stage.add_basic_scene();
  set_limit(stage, "/settings", 16);
  host::MeshDescription mesh = Stage::quad();
  mesh.primvars["temperature"] = {
      Interpolation::constant, {}, Array<float>(std::vector<float>(size_t(8) << 20, 1)), {}};
  stage.scene.SetMesh("/quad_of_numbers", mesh);
  stage.index->SyncAll();
  EXPECT_LT(stage.stat("memoryInUse"), 16 * kMiB);
  EXPECT_EQ(stage.count("delegate.exception"), 1u);
  stage.scene.Remove("/settings");
  EXPECT_TRUE(stage.index->SyncAll());
  EXPECT_GT(stage.stat("memoryInUse"), 32 * kMiB);
  EXPECT_EQ(stage.count("delegate.exception"), 1u);
}

// A buffer counts once, however many meshes hold it.
TEST(MemoryLimit, ArraysThatMeshesShareCountOnce) {
  constexpr size_t kPoints = 100000, kMeshes = 16;
  constexpr double kBytes = kPoints * sizeof(Vec3f);
  const auto growth = [&](bool shares) {
    Stage stage;
    const auto make = [] { return Array<Vec3f>(std::vector<Vec3f>(kPoints, Vec3f(1, 2, 3))); };
    const Array<Vec3f> shared = make();
    host::MeshDescription mesh = Stage::quad();
    const auto in_use = [&] {
      stage.index->SyncAll();
      return stage.stat("memoryInUse");
    };
    const double before = in_use();
    const auto path = [](size_t i) { return Path("/m" + std::to_string(i)); };
    for (size_t i = 0; i < kMeshes; ++i) {
      mesh.primvars["points"].value = shares ? shared : make();
      stage.scene.SetMesh(path(i), mesh);
    }
    const double all = in_use() - before;
    for (size_t i = 1; i < kMeshes; ++i) stage.scene.Remove(path(i));
    EXPECT_GT(in_use() - before, 0.9 * kBytes) << "the last one still holds it";
    return all;
  };
  EXPECT_NEAR(growth(true), kBytes, kBytes / 10);
  EXPECT_NEAR(growth(false), kMeshes * kBytes, kMeshes * kBytes / 10);
}

// A deforming mesh takes memory for each pose of the shutter.
TEST(MemoryLimit, AMeshThatItDoesNotHoldInAllPosesIsNamed) {
  Drawing drawing(14);
  host::CameraDescription camera = drawing.stage.scene.GetCameras().at("/camera");
  camera.parameters["shutterClose"] = 1.0;
  drawing.stage.scene.SetCamera("/camera", camera);
  host::MeshDescription mesh = refined_quad(7);
  const Value points = mesh.primvars["points"].value;
  mesh.primvarSamples["points"] = {{0, 1.0 / 32, 1}, {points, points, Array<Vec3f>(std::vector<Vec3f>(4, Vec3f(2)))}};
  drawing.stage.scene.SetMesh("/waving", mesh);
  EXPECT_FALSE(drawing.draw());
  const std::string errors = drawing.errors();
  EXPECT_TRUE(errors.starts_with("/waving: a mesh in 33 poses needs ")) << errors;
  EXPECT_EQ(drawing.stage.stat("scene.faultCount"), 1);
  EXPECT_EQ(drawing.stage.stat("scene.outOfMemory"), 1);
  drawing.stage.delegate->SetRenderSetting("memoryLimit", 1024);
  EXPECT_TRUE(drawing.draw());
  EXPECT_EQ(drawing.errors(), "");
  EXPECT_EQ(drawing.stage.stat("scene.faultCount"), -1);
}

// promise: pipeline.memory.limit
TEST(MemoryLimit, DelegatesHaveOneEach) {
  Drawing small(16), large(1024);
  for (Drawing* drawing : {&small, &large}) {
    drawing->stage.scene.SetMesh("/fine", refined_quad(8));
    EXPECT_EQ(drawing->draw(), drawing == &large);
  }
  EXPECT_NE(small.errors(), "");
  EXPECT_EQ(large.errors(), "");
  EXPECT_LT(small.stage.stat("memoryInUse"), 16 * kMiB);
}

AssetPath image_file(const std::string& name, const std::string& bytes) {
  return {name, name, std::make_shared<const std::vector<uint8_t>>(bytes.begin(), bytes.end())};
}

/// An image in a material and a mesh for each of these wrap modes.
void add_images(Stage& stage, const AssetPath& file, const std::vector<const char*>& wraps,
                const char* input = "baseColor") {
  for (const char* wrap : wraps) {
    MaterialNetwork network;
    network.nodes["/m/surface"] = {"AlabasterDisney", {}, {{input, {{"/m/map", "rgb"}}}}};
    network.nodes["/m/map"] = {"AlabasterTexture", {{"file", file}, {"wrapS", std::string(wrap)}}, {}};
    network.terminals["surface"] = {"/m/surface", "surface"};
    const std::string name = wrap;
    stage.scene.SetMaterial("/" + name, network);
    host::MeshDescription mesh = Stage::quad();
    mesh.material = "/" + name;
    stage.scene.SetMesh("/mesh_" + name, mesh);
  }
}

/// A million grey texels, as halves.
AssetPath tall_image() {
  return image_file("tall.hdr",
                    "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 16384 +X 64\n" + std::string(4 << 20, '\x80'));
}

// promise: pipeline.memory.image_once
TEST(MemoryLimit, AnImageIsHeldOnceWhateverItsWrapModes) {
  Drawing one(256), three(256);
  add_images(one.stage, tall_image(), {"repeat"});
  add_images(three.stage, tall_image(), {"repeat", "clamp", "mirror"});
  ASSERT_TRUE(one.draw() && three.draw());
  EXPECT_GT(one.stage.stat("memoryInUse"), 2 * kMiB);
  EXPECT_LT(three.stage.stat("memoryInUse"), one.stage.stat("memoryInUse") + kMiB);
  EXPECT_LT(three.stage.stat("totalMemory"), one.stage.stat("totalMemory") + kMiB);
}

// promise: pipeline.memory.image_once
TEST(MemoryLimit, AnImageIsDecodedOnceAVisibleMeshHasItsMaterial) {
  Drawing drawing(256);
  add_images(drawing.stage, tall_image(), {"repeat"});
  host::MeshDescription mesh = drawing.stage.scene.GetMeshes().at("/mesh_repeat");
  mesh.visible = false;
  drawing.stage.scene.SetMesh("/mesh_repeat", mesh);
  ASSERT_TRUE(drawing.draw());
  const double before = drawing.stage.stat("memoryInUse");
  EXPECT_LT(before, kMiB);
  mesh.visible = true;
  drawing.stage.scene.SetMesh("/mesh_repeat", mesh);
  ASSERT_TRUE(drawing.draw());
  EXPECT_GT(drawing.stage.stat("memoryInUse"), before + 2 * kMiB);
}

// promise: pipeline.memory.images
TEST(MemoryLimit, AnImageThatItDoesNotHoldIsRefusedBeforeItIsDecoded) {
  Drawing drawing(2);
  add_images(drawing.stage, tall_image(), {"repeat"});
  drawing.stage.index->SyncAll();
  const std::string errors = drawing.errors();
  EXPECT_NE(errors.find("tall.hdr: an image of 64 x 16384 pixels needs 2 MiB more"), std::string::npos) << errors;
  EXPECT_EQ(drawing.stage.stat("scene.outOfMemory"), 1);
}

// A header is enough: rows of this length are not read.
// promise: pipeline.memory.images
TEST(MemoryLimit, AnImageOfLongRowsIsRefusedBeforeARowIsRead) {
  Drawing drawing(64);
  const AssetPath file = image_file("wide.hdr", "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 8388608\n");
  drawing.stage.scene.SetLight("/dome", {.type = "domeLight", .transform = {}, .parameters = {{"texture:file", file}}});
  drawing.stage.index->SyncAll();
  const std::string errors = drawing.errors();
  EXPECT_NE(errors.find("wide.hdr: decoding an image of 8388608 pixels a row needs "), std::string::npos) << errors;
  EXPECT_EQ(drawing.stage.stat("scene.outOfMemory"), 1);
}

/// A TIFF of bytes, which are grey: rows from the top, each of them in one value.
std::string grey_tiff(uint32_t width, const std::vector<uint8_t>& rows) {
  std::string file = "II*";
  file.push_back(0);
  const auto add = [&](auto... numbers) {
    (file.append(reinterpret_cast<const char*>(&numbers), sizeof numbers), ...);
  };
  const auto height = static_cast<uint32_t>(rows.size());
  constexpr uint16_t kLong = 4, kEntries = 9;
  constexpr uint32_t kDirectory = 8, kPixels = kDirectory + 2 + 12 * kEntries + 4;
  add(kDirectory, kEntries);
  const std::pair<uint16_t, uint32_t> entries[kEntries] = {{256, width}, {257, height}, {258, 8},
                                                           {259, 1},     {262, 1},      {273, kPixels},
                                                           {277, 1},     {278, height}, {279, width * height}};
  for (const auto& [tag, value] : entries) add(tag, kLong, uint32_t(1), value);
  add(uint32_t(0));
  for (const uint8_t value : rows) file.append(width, static_cast<char>(value));
  return file;
}

// The rows are converted by us: OpenImageIO would take memory for 256 of them.
TEST(MemoryLimit, AnImageOfLongRowsTakesMemoryForTheRowsThatItHas) {
  constexpr size_t kWidth = size_t(1) << 20, kRows = 2;
  Drawing drawing(256);
  add_images(drawing.stage, image_file("wide.tif", grey_tiff(kWidth, {0, 255})), {"clamp"});
  const testing::LargestAllocation largest;
  ASSERT_TRUE(drawing.draw());
  EXPECT_EQ(drawing.errors(), "");
  EXPECT_LE(largest.bytes(), kRows * kWidth * 4 * sizeof(float)) << "as floats with an alpha";
}

// A host may lend any number of primvars that nothing asks for.
// promise: pipeline.memory.arrays
TEST(MemoryLimit, PrimvarsThatNoMaterialReadsCount) {
  Drawing drawing(16);
  ASSERT_TRUE(drawing.draw());
  const double before = drawing.stage.stat("memoryInUse");
  const auto set_numbers = [&](size_t count) {
    host::MeshDescription mesh = Stage::quad();
    mesh.primvars["temperature"] = {Interpolation::constant, {}, Array<float>(std::vector<float>(count, 1)), {}};
    drawing.stage.scene.SetMesh("/quad_of_numbers", mesh);
    return drawing.draw();
  };
  ASSERT_TRUE(set_numbers(size_t(1) << 20));
  EXPECT_EQ(drawing.errors(), "");
  EXPECT_GE(drawing.stage.stat("memoryInUse"), before + 4 * kMiB);
  EXPECT_TRUE(set_numbers(size_t(8) << 20)) << "the mesh as it was";
  const std::string errors = drawing.errors();
  EXPECT_NE(errors.find("/quad_of_numbers needs 32 MiB more"), std::string::npos) << errors;
  ASSERT_TRUE(set_numbers(1));
  // The builder lets go of the scene before on its own thread.
  for (int i = 0; i < 500 && drawing.stage.stat("memoryInUse") >= before + kMiB; ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  EXPECT_LT(drawing.stage.stat("memoryInUse"), before + kMiB);
}

// promise: pipeline.memory.interiors
TEST(MemoryLimit, TangentsOfNormalMapsCount) {
  const auto in_use = [](bool mapped) {
    Drawing drawing(256);
    const AssetPath map =
        image_file("flat.hdr", "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 1\n" + std::string("\x80\x80\xff\x80"));
    add_images(drawing.stage, map, {"clamp"}, mapped ? "normal" : "baseColor");
    host::MeshDescription mesh = refined_quad(8);
    mesh.material = "/clamp";
    mesh.primvars["st"] = {
        Interpolation::vertex, "textureCoordinate", Array<Vec2f>{{0, 0}, {1, 0}, {1, 1}, {0, 1}}, {}};
    drawing.stage.scene.SetMesh("/mesh_clamp", mesh);
    EXPECT_TRUE(drawing.draw());
    EXPECT_EQ(drawing.errors(), "");
    return drawing.stage.stat("memoryInUse");
  };
  EXPECT_GE(in_use(true), in_use(false) + 131072.0 * 3 * sizeof(uint32_t));
}

/// Instancers in each other, each of which places the next one twice. Returns the name of the innermost.
std::string add_nested_instancers(Stage& stage, int depth) {
  std::string parent;
  for (int i = 0; i < depth; ++i) {
    const std::string name = "/instancer" + std::to_string(i);
    host::InstancerDescription instancer;
    instancer.primvars = {{"hydra:instanceTranslations", Array<Vec3f>{{0, 0, 0}, {1, 0, 0}}}};
    const std::string inner = i + 1 < depth ? "/instancer" + std::to_string(i + 1) : "/many";
    instancer.indices[inner] = {0, 1};
    instancer.parent = parent;
    stage.scene.SetInstancer(name, instancer);
    parent = name;
  }
  return parent;
}

// A scene of a few hundred bytes has 2^24 instances, or any number.
// promise: pipeline.memory.instances
TEST(MemoryLimit, NestedInstancersThatItDoesNotHoldAreAFault) {
  for (const int depth : {24, 64, 20000}) {
    Drawing drawing(64);
    ASSERT_TRUE(drawing.draw());
    const double before = drawing.stage.stat("memoryInUse");
    host::MeshDescription mesh = Stage::quad();
    mesh.instancer = add_nested_instancers(drawing.stage, depth);
    MaterialNetwork glass;
    glass.nodes["/glass/surface"] = {"AlabasterDisney", {{"specTrans", 1.0f}}, {}};
    glass.terminals["surface"] = {"/glass/surface", "surface"};
    drawing.stage.scene.SetMaterial("/glass", glass);
    mesh.material = "/glass";
    drawing.stage.scene.SetMesh("/many", mesh);
    EXPECT_EQ(drawing.draw(), depth > 100);
    if (depth > 100) {
      EXPECT_EQ(drawing.stage.count("instancer.depth"), 1u);
    } else {
      EXPECT_EQ(drawing.stage.stat("scene.faultCount"), 1) << depth;
      EXPECT_EQ(drawing.stage.stat("scene.outOfMemory"), 1) << depth;
      EXPECT_EQ(drawing.stage.count("mesh.open"), 0u) << "a mesh that is not drawn";
      const std::string errors = drawing.errors();
      EXPECT_NE(errors.find("instances of /instancer"), std::string::npos) << errors;
    }
    drawing.stage.scene.Remove("/many");
    EXPECT_TRUE(drawing.draw());
    EXPECT_EQ(drawing.stage.stat("scene.faultCount"), -1);
    EXPECT_LT(drawing.stage.stat("memoryInUse"), before + kMiB);
  }
}

// Turning instances have up to 129 poses each.
// promise: pipeline.memory.instances
TEST(MemoryLimit, InstancesThatMoveCount) {
  const auto in_use = [](bool turning) {
    Drawing drawing(256);
    host::InstancerDescription instancer;
    std::vector<Vec3f> places(4096, Vec3f(0, 0, 0));
    instancer.primvars = {{"hydra:instanceTranslations", Array<Vec3f>(places)}};
    std::vector<int32_t> indices(places.size());
    std::iota(indices.begin(), indices.end(), 0);
    instancer.indices["/many"] = indices;
    host::MeshDescription mesh = Stage::quad();
    mesh.instancer = "/instancer";
    if (turning) {
      Matrix4d half;
      half.rotate(Vec3d(0, 0, 2));
      instancer.transformSamples = {{0, 1}, {Matrix4d(), half}};
      host::CameraDescription camera = drawing.stage.scene.GetCameras().at("/camera");
      camera.parameters["shutterClose"] = 1.0;
      drawing.stage.scene.SetCamera("/camera", camera);
    }
    drawing.stage.scene.SetInstancer("/instancer", instancer);
    drawing.stage.scene.SetMesh("/many", mesh);
    EXPECT_TRUE(drawing.draw());
    EXPECT_EQ(drawing.errors(), "");
    return drawing.stage.stat("memoryInUse");
  };
  EXPECT_GT(in_use(true), in_use(false) + 4096.0 * 39 * sizeof(Matrix4d)) << "two radians in steps of three degrees";
}

// Beside its AOVs a film keeps what a part needs for a merge, and the rays of an adaptive frame.
// promise: pipeline.memory.frames
TEST(MemoryLimit, FramesCountAllPlanesOfTheirFilms) {
  struct Frame {
    Dictionary settings;
    double bytes = 0, film = 0;
  };
  Frame even{{{"samples", 8}}}, part{{{"samples", 8}, {"firstSample", 1}}},
      adaptive{{{"samples", 32}, {"adaptive", true}}},
      decided{{{"samples", 32}, {"adaptive", true}, {"targetError", 0.5f}}};
  for (Frame* frame : {&even, &part, &adaptive, &decided}) {
    Drawing drawing(64);
    ASSERT_TRUE(drawing.draw());
    for (const auto& [name, value] : frame->settings) drawing.stage.delegate->SetRenderSetting(name, value);
    const double before = drawing.stage.stat("memoryInUse");
    RenderBuffer* const large = drawing.stage.add_buffer("/large", 128, 128, Format::float32vec4);
    drawing.state = Stage::state_for(128, 128, "color", large);
    ASSERT_TRUE(drawing.draw());
    frame->bytes = (drawing.stage.stat("memoryInUse") - before) / (128 * 128);
    frame->film = drawing.stage.stat("filmMemory") / (128 * 128);
  }
  EXPECT_EQ(part.film, even.film + 240) << "three sums of 80 bytes";
  EXPECT_EQ(adaptive.film, even.film + 4);
  EXPECT_NEAR(part.bytes, even.bytes + 240, 2);
  EXPECT_GT(adaptive.bytes, even.bytes + 8) << "rays and rates";
  EXPECT_NEAR(decided.bytes, adaptive.bytes + adaptive.film, 2) << "a second film";
  EXPECT_GT(even.bytes, even.film);
}

TEST(MemoryLimit, FramesCountForAsLongAsTheyAreDrawn) {
  Drawing drawing(64);
  ASSERT_TRUE(drawing.draw());
  const double before = drawing.stage.stat("memoryInUse");
  RenderBuffer* const large = drawing.stage.add_buffer("/large", 512, 512, Format::float32vec4);
  drawing.state = Stage::state_for(512, 512, "color", large);
  ASSERT_TRUE(drawing.draw());
  EXPECT_GT(drawing.stage.stat("memoryInUse"), before + 512 * 512 * 36);
  drawing.pass = nullptr;
  EXPECT_LE(drawing.stage.stat("memoryInUse"), before);
}

}  // namespace
}  // namespace alabaster::hd
