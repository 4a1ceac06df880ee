// Paths through clear bodies against slabs by hand.
#include "core/integrator/interface.h"

#include <gtest/gtest.h>

#include <cmath>

#include "testenv/support/path_tracer.h"
#include "testenv/support/z_test.h"

namespace alabaster {
namespace {

using testing::PathTracer;
using testing::RunningStatistics;
using testing::SceneBuilder;

DisneyParameters clear(float ior) {
  DisneyParameters p;
  p.base_color = Rgb(1.0f);
  p.spec_trans = 1;
  p.roughness = 0;
  p.ior = ior;
  return p;
}

DisneyParameters lamp(float radiance) {
  DisneyParameters p = testing::matt(Rgb(0.0f));
  p.emission = Rgb(radiance);
  return p;
}

/// A closed box of flat faces, in y from `bottom` to `top`.
Mesh slab_mesh(float bottom, float top, float half_width) {
  Cage cage;
  for (int i = 0; i < 8; ++i)
    cage.points.emplace_back(i & 1 ? half_width : -half_width, i & 2 ? top : bottom, i & 4 ? half_width : -half_width);
  cage.face_vertex_counts.assign(6, 4);
  cage.face_vertex_indices = {0, 2, 3, 1, 4, 5, 7, 6, 0, 1, 5, 4, 2, 6, 7, 3, 0, 4, 6, 2, 1, 3, 7, 5};
  return build_mesh(cage, {}, {});
}

RunningStatistics means(PathTracer* tracer, int channel, int runs = 256, int samples = 32) {
  RunningStatistics statistics;
  uint32_t index = 0;
  for (int r = 0; r < testing::run_samples(runs); ++r) {
    double sum = 0;
    for (int i = 0; i < samples; ++i) sum += double(tracer->trace(index++).color[channel]);
    statistics.add(sum / samples);
  }
  return statistics;
}

void expect_mean(PathTracer* tracer, int channel, double expected, const char* what) {
  const auto result = z_test(means(tracer, channel), expected, {.slack = 2e-4 * expected + 1e-6});
  EXPECT_TRUE(plausible(result)) << what;
}

/// A stack of layers: how much of the light that comes from below it passes and what it sends back, all reflections
/// counted (adding, without interference).
struct Stack {
  double passed = 1, reflected_above = 0, reflected_below = 0;

