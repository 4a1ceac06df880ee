#include "core/material/directional_albedo.h"

#include <memory>
#include <mutex>

#include "core/material/albedo_table.h"
#include "core/material/disney_clearcoat.h"
#include "core/material/disney_diffuse.h"
#include "core/material/disney_sheen.h"
#include "core/material/fresnel.h"

namespace alabaster {
namespace {

// Cosines are spaced by their squares: albedos change fastest near the horizon. That is left out itself, where a lobe's
// f may be infinite.
float cosine_at(float x) {
  return std::max(1e-4f, sqr(x));
}
float place_of(float cosine) {
  return std::sqrt(std::clamp(cosine, 0.0f, 1.0f));
}

Vec3f direction(float cosine) {
  return {safe_sqrt(1 - sqr(cosine)), 0, cosine};
}

// Midpoints of a grid over the unit square; the mean of f(u).
template <int kColumns, int kRows, class F>
auto mean_over_square(const F& f) {
  decltype(f(Vec2f())) sum(0);
  for (int row = 0; row < kRows; ++row)
    for (int column = 0; column < kColumns; ++column)
      sum += f(Vec2f((static_cast<float>(column) + 0.5f) / kColumns, (static_cast<float>(row) + 0.5f) / kRows));
  return sum * (1.0f / (kColumns * kRows));
}

// As above, over a Fibonacci lattice, no two points of which share a coordinate: a grid may miss what is narrow along
// an axis.
template <class F>
auto mean_over_lattice(const F& f) {
  constexpr uint32_t kPoints = 4181, kStep = 2584;
  decltype(f(Vec2f())) sum(0);
  for (uint32_t i = 0; i < kPoints; ++i)
    sum +=
        f(Vec2f((static_cast<float>(i) + 0.5f) / kPoints, (static_cast<float>(i * kStep % kPoints) + 0.5f) / kPoints));
  return sum * (1.0f / kPoints);
}

// Int f wi.z dwi over the hemisphere, of a lobe that is symmetric about the plane of incidence: f(wo, wi). Points are
// dense near the horizon: wi.z is u.x^2.
template <class F>
float cosine_weighted(float cosine, const F& f) {
  const Vec3f wo = direction(cosine);
  return kPi * mean_over_square<48, 48>([&](const Vec2f& u) {
           const float z = sqr(u.x), r = safe_sqrt(1 - sqr(z)), phi = kPi * u.y;
           return f(wo, Vec3f(r * std::cos(phi), r * std::sin(phi), z)) * (4 * u.x * z);
         });
}

// By visible normals: f cos / pdf is G1(wi). Facets tilt steeply where u.x is near 1, so points are dense there.
Vec2f ggx_at(const Vec2f& u, const Vec3f& wo, const Ggx& ggx) {
  const float rest = 1 - u.x;
  const Vec3f wm = ggx.sample(wo, {1 - rest * rest * rest, u.y});
  const Vec3f wi = reflect_about(wo, wm);
  if (!(wi.z > 0)) return {0, 0};
  const float g1 = 3 * rest * rest * wi.z * ggx.g1_over_cos(wi);
  return {g1, g1 * schlick_weight(dot(wo, wm))};
}
template <int kColumns, int kRows>
Vec2f integrate_ggx(const Vec3f& wo, const Ggx& ggx) {
  return mean_over_square<kColumns, kRows>([&](const Vec2f& u) { return ggx_at(u, wo, ggx); });
}

// Alphas from the sharpest to 1 are spaced by their squares.
float alpha_at(float y) {
  return sqr(lerp(std::sqrt(kMinAlpha), 1.0f, y));
}
float place_of_alpha(float alpha) {
  return (std::sqrt(alpha) - std::sqrt(kMinAlpha)) / (1 - std::sqrt(kMinAlpha));
}

// Near the horizon straight lines between corners run below the albedo by this share. Who keeps energy must not think
// it too low.
template <class Albedo>
Albedo raised(const Albedo& albedo, float cosine, float share) {
  return cosine < 0.05f ? albedo * (1 + share) : albedo;
}

using GgxTable = AlbedoTable<Vec2f, 48, 32>;
const GgxTable& ggx_table() {
  static const GgxTable table([](const GgxTable::Place& at) {
    const float alpha = alpha_at(at[1]);
    const float cosine = cosine_at(at[0]);
    return raised(integrate_ggx<24, 8>(direction(cosine), {alpha, alpha}), cosine, 0.003f);
  });
  return table;
}

// Samples of GTR1 by D wm.z: f cos / pdf = F G 4 cos_d wi.z / (4 wo.z wi.z wm.z).
float integrate_clearcoat(float cosine, float alpha) {
  const DisneyClearcoat lobe{1, {alpha}};
  const Vec3f wo = direction(cosine);
  return mean_over_square<32, 16>([&](const Vec2f& u) {
    const auto wi = lobe.sample(wo, {u.x, 0.5f * u.y});
    if (!wi) return 0.0f;
    const LobeValue value = lobe.evaluate(wo, *wi);
    return value.pdf > 0 ? value.f.r * wi->z / value.pdf : 0.0f;
  });
}

// Anisotropic facets of one shape: their albedos over directions. Towards y albedos change within a small angle, which
// azimuths resolve that are stretched half as much as the facets; the means of these and the others are evenly spaced.
class StretchedFacets {
 public:
  explicit StretchedFacets(const Ggx& ggx)
      : squeeze_(std::sqrt(ggx.alpha_y / ggx.alpha_x)), table_([&](const std::array<float, 2>& at) {
          const float cosine = std::max(1e-4f, 1 - sqr(1 - sqr(at[0]))), sine = safe_sqrt(1 - sqr(cosine));
          const float phi = azimuth_at(at[1]);
          return raised(integrate({sine * std::cos(phi), sine * std::sin(phi), cosine}, ggx), cosine, 0.003f);
        }) {
    mean_ = mean_over_square<64, 64>([&](const Vec2f& u) {
      const float cosine = std::sqrt(u.x), sine = safe_sqrt(1 - u.x), phi = 0.5f * kPi * u.y;
      return at({sine * std::cos(phi), sine * std::sin(phi), cosine}).x;
    });
  }

