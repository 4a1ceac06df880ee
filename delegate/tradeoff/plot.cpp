#include "delegate/tradeoff/plot.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <iterator>

#include "delegate/tradeoff/gnuplot.h"

namespace alabaster::tradeoff {
namespace {

namespace fs = std::filesystem;

// Pixels. The margins are fixed, so that names can be placed beside the ends of their lines.
constexpr int kWidth = 1200, kHeight = 760, kLeft = 84, kBottom = 70, kCharacter = 8, kNameHeight = 18, kKeyRow = 18;
constexpr int kTitle = 48, kKeySymbol = 64;
constexpr size_t kManyLines = 8;     // with more, lines are drawn thinner
constexpr size_t kLongestName = 50;  // characters; longer ones are cut off by the picture's edge

/// Okabe and Ito's colours, which the colour-blind can tell apart, without yellow and black, and gnuplot's filled
/// markers.
constexpr const char* kColors[] = {"#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#666666"};
constexpr int kMarkers[] = {7, 5, 9, 13, 11, 15};
/// Lines of one group differ in dash pattern.
constexpr const char* kDashes[] = {"solid", "(14,6)", "(4,4)", "(14,4,3,4)", "(8,3)", "(2,6)"};

struct Style {
  const char* color;
  int marker;
};

/// With six markers and seven colours, 42 groups can be told apart.
Style style_of_group(size_t group) {
  return {kColors[group % std::size(kColors)], kMarkers[group % std::size(kMarkers)]};
}

struct Name {
  std::string text;
  Style style;
  double x, y;    // where its line ends, as fractions of the axes
  double at = 0;  // height of the name itself
};

struct Axis {
  double low = 0, high = 0;
  double place(double value) const { return std::log(value / low) / std::log(high / low); }
};

std::string number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.9g", value);
  return text;
}

/// The plot without the points that a logarithmic axis cannot show.
Plot drawable(const Plot& plot) {
  Plot out = plot;
  for (PlotLine& line : out.lines)
    std::erase_if(line.points, [](const PlotPoint& p) {
      return !(p.seconds > 0 && p.error > 0 && std::isfinite(p.seconds) && std::isfinite(p.error));
    });
  std::erase_if(out.lines, [](const PlotLine& line) { return line.points.empty(); });
  return out;
}

/// The point's interval, or the point itself where none is known.
Axis interval(const PlotPoint& p) {
  const bool known = p.high > 0 && std::isfinite(p.high) && std::isfinite(p.low);
  return known ? Axis{std::min(p.low, p.error), std::max(p.high, p.error)} : Axis{p.error, p.error};
}

struct Terminal {
  std::string options;
  double marker;  // sizes that look alike
};

/// Writes the gnuplot script of one plot.
class Script {
 public:
  Script(const Plot& plot, const Terminal& terminal, const std::string& output)
      : plot_(plot), marker_(terminal.marker) {
    find_axes();
    size_t longest_name = 0;
    for (const PlotLine& line : plot.lines) longest_name = std::max(longest_name, line.name.size());
    right_ = int(std::min(longest_name, kLongestName)) * kCharacter + 48;
    top_ = kTitle + kKeyRow * key_rows() + kKeyRow / 2;
    if (plot.lines.size() > kManyLines) marker_ *= 0.75;
    text_ = "set terminal " + terminal.options + "\nset output " + gnuplot_quoted(output) + "\nset encoding utf8\n";
    frame();
    names();
    curves();
  }
  const std::string& text() const { return text_; }

 private:
  void find_axes() {
    x_ = y_ = {INFINITY, 0};
    for (const PlotLine& line : plot_.lines)
      for (const PlotPoint& p : line.points) {
        x_ = {std::min(x_.low, p.seconds), std::max(x_.high, p.seconds)};
        // An interval that reaches down to zero leaves the picture without stretching it.
        y_ = {std::min(y_.low, std::max(interval(p).low, p.error / 4)), std::max(y_.high, interval(p).high)};
      }
    for (Axis* axis : {&x_, &y_}) {
      const double margin = std::max(std::pow(axis->high / axis->low, 0.05), 1.1);
      *axis = {axis->low / margin, axis->high * margin};
    }
  }

