#include "core/integrator/see_through.h"

#include <gtest/gtest.h>

#include <cmath>

#include "testenv/support/material_testing.h"
#include "testenv/support/memory_texture.h"
#include "testenv/support/path_tracer.h"
#include "testenv/support/z_test.h"

namespace alabaster {
namespace {

using testing::PathTracer;
using testing::RunningStatistics;
using testing::SceneBuilder;

DisneyParameters film(float opacity) {
  DisneyParameters p = testing::matt(Rgb(0.0f));
  p.opacity = opacity;
  return p;
}

// Moved aside, so that no ray meets the edge between two triangles, of which both would count.
Matrix4d at_height(double y) {
  return Matrix4d().setTranslation(Vec3d(0.37, y, 0.11));
}

RunningStatistics greens(PathTracer* tracer, uint32_t samples) {
  RunningStatistics statistics;
  for (uint32_t i = 0; i < testing::run_samples(samples); ++i) statistics.add(double(tracer->trace(i).color.g));
  return statistics;
}

// Black films before a white sky pass the product of their transmittances.
TEST(SeeThrough, LayersMultiply) {
  SceneBuilder b;
  const auto plane = b.prototype(testing::plane_mesh(4));
  double passes = 1;
  for (const float opacity : {0.5f, 0.25f, 0.1f}) {
    b.add(plane, b.material(film(opacity)), at_height(-passes));
    passes *= 1 - double(opacity);
  }
  b.add(testing::constant_dome(1, true));
  PathTracer tracer(b.snapshot(), {0.3, 3, 0.2});
  const auto result = z_test(greens(&tracer, 20000), passes);
  EXPECT_TRUE(plausible(result));
}

// A sun through films over a matt plane: shadows have no noise, for the share is computed, not drawn.
TEST(SeeThrough, ShadowsHaveTheShareThatPasses) {
  const auto lit = [](const std::vector<float>& opacities) {
    SceneBuilder b;
    b.add(b.prototype(testing::plane_mesh(2)), b.material(testing::matt(Rgb(0.8f))));
    const auto plane = b.prototype(testing::plane_mesh(8));
    double height = 4;
    for (const float opacity : opacities) b.add(plane, b.material(film(opacity)), at_height(height += 1));
    LightParameters sun;
    sun.type = LightType::distant;
    sun.angle = 0;
    sun.light_to_world = Matrix4d().setAxisAngle(Vec3d(1, 0, 0), -M_PI / 2);
    b.add(sun);
    PathTracer tracer(b.snapshot(), {0.3, 3, 0.2});
    tracer.settings.max_depth = 1;
    return tracer.trace(0).color.g;
  };
  const float open = lit({});
  ASSERT_GT(open, 0);
  EXPECT_NEAR(lit({0.5f, 0.25f, 0.1f}) / open, 0.5f * 0.75f * 0.9f, 1e-6f);
  EXPECT_EQ(lit({0.5f, 0.25f, 0.1f}), lit({0.1f, 0.5f, 0.25f})) << "in whatever order";
  EXPECT_EQ(lit({0.0f}), open);
  EXPECT_EQ(lit({0.5f, 1.0f}), 0);
}

TEST(SeeThrough, AThresholdCutsOut) {
  const auto image = std::make_shared<testing::MemoryTexture>(1, std::vector<Rgb>{Rgb(0.6f)});
  DisneyMaterial material;
  testing::connect("opacity", image, &material, Channel::r);
  Mesh mesh;
  const HitPrimvars at(mesh, TriangleHit(), {0, 0});
  EXPECT_TRUE(material.is_partly_opaque());
  EXPECT_EQ(material.coverage(at), 0.6f);
  material.constants.opacity_threshold = 0.5f;
  EXPECT_EQ(material.coverage(at), 1);
  material.constants.opacity = 0.5f;
  EXPECT_EQ(material.coverage(at), 0);
}

// A single-sided plane: from its front the plane, from behind the sky; it shades neither what lies before nor behind.
TEST(SeeThrough, SingleSidedFacesAreNotThereFromBehind) {
  const auto seen = [](double eye_height, bool double_sided, const DisneyParameters& p, bool mirrored) {
    SceneBuilder b;
    const Matrix4d transform = mirrored ? Matrix4d().setScale(Vec3d(-1, 1, 1)) : Matrix4d();
    b.add(b.prototype(testing::plane_mesh(2)), b.material(p), transform);
    b.description.instances[0].options.double_sided = double_sided;
    b.add(testing::constant_dome(1, true));
    PathTracer tracer(b.snapshot(), {0.1, eye_height, 0});
    tracer.settings.max_depth = 0;
    return tracer.trace(0).color.g;
  };
  const DisneyParameters black = testing::matt(Rgb(0.0f));
  for (const bool mirrored : {false, true}) {
    EXPECT_EQ(seen(3, false, black, mirrored), 0) << mirrored;
    EXPECT_EQ(seen(-3, false, black, mirrored), 1) << mirrored;
    EXPECT_EQ(seen(-3, true, black, mirrored), 0) << mirrored;
  }
}

TEST(SeeThrough, AClosedMeshCostsNothingSingleSided) {
  SceneBuilder b;
  Mesh sphere = testing::sphere_mesh(1, 8, false);
  sphere.outward = true;
  b.add(b.prototype(std::move(sphere)), b.material({}));
  b.description.instances[0].options.double_sided = false;
  EXPECT_FALSE(b.snapshot()->features.see_through) << "only its front can be seen";
  DisneyParameters glass;
  glass.spec_trans = 1;
  b.description.instances[0].materials.push_back(b.material(glass));
  EXPECT_TRUE(b.snapshot()->features.see_through) << "light comes in through the glass";
}

/// Black on the left, white on the right.
class StepTexture final : public Texture {
 public:
  Rgb rgb(const Vec2f& uv) const override { return Rgb(uv.x < 0.5f ? 0.0f : 1.0f); }
  int width() const override { return 2; }
  int height() const override { return 1; }
  size_t memory_bytes() const override { return 0; }
  Rgb texel(int x, int) const override { return Rgb(static_cast<float>(x)); }
};

// A textured quad whose right half glows lights a plane as a glowing quad of half the size there does; with half the
// opacity it gives half.
TEST(TexturedEmission, LightsAsTheGlowingPartAlone) {
  const auto plane_under = [](bool textured, float opacity) {
    SceneBuilder b;
    b.add(b.prototype(testing::plane_mesh(4)), b.material(testing::matt(Rgb(0.8f))));
    Mesh quad = testing::plane_mesh(2);
    quad.uv_sets.push_back({{}, "st"});
    for (const Vec3f& p : quad.points) quad.uv_sets[0].values.emplace_back(0.5f + 0.5f * p.x, 0.5f + 0.5f * p.z);
    auto glow = std::make_shared<DisneyMaterial>();
    glow->constants = testing::matt(Rgb(0.0f));
    glow->constants.emission = Rgb(2.0f);
    glow->constants.opacity = opacity;
    Matrix4d place = at_height(1.5);
    if (textured) {
      testing::connect("emission", std::make_shared<StepTexture>(), glow.get());
    } else {
      place = Matrix4d().setScale(Vec3d(0.5, 1, 1)) * Matrix4d().setTranslation(Vec3d(0.5, 0, 0)) * place;
    }
    b.add(b.prototype(std::move(quad)), glow, place);
    PathTracer tracer(b.snapshot(), {0.3, 0.7, 0.2});
    tracer.settings.max_depth = 1;
    return greens(&tracer, 20000);
  };
  const RunningStatistics half = plane_under(false, 1);
  ASSERT_GT(half.mean(), 0.1);
  for (const float opacity : {1.0f, 0.5f}) {
    const RunningStatistics textured = plane_under(true, opacity);
    const double error = std::hypot(textured.standard_error(), opacity * half.standard_error());
    EXPECT_TRUE(plausible(testing::z_test(textured.mean(), error, opacity * half.mean()))) << opacity;
  }
}

// What a sheet passes of the sun, on the ground and by itself, and that it is there as glass is.
TEST(TransparentSheet, LightsTheGroundAndIsSeenAsGlassIs) {
  const auto ground = [](float opacity, bool textured, float threshold, float* alpha) {
    SceneBuilder b;
    b.add(b.prototype(testing::plane_mesh(8)), b.material(testing::matt(Rgb(0.8f))));
    auto glass = std::make_shared<DisneyMaterial>();
    glass->constants.opacity_mode = OpacityMode::transparent;
    glass->constants.base_color = Rgb(0.0f), glass->constants.roughness = 0.05f;
    glass->constants.opacity = textured ? 1 : opacity;
    glass->constants.opacity_threshold = threshold;
    if (textured)
      testing::connect("opacity", std::make_shared<testing::MemoryTexture>(1, std::vector{Rgb(opacity)}), glass.get(),
                       Channel::r);
    glass->settle_opacity_mode();
    if (opacity < 2) b.add(b.prototype(testing::plane_mesh(8)), glass, at_height(1));
    LightParameters sun;
    sun.type = LightType::distant;
    sun.angle = 0;
    sun.light_to_world = Matrix4d().setAxisAngle(Vec3d(1, 0, 0), -M_PI / 2);
    b.add(sun);
    const auto scene = b.snapshot();
    PathTracer below(scene, {0.3, 0.7, 0.2}), above(scene, {0.3, 5, 0.2});
    below.settings.max_depth = 1;
    above.aovs |= aov_bit(Aov::depth);
    const FilmSample seen = above.trace(0);
    *alpha = seen.alpha;
    EXPECT_NEAR(seen.distance, threshold > 0 || opacity > 1 ? 5 : 4, 0.02);
    return double(below.trace(0).color.g);
  };
  float alpha = 0;
  const double bare = ground(2, false, 0, &alpha);
  ASSERT_GT(bare, 0.1);
  for (const bool textured : {false, true}) {
    EXPECT_NEAR(ground(0.4f, textured, 0, &alpha), bare * 0.6 * 0.96, 0.003 * bare) << textured;
    EXPECT_EQ(alpha, 1);
    EXPECT_EQ(ground(0.4f, textured, 0.5f, &alpha), bare) << "cut out by the threshold";
  }
}

// A plane below a glowing mesh of two materials, which faces away: each material that has a back gives its half.
TEST(SidesOfMaterials, DecideOnEmissionBeforeTheMesh) {
  const auto plane_under = [](Sides first, Sides second, bool double_sided) {
    SceneBuilder b;
    b.add(b.prototype(testing::plane_mesh(4)), b.material(testing::matt(Rgb(0.8f))));
    DisneyParameters glow = testing::matt(Rgb(0.0f));
    glow.emission = Rgb(2.0f);
    glow.sides = first;
    Mesh quad = testing::plane_mesh(2);
    quad.triangle_material = {0, 1};
    b.add(b.prototype(std::move(quad)), b.material(glow), at_height(1.5));
    glow.sides = second;
    b.description.instances.back().materials.push_back(b.material(glow));
    b.description.instances.back().options.double_sided = double_sided;
    PathTracer tracer(b.snapshot(), {0.3, 0.7, 0.2});
    tracer.settings.max_depth = 1;
    return greens(&tracer, 20000);
  };
  const RunningStatistics whole = plane_under(Sides::both, Sides::mesh, true);
  const RunningStatistics left = plane_under(Sides::both, Sides::front, true);
  const RunningStatistics right = plane_under(Sides::mesh, Sides::both, false);
  ASSERT_GT(std::min(left.mean(), right.mean()), 0.1);
  const double error = std::hypot(std::hypot(left.standard_error(), right.standard_error()), whole.standard_error());
  EXPECT_TRUE(plausible(testing::z_test(left.mean() + right.mean(), error, whole.mean())));
  EXPECT_EQ(plane_under(Sides::both, Sides::mesh, false).mean(), left.mean());
  EXPECT_EQ(plane_under(Sides::front, Sides::mesh, false).mean(), 0);
  EXPECT_EQ(plane_under(Sides::mesh, Sides::mesh, true).mean(), whole.mean());
}

}  // namespace
}  // namespace alabaster
