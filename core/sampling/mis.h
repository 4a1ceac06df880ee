#pragma once

namespace alabaster {

/// Power heuristic, beta = 2 (Veach 1997, section 9.2.4), for one sample of each of two techniques; for n samples
/// of one, pass n times its pdf. Safe for huge pdfs.
inline float power_heuristic(float pdf, float other_pdf) {
  if (!(pdf > 0)) return 0;
  const float ratio = other_pdf / pdf;
  return 1 / (1 + ratio * ratio);
}

}  // namespace alabaster
