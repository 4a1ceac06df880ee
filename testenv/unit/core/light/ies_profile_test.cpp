// Profiles that the tests write, against the closed forms that they are samples of.
#include "core/light/ies_profile.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>
#include <sstream>

#include "core/light/light.h"
#include "core/light/light_shaping.h"
#include "testenv/support/reports.h"

namespace alabaster {
namespace {

constexpr double kRadians = std::numbers::pi / 180;

std::string header(const std::string& tilt = "NONE") {
  return "IESNA:LM-63-1995\r\n[TEST] written by a test\r\n[MANUFAC] none\r\nTILT=" + tilt + "\r\n";
}

struct Angles {
  double first, last;
  int count;
  double at(int i) const { return count == 1 ? first : first + (last - first) * i / (count - 1); }
};

/// A file that samples intensity(vertical, horizontal), in degrees; the multipliers in it make up a factor of 3.
std::string file(const Angles& vertical, const Angles& horizontal,
                 const std::function<double(double, double)>& intensity) {
  std::ostringstream text;
  text.precision(12);
  text << header() << "1 -1 4.0 " << vertical.count << ' ' << horizontal.count << " 1 2 -0.1 -0.1 0\n0.75, 1 100\n";
  for (int i = 0; i < vertical.count; ++i) text << vertical.at(i) << (i % 10 == 9 ? "\n" : " ");
  text << '\n';
  for (int i = 0; i < horizontal.count; ++i) text << horizontal.at(i) << ' ';
  for (int j = 0; j < horizontal.count; ++j) {
    text << '\n';
    for (int i = 0; i < vertical.count; ++i) text << intensity(vertical.at(i), horizontal.at(j)) / 3 << ' ';
  }
  text << '\n';
  return text.str();
}

std::shared_ptr<const IesProfile> parse(const std::string& text) {
  testing::Reports reports;
  auto profile = IesProfile::parse(text, "lamp.ies", reports.sink);
  EXPECT_TRUE(profile) << reports.text();
  return profile;
}

TEST(IesProfile, IsTheFunctionThatItSamples) {
  // cos^2 below, dark above; 2 + cos of the horizontal angle.
  const auto lobe = [](double v, double h) {
    const double c = std::max(0.0, std::cos(v * kRadians));
    return 100 * c * c * (2 + std::cos(h * kRadians));
  };
  const auto profile = parse(file({0, 90, 181}, {0, 180, 181}, lobe));
  for (double v : {0.0, 0.3, 44.9, 89.0})
    for (double h : {0.0, 12.3, 179.5, 200.0, 359.0, -90.0, 725.0})
      EXPECT_NEAR(profile->intensity(v, h), lobe(v, h), 0.05) << v << " " << h;
  EXPECT_EQ(profile->intensity(90.1, 0), 0) << "dark beyond its angles";
  EXPECT_NEAR(profile->mean(), 100 * 2 / 6.0, 0.01);  // half the integral of cos^2 over its cosine, times 2
  EXPECT_NEAR(profile->largest(60, 80), lobe(60, 0), 1e-6);
  EXPECT_EQ(profile->largest(95, 180), 0);
}

TEST(IesProfile, LinearProfilesAreExact) {
  const auto profile = parse(file({0, 180, 4}, {0, 360, 5}, [](double v, double h) { return v + h; }));
  EXPECT_NEAR(profile->intensity(100, 200), 300, 1e-9);
  EXPECT_NEAR(profile->intensity(180, 359.999), 539.999, 1e-9);
  EXPECT_NEAR(profile->mean(), 90 + 180, 1e-9);
}

// The part of the circle that a file leaves out mirrors what it has.
TEST(IesProfile, SymmetriesFillTheCircle) {
  const auto round = parse(file({0, 180, 3}, {0, 0, 1}, [](double v, double) { return v; }));
  EXPECT_NEAR(round->intensity(45, 123), 45, 1e-9);
  const auto quadrant = parse(file({0, 180, 3}, {0, 90, 10}, [](double, double h) { return h; }));
  for (double h : {30.0, 150.0, 210.0, 330.0}) EXPECT_NEAR(quadrant->intensity(45, h), 30, 1e-9) << h;
  const auto half = parse(file({0, 180, 3}, {0, 180, 10}, [](double, double h) { return h; }));
  EXPECT_NEAR(half->intensity(45, 250), 110, 1e-9);
  const auto sideways = parse(file({0, 180, 3}, {90, 270, 10}, [](double, double h) { return h; }));
  EXPECT_NEAR(sideways->intensity(45, 250), 250, 1e-9);
  EXPECT_NEAR(sideways->intensity(45, 30), 150, 1e-9);
  EXPECT_NEAR(sideways->intensity(45, 300), 240, 1e-9);
}

TEST(IesProfile, FilesWithoutAVersionAndWithTrailingTextAreRead) {
  const std::string text = file({0, 90, 3}, {0, 0, 1}, [](double, double) { return 3; });
  EXPECT_TRUE(parse(text.substr(text.find("TILT")) + "\x1a"));
}

// Every fault names file and line and what to do.
TEST(IesProfile, MalformedFilesAreRefusedByName) {
  const std::string good = file({0, 90, 3}, {0, 0, 1}, [](double, double) { return 3; });
  const auto with = [&](const std::string& from, const std::string& to) {
    std::string text = good;
    text.replace(text.find(from), from.size(), to);
    return text;
  };
  struct Case {
    std::string text, line, says;
  };
  for (const auto& [text, line, says] : {
           Case{"", "lamp.ies:0", "no line 'TILT=NONE'"},
           Case{"hello\nworld\n", "lamp.ies:2", "no line 'TILT=NONE'"},
           Case{header("INCLUDE") + "1 2 3", "lamp.ies:4", "'TILT=INCLUDE' is not supported"},
           Case{header("lamp.tlt") + "1 2 3", "lamp.ies:4", "'TILT=lamp.tlt' is not supported"},
           Case{with("3 1 1 2", "3 1 2 2"), "lamp.ies:5", "type B is not supported"},
           Case{with("3 1 1 2", "3 1 3 2"), "lamp.ies:5", "type A is not supported"},
           Case{with("3 1 1 2", "3.5 1 1 2"), "lamp.ies:", "not whole"},
           Case{with("3 1 1 2", "900000 1 1 2"), "lamp.ies:8", "do not ascend"},
           Case{with("3 1 1 2", "-3 1 1 2"), "lamp.ies:5", "the number of vertical angles is out of range"},
           Case{with("0.75, 1", "nan, 1"), "lamp.ies:6", "expected a number, the ballast factor"},
           Case{with("0 45 90", "0 45 45"), "lamp.ies:7", "vertical angles do not ascend"},
           Case{with("0 45 90", "0 45 190"), "lamp.ies:7", "the vertical angle is out of range"},
           Case{with("\n0 \n", "\n5 \n"), "lamp.ies:8", "horizontal angles must go from"},
           Case{with("1 1 1 \n", "1 1 x\n"), "lamp.ies:9", "expected a number, the candela value"},
           Case{with("1 1 1 \n", "1 -1 1\n"), "lamp.ies:9", "the candela value is out of range"},
           Case{with("1 1 1 \n", "1 1 1 1\n"), "lamp.ies:9", "more numbers than"},
           Case{with("1 1 1 \n", "1 1\n"), "lamp.ies:10", "expected a number, the candela value"},
       }) {
    testing::Reports reports;
    EXPECT_FALSE(IesProfile::parse(text, "lamp.ies", reports.sink)) << says;
    EXPECT_NE(reports.text().find(line), std::string::npos) << reports.text();
    EXPECT_NE(reports.text().find(says), std::string::npos) << reports.text();
  }
  testing::Reports reports;
  EXPECT_FALSE(IesProfile::load("/nowhere/lamp.ies", reports.sink));
  EXPECT_FALSE(IesProfile::load("/dev/zero", reports.sink));
  EXPECT_NE(reports.text().find("regular file"), std::string::npos) << reports.text();
  EXPECT_NE(reports.text().find("no such file"), std::string::npos);
}

// A point light of intensity 1 gives the profile's candela: down is local -z, horizontal 0 is +x, 90 is +y.
TEST(IesProfile, ShapesLights) {
  LightParameters d;
  d.type = LightType::sphere;
  d.treat_as_point = true;
  d.ies = parse(file({0, 180, 181}, {0, 360, 361}, [](double v, double h) { return v + 1000 * h; }));
  const auto candela = [&](const Vec3f& p) {
    const Light light = make_light(d, Vec3d(0, 0, 0));
    const auto s = std::visit([&](const auto& l) { return l.sample(p, {0.5f, 0.5f}); }, light);
    EXPECT_GT(std::visit([&](const auto& l) { return l.importance(p); }, light), 0);
    return s ? s->radiance.g * dot(p, p) : 0.0f;
  };
  EXPECT_NEAR(candela({2, 0, 0}), 90, 1e-2);
  EXPECT_NEAR(candela({0, 2, -2}), 90045, 1);
  EXPECT_NEAR(candela({-3, 0, 3}), 180135, 1);
  EXPECT_NEAR(candela({0, -2, 0}), 270090, 1);
  d.ies_angle_scale = 2;  // twice as wide
  EXPECT_NEAR(candela({0, 2, 0}), 90045, 1);
  d.ies_angle_scale = -2;  // about +z
  EXPECT_NEAR(candela({0, 2, 0}), 90135, 1);
  d.ies_angle_scale = 0;
  d.ies_normalize = true;
  EXPECT_NEAR(candela({0, 2, -2}), 90045 / (90 + 180000.0), 1e-5);
  d.light_to_world = Matrix4d(-1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1);  // mirrors x
  d.ies_normalize = false;
  EXPECT_NEAR(candela({-2, 0, 0}), 90, 1e-2);
  EXPECT_NEAR(candela({0, 2, -2}), 90045, 1);
}

// A normalised profile leaves the power of a sphere as it is: the mean of its factor over all directions is 1.
TEST(IesProfile, NormalizedProfilesKeepThePower) {
  LightParameters d;
  d.ies = parse(file({0, 90, 31}, {0, 90, 31},
                     [](double v, double h) { return 5000 * std::cos(v * kRadians) * (1 + std::sin(h * kRadians)); }));
  d.ies_normalize = true;
  const auto shaping = LightShaping::make(d);
  double sum = 0;
  constexpr int kSteps = 400;
  for (int i = 0; i < kSteps; ++i)
    for (int j = 0; j < kSteps; ++j) {
      const double z = -1 + 2 * (i + 0.5) / kSteps, phi = 2 * std::numbers::pi * (j + 0.5) / kSteps,
                   r = std::sqrt(1 - z * z);
      sum += static_cast<double>(shaping->factor(Vec3d(r * std::cos(phi), r * std::sin(phi), z)).g);
    }
  EXPECT_NEAR(sum / (kSteps * kSteps), 1, 1e-3);
  EXPECT_NEAR(shaping->mean(), 1, 1e-6);
}

}  // namespace
}  // namespace alabaster
