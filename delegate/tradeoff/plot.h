// Plots error against time.
#pragma once

#include <string>
#include <vector>

namespace alabaster::tradeoff {

struct PlotPoint {
  double seconds = 0, error = 0;
  double low = 0, high = 0;  // interval of the error; both 0 if unknown
  bool front = false;        // ringed
};

/// One configuration at several sample counts; the line connects the points in order.
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

/// Draws a plot with two logarithmic axes, in which points of the front are ringed, into `file` (.svg or .png), written
/// under a temporary name and renamed. Points whose time or error is not finite and positive are left out. Needs the
/// program gnuplot. Empty on success, else the problem and its remedy; `file` is then unchanged.
std::string draw_plot(const Plot& plot, const std::string& file);

}  // namespace alabaster::tradeoff
