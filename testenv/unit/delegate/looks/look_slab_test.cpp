// One medium by the surfaces of several standards, each read from an archive as it was authored.
#include <gtest/gtest.h>

#include "delegate/archive/archive.h"
#include "testenv/support/gltf_testing.h"
#include "testenv/support/stage.h"

namespace alabaster::hd::looks {
namespace {

constexpr int kSize = 16;

using Parameters = std::map<Token, Value>;

/// The mean colour of a body a hundred mean free paths thick below a white dome: its albedo.
Vec3f albedo_of(const char* type, const Parameters& parameters) {
  const gltf::testing::TemporaryFolder folder;
  const std::string file = folder.path() + "/look.alab";
  {
    host::RetainedSceneDelegate scene;
    host::CameraDescription camera;
    camera.transform[3][2] = 4;
    camera.parameters = {{"focalLength", 8.0f}, {"horizontalAperture", 1.0f}, {"verticalAperture", 1.0f}};
    scene.SetCamera("/camera", camera);
    scene.SetLight("/dome", {.type = "domeLight", .transform = {}, .parameters = {}});
    MaterialNetwork network;
    network.nodes["/look/surface"] = {type, parameters, {}};
    network.terminals["surface"] = {"/look/surface", "out"};
    scene.SetMaterial("/look", network);
    auto body = Stage::cube(0);
    body.topology.scheme = "none";  // flat faces
    body.material = "/look";
    scene.SetMesh("/body", body);
    EXPECT_EQ(archive::WriteArchive(file, scene.GetPrims()), "");
  }
  Stage stage({{"samples", int64_t(64)}, {"threads", 2}});
  EXPECT_TRUE(archive::ReadArchive(file, &stage.scene, {}).ok);
  RenderBuffer* const buffer = stage.add_buffer("/color", kSize, kSize, Format::float32vec4);
  stage.index->SyncAll();
  auto pass = stage.delegate->CreateRenderPass();
  EXPECT_TRUE(Stage::finish(*pass, Stage::state_for(kSize, kSize, "color", buffer)));
  pass.reset();
  EXPECT_TRUE(stage.take_diagnostics().empty());
  const std::vector<float> pixels = Stage::pixels<float>(buffer);
  Vec3f sum(0);
  for (size_t i = 0; i < pixels.size(); i += 4) sum += Vec3f(pixels[i], pixels[i + 1], pixels[i + 2]);
  return sum / float(kSize * kSize);
}

TEST(LookSlab, OneMediumHasOneAlbedoByAllStandards) {
  const Vec3f color(0.8f, 0.5f, 0.2f), radius(0.02f, 0.01f, 0.005f);
  const std::pair<const char*, Parameters> looks[] = {{"AlabasterDisney",
                                                       {{"baseColor", color},
                                                        {"meanFreePath", radius},
                                                        {"ior", 1.0f},
                                                        {"specular", 0.0f},
                                                        {"diffuseRoughness", 0.43f}}},
                                                      {"ND_open_pbr_surface_surfaceshader",
                                                       {{"subsurface_weight", 1.0f},
                                                        {"subsurface_color", color},
                                                        {"subsurface_radius", 0.02f},
                                                        {"subsurface_radius_scale", Vec3f(1, 0.5f, 0.25f)},
                                                        {"specular_ior", 1.0f},
                                                        {"specular_roughness", 0.3f},
                                                        {"specular_weight", 0.0f}}},
                                                      {"ND_standard_surface_surfaceshader",
                                                       {{"subsurface", 1.0f},
                                                        {"subsurface_color", color},
                                                        {"subsurface_radius", radius},
                                                        {"specular_IOR", 1.0f},
                                                        {"specular_roughness", 0.3f},
                                                        {"specular", 0.0f}}},
                                                      {"arnold:standard_surface",
                                                       {{"subsurface", 1.0f},
                                                        {"subsurface_color", color},
                                                        {"subsurface_radius", radius},
                                                        {"specular_IOR", 1.0f},
                                                        {"specular_roughness", 0.3f},
                                                        {"specular", 0.0f}}},
                                                      {"ND_disney_principled",
                                                       {{"subsurface", 1.0f},
                                                        {"baseColor", color},
                                                        {"subsurfaceDistance", radius},
                                                        {"specular", 0.0f},
                                                        {"roughness", 0.43f}}}};
  // Of a roughness at which Disney's retro-reflection makes Lambert's law of entry and exit.
  const Vec3f ours = albedo_of(looks[0].first, looks[0].second);
  for (const auto& [type, parameters] : looks) {
    const Vec3f found = albedo_of(type, parameters);
    for (int i = 0; i < 3; ++i) {
      EXPECT_NEAR(found[i], ours[i], 0.01f * ours[i]) << type;
      EXPECT_NEAR(found[i], color[i], 0.01f * color[i]) << type;
    }
  }
}

}  // namespace
}  // namespace alabaster::hd::looks
