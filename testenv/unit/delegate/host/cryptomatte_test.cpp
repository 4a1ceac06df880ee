// Cryptomatte's layers in files, decoded as its specification 1.2.0 says.
#include <OpenImageIO/imageio.h>
#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numeric>

#include "core/digest/cryptomatte_hash.h"
#include "delegate/host/frame_recorder.h"
#include "testenv/support/stage.h"
#include "testenv/unit/delegate/host/product_fixture.h"

namespace alabaster::hd::host {
namespace {

constexpr int kSide = 24;

// The layers of one name in a file.
struct Mattes {
  std::vector<float> pixels;  // of all layers: key, coverage, key, coverage, ...
  size_t ranks = 0;
  std::map<std::string, std::string> attributes;  // of its own, by what stands after the last slash
  nlohmann::json manifest;

  std::vector<float> of(const std::string& name) const {
    const auto key =
        std::bit_cast<float>(static_cast<uint32_t>(std::stoul(manifest.value(name, std::string("0")), nullptr, 16)));
    std::vector<float> matte;
    for (size_t i = 0; i < pixels.size(); i += 2 * ranks) {
      float coverage = 0;
      for (size_t r = 0; r < ranks; ++r)
        if (pixels[i + 2 * r] == key) coverage += pixels[i + 2 * r + 1];
      matte.push_back(coverage);
    }
    return matte;
  }
};

Mattes read_mattes(const std::string& file, const std::string& name) {
  Mattes mattes;
  const auto input = OIIO::ImageInput::open(file);
  if (!input) return mattes;
  const OIIO::ImageSpec& spec = input->spec();
  std::string prefix;
  for (const auto& attribute : spec.extra_attribs)
    if (attribute.name().string().ends_with("/name") && attribute.get_string() == name)
      prefix = attribute.name().string().substr(0, attribute.name().size() - 4);
  for (const auto& attribute : spec.extra_attribs)
    if (const std::string key = attribute.name().string(); !prefix.empty() && key.starts_with(prefix))
      mattes.attributes[key.substr(prefix.size())] = attribute.get_string();
  mattes.manifest = nlohmann::json::parse(mattes.attributes["manifest"], nullptr, false);
  EXPECT_EQ(prefix.substr(0, 12), prefix.empty() ? "" : "cryptomatte/");

  std::vector<int> columns;
  for (int layer = 0; layer < 8; ++layer)
    for (const char* channel : {".R", ".G", ".B", ".A"}) {
      const int column = spec.channelindex(name + "0" + std::to_string(layer) + channel);
      if (column >= 0) columns.push_back(column);
    }
  mattes.ranks = columns.size() / 2;
  std::vector<float> all(size_t(spec.image_pixels()) * size_t(spec.nchannels));
  input->read_image(0, 0, 0, spec.nchannels, OIIO::TypeDesc::FLOAT, all.data());
  for (const int column : columns) EXPECT_EQ(spec.channelformat(column), OIIO::TypeDesc::FLOAT);
  for (size_t i = 0; i < all.size(); i += size_t(spec.nchannels))
    for (const int column : columns) mattes.pixels.push_back(all[i + size_t(column)]);
  return mattes;
}

std::vector<int32_t> read_ids(const std::string& file, const std::string& name) {
  const auto input = OIIO::ImageInput::open(file);
  if (!input) return {};
  const OIIO::ImageSpec& spec = input->spec();
  const auto channel = static_cast<size_t>(spec.channelindex(name)), channels = size_t(spec.nchannels);
  std::vector<uint32_t> all(size_t(spec.image_pixels()) * channels);
  input->read_image(0, 0, 0, spec.nchannels, OIIO::TypeDesc::UINT, all.data());
  std::vector<int32_t> ids;
  for (size_t i = channel; i < all.size(); i += channels) ids.push_back(static_cast<int32_t>(all[i]));
  return ids;
}

class Cryptomatte : public ProductFile {
 protected:
  Cryptomatte() {
    stage.add_basic_scene();
    CameraDescription camera = stage.scene.GetCameras().at("/camera");
    camera.parameters["fStop"] = 8.0f, camera.parameters["focusDistance"] = 5.0f;
    camera.parameters["shutterOpen"] = 0.0f, camera.parameters["shutterClose"] = 1.0f;
    stage.scene.SetCamera("/camera", camera);
    stage.set_surface("/veil", {{"opacity", 0.4f}});
    stage.set_surface("/glass", {{"specTrans", 1.0f}, {"roughness", 0.0f}});
    // A pane that moves and is partly clear, before a glass cube, before the quad.
    MeshDescription pane = Stage::quad();
    pane.material = "/veil";
    pane.transform = moved(-0.5, 0.3, 1.2);
    pane.transformSamples = {{0, 1}, {pane.transform, moved(0.4, 0.3, 1.2)}};
    stage.scene.SetMesh("/props/front/pane", pane);
    MeshDescription cube = Stage::cube(1);
    cube.material = "/glass";
    cube.transform = moved(0.6, -0.4, 0.8);
    stage.scene.SetMesh("/props/front/cube", cube);
    settings.camera = "/camera";
    settings.width = settings.height = kSide;
    settings.settings = {{"samples", 48}};
    settings.products.resize(1);
    settings.products[0].file = path("frame.exr");
  }
  static Matrix4d moved(double x, double y, double z) {
    Matrix4d m;
    m.setTranslation(Vec3d(x, y, z));
    return m;
  }
  RecordResult record(const std::vector<std::string>& aovs) {
    settings.products[0].vars.clear();
    for (const std::string& aov : aovs) settings.products[0].vars.push_back(UsualRenderVar(aov));
    stage.scene.SetRenderSettings("/settings", settings);
    RecordResult result = RecordFrame(stage.index.get(), &stage.scene, "/settings", {});
    EXPECT_EQ(result.status, RecordStatus::done) << result.text;
    return result;
  }
  void hold_out(const Path& mesh, bool held) { set_option(mesh, "holdout", held); }
  void set_option(const Path& mesh, const char* name, Value value) {
    MeshDescription changed = stage.scene.GetMeshes().at(mesh);
    changed.primvars[name] = {Interpolation::constant, {}, std::move(value), {}};
    stage.scene.SetMesh(mesh, changed);
  }
  // Small quads in focus about the large one, alone: three in a row, and two such rows.
  void add_chips() {
    for (const char* other : {"/props/front/pane", "/props/front/cube"}) stage.scene.Remove(other);
    MeshDescription chip = Stage::quad();
    chip.primvars["points"].value =
        Array<Vec3f>{{-0.4f, -0.4f, -1}, {0.4f, -0.4f, -1}, {0.4f, 0.4f, -1}, {-0.4f, 0.4f, -1}};
    chip.instancer = "/row";
    stage.scene.SetMesh("/chip", chip);
    stage.scene.SetName("/chip", "bead");
    InstancerDescription row, rows;
    row.primvars["hydra:instanceTranslations"] = Array<Vec3f>{{-1.2f, 0, 0}, {0, 0, 0}, {1.2f, 0, 0}};
    row.indices["/chip"] = {0, 1, 2};
    row.parent = "/rows";
    rows.primvars["hydra:instanceTranslations"] = Array<Vec3f>{{0, -1.7f, 0}, {0, 1.7f, 0}};
    rows.indices["/row"] = {0, 1};
    stage.scene.SetInstancer("/row", row);
    stage.scene.SetInstancer("/rows", rows);
  }
  std::vector<float> alpha() {
    record({"color"});
    const auto input = OIIO::ImageInput::open(path("frame.exr"));
    std::vector<float> rgba(kSide * kSide * 4), alpha;
    input->read_image(0, 0, 0, 4, OIIO::TypeDesc::FLOAT, rgba.data());
    for (size_t i = 3; i < rgba.size(); i += 4) alpha.push_back(rgba[i]);
    return alpha;
  }