  void add(double reflectance, double transmittance) {
    const double echo = 1 / (1 - reflected_below * reflectance);
    reflected_above += passed * passed * reflectance * echo;
    const double below = reflectance + transmittance * transmittance * reflected_below * echo;
    passed *= transmittance * echo;
    reflected_below = below;
  }
  void boundary(double n1, double n2) {
    const double f = (n1 - n2) * (n1 - n2) / ((n1 + n2) * (n1 + n2));
    add(f, 1 - f);
  }
  void absorb(double transmittance) {
    // Light that turns back passes twice.
    reflected_below *= transmittance * transmittance;
    passed *= transmittance;
  }
};

/// A camera above that looks straight down, and a lamp below everything.
PathTracer look_down(SceneBuilder* b, float eye_height = 5) {
  b->add(b->prototype(testing::plane_mesh(40)), b->material(lamp(1)), Matrix4d().setTranslation(Vec3d(0, -10, 0)));
  PathTracer tracer(b->snapshot(), {0, eye_height, 0});
  tracer.settings.max_depth = 40;
  return tracer;
}

// A slab whose faces are doubled, or wind inward, is the same slab.
TEST(Interface, TheWindingOfAClosedMeshDoesNotMatter) {
  const auto seen = [](bool has_outward, bool has_inward) {
    const Mesh slab = slab_mesh(-0.2f, 0.3f, 2);
    Cage cage;
    cage.points = slab.points;
    for (const Corners& t : slab.triangles) {
      if (has_outward)
        cage.face_vertex_indices.insert(cage.face_vertex_indices.end(), {int(t[0]), int(t[1]), int(t[2])});
      if (has_inward)
        cage.face_vertex_indices.insert(cage.face_vertex_indices.end(), {int(t[0]), int(t[2]), int(t[1])});
    }
    cage.face_vertex_counts.assign(cage.face_vertex_indices.size() / 3, 3);
    const Mesh mesh = build_mesh(cage, {}, {});
    EXPECT_TRUE(mesh.closed);
    EXPECT_EQ(mesh.outward, !has_inward);
    SceneBuilder b;
    DisneyParameters glass = clear(1.5f);
    glass.attenuation_color = Rgb(0.5f);
    glass.attenuation_distance = 0.5f;
    b.add(b.prototype(mesh), b.material(glass)).add(testing::constant_dome(1, true));
    PathTracer tracer(b.snapshot(), {0.4, 3, 0.1});
    return means(&tracer, 1, 16).mean();
  };
  const double right = seen(true, false);
  EXPECT_GT(right, 0.3);
  EXPECT_LT(right, 0.7);
  EXPECT_NEAR(seen(false, true), right, 1e-5);
  EXPECT_NEAR(seen(true, true), right, 1e-5);
}

TEST(Interface, AnAbsorbingSlabFollowsBeerAndLambert) {
  SceneBuilder b;
  DisneyParameters glass = clear(1.5f);
  glass.attenuation_color = {1, 0.5f, 0.1f};
  glass.attenuation_distance = 0.5f;
  b.add(b.prototype(slab_mesh(-1.5f, 0.5f, 20)), b.material(glass));
  PathTracer tracer = look_down(&b);
  for (int c = 0; c < 3; ++c) {
    const double tau = std::pow(double(glass.attenuation_color[c]), 2 / 0.5);
    Stack stack;
    stack.boundary(1, 1.5);
    stack.absorb(tau);
    stack.boundary(1.5, 1);
    expect_mean(&tracer, c, stack.passed, "a slab two units thick");
  }
}

// baseColor is the colour of the whole body: its square root at each of two surfaces.
TEST(Interface, ABodyHasItsBaseColorOnceAndSoHasASheet) {
  for (const bool thin : {false, true}) {
    SceneBuilder b;
    DisneyParameters glass = clear(1.5f);
    glass.base_color = {1, 0.5f, 0.04f};
    glass.thin = thin;
    if (thin)
      b.add(b.prototype(testing::plane_mesh(20)), b.material(glass));
    else
      b.add(b.prototype(slab_mesh(-1, 0, 20)), b.material(glass));
    PathTracer tracer = look_down(&b);
    for (int c = 0; c < 3; ++c) {
      const double color = double(glass.base_color[c]), f = 0.04;
      const double echo = 1 / (1 - f * f);  // reflections inside are not tinted
      expect_mean(&tracer, c, (1 - f) * (1 - f) * echo * color, thin ? "sheet" : "slab");
    }
  }
}

struct Pool {
  uint32_t glass_priority, water_priority;
  double glass_ends;  // the depth of the boundary of glass and water
};

// Glass from 0 to -1, and water that begins at -0.9 inside it and ends at -2.
TEST(Interface, OverlappingDielectricsMeetWherePrioritySays) {
  for (const Pool& pool : {Pool{2, 1, 1.0}, Pool{1, 2, 0.9}, Pool{0, 0, 1.0}}) {
    SceneBuilder b;
    DisneyParameters glass = clear(1.8f), water = clear(1.33f);
    glass.attenuation_color = {0.5f, 1, 0.8f};
    water.attenuation_color = {1, 0.2f, 0.8f};
    glass.attenuation_distance = water.attenuation_distance = 1;
    glass.priority = pool.glass_priority;
    water.priority = pool.water_priority;
    b.add(b.prototype(slab_mesh(-1, 0, 20)), b.material(glass));
    b.add(b.prototype(slab_mesh(-2, -0.9f, 20)), b.material(water));
    PathTracer tracer = look_down(&b);
    for (int c = 0; c < 3; ++c) {
      Stack stack;
      stack.boundary(1, double(water.ior));
      stack.absorb(std::pow(double(water.attenuation_color[c]), 2 - pool.glass_ends));
      stack.boundary(double(water.ior), double(glass.ior));
      stack.absorb(std::pow(double(glass.attenuation_color[c]), pool.glass_ends));
      stack.boundary(double(glass.ior), 1);
      expect_mean(&tracer, c, stack.passed, pool.glass_priority ? "by priority" : "the smaller one");
    }
  }
}

TEST(Interface, ACameraMayStandInside) {
  SceneBuilder b;
  DisneyParameters water = clear(1.33f), glass = clear(1.5f);
  water.attenuation_color = Rgb(0.5f);
  water.attenuation_distance = 1;
  glass.attenuation_color = Rgb(0.25f);
  glass.attenuation_distance = 1;
  // A sea, and a pane in it below the camera.
  b.add(b.prototype(slab_mesh(-3, 20, 20)), b.material(water));
  b.add(b.prototype(slab_mesh(-1, 0, 10)), b.material(glass));
  PathTracer tracer = look_down(&b, 2);
  Stack stack;
  stack.boundary(1, 1.33);
  stack.absorb(0.25);
  stack.boundary(1.33, 1.5);
  stack.absorb(0.25);
  stack.boundary(1.5, 1.33);
  stack.absorb(0.25);
  // Light that the pane sends back upwards has far to go in water, which leaves 0.5^18 of it.
  expect_mean(&tracer, 1, stack.passed * 1.33 * 1.33, "radiance in water is n^2 times that in air");
}

TEST(Interface, NestedInteriorsAreFoundAtAPoint) {
  SceneBuilder b;
  b.add(b.prototype(slab_mesh(-3, 3, 20)), b.material(clear(1.33f)));
  b.add(b.prototype(slab_mesh(-1, 1, 10)), b.material(clear(1.5f)));
  b.add(b.prototype(slab_mesh(-0.5f, 0.5f, 0.1f)), b.material(clear(1.2f)));
  PathTracer tracer(b.snapshot(), {0, 5, 0});
  const auto index_at = [&](const Vec3f& p) {
    return interiors_at(tracer.context(), {p, {0, -1, 0}, 1e30f}, Seeker::path).index();
  };
  EXPECT_EQ(index_at({0, 4, 0}), 1);
  EXPECT_EQ(index_at({0, 2, 0}), 1.33f);
  EXPECT_EQ(index_at({0, 0.7f, 0}), 1.5f);
  EXPECT_EQ(index_at({0, 0, 0}), 1.2f);
  EXPECT_EQ(index_at({0, -0.7f, 0}), 1.5f);
  EXPECT_EQ(index_at({0, -2, 0}), 1.33f);
}

// There is no number of bodies within each other beyond which one is not noticed.
TEST(Interface, TheInnermostOfManyBodiesAbsorbs) {
  for (const int count : {7, 60}) {
    SceneBuilder b;
    for (int i = 0; i < count; ++i) {
      DisneyParameters p = clear(1);
      if (i == count - 1) p.attenuation_color = Rgb(0.5f), p.attenuation_distance = 2;
      const float half = static_cast<float>(count - i);
      b.add(b.prototype(slab_mesh(-half, half, 100 + half)), b.material(p));
    }
    b.add(testing::constant_dome(1, true));
    PathTracer tracer(b.snapshot(), {0, 200, 0});
    tracer.settings.max_depth = 1000;
    EXPECT_NEAR(tracer.trace(0).color.g, 0.5f, 1e-3f) << count;
  }
}

// A body of ior 1 is not seen: every sample is the background's.
TEST(Interface, IorOneIsNotSeen) {
  for (const bool thin : {false, true}) {
    SceneBuilder b;
    DisneyParameters p = clear(1);
    p.roughness = 0.6f;
    p.thin = thin;
    b.add(b.prototype(testing::sphere_mesh(1, 16, true)), b.material(p)).add(testing::constant_dome(0.75f, true));
    PathTracer tracer(b.snapshot(), {0, 0, 3});
    for (uint32_t i = 0; i < 64; ++i) EXPECT_EQ(tracer.trace(i).color, Rgb(0.75f));
  }
}

// A lossless body in a white furnace is not seen either. Rough facets lose what they hide from each other.
TEST(Interface, AClearBodyInAFurnace) {
  for (const float roughness : {0.0f, 0.3f}) {
    SceneBuilder b;
    DisneyParameters p = clear(1.5f);
    p.roughness = roughness;
    b.add(b.prototype(testing::sphere_mesh(1, 64, true)), b.material(p)).add(testing::constant_dome(1, true));
    PathTracer tracer(b.snapshot(), {1, 2, 3});
    tracer.settings.max_depth = 64;
    const auto energy = means(&tracer, 1);
    EXPECT_NEAR(energy.mean(), 1, roughness > 0 ? 0.03 : 1e-3) << roughness;
    EXPECT_LE(energy.mean(), 1 + 1e-3) << roughness;
  }
}

// A medium without loss, seen through a clear boundary: all light comes out again, past any number of inner
// reflections. Light that enters a blend by the entry lobe is multiplied by 41/42 once.
TEST(Interface, AScatteringMediumInAFurnace) {
  for (const float clear_share : {1.0f, 0.5f}) {
    SceneBuilder b;
    DisneyParameters p = clear(1.5f);
    p.spec_trans = clear_share;
    p.specular = clear_share == 1 ? 1 : 0;  // of the opaque share: its reflection is not subtracted from its base
    p.scatter_distance = Rgb(0.5f);
    b.add(b.prototype(testing::sphere_mesh(1, 32, true)), b.material(p)).add(testing::constant_dome(1, true));
    PathTracer tracer(b.snapshot(), {1, 2, 3});
    tracer.settings.max_depth = 64;
    const auto energy = means(&tracer, 1, 64, 32);
    std::cout << "scattering body, clear share " << clear_share << ": " << energy.mean() << " +- "
              << energy.standard_error() << "\n";
    EXPECT_TRUE(plausible(testing::at_most_test(energy, 1 + 1e-3)));
    EXPECT_GE(energy.mean(), (clear_share == 1 ? 0.995 : 0.98) - 4 * energy.standard_error());
  }
}

// With hardly any scattering the medium is clear: refraction in, a straight line, refraction out.
TEST(Interface, AMediumThatHardlyScattersIsClear) {
  SceneBuilder b;
  DisneyParameters p = clear(1.5f);
  p.scatter_distance = Rgb(1e5f);
  b.add(b.prototype(slab_mesh(-1, 0, 20)), b.material(p));
  PathTracer tracer = look_down(&b);
  Stack stack;
  stack.boundary(1, 1.5);
  stack.boundary(1.5, 1);
  expect_mean(&tracer, 1, stack.passed, "slab");
}

// The guides of a denoiser are those of what smooth glass shows.
TEST(Interface, GuidesAreSeenThroughSmoothGlass) {
  for (const bool smooth : {true, false}) {
    SceneBuilder b;
    DisneyParameters glass = clear(1.5f), floor = testing::matt({0.2f, 0.6f, 0.1f});
    glass.roughness = smooth ? 0.05f : 0.5f;
    glass.specular = 0;  // no path reflects
    b.add(b.prototype(slab_mesh(-1, 0, 20)), b.material(glass)).add(testing::constant_dome(1, false));
    b.add(b.prototype(testing::plane_mesh(40)), b.material(floor), Matrix4d().setTranslation(Vec3d(0, -2, 0)));
    PathTracer tracer(b.snapshot(), {0, 5, 0});
    tracer.aovs = kGuideAovs;
    EXPECT_NEAR(tracer.trace(0).albedo.g, smooth ? 0.6f : 1.0f, 0.05f) << smooth;
  }
}

// Each channel has an index of its own. Channels share no path, so each keeps its mean.
TEST(Interface, DispersionSpreadsTheIndexOverTheChannels) {
  SceneBuilder b;
  DisneyParameters glass = clear(2);
  glass.dispersion = 20;
  b.add(b.prototype(slab_mesh(-1, 0, 20)), b.material(glass));
  PathTracer tracer = look_down(&b);
  for (int c = 0; c < 3; ++c) {
    const double ior = 2 + (c - 1) * 0.025 * 20;
    Stack stack;
    stack.boundary(1, ior);
    stack.boundary(ior, 1);
    expect_mean(&tracer, c, stack.passed, "slab of index 1.5, 2 and 2.5");
  }
}

// A lamp in absorbing water lights a floor there: the same through light sampling, which a small lamp needs, and
// through sampled lobes, whatever the lamp is made of.
TEST(Interface, LightInsideAMediumIsAbsorbed) {
  double mean[2][2];
  for (const bool absorbs : {false, true})
    for (const bool mesh : {false, true}) {
      SceneBuilder b;
      DisneyParameters water = clear(1.33f);
      water.attenuation_color = Rgb(0.25f);
      water.attenuation_distance = absorbs ? 2.0f : 0.0f;
      b.add(b.prototype(slab_mesh(-1, 20, 20)), b.material(water));
      b.add(b.prototype(testing::plane_mesh(8)), b.material(testing::matt(Rgb(0.5f))));
      if (mesh) {
        b.add(b.prototype(testing::sphere_mesh(0.1f, 24, false)), b.material(lamp(10)),
              Matrix4d().setTranslation(Vec3d(0, 2, 0)));
      } else {
        LightParameters light;
        light.type = LightType::sphere;
        light.radius = 0.1f;
        light.intensity = 10;
        light.light_to_world = Matrix4d().setTranslation(Vec3d(0, 2, 0));
        b.add(light);
      }
      PathTracer tracer(b.snapshot(), {1.5, 1, 0});
      tracer.settings.max_depth = 1;
      mean[absorbs][mesh] = means(&tracer, 1, 64, 32).mean();
    }
  const double from_camera = std::hypot(1.5, 1.0);
  for (const bool mesh : {false, true})
    EXPECT_NEAR(mean[1][mesh] / mean[0][mesh], std::pow(0.5, from_camera + 1.9), 0.01) << mesh;
  EXPECT_NEAR(mean[1][0], mean[1][1], 0.03 * mean[1][0]);
}

// Light sampling and lobe sampling find the same light through a rough boundary and on the far side of a leaf.
TEST(Interface, LightsBehindAreSampled) {
  for (const bool leaf : {false, true}) {
    double mean[2];
    for (const bool lights_are_meshes : {true, false}) {
      SceneBuilder b;
      DisneyParameters p = clear(1.5f);
      p.roughness = 0.7f;
      p.thin = true;
      if (leaf) p.spec_trans = 0, p.diff_trans = 1.5f, p.ior = 1, p.diff_trans_color = {0.2f, 0.6f, 0.1f};
      b.add(b.prototype(testing::plane_mesh(20)), b.material(p));
      if (lights_are_meshes) {
        b.add(b.prototype(testing::plane_mesh(2)), b.material(lamp(3)), Matrix4d().setTranslation(Vec3d(1, -2, 0)));
      } else {
        LightParameters light;
        light.type = LightType::rect;
        light.width = light.height = 2;
        light.intensity = 3;
        light.light_to_world =
            Matrix4d().setAxisAngle(Vec3d(1, 0, 0), M_PI / 2) * Matrix4d().setTranslation(Vec3d(1, -2, 0));
        b.add(light);
      }
      PathTracer tracer(b.snapshot(), {0, 3, 0});
      const auto found = means(&tracer, 1);
      mean[lights_are_meshes] = found.mean();
      EXPECT_LT(found.standard_error(), 0.01 * found.mean()) << "the lamp is found by light sampling";
      EXPECT_GT(found.mean(), 0.01);
    }
    EXPECT_NEAR(mean[0], mean[1], 0.03 * mean[0]) << leaf;
  }
}

// A boundary that a body of higher priority hides is no surface: no light falls from it on what stands in the outer
// body, nor on what stands in both.
TEST(Interface, AHiddenBoundaryDoesNotEmit) {
  for (const uint32_t priority : {1u, 3u})
    for (const float floor : {1.0f, 40.0f}) {  // within the inner body, and through its wall
      SceneBuilder b;
      DisneyParameters outer = clear(1), inner = clear(1);
      outer.priority = 2;
      inner.priority = priority;
      inner.emission = Rgb(1.0f);
      b.add(b.prototype(slab_mesh(-20, 20, 30)), b.material(outer));
      b.add(b.prototype(slab_mesh(-2, 3, 2)), b.material(inner));
      b.add(b.prototype(testing::plane_mesh(floor)), b.material(testing::matt(Rgb(0.5f))));
      // Below the inner body's top, or beside it.
      PathTracer tracer(b.snapshot(), floor < 2 ? Vec3d(0, 2, 0.1) : Vec3d(6, 5, 0),
                        floor < 2 ? Vec3d(0) : Vec3d(6, 0, 0.1));
      const double light = means(&tracer, 1, 16).mean();
      if (priority < 2)
        EXPECT_EQ(light, 0) << floor;
      else
        EXPECT_GT(light, 0.01) << floor;
    }
}

// The camera stands in a body that lets the inner one's boundary be no boundary: its far plane counts behind it, too.
TEST(Interface, TheFarPlaneCountsBehindAHiddenBoundary) {
  SceneBuilder b;
  DisneyParameters outer = clear(1), inner = clear(1.5f);
  outer.priority = 2;
  inner.priority = 1;
  b.add(b.prototype(slab_mesh(-20, 20, 30)), b.material(outer));
  b.add(b.prototype(slab_mesh(-1, 1, 3)), b.material(inner));
  PathTracer tracer = look_down(&b);
  EXPECT_EQ(tracer.trace(0).color, Rgb(1.0f)) << "the lamp is at 15";
  tracer.reach = 15.5f;
  EXPECT_EQ(tracer.trace(0).color, Rgb(1.0f));
  tracer.reach = 14.5f;
  EXPECT_EQ(tracer.trace(0).color, Rgb(0.0f));
}

// The distance is that from the camera, through both hidden boundaries of the inner body: it decides which sample of a
// pixel is closest, whose depth, position, motion and ids the pixel shows.
TEST(Interface, TheFirstHitBehindHiddenBoundariesHasItsDistanceFromTheCamera) {
  for (const uint32_t inner_priority : {0u, 1u, 3u}) {
    SceneBuilder b;
    DisneyParameters outer = clear(1), inner = clear(1);
    outer.priority = 2;
    inner.priority = inner_priority;
    b.add(b.prototype(slab_mesh(-20, 20, 30)), b.material(outer));
    b.add(b.prototype(slab_mesh(-1, 1, 3)), b.material(inner));
    PathTracer tracer = look_down(&b);
    tracer.aovs = kClosestAovs & ~kVectorAovs;
    const FilmSample sample = tracer.trace(0);
    const float expected = inner_priority > outer.priority ? 4 : 15;
    EXPECT_NEAR(sample.distance, expected, 1e-4) << inner_priority;
    EXPECT_NEAR(sample.camera_depth, expected, 1e-4) << inner_priority;
  }
}

// A pane of index 1 halves all light that comes through it, whatever the light is like and however it is found; one of
// opacity .5 lets a half by beside it.
TEST(Interface, LightGoesStraightOnThroughSheets) {
  const auto above = [](LightType type, float size) {
    LightParameters light;
    light.type = type;
    light.radius = light.width = light.height = size;
    light.angle = 60 * size;
    light.intensity = 5;
    light.light_to_world =
        Matrix4d().setAxisAngle(Vec3d(1, 0, 0), -M_PI / 2) * Matrix4d().setTranslation(Vec3d(0.3, 2.5, 0.2));
    return light;
  };
  const LightParameters lamps[] = {above(LightType::distant, 0),   above(LightType::distant, 0.5f),
                                   above(LightType::sphere, 0.1f), above(LightType::sphere, 0.8f),
                                   above(LightType::rect, 1.5f),   testing::constant_dome(1, true)};
  const auto floor = [&](size_t which, float opacity, bool pane) {
    SceneBuilder b;
    DisneyParameters sheet = testing::matt(Rgb(0.5f));
    sheet.thin = true, sheet.spec_trans = 1, sheet.opacity = opacity;
    b.add(b.prototype(testing::plane_mesh(20)), b.material(testing::matt(Rgb(0.5f))));
    if (pane)
      b.add(b.prototype(testing::plane_mesh(20)), b.material(sheet), Matrix4d().setTranslation(Vec3d(0.37, 1, 0.11)));
    if (which < std::size(lamps)) {
      b.add(lamps[which]);
    } else {
      DisneyParameters ember = testing::matt(Rgb(0.0f));
      ember.emission = Rgb(4.0f);
      b.add(b.prototype(testing::sphere_mesh(0.5f, 12, true)), b.material(ember),
            Matrix4d().setTranslation(Vec3d(0.3, 2.5, 0.2)));
    }
    PathTracer tracer(b.snapshot(), {0, 0.5, 0.3});
    tracer.settings.max_depth = 1;  // a pane is no bounce
    testing::RunningStatistics light;
    for (uint32_t i = 0; i < testing::run_samples(20000u); ++i) light.add(double(tracer.trace(i).color.g));
    return light;
  };
  for (size_t which = 0; which <= std::size(lamps); ++which) {
    const auto bare = floor(which, 1, false);
    for (const float opacity : {1.0f, 0.5f}) {
      const auto through = floor(which, opacity, true);
      const double expected = bare.mean() * (opacity < 1 ? 0.75 : 0.5);
      EXPECT_NEAR(through.mean(), expected, 5 * (through.standard_error() + bare.standard_error()) + 2e-3 * expected)
          << "lamp " << which << ", opacity " << opacity;
    }
  }
}

}  // namespace
}  // namespace alabaster
