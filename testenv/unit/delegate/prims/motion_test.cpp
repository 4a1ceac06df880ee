// Motion through the contract: time samples, shutters, and what is wrong with them.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "testenv/support/stage.h"

namespace alabaster::hd {
namespace {

constexpr int kSize = 32;  // pixels of an eighth
constexpr double kPixel = 4.0 / kSize;

Matrix4d shifted(double x, double y = 0) {
  return Matrix4d().setTranslation(Vec3d(x, y, 0));
}
TimeSamples<Matrix4d> sideways(double from, double to) {
  return {{0, 1}, {shifted(from), shifted(to)}};
}

class MotionStage : public Stage {
 public:
  MotionStage() : Stage({{"samples", int64_t(256)}}) {
    add_basic_scene();
    quad_ = quad();
    open(0, 1);
  }
  void open(double from, double to) {
    host::CameraDescription camera = scene.GetCameras().at("/camera");
    camera.parameters["shutterOpen"] = from;
    camera.parameters["shutterClose"] = to;
    scene.SetCamera("/camera", camera);
  }
  host::MeshDescription& mesh() { return quad_; }
  void set() { scene.SetMesh("/quad", quad_); }

  std::vector<float> picture() {
    index->SyncAll();
    RenderBuffer* buffer = add_buffer("/color", kSize, kSize, Format::float32vec4);
    index->SyncAll();
    const auto pass = delegate->CreateRenderPass();
    EXPECT_TRUE(finish(*pass, state_for(kSize, kSize, "color", buffer)));
    return pixels<float>(buffer);
  }
  /// Alpha along the row through the middle.
  std::vector<double> coverage() {
    const std::vector<float> all = picture();
    std::vector<double> row;
    for (int x = 0; x < kSize; ++x) row.push_back(double(all[size_t((kSize / 2 * kSize + x) * 4 + 3)]));
    return row;
  }

