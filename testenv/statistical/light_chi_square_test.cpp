// Every light draws directions from the pdf it states, as seen from near, far, inside and grazing points.
#include <gtest/gtest.h>

#include <numeric>

#include "core/light/light_set.h"
#include "testenv/support/chi_square.h"
#include "testenv/support/memory_texture.h"

namespace alabaster::testing {
namespace {

constexpr int kTests = 24;  // in this file

struct View {
  const char* name;
  Vec3f p;
  double pole_exponent = 1;  // of the bins, about `towards`
  Vec3f towards{0, 0, 1};
};

template <class L>
void check(const L& light, const View& view, uint64_t seed) {
  const auto sample = [&](Rng& rng) -> std::optional<Vec3f> {
    const auto s = light.sample(view.p, uniform2(rng));
    if (!s) return std::nullopt;
    return s->wi;
  };
  const auto pdf = [&](const Vec3f& w) {
    const auto hit = light.intersect({view.p, w});
    return hit ? hit->pdf : 0.0f;
  };
  ChiSquareOptions options{.bins_x = 18, .bins_y = 18, .samples = 60000, .seed = seed, .number_of_tests = kTests};
  options.frame = frame_from_normal(normalize(view.towards));
  options.pole_exponent = view.pole_exponent;
  const auto r = chi_square_sphere(sample, pdf, options);
  EXPECT_TRUE(r.passed) << view.name << '\n' << r.report;
}

LightDescription described(LightType type) {
  LightDescription d;
  d.type = type;
  return d;
}

TEST(LightChiSquare, Rect) {
  LightDescription d = described(LightType::rect);
  d.width = 2;
  const RectLight light(d, Vec3d(0, 0, 0));
  uint64_t seed = 10;
  for (const View& view :
       {View{"near", {0.2f, 0.1f, -0.3f}}, View{"beside", {1.5f, -0.2f, -0.4f}},
        View{"grazing", {0, 0.7f, -0.05f}, 1, {0, -1, 0.2f}}, View{"far", {40, 10, -70}, 8, {-40, -10, 70}},
        View{"so far that it is sampled by area", {400, 0, -400}, 10, {-400, 0, 400}}})
    check(light, view, seed++);
}

TEST(LightChiSquare, ShearedRectIsSampledByArea) {
  LightDescription d = described(LightType::rect);
  d.light_to_world = Matrix4d(1, 0, 0, 0, 0.8, 1, 0, 0, 0, 0.3, 2, 0, 0, 0, 0, 1);
  const RectLight light(d, Vec3d(0, 0, 0));
  check(light, {"near", {0.2f, 0.1f, -0.5f}}, 20);
  check(light, {"beside", {1.5f, -0.2f, -0.8f}}, 21);
}

TEST(LightChiSquare, Sphere) {
  const SphereLight light(described(LightType::sphere), Vec3d(0, 0, 0));
  uint64_t seed = 30;
  for (const View& view : {View{"near", {0, 0.1f, -0.52f}}, View{"at a distance", {1, 2, 3}, 3, {-1, -2, -3}},
                           View{"far", {100, 200, -300}, 10, {-100, -200, 300}}, View{"inside", {0.1f, -0.3f, 0.2f}}})
    check(light, view, seed++);
}

TEST(LightChiSquare, SphereWithSpotCone) {
  LightDescription d = described(LightType::sphere);
  d.cone_inner = 10;
  d.cone_outer = 25;
  const SphereLight light(d, Vec3d(0, 0, 0));
  check(light, {"inside the cone", {0.1f, 0, -1.2f}}, 40);
  check(light, {"partly outside", {0.5f, 0, -1.2f}}, 41);
}

TEST(LightChiSquare, Distant) {
  LightDescription d = described(LightType::distant);
  d.light_to_world = Matrix4d(1, 0, 0, 0, 0, 0, 1, 0, 0, -1, 0, 0, 5, 5, 5, 1);
  uint64_t seed = 50;
  for (float angle : {0.53f, 40.0f, 220.0f}) {
    d.angle = angle;
    check(DistantLight(d, Vec3d(0, 0, 0)), {"", {1, 2, 3}, angle < 1 ? 6.0 : 1.0, {0, -1, 0}}, seed++);
  }
}

TEST(LightChiSquare, Dome) {
  LightDescription d = described(LightType::dome);
  check(DomeLight(d, Vec3d(0, 0, 0)), {"constant", {0, 0, 0}}, 60);
  // Black regions, a bright pole, a steep sun, and edges that differ.
  std::vector<Rgb> texels(size_t{12} * 6, Rgb(0.0f));
  for (size_t i = 0; i < 12; ++i) texels[i] = Rgb(static_cast<float>(i + 1), 1, 2);
  texels[12 * 3 + 11] = Rgb(5, 0, 0);
  texels[12 * 2 + 4] = Rgb(60, 50, 40);
  texels[12 * 5 + 2] = Rgb(0, 0, 30);
  d.texture = std::make_shared<MemoryTexture>(12, texels);
  // Bins aligned with the rows' pole, or the cells' edges cost the quadrature too much.
  check(DomeLight(d, Vec3d(0, 0, 0)), {"image", {0, 0, 0}, 1, {0, 1, 0}}, 61);
  d.light_to_world = Matrix4d(0, 0, -1, 0, 0, 3, 0, 0, 2, 0, 0, 0, 7, 7, 7, 1);
  check(DomeLight(d, Vec3d(0, 0, 0)), {"image turned and unevenly scaled", {0, 0, 0}, 1, {0, 1, 0}}, 62);
}

// Both triangles may lie behind one another: the density of a direction is the sum over all hits.
TEST(LightChiSquare, Mesh) {
  const std::vector<MeshLight::Triangle> triangles = {
      {{-1, -1, 1}, {1, -1, 1}, {0, 1, 1.5f}, Rgb(1, 2, 3)},
      {{-1, 0, -1}, {1, 0, -1}, {0, 2, -2}, Rgb(0.0f)},
      {{0, -1, 2}, {2, 0, 2}, {0, 2, 2}, Rgb(5, 1, 1)},
  };
  const MeshLight light(7, triangles, {4, 2, 9});
  const uint32_t ids[3] = {4, 2, 9};
  const auto distance_to = [](const MeshLight::Triangle& t, const Vec3f& p, const Vec3f& w) {
    const Vec3f e1 = t.p1 - t.p0, e2 = t.p2 - t.p0, h = cross(w, e2), s = p - t.p0, q = cross(s, e1);
    const float inverse = 1 / dot(e1, h), u = dot(s, h) * inverse, v = dot(w, q) * inverse;
    const float distance = dot(e2, q) * inverse;
    return u >= 0 && v >= 0 && u + v <= 1 && distance > 0 ? distance : 0;
  };
  uint64_t seed = 70;
  for (const Vec3f& p : {Vec3f(0, 0, 0), Vec3f(0.3f, 0, 1.7f)}) {
    const auto sample = [&](Rng& rng) -> std::optional<Vec3f> {
      const auto s = light.sample(p, uniform2(rng));
      if (!s) return std::nullopt;
      return s->wi;
    };
    const auto pdf = [&](const Vec3f& w) {
      float sum = 0;
      for (size_t i = 0; i < 3; ++i) {
        const float t = distance_to(triangles[i], p, w);
        if (t > 0) sum += light.pdf(ids[i], w, t);
      }
      return sum;
    };
    const auto r = chi_square_sphere(
        sample, pdf, {.bins_x = 18, .bins_y = 18, .samples = 60000, .seed = seed++, .number_of_tests = kTests});
    EXPECT_TRUE(r.passed) << r.report;
  }
}

// The instrument notices a light whose pdf is that of a slightly larger light, and one that forgets the cosine.
TEST(LightChiSquare, WrongPdfsFail) {
  LightDescription d = described(LightType::rect);
  const RectLight light(d, Vec3d(0, 0, 0));
  d.width = 1.03f;
  const RectLight larger(d, Vec3d(0, 0, 0));
  const Vec3f p(0.8f, 0.1f, -0.6f);
  const ChiSquareOptions coarse{.bins_x = 18, .bins_y = 18, .samples = 60000};
  const auto sample = [&](Rng& rng) -> std::optional<Vec3f> { return light.sample(p, uniform2(rng))->wi; };
  const auto larger_pdf = [&](const Vec3f& w) {
    const auto hit = larger.intersect({p, w});
    return hit ? hit->pdf : 0.0f;
  };
  EXPECT_FALSE(chi_square_sphere(sample, larger_pdf, coarse).passed);
  const auto without_cosine = [&](const Vec3f& w) {
    const auto hit = light.intersect({p, w});
    return hit ? hit->t * hit->t : 0.0f;  // area 1
  };
  EXPECT_FALSE(chi_square_sphere(sample, without_cosine, coarse).passed);
}

}  // namespace
}  // namespace alabaster::testing
