#include "core/subsurface/lit_surface.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/math/elementary.h"
#include "core/math/vector.h"

namespace alabaster {
namespace {

// A point is dark below this share of the mean irradiance; a body is lit unevenly if this share of its area is dark.
constexpr double kDark = 0.25, kUneven = 0.1;
// Where less of the irradiance of what is lit comes through the body, light that other surfaces bring is more.
constexpr float kLeastLevel = 0.0003f;

}  // namespace

std::optional<LitSurface> LitSurface::choose(const std::vector<LitPoint>& points) {
  double power = 0, squared = 0, area = 0, dark = 0;
  for (const LitPoint& point : points) {
    power += static_cast<double>(point.irradiance) * point.area;
    squared += static_cast<double>(point.irradiance) * point.irradiance * point.area;
    area += point.area;
  }
  for (const LitPoint& point : points)
    if (point.irradiance * area < kDark * power) dark += point.area;
  if (!(power > 0) || !(dark > kUneven * area)) return std::nullopt;
  LitSurface chosen;
  // The area that has as much light at the mean irradiance of the points, weighted by their light.
  chosen.area_of_each_ = static_cast<float>(power * power / squared / kPoints);
  double passed = 0;
  size_t kept = 0;
  for (const LitPoint& point : points) {
    passed += static_cast<double>(point.irradiance) * point.area;
    for (; kept < kPoints && (static_cast<double>(kept) + 0.5) * power < passed * kPoints; ++kept) {
      chosen.x_[kept] = point.p.x, chosen.y_[kept] = point.p.y, chosen.z_[kept] = point.p.z;
      chosen.nx_[kept] = point.inward.x, chosen.ny_[kept] = point.inward.y, chosen.nz_[kept] = point.inward.z;
      chosen.facing_ -= point.inward * (1.0f / kPoints);
    }
  }
  return chosen;
}

Vec3f LitSurface::direction_from(const Vec3f& p, float kappa) const {
  float gx = 0, gy = 0, gz = 0, level = 0;
  for (size_t i = 0; i < kPoints; ++i) {
    const float dx = p.x - x_[i], dy = p.y - y_[i], dz = p.z - z_[i];
    const float r2 = std::max(dx * dx + dy * dy + dz * dz, std::numeric_limits<float>::min()), r = std::sqrt(r2);
    const float height = std::max(0.0f, dx * nx_[i] + dy * ny_[i] + dz * nz_[i]);
    const float x = std::min(kappa * r, 80.0f);
    const float falloff = (1 + x) * quick_exp(-x) * (height / r) * (1 / r2);
    const float weight = (1 + x) * falloff / r;
    level += falloff;
    gx -= weight * dx, gy -= weight * dy, gz -= weight * dz;
  }
  if (!(level * area_of_each_ > kTwoPi * kLeastLevel)) return {0, 0, 0};
  const Vec3f g(gx, gy, gz);
  const float length_of_g = length(g);
  return length_of_g > 0 && std::isfinite(length_of_g) ? g * (1 / length_of_g) : Vec3f(0, 0, 0);
}

}  // namespace alabaster
