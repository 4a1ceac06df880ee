#include "core/material/charlie_sheen.h"

#include "core/material/albedo_table.h"

namespace alabaster {
namespace {

// Towards the horizon the albedo rises steeply in the cosine, and more so the smoother the fibres.
constexpr float kSteepest = 1e-5f;

float integrate(float cosine, float roughness) {
  constexpr int kRows = 48, kColumns = 32;
  const CharlieSheen lobe{Rgb(1.0f), roughness};
  const Vec3f wo(safe_sqrt(1 - sqr(cosine)), 0, cosine);
  double sum = 0;
  for (int i = 0; i < kRows; ++i)
    for (int j = 0; j < kColumns; ++j) {  // half the hemisphere, by symmetry
      const float t = (float(i) + 0.5f) / kRows, z = sqr(t), s = safe_sqrt(1 - sqr(z));
      const float phi = kPi * (float(j) + 0.5f) / kColumns;
      const Vec3f wi(s * std::cos(phi), s * std::sin(phi), z);
      const float sine2 = 1 - sqr(cosine + z) / (2 + 2 * dot(wo, wi));
      if (sine2 > 0) sum += double(lobe.unlimited(wo, wi, sine2) * z * 2 * t);
    }
  return float(sum * 2 * double(kPi) / (kRows * kColumns));
}

}  // namespace

float charlie_albedo(float cosine, float place) {
  using Table = AlbedoTable<float, 96, 48>;
  static const Table table([](const Table::Place& at) {
    return integrate(std::max(kSteepest, at[0] * at[0] * at[0]), std::pow(CharlieSheen::kMinRoughness, 1 - at[1]));
  });
  return table.at({std::cbrt(std::clamp(cosine, 0.0f, 1.0f)), place});
}

float charlie_place(float roughness) {
  return 1 - std::log(roughness) / std::log(CharlieSheen::kMinRoughness);
}

}  // namespace alabaster
