#include "testenv/view/player/frame_times.h"

#include <algorithm>

namespace alabaster::view {
namespace {

double quantile(std::vector<double> values, double share) {
  if (values.empty()) return 0;
  std::sort(values.begin(), values.end());
  return values[size_t(share * double(values.size() - 1))];
}

}  // namespace

void FrameTimes::add(double seconds, double work) {
  at_.push_back(seconds);
  work_.push_back(work);
  constexpr size_t kMost = 100000;
  if (at_.size() > kMost) at_.erase(at_.begin()), work_.erase(work_.begin());
}

FrameTimes::Summary FrameTimes::take() {
  Summary s;
  s.frames = int(at_.size());
  std::vector<double> intervals;
  for (size_t i = 1; i < at_.size(); ++i) intervals.push_back(1e3 * (at_[i] - at_[i - 1]));
  if (!intervals.empty()) s.per_second = double(intervals.size()) / (at_.back() - at_.front());
  s.work_median = quantile(work_, 0.5), s.work_p95 = quantile(work_, 0.95);
  s.interval_p95 = quantile(intervals, 0.95), s.interval_worst = quantile(intervals, 1);
  at_.clear(), work_.clear();
  return s;
}

}  // namespace alabaster::view
