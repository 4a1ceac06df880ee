// Published models and our conversions of them, compared with counts on which other programs agree.
#include <gtest/gtest.h>

#include <cmath>

#include "testenv/support/gltf_testing.h"

namespace alabaster::hd::gltf::testing {
namespace {

// The number of triangles: a mesh of several nodes counts once, a polygon counts as its stored triangles.
size_t triangle_count(const host::RetainedSceneDelegate& scene) {
  size_t count = 0;
  for (const auto& [id, mesh] : scene.GetMeshes())
    for (const int32_t corners : mesh.topology.faceVertexCounts) count += size_t(corners - 2);
  return count;
}

size_t faces_with(const host::MeshDescription& mesh, int32_t corners) {
  size_t count = 0;
  for (const int32_t c : mesh.topology.faceVertexCounts) count += c == corners;
  return count;
}

TEST(GltfValidAssets, ModelsHaveTheTrianglesThatTheirCatalogueTells) {
  const std::string assets = assets_folder();
  if (assets.empty()) GTEST_SKIP() << kNoAssets;
  const std::pair<const char*, size_t> kModels[] = {{"valid/AnimatedMorphCube/Quantized/AnimatedMorphCube.gltf", 12},
                                                    {"valid/AttenuationTest/AttenuationTest.glb", 232},
                                                    {"valid/BoxInterleaved/BoxInterleaved.glb", 12},
                                                    {"valid/BoxMeshopt/BoxMeshopt.glb", 12},
                                                    {"valid/Cameras/Cameras.gltf", 2},
                                                    {"valid/ClearCoatTest/ClearCoatTest.glb", 37116},
                                                    {"valid/EmissiveStrengthTest/EmissiveStrengthTest.glb", 90},
                                                    {"valid/FlightHelmet/FlightHelmet.gltf", 94722},
                                                    {"valid/LightsPunctualLamp/LightsPunctualLamp.gltf", 6000},
                                                    {"valid/MeshPrimitiveModes/MeshPrimitiveModes.gltf", 16},
                                                    {"valid/MorphPrimitivesTest/Draco/MorphPrimitivesTest.gltf", 32},
                                                    {"valid/MultiUVTest/MultiUVTest.glb", 12},
                                                    {"valid/NegativeScaleTest/NegativeScaleTest.glb", 3884},
                                                    {"valid/RiggedSimple/RiggedSimple.glb", 188},
                                                    {"valid/SimpleSparseAccessor/SimpleSparseAccessor.gltf", 12},
                                                    {"valid/SpecularTest/SpecularTest.glb", 44828},
                                                    {"valid/TextureTransformTest/TextureTransformTest.gltf", 18},
                                                    {"valid/Unicode❤♻Test/Unicode❤♻Test.gltf", 2},
                                                    {"valid/WaterBottle/WaterBottle.gltf", 4510},
                                                    {"valid/edge/00_empty_scene.gltf", 0},
                                                    {"valid/edge/00_no_nodes.gltf", 0},
                                                    {"valid/edge/00_no_scene.gltf", 12},
                                                    {"sss/armadillo_jade.glb", 86482},
                                                    {"sss/bunny_marble.glb", 59664},
                                                    {"sss/dragon_wax.glb", 25308},
                                                    {"subdiv/spot_control_sss.glb", 372},
                                                    {"subdiv/spot_quads_textured.glb", 5856},
                                                    {"subdiv/suzanne_assimp.glb", 968},
                                                    {"subdiv/suzanne_quads.glb", 968}};
  for (const auto& [name, triangles] : kModels) {
    const Loaded loaded = load(assets + "/" + name);
    EXPECT_TRUE(loaded.summary.ok) << name << "\n" << loaded.said();
    EXPECT_EQ(triangle_count(*loaded.scene), triangles) << name;
  }
}

TEST(GltfValidAssets, CagesHaveTheirPolygonsAndAreWelded) {
  const std::string assets = assets_folder();
  if (assets.empty()) GTEST_SKIP() << kNoAssets;
  struct Expected {
    const char* name;
    size_t triangles, quads, pentagons;
  };
  for (const Expected& expected :
       {Expected{"spot_control_sss.glb", 4, 160, 16}, Expected{"spot_quads_textured.glb", 0, 2928, 0},
        Expected{"suzanne_assimp.glb", 32, 468, 0}, Expected{"suzanne_quads.glb", 32, 468, 0}}) {
    const Loaded loaded = load(assets + "/subdiv/" + expected.name);
    ASSERT_EQ(loaded.scene->GetMeshes().size(), 1u) << loaded.said();
    const host::MeshDescription& mesh = loaded.scene->GetMeshes().begin()->second;
    EXPECT_EQ(mesh.topology.scheme, Token("catmullClark"));
    EXPECT_EQ(faces_with(mesh, 3), expected.triangles) << expected.name;
    EXPECT_EQ(faces_with(mesh, 4), expected.quads) << expected.name;
    EXPECT_EQ(faces_with(mesh, 5), expected.pentagons) << expected.name;
    EXPECT_EQ(mesh.topology.faceVertexCounts.size(), expected.triangles + expected.quads + expected.pentagons);
    EXPECT_EQ(mesh.displayStyle.refineLevel, GltfOptions().refine_level);
    EXPECT_EQ(mesh.primvars.count("normals"), 0u);
  }
}

TEST(GltfValidAssets, ClosedCageHasEveryEdgeTwice) {
  const std::string assets = assets_folder();
  if (assets.empty()) GTEST_SKIP() << kNoAssets;
  const Loaded loaded = load(assets + "/subdiv/spot_quads_textured.glb");
  ASSERT_EQ(loaded.scene->GetMeshes().size(), 1u);
  const host::MeshDescription& mesh = loaded.scene->GetMeshes().begin()->second;
  std::map<std::pair<int32_t, int32_t>, int>
      edges;  // directed: in a closed, consistently wound mesh each occurs once in each direction
  size_t first = 0;
  for (const int32_t corners : mesh.topology.faceVertexCounts) {
    for (int32_t c = 0; c < corners; ++c)
      ++edges[{mesh.topology.faceVertexIndices[first + size_t(c)],
               mesh.topology.faceVertexIndices[first + size_t((c + 1) % corners)]}];
    first += size_t(corners);
  }
  for (const auto& [edge, count] : edges) {
    EXPECT_EQ(count, 1);
    EXPECT_EQ(edges.count({edge.second, edge.first}), 1u);
  }
  EXPECT_EQ(mesh.primvars.at("st").indices.size(), mesh.topology.faceVertexIndices.size());
}

// The draft's name and the later one mean the same; d = 1 / (sigma_t (1-g) s(A)).
TEST(GltfValidAssets, ScatteringVolumesBecomeSubsurface) {
  const std::string assets = assets_folder();
  if (assets.empty()) GTEST_SKIP() << kNoAssets;
  struct Expected {
    const char* name;
    double color[3], albedo[3], distance, g;
  };
  for (const Expected& expected :
       {Expected{"armadillo_jade.glb", {0.3, 0.75, 0.4}, {0.25, 0.6, 0.32}, 0.03023283709353788, 0.3},
        Expected{"bunny_marble.glb", {0.8, 0.75, 0.7}, {0.83, 0.79, 0.75}, 0.0249095681389662, 0},
        Expected{"dragon_wax.glb", {0.9, 0.6, 0.3}, {0.9, 0.5, 0.2}, 0.5494030380249023, 0}}) {
    const Loaded loaded = load(assets + "/sss/" + expected.name);
    ASSERT_EQ(loaded.scene->GetMaterials().size(), 1u) << loaded.said();
    const MaterialNetwork& network = loaded.scene->GetMaterials().begin()->second;
    const MaterialNode& node = network.nodes.at(network.terminals.at("surface").upstreamNode);
    const Vec3f d = node.parameters.at("scatterDistance").get_or(Vec3f(0));
    const Vec3f base = node.parameters.at("baseColor").get_or(Vec3f(0));
    const auto g = node.parameters.find("scatterAnisotropy");
    EXPECT_EQ(g == node.parameters.end() ? 0.0f : float(g->second.number_or(-9)), float(expected.g)) << expected.name;
    for (int c = 0; c < 3; ++c) {
      const double albedo = expected.albedo[c], sigma_t = -std::log(expected.color[c]) / expected.distance;
      const double s = 1.9 - albedo + 3.5 * (albedo - 0.8) * (albedo - 0.8);
      EXPECT_NEAR(double(base[c]), albedo, 1e-6);
      EXPECT_NEAR(double(d[c]) * sigma_t * (1 - expected.g) * s, 1, 1e-5) << expected.name;
    }
  }
}

}  // namespace
}  // namespace alabaster::hd::gltf::testing
