// Sums of samples that do not depend on the order of their terms. So the sums of parts of a pixel's samples add up to
// the very bits of the sum of all, however they are split.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "core/color/rgb.h"

namespace alabaster {

/// Samples that one sum takes without overflow.
inline constexpr uint64_t kMostSummedSamples = uint64_t(1) << 24;

/// A sum of colours of any float brightness. The exponents of floats are cut into fixed bins of 32 bits, and each value
/// into one part for each bin. Each bin sums its parts, exactly. The highest three of the bins that the values reach
/// are kept, which is 65 bits or more below the largest value's first (Demmel and Nguyen 2013, "Fast Reproducible
/// Floating-Point Summation", section 5, with integers). Values that are not finite count as zero.
class RgbSum {
 public:
  void add(const Rgb& value) {
    add(0, value.r);
    add(1, value.g);
    add(2, value.b);
  }
  void add(const RgbSum& other);
  std::array<double, 3> value() const { return {value(0), value(1), value(2)}; }
  /// False for bits that no sum has: they were read from a damaged file.
  bool is_valid() const;

 private:
  static constexpr int kBins = 3, kBinBits = 32;
  static constexpr int kHighestBin = 8;  // floats have bits from 2^-149 to 2^127

  void add(size_t channel, float value);
  /// Moves the kept bins up to `top`. Those that fall out at the lower end are as if they had never been kept.
  void raise(size_t channel, int top);
  double value(size_t channel) const;

  std::array<std::array<int64_t, kBins>, 3> bins_{};  // of each channel, the highest first
  std::array<uint16_t, 4> top_{};                     // of each channel: the number of the highest. The last is unused
};

inline void RgbSum::add(size_t channel, float value) {
  // value = mantissa * 2^(position - 149).
  const auto bits = std::bit_cast<uint32_t>(value);
  const uint32_t exponent = bits >> 23 & 0xff;
  if ((bits & 0x7fffffff) == 0 || exponent == 0xff) return;
  const uint64_t mantissa = (bits & 0x7fffff) | (exponent ? 0x800000 : 0);
  const uint32_t position = exponent ? exponent - 1 : 0;

  // Cut it into the parts of two bins.
  const auto bin = static_cast<int>(position / kBinBits);
  const uint64_t placed = mantissa << position % kBinBits;
  const auto sign = static_cast<int64_t>(bits >> 31) * -2 + 1;
  const auto low = static_cast<int64_t>(placed & 0xffffffff) * sign, high = static_cast<int64_t>(placed >> 32) * sign;

  // Add those that are kept.
  const int highest = high ? bin + 1 : bin;
  if (highest > top_[channel]) [[unlikely]]
    raise(channel, highest);
  const int at = top_[channel] - bin;
  auto& bins = bins_[channel];
  if (at < kBins) bins[static_cast<size_t>(at)] += low;
  if (high && at <= kBins) bins[static_cast<size_t>(at - 1)] += high;
}

inline double RgbSum::value(size_t channel) const {
  const auto& bins = bins_[channel];
  const double sum =
      (static_cast<double>(bins[0]) * 0x1p32 + static_cast<double>(bins[1])) * 0x1p32 + static_cast<double>(bins[2]);
  // 2^(32 (top - 2) - 149)
  constexpr double kUnits[kHighestBin + 1] = {0x1p-213, 0x1p-181, 0x1p-149, 0x1p-117, 0x1p-85,
                                              0x1p-53,  0x1p-21,  0x1p11,   0x1p43};
  return sum * kUnits[top_[channel]];
}

/// A sum of numbers from -2 to 2, in units of 2^-38. Values beyond are clamped; NaN counts as zero.
class UnitSum {
 public:
  void add(float value) {
    if (value != 0)
      units_ += std::lrint(std::clamp(value == value ? static_cast<double>(value) : 0.0, -2.0, 2.0) / kUnit);
  }
  void add(const UnitSum& other) { units_ += other.units_; }
  double value() const { return static_cast<double>(units_) * kUnit; }

 private:
  static constexpr double kUnit = 0x1p-38;
  int64_t units_ = 0;
};

}  // namespace alabaster
