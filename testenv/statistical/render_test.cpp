// The whole renderer against answers derived by hand: closed forms, furnaces, and two ways to light the same scene.
#include <gtest/gtest.h>

#include <cmath>

#include "core/material/disney_bsdf.h"
#include "core/subsurface/medium.h"
#include "testenv/support/half_space.h"
#include "testenv/support/material_testing.h"
#include "testenv/support/scene_builder.h"
#include "testenv/support/z_test.h"

namespace alabaster {
namespace {

using testing::MeanError;
using testing::SceneBuilder;

// A film's pixels are independent samples of the expected values given per pixel.
void expect_film(const Film& film, const std::function<double(int x, int y)>& expected, double slack) {
  const auto color = film.resolve_float(Aov::color);
  const PixelRect w = film.data_window();
  testing::RunningStatistics differences;
  for (int y = w.y0; y < w.y1; ++y)
    for (int x = w.x0; x < w.x1; ++x) {
      const auto i = static_cast<size_t>((y - w.y0) * w.width() + x - w.x0);
      differences.add(color[4 * i + 1] - expected(x, y));
    }
  const auto result = testing::z_test(differences, 0, {.slack = slack});
  EXPECT_TRUE(plausible(result));
}

// Only the 2015 diffuse: roughness 0 removes the retro-reflective term, ior 1 the specular lobe.
DisneyParameters diffuse_only(float albedo) {
  DisneyParameters p;
  p.base_color = Rgb(albedo);
  p.roughness = 0;
  p.ior = 1;
  p.specular = 0;
  return p;
}

double schlick(double cosine) {
  return std::pow(1 - cosine, 5);
}

RenderRequest straight_down(SceneBuilder* b, const DisneyParameters& material) {
  b->add(b->prototype(testing::plane_mesh(40)), b->material(material));
  RenderRequest request;
  request.scene = b->snapshot();
  request.camera = testing::look_at({0, 5, 0}, {0, 0, 0}, 30);
  request.camera.orthographic = true;  // every view is along the normal: F_V = 0
  request.camera.horizontal_aperture = request.camera.vertical_aperture = 2;
  request.width = request.height = 48;
  request.data_window = {0, 0, 48, 48};
  request.settings.samples = 64;
  request.settings.filter = PixelFilter::box;
  return request;
}

// On the film of straight_down, up is -z or +z by look_at's choice, and x is world x up to sign. The lights below are
// symmetric about both axes, so signs do not matter.
Vec3d film_point(int x, int y) {
  return {(x + 0.5) / 24 - 1, 0, (y + 0.5) / 24 - 1};
}

// Outgoing radiance at a point of the plane lit by a rectangle overhead, by the midpoint rule over the rectangle.
double rect_over_plane(const Vec3d& p, double half, double height, double radiance, double albedo) {
  constexpr int kSteps = 64;
  double sum = 0;
  for (int i = 0; i < kSteps; ++i)
    for (int j = 0; j < kSteps; ++j) {
      const Vec3d q(half * (2 * (i + 0.5) / kSteps - 1), height, half * (2 * (j + 0.5) / kSteps - 1));
      const Vec3d d = q - p;
      const double r2 = dot(d, d), cosine = height / std::sqrt(r2);
      sum += cosine * cosine / r2 * (1 - 0.5 * schlick(cosine));
    }
  return radiance * albedo / M_PI * sum * 4 * half * half / (kSteps * kSteps);
}

TEST(ClosedForm, RectLightOverPlane) {
  SceneBuilder b;
  LightParameters light;
  light.type = LightType::rect;
  light.width = light.height = 1;
  light.intensity = 7;
  // Lights emit down -z: turn it to -y, two above the plane.
  light.light_to_world = Matrix4d(1, 0, 0, 0, 0, 0, -1, 0, 0, 1, 0, 0, 0, 2, 0, 1);
  b.add(light);
  const auto film = testing::render(straight_down(&b, diffuse_only(0.6f)));
  expect_film(
      *film, [](int x, int y) { return rect_over_plane(film_point(x, y), 0.5, 2, 7, 0.6); }, 2e-4);
}

// A sphere light entirely above the horizon: E = pi L (r/d)^2 cos(theta). It is small, so the light-dependent term is
// that of its centre to second order. The slack bounds the rest (half the cone's variation of (1-.5F)cos).
TEST(ClosedForm, SphereLightOverPlane) {
  SceneBuilder b;
  LightParameters light;
  light.type = LightType::sphere;
  light.radius = 0.05f;
  light.intensity = 900;
  light.light_to_world.setTranslation(Vec3d(0, 3, 0));
  b.add(light);
  const auto film = testing::render(straight_down(&b, diffuse_only(0.5f)));
  expect_film(
      *film,
      [](int x, int y) {
        const Vec3d p = film_point(x, y);
        const double d2 = dot(p, p) + 9, cosine = 3 / std::sqrt(d2);
        return 0.5 * 900 * 0.05 * 0.05 / d2 * cosine * (1 - 0.5 * schlick(cosine));
      },
      2e-4);
}

TEST(ClosedForm, EmissiveMeshIsARectLight) {
  // The same square as a light and as an emissive mesh: two estimators, two MIS partners, one picture.
  const auto lit = [](bool mesh) {
    SceneBuilder b;
    if (mesh) {
      DisneyParameters glow = diffuse_only(0);
      glow.emission = Rgb(7);
      b.add(b.prototype(testing::plane_mesh(1)), b.material(glow), Matrix4d().setTranslation(Vec3d(0, 2, 0)));
    } else {
      LightParameters light;
      light.intensity = 7;
      light.light_to_world = Matrix4d(1, 0, 0, 0, 0, 0, -1, 0, 0, 1, 0, 0, 0, 2, 0, 1);
      b.add(light);
    }
    DisneyParameters shiny;
    shiny.roughness = 0.25f;
    RenderRequest request = straight_down(&b, shiny);
    request.camera = testing::look_at({0, 0.8, 2}, {0, 0, 0}, 50);
    return testing::render(request);
  };
  const auto a = lit(true)->resolve_float(Aov::color);
  RenderRequest other;
  const auto b = lit(false)->resolve_float(Aov::color);
  testing::RunningStatistics differences;
  for (size_t i = 1; i < a.size(); i += 4) differences.add(a[i] - b[i]);
  const auto result = testing::z_test(differences, 0);
  EXPECT_TRUE(plausible(result));
}

// A sphere in a constant dome of radiance one. With every light direction at the same radiance the exit lobe integrates
// to 1 - 1/42 (2 Int mu (1-mu)^5 dmu = 1/21), so a pixel shows A_eff (1 - .5 F_V)(41/42).
double furnace(float albedo, float scatter_distance, AlbedoInversion inversion, MeanError* out) {
  SceneBuilder b;
  DisneyParameters p = diffuse_only(albedo);
  p.scatter_distance = Rgb(scatter_distance);
  b.add(b.prototype(testing::sphere_mesh(1, 96, false)), b.material(p));
  b.add(testing::constant_dome(1, false));
  RenderRequest request;
  request.scene = b.snapshot();
  request.camera =
      testing::look_at({0, 0, 4}, {0, 0, 0}, 4);  // the middle of the sphere: views within 8 degrees of normal
  request.width = request.height = 32;
  request.data_window = {0, 0, 32, 32};
  request.settings.samples = 128;
  request.settings.inversion = inversion;
  RenderProgress progress;
  *out = testing::film_mean(*testing::render(request, &progress), 1);
  EXPECT_EQ(progress.counters.walk_safety_cap, 0u);
  EXPECT_EQ(progress.counters.walk_lost, 0u) << "a closed mesh loses nothing";
  return 41.0 / 42;
}

void expect_within(const MeanError& m, double expected, double slack) {
  EXPECT_TRUE(plausible(testing::z_test(m.mean, m.standard_error, expected, {.slack = slack})));
}

// Slack: F_V at 8 degrees is below 1e-9; a facet of the 96-ring sphere tilts by less than a degree; curvature of a
// sphere of 1000 scatter distances changes A by less than 1/1000.
TEST(Furnace, WalkObtainsTheAlbedoAsked) {
  for (const float albedo : {0.2f, 0.5f, 0.8f, 0.95f}) {
    MeanError m;
    const double exit = furnace(albedo, 5e-4f, AlbedoInversion::exact, &m);
    expect_within(m, albedo * exit, 1e-3 * albedo);
  }
}

// promise: trade_off.bias.inversion
TEST(Furnace, PaperInversionObtainsWhatEquationOneGives) {
  for (const float albedo : {0.2f, 0.5f, 0.8f, 0.95f}) {
    MeanError m;
    const double exit = furnace(albedo, 5e-4f, AlbedoInversion::chiang2016, &m);
    const double obtained = testing::half_space_albedo(one_minus_alpha(albedo, AlbedoInversion::chiang2016));
    expect_within(m, obtained * exit, 1e-3 * albedo);
  }
}

TEST(Furnace, WhiteBodyReturnsEverything) {
  MeanError m;
  const double exit = furnace(1, 0.3f, AlbedoInversion::exact, &m);
  expect_within(m, exit, 1e-6);
}

// scatter_distance 0 is bit for bit the 2015 diffuse; the lambert mode too.
TEST(Furnace, ZeroScatterDistanceIsTheDiffuseBitForBit) {
  const auto picture = [](float scatter_distance, SubsurfaceMode mode) {
    SceneBuilder b;
    DisneyParameters p;
    p.scatter_distance = Rgb(scatter_distance);
    b.add(b.prototype(testing::sphere_mesh(1, 24, true)), b.material(p)).add(testing::constant_dome(1, true));
    RenderRequest request;
    request.scene = b.snapshot();
    request.camera = testing::look_at({0, 1, 4}, {0, 0, 0}, 40);
    request.width = request.height = 32;
    request.data_window = {0, 0, 32, 32};
    request.settings.samples = 4;
    request.settings.subsurface = mode;
    return testing::render(request)->resolve_float(Aov::color);
  };
  EXPECT_EQ(picture(0, SubsurfaceMode::walk), picture(0, SubsurfaceMode::lambert));
  EXPECT_EQ(picture(0, SubsurfaceMode::walk), picture(0.1f, SubsurfaceMode::lambert));
  EXPECT_NE(picture(0, SubsurfaceMode::walk), picture(0.1f, SubsurfaceMode::walk));
}

// One value left of the middle, another right of it.
class HalvesTexture : public Texture {
 public:
  HalvesTexture(const Rgb& left, const Rgb& right) : left_(left), right_(right) {}
  Rgb rgb(const Vec2f& uv) const override { return uv.x < 0.5f ? left_ : right_; }
  int width() const override { return 2; }
  int height() const override { return 1; }
  size_t memory_bytes() const override { return 0; }
  Rgb texel(int x, int) const override { return x ? right_ : left_; }

