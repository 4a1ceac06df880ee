// A medium as walks need it: in double precision, with the asymptotic modes that the shortcuts follow. Made once per
// material where no texture varies it, else once per entry.
#pragma once

#include <algorithm>
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

/// The decay of light far from all surfaces, per channel: exp(-kappa distance).
struct DiffusionModes {
  std::array<DwivediMode, 3> mode{};
  ChannelValues kappa{};         // sigma_t x, 1/world unit
  std::array<bool, 3> guided{};  // worth guiding, and safe in the arithmetic used

  /// Near white the guided lobe is all but isotropic (nu0 > 180); near black (nu0 < 1.003) nothing scatters twice.
  static bool is_guided(float one_minus_alpha) { return one_minus_alpha > 1e-5f && one_minus_alpha < 0.7f; }
};

struct WalkShortcuts {
  bool guiding = false, sphere_steps = false;
};

/// Sphere steps pay in a channel with a smaller 1 - alpha (A > 0.7): walks are long enough there.
inline constexpr float kSphereStepsPayBelow = 0.024f;

/// Guiding does not pay where the clearest channel has a smaller 1 - alpha (A > 0.97): walks are long in that channel,
/// guiding hardly shortens them, and every event pays for it.
inline constexpr float kGuidingPaysAbove = 2e-4f;

/// Guiding back to the surface does not pay where it has a smaller one (A > 0.92): the twin has taken the noise of lit
/// places, and elsewhere every event pays for the guiding.
inline constexpr float kGuidingBackPaysAbove = 1.2e-3f;

/// 1 - alpha of the clearest channel; above 1 if none scatters.
inline float least_absorption(const Medium& medium) {
  float least = 2;
  for (int c = 0; c < 3; ++c)
    if (medium.active[c]) least = std::min(least, medium.one_minus_alpha[c]);
  return least;
}

/// The shortcuts that pay in a medium: none where scattering has a preferred direction.
inline WalkShortcuts worthwhile_shortcuts(const Medium& medium) {
  if (medium.g != 0) return {};
  const float clearest = least_absorption(medium);
  bool guided = false;
  for (int c = 0; c < 3; ++c) guided |= medium.active[c] && DiffusionModes::is_guided(medium.one_minus_alpha[c]);
  return {guided && clearest > kGuidingPaysAbove, clearest < kSphereStepsPayBelow};
}

/// `alpha` comes from whichever of alpha and 1 - alpha carries more digits. `excess` is each channel's extinction above
/// the clearest one's: ratios of transmittances need no more, which saves an exponential where channels differ and all
/// of them where they are alike.
struct WalkMedium {
  Medium medium;
  ChannelValues sigma_t{}, alpha{}, excess{};
  WalkShortcuts worthwhile;  // of those allowed
  bool pays_to_guide_back;   // to the surface of a closed mesh, if guiding is worthwhile
  DiffusionModes modes;      // only where a shortcut is worthwhile

  /// `shortcuts`: those that the walk may take; the modes are found for them alone.
  // NOLINTNEXTLINE(google-explicit-constructor): the same medium, in the form that the loop reads
  WalkMedium(const Medium& m, WalkShortcuts shortcuts = {true, true})
      : medium(m),
        worthwhile(worthwhile_shortcuts(m)),
        pays_to_guide_back(least_absorption(m) > kGuidingBackPaysAbove) {
    worthwhile.guiding &= shortcuts.guiding;
    worthwhile.sphere_steps &= shortcuts.sphere_steps;
    double clearest = std::numeric_limits<double>::infinity();
    for (int c = 0; c < 3; ++c) {
      const auto i = static_cast<size_t>(c);
      sigma_t[i] = m.sigma_t[c];
      alpha[i] = m.alpha[c] < 0.5f ? m.alpha[c] : 1.0 - m.one_minus_alpha[c];
      if (m.active[c]) clearest = std::min(clearest, sigma_t[i]);
    }
    for (size_t c = 0; c < 3; ++c) excess[c] = m.active[c] ? sigma_t[c] - clearest : 0;
    if (worthwhile.guiding || worthwhile.sphere_steps) find_modes();
  }

  /// 1/nu0 of a channel.
  double x_of(size_t c) const {
    return worthwhile.guiding || worthwhile.sphere_steps ? modes.mode[c].x
                                                         : dwivedi_mode(medium.one_minus_alpha[static_cast<int>(c)]).x;
  }

  /// World units; 0: nothing scatters.
  float longest_mean_free_path() const {
    float longest = 0;
    for (int c = 0; c < 3; ++c)
      if (medium.active[c] && medium.sigma_t[c] > 0) longest = std::max(longest, 1 / medium.sigma_t[c]);
    return longest;
  }

 private:
  void find_modes() {
    for (size_t c = 0; c < 3; ++c) {
      if (!medium.active[c]) continue;
      const float complement = medium.one_minus_alpha[static_cast<int>(c)];
      modes.mode[c] = dwivedi_mode(complement);
      modes.kappa[c] = sigma_t[c] * modes.mode[c].x;
      modes.guided[c] = DiffusionModes::is_guided(complement);
    }
  }
};

/// The media of one material, by albedo inversion: which one a render wants is a setting, known after the commit.
class MaterialMedia {
 public:
  MaterialMedia(const Rgb& albedo, const Rgb& scatter_distance, float g)
      : media_{make_medium(albedo, scatter_distance, AlbedoInversion::chiang2016, g),
               make_medium(albedo, scatter_distance, AlbedoInversion::exact, g)} {}
  const WalkMedium& operator[](AlbedoInversion inversion) const { return media_[static_cast<size_t>(inversion)]; }

 private:
  std::array<WalkMedium, 2> media_;  // in the order of AlbedoInversion
};

}  // namespace alabaster