  Vec2f at(const Vec3f& w) const {
    // Cosines are dense near the horizon and about the normal, where albedos have a ridge along y.
    const float place = safe_sqrt(1 - safe_sqrt(1 - w.z));
    return table_.at({place, place_of_azimuth(std::abs(w.x), std::abs(w.y))});
  }
  float mean() const { return mean_; }

 private:
  float place_of_azimuth(float x, float y) const { return (std::atan2(y, x) + std::atan2(y * squeeze_, x)) * kInvPi; }
  // The inverse, by bisection.
  float azimuth_at(float place) const {
    float low = 0, high = 0.5f * kPi;
    for (int i = 0; i < 24; ++i) {
      const float middle = 0.5f * (low + high);
      (place_of_azimuth(std::cos(middle), std::sin(middle)) < place ? low : high) = middle;
    }
    return 0.5f * (low + high);
  }
  // As integrate_ggx(), the finer the rougher: few facets of rough ones are both seen and lit. Who keeps energy must
  // not think an albedo too low.
  static Vec2f integrate(const Vec3f& wo, const Ggx& ggx) {
    const Vec2f sum = ggx.alpha_x < 0.7f ? integrate_ggx<24, 32>(wo, ggx)
                      : ggx.alpha_x < 2  ? integrate_ggx<32, 64>(wo, ggx)
                                         : mean_over_lattice([&](const Vec2f& u) { return ggx_at(u, wo, ggx); });
    constexpr float kError = 1.5e-3f;
    return {std::min(1.0f, sum.x + kError), std::min(1.0f, sum.y + std::min(kError, 0.03f * sum.y))};
  }

  float squeeze_, mean_ = 0;
  AlbedoTable<Vec2f, 24, 16> table_;
};

// Shapes of anisotropic facets, on a grid of both alphas. Each is made when it is first needed: in 10 ms, or 65 ms
// where alpha_x is above 2. Few materials need more than the four about their own.
class FacetShapes {
 public:
  /// `value(facets)`, interpolated between the shapes about `ggx`.
  template <class F>
  auto at(const Ggx& ggx, const F& value) {
    const Place x(ggx.alpha_x, kX), y(ggx.alpha_y, kY);
    const auto row = [&](size_t j) {
      return value(get(x.cell, j)) * (1 - x.within) + value(get(x.cell + 1, j)) * x.within;
    };
    return row(y.cell) * (1 - y.within) + row(y.cell + 1) * y.within;
  }

 private:
  static constexpr float kStep = 0.025f;
  static constexpr size_t kX = 34, kY = 20;  // cells: alpha_x up to 38, alpha_y to 1.1
  // Roots, and beyond 1 ever less: rougher facets differ little.
  static float spaced(float alpha) { return std::sqrt(alpha) / (1 + std::sqrt(alpha)); }
  static float alpha_of(size_t corner) {
    const float p = spaced(kMinAlpha) + kStep * static_cast<float>(corner);
    return sqr(p / (1 - p));
  }
  struct Place {
    size_t cell;
    float within;
    Place(float alpha, size_t cells) {
      const float at = std::max(0.0f, (spaced(alpha) - spaced(kMinAlpha)) / kStep);
      cell = std::min(static_cast<size_t>(at), cells - 1);
      within = std::min(1.0f, at - static_cast<float>(cell));
    }
  };
  struct Made {
    std::once_flag once;
    std::unique_ptr<const StretchedFacets> facets;
  };

  const StretchedFacets& get(size_t x, size_t y) {
    Made& made = made_[y * (kX + 1) + x];
    std::call_once(made.once, [&] {
      made.facets = std::make_unique<const StretchedFacets>(Ggx{alpha_of(x), alpha_of(y)});
    });
    return *made.facets;
  }

