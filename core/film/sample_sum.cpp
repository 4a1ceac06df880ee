#include "core/film/sample_sum.h"

namespace alabaster {

void RgbSum::raise(size_t channel, int top) {
  auto& bins = bins_[channel];
  for (int i = kBins - 1; i >= 0; --i) {
    const int from = i - (top - top_[channel]);
    bins[static_cast<size_t>(i)] = from >= 0 ? bins[static_cast<size_t>(from)] : 0;
  }
  top_[channel] = static_cast<uint16_t>(top);
}

void RgbSum::add(const RgbSum& other) {
  for (size_t c = 0; c < 3; ++c) {
    if (other.top_[c] > top_[c]) raise(c, other.top_[c]);
    const auto lower = static_cast<size_t>(top_[c] - other.top_[c]);
    for (size_t i = lower; i < kBins; ++i) bins_[c][i] += other.bins_[c][i - lower];
  }
}

bool RgbSum::is_valid() const {
  constexpr int64_t kMost = int64_t(kMostSummedSamples) << kBinBits;
  for (size_t c = 0; c < 3; ++c) {
    if (top_[c] > kHighestBin) return false;
    for (const int64_t bin : bins_[c])
      if (bin > kMost || bin < -kMost) return false;
  }
  return true;
}

}  // namespace alabaster
