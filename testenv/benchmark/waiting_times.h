// Shared by the programs that measure waiting times: a clock, percentiles and images in memory.
#pragma once

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <string>
#include <vector>

#include "delegate/api/types.h"

namespace alabaster::hd {

using Clock = std::chrono::steady_clock;

inline double milliseconds_since(Clock::time_point start) {
  return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

/// The least of the values that `share` of them do not exceed (nearest rank).
inline double percentile(std::vector<double> values, double share) {
  std::sort(values.begin(), values.end());
  const double rank = std::ceil(share * static_cast<double>(values.size()));
  return values[static_cast<size_t>(std::max(rank, 1.0)) - 1];
}

/// A Radiance file in memory; `texel(x, y)` gives its four bytes.
template <class Texel>
AssetPath radiance_image(int width, int height, const Texel& texel) {
  auto bytes = std::make_shared<std::vector<uint8_t>>();
  const std::string head =
      "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y " + std::to_string(height) + " +X " + std::to_string(width) + "\n";
  bytes->assign(head.begin(), head.end());
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const std::array<uint8_t, 4> rgbe = texel(x, y);
      bytes->insert(bytes->end(), rgbe.begin(), rgbe.end());
    }
  return {"sky.hdr", "", bytes};
}

}  // namespace alabaster::hd
