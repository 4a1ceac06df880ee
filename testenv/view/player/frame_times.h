// How smoothly a window is drawn.
#pragma once

#include <vector>

namespace alabaster::view {

class FrameTimes {
 public:
  /// A picture of the window that appeared at `seconds`, after `work` milliseconds of this thread.
  void add(double seconds, double work);

  struct Summary {
    int frames = 0;
    double per_second = 0;
    double work_median = 0, work_p95 = 0, interval_p95 = 0, interval_worst = 0;  // milliseconds
  };
  /// Covers all pictures since the last call.
  Summary take();

 private:
  std::vector<double> at_, work_;
};

}  // namespace alabaster::view
