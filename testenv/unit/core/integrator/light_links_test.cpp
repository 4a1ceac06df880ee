// Lights that light some objects only, and whose shadows some objects only cast. Where the numbers of a linked scene
// are those of a scene without the rest, sample for sample, light sampling and lobe sampling must both have found
// nothing else.
#include <gtest/gtest.h>

#include <cmath>

#include "testenv/support/furnace.h"
#include "testenv/support/path_tracer.h"
#include "testenv/support/z_test.h"

namespace alabaster {
namespace {

using testing::matt;
using testing::PathTracer;
using testing::RunningStatistics;
using testing::SceneBuilder;

constexpr uint32_t kA = 1, kB = 2;  // categories
// Sets of categories, by number: none, {A}, {B}, {A, B}.
const std::vector<std::vector<uint32_t>> kSets = {{}, {kA}, {kB}, {kA, kB}};

Matrix4d at(double x, double y, double z) {
  return Matrix4d().setTranslation(Vec3d(x, y, z));
}

/// A quad of side 2 that shines down from y = 2; by default the camera sees it mirrored in the middle of the floor.
LightParameters panel(double x = -1.6) {
  LightParameters light;
  light.width = light.height = 2;
  light.intensity = 3;
  light.light_to_world = Matrix4d().setAxisAngle(Vec3d(1, 0, 0), -M_PI / 2) * at(x, 2, -0.5);
  return light;
}

DisneyParameters glossy(float roughness) {
  DisneyParameters p;
  p.base_color = Rgb(0.9f, 0.6f, 0.3f);
  p.metallic = 1;
  p.roughness = roughness;
  return p;
}

/// The camera looks down at the middle of a floor.
struct Scene : SceneBuilder {
  explicit Scene(uint32_t floor_set, const DisneyParameters& floor = matt(Rgb(0.7f))) {
    description.category_sets = kSets;
    put(testing::plane_mesh(6), material(floor), Matrix4d(), floor_set);
  }
  void put(Mesh mesh, const std::shared_ptr<const DisneyMaterial>& m, const Matrix4d& where, uint32_t set) {
    add(prototype(std::move(mesh)), m, where);
    description.instances.back().category_set = set;
  }
  void shine(LightParameters light, uint32_t light_link, uint32_t shadow_link = 0) {
    light.light_link = light_link;
    light.shadow_link = shadow_link;
    add(light);
  }
  std::vector<Rgb> samples(uint32_t max_depth = 1, int count = 64) {
    PathTracer tracer(snapshot(), {1.2, 1.5, 0.4});
    tracer.settings.max_depth = max_depth;
    std::vector<Rgb> colors;
    for (int i = 0; i < count; ++i) colors.push_back(tracer.trace(static_cast<uint32_t>(i)).color);
    return colors;
  }
};

double sum_of(const std::vector<Rgb>& colors) {
  double sum = 0;
  for (const Rgb& c : colors) sum += double(c.g);
  return sum;
}

void expect_same(const std::vector<Rgb>& a, const std::vector<Rgb>& b, const char* what) {
  for (size_t i = 0; i < a.size(); ++i)
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(a[i][c], b[i][c], 1e-5 * (1 + double(b[i][c]))) << what << " sample " << i;
}

const float kRoughness[] = {0.02f, 0.3f, 1.0f};  // found by the lobe, by both, by light sampling

/// The light by layer that 256 samples bring of a surface below a panel, in one bounce.
LightLayers layers_of(const DisneyParameters& p, float size, const LobeScales& scales) {
  SceneBuilder b;
  testing::add(&b, b.prototype(testing::sphere_mesh(1, 32, true)), p);
  LightParameters light = panel(-0.5);
  light.width = light.height = size;
  light.intensity = 3 / (size * size);
  light.diffuse = scales.diffuse, light.specular = scales.specular;
  b.add(light);
  PathTracer tracer(b.snapshot(), {1.2, 3.5, 0.4}, {0, 1, 0});
  tracer.settings.max_depth = 1;
  LightLayers sum{};
  for (uint32_t i = 0; i < 256; ++i) {
    LightLayers one{};
    const FilmSample seen = tracer.trace(i, &one);
    const Rgb all = one.sum();
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(seen.color[c], all[c], 1e-5 * (1 + double(all[c])));
    sum.add(one, 1);
  }
  return sum;
}

// Of lobes, a coat, a clear sheet and a body, found by light sampling, by the lobe, by both.
TEST(LobeScales, AreMultiplesOfTheLayersOfOneBounce) {
  for (const char* kind : {"plain", "coated", "sheet", "body"})
    for (const float roughness : {0.05f, 0.5f})
      for (const float size : {0.2f, 4.0f}) {
        SCOPED_TRACE(std::string(kind) + " " + std::to_string(roughness) + " " + std::to_string(size));
        DisneyParameters p;
        p.roughness = roughness, p.base_color = {0.8f, 0.5f, 0.2f};
        if (kind == std::string("coated")) p.coat = 1, p.coat_roughness = 0.2f, p.sheen = 1;
        if (kind == std::string("sheet")) p.thin = true, p.spec_trans = 0.5f;
        if (kind == std::string("body")) p.scatter_distance = {0.2f, 0.1f, 0};
        const LightLayers whole = layers_of(p, size, {}), scaled = layers_of(p, size, {0.5f, 3});
        EXPECT_GT(whole.specular().g, 0.01f);
        for (int c = 0; c < 3; ++c) {
          EXPECT_NEAR(scaled.diffuse()[c], 0.5f * whole.diffuse()[c], 1e-4f * (1 + whole.diffuse()[c]));
          EXPECT_NEAR(scaled.specular()[c], 3 * whole.specular()[c], 1e-4f * (1 + whole.specular()[c]));
          EXPECT_NEAR(scaled.subsurface()[c], 0.5f * whole.subsurface()[c],
                      1e-4f * (1 + std::abs(whole.subsurface()[c])));
        }
        const LightLayers none = layers_of(p, size, {1, 0});
        EXPECT_EQ(none.specular(), Rgb(0.0f));
      }
}

TEST(LobeScales, ALightIsSeenAsItIs) {
  Scene scene(0);
  LightParameters light = panel(0);
  light.visible_to_camera = true;
  light.diffuse = 0.2f, light.specular = 0.5f;
  scene.shine(light, 0);
  PathTracer tracer(scene.snapshot(), {0, 0.5, -0.5}, {0, 2, -0.4});
  EXPECT_EQ(tracer.trace(0).color.g, 3);
}

TEST(ShadowEnable, NothingCastsTheShadowsOfALightWithout) {
  for (const float roughness : kRoughness)
    for (const bool linked : {false, true}) {
      Scene shadowed(1, glossy(roughness)), alone(1, glossy(roughness));
      if (!linked) shadowed.description.category_sets.clear(), shadowed.description.instances.back().category_set = 0;
      shadowed.put(testing::sphere_mesh(0.5f, 16, true), shadowed.material(matt(Rgb(0.0f))), at(-0.8, 1, -0.25),
                   linked ? 3 : 0);
      LightParameters light = panel();
      alone.shine(light, 0);
      light.shadow_enable = false;
      shadowed.shine(light, linked ? kA : 0);
      EXPECT_GT(sum_of(alone.samples()), 0);
      expect_same(shadowed.samples(), alone.samples(), "without a shadow");
    }
}

TEST(LightLinks, AnObjectIsLitByTheLightsOfItsCategories) {
  for (const float roughness : kRoughness) {
    Scene linked(1, glossy(roughness)), alone(0, glossy(roughness));
    linked.shine(panel(1.5), kB);
    linked.shine(panel(), kA);
    linked.shine(testing::constant_dome(1, false), kB);
    alone.shine(panel(), 0);
    EXPECT_GT(sum_of(alone.samples()), 0);
    expect_same(linked.samples(), alone.samples(), "lit by A alone");
  }
}

TEST(LightLinks, AnObjectOfNoCategoryIsLitByUnlinkedLightsAlone) {
  Scene linked(0), dark(0), plain(0);
  linked.shine(panel(), kA);
  linked.shine(testing::constant_dome(0.5f, false), 0);
  plain.shine(testing::constant_dome(0.5f, false), 0);
  dark.shine(panel(), kA);
  dark.shine(testing::constant_dome(1, false), kB);
  expect_same(linked.samples(), plain.samples(), "the dome alone");
  EXPECT_EQ(sum_of(dark.samples(8)), 0);
}

// Beyond kSampleAllUpTo lights one of them is chosen, among those that light the object.
TEST(LightLinks, ManyLightsAreChosenAmongThoseThatLight) {
  Scene linked(1), alone(0);
  for (int i = 0; i < 12; ++i) {
    linked.shine(panel(0.1 * i), i % 2 ? kA : kB);
    if (i % 2) alone.shine(panel(0.1 * i), 0);
  }
  expect_same(linked.samples(), alone.samples(), "six of twelve");
}

// Light is additive: with two lights, each linked to an object of two that light each other, the picture is the sum of
// those with one light each.
TEST(LightLinks, TwoLinkedLightsAreTheSumOfEach) {
  const auto render = [](bool first, bool second) {
    Scene scene(1);
    scene.put(testing::sphere_mesh(0.4f, 24, true), scene.material(matt({0.2f, 0.8f, 0.4f})), at(-0.3, 0.45, 0.5), 2);
    if (first) scene.shine(panel(), kA);
    if (second) scene.shine(testing::constant_dome(1, false), kB);
    PathTracer tracer(scene.snapshot(), {1.2, 1.5, 0.4});
    RunningStatistics means;
    uint32_t index = 0;
    for (int run = 0; run < testing::run_samples(256); ++run) {
      double sum = 0;
      for (int i = 0; i < 16; ++i) sum += double(tracer.trace(index++).color.g);
      means.add(sum / 16);
    }
    return means;
  };
  const RunningStatistics both = render(true, true), first = render(true, false), second = render(false, true);
  EXPECT_GT(first.mean(), 0.05);
  EXPECT_GT(second.mean(), 0.005);
  const double error =
      std::sqrt((both.variance() + first.variance() + second.variance()) / static_cast<double>(both.count()));
  EXPECT_TRUE(plausible(testing::z_test(both.mean(), error, first.mean() + second.mean())));
}

// A plate between floor and light that casts no shadow might as well not be there; one that does shades as ever.
TEST(ShadowLinks, UnlinkedObjectsCastNoShadow) {
  for (const float roughness : kRoughness) {
    for (const bool dome : {false, true}) {
      const LightParameters light = dome ? testing::constant_dome(1, false) : panel();
      const auto with_plate = [&](uint32_t set, uint32_t shadow_link) {
        Scene scene(3, glossy(roughness));
        scene.put(testing::plane_mesh(1), scene.material(matt(Rgb(0.0f))), at(-0.9, 1, -0.3), set);
        scene.shine(light, 0, shadow_link);
        return scene.samples();
      };
      Scene bare(3, glossy(roughness));
      bare.shine(light, 0, 0);
      const auto unshaded = bare.samples(), shaded = with_plate(2, 0);
      EXPECT_LT(sum_of(shaded), 0.97 * sum_of(unshaded)) << "roughness " << roughness;
      expect_same(with_plate(2, kA), unshaded, "the plate is in B alone");
      expect_same(with_plate(2, kB), shaded, "the plate casts the shadow");
      expect_same(with_plate(0, kB), unshaded, "nothing in front is in B");
    }
  }
}

TEST(ShadowLinks, EachLightHasItsOwn) {
  const auto render = [](bool first, bool second) {
    Scene scene(0, glossy(0.3f));
    scene.put(testing::plane_mesh(1), scene.material(matt(Rgb(0.0f))), at(-0.9, 1, -0.3), 1);
    scene.put(testing::plane_mesh(1), scene.material(matt(Rgb(0.0f))), at(-0.5, 0.8, 0.6), 2);
    if (first) scene.shine(panel(), 0, kA);
    if (second) scene.shine(panel(1), 0, kB);
    return scene.samples(1, 4096);
  };
  const double both = sum_of(render(true, true)), sum = sum_of(render(true, false)) + sum_of(render(false, true));
  EXPECT_NEAR(both / sum, 1, 0.02);
}

// The share of a partly opaque plate that is there, in the mean.
TEST(ShadowLinks, PartlyOpaqueCastersLetTheirShareThrough) {
  DisneyParameters veil = matt(Rgb(0.0f));
  veil.opacity = 0.4f;
  const auto mean = [&](uint32_t shadow_link, uint32_t veil_set) {
    Scene scene(0, glossy(0.4f));
    scene.put(testing::plane_mesh(9), scene.material(veil), at(0, 1, 0), veil_set);
    scene.put(testing::plane_mesh(9), scene.material(matt(Rgb(0.0f))), at(0, 1.2, 0), 2);
    scene.shine(panel(), 0, shadow_link);
    // From below the plates.
    PathTracer tracer(scene.snapshot(), {0.8, 0.9, 0.2});
    tracer.settings.max_depth = 1;
    double sum = 0;
    for (uint32_t i = 0; i < 4096; ++i) sum += double(tracer.trace(i).color.g);
    return sum / 4096;
  };
  const double clear = mean(kA, 0), veiled = mean(kA, 1);
  EXPECT_GT(clear, 0);
  EXPECT_NEAR(veiled / clear, 0.6, 0.02);
}

// The camera sees a light behind everything that stands before it, whatever casts its shadows.
TEST(ShadowLinks, DoNotCountForTheCamera) {
  Scene scene(0, matt(Rgb(0.0f)));
  LightParameters below = panel();
  below.light_to_world = at(0, 0, 0);
  below.light_to_world = Matrix4d().setAxisAngle(Vec3d(1, 0, 0), M_PI / 2) * at(0, -1, 0);
  below.visible_to_camera = true;
  scene.shine(below, 0, kA);
  EXPECT_EQ(sum_of(scene.samples()), 0);
  below.light_to_world = Matrix4d().setAxisAngle(Vec3d(1, 0, 0), M_PI / 2) * at(0, 0.5, 0);
  Scene before(0, matt(Rgb(0.0f)));
  before.shine(below, kB, kA);
  EXPECT_NEAR(sum_of(before.samples()) / 64, 3, 1e-4);
}

// A boundary that a body of higher priority hides is no surface: the light that a path meets behind it has been counted
// from the last surface, whatever casts its shadows.
TEST(ShadowLinks, AHiddenBoundaryIsNoSurfaceToCountLightFrom) {
  DisneyParameters glass = testing::clear_body(1.5f), core = testing::clear_body(1.2f);
  glass.priority = 2;
  core.priority = 1;
  const auto samples = [&](bool has_core) {
    Scene scene(3, glossy(0.3f));
    scene.put(testing::sphere_mesh(0.6f, 24, true), scene.material(glass), at(-0.5, 0.7, -0.2), 0);
    if (has_core) scene.put(testing::sphere_mesh(0.4f, 24, true), scene.material(core), at(-0.5, 0.7, -0.2), 0);
    scene.shine(panel(-0.8), 0, kA);
    return scene.samples(8);
  };
  const std::vector<Rgb> bare = samples(false);
  EXPECT_GT(sum_of(bare), 0);
  expect_same(samples(true), bare, "with a core that is not there");
}

// Nor is one that casts a shadow: paths find the light behind it.
TEST(ShadowLinks, AHiddenBoundaryTakesNoLight) {
  DisneyParameters tank = testing::clear_body(1), core = testing::clear_body(1.2f);
  tank.priority = 2;
  core.priority = 1;
  for (const float roughness : kRoughness) {
    const auto sum = [&](bool has_core, uint32_t core_set, uint32_t shadow_link) {
      Scene scene(3, glossy(roughness));
      scene.put(testing::sphere_mesh(9, 24, true), scene.material(tank), Matrix4d(), 3);
      if (has_core) scene.put(testing::sphere_mesh(0.6f, 24, true), scene.material(core), at(-0.9, 1, -0.3), core_set);
      scene.shine(panel(), 0, shadow_link);
      return sum_of(scene.samples(8, 8192));
    };
    const double bare = sum(false, 0, 0);
    EXPECT_GT(bare, 0);
    EXPECT_NEAR(sum(true, 1, 0) / bare, 1, 0.03) << "no link, roughness " << roughness;
    EXPECT_NEAR(sum(true, 1, kA) / bare, 1, 0.03) << "it casts the light's shadow, roughness " << roughness;
    EXPECT_NEAR(sum(true, 1, kB) / bare, 1, 0.03) << "it casts none, roughness " << roughness;
  }
}

DisneyParameters wax() {
  DisneyParameters p = matt(Rgb(0.8f));
  p.scatter_distance = Rgb(0.2f);
  return p;
}

TEST(LightLinks, LinksApplyWhereLightEntersABody) {
  const auto samples = [](uint32_t set, uint32_t link, bool other) {
    SceneBuilder b;
    b.description.category_sets = kSets;
    b.add(b.prototype(testing::sphere_mesh(1, 24, true)), b.material(wax()));
    b.description.instances.back().category_set = set;
    LightParameters light = panel();
    light.light_to_world = light.light_to_world * at(0, 1, 0);
    light.light_link = link;
    b.add(light);
    if (other) b.add(testing::constant_dome(2, false)), b.description.lights.back().light_link = kB;
    PathTracer tracer(b.snapshot(), {2, 3, 2});
    tracer.settings.max_depth = 3;
    std::vector<Rgb> colors;
    for (uint32_t i = 0; i < 64; ++i) colors.push_back(tracer.trace(i).color);
    return colors;
  };
  const auto plain = samples(0, 0, false);
  EXPECT_GT(sum_of(plain), 0);
  EXPECT_EQ(sum_of(samples(0, kA, false)), 0) << "a body of no category";
  EXPECT_EQ(sum_of(samples(0, kA, true)), 0);
  expect_same(samples(1, kA, true), plain, "the body is in A");
}

// A link that names everything is no link.
TEST(LightLinks, LinksOfAllObjectsChangeNoBit) {
  Scene linked(3, glossy(0.3f)), plain(0, glossy(0.3f));
  for (Scene* scene : {&linked, &plain}) {
    const uint32_t set = scene == &linked ? 3 : 0;
    scene->put(testing::sphere_mesh(0.4f, 24, true), scene->material(wax()), at(-0.3, 0.45, 0.5), set);
    scene->shine(panel(), scene == &linked ? kA : 0, scene == &linked ? kB : 0);
    scene->shine(testing::constant_dome(0.5f, false), scene == &linked ? kB : 0, scene == &linked ? kA : 0);
  }
  expect_same(linked.samples(4, 256), plain.samples(4, 256), "everything is in A and B");
}

}  // namespace
}  // namespace alabaster
