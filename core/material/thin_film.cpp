#include "core/material/thin_film.h"

#include <array>
#include <limits>

#include "core/material/fresnel.h"
#include "core/sampling/warp.h"

namespace alabaster {
namespace {

/// The response of the eye to cos(phase) over the spectrum, `opd` the difference of optical paths in metres: the
/// Gaussians of the paper's appendix, a fit of the CIE 1931 curves, in XYZ and then in Rec.709.
Rgb sensitivity(float opd, const Rgb& shift) {
  constexpr std::array<float, 4> kValue{5.4856e-13f, 4.4201e-13f, 5.2481e-13f, 9.7470e-14f};
  constexpr std::array<float, 4> kPosition{1.6810e6f, 1.7953e6f, 2.2084e6f, 2.2399e6f};
  constexpr std::array<float, 4> kVariance{4.3278e9f, 9.3046e9f, 6.6121e9f, 4.5282e9f};
  constexpr float kScale = 1 / 1.0685e-7f;
  const float phase = kTwoPi * opd;
  const auto gaussian = [&](size_t i, float by) {
    return kScale * kValue[i] * std::sqrt(kTwoPi * kVariance[i]) * std::cos(kPosition[i] * phase + by) *
           std::exp(-phase * phase * kVariance[i]);
  };
  const float x = gaussian(0, shift.r) + gaussian(3, shift.r), y = gaussian(1, shift.g), z = gaussian(2, shift.b);
  return {3.2404542f * x - 1.5371385f * y - 0.4985314f * z, -0.9692660f * x + 1.8760108f * y + 0.0415560f * z,
          0.0556434f * x - 0.2040259f * y + 1.0572252f * z};
}

float f0_between(float n1, float n2) {
  return sqr((n2 - n1) / (n2 + n1));
}

}  // namespace

Rgb ThinFilm::over(const Rgb& bare, float cosine, const Rgb& f0, float f90) const {
  if (!(f90 >= std::numeric_limits<float>::min())) return bare;  // 1 / f90 is no number
  // f90 is a weight of all that is reflected (KHR_materials_specular), the film's light included.
  const Rgb unweighted = clamp01(f0 * (1 / f90));
  const Rgb change = reflectance(cosine, unweighted) - schlick(unweighted, Rgb(1.0f), cosine);
  return clamp01(bare + change * (share * f90));
}

Rgb ThinFilm::reflectance(float cosine, const Rgb& f0) const {
  // A film of no thickness is air: its index rises over the first 30 nanometres (the paper's code, whose unit is the
  // micrometre).
  const float fade = std::clamp(thickness / 30, 0.0f, 1.0f), n = lerp(1.0f, ior, fade * fade * (3 - 2 * fade));
  const float cos2_t = 1 - (1 - sqr(cosine)) / sqr(n);
  if (!(cos2_t > 0)) return Rgb(1.0f);
  const float cos_t = std::sqrt(cos2_t), opd = 2e-9f * n * thickness * cos_t;
  // Schlick's f90 falls with f0, as that of surfaces does: where the film is air nothing is reflected at any angle.
  const float f12 = f0_between(1, n), r12 = lerp(f12, std::min(1.0f, 50 * f12), schlick_weight(cosine)), t121 = 1 - r12;
  // Phases: half a wave where the light meets a denser medium. From below, the film's upper face is the thinner one.
  const float phase21 = n < 1 ? 0 : kPi;
  Rgb r123, constant, shift;
  for (int c = 0; c < 3; ++c) {
    const float root = std::sqrt(std::clamp(f0[c], 0.0f, 0.9999f)), base = (1 + root) / (1 - root);
    const float r23 = lerp(f0_between(n, base), 1.0f, schlick_weight(cos_t));
    shift[c] = phase21 + (base < n ? kPi : 0.0f);
    r123[c] = std::min(r12 * r23, 0.9999f);
    constant[c] = sqr(t121) * r23 / (1 - r123[c]);
  }
  Rgb sum = Rgb(r12) + constant, factor = constant - Rgb(t121);
  for (int m = 1; m <= 2; ++m) {
    const auto order = static_cast<float>(m);
    for (int c = 0; c < 3; ++c) factor[c] *= std::sqrt(r123[c]);
    sum += factor * sensitivity(order * opd, shift * order) * 2.0f;
  }
  return clamp01(sum);
}

}  // namespace alabaster
