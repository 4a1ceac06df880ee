#include "core/material/microfacet.h"

#include <gtest/gtest.h>

#include "core/material/fresnel.h"
#include "core/sampling/warp.h"
#include "testenv/support/chi_square.h"

namespace alabaster {
namespace {

using testing::integrate_sphere;
using testing::uniform2;

Vec3f spherical(float theta, float phi) {
  return {std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta)};
}

float visible_pdf(const Ggx& ggx, const Vec3f& wo, const Vec3f& wm) {
  return ggx.d(wm) * ggx.g1_over_cos(wo) * std::max(0.0f, dot(wo, wm));
}

// The solid angle that a warp makes of a unit of area at `u`: one over the pdf of its samples.
template <class Warp>
double solid_angle_at(const Warp& warp, const Vec2f& u) {
  constexpr float kStep = 4e-3f;
  const auto slope = [&](const Vec2f& by) { return Vec3d(warp(u + by) - warp(u - by)) * (0.5 / kStep); };
  return length(cross(slope({kStep, 0}), slope({0, kStep})));
}

const Ggx kGgx[] = {{1, 1}, {0.3f, 0.3f}, {0.05f, 0.05f}, {0.4f, 0.04f}, {3.1f, 0.31f}};

TEST(Fresnel, SchlickEndsAndClamps) {
  EXPECT_EQ(schlick_weight(1), 0);
  EXPECT_EQ(schlick_weight(0), 1);
  EXPECT_EQ(schlick_weight(1.0001f), 0);
  EXPECT_EQ(schlick_weight(-0.0001f), 1);
  EXPECT_FLOAT_EQ(schlick_weight(0.5f), 1.0f / 32);
  EXPECT_EQ(f0_from_ior(1), 0);
  EXPECT_FLOAT_EQ(f0_from_ior(1.5f), 0.04f);
  const Rgb f = schlick({0.1f, 0.2f, 0.3f}, {1, 0.5f, 0.3f}, 0);
  EXPECT_EQ(f, Rgb(1, 0.5f, 0.3f));
}

TEST(Fresnel, TintHasLuminanceOne) {
  const Rgb t = tint({0.2f, 0.5f, 0.9f});
  EXPECT_NEAR(0.3f * t.r + 0.6f * t.g + 0.1f * t.b, 1, 1e-6);
  EXPECT_EQ(tint(Rgb(0.0f)), Rgb(1.0f));
}

TEST(Microfacet, FacetOfOppositeDirectionsIsRefused) {
  const Vec3f w = spherical(0.7f, 0.3f);
  EXPECT_FALSE(mirror_facet(w, -w).has_value());
  const auto facet = mirror_facet(w, {0, 0, 1});
  ASSERT_TRUE(facet.has_value());
  const Vec3f mirrored = reflect_about(w, facet->wm);
  EXPECT_NEAR(facet->cos_d, dot(w, facet->wm), 1e-6);
  EXPECT_NEAR(length(mirrored - Vec3f(0, 0, 1)), 0, 1e-6);
}

// Int D(wm) wm.z dwm = 1: the projected area of the facets is that of the surface.
TEST(Microfacet, ProjectedAreaIsOne) {
  for (const Ggx& ggx : kGgx) {
    const auto area = [&](const Vec3f& w) { return w.z > 0 ? double(ggx.d(w)) * double(w.z) : 0; };
    EXPECT_NEAR(integrate_sphere(area, {}, 4), 1, 2e-4) << ggx.alpha_x << " " << ggx.alpha_y;
  }
  for (float alpha : {0.1f, 0.03f, 0.001f}) {
    const Gtr1 gtr1{alpha};
    EXPECT_NEAR(integrate_sphere([&](const Vec3f& w) { return double(gtr1.d(w) * std::max(0.0f, w.z)); }, {}, 8), 1,
                2e-4)
        << alpha;
  }
  // The sharpest lobe too, in the finest bins.
  const Ggx sharpest{kMinAlpha, kMinAlpha};
  const auto area = [&](const Vec3f& w) { return w.z > 0 ? double(sharpest.d(w)) * double(w.z) : 0; };
  EXPECT_NEAR(integrate_sphere(area, {}, 12), 1, 1e-3);
}

// Int D G1(wo) max(0, wo.wm) dwm = wo.z: masking is the one and only that makes the visible area right (Heitz 2014,
// eq. 18). A G1 of another distribution or of the wrong alpha fails this.
TEST(Microfacet, MaskingConservesVisibleArea) {
  for (const Ggx& ggx : kGgx) {
    for (float theta : {0.0f, 0.9f, 1.5f}) {
      const Vec3f wo = spherical(theta, 0.8f);
      const auto visible = [&](const Vec3f& wm) { return double(visible_pdf(ggx, wo, wm)); };
      EXPECT_NEAR(integrate_sphere(visible, {}, 4), 1, 5e-4) << ggx.alpha_x << " " << ggx.alpha_y << " at " << theta;
      EXPECT_LE(wo.z * ggx.g1_over_cos(wo), 1 + 1e-6f);
    }
  }
}

TEST(Microfacet, SamplesFollowTheirPdf) {
  Rng rng(11, 3);
  const auto inner = [&] { return Vec2f(0.05f + 0.9f * rng.uniform(), 0.05f + 0.9f * rng.uniform()); };
  for (const Ggx& ggx : kGgx)
    for (int i = 0; i < 2000; ++i) {
      const Vec3f wo = sample_cosine_hemisphere(uniform2(rng));
      const Vec2f u = inner();
      const double pdf = visible_pdf(ggx, wo, ggx.sample(wo, u));
      EXPECT_NEAR(pdf * solid_angle_at([&](const Vec2f& at) { return ggx.sample(wo, at); }, u), 1, 0.02);
    }
  for (float alpha : {0.1f, 0.01f, 0.001f}) {
    const Gtr1 gtr1{alpha};
    for (int i = 0; i < 2000; ++i) {
      const Vec2f u = inner();
      const Vec3f wm = gtr1.sample(u);
      const double pdf = gtr1.d(wm) * wm.z;
      EXPECT_NEAR(pdf * solid_angle_at([&](const Vec2f& at) { return gtr1.sample(at); }, u), 1, 0.02);
    }
  }
}

TEST(Microfacet, FiniteAtTheEdges) {
  for (const Ggx& ggx : {Ggx{kMinAlpha, kMinAlpha}, Ggx{3.2f, 0.32f}, Ggx{kMinAlpha, 1}}) {
    for (float z : {1.0f, 1e-3f, 1e-10f, 1e-30f, 1e-44f}) {
      const Vec3f wo(std::sqrt(1 - z * z), 0, z);
      EXPECT_TRUE(std::isfinite(ggx.g1_over_cos(wo)));
      for (const Vec2f& u : {Vec2f(0, 0), Vec2f(kOneMinusEpsilon, kOneMinusEpsilon), Vec2f(0.5f, 0.25f),
                             Vec2f(kOneMinusEpsilon, 0.5f), Vec2f(0, kOneMinusEpsilon)}) {
        const Vec3f wm = ggx.sample(wo, u);
        EXPECT_TRUE(is_finite(wm));
        EXPECT_NEAR(length(wm), 1, 1e-5);
        EXPECT_TRUE(std::isfinite(visible_pdf(ggx, wo, wm)));
      }
    }
  }
}

}  // namespace
}  // namespace alabaster