  /// Ticks at 1, 2 and 5 where there are few decades, else one per decade.
  void ticks(const char* name, const Axis& axis) {
    const double decades = std::log10(axis.high / axis.low);
    text_ += std::string("set ") + name + "tics scale 0.6 (";
    std::string list;
    for (int e = int(std::floor(std::log10(axis.low))); e <= int(std::ceil(std::log10(axis.high))); ++e)
      for (int m = 1; m < 10; ++m) {
        const double value = m * std::pow(10.0, e);
        const bool major = m == 1 || (decades < 3 && (m == 2 || m == 5)) || decades < 0.8;
        if (value < axis.low || value > axis.high) continue;
        char label[32];
        std::snprintf(label, sizeof label, "%.6g", value);
        list += (list.empty() ? "" : ", ") + (major ? gnuplot_quoted(label) : "''") + " " + number(value) +
                (major ? " 0" : " 1");
      }
    text_ += list + ")\n";
  }

  void frame() {
    const std::string left = number(double(kLeft) / kWidth);
    const double key_middle = kTitle + 0.5 * kKeyRow * key_rows();
    text_ += "set lmargin at screen " + left + "\nset rmargin at screen " + number(1 - double(right_) / kWidth) +
             "\nset bmargin at screen " + number(double(kBottom) / kHeight) + "\nset tmargin at screen " +
             number(1 - double(top_) / kHeight) + "\n";
    text_ += "set logscale xy\nset xrange [" + number(x_.low) + ":" + number(x_.high) + "]\nset yrange [" +
             number(y_.low) + ":" + number(y_.high) + "]\n";
    ticks("x", x_);
    ticks("y", y_);
    text_ +=
        "set border 3 linecolor '#444444'\nset xtics nomirror\nset ytics nomirror\n"
        "set grid xtics ytics linecolor '#DDDDDD' linewidth 1 dashtype solid\nset grid nomxtics nomytics\n";
    text_ += "set label " + gnuplot_quoted(plot_.title) + " at screen " + left + "," +
             number(1 - 0.5 * kTitle / kHeight) + " left font ',17' noenhanced\nset xlabel " +
             gnuplot_quoted(plot_.time_label) + " noenhanced\nset ylabel " + gnuplot_quoted(plot_.error_label) +
             " noenhanced\n";
    text_ += "set key at screen " + left + "," + number(1 - key_middle / kHeight) +
             " left center horizontal Left reverse noenhanced samplen 2 maxrows " + std::to_string(key_rows()) + "\n";
  }

  /// The groups, in the order of their first occurrence.
  std::vector<std::string> groups() const {
    std::vector<std::string> all;
    for (const PlotLine& line : plot_.lines)
      if (std::find(all.begin(), all.end(), line.group) == all.end()) all.push_back(line.group);
    return all;
  }
  /// Rows of the legend, with as many entries in each as fit; one entry is the front's.
  int key_rows() const {
    std::vector<std::string> all = groups();
    std::erase_if(all, [&](const std::string& group) {  // the name at the line's end tells enough
      return std::any_of(plot_.lines.begin(), plot_.lines.end(),
                         [&](const PlotLine& line) { return line.group == group && line.name == group; });
    });
    size_t longest = std::string("the front").size();
    for (const std::string& group : all) longest = std::max(longest, group.size());
    const int columns = std::max(1, (kWidth - kLeft - right_) / (int(longest) * kCharacter + kKeySymbol));
    return (int(all.size()) + columns) / columns;
  }
  size_t group_of(size_t line) const {
    const std::vector<std::string> all = groups();
    return size_t(std::find(all.begin(), all.end(), plot_.lines[line].group) - all.begin());
  }
  size_t place_in_group(size_t line) const {
    return size_t(std::count_if(plot_.lines.begin(), plot_.lines.begin() + std::ptrdiff_t(line),
                                [&](const PlotLine& other) { return other.group == plot_.lines[line].group; }));
  }
  Style style_of(size_t line) const { return style_of_group(group_of(line)); }

  /// Names stand in a column at the right, each as near to the height of its line's end as the others allow.
  void names() {
    std::vector<Name> names;
    for (size_t i = 0; i < plot_.lines.size(); ++i) {
      const PlotPoint& end = plot_.lines[i].points.back();
      names.push_back({plot_.lines[i].name, style_of(i), x_.place(end.seconds), y_.place(end.error)});
    }
    std::stable_sort(names.begin(), names.end(), [](const Name& a, const Name& b) { return a.y < b.y; });
    const double plot_height = kHeight - kBottom - top_;
    const double step = std::min(kNameHeight / plot_height, 1.0 / double(names.size()));
    spread(names, step);
    for (const Name& name : names) {
      text_ += "set arrow from graph " + number(name.x) + "," + number(name.y) + " to graph 1.012," + number(name.at) +
               " nohead back linewidth 0.7 linecolor '#999999' dashtype (2,4)\n";
      text_ += "set label " + gnuplot_quoted(name.text) + " at graph 1.018," + number(name.at) +
               " left offset 0.7,-0.22 noenhanced textcolor '#222222' point pointtype " +
               std::to_string(name.style.marker) + " pointsize " + number(marker_) + " linecolor '" + name.style.color +
               "'\n";
    }
  }

