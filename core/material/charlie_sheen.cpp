#include "core/material/charlie_sheen.h"

#include "core/material/albedo_table.h"

namespace alabaster {
namespace {

float integrate(float cosine, float roughness) {
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

}  // namespace

float charlie_albedo(float cosine, float roughness) {
  // Cosines are spaced by their squares: the albedo rises steeply towards the horizon.
  using Table = AlbedoTable<float, 32, 32>;
  static const Table table([](const Table::Place& at) { return integrate(sqr(std::max(0.02f, at[0])), at[1]); });
  return table.at({safe_sqrt(std::clamp(cosine, 0.0f, 1.0f)), roughness});
}

}  // namespace alabaster
