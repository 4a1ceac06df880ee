// subsurfaceWeight, subsurfaceColor and meanFreePath: mixtures of diffuse reflection and walks.
#include <gtest/gtest.h>

#include <cmath>

#include "testenv/support/furnace.h"
#include "testenv/support/material_testing.h"
#include "testenv/support/medium_bodies.h"
#include "testenv/support/mesh_bodies.h"

namespace alabaster {
namespace {

using testing::add;
using testing::clear_body;
using testing::expect_furnace;
using testing::matt;
using testing::PathTracer;
using testing::plausible;
using testing::RunningStatistics;
using testing::SceneBuilder;
using testing::white_body;
using testing::z_test;

/// Squares of two values, over the unit square of texture coordinates.
class Squares final : public Texture {
 public:
  Squares(float a, float b, int count) : values_{a, b}, count_(count) {}
  Rgb rgb(const Vec2f& uv) const override {
    const auto at = [&](float x) { return static_cast<int>(std::floor(x * static_cast<float>(count_))); };
    return Rgb(values_[(at(uv.x) + at(uv.y)) & 1]);
  }
  int width() const override { return count_; }
  int height() const override { return count_; }
  size_t memory_bytes() const override { return sizeof(*this); }
  Rgb texel(int x, int y) const override { return Rgb(values_[(x + y) & 1]); }

