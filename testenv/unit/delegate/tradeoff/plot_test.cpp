#include "delegate/tradeoff/plot.h"

#include <OpenImageIO/imageio.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>

namespace alabaster::tradeoff {
namespace {

namespace fs = std::filesystem;

class PlotFile : public ::testing::Test {
 protected:
  PlotFile() { fs::create_directories(folder_); }
  ~PlotFile() override { fs::remove_all(folder_); }
  std::string path(const std::string& name) const { return (folder_ / name).string(); }
  static std::string content(const std::string& file) {
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }
  /// The plot as SVG text; empty after a failure.
  std::string svg(const Plot& plot) const {
    const std::string problem = draw_plot(plot, path("a.svg"));
    EXPECT_EQ(problem, "");
    return content(path("a.svg"));
  }
  size_t files() const { return size_t(std::distance(fs::directory_iterator(folder_), {})); }

  fs::path folder_ = fs::temp_directory_path() / ("alabaster_plot_" + std::to_string(::getpid()));
};

Plot example() {
  Plot plot;
  plot.title = "a scene";
  plot.error_label = "relative RMSE";
  for (const char* name : {"walk", "adaptive", "lambert"}) {
    PlotLine line{name, name[0] == 'l' ? "cheap" : "dear", {}};
    for (int i = 1; i <= 4; ++i) {
      const double error = (name[0] == 'a' ? 0.2 : 0.3) / i;
      line.points.push_back({std::pow(4, i), error, 0.9 * error, 1.1 * error, name[0] == 'a'});
    }
    plot.lines.push_back(line);
  }
  return plot;
}

size_t count(const std::string& text, const std::string& part) {
  size_t found = 0;
  for (size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++found;
  return found;
}

TEST_F(PlotFile, DrawsBothKinds) {
  const std::string text = svg(example());
  for (const char* word :
       {"a scene", "relative RMSE", "CPU seconds", "walk", "adaptive", "lambert", "cheap", "dear", "the front"})
    EXPECT_NE(text.find(word), std::string::npos) << word;
  ASSERT_EQ(draw_plot(example(), path("a.png")), "");
  const auto image = OIIO::ImageInput::open(path("a.png"));
  ASSERT_TRUE(image);
  EXPECT_GE(image->spec().width, 1000);
  EXPECT_EQ(files(), 2u);
}

TEST_F(PlotFile, LeavesOutWhatLogarithmsDoNotHave) {
  Plot plot = example();
  const std::string before = svg(plot);
  for (const PlotPoint& bad : {PlotPoint{0, 1, 1, 1}, {1, 0, 0, 1}, {NAN, 1, 1, 1}, {1, INFINITY, 1, 1}, {-1, 1, 1, 1}})
    plot.lines[0].points.push_back(bad);
  plot.lines.push_back({"empty", "none", {}});
  EXPECT_EQ(svg(plot), before);
}

TEST_F(PlotFile, IntervalsMayBeUnknownOrReachDownToNothing) {
  Plot plot = example();
  plot.lines[0].points[0].low = -1;
  plot.lines[0].points[1].high = INFINITY;
  plot.lines[0].points[2] = {64, 0.1};
  const std::string text = svg(plot);
  EXPECT_EQ(count(text, "nan"), 0u);
  EXPECT_EQ(count(text, "inf"), 0u);
}

TEST_F(PlotFile, OnePointIsAPlot) {
  Plot plot;
  plot.lines.push_back({"one", "one", {{1, 1}}});
  EXPECT_NE(svg(plot).find("one"), std::string::npos);
}

// promise: security.no_command
TEST_F(PlotFile, NamesAreTakenLiterally) {
  Plot plot = example();
  plot.title = "it's `touch " + path("title") + "` \"$HOME\" a_b^c\n!touch " + path("line");
  plot.lines[0].name = "';system('touch " + path("name") + "');'";
  plot.lines[0].group = "<g> & \\n";
  const std::string text = svg(plot);
  EXPECT_NE(text.find("it's `touch"), std::string::npos);
  EXPECT_NE(text.find("a_b^c"), std::string::npos);
  EXPECT_NE(text.find("&lt;g> &amp;"), std::string::npos);
  EXPECT_EQ(files(), 1u);
}

TEST_F(PlotFile, ManyAndLongNamesStayInThePicture) {
  Plot plot;
  for (int i = 0; i < 60; ++i)
    plot.lines.push_back({std::string(120, char('a' + i % 26)), std::to_string(i % 9), {{1, 1}, {2, 0.5}}});
  EXPECT_NE(svg(plot), "");
}

TEST_F(PlotFile, SaysWhatIsWrong) {
  EXPECT_NE(draw_plot(Plot{}, path("a.svg")).find("nothing to draw"), std::string::npos);
  EXPECT_NE(draw_plot(example(), path("a.gif")).find("neither .svg nor .png"), std::string::npos);
  const std::string lost = (folder_ / "no" / "a.svg").string();
  EXPECT_NE(draw_plot(example(), lost).find(lost), std::string::npos);
  EXPECT_EQ(files(), 0u);
}

TEST_F(PlotFile, NamesThePackageThatIsMissing) {
  std::ofstream(path("a.svg")) << "before";
  const std::string before = std::getenv("PATH");
  ::setenv("PATH", path("nothing").c_str(), 1);
  const std::string problem = draw_plot(example(), path("a.svg"));
  ::setenv("PATH", before.c_str(), 1);
  EXPECT_NE(problem.find("gnuplot-nox"), std::string::npos) << problem;
  EXPECT_EQ(content(path("a.svg")), "before");
  EXPECT_EQ(files(), 1u);
}

TEST_F(PlotFile, FailureOfGnuplotIsReportedWithItsMessage) {
  const std::string fake = path("gnuplot");
  std::ofstream(fake) << "#!/bin/sh\necho out of ink >&2\nexit 3\n";
  fs::permissions(fake, fs::perms::owner_all);
  const std::string before = std::getenv("PATH");
  ::setenv("PATH", folder_.c_str(), 1);
  const std::string problem = draw_plot(example(), path("a.svg"));
  ::setenv("PATH", before.c_str(), 1);
  EXPECT_NE(problem.find("out of ink"), std::string::npos) << problem;
  EXPECT_FALSE(fs::exists(path("a.svg")));
}

}  // namespace
}  // namespace alabaster::tradeoff
