// Error against time as a picture: what a table of measurements says, at a glance.
#pragma once

#include <string>
#include <vector>

namespace alabaster::tradeoff {

struct PlotPoint {
  double seconds = 0, error = 0;
  double low = 0, high = 0;  // interval of the error; both 0: not known
};

/// One configuration over its sample counts: points in the order in which the line connects them.
struct PlotLine {
  std::string name;   // stands at the end of the line
  std::string group;  // lines of one group share colour and marker
  std::vector<PlotPoint> points;
};

struct Plot {
  std::string title;
  std::string time_label = "CPU seconds", error_label;
  std::vector<PlotLine> lines;
};

/// Draws a plot, both axes logarithmic, with the Pareto front of all points marked, into `file` (.svg or .png), written
/// under a temporary name and renamed. Points whose time or error is not finite and positive are left out. Needs the
/// program gnuplot. Empty on success, else what is wrong and what to do about it; then `file` is what it was.
std::string draw_plot(const Plot& plot, const std::string& file);

}  // namespace alabaster::tradeoff
