// Small documents of our own, compared with the text of their scenes (testenv/unit/delegate/gltf/translations). After
// an intended change run with ALABASTER_UPDATE_EXPECTED=1 and read the difference.
#include <gtest/gtest.h>

#include <cmath>

#include "core/material/fresnel.h"
#include "delegate/description/render_description.h"
#include "testenv/support/build_paths.h"
#include "testenv/unit/delegate/gltf/gltf_builder.h"

namespace alabaster::hd::gltf::testing {
namespace {

const std::string kFolder = alabaster::testing::source_file("testenv/unit/delegate/gltf/translations/");

Loaded load_own(const std::string& topic, const GltfOptions& options = {}) {
  return load(kFolder + topic + ".gltf", options);
}

class GltfTranslation : public ::testing::TestWithParam<const char*> {};

TEST_P(GltfTranslation, MatchesTheExpectedText) {
  const Loaded loaded = load_own(GetParam());
  ASSERT_TRUE(loaded.summary.ok) << loaded.said();
  const std::string text = text_of(*loaded.scene), file = kFolder + GetParam() + ".expected.txt";
  if (std::getenv("ALABASTER_UPDATE_EXPECTED")) std::ofstream(file) << text;
  EXPECT_EQ(text, read_text(file));
}

INSTANTIATE_TEST_SUITE_P(Topics, GltfTranslation,
                         ::testing::Values("nodes", "modes", "ngons", "materials", "extensions", "lights_cameras",
                                           "image_light", "visibility", "texture"));

// promise: pipeline.name.prims
TEST(GltfTransforms, AModelsTransformComesLastAndACopyHasARoot) {
  const TemporaryFolder folder;
  std::filesystem::copy(std::filesystem::path(kFolder), folder.path(), std::filesystem::copy_options::recursive);
  host::RetainedSceneDelegate scene;
  const std::string file = folder.write("two.json", R"({"models": [{"file": "nodes.gltf"},
    {"file": "nodes.gltf", "transform": {"translate": [100, 0, 0]}}]})");
  ASSERT_TRUE(description::LoadScene(file, &scene, {}).ok);
  expect_near(transformed({0, 0, 0}, scene.GetMeshes().at("/copy2/gltf/nodes/nodes/1_child_with_slash/0").transform),
              {108, 21, 33});
  const Path instancer("/copy2/gltf/nodes/nodes/3_left/instancer");
  const auto* transforms =
      scene.GetInstancers().at(instancer).primvars.at("hydra:instanceTransforms").get<Array<Matrix4d>>();
  ASSERT_NE(transforms, nullptr);
  ASSERT_EQ(transforms->size(), 2u);
  const Matrix4d& placed = scene.GetInstancers().at(instancer).transform;
  expect_near(transformed(transformed({1, 0, 0}, (*transforms)[0]), placed), {100, 0, 0});
  expect_near(transformed(transformed({1, 0, 0}, (*transforms)[1]), placed), {99, 0, 0});
}

// A file may ask for more anisotropy than can be rendered. This is reported, and the nearest value used.
TEST(GltfMaterials, AnisotropyBeyondTheRangeIsTakenAtItsEnd) {
  Json document = Json::parse(read_text(kFolder + "materials.gltf"));
  for (const auto& [authored, taken] : {std::pair(0.9, 0.9f), {-0.95, -0.9f}, {1.0, 0.9f}}) {
    document["materials"][3]["extensions"]["KHR_materials_volume_scatter"]["scatterAnisotropy"] = authored;
    const TemporaryFolder folder;
    const Loaded loaded = load(folder.write("materials.gltf", document.dump()));
    ASSERT_TRUE(loaded.summary.ok) << loaded.said();
    EXPECT_EQ(loaded.says(Severity::warning, "scatterAnisotropy is outside"),
              authored != double(taken) && authored != 0.9);
    const MaterialNetwork& network = loaded.scene->GetMaterials().at("/gltf/materials/materials/3_draft");
    const MaterialNode& node = network.nodes.at(network.terminals.at("surface").upstreamNode);
    EXPECT_EQ(node.parameters.at("scatterAnisotropy"), Value(taken)) << authored;
  }
}

// Only geometry distinguishes a hexagon from two chained quads with the same first index.
TEST(GltfNgons, ChainedQuadsAreTwoPolygonsAndHexagonsOne) {
  Json document = Json::parse(read_text(kFolder + "ngons.gltf"));
  const auto load_fan = [&](const std::vector<Vec3f>& points) {
    std::string binary;
    for (const Vec3f& p : points) binary.append(reinterpret_cast<const char*>(&p), sizeof p);
    for (uint16_t i = 1; i + 1 < uint16_t(points.size()); ++i)
      for (const uint16_t index : {uint16_t(0), i, uint16_t(i + 1)})
        binary.append(reinterpret_cast<const char*>(&index), sizeof index);
    const size_t split = points.size() * sizeof(Vec3f);
    document["buffers"] = {{{"byteLength", binary.size()}}};
    document["bufferViews"] = {{{"buffer", 0}, {"byteLength", split}},
                               {{"buffer", 0}, {"byteOffset", split}, {"byteLength", binary.size() - split}}};
    document["accessors"] = {
        {{"bufferView", 0}, {"componentType", 5126}, {"type", "VEC3"}, {"count", points.size()}},
        {{"bufferView", 1}, {"componentType", 5123}, {"type", "SCALAR"}, {"count", (points.size() - 2) * 3}}};
    Json& primitive = document["meshes"][0]["primitives"][0];
    primitive["attributes"] = {{"POSITION", 0}};
    primitive["indices"] = 1;
    const TemporaryFolder folder;
    const Loaded loaded = load(folder.write("fan.glb", make_glb(document.dump(), binary)));
    EXPECT_TRUE(loaded.summary.ok) << loaded.said();
    return loaded.scene->GetMeshes().begin()->second.topology.faceVertexCounts;
  };
  std::vector<Vec3f> hexagon;
  for (int i = 0; i < 6; ++i)
    hexagon.emplace_back(float(std::cos(i * 1.0471975512)), float(std::sin(i * 1.0471975512)), 0.0f);
  EXPECT_EQ(load_fan(hexagon), (Array<int32_t>{6}));
  EXPECT_EQ(load_fan({{1, 0, 0}, {2, 0, 0}, {2, 1, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 0}}), (Array<int32_t>{4, 4}));
}

}  // namespace
}  // namespace alabaster::hd::gltf::testing