  Stage stage;
  RenderSettingsDescription settings;
};

// The samples are the same, so the matte of an object is the alpha of a frame in which all others are holes: with
// motion blur, depth of field and opacity. Glass counts by its surface.
// promise: pipeline.cryptomatte.coverage
TEST_F(Cryptomatte, TheMatteOfAnObjectIsItsAlpha) {
  const std::vector<Path> meshes{"/quad", "/props/front/pane", "/props/front/cube"};
  settings.products[0].dataType = "float";
  record({"color", "cryptoObject"});
  const Mattes mattes = read_mattes(path("frame.exr"), "CryptoObject");
  ASSERT_EQ(mattes.pixels.size(), size_t(kSide) * kSide * 12);
  for (const Path& shown : meshes) {
    for (const Path& mesh : meshes) hold_out(mesh, mesh != shown);
    const std::vector<float> matte = mattes.of(shown.str()), expected = alpha();
    double sum = 0;
    for (size_t i = 0; i < matte.size(); ++i) {
      EXPECT_NEAR(matte[i], expected[i], 1e-6f) << shown.str() << " at " << i;
      sum += double(matte[i]);
    }
    EXPECT_GT(sum, 10) << shown.str();
  }

  // A hold-out has no matte.
  for (const Path& mesh : meshes) hold_out(mesh, mesh == meshes[1]);
  record({"cryptoObject"});
  const std::vector<float> none = read_mattes(path("frame.exr"), "CryptoObject").of(meshes[1].str());
  EXPECT_EQ(std::count(none.begin(), none.end(), 0.0f), kSide * kSide);
}

// A pixel of a frame 64 times as wide and as high has one ray through a point of its own, at a time and through a place
// of the lens of its own.
// promise: pipeline.cryptomatte.coverage
TEST_F(Cryptomatte, CoverageIsThatOfManyPointSamples) {
  constexpr int kWide = 12, kPoints = 64;
  settings.settings = {{"samples", kPoints * kPoints}, {"filter", "box"}, {"maxDepth", 1}};
  settings.width = settings.height = kWide;
  record({"cryptoObject"});
  const Mattes mattes = read_mattes(path("frame.exr"), "CryptoObject");
  settings.width = settings.height = kWide * kPoints;
  settings.settings["samples"] = 1;
  record({"primId"});
  const std::vector<int32_t> ids = read_ids(path("frame.exr"), "primId.X");
  ASSERT_EQ(ids.size(), size_t(kWide * kPoints) * kWide * kPoints);
  for (const char* mesh : {"/quad", "/props/front/pane", "/props/front/cube"}) {
    int32_t id = 0;
    while (id < 100 && stage.index->GetRprimPathFromPrimId(id) != Path(mesh)) ++id;
    std::vector<double> points(size_t(kWide) * kWide);
    for (size_t i = 0; i < ids.size(); ++i)
      if (ids[i] == id)
        points[i / (kWide * kPoints) / kPoints * kWide + i % (kWide * kPoints) / kPoints] += 1.0 / (kPoints * kPoints);
    const std::vector<float> matte = mattes.of(mesh);
    double largest = 0, sum = 0, covered = 0;
    for (size_t i = 0; i < matte.size(); ++i) {
      largest = std::max(largest, std::abs(double(matte[i]) - points[i]));
      sum += double(matte[i]) - points[i], covered += points[i];
    }
    RecordProperty("largest of " + std::string(mesh), std::to_string(largest));
    EXPECT_GT(covered, 5) << mesh;
    EXPECT_LT(largest, 0.05) << mesh << ": both have a deviation of 0.008 where half is covered";
    EXPECT_LT(std::abs(sum), 0.005 * covered) << mesh;
  }
}

// Instances are numbered as in AOV instanceId: of nested instancers the innermost counts fastest.
// promise: pipeline.cryptomatte.instances
TEST_F(Cryptomatte, InstancesHaveMattesWhereTheMeshAsks) {
  add_chips();
  settings.settings["filter"] = "box";
  record({"cryptoObject"});
  const std::vector<float> all = read_mattes(path("frame.exr"), "CryptoObject").of("bead");
  set_option("/chip", "cryptoInstances", true);
  record({"cryptoObject", "cryptoAsset", "primId", "instanceId"});
  const Mattes mattes = read_mattes(path("frame.exr"), "CryptoObject");
  const std::vector<int32_t> prims = read_ids(path("frame.exr"), "primId.X"),
                             instances = read_ids(path("frame.exr"), "instanceId.X");
  EXPECT_EQ(mattes.manifest.size(), 7u) << mattes.manifest.dump();
  EXPECT_FALSE(mattes.manifest.contains("bead"));
  std::vector<float> sum(all.size());
  for (int instance = 0; instance < 6; ++instance) {
    const std::vector<float> matte = mattes.of("bead." + std::to_string(instance));
    size_t whole = 0;
    for (size_t i = 0; i < matte.size(); ++i) {
      sum[i] += matte[i];
      if (matte[i] < 1) continue;
      ++whole;
      EXPECT_EQ(instances[i], instance) << i;
    }
    EXPECT_GT(whole, 0u) << instance;
  }
  for (size_t i = 0; i < all.size(); ++i) EXPECT_NEAR(sum[i], all[i], 1e-6f) << i;
  EXPECT_EQ(read_mattes(path("frame.exr"), "CryptoAsset").of("/chip"), all);

  // A million would make a manifest that compositors do not read.
  InstancerDescription rows = stage.scene.GetInstancers().at("/rows");
  std::vector<Vec3f> places;
  for (int i = 0; i < 40'000; ++i) places.emplace_back(0.0f, 100.0f * static_cast<float>(i), 0.0f);
  rows.primvars["hydra:instanceTranslations"] = Array<Vec3f>(places);
  std::vector<int32_t> indices(40'000);
  std::iota(indices.begin(), indices.end(), 0);
  rows.indices["/row"] = Array<int32_t>(indices);
  stage.scene.SetInstancer("/rows", rows);
  record({"cryptoObject"});
  const Mattes together = read_mattes(path("frame.exr"), "CryptoObject");
  EXPECT_EQ(together.manifest.size(), 2u);
  EXPECT_TRUE(together.manifest.contains("bead"));
  EXPECT_EQ(stage.count("mesh.cryptoInstances"), 1u);
}

// promise: pipeline.cryptomatte.own_names
TEST_F(Cryptomatte, MeshesMayNameTheirMattes) {
  record({"cryptoObject", "cryptoAsset"});
  const Mattes own = read_mattes(path("frame.exr"), "CryptoObject");
  const std::vector<float> quad = own.of("/quad"), pane = own.of("/props/front/pane"),
                           cube = own.of("/props/front/cube");
  for (const char* mesh : {"/props/front/pane", "/props/front/cube"})
    set_option(mesh, "cryptoObject", std::string("front"));
  set_option("/quad", "cryptoAsset", std::string("stage"));
  record({"cryptoObject", "cryptoAsset", "primId"});
  const std::vector<float> front = read_mattes(path("frame.exr"), "CryptoObject").of("front");
  for (size_t i = 0; i < front.size(); ++i) EXPECT_NEAR(front[i], pane[i] + cube[i], 1e-6f);
  EXPECT_EQ(read_mattes(path("frame.exr"), "CryptoAsset").of("stage"), quad);
  const auto input = OIIO::ImageInput::open(path("frame.exr"));
  const std::string names = input->spec().get_string_attribute("alabaster/names/primId");
  EXPECT_NE(names.find("/props/front/pane"), std::string::npos) << "ids keep the names of prims";
}

// promise: pipeline.aov.cryptomatte, pipeline.cryptomatte.coverage
TEST_F(Cryptomatte, MaterialsAndAssetsHaveMattes) {
  record({"cryptoObject", "cryptoMaterial", "cryptoAsset"});
  const Mattes objects = read_mattes(path("frame.exr"), "CryptoObject");
  const Mattes materials = read_mattes(path("frame.exr"), "CryptoMaterial");
  const Mattes assets = read_mattes(path("frame.exr"), "CryptoAsset");
  EXPECT_EQ(materials.of("/glass"), objects.of("/props/front/cube"));
  EXPECT_EQ(materials.of("default"), objects.of("/quad"));
  const std::vector<float> props = assets.of("/props/front"), pane = objects.of("/props/front/pane"),
                           cube = objects.of("/props/front/cube");
  for (size_t i = 0; i < props.size(); ++i) EXPECT_NEAR(props[i], pane[i] + cube[i], 1e-6f);
  EXPECT_EQ(assets.of("/quad"), objects.of("/quad"));
}

// promise: pipeline.cryptomatte.names, pipeline.cryptomatte.ranks, pipeline.ids.names
TEST_F(Cryptomatte, FilesHaveTheNames) {
  stage.scene.SetName("/quad", "floor");
  stage.scene.SetName("/props/front/pane", "twice");
  stage.scene.SetName("/props/front/cube", "twice");
  stage.scene.SetName("/glass", "clear glass");
  settings.settings["cryptoRanks"] = 3;
  const RecordResult result = record({"cryptoObject", "cryptoMaterial", "primId", "materialId"});
  const Mattes objects = read_mattes(path("frame.exr"), "CryptoObject");
  EXPECT_EQ(objects.ranks, 4u) << "three, in pairs";
  EXPECT_EQ(objects.attributes.at("hash"), "MurmurHash3_32");
  EXPECT_EQ(objects.attributes.at("conversion"), "uint32_to_float32");
  std::map<std::string, std::string> names;
  for (const auto& [name, hash] : objects.manifest.items()) names[name] = hash;
  char floor[9];
  std::snprintf(floor, sizeof floor, "%08x", cryptomatte_hash("floor"));
  EXPECT_EQ(names.size(), 3u);
  EXPECT_EQ(names["floor"], floor);
  EXPECT_TRUE(names.contains("/props/front/pane") && names.contains("/props/front/cube")) << "a name of two is none";
  EXPECT_TRUE(read_mattes(path("frame.exr"), "CryptoMaterial").manifest.contains("clear glass"));

  // The numbers of ids have names, in the file and in the statistics.
  const auto input = OIIO::ImageInput::open(path("frame.exr"));
  const auto prims = nlohmann::json::parse(input->spec().get_string_attribute("alabaster/names/primId"));
  const auto materials = nlohmann::json::parse(input->spec().get_string_attribute("alabaster/names/materialId"));
  EXPECT_EQ(materials, nlohmann::json({{"0", "clear glass"}, {"1", "/veil"}, {"2", "default"}}));
  const auto in_stats = result.stats.at("names").get_or(std::shared_ptr<const Dictionary>());
  ASSERT_TRUE(in_stats);
  for (const auto& [id, name] : prims.items()) {
    const Path path = stage.index->GetRprimPathFromPrimId(std::stoi(id));
    EXPECT_EQ(name.get<std::string>(), path == Path("/quad") ? "floor" : path.str());
    const auto of_prims = in_stats->at("primId").get_or(std::shared_ptr<const Dictionary>());
    EXPECT_EQ(of_prims->at(id).text_or(""), name.get<std::string>());
  }
  EXPECT_EQ(prims.size(), 3u);
  record({"color"});
  EXPECT_TRUE(read_mattes(path("frame.exr"), "CryptoObject").attributes["manifest"].empty());
}

// A buffer shows a pair of ranks by the number at the end of the AOV's name.
// promise: pipeline.cryptomatte.hosts
TEST_F(Cryptomatte, ABufferShowsAPairOfRanks) {
  record({"cryptoObject01"});
  const Mattes second = read_mattes(path("frame.exr"), "CryptoObject");
  EXPECT_EQ(second.ranks, 2u);
  record({"cryptoObject"});
  const Mattes all = read_mattes(path("frame.exr"), "CryptoObject");
  for (size_t i = 0; i < size_t(kSide) * kSide; ++i)
    for (size_t c = 0; c < 4; ++c) EXPECT_EQ(second.pixels[4 * i + c], all.pixels[12 * i + 4 + c]);
  EXPECT_EQ(stage.delegate->GetDefaultAovDescriptor("cryptoObject08").format, Format::invalid);
}

// The values of MurmurHash3_x86_32 with seed 0, and the specification's mended exponents.
TEST(CryptomatteHash, IsThatOfTheSpecification) {
  EXPECT_EQ(cryptomatte_hash("hello"), 0x248bfa47u);
  EXPECT_EQ(cryptomatte_hash("hello, world"), 0x149bbb7fu);
  EXPECT_EQ(cryptomatte_hash("The quick brown fox jumps over the lazy dog"), 0x2e4ff723u);
  EXPECT_EQ(cryptomatte_hash(""), 0x00800000u) << "0 would be a subnormal";
  for (int i = 0; i < 4000; ++i) {
    const uint32_t exponent = cryptomatte_hash(std::to_string(i)) >> 23 & 0xff;
    EXPECT_TRUE(exponent > 0 && exponent < 255) << i;
  }
}

}  // namespace
}  // namespace alabaster::hd::host
