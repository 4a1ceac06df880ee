// The light of a group is that of a scene with its lights alone, and all groups add up to the picture.
#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "testenv/support/scene_builder.h"
#include "testenv/support/z_test.h"

namespace alabaster {
namespace {

constexpr int kSide = 40, kBlock = 10, kBlocks = (kSide / kBlock) * (kSide / kBlock);

// By number: light without a group is 0.
const std::vector<std::string> kGroups{"bead", "key", "lamp", "rim"};
enum : uint32_t { kNone, kBead, kKey, kLamp, kRim };
constexpr uint32_t kAll = 31;

Matrix4d moved(double x, double y, double z) {
  return Matrix4d().setTranslation(Vec3d(x, y, z));
}

// Wax, glass and a jelly about an opaque bead and a light, on a floor, in the light of a dome that the camera sees, of
// a lamp of triangles, and of two more lights, one with shadow links and the other with multipliers for lobes. `lit`:
// bits of the groups that shine.
std::shared_ptr<const SceneSnapshot> scene(uint32_t lit) {
  testing::SceneBuilder b;
  DisneyParameters wax, glass, jelly, bead, lamp;
  wax.scatter_distance = {0.3f, 0.1f, 0.02f};
  wax.clearcoat = 1;
  glass.spec_trans = jelly.spec_trans = 1;
  jelly.scatter_distance = Rgb(0.5f);
  lamp.emission = lit >> kLamp & 1 ? Rgb(6, 4, 2) : Rgb(0.0f);
  const auto ball = [&](float radius) { return b.prototype(testing::sphere_mesh(radius, 16, true)); };
  b.add(b.prototype(testing::plane_mesh(6)), b.material({}));
  b.add(ball(0.5f), b.material(wax), moved(-0.7, 0.5, 0));
  b.add(ball(0.4f), b.material(glass), moved(0.2, 0.41, 0.6));
  b.add(ball(0.5f), b.material(jelly), moved(0.8, 0.51, -0.3));
  b.add(ball(0.1f), b.material(bead), moved(0.7, 0.5, -0.2));
  b.add(b.prototype(testing::sphere_mesh(0.15f, 8, false)), b.material(lamp), moved(-0.3, 0.16, 0.9));
  b.description.instances.back().light_group = kLamp;
  b.description.instances[1].category_set = 1;
  b.description.category_sets = {{}, {1}};
  b.description.light_groups = kGroups;
  const auto add = [&](LightParameters light, uint32_t group) {
    light.group = group;
    if (lit >> group & 1) b.add(light);
  };
  LightParameters within, key, rim;
  within.type = key.type = LightType::sphere;
  within.radius = 0.1f, within.intensity = 4, within.light_to_world = moved(0.95, 0.55, -0.3);
  key.radius = 0.4f, key.intensity = 20, key.light_to_world = moved(2, 3, 1);
  key.shadow_link = 1;
  rim.type = LightType::rect;
  rim.intensity = 5, rim.color = {0.4f, 0.6f, 1}, rim.light_to_world = moved(0, 1.5, 3);
  rim.diffuse = 0.5f, rim.specular = 2, rim.visible_to_camera = true;
  add(within, kBead);
  add(key, kKey);
  add(rim, kRim);
  add(testing::constant_dome(0.3f, true), kNone);
  return b.snapshot();
}

RenderRequest request_of(uint32_t lit, uint32_t seed) {
  RenderRequest request;
  request.scene = scene(lit);
  request.camera = testing::look_at({0, 1.2, 3.5}, {0, 0.45, 0}, 38);
  request.width = request.height = kSide;
  request.data_window = {0, 0, kSide, kSide};
  request.aovs = aov_bit(Aov::color) | aov_bit(Aov::light_group);
  request.light_groups = {"", "bead", "key", "lamp", "rim"};
  request.settings.samples = 16;
  request.settings.seed = seed;
  return request;
}

class LightGroups : public ::testing::TestWithParam<SubsurfaceMode> {};

// promise: pipeline.aov.light_group, pipeline.aov.light_group_sums
TEST_P(LightGroups, AddUpToTheColorOfEveryPixel) {
  for (const float exposure : {0.0f, 1.5f}) {
    RenderRequest request = request_of(kAll, 1);
    request.settings.subsurface = GetParam();
    request.camera.exposure = exposure;
    constexpr Aov kKinds[] = {Aov::direct_diffuse,      Aov::indirect_diffuse, Aov::direct_subsurface,
                              Aov::indirect_subsurface, Aov::direct_specular,  Aov::indirect_specular,
                              Aov::transmission,        Aov::emission};
    for (const Aov kind : kKinds) request.aovs |= aov_bit(kind);
    const auto film = testing::render(request);
    const std::vector<float> color = film->resolve_float(Aov::color);
    std::vector<std::vector<float>> groups;
    for (size_t g = 0; g < request.light_groups.size(); ++g) groups.push_back(film->resolve_light_group(g));
    for (size_t i = 0; i < groups[0].size(); ++i) {
      double sum = 0, size = 0;
      for (const auto& group : groups) sum += group[i], size += std::abs(group[i]);
      ASSERT_NEAR(sum, color[i / 3 * 4 + i % 3], 32 * 0x1p-24 * size) << i;
    }
    std::vector<double> kinds(groups[0].size()), sizes(kinds.size());
    for (const Aov kind : kKinds) {
      const std::vector<float> light = film->resolve_float(kind);
      for (size_t i = 0; i < light.size(); ++i) kinds[i] += double(light[i]), sizes[i] += std::abs(double(light[i]));
    }
    for (size_t i = 0; i < kinds.size(); ++i)
      ASSERT_NEAR(kinds[i], color[i / 3 * 4 + i % 3], 32 * 0x1p-24 * sizes[i]) << "kinds at " << i;
    request.light_groups.clear();
    request.aovs &= ~aov_bit(Aov::light_group);
    EXPECT_EQ(testing::render(request)->resolve_float(Aov::color), color) << "groups change no sample";
    request.aovs = aov_bit(Aov::color);
    const std::vector<float> plain = testing::render(request)->resolve_float(Aov::color);
    for (size_t i = 0; i < color.size(); ++i)
      ASSERT_NEAR(plain[i], color[i], 32 * 0x1p-24 * color[i]) << "the rounding of layers at " << i;
  }
}

// Sums of blocks of pixels, over many seeds.
TEST_P(LightGroups, AreTheLightOfTheirLightsAlone) {
  using Means = std::vector<testing::RunningStatistics>;  // by block and channel
  const auto add = [](const std::vector<float>& pixels, size_t stride, Means* means) {
    std::vector<double> sums(means->size());
    for (size_t y = 0; y < kSide; ++y)
      for (size_t x = 0; x < kSide; ++x)
        for (size_t c = 0; c < 3; ++c)
          sums[(y / kBlock * (kSide / kBlock) + x / kBlock) * 3 + c] += double(pixels[(y * kSide + x) * stride + c]);
    for (size_t i = 0; i < sums.size(); ++i) (*means)[i].add(sums[i]);
  };
  const uint32_t seeds = testing::run_samples(12u);
  std::vector<Means> of_groups(5, Means(kBlocks * 3)), alone = of_groups;
  for (uint32_t seed = 0; seed < seeds; ++seed) {
    RenderRequest request = request_of(kAll, testing::run_seed(1000 + seed));
    request.settings.subsurface = GetParam();
    const auto film = testing::render(request);
    for (uint32_t g = 0; g < 5; ++g) {
      add(film->resolve_light_group(g), 3, &of_groups[g]);
      RenderRequest own = request_of(1u << g, testing::run_seed(2000 + 10 * seed + g));
      own.settings.subsurface = GetParam();
      add(testing::render(own)->resolve_float(Aov::color), 4, &alone[g]);
    }
  }
  for (size_t g = 0; g < 5; ++g)
    for (size_t i = 0; i < of_groups[g].size(); ++i) {
      const auto result = testing::z_test(of_groups[g][i], alone[g][i]);
      EXPECT_TRUE(testing::plausible(result)) << "group " << g << " block " << i / 3 << " channel " << i % 3;
    }
}

INSTANTIATE_TEST_SUITE_P(Modes, LightGroups, ::testing::Values(SubsurfaceMode::walk, SubsurfaceMode::diffusion));

}  // namespace
}  // namespace alabaster
