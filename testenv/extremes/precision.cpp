// The kernels in float beside the same formulas in long double, written again from their sources.
#include <functional>

#include "core/camera/camera.h"
#include "core/geometry/surface_hit.h"
#include "core/material/fresnel.h"
#include "core/material/microfacet.h"
#include "core/sampling/warp.h"
#include "core/subsurface/dwivedi.h"
#include "core/subsurface/henyey_greenstein.h"
#include "testenv/extremes/rows.h"
#include "testenv/support/chi_square.h"
#include "testenv/support/half_space.h"

namespace alabaster::testing {
namespace {

using Exact = long double;

const Exact kPiExact = std::acos(Exact(-1));

/// The largest error of a kernel over random arguments.
class LargestError {
 public:
  void add(Exact given, Exact exact, Exact scale) {
    const auto error = static_cast<double>(std::abs(given - exact) / scale);
    if (!(error <= largest_)) largest_ = error;  // NaN too
  }
  void add_relative(Exact given, Exact exact) { add(given, exact, std::max(std::abs(exact), Exact(1e-37))); }
  double largest() const { return largest_; }

 private:
  double largest_ = 0;
};

class Kernels {
 public:
  explicit Kernels(Report& report)
      : rows_(report, "Precision",
              "Kernels in float beside the same formulas in long double, written again: the largest error over random\n"
              "arguments, in units of a float's rounding, 2^-24. `relative`: of the value; `absolute`: of 1."),
        count_(static_cast<int>(report.walks_for(0.4))) {}

  /// `evaluate(rng, error)` adds one error.
  void row(const char* kernel, const char* arguments, const char* measure, double most, const std::string& why,
           const std::function<void(Rng&, LargestError*)>& evaluate) {
    Rng rng(55, 5);
    LargestError error;
    for (int i = 0; i < count_; ++i) evaluate(rng, &error);
    const double units = error.largest() * 0x1p24;
    rows_.require(kernel, arguments, text("%s error <= %g units", measure, most), why, text("%.3g units", units),
                  units <= most);
  }
  Rows& rows() { return rows_; }