  /// Least squares under "at least a step apart": neighbours that want to overlap become a block about their mean.
  static void spread(std::vector<Name>& names, double step) {
    struct Block {
      double sum;  // of (wanted height - position in the block)
      size_t count;
      double low(double gap) const { return std::clamp(sum / double(count), 0.0, 1 - gap * double(count - 1)); }
    };
    std::vector<Block> blocks;
    for (const Name& name : names) {
      blocks.push_back({name.y, 1});
      while (blocks.size() > 1) {
        const Block top = blocks.back();
        Block& below = blocks[blocks.size() - 2];
        if (below.low(step) + step * double(below.count) <= top.low(step)) break;
        below = {below.sum + top.sum - step * double(below.count * top.count), below.count + top.count};
        blocks.pop_back();
      }
    }
    size_t next = 0;
    for (const Block& block : blocks)
      for (size_t i = 0; i < block.count; ++i) names[next++].at = block.low(step) + step * double(i);
  }

  void curves() {
    std::vector<const PlotPoint*> front;
    for (const PlotLine& line : plot_.lines)
      for (const PlotPoint& p : line.points)
        if (p.front) front.push_back(&p);
    std::sort(front.begin(), front.end(), [](const auto* a, const auto* b) { return a->seconds < b->seconds; });
    std::string blocks = "$front << EOD\n";
    for (const PlotPoint* p : front) blocks += number(p->seconds) + " " + number(p->error) + "\n";
    if (front.empty()) blocks += "NaN NaN\n";
    blocks += "EOD\n";
    std::string plots = "plot $front with lines linecolor '#D9D9D9' linewidth 7 title 'the front', \\\n";
    for (size_t i = 0; i < plot_.lines.size(); ++i) {
      const std::string data = "$line" + std::to_string(i);
      blocks += data + " << EOD\n";
      for (const PlotPoint& p : plot_.lines[i].points) {
        blocks += number(p.seconds) + " " + number(p.error) + " " + number(std::max(interval(p).low, y_.low)) + " " +
                  number(interval(p).high) + "\n";
      }
      blocks += "EOD\n";
      const Style style = style_of(i);
      const size_t place = place_in_group(i);
      const std::string color = std::string(" linecolor '") + style.color + "'";
      plots +=
          data + " using 1:2:3:4 with yerrorbars pointtype 0 linewidth 1" + color + " notitle, \\\n" + data +
          " using 1:2 with linespoints linewidth " + (plot_.lines.size() > kManyLines ? "1.1" : "1.6") + " pointsize " +
          number(marker_) + " pointtype " + std::to_string(style.marker) + color + " dashtype " +
          kDashes[place % std::size(kDashes)] +
          (place == 0 && plot_.lines[i].group != plot_.lines[i].name ? " title " + gnuplot_quoted(plot_.lines[i].group)
                                                                     : " notitle") +
          ", \\\n";
    }
    plots += "$front with points pointtype 6 pointsize " + number(1.9 * marker_) +
             " linewidth 1.2 linecolor '#222222' notitle\n";
    text_ += blocks + plots;
  }

  const Plot& plot_;
  double marker_;
  Axis x_, y_;
  int right_ = 0, top_ = 0;
  std::string text_;
};

}  // namespace

std::string draw_plot(const Plot& plot, const std::string& file) {
  const std::string ending = fs::path(file).extension().string();
  const std::string size = std::to_string(kWidth) + "," + std::to_string(kHeight);
  Terminal terminal;
  if (ending == ".svg")
    terminal = {"svg size " + size + " name 'tradeoff' noenhanced font 'sans-serif,13' background '#FFFFFF'", 0.75};
  else if (ending == ".png")
    terminal = {"pngcairo size " + size + " noenhanced font 'sans,11' background '#FFFFFF'", 1.1};
  else
    return "'" + file + "' is neither .svg nor .png: use one of these extensions.";

  const Plot shown = drawable(plot);
  if (shown.lines.empty()) return "There is nothing to draw: no point has a positive time and a positive error.";
  return draw_with_gnuplot([&](const std::string& drawn) { return Script(shown, terminal, drawn).text(); }, file);
}

}  // namespace alabaster::tradeoff
