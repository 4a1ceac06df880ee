#include "core/material/charlie_sheen.h"

#include <array>

namespace alabaster {
namespace {

constexpr int kSize = 32;  // cells per axis

// Cosines are spaced by their squares: the albedo rises steeply towards the horizon.
struct AlbedoTable {
  std::array<std::array<float, kSize + 1>, kSize + 1> values{};

  AlbedoTable() {
    for (int r = 0; r <= kSize; ++r)
      for (int c = 0; c <= kSize; ++c)
        values[size_t(r)][size_t(c)] = integrate(sqr(std::max(0.02f, float(c) / kSize)), float(r) / kSize);
  }

  static float integrate(float cosine, float roughness) {
    constexpr int kRows = 48, kColumns = 48;
    const CharlieSheen lobe = CharlieSheen::from(Rgb(1.0f), roughness);
    const Vec3f wo(safe_sqrt(1 - sqr(cosine)), 0, cosine);
    double sum = 0;
    for (int i = 0; i < kRows; ++i)
      for (int j = 0; j < kColumns; ++j) {  // half the hemisphere, by symmetry
        const float z = (float(i) + 0.5f) / kRows, s = safe_sqrt(1 - sqr(z)), phi = kPi * (float(j) + 0.5f) / kColumns;
        const Vec3f wi(s * std::cos(phi), s * std::sin(phi), z);
        if (const auto facet = mirror_facet(wo, wi)) sum += double(lobe.unlimited(wo, wi, facet->wm) * z);
      }
    return float(sum * 2 * double(kPi) / (kRows * kColumns));
  }
};

}  // namespace

float charlie_albedo(float cosine, float roughness) {
  static const AlbedoTable table;
  const float x = safe_sqrt(std::clamp(cosine, 0.0f, 1.0f)) * kSize, y = std::clamp(roughness, 0.0f, 1.0f) * kSize;
  const int i = std::min(int(x), kSize - 1), j = std::min(int(y), kSize - 1);
  const float u = x - float(i), v = y - float(j);
  const auto& low = table.values[size_t(j)];
  const auto& high = table.values[size_t(j) + 1];
  return lerp(lerp(low[size_t(i)], low[size_t(i) + 1], u), lerp(high[size_t(i)], high[size_t(i) + 1], u), v);
}

}  // namespace alabaster