 private:
  Rows rows_;
  int count_;
};

/// From `low` to `high`, evenly by its logarithm.
float log_uniform(Rng& rng, double low, double high) {
  return static_cast<float>(low * std::pow(high / low, double(rng.uniform())));
}

// ---- Fresnel

Exact exact_fresnel(Exact cosine, Exact eta) {
  const Exact cos2_t = ((eta - 1) * (eta + 1) + cosine * cosine) / (eta * eta);
  if (!(cos2_t > 0)) return 1;
  const Exact cos_t = std::sqrt(cos2_t);
  const Exact parallel = (eta * cosine - cos_t) / (eta * cosine + cos_t);
  const Exact perpendicular = (cosine - eta * cos_t) / (cosine + eta * cos_t);
  return (parallel * parallel + perpendicular * perpendicular) / 2;
}

void print_fresnel(Kernels& k) {
  const auto fresnel = [](double low, double high) {
    return [=](Rng& rng, LargestError* e) {
      const float cosine = log_uniform(rng, 1e-6, 1), eta = log_uniform(rng, low, high);
      e->add(fresnel_dielectric(cosine, eta), exact_fresnel(cosine, eta), 1);
    };
  };
  k.row("Fresnel's equations", "index 1.2 to 4, cosine 1e-6 to 1", "absolute", 16, "a dozen roundings",
        fresnel(1.2, 4));
  k.row("Fresnel's equations", "index 1.0001 to 1.01", "absolute", 64,
        "cos_t from its square, which must not cancel at grazing incidence", fresnel(1.0001, 1.01));
  k.row("Fresnel's equations", "index .25 to .8, away from total reflection", "absolute", 64, "a dozen roundings",
        [](Rng& rng, LargestError* e) {
          const float eta = log_uniform(rng, 0.25, 0.8), cosine = rng.uniform();
          // At the critical angle itself its derivative is infinite.
          if (std::abs(Exact(cosine) * cosine - (1 - Exact(eta) * eta)) > 0.05L)
            e->add(fresnel_dielectric(cosine, eta), exact_fresnel(cosine, eta), 1);
        });
  k.row("f0 by index", "index - 1 from 1e-6 to 3", "relative", 8, "ior - 1 is exact below 2, so nothing is lost near 1",
        [](Rng& rng, LargestError* e) {
          const float ior = 1 + log_uniform(rng, 1e-6, 3);
          const Exact root = (Exact(ior) - 1) / (Exact(ior) + 1);
          e->add_relative(f0_from_ior(ior), root * root);
        });
  k.row("Schlick's weight", "cosine 0 to 1", "absolute", 4, "five products", [](Rng& rng, LargestError* e) {
    const float cosine = rng.uniform();
    e->add(schlick_weight(cosine), std::pow(1 - Exact(cosine), Exact(5)), 1);
  });
}

// ---- microfacets

Vec3f any_direction(Rng& rng) {
  const Vec2f u = uniform2(rng);
  return sample_cosine_hemisphere({0.001f + 0.998f * u.x, u.y});
}

void print_microfacets(Kernels& k) {
  const auto about_peak = [](Rng& rng, float alpha) {
    // Facets that the lobe has, out to a hundred times its width.
    const float t = alpha * log_uniform(rng, 1e-3, 100), phi = kTwoPi * rng.uniform();
    return normalize(Vec3f(t * std::cos(phi), t * std::sin(phi), 1));
  };
  for (const float alpha : {kMinAlpha, 0.01f, 1.0f})
    k.row("GGX, D", text("alpha %g", double(alpha)).c_str(), "relative", 16, "a dozen roundings, none cancels",
          [=](Rng& rng, LargestError* e) {
            const Vec3f wm = about_peak(rng, alpha);
            const Exact a = alpha, x = wm.x / a, y = wm.y / a, z = wm.z, s = x * x + y * y + z * z;
            e->add_relative(Ggx{alpha, alpha}.d(wm), 1 / (kPiExact * a * a * s * s));
          });
  k.row("GGX, G1 over the cosine", "alpha 1e-4 to 1", "relative", 8, "no term cancels", [](Rng& rng, LargestError* e) {
    const float alpha = log_uniform(rng, 1e-4, 1);
    const Vec3f w = any_direction(rng);
    const Exact x = Exact(alpha) * w.x, y = Exact(alpha) * w.y, z = w.z;
    e->add_relative(Ggx{alpha, alpha}.g1_over_cos(w), 2 / (z + std::sqrt(z * z + x * x + y * y)));
  });
  k.row("GTR1, D", "alpha .001 to .1", "relative", 32, "a logarithm", [&](Rng& rng, LargestError* e) {
    const float alpha = log_uniform(rng, 1e-3, 0.1);
    const Vec3f wm = about_peak(rng, alpha);
    const Exact a2 = Exact(alpha) * alpha, sin2 = Exact(wm.x) * wm.x + Exact(wm.y) * wm.y;
    const Exact t = sin2 + a2 * wm.z * wm.z;
    e->add_relative(Gtr1{alpha}.d(wm), (a2 - 1) / (kPiExact * std::log(a2) * t));
  });
}

// ---- sampling

void print_warps(Kernels& k) {
  k.row("cone of directions", "1 - cos from 1e-12 to 1: sine", "relative", 8, "1 - cos is passed, not cos",
        [](Rng& rng, LargestError* e) {
          const float m = log_uniform(rng, 1e-12, 1);
          const Vec2f u = uniform2(rng);
          const Vec3f w = sample_uniform_cone(u, m);
          const Exact h = Exact(u.x) * m, sine = std::sqrt(h * (2 - h));
          e->add(std::hypot(Exact(w.x), Exact(w.y)), sine, std::max(sine, Exact(1e-20)));
        });
  k.row("uniform sphere", "sine, to the poles", "relative", 8, "from u (1 - u), not from 1 - z^2",
        [](Rng& rng, LargestError* e) {
          const Vec2f u(log_uniform(rng, 1e-9, 0.5), rng.uniform());
          const Vec3f w = sample_uniform_sphere(u);
          e->add_relative(std::hypot(Exact(w.x), Exact(w.y)), 2 * std::sqrt(Exact(u.x) * (1 - Exact(u.x))));
        });
  k.row("cosine hemisphere", "its length", "absolute", 4, "z from the others", [](Rng& rng, LargestError* e) {
    const Vec3f w = sample_cosine_hemisphere(uniform2(rng));
    e->add(Exact(w.x) * w.x + Exact(w.y) * w.y + Exact(w.z) * w.z, 1, 1);
  });
  k.row("cosine hemisphere", "z, to the horizon", "relative", 8, "from the way to the rim, not from 1 - x^2 - y^2",
        [](Rng& rng, LargestError* e) {
          const Vec2f u(log_uniform(rng, 1e-7, 0.5), rng.uniform());
          const Exact a = 2 * Exact(u.x) - 1, b = 2 * Exact(u.y) - 1, r = std::max(std::abs(a), std::abs(b));
          e->add_relative(sample_cosine_hemisphere(u).z, std::sqrt((1 - r) * (1 + r)));
        });
  k.row("GGX, visible normals", "alpha 1e-4: slope", "absolute", 16, "of the lobe's width",
        [](Rng& rng, LargestError* e) {
          const Vec3f wo = any_direction(rng);
          const Vec2f u = uniform2(rng);
          constexpr float kAlpha = kMinAlpha;
          const Vec3f wm = Ggx{kAlpha, kAlpha}.sample(wo, u);
          // Heitz 2018, section 3.
          const Exact vx = Exact(kAlpha) * wo.x, vy = Exact(kAlpha) * wo.y, vz = wo.z;
          const Exact length = std::sqrt(vx * vx + vy * vy + vz * vz), x = vx / length, y = vy / length,
                      z = vz / length;
          const Exact l = std::hypot(x, y), t1x = -y / l, t1y = x / l;
          const Exact t2x = -z * t1y, t2y = z * t1x, t2z = x * t1y - y * t1x;
          const Exact r = std::sqrt(Exact(u.x)), phi = 2 * kPiExact * u.y, s = (1 + z) / 2;
          const Exact p1 = r * std::cos(phi), p2 = (1 - s) * std::sqrt(1 - p1 * p1) + s * r * std::sin(phi);
          const Exact p3 = std::sqrt(std::max(Exact(0), 1 - p1 * p1 - p2 * p2));
          const Exact nx = t1x * p1 + t2x * p2 + x * p3, ny = t1y * p1 + t2y * p2 + y * p3, nz = t2z * p2 + z * p3;
          // Slopes in units of alpha; those beyond ten are of the tail, where the projected point nears the rim.
          if (nz < 0.1L) return;
          e->add(Exact(wm.x) / wm.z / kAlpha, nx / nz, std::max(Exact(1), 1 / (nz * nz)) * 10);
          e->add(Exact(wm.y) / wm.z / kAlpha, ny / nz, std::max(Exact(1), 1 / (nz * nz)) * 10);
        });
}

// ---- below the surface

void print_walks(Kernels& k) {
  const auto phase = [](auto&& part) {
    return [part](Rng& rng, LargestError* e) {
      const float g = (rng.next() % 2 ? 1 : -1) * (1 - log_uniform(rng, 1e-4, 1));
      const Vec2f u(rng.next() % 2 ? log_uniform(rng, 1e-6, 0.5) : 1 - log_uniform(rng, 1e-6, 0.5), rng.uniform());
      const Exact x = u.x, v = 1 - x, q = (1 + Exact(g)) * v + (1 - Exact(g)) * x;
      // 1 - cos and 1 + cos: sums of positive terms.
      const Exact behind = 2 * (1 - Exact(g)) * (1 - Exact(g)) * x * (1 + g * v) / (q * q);
      const Exact ahead = 2 * (1 + Exact(g)) * (1 + Exact(g)) * v * (1 - g * x) / (q * q);
      part(sample_henyey_greenstein(u, g), behind, ahead, e);
    };
  };
  k.row(
      "Henyey and Greenstein", "g to .9999, to both poles: cosine", "absolute", 16, "sums of positive terms",
      phase([](const Vec3f& w, Exact behind, Exact ahead, LargestError* e) { e->add(w.z, (ahead - behind) / 2, 1); }));
  k.row("Henyey and Greenstein", "g to .9999, to both poles: sine", "relative", 16, "not from 1 - cos^2",
        phase([](const Vec3f& w, Exact behind, Exact ahead, LargestError* e) {
          e->add_relative(std::hypot(Exact(w.x), Exact(w.y)), std::sqrt(behind * ahead));
        }));
  k.row("Dwivedi's mode, in double", "1 - alpha from 1e-12 to .999: x", "relative", 8, "the fit's error of 4e-7",
        [](Rng& rng, LargestError* e) {
          const double c = double(log_uniform(rng, 1e-12, 0.999));
          Exact x = dwivedi_mode(c).x;
          // Newton's method on alpha atanh(x) = x.
          for (int i = 0; i < 3; ++i)
            x -= ((1 - Exact(c)) * std::atanh(x) - x) / ((1 - Exact(c)) / ((1 - x) * (1 + x)) - 1);
          e->add_relative(dwivedi_mode(c).x, x);
        });
  k.row("Dwivedi's cosine, in double", "1 - alpha from 1e-8 to .999", "absolute", 0.001, "a cancellation of 1e-16 / x",
        [](Rng& rng, LargestError* e) {
          const DwivediMode mode = dwivedi_mode(double(log_uniform(rng, 1e-8, 0.999)));
          const double u = double(rng.uniform());
          const Exact x = mode.x;
          e->add(sample_dwivedi(u, mode), (1 - (1 + x) * std::exp(-2 * Exact(mode.theta) * u)) / x, 1);
        });
  k.row("cosine of exponential density, in double", "x from 1e-8 to 700: its distribution function", "absolute", 0.1,
        "below x = 1e-4 the second term of its series", [](Rng& rng, LargestError* e) {
          const double x = double(log_uniform(rng, 1e-8, 700)), u = double(rng.uniform());
          const Exact above = 1 - Exact(sample_exponential_cosine(u, x));
          e->add(std::expm1(-Exact(x) * above) / std::expm1(-2 * Exact(x)), 1 - Exact(u), 1);
        });
}

// ---- albedo inversion

void print_inversion(Kernels& k) {
  k.row("albedo inversion, exact", "A from 1e-6 to .999999: obtained A", "absolute", 0.5,
        "the fit's error of 2e-8; 1 - alpha rounded to float", [n = 0](Rng& rng, LargestError* e) mutable {
          if (n++ > 400) return;  // each needs a quadrature
          const float x = log_uniform(rng, 1e-6, 0.5), a = rng.next() % 2 ? x : 1 - x;
          const Medium medium = make_medium(Rgb(a), Rgb(1.0f), AlbedoInversion::exact);
          e->add(half_space_albedo(double(medium.one_minus_alpha.g)), a, 1);
        });
  k.row("albedo inversion, exact", "1 - A from 1e-6 to .5: obtained 1 - A", "relative", 4,
        "the fit is exact at A = 1; 1 - alpha rounded to float", [n = 0](Rng& rng, LargestError* e) mutable {
          if (n++ > 400) return;
          const float a = 1 - log_uniform(rng, 1e-6, 0.5);
          const Medium medium = make_medium(Rgb(a), Rgb(1.0f), AlbedoInversion::exact);
          e->add_relative(1 - Exact(half_space_albedo(double(medium.one_minus_alpha.g))), 1 - Exact(a));
        });
  k.row("extinction", "d from 1e-20 to 1e20", "relative", 1, "one rounding", [](Rng& rng, LargestError* e) {
    const float d = log_uniform(rng, 1e-20, 1e20), a = rng.uniform();
    const Medium medium = make_medium(Rgb(a), Rgb(d), AlbedoInversion::exact);
    const Exact difference = Exact(a) - 0.8L, scale = 1.9L - a + 3.5L * difference * difference;
    e->add_relative(medium.sigma_t.g, 1 / (d * scale));
  });
}

// ---- rays

// The point of a hit and the origin of the next ray, in a triangle anywhere under any placement.
void print_offsets(Kernels& k) {
  double worst = 0, farthest = 0;
  int wrong_side = 0;
  Rng rng(77, 7);
  const auto any = [&](double size) { return static_cast<float>((2 * double(rng.uniform()) - 1) * size); };
  const int count = static_cast<int>(k.rows().report().walks_for(0.1));
  for (int i = 0; i < count; ++i) {
    Mesh mesh;
    const float place = log_uniform(rng, 1e-3, 1e5), size = log_uniform(rng, 1e-3, 1e3);
    const Vec3f middle(any(double(place)), any(double(place)), any(double(place)));
    for (int c = 0; c < 3; ++c)
      mesh.points.push_back(middle + Vec3f(any(double(size)), any(double(size)), any(double(size))));
    mesh.triangles = {{0, 1, 2}};
    Matrix4d m;
    m.setEulerAngles(Vec3d(double(any(3)), double(any(3)), double(any(3))));
    m = scaling(double(log_uniform(rng, 0.01, 100)), 1, 1) * m * translation(double(any(1e4)), double(any(1e4)), 0);
    const Affine to_render = to_affine(m), to_object = to_affine(m.inverse());
    TriangleHit hit;
    hit.u = rng.uniform(), hit.v = (1 - hit.u) * rng.uniform();
    const SurfaceHit s = surface_hit(mesh, hit, to_render, to_object);
    // The exact plane of the float triangle under the float map.
    const auto placed = [&](const Vec3f& p) {
      return Vec3d(to_render.x) * double(p.x) + Vec3d(to_render.y) * double(p.y) + Vec3d(to_render.z) * double(p.z) +
             Vec3d(to_render.t);
    };
    const Vec3d p0 = placed(mesh.points[0]), e1 = placed(mesh.points[1]) - p0, e2 = placed(mesh.points[2]) - p0;
    const Vec3d normal = cross(e1, e2);
    // A sliver's normal is not known to floats: skipped here, and rendered above.
    if (!(length(normal) > 1e-2 * length(e1) * length(e2)) || !(length(e1) > 1e-3 * double(place))) continue;
    const Vec3d n = normal * ((dot(normal, Vec3d(s.ng)) > 0 ? 1 : -1) / length(normal));
    worst = std::max(worst, std::abs(dot(Vec3d(s.p) - p0, n)) / double(s.offset));
    const double height = dot(Vec3d(offset_point(s.p, s.ng, s.offset)) - p0, n);
    wrong_side += !(height > 0);
    farthest = std::max(farthest, height / double(s.offset));
  }
  k.rows().require("hits of triangles under maps", "places to 1e5, sizes 1e-3 to 1e3, stretched by .01 to 100",
                   "distance from the exact plane <= .5 of the offset", "the offset covers the next ray's rounding too",
                   text("%.3g of it", worst), worst <= 0.5);
  k.rows().require("origins of the next rays", "the same", "all above the exact plane, at most two offsets", "rounding",
                   text("%d below; the farthest at %.3g offsets", wrong_side, farthest),
                   wrong_side == 0 && farthest < 2);
}

void print_cameras_rays(Kernels& k) {
  for (const double degrees : {0.001, 40.0, 179.0})
    k.row("camera rays", text("view of %g degrees: angle off the axis", degrees).c_str(), "relative", 16,
          "products and a normalisation", [=](Rng& rng, LargestError* e) {
            CameraParameters parameters = look_at({0, 0, 0}, {0, 0, -1}, degrees);
            const Camera camera(parameters, 1024, 1024, {0, 0, 0});
            const Vec2f film(1024 * rng.uniform(), 512);
            const Ray ray = camera.generate_ray(film, {0, 0});
            const Exact half = Exact(parameters.horizontal_aperture) / 2;
            const Exact exact = (Exact(film.x) / 512 - 1) * half;
            e->add(Exact(ray.dir.x) / -Exact(ray.dir.z), exact, half);
          });
}

}  // namespace

void print_precision(Report& report) {
  Kernels kernels(report);
  print_fresnel(kernels);
  print_microfacets(kernels);
  print_warps(kernels);
  print_walks(kernels);
  print_inversion(kernels);
  print_offsets(kernels);
  print_cameras_rays(kernels);
}

}  // namespace alabaster::testing
