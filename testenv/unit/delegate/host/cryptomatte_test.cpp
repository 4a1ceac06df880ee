// Cryptomatte's layers in files, decoded as its specification 1.2.0 says.
#include <OpenImageIO/imageio.h>
#include <gtest/gtest.h>

#include <bit>
#include <nlohmann/json.hpp>

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
  void hold_out(const Path& mesh, bool held) {
    MeshDescription changed = stage.scene.GetMeshes().at(mesh);
    changed.primvars["holdout"] = {Interpolation::constant, {}, held, {}};
    stage.scene.SetMesh(mesh, changed);
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