 private:
  host::MeshDescription quad_;
};

// The share of the shutter in which the quad, whose middle moves from `from` to `to`, covers x.
double share_covered(double x, double from, double to) {
  if (from == to) return std::abs(x - from) <= 1;
  const double a = (x - 1 - from) / (to - from), b = (x + 1 - from) / (to - from);
  return std::max(0.0, std::min(1.0, std::max(a, b)) - std::max(0.0, std::min(a, b)));
}

// Filters of pixels are wider than pixels.
bool is_at_edge(double x, double middle) {
  return std::abs(std::abs(x - middle) - 1) < 2 * kPixel;
}

void expect_coverage(const std::vector<double>& row, double from, double to) {
  for (int x = 0; x < kSize; ++x) {
    const double at = (x + 0.5) * kPixel - 2;
    if (from == to && is_at_edge(at, from)) continue;
    EXPECT_NEAR(row[size_t(x)], share_covered(at, from, to), 0.07)
        << "column " << x << " from " << from << " to " << to;
  }
}

TEST(MotionSync, TheShutterOfTheCameraDecidesAndMayChangeByItself) {
  MotionStage stage;
  stage.mesh().transformSamples = sideways(-1, 1);
  stage.mesh().primvarSamples["points"] = {
      {0, 1}, {stage.mesh().primvars["points"].value, Array<Vec3f>{{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}}}};
  stage.set();
  const std::pair<double, double> shutters[] = {{0, 1}, {0.25, 0.75}, {-3, 0}, {0.5, 0.5}, {0, 0.5}};
  for (const auto& [from, to] : shutters) {
    stage.open(from, to);
    expect_coverage(stage.coverage(), -1 + 2 * std::max(from, 0.0), -1 + 2 * std::max(to, 0.0));
  }
}

TEST(MotionSync, PointsWithSamplesAreBlurred) {
  MotionStage stage;
  const auto moved = [](float x) { return Array<Vec3f>{{x - 1, -1, 0}, {x + 1, -1, 0}, {x + 1, 1, 0}, {x - 1, 1, 0}}; };
  stage.mesh().primvarSamples["points"] = {{0, 0.25, 1}, {moved(-0.5f), moved(0.5f), moved(0.5f)}};
  stage.set();
  std::vector<double> row = stage.coverage();
  for (int x = 0; x < kSize; ++x) {
    const double at = (x + 0.5) * kPixel - 2;
    if (is_at_edge(at, 0.5)) continue;
    EXPECT_NEAR(row[size_t(x)], 0.25 * share_covered(at, -0.5, 0.5) + 0.75 * share_covered(at, 0.5, 0.5), 0.07) << x;
  }
  stage.open(0, 0.25);
  expect_coverage(stage.coverage(), -0.5, 0.5);
}

TEST(MotionSync, InstancersMoveWhatTheyPlace) {
  MotionStage stage;
  host::InstancerDescription inner, outer;
  outer.indices["/inner"] = {0};
  outer.transformSamples = sideways(-0.25, 0.25);
  inner.parent = "/outer";
  inner.indices["/quad"] = {0};
  inner.transformSamples = sideways(-0.25, 0.25);
  stage.scene.SetInstancer("/outer", outer);
  stage.scene.SetInstancer("/inner", inner);
  stage.mesh().instancer = "/inner";
  stage.mesh().transformSamples = sideways(-0.25, 0.25);
  stage.set();
  expect_coverage(stage.coverage(), -0.75, 0.75);
}

TEST(MotionSync, InstancesMoveByThemselves) {
  MotionStage stage;
  host::InstancerDescription instancer;
  instancer.indices["/quad"] = {0, 1};
  const auto placed = [](double x) { return Array<Matrix4d>{shifted(x), shifted(50)}; };
  instancer.primvars["hydra:instanceTransforms"] = placed(0);
  instancer.primvarSamples["hydra:instanceTransforms"] = {{0, 1}, {placed(-0.5), placed(0.5)}};
  stage.scene.SetInstancer("/instancer", instancer);
  stage.mesh().instancer = "/instancer";
  stage.set();
  expect_coverage(stage.coverage(), -0.5, 0.5);
  instancer.primvarSamples["hydra:instanceTransforms"] = {{0, 1}, {placed(-0.5), Array<Matrix4d>{shifted(1)}}};
  stage.scene.SetInstancer("/instancer", instancer);
  expect_coverage(stage.coverage(), 0, 0);
  EXPECT_EQ(stage.count("motion.instances"), 1u);
}

TEST(MotionSync, AShutterWithoutLengthGivesTheBytesOfTheStillScene) {
  MotionStage still, moving;
  moving.open(0, 0);
  moving.mesh().transformSamples = {{-1, 0, 1}, {shifted(-1), Matrix4d(), shifted(1)}};
  const Value points = moving.mesh().primvars["points"].value;
  moving.mesh().primvarSamples["points"] = {{-1, 0, 1},
                                            {points, points, Array<Vec3f>(std::vector<Vec3f>(4, Vec3f(2)))}};
  moving.set();
  EXPECT_EQ(moving.picture(), still.picture()) << "an open shutter shows the same of what does not move";
}

// A fault is reported once, as a warning, and the prim is drawn without blur.
TEST(MotionSync, FaultySamplesAreReported) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto with = [](const TimeSamples<Matrix4d>& samples) {
    MotionStage stage;
    stage.mesh().transformSamples = samples;
    stage.set();
    expect_coverage(stage.coverage(), 0, 0);
    return stage.count("motion.transform");
  };
  EXPECT_EQ(with({{0, 1}, {shifted(1)}}), 1u) << "a value is missing";
  EXPECT_EQ(with({{1, 0}, {shifted(0), shifted(1)}}), 1u);
  EXPECT_EQ(with({{0, nan}, {shifted(0), shifted(1)}}), 1u);
  EXPECT_EQ(with({{0, 1}, {shifted(0), shifted(nan)}}), 1u);
  EXPECT_EQ(with({{0, 1}, {shifted(0), Matrix4d(0.0)}}), 1u) << "not invertible";
  EXPECT_EQ(with({{0}, {shifted(7)}}), 0u) << "a single sample does not move";
}

TEST(MotionSync, FaultySamplesOfALensAreReported) {
  const auto with = [](const Value& samples, const char* code) {
    MotionStage stage;
    host::CameraDescription camera = stage.scene.GetCameras().at("/camera");
    camera.parameters["focalLength:samples"] = samples;
    stage.scene.SetCamera("/camera", camera);
    stage.set();
    const std::vector<double> seen = stage.coverage();
    return std::pair(seen, stage.count(code));
  };
  const auto at = [](std::vector<double> times, std::vector<Value> values) -> Value {
    return std::make_shared<const TimeSamples<Value>>(TimeSamples<Value>{std::move(times), std::move(values)});
  };
  MotionStage still;
  still.set();
  const std::vector<double> wanted = still.coverage();
  EXPECT_EQ(with(at({0, 1}, {2.0f}), "motion.lens"), std::pair(wanted, size_t(1))) << "a value is missing";
  EXPECT_EQ(with(at({1, 0}, {1.0f, 2.0f}), "motion.lens"), std::pair(wanted, size_t(1)));
  EXPECT_EQ(with(at({0, 1}, {1.0f, Matrix4d()}), "motion.lens"), std::pair(wanted, size_t(1)));
  EXPECT_EQ(with(1.0f, "motion.lens"), std::pair(wanted, size_t(1))) << "no samples";
  EXPECT_EQ(with(at({0}, {2.0f}), "motion.lens"), std::pair(wanted, size_t(0))) << "a single sample does not move";
  EXPECT_EQ(with(at({0, 1}, {1.0f, -2.0f}), "parameter.range").second, 1u);
  EXPECT_NE(with(at({0, 1}, {1.0f, 2.0f}), "motion.lens").first, wanted) << "it zooms";
}

TEST(MotionSync, FaultyPointsAreErrors) {
  const auto with = [](const Value& later) {
    MotionStage stage;
    stage.mesh().primvarSamples["points"] = {{0, 1}, {stage.mesh().primvars["points"].value, later}};
    stage.set();
    expect_coverage(stage.coverage(), 0, 0);
    return stage.count("motion.points");
  };
  EXPECT_EQ(with(Array<Vec3f>{{0, 0, 0}}), 1u) << "another number of points";
  EXPECT_EQ(with(Array<Vec3f>(std::vector<Vec3f>(5, Vec3f(1)))), 1u);
  EXPECT_EQ(with(Array<Vec3f>{{0, 0, 0}, {0, 0, 0}, {0, std::nanf(""), 0}, {0, 0, 0}}), 1u);
  EXPECT_EQ(with(std::string("points")), 1u);
}

TEST(MotionSync, AShutterMustNotCloseBeforeItOpens) {
  MotionStage stage;
  stage.mesh().transformSamples = sideways(-1, 1);
  stage.set();
  stage.open(0.5, 0.25);
  expect_coverage(stage.coverage(), 0, 0);
  EXPECT_EQ(stage.count("camera.shutter"), 1u);
}

}  // namespace
}  // namespace alabaster::hd
