// The layers of light add up to the picture, and each equals the picture of a scene that has nothing else.
#include <gtest/gtest.h>

#include <cmath>

#include "core/subsurface/medium.h"
#include "testenv/support/scene_builder.h"
#include "testenv/support/z_test.h"

namespace alabaster {
namespace {

using testing::RunningStatistics;
using testing::SceneBuilder;

DisneyParameters every_lobe() {
  DisneyParameters p;
  p.base_color = {0.8f, 0.6f, 0.3f};
  p.roughness = 0.4f;
  p.sheen = 0.5f;
  p.clearcoat = 1;
  p.clearcoat_gloss = 0.5f;
  p.scatter_distance = {0.3f, 0.1f, 0};
  return p;
}

DisneyParameters without_specular(DisneyParameters p) {
  p.ior = 1;
  p.specular = p.clearcoat = 0;
  return p;
}

RenderRequest request_of(SceneBuilder* b, const CameraParameters& camera, int size, uint32_t samples) {
  RenderRequest request;
  request.scene = b->snapshot();
  request.camera = camera;
  request.width = request.height = size;
  request.data_window = {0, 0, size, size};
  request.aovs = kLayerAovs;
  request.settings.samples = samples;
  request.settings.energy = EnergyModel::burley2015;  // its lobes do not depend on each other
  return request;
}

LightParameters key_light() {
  LightParameters key;
  key.type = LightType::sphere;
  key.radius = 0.5f;
  key.intensity = 20;
  key.light_to_world.setTranslation(Vec3d(2, 3, 1));
  return key;
}

std::vector<double> channel(const Film& film, Aov aov, int c) {
  const auto values = film.resolve_float(aov);
  std::vector<double> out;
  for (size_t i = static_cast<size_t>(c); i < values.size(); i += static_cast<size_t>(aov_info(aov).components()))
    out.push_back(values[i]);
  return out;
}

// Pixels are independent samples of their expected values.
void expect_mean(const std::vector<double>& values, double expected, double slack, const std::string& what) {
  RunningStatistics statistics;
  for (const double v : values) statistics.add(v);
  const auto result = testing::z_test(statistics, expected, {.slack = slack});
  EXPECT_TRUE(plausible(result)) << what;
}

std::vector<double> difference(std::vector<double> a, const std::vector<double>& b) {
  for (size_t i = 0; i < a.size(); ++i) a[i] -= b[i];
  return a;
}

// Bodies of every kind that illuminate each other, a visible lamp, and a backdrop.
RenderRequest mixed_request() {
  SceneBuilder b;
  DisneyParameters metal, lamp;
  metal.metallic = 1;
  metal.roughness = 0.2f;
  lamp.emission = {3, 2, 1};
  b.add(b.prototype(testing::plane_mesh(6)), b.material({}));
  b.add(b.prototype(testing::sphere_mesh(0.5f, 24, true)), b.material(every_lobe()),
        Matrix4d().setTranslation(Vec3d(-0.6, 0.5, 0)));
  b.add(b.prototype(testing::sphere_mesh(0.5f, 24, true)), b.material(metal),
        Matrix4d().setTranslation(Vec3d(0.6, 0.5, 0)));
  b.add(b.prototype(testing::sphere_mesh(0.2f, 8, false)), b.material(lamp),
        Matrix4d().setTranslation(Vec3d(0, 0.2, 0.9)));
  b.add(key_light()).add(testing::constant_dome(0.3f, true));
  return request_of(&b, testing::look_at({0, 1.2, 3.5}, {0, 0.5, 0}, 40), 64, 16);
}

constexpr Aov kKinds[] = {Aov::direct_diffuse,      Aov::indirect_diffuse, Aov::direct_subsurface,
                          Aov::indirect_subsurface, Aov::direct_specular,  Aov::indirect_specular,
                          Aov::transmission,        Aov::emission};

class LightLayersInMode : public ::testing::TestWithParam<SubsurfaceMode> {};

TEST_P(LightLayersInMode, AddUpToTheColorOfEveryPixel) {
  RenderRequest request = mixed_request();
  request.settings.subsurface = GetParam();
  const auto film = testing::render(request);
  const Aov parts[] = {Aov::diffuse, Aov::subsurface, Aov::specular, Aov::emission};
  const Aov walks[] = {Aov::subsurface_unscattered, Aov::subsurface_single, Aov::subsurface_multiple};
  for (int c = 0; c < 3; ++c) {
    const auto color = channel(*film, Aov::color, c), subsurface = channel(*film, Aov::subsurface, c);
    std::vector<double> left = color, subsurface_left = subsurface;
    for (const Aov part : parts) {
      const auto layer = channel(*film, part, c);
      double total = 0;
      for (const double v : layer) {
        // A walk's twin may take more than few walks bring.
        EXPECT_TRUE(v >= 0 || part == Aov::subsurface) << aov_info(part).name;
        total += v;
      }
      EXPECT_EQ(total > 0, !(part == Aov::subsurface && c == 2)) << aov_info(part).name << c;
      left = difference(std::move(left), layer);
    }
    std::vector<double> kinds_left = color;
    for (const Aov kind : kKinds) kinds_left = difference(std::move(kinds_left), channel(*film, kind, c));
    for (const Aov walk : walks) subsurface_left = difference(std::move(subsurface_left), channel(*film, walk, c));
    // Float rounding: of a sample's dozen additions, and of the averages. Twins add and take up to the color.
    for (size_t i = 0; i < color.size(); ++i) {
      ASSERT_LE(std::abs(left[i]), 16 * 0x1p-24 * color[i]) << i;
      ASSERT_LE(std::abs(kinds_left[i]), 16 * 0x1p-24 * color[i]) << i;
      ASSERT_LE(std::abs(subsurface_left[i]), 4 * 0x1p-24 * color[i]) << i;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Modes, LightLayersInMode,
                         ::testing::Values(SubsurfaceMode::walk, SubsurfaceMode::reference, SubsurfaceMode::diffusion));

// Samples take the same ways as far as they go, so direct light is the very light of a render with one bounce.
// promise: pipeline.aov.direct
TEST_P(LightLayersInMode, DirectLightIsThatOfOneBounce) {
  RenderRequest request = mixed_request();
  request.settings.subsurface = GetParam();
  const auto film = testing::render(request);
  request.settings.max_depth = 1;
  const auto once = testing::render(request);
  const std::pair<Aov, Aov> direct[] = {{Aov::direct_diffuse, Aov::diffuse},
                                        {Aov::direct_subsurface, Aov::subsurface},
                                        {Aov::direct_specular, Aov::specular}};
  for (const auto& [aov, whole] : direct) {
    EXPECT_EQ(film->resolve_float(aov), once->resolve_float(aov)) << aov_info(aov).name;
    EXPECT_EQ(once->resolve_float(aov), once->resolve_float(whole)) << aov_info(aov).name;
  }
  for (const Aov aov : {Aov::indirect_diffuse, Aov::indirect_subsurface, Aov::indirect_specular}) {
    for (const float v : once->resolve_float(aov)) ASSERT_EQ(v, 0) << aov_info(aov).name;
    double light = 0;
    for (const float v : film->resolve_float(aov)) light += double(v);
    EXPECT_GT(light, 10) << aov_info(aov).name;
  }
}

// A diffusion profile does not distinguish numbers of events.
// promise: pipeline.aov.diffusion
TEST(LightLayers, DiffusionIsMultipleScattering) {
  RenderRequest request = mixed_request();
  request.settings.subsurface = SubsurfaceMode::diffusion;
  const auto film = testing::render(request);
  EXPECT_EQ(film->resolve_float(Aov::subsurface_multiple), film->resolve_float(Aov::subsurface));
}

TEST(LightLayers, DoNotChangeTheColor) {
  RenderRequest request = mixed_request();
  const auto with = testing::render(request)->resolve_float(Aov::color);
  request.aovs = aov_bit(Aov::color);
  const auto plain = testing::render(request);
  EXPECT_EQ(plain->resolve_float(Aov::color), with);
  for (const float v : plain->resolve_float(Aov::diffuse)) ASSERT_EQ(v, 0) << "not requested";
}

// Light seen in a mirror is specular, whatever scattered it before.
// promise: pipeline.aov.first_surface
TEST(LightLayers, FirstSurfaceSelectsTheLayer) {
  SceneBuilder b;
  DisneyParameters mirror;
  mirror.metallic = 1;
  mirror.roughness = 0;
  b.add(b.prototype(testing::plane_mesh(40)), b.material(mirror));
  b.add(b.prototype(testing::sphere_mesh(1, 24, true)), b.material(every_lobe()),
        Matrix4d().setTranslation(Vec3d(0, 1.5, -2)));
  b.add(key_light());
  const auto film = testing::render(request_of(&b, testing::look_at({0, 1.5, 4}, {0, 0, 1.2}, 20), 24, 16));
  double seen = 0;
  for (int c = 0; c < 3; ++c) {
    for (const double v : channel(*film, Aov::specular, c)) seen += v;
    for (const Aov none : {Aov::diffuse, Aov::subsurface, Aov::emission})
      for (const double v : channel(*film, none, c)) ASSERT_EQ(v, 0) << aov_info(none).name;
  }
  EXPECT_GT(seen, 1);
}

// What is seen through a clear pane of index 1 is transmission, all of it. What scattered in a body behind a clear wall
// is subsurface.
// promise: pipeline.aov.transmission
TEST(LightLayers, LightThroughClearSurfacesIsTransmission) {
  DisneyParameters pane, jelly, seen = every_lobe();
  seen.scatter_distance = Rgb(0.0f);
  pane.spec_trans = jelly.spec_trans = 1;
  pane.ior = 1, pane.thin = true;
  jelly.scatter_distance = Rgb(0.3f);
  const auto film_of = [&](bool behind_pane) {
    SceneBuilder b;
    b.add(b.prototype(testing::sphere_mesh(1, 24, true)), b.material(behind_pane ? seen : jelly));
    if (behind_pane)
      b.add(b.prototype(testing::plane_mesh(40)), b.material(pane),
            Matrix4d().setAxisAngle(Vec3d(1, 0, 0), 1.5707963267948966) * Matrix4d().setTranslation(Vec3d(0, 0, 2)));
    b.add(testing::constant_dome(0.5f, false)).add(key_light());
    return testing::render(request_of(&b, testing::look_at({0, 0, 4}, {0, 0, 0}, 24), 24, 16));
  };
  const auto through = film_of(true), body = film_of(false);
  for (int c = 0; c < 3; ++c)
    EXPECT_EQ(channel(*through, Aov::transmission, c), channel(*through, Aov::color, c)) << "all of it";
  const auto total = [](const Film& film, Aov aov) {
    double sum = 0;
    for (const float v : film.resolve_float(aov)) sum += double(v);
    return sum;
  };
  EXPECT_GT(total(*through, Aov::transmission), 10);
  EXPECT_GT(total(*body, Aov::direct_subsurface), 10);
  EXPECT_GT(total(*body, Aov::direct_specular), 1) << "the highlight";
  EXPECT_LT(total(*body, Aov::transmission), 0.05 * total(*body, Aov::subsurface)) << "what has not scattered";
}

// promise: pipeline.aov.emission
TEST(LightLayers, LightSeenDirectlyIsEmission) {
  SceneBuilder b;
  DisneyParameters lamp;
  lamp.base_color = Rgb(0.0f);
  lamp.ior = 1;
  lamp.specular = 0;
  lamp.emission = {3, 2, 1};
  b.add(b.prototype(testing::sphere_mesh(1, 24, true)), b.material(lamp)).add(testing::constant_dome(0.5f, true));
  const auto film = testing::render(request_of(&b, testing::look_at({0, 0, 4}, {0, 0, 0}, 40), 32, 4));
  for (int c = 0; c < 3; ++c) EXPECT_EQ(channel(*film, Aov::emission, c), channel(*film, Aov::color, c));
  EXPECT_EQ(film->resolve_float(Aov::emission)[0], 0.5f) << "the backdrop";
  EXPECT_EQ(film->resolve_float(Aov::emission)[size_t{3} * (16 * 32 + 16)], 3.0f) << "the lamp";
}

// On a convex body light scatters at one surface only, so its layers equal those of bodies without the other lobes.
class Lobes : public ::testing::Test {
 protected:
  static std::shared_ptr<const Film> body(const DisneyParameters& parameters) {
    SceneBuilder b;
    b.add(b.prototype(testing::sphere_mesh(1, 48, true)), b.material(parameters));
    b.add(key_light()).add(testing::constant_dome(0.3f, false));
    return testing::render(request_of(&b, testing::look_at({0, 1, 4}, {0, 0, 0}, 34), 48, 64));
  }
  static const Film& mixed() {
    static const auto film = body(every_lobe());
    return *film;
  }
};

// promise: pipeline.aov.specular
TEST_F(Lobes, SpecularIsThatOfABlackBody) {
  DisneyParameters black = every_lobe();
  black.base_color = Rgb(0.0f);
  black.sheen = 0;
  black.scatter_distance = Rgb(0.0f);
  const auto alone = body(black);
  for (int c = 0; c < 3; ++c)
    expect_mean(difference(channel(mixed(), Aov::specular, c), channel(*alone, Aov::color, c)), 0, 0, "specular");
}

// promise: pipeline.aov.diffuse, pipeline.aov.subsurface
TEST_F(Lobes, SubsurfaceAndDiffuseAreThoseOfBodiesWithoutSpecular) {
  // Roughness 0 removes the retro-reflective term, which stays local. Only the subsurface lobe is left in the
  // scattering channels.
  DisneyParameters walk_only = without_specular(every_lobe());
  walk_only.roughness = walk_only.sheen = 0;
  const auto matt = body(without_specular(every_lobe())), walk = body(walk_only);
  for (int c = 0; c < 2; ++c) {
    const auto subsurface = channel(*walk, Aov::color, c);
    expect_mean(difference(channel(mixed(), Aov::subsurface, c), subsurface), 0, 0, "subsurface");
    const auto local = difference(channel(*matt, Aov::color, c), subsurface);
    expect_mean(difference(channel(mixed(), Aov::diffuse, c), local), 0, 0, "diffuse beside subsurface");
  }
  expect_mean(difference(channel(mixed(), Aov::diffuse, 2), channel(*matt, Aov::color, 2)), 0, 0, "diffuse");
  for (const double v : channel(mixed(), Aov::subsurface, 2)) ASSERT_EQ(v, 0) << "this channel does not scatter";
}

// The part of light that crosses a sphere of radius 1, over chords of 2 cos(theta), after entering by the cosine lobe.
double unscattered_part(double tau) {
  return (1 - (1 + 2 * tau) * std::exp(-2 * tau)) / (2 * tau * tau);
}

// Escape without a further event from a distance r of the centre, averaged over directions.
double escape(double r, double tau) {
  constexpr int kSteps = 256;
  double sum = 0;
  for (int i = 0; i < kSteps; ++i) {
    const double mu = 2 * (i + 0.5) / kSteps - 1;
    sum += std::exp(-tau * (std::sqrt(1 - r * r * (1 - mu * mu)) - r * mu));
  }
  return sum / kSteps;
}

// One event on the chord, with probability alpha to go on, then escape. By the midpoint rule.
double single_part(double tau, double alpha) {
  constexpr int kSteps = 128;
  double sum = 0;
  for (int i = 0; i < kSteps; ++i) {
    const double mu = (i + 0.5) / kSteps;
    for (int j = 0; j < kSteps; ++j) {
      const double t = 2 * mu * (j + 0.5) / kSteps, r = std::sqrt(1 + t * t - 2 * t * mu);
      sum += 2 * mu * (2 * mu / kSteps) * tau * std::exp(-tau * t) * escape(std::min(r, 1.0), tau);
    }
  }
  return alpha * sum / kSteps;
}

// In a furnace of radiance one every exit sees the same, so a layer shows its part of the entering energy, times the
// exit lobe's 1 - 1/42. The channels share their walks at three optical depths.
// promise: pipeline.aov.subsurface_parts
TEST(LightLayers, UnscatteredAndSingleAreThoseOfASphere) {
  constexpr double kTau[3] = {0.3, 1, 3}, kAlbedo[3] = {0.5, 0.9, 0.7}, kExit = 41.0 / 42;
  DisneyParameters p = without_specular({});
  p.roughness = 0;
  for (int c = 0; c < 3; ++c) {
    p.base_color[c] = static_cast<float>(kAlbedo[c]);
    p.scatter_distance[c] = static_cast<float>(1 / (kTau[c] * distance_scale(kAlbedo[c])));
  }
  SceneBuilder b;
  b.add(b.prototype(testing::sphere_mesh(1, 128, false)), b.material(p)).add(testing::constant_dome(1, false));
  // The middle of the sphere: within 8 degrees of its normal F_V is below 1e-9.
  const auto film = testing::render(request_of(&b, testing::look_at({0, 0, 4}, {0, 0, 0}, 4), 48, 64));
  for (int c = 0; c < 3; ++c) {
    const double alpha = 1 - one_minus_alpha(kAlbedo[c], AlbedoInversion::exact);
    // Facets lie up to 3e-4 of the radius inside the sphere.
    constexpr double kSlack = 3e-4;
    expect_mean(channel(*film, Aov::subsurface_unscattered, c), kExit * unscattered_part(kTau[c]), kSlack,
                "unscattered");
    expect_mean(channel(*film, Aov::subsurface_single, c), kExit * single_part(kTau[c], alpha), kSlack, "single");
  }
}

}  // namespace
}  // namespace alabaster
