// Every light samples directions by the pdf that it states, seen from near, far, inside and grazing points.
#include <gtest/gtest.h>

#include <functional>

#include "core/light/light.h"
#include "core/math/frame.h"
#include "core/sampling/warp.h"
#include "testenv/support/chi_square.h"
#include "testenv/support/memory_texture.h"

namespace alabaster::testing {
namespace {

// Directions are binned on a chart of the light as seen from p. It maps to the unit square, where the light's outline
// follows bin edges, so that the pdf has no jumps within bins. Half the square lies outside the light.
struct Chart {
  std::function<Vec2f(const Vec3f&)> to_square;
  std::function<Vec3f(const Vec2f&)> direction;
  std::function<double(const Vec2f&)> solid_angle;  // per unit area of the square
};

// The rounding error of float directions: u within this distance of the light's edge counts as on the light.
double snap(double u, double edge, double inward, double blur) {
  return std::abs(u - edge) < blur && (u - edge) * inward <= 0 ? edge + inward * 1e-6 : u;
}

Vec2f in_square(double x, double y) {
  return {static_cast<float>(std::clamp(x, 0.0, 0.9999999)), static_cast<float>(std::clamp(y, 0.0, 0.9999999))};
}

constexpr double kBlur = 0x1p-22;  // radians
// A parallelogram in the plane z = 0, centred at the origin, with edges x and y. The square covers twice its area.
Chart parallelogram(const Vec3f& p, const Vec3d& x, const Vec3d& y) {
  const Vec3d origin(p);
  const double area = length(cross(x, y)), size = std::min(length(x), length(y));
  const auto point = [=](const Vec2f& u) {
    return x * (2 * (static_cast<double>(u.x) - 0.5)) + y * (2 * (static_cast<double>(u.y) - 0.5)) - origin;
  };
  const auto to_square = [=](const Vec3f& w) {
    if (!(w.z > 0)) return Vec2f(0, 0);
    const double t = -origin.z / static_cast<double>(w.z), blur = kBlur * t / (static_cast<double>(w.z) * size);
    const Vec3d q = origin + Vec3d(w) * t;
    const double determinant = x.x * y.y - x.y * y.x;
    double u = 0.5 + 0.5 * (q.x * y.y - q.y * y.x) / determinant, v = 0.5 + 0.5 * (x.x * q.y - x.y * q.x) / determinant;
    u = snap(snap(u, 0.25, 1, blur), 0.75, -1, blur);
    v = snap(snap(v, 0.25, 1, blur), 0.75, -1, blur);
    return in_square(u, v);
  };
  const auto solid_angle = [=](const Vec2f& u) {
    const Vec3d d = point(u);
    const double l = length(d);
    return 4 * area * d.z / (l * l * l);
  };
  return {to_square, [=](const Vec2f& u) { return Vec3f(normalize(point(u))); }, solid_angle};
}

// A cone of this 1 - cos around `axis`. The square covers twice its solid angle, or the sphere if that is less.
Chart cone(const Vec3f& axis, double one_minus_cos) {
  const Frame frame = frame_from_normal(normalize(axis));
  const double range = std::min(2 * one_minus_cos, 2.0);
  const auto to_square = [=](const Vec3f& w) {
    const Vec3f apart = w - frame.n, l = frame.to_local(w);
    const double h = 0.5 * static_cast<double>(dot(apart, apart));
    const double u = snap(h / range, one_minus_cos / range, -1, kBlur * std::sqrt(2 * h) / range);
    return in_square(u, 0.5 + static_cast<double>(std::atan2(l.y, l.x)) / (2 * kPiDouble));
  };
  const auto direction = [=](const Vec2f& u) {
    const double h = u.x * range, phi = 2 * kPiDouble * (static_cast<double>(u.y) - 0.5), r = std::sqrt(h * (2 - h));
    return normalize(
        Vec3f(Vec3d(frame.s) * (r * std::cos(phi)) + Vec3d(frame.t) * (r * std::sin(phi)) + Vec3d(frame.n) * (1 - h)));
  };
  return {to_square, direction, [=](const Vec2f&) { return 2 * kPiDouble * range; }};
}

// Longitude and colatitude around y, as in an image of the dome.
Chart lat_long() {
  const auto to_square = [](const Vec3f& w) {
    const double x = w.x, z = w.z;
    return in_square(0.5 - std::atan2(x, z) / (2 * kPiDouble),
                     std::atan2(std::sqrt(x * x + z * z), static_cast<double>(w.y)) / kPiDouble);
  };
  const auto direction = [](const Vec2f& u) {
    const double phi = 2 * kPiDouble * (0.5 - static_cast<double>(u.x)), theta = kPiDouble * u.y;
    return Vec3f(Vec3d(std::sin(theta) * std::sin(phi), std::cos(theta), std::sin(theta) * std::cos(phi)));
  };
  return {to_square, direction, [](const Vec2f& u) { return 2 * kPiDouble * kPiDouble * std::sin(kPiDouble * u.y); }};
}

// An ellipse in the plane z = 0, centred at the origin, of these semi-axes (perpendicular or not). The square covers
// twice its area, radius squared by azimuth.
Chart ellipse(const Vec3f& p, const Vec3d& x, const Vec3d& y) {
  const Vec3d origin(p);
  const double area = length(cross(x, y)), size = std::min(length(x), length(y));
  const auto point = [=](const Vec2f& u) {
    const double r = std::sqrt(2 * static_cast<double>(u.x)), phi = 2 * kPiDouble * (static_cast<double>(u.y) - 0.5);
    return x * (r * std::cos(phi)) + y * (r * std::sin(phi)) - origin;
  };
  const auto to_square = [=](const Vec3f& w) {
    if (!(w.z > 0)) return Vec2f(0.99f, 0);
    const double t = -origin.z / static_cast<double>(w.z), blur = kBlur * t / (static_cast<double>(w.z) * size);
    const Vec3d q = origin + Vec3d(w) * t;
    const double determinant = x.x * y.y - x.y * y.x;
    const double a = (q.x * y.y - q.y * y.x) / determinant, b = (x.x * q.y - x.y * q.x) / determinant;
    return in_square(snap(0.5 * (a * a + b * b), 0.5, -1, 2 * blur), 0.5 + std::atan2(b, a) / (2 * kPiDouble));
  };
  const auto solid_angle = [=](const Vec2f& u) {
    const Vec3d d = point(u);
    const double l = length(d);
    return 2 * kPiDouble * area * d.z / (l * l * l);
  };
  return {to_square, [=](const Vec2f& u) { return Vec3f(normalize(point(u))); }, solid_angle};
}

// The visible side of a cylinder about the x axis, of radius r. The square covers twice its length, and the angles
// about the axis from which it is seen.
Chart cylinder(const Vec3f& p, double length_of_it, double r) {
  const Vec3d origin(p);
  const double h = std::hypot(origin.y, origin.z), middle = std::atan2(origin.z, origin.y), widest = std::acos(r / h);
  const auto point = [=](const Vec2f& u) {
    const double angle = middle + widest * (2 * static_cast<double>(u.y) - 1);
    return Vec3d(length_of_it * (2 * static_cast<double>(u.x) - 1), r * std::cos(angle), r * std::sin(angle));
  };
  const auto to_square = [=](const Vec3f& w) {
    // |(y, z) of origin + t w| = r.
    const Vec3d d(w);
    const double a = d.y * d.y + d.z * d.z, b = origin.y * d.y + origin.z * d.z, c = h * h - r * r;
    const double t = (-b - std::sqrt(std::max(0.0, b * b - a * c))) / a;
    const Vec3d q = origin + d * t;
    const double angle = std::remainder(std::atan2(q.z, q.y) - middle, 2 * kPiDouble);
    const double blur = kBlur * t / length_of_it * 4;
    const double x = 0.5 + 0.5 * q.x / length_of_it;
    return in_square(snap(snap(x, 0.25, 1, blur), 0.75, -1, blur), 0.5 + 0.5 * angle / widest);
  };
  const auto solid_angle = [=](const Vec2f& u) {
    const Vec3d q = point(u), d = q - origin;
    const double l = length(d), cosine = -(d.y * q.y + d.z * q.z) / (l * r);
    return std::max(0.0, cosine) / (l * l) * r * 2 * widest * 2 * length_of_it;
  };
  return {to_square, [=](const Vec2f& u) { return Vec3f(normalize(point(u) - origin)); }, solid_angle};
}

template <class L>
ChiSquareResult test_light(const L& light, const Vec3f& p, const Chart& chart, uint64_t seed) {
  const auto sample = [&](Rng& rng) -> std::optional<Vec2f> {
    const auto s = light.sample(p, uniform2(rng));
    if (!s) return std::nullopt;
    return chart.to_square(s->wi);
  };
  const auto pdf = [&](const Vec2f& u) {
    const auto hit = light.intersect({p, chart.direction(u)});
    return hit ? static_cast<float>(hit->pdf * chart.solid_angle(u)) : 0.0f;
  };
  return chi_square_square(sample, pdf, {.bins_x = 36, .bins_y = 36, .samples = 100000, .seed = seed});
}

template <class L>
void check(const L& light, const char* name, const Vec3f& p, const Chart& chart, uint64_t seed) {
  const auto r = test_light(light, p, chart, seed);
  EXPECT_TRUE(plausible(r)) << name;
}

// A rectangle for a lobe that weighs light by the cosine.
struct Facing {
  RectDiskLight light;
  Vec3f n;
  std::optional<LightSample> sample(const Vec3f& p, const Vec2f& u) const { return light.sample(p, u, n); }
  std::optional<LightHit> intersect(const Ray& ray) const { return light.intersect(ray, n); }
};

LightParameters described(LightType type) {
  LightParameters d;
  d.type = type;
  return d;
}

TEST(LightChiSquare, Rect) {
  LightParameters d = described(LightType::rect);
  d.width = 2;
  const RectDiskLight light(d, Vec3d(0, 0, 0));
  struct View {
    const char* name;
    Vec3f p;
  };
  uint64_t seed = 10;
  for (const auto& [name, p] :
       {View{"near", {0.2f, 0.1f, -0.3f}}, View{"nearly touching", {0.2f, 0.1f, -0.03f}},
        View{"beside", {1.5f, -0.2f, -0.4f}}, View{"grazing", {0, 0.7f, -0.02f}}, View{"far", {40, 10, -70}},
        View{"very far", {200, 0, -200}}, View{"so flat that it is sampled by area", {0, 0.9f, -2e-5f}}})
    check(light, name, p, parallelogram(p, Vec3d(2, 0, 0), Vec3d(0, 1, 0)), seed++);
}

TEST(LightChiSquare, RectAsLobesSeeIt) {
  LightParameters d = described(LightType::rect);
  d.width = 2;
  const RectDiskLight light(d, Vec3d(0, 0, 0));
  struct View {
    const char* name;
    Vec3f p, n;
  };
  uint64_t seed = 120;
  for (const auto& [name, p, n] :
       {View{"near", {0.2f, 0.1f, -0.3f}, {0, 0, 1}}, View{"as near as it may be", {0.8f, -0.3f, -2.1f}, {0, 0, 1}},
        View{"tilted", {0.8f, -0.3f, -2.1f}, {0.8f, 0, 0.6f}}, View{"half below the horizon", {0, 0, -2.3f}, {1, 0, 0}},
        View{"wholly below it", {3, 0.5f, -1}, {1, 0, 0}}, View{"far", {40, 10, -70}, {0, 1, 0}}})
    check(Facing{light, n}, name, p, parallelogram(p, Vec3d(2, 0, 0), Vec3d(0, 1, 0)), seed++);
}

TEST(LightChiSquare, RectWithAnImage) {
  LightParameters d = described(LightType::rect);
  d.width = 2;
  // A black region wider than the filter, bright texels, edges that differ.
  std::vector<Rgb> texels(size_t{6} * 6, Rgb(0.0f));
  for (size_t i = 0; i < 6; ++i) texels[i] = Rgb(static_cast<float>(i + 1), 1, 2);
  texels[6 * 3 + 5] = Rgb(40, 0, 0);
  texels[6 * 5] = Rgb(0, 0, 30);
  d.texture = std::make_shared<MemoryTexture>(6, texels);
  uint64_t seed = 110;
  for (const Vec3f& p : {Vec3f(0.2f, 0.1f, -1), Vec3f(1.5f, -0.2f, -0.8f), Vec3f(40, 10, -70)})
    check(RectDiskLight(d, Vec3d(0, 0, 0)), "image", p, parallelogram(p, Vec3d(2, 0, 0), Vec3d(0, 1, 0)), seed++);
}

TEST(LightChiSquare, ShearedRectIsSampledByArea) {
  LightParameters d = described(LightType::rect);
  d.light_to_world = Matrix4d(1, 0, 0, 0, 0.8, 1, 0, 0, 0, 0.3, 2, 0, 0, 0, 0, 1);
  const RectDiskLight light(d, Vec3d(0, 0, 0));
  uint64_t seed = 20;
  for (const Vec3f& p : {Vec3f(0.2f, 0.1f, -0.5f), Vec3f(1.5f, -0.2f, -0.8f)})
    check(light, "sheared", p, parallelogram(p, Vec3d(1, 0, 0), Vec3d(0.8, 1, 0)), seed++);
}

TEST(LightChiSquare, Disk) {
  LightParameters d = described(LightType::disk);
  d.radius = 1;
  const RectDiskLight light(d, Vec3d(0, 0, 0));
  uint64_t seed = 90;
  for (const Vec3f& p :
       {Vec3f(0.2f, 0.1f, -0.3f), Vec3f(0, 0.9f, -0.2f), Vec3f(1.5f, -0.2f, -0.8f), Vec3f(40, 10, -70)})
    check(light, "disk", p, ellipse(p, Vec3d(1, 0, 0), Vec3d(0, 1, 0)), seed++);
  d.light_to_world = Matrix4d(-1, 0, 0, 0, 0.8, 2, 0, 0, 0, 0.3, 2, 0, 0, 0, 0, 1);  // mirrored and sheared
  const Vec3f p(0.2f, 0.1f, -2);
  check(RectDiskLight(d, Vec3d(0, 0, 0)), "sheared", p, ellipse(p, Vec3d(-1, 0, 0), Vec3d(0.8, 2, 0)), seed);
}

TEST(LightChiSquare, Cylinder) {
  LightParameters d = described(LightType::cylinder);
  d.radius = 0.25f;
  d.length = 2;
  const CylinderLight light(d, Vec3d(0, 0, 0));
  uint64_t seed = 100;
  for (const Vec3f& p :
       {Vec3f(0.1f, -0.2f, -0.3f), Vec3f(0.3f, 2, 1), Vec3f(3, 0.2f, 0.4f), Vec3f(-1.2f, 0, 0.3f), Vec3f(40, 10, -70)})
    check(light, "cylinder", p, cylinder(p, 2, 0.25), seed++);
}

TEST(LightChiSquare, Sphere) {
  const SphereLight light(described(LightType::sphere), Vec3d(0, 0, 0));
  uint64_t seed = 30;
  for (const Vec3f& p : {Vec3f(0, 0.1f, -0.52f), Vec3f(1, 2, 3), Vec3f(100, 200, -300)}) {
    const double sin2 = 0.25 / static_cast<double>(dot(p, p));
    check(light, "outside", p, cone(-p, sin2 / (1 + std::sqrt(1 - sin2))), seed++);
  }
  check(light, "inside", {0.1f, -0.3f, 0.2f}, cone({0, 0, 1}, 2), seed);
}

// Outside the spot both sample() and intersect() are empty; the rest must still agree.
TEST(LightChiSquare, SphereWithSpotCone) {
  LightParameters d = described(LightType::sphere);
  d.cone_inner = 10;
  d.cone_outer = 25;
  const SphereLight light(d, Vec3d(0, 0, 0));
  const Vec3f p(0, 0, -1.2f);
  const double sin2 = 0.25 / 1.44, filled = sin2 / (1 + std::sqrt(1 - sin2));
  // The outer cone is wider than the sphere's at one point and narrower at the other.
  check(light, "wide", p, cone(-p, filled), 40);
  d.cone_outer = 15;
  check(SphereLight(d, Vec3d(0, 0, 0)), "narrow", p, cone(-p, 1 - std::cos(15 * kPiDouble / 180)), 41);
}

TEST(LightChiSquare, Distant) {
  LightParameters d = described(LightType::distant);
  d.light_to_world = Matrix4d(1, 0, 0, 0, 0, 0, 1, 0, 0, -1, 0, 0, 5, 5, 5, 1);
  uint64_t seed = 50;
  for (float angle : {0.53f, 40.0f, 220.0f}) {
    d.angle = angle;
    const double s = std::sin(static_cast<double>(angle) * kPiDouble / 720);
    check(DistantLight(d, Vec3d(0, 0, 0)), "distant", {1, 2, 3}, cone({0, -1, 0}, 2 * s * s), seed++);
  }
}

TEST(LightChiSquare, Dome) {
  LightParameters d = described(LightType::dome);
  check(DomeLight(d, Vec3d(0, 0, 0)), "constant", {0, 0, 0}, lat_long(), 60);
  // Black regions, a bright pole, a steep sun, and edges that differ.
  std::vector<Rgb> texels(size_t{12} * 6, Rgb(0.0f));
  for (size_t i = 0; i < 12; ++i) texels[i] = Rgb(static_cast<float>(i + 1), 1, 2);
  texels[12 * 3 + 11] = Rgb(5, 0, 0);
  texels[12 * 2 + 4] = Rgb(60, 50, 40);
  texels[12 * 5 + 2] = Rgb(0, 0, 30);
  d.texture = std::make_shared<MemoryTexture>(12, texels);
  check(DomeLight(d, Vec3d(0, 0, 0)), "image", {0, 0, 0}, lat_long(), 61);
  d.light_to_world = Matrix4d(0, 0, -1, 0, 0, 3, 0, 0, 2, 0, 0, 0, 7, 7, 7, 1);  // a quarter turn keeps texels on bins
  check(DomeLight(d, Vec3d(0, 0, 0)), "image turned and unevenly scaled", {0, 0, 0}, lat_long(), 62);
}

// The left half of the square is the first triangle, the right half the third; the second gives no light. Seen from p
// the two do not overlap.
TEST(LightChiSquare, Mesh) {
  const std::vector<MeshLight::Triangle> triangles = {
      {{-1, -1, 1}, {1, -1, 1}, {0, 1, 1.5f}, Rgb(1, 2, 3)},
      {{-1, 0, 0.5f}, {1, 0, 0.5f}, {0, 2, 0.5f}, Rgb(0.0f)},
      {{3, -1, 2}, {5, 0, 2}, {3, 2, 2}, Rgb(5, 1, 1)},
  };
  const MeshLight light(7, triangles, {4, 2, 9});
  const auto barycentric = [](const MeshLight::Triangle& t, const Vec3f& p, const Vec3f& w) {
    const Vec3f e1 = t.p1 - t.p0, e2 = t.p2 - t.p0, h = cross(w, e2), s = p - t.p0, q = cross(s, e1);
    const float inverse = 1 / dot(e1, h), u = dot(s, h) * inverse, v = dot(w, q) * inverse;
    return Vec3f(1 - u - v, u, v);
  };
  uint64_t seed = 70;
  for (const Vec3f& p : {Vec3f(0, 0, 0), Vec3f(0.3f, 0, 0.8f)}) {
    const auto sample = [&](Rng& rng) -> std::optional<Vec2f> {
      const auto s = light.sample(p, uniform2(rng));
      if (!s) return std::nullopt;
      const bool first = s->radiance == triangles[0].radiance;
      const Vec3f b = barycentric(triangles[first ? 0 : 2], p, s->wi);
      // The inverse of sample_uniform_triangle().
      const float root = 1 - std::clamp(b.x, 0.0f, 1.0f), y = root > 0 ? std::clamp(b.y, 0.0f, 1.0f) / root : 0;
      return in_square(std::clamp(0.5 * static_cast<double>(root * root), 0.0, 0.4999999) + (first ? 0 : 0.5), y);
    };
    const auto pdf = [&](const Vec2f& u) {
      const bool first = u.x < 0.5f;
      const MeshLight::Triangle& t = triangles[first ? 0 : 2];
      const Vec2f b = sample_uniform_triangle({2 * u.x - (first ? 0.0f : 1.0f), u.y});
      const Vec3f d = t.p0 * b.x + t.p1 * b.y + t.p2 * (1 - b.x - b.y) - p, w = normalize(d);
      const float twice_area_cos = std::abs(dot(cross(t.p1 - t.p0, t.p2 - t.p0), w));
      return light.pdf(first ? 4 : 9, w, length(d)) * twice_area_cos / dot(d, d);  // the triangle fills half the square
    };
    const auto r = chi_square_square(sample, pdf, {.bins_x = 36, .bins_y = 36, .samples = 100000, .seed = seed++});
    EXPECT_TRUE(plausible(r));
  }
}

// The test detects a light that is slightly larger than it states, and a pdf without the light's cosine.
TEST(LightChiSquare, WrongPdfsFail) {
  struct Wrong {
    RectDiskLight sampled, stated;
    float power_of_cosine;
    std::optional<LightSample> sample(const Vec3f& p, const Vec2f& u) const { return sampled.sample(p, u); }
    std::optional<LightHit> intersect(const Ray& ray) const {
      auto hit = stated.intersect(ray);
      if (hit) hit->pdf *= std::pow(ray.dir.z, power_of_cosine);
      return hit;
    }
  };
  LightParameters d = described(LightType::rect);
  const RectDiskLight light(d, Vec3d(0, 0, 0));
  d.width = 1.03f;
  const RectDiskLight larger(d, Vec3d(0, 0, 0));
  const Vec3f p(0.8f, 0.1f, -0.6f);
  const Chart chart = parallelogram(p, Vec3d(1, 0, 0), Vec3d(0, 1, 0));
  EXPECT_TRUE(plausible(test_light(Wrong{light, light, 0}, p, chart, 80)));
  EXPECT_TRUE(noticed(test_light(Wrong{light, larger, 0}, p, chart, 81)));
  EXPECT_TRUE(noticed(test_light(Wrong{light, light, 1}, p, chart, 82)));
  // And a pdf that takes the lobe for another.
  struct WrongLobe {
    Facing sampled, stated;
    std::optional<LightSample> sample(const Vec3f& from, const Vec2f& u) const { return sampled.sample(from, u); }
    std::optional<LightHit> intersect(const Ray& ray) const { return stated.intersect(ray); }
  };
  const Vec3f far(1.6f, 0.2f, -1.2f);
  const Facing lobe{light, {0, 0.6f, 0.8f}}, tilted{light, normalize(Vec3f(0.4f, 0.6f, 0.8f))};
  EXPECT_TRUE(
      noticed(test_light(WrongLobe{lobe, tilted}, far, parallelogram(far, Vec3d(1, 0, 0), Vec3d(0, 1, 0)), 83)));
}

}  // namespace
}  // namespace alabaster::testing