  std::array<Made, (kX + 1) * (kY + 1)> made_;
};

FacetShapes& facet_shapes() {
  static FacetShapes shapes;
  return shapes;
}

// Indices are spaced so that those of both sides of a boundary are alike.
constexpr float kLeastPlaceOfEta = 0.2f;
float eta_at(float y) {
  const float place = lerp(kLeastPlaceOfEta, 1 - kLeastPlaceOfEta, y);
  return place / (1 - place);
}
float place_of_eta(float eta) {
  return (eta / (1 + eta) - kLeastPlaceOfEta) / (1 - 2 * kLeastPlaceOfEta);
}

// By visible normals, as integrate_ggx(). The azimuths of one side of the plane of incidence are as good as all. Fewer
// points would be off by up to 0.04, where facets begin to reflect totally.
Vec2f integrate_dielectric(float cosine, float alpha, float eta) {
  const Vec3f wo = direction(cosine);
  const Ggx ggx{alpha, alpha};
  return mean_over_square<48, 8>([&](const Vec2f& u) {
    const float rest = 1 - u.x, weight = 3 * rest * rest;
    const Vec3f wm = ggx.sample(wo, {1 - rest * rest * rest, 0.25f + 0.5f * u.y});
    const float cos_d = dot(wo, wm);
    if (!(cos_d > 0)) return Vec2f(0, 0);
    const float fresnel = fresnel_dielectric(cos_d, eta);
    const auto left = [&](const Vec3f& wi) { return wi.z > 0 ? weight * wi.z * ggx.g1_over_cos(wi) : 0; };
    const Vec3f through = wm * (cos_d / eta - cosine_refracted(cos_d, eta)) - wo / eta;
    return Vec2f(fresnel * left(reflect_about(wo, wm)), (1 - fresnel) * left({through.x, through.y, -through.z}));
  });
}

}  // namespace

GgxAlbedo ggx_albedo(const Vec3f& wo, const Ggx& ggx) {
  if (ggx.alpha_x == ggx.alpha_y) {
    const Vec2f value = ggx_table().at({place_of(wo.z), place_of_alpha(ggx.alpha_x)});
    return {value.x, value.y};
  }
  const Vec2f value = facet_shapes().at(ggx, [&](const StretchedFacets& facets) { return facets.at(wo); });
  return {value.x, value.y};
}

float mean_ggx_albedo(const Ggx& ggx) {
  if (ggx.alpha_x != ggx.alpha_y) return facet_shapes().at(ggx, [](const StretchedFacets& f) { return f.mean(); });
  static const AlbedoTable<float, 32> table([](const std::array<float, 1>& at) {
    constexpr int kCosines = 256;
    float sum = 0;
    for (int i = 0; i < kCosines; ++i) {
      const float cosine = (static_cast<float>(i) + 0.5f) / kCosines;
      sum += 2 * cosine * ggx_table().at({place_of(cosine), at[0]}).x / kCosines;
    }
    return sum;
  });
  return table.at({place_of_alpha(ggx.alpha_x)});
}

DielectricAlbedo dielectric_albedo(float cosine, float alpha, float eta) {
  constexpr float kSmooth = 0.01f;  // Fresnel's equations change too fast for a table
  if (alpha < kSmooth) {
    const float fresnel = fresnel_dielectric(cosine, eta);
    return {fresnel, 1 - fresnel};
  }
  static const AlbedoTable<Vec2f, 24, 16, 24> table([](const std::array<float, 3>& at) {
    return integrate_dielectric(cosine_at(at[0]), alpha_at(at[1]), eta_at(at[2]));
  });
  const Vec2f value = table.at({place_of(cosine), place_of_alpha(alpha), place_of_eta(eta)});
  return {value.x, value.y};
}

float clearcoat_albedo(float cosine, float gtr1_alpha) {
  static const AlbedoTable<float, 48, 4> table(
      [](const std::array<float, 2>& at) { return integrate_clearcoat(cosine_at(at[0]), lerp(0.001f, 0.1f, at[1])); });
  return table.at({place_of(cosine), (gtr1_alpha - 0.001f) / 0.099f});
}

float sheen_albedo(float cosine) {
  static const AlbedoTable<float, 32> table([](const std::array<float, 1>& at) {
    return cosine_weighted(
        cosine_at(at[0]), [](const Vec3f& wo, const Vec3f& wi) { return DisneySheen{Rgb(1.0f)}.evaluate(wo, wi).f.r; });
  });
  return table.at({place_of(cosine)});
}

float flat_albedo(float cosine, float roughness) {
  static const AlbedoTable<float, 64, 8> table([](const std::array<float, 2>& at) {
    const float cosine = cosine_at(at[0]);
    const auto flat = [&](const Vec3f& wo, const Vec3f& wi) { return DisneyDiffuse::flat(wo, wi, at[1]); };
    return raised(cosine_weighted(cosine, flat), cosine, 0.003f);
  });
  return table.at({place_of(cosine), roughness});
}

}  // namespace alabaster