 private:
  Rgb left_, right_;
};

// A convex body whose u grows with x, seen along z: light enters the medium of the visible half, whatever the other
// half is made of.
RenderRequest body_request(const std::shared_ptr<const DisneyMaterial>& material) {
  SceneBuilder b;
  Mesh mesh = testing::sphere_mesh(1, 32, true);
  mesh.uv_sets.push_back({{}, "st"});
  for (const Vec3f& p : mesh.points) mesh.uv_sets[0].values.emplace_back(0.5f + 0.5f * p.x, 0.5f + 0.5f * p.y);
  LightParameters key;
  key.type = LightType::sphere;
  key.radius = 0.25f;
  key.intensity = 30;
  key.light_to_world.setTranslation(Vec3d(2, 3, 1));
  b.add(b.prototype(std::move(mesh)), material).add(testing::constant_dome(1, true)).add(key);
  RenderRequest request;
  request.scene = b.snapshot();
  request.camera = testing::look_at({0, 0, 4}, {0, 0, 0}, 34);
  request.width = request.height = 32;
  request.data_window = {0, 0, 32, 32};
  request.settings.samples = 8;
  request.settings.filter = PixelFilter::box;
  return request;
}

std::vector<float> textured_body(const Rgb& left, const Rgb& right, bool color_map) {
  auto material = std::make_shared<DisneyMaterial>();
  material->constants.base_color = color_map ? Rgb(1.0f) : Rgb(0.9f, 0.6f, 0.4f);
  material->constants.scatter_distance = color_map ? Rgb(0.3f, 0.2f, 0.1f) : Rgb(1.0f);
  testing::connect(color_map ? "baseColor" : "scatterDistance", std::make_shared<HalvesTexture>(left, right),
                   material.get());
  return testing::render(body_request(material))->resolve_float(Aov::color);
}

void expect_halves(const Rgb& left, const Rgb& right, bool color_map) {
  const auto both = textured_body(left, right, color_map);
  const auto only_left = textured_body(left, left, color_map), only_right = textured_body(right, right, color_map);
  ASSERT_NE(only_left, only_right);
  for (size_t i = 0; i < both.size(); ++i) {
    const size_t x = i / 4 % 32;
    if (x == 15 || x == 16) continue;
    ASSERT_EQ(both[i], (x < 16 ? only_left : only_right)[i]) << i;
  }
}

TEST(Textured, EachHalfIsTheConstantBodyBitForBit) {
  expect_halves({0.3f, 0.2f, 0.1f}, {0.05f, 0.1f, 0.4f}, false);
  expect_halves({0.9f, 0.5f, 0.2f}, {0.2f, 0.8f, 1}, true);
}

TEST(Textured, ZeroInTheMapIsTheDiffuseOfItsChannelBitForBit) {
  expect_halves({0.3f, 0.2f, 0.1f}, Rgb(0.0f), false);
  expect_halves({0.3f, 0, 0.1f}, {0, 0.2f, 0}, false);
  // Nothing scatters anywhere, as without map and distance.
  auto plain = std::make_shared<DisneyMaterial>();
  plain->constants.base_color = {0.9f, 0.6f, 0.4f};
  const RenderRequest request = body_request(plain);
  ASSERT_FALSE(request.scene->features.subsurface);
  EXPECT_EQ(testing::render(request)->resolve_float(Aov::color), textured_body(Rgb(0.0f), Rgb(0.0f), false));
}

// Scaling scene, camera, scatter distance and light sizes by 2^k changes no bit.
TEST(RenderScale, PowersOfTwoChangeNothing) {
  const auto picture = [](int exponent) {
    const double s = std::ldexp(1.0, exponent);
    SceneBuilder b;
    DisneyParameters p;
    p.base_color = {0.9f, 0.6f, 0.4f};
    p.scatter_distance = Rgb(0.2f, 0.1f, 0.05f) * static_cast<float>(s);
    b.add(b.prototype(testing::sphere_mesh(static_cast<float>(s), 24, true)), b.material(p));
    LightParameters key;
    key.type = LightType::sphere;
    key.radius = static_cast<float>(0.25 * s);
    key.intensity = 30;
    key.light_to_world.setTranslation(Vec3d(2, 3, 1) * s);
    b.add(key).add(testing::constant_dome(0.2f, true));
    RenderRequest request;
    request.scene = b.snapshot();
    request.camera = testing::look_at(Vec3d(0, 1, 4) * s, {0, 0, 0}, 40);
    request.width = request.height = 24;
    request.data_window = {0, 0, 24, 24};
    request.settings.samples = 4;
    return testing::render(request)->resolve_float(Aov::color);
  };
  const auto expected = picture(0);
  for (const int exponent : {-20, -7, 1, 20}) EXPECT_EQ(picture(exponent), expected) << "2^" << exponent;
}

}  // namespace
}  // namespace alabaster
