// A medium as the walk wants it: in double precision, with the asymptotic modes that its shortcuts follow.
#pragma once

#include <array>
#include <cmath>
#include <limits>

#include "core/subsurface/dwivedi.h"
#include "core/subsurface/medium.h"

namespace alabaster {

/// One value per colour channel, in double.
using ChannelValues = std::array<double, 3>;

inline double max_value(const ChannelValues& v) {
  return std::max(v[0], std::max(v[1], v[2]));
}
inline double sum_of(const ChannelValues& v) {
  return v[0] + v[1] + v[2];
}

/// alpha in double, from whichever of alpha and 1 - alpha carries more digits, and each channel's extinction above the
/// clearest one's. Ratios of transmittances need no more than that excess: it saves an exponential where channels
/// differ and all of them where they are alike.
struct WalkMedium {
  ChannelValues sigma_t{}, alpha{}, excess{};

  explicit WalkMedium(const Medium& medium) {
    double clearest = std::numeric_limits<double>::infinity();
    for (int c = 0; c < 3; ++c) {
      const auto i = static_cast<size_t>(c);
      sigma_t[i] = medium.sigma_t[c];
      alpha[i] = medium.alpha[c] < 0.5f ? medium.alpha[c] : 1.0 - medium.one_minus_alpha[c];
      if (medium.active[c]) clearest = std::min(clearest, sigma_t[i]);
    }
    for (size_t c = 0; c < 3; ++c) excess[c] = medium.active[c] ? sigma_t[c] - clearest : 0;
  }
};

/// How light falls off far from all surfaces, per channel: as exp(-kappa distance). Only for walks with shortcuts.
struct DiffusionModes {
  std::array<DwivediMode, 3> mode{};
  ChannelValues kappa{};         // sigma_t x, 1/world unit
  std::array<bool, 3> guided{};  // worth guiding, and safe in the arithmetic used

  DiffusionModes(const WalkMedium& walk_medium, const Medium& medium) {
    for (size_t c = 0; c < 3; ++c) {
      if (!medium.active[c]) continue;
      mode[c] = dwivedi_mode(medium.one_minus_alpha[static_cast<int>(c)]);
      kappa[c] = walk_medium.sigma_t[c] * mode[c].x;
      guided[c] = is_guided(medium.one_minus_alpha[static_cast<int>(c)]);
    }
  }
  /// Near white the guided lobe is all but isotropic (nu0 > 180); near black (nu0 < 1.003) nothing scatters twice.
  static bool is_guided(float one_minus_alpha) { return one_minus_alpha > 1e-5f && one_minus_alpha < 0.7f; }
};

}  // namespace alabaster