 private:
  float values_[2];
  int count_;
};

/// Texture coordinates of a body's points from above.
Mesh with_coordinates(Mesh mesh) {
  UvSet& set = mesh.uv_sets.emplace_back();
  set.name = "st";
  const Vec3f &low = mesh.bounds.lower, size = mesh.bounds.extent();
  for (const Vec3f& p : mesh.points) set.values.push_back({(p.x - low.x) / size.x, (p.z - low.z) / size.z});
  return mesh;
}

void add_textured(SceneBuilder* b, Mesh mesh, const DisneyParameters& p, const char* parameter,
                  std::shared_ptr<const Texture> image) {
  auto material = std::make_shared<DisneyMaterial>();
  material->constants = p;
  testing::connect(parameter, std::move(image), material.get(),
                   find_material_parameter(parameter)->is_color() ? Channel::rgb : Channel::r);
  b->add(b->prototype(with_coordinates(std::move(mesh))), material);
}

/// A ball that shows everything that a mixture has: two channels that scatter and one that does not, both highlights.
DisneyParameters mixture(float weight) {
  DisneyParameters p;
  p.base_color = {0.2f, 0.7f, 0.5f};
  p.subsurface_color = {0.8f, 0.3f, 0.6f};
  p.subsurface_weight = weight;
  p.scatter_distance = {0.4f, 0.1f, 0};
  return p;
}

std::shared_ptr<const Film> picture(const DisneyParameters& p, uint32_t seed, SubsurfaceMode mode) {
  SceneBuilder b;
  add(&b, b.prototype(testing::sphere_mesh(1, 48, true)), p);
  LightParameters key;
  key.type = LightType::distant;
  key.angle = 1;
  key.intensity = 2;
  b.add(testing::constant_dome(0.5f, false)).add(key);
  RenderRequest request = testing::request_of(&b, testing::look_at({3, 3, 4}, {0, 0, 0}, 26), 64);
  request.settings.seed = testing::run_seed(seed);
  request.settings.subsurface = mode;
  return testing::render(request);
}

// By blocks of 8 x 8 pixels, each channel, for a body that meets no light of its own.
TEST(SubsurfaceWeight, AConvexBodyIsTheMixtureOfBoth) {
  for (const auto mode :
       {SubsurfaceMode::walk, SubsurfaceMode::reference, SubsurfaceMode::diffusion, SubsurfaceMode::lambert})
    for (const float weight : {0.25f, 0.7f}) {
      const auto half = picture(mixture(weight), 1, mode), none = picture(mixture(0), 2, mode),
                 all = picture(mixture(1), 3, mode);
      const auto x = half->resolve_float(Aov::color), a = none->resolve_float(Aov::color),
                 b = all->resolve_float(Aov::color);
      for (int block = 0; block < 16; ++block)
        for (size_t c = 0; c < 3; ++c) {
          RunningStatistics difference;
          for (int i = 0; i < 64; ++i) {
            const auto pixel = static_cast<size_t>((block / 4 * 8 + i / 8) * 32 + block % 4 * 8 + i % 8);
            difference.add(double(x[4 * pixel + c] - (1 - weight) * a[4 * pixel + c] - weight * b[4 * pixel + c]));
          }
          EXPECT_TRUE(plausible(z_test(difference, 0, {.slack = 1e-3})))
              << "mode " << int(mode) << ", weight " << weight << ", block " << block << ", channel " << c;
        }
    }
}

TEST(SubsurfaceWeight, ZeroIsTheSurfaceWithoutAMediumToTheBit) {
  DisneyParameters none = mixture(0);
  none.scatter_distance = Rgb(0.0f), none.subsurface_color = Rgb(-1.0f), none.subsurface_weight = 1;
  EXPECT_EQ(picture(mixture(0), 1, SubsurfaceMode::walk)->resolve_float(Aov::color),
            picture(none, 1, SubsurfaceMode::walk)->resolve_float(Aov::color));
}

// A light that enters where all goes below meets walls from inside that let nothing out, and comes out all the same.
TEST(SubsurfaceWeight, AWhiteBallOfPartsWithoutLosesNoLight) {
  for (const bool in_array : {false, true}) {
    SceneBuilder b;
    add_textured(&b, testing::sphere_mesh(1, 48, true), white_body(0.1f), "subsurfaceWeight",
                 std::make_shared<Squares>(0.0f, 1.0f, 12));
    if (in_array) testing::make_last_an_array(&b, {Matrix4d()});
    expect_furnace(b,
                   {{"middle", {0.3, 3, 4}}, {"rim", {0, 4, 0}, {0.8, 0, 0.1}}, {"within", {0, 0.1, 0.2}, {1, 0, 0}}},
                   {.runs = 32, .slack = 0.01}, in_array ? "an array" : "alone");
  }
}

TEST(SubsurfaceWeight, ACloudyBodyWithoutASubsurfaceLobeLosesNoLight) {
  SceneBuilder b;
  DisneyParameters p = clear_body(1, 0.2f);  // whose rough facets lose nothing
  p.spec_trans = 0.5f, p.subsurface_weight = 0, p.roughness = 0.5f, p.specular = 0;
  add(&b, b.prototype(testing::sphere_mesh(1, 48, true)), p);
  expect_furnace(b, {{"middle", {0, 3, 4}}, {"off it", {0, 0, 5}, {0.6, 0.1, 0}}},
                 {.runs = 64, .slack = 0.01, .sees_background = true}, "cloudy");
}

/// A white surface on a half-space of albedo .9 and mean free path 1, with squares of weights .2 and .8.
SceneBuilder half_space(int squares) {
  SceneBuilder b;
  DisneyParameters p = matt(Rgb(1.0f));
  p.subsurface_color = Rgb(0.9f);
  p.mean_free_path = Rgb(1.0f);
  add_textured(&b, testing::plane_mesh(64), p, "subsurfaceWeight", std::make_shared<Squares>(0.2f, 0.8f, squares));
  return b;
}

/// The mean over the middle of the plane, seen at an angle to its normal.
RunningStatistics seen(SceneBuilder b, double degrees, uint32_t seed, int channel = 1) {
  const double angle = degrees * M_PI / 180;
  RenderRequest request =
      testing::request_of(&b, testing::look_at({20 * std::sin(angle), 20 * std::cos(angle), 0.1}, {0, 0, 0}, 30), 64);
  request.camera.orthographic = true;
  request.camera.horizontal_aperture = request.camera.vertical_aperture = 4;
  request.settings.seed = testing::run_seed(seed);
  request.settings.max_depth = 64;
  const auto film = testing::render(request);
  const auto color = film->resolve_float(Aov::color);
  RunningStatistics all;
  for (size_t i = 0; i < color.size() / 4; ++i) all.add(double(color[4 * i + static_cast<size_t>(channel)]));
  return all;
}

LightParameters sun(double degrees) {
  LightParameters light;
  light.type = LightType::distant;
  light.angle = 0;
  light.intensity = 1;
  const double angle = degrees * M_PI / 180;
  light.light_to_world =
      Matrix4d().setEulerAngles(Vec3d(-M_PI / 2, 0, 0)) * Matrix4d().setEulerAngles(Vec3d(0, 0, -angle));
  return light;
}

// As many squares of either weight are seen: what is seen from a and lit from b is lit from a and seen from b.
TEST(SubsurfaceWeight, SquaresOfOneMeanFreePathAreReciprocal) {
  SceneBuilder b = half_space(64), swapped = b;
  b.add(sun(0)), swapped.add(sun(60));
  const auto from_60 = seen(b, 60, 4), from_0 = seen(swapped, 0, 5);
  ASSERT_GT(from_60.mean(), 0.05);
  EXPECT_TRUE(plausible(
      z_test(from_60.mean() * 0.5, 0.5 * from_60.standard_error(), from_0.mean(), {.slack = 0.01 * from_0.mean()})));
}

// Light that enters by the weight a and leaves by b counts by the lesser of the two; far from where it entered they are
// independent, and .2, .8 give 1 - .5 + .9 (3 * .2 + .8) / 4.
TEST(SubsurfaceWeight, SquaresSendOutNoMoreThanComesIn) {
  const double lobes = testing::kExit;  // of Lambert's term, seen along the normal
  for (const auto& [squares, wanted] : {std::pair(64 * 64, 0.815 * lobes), {64, 0.0}}) {
    SceneBuilder b = half_space(squares);
    b.add(testing::constant_dome(1, false));
    const auto light = seen(b, 0, 6);
    EXPECT_TRUE(plausible(testing::at_most_test(light, lobes))) << squares;
    if (wanted > 0) {
      EXPECT_TRUE(plausible(z_test(light, wanted, {.slack = 0.005})));
    }
  }
}

/// A slab lit from behind, whose mean free path a texture gives.
RunningStatistics through_slab(const DisneyParameters& p, std::shared_ptr<const Texture> image, double x,
                               uint32_t seed) {
  SceneBuilder b;
  Mesh slab = testing::box_mesh({-8, -0.5f, -8}, {8, 0.5f, 8});
  if (image)
    add_textured(&b, std::move(slab), p, "meanFreePath", std::move(image));
  else
    add(&b, b.prototype(std::move(slab)), p);
  LightParameters behind = sun(180);
  behind.intensity = 10;
  b.add(behind);
  RenderRequest request = testing::request_of(&b, testing::look_at({x, 10, -4.1}, {x, 0, -4}, 8), 128, 16);
  request.settings.seed = testing::run_seed(seed);
  const auto color = testing::render(request)->resolve_float(Aov::color);
  RunningStatistics all;
  for (size_t i = 0; i < color.size() / 4; ++i) all.add(double(color[4 * i + 1]));
  return all;
}

TEST(MeanFreePath, EachHalfOfATexturedSlabIsItsConstantMaterial) {
  DisneyParameters p = testing::medium_only(0.7f, 0);
  p.scatter_anisotropy = 0.4f;
  p.mean_free_path = Rgb(1.0f);
  // Squares as large as half the slab, which is eight times as far as it is thick.
  const auto image = std::make_shared<Squares>(0.1f, 0.4f, 2);
  for (const float path : {0.1f, 0.4f}) {
    DisneyParameters constant = p;
    constant.mean_free_path = Rgb(path);
    const double x = path < 0.2f ? -4 : 4;
    const auto textured = through_slab(p, image, x, 7), alike = through_slab(constant, nullptr, x, 8);
    ASSERT_GT(alike.mean(), 1e-3);
    EXPECT_TRUE(plausible(z_test(textured, alike, {.slack = 0.01 * alike.mean()}))) << path;
  }
}

/// Light that crosses a slab without an event.
double crossed(const DisneyParameters& p) {
  SceneBuilder b;
  add(&b, b.prototype(testing::box_mesh({-8, -0.5f, -8}, {8, 0.5f, 8})), p);
  b.add(testing::constant_dome(1, false));
  PathTracer tracer(b.snapshot(), {0, 10, 0.1});
  tracer.settings.walk = {.guiding = false, .sphere_steps = false, .twins = false};
  double sum = 0;
  constexpr int kSamples = 1 << 16;
  for (uint32_t i = 0; i < kSamples; ++i) {
    LightLayers layers;
    tracer.trace(i, &layers);
    sum += double(layers.unscattered().g);
  }
  return sum / kSamples;
}

// The mean of exp(-1 / cos) over a cosine lobe is 2 E3(1).
TEST(MeanFreePath, ItIsTheExtinctionWhateverColourAndAnisotropy) {
  for (const auto& [albedo, g] : {std::pair(0.2f, 0.0f), {0.9f, 0.0f}, {0.9f, 0.7f}, {0.5f, -0.5f}}) {
    DisneyParameters p = testing::medium_only(albedo, 0.2f);
    p.mean_free_path = Rgb(1.0f), p.scatter_anisotropy = g;
    EXPECT_NEAR(crossed(p) / testing::kExit, 2 * 0.1096919670, 0.003) << albedo << " " << g;
  }
}

// A body with a colour of its own keeps the tint of its clear walls.
TEST(SubsurfaceColor, ClearWallsKeepTheBaseColor) {
  DisneyParameters p = clear_body(1, 1e6f);
  p.base_color = Rgb(0.25f), p.specular = 0;
  for (const auto& [own, level] : {std::pair(0.9f, 0.25), {-1.0f, 1.0}}) {
    p.subsurface_color = Rgb(own);
    SceneBuilder b;
    add(&b, b.prototype(testing::box_mesh({0.5f, 0.5f, 0.5f})), p);
    b.add(testing::constant_dome(1, true));
    PathTracer tracer(b.snapshot(), {0, 0, 5});
    const auto through = testing::look(&tracer, 8, [](const FilmSample& s) { return double(s.color.g); });
    EXPECT_TRUE(plausible(z_test(through, level, {.slack = 1e-4}))) << own;
  }
}

TEST(SubsurfaceColor, IsInTheDenoisersAlbedoByItsWeight) {
  const auto albedo = [](float weight) {
    SceneBuilder b;
    DisneyParameters p = matt(Rgb(0.2f));
    p.subsurface_color = Rgb(0.8f), p.subsurface_weight = weight, p.scatter_distance = Rgb(0.1f);
    add(&b, b.prototype(testing::sphere_mesh(1, 24, true)), p);
    PathTracer tracer(b.snapshot(), {0, 0, 5});
    tracer.aovs |= aov_bit(Aov::albedo);
    return tracer.trace(0).albedo.g;
  };
  EXPECT_NEAR(albedo(0), 0.2f, 1e-6);
  EXPECT_NEAR(albedo(0.25f), 0.35f, 1e-6);
  EXPECT_NEAR(albedo(1), 0.8f, 1e-6);
}

}  // namespace
}  // namespace alabaster
