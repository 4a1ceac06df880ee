// A model whose source says no more than what differs from its pose before, as a child process does.
#include "delegate/description/model.h"

#include <gtest/gtest.h>

#include <limits>

namespace alabaster::hd::description {
namespace {

/// A camera moves along x by a unit in a time code from code 3 on, and zooms; a light goes out; a mesh is there up to
/// code 5, and the light's link changes as it goes out. A source of everything says all of that at all times.
class Sliding : public host::SceneSource {
 public:
  explicit Sliding(bool says_all) : says_all_(says_all) {
    facts_.files = {"sliding"};
    facts_.varies = true;
    facts_.timeCodesPerSecond = 30;
  }
  host::SourceFault Open(const std::string&, const host::SourceOptions&, const DiagnosticSink&) override {
    return host::SourceFault::none;
  }
  const host::SceneFacts& Facts() const override { return facts_; }
  host::SourceFault Pose(std::optional<double> time, const DiagnosticSink&, host::SceneEdits* edits) override {
    const double now = time.value_or(0), before = last_.value_or(now);
    if (now > fails_after) return host::SourceFault::input;
    const bool is_first = !last_;
    last_ = now;
    const auto x = [](double t) { return std::max(t - 3, 0.0); };
    host::CameraDescription camera;
    camera.transform[3][0] = x(now);
    camera.parameters = {{"focalLength", float(1 + x(now))}, {"fStop", 8.0f}};
    host::LightDescription light{.type = "sphereLight", .transform = {}, .parameters = {{"radius", 2.0f}}};
    light.parameters["intensity"] = now > 4 ? 0.0f : 1.0f;
    light.parameters["lightLink"] = Token(now > 4 ? "late" : "early");
    if (says_all_ || is_first) edits->set("/eye", camera, "Eye"), edits->set("/lamp", light);
    if (!says_all_ && x(now) != x(before))
      edits->changes["/eye"] = {{"transform", camera.transform}, {"focalLength", camera.parameters.at("focalLength")}};
    if (!says_all_ && (now > 4) != (before > 4))
      edits->changes["/lamp"] = {{"intensity", light.parameters.at("intensity")},
                                 {"lightLink", light.parameters.at("lightLink")}};
    const bool was_there = !is_first && before <= 5, is_there = now <= 5;
    if (is_there && (says_all_ || !was_there)) edits->set("/mesh", host::MeshDescription());
    if (was_there && !is_there) edits->removed.emplace_back("/mesh");
    return host::SourceFault::none;
  }
  double fails_after = std::numeric_limits<double>::infinity();

 private:
  const bool says_all_;
  host::SceneFacts facts_;
  std::optional<double> last_;
};

LoadOptions at_frame(double frame) {
  LoadOptions options;
  options.frame = frame;
  return options;
}

/// The scene after the pose of each frame.
class Posed {
 public:
  explicit Posed(bool says_all, FrameShutter shutter = {}, std::optional<double> fps = {}, bool next_frame = false) {
    auto sliding = std::make_unique<Sliding>(says_all);
    source = sliding.get();
    model_.source = std::move(sliding);
    model_.shutter = shutter;
    model_.next_frame = next_frame;
    model_.frames_per_second = fps;
    model_.placement.transform = Matrix4d().setTranslation(Vec3d(0, 10, 0));
  }
  void set_root(const std::string& root) { model_.root = root; }
  void fail(double frame) {
    host::SceneEdits edits;
    EXPECT_EQ(model_.pose(model_.time_of(at_frame(frame)), {}, &edits), host::SourceFault::input);
  }
  /// Returns what was said.
  host::SceneEdits pose(double frame) {
    host::SceneEdits edits;
    EXPECT_EQ(model_.pose(model_.time_of(at_frame(frame)), {}, &edits), host::SourceFault::none);
    model_.place(&edits);
    EXPECT_EQ(host::ApplyEdits(edits, &scene), "");
    model_.shown();
    return edits;
  }
  host::RetainedSceneDelegate scene;
  Sliding* source = nullptr;

 private:
  OpenModel model_;
};

TEST(OpenModel, DifferencesMakeTheSameSceneAsAllThatThereIs) {
  for (const auto& [shutter, next] : {std::pair{FrameShutter{}, false},
                                      {FrameShutter{-0.5, 0.5}, false},
                                      {FrameShutter{0, 3}, false},
                                      {FrameShutter{}, true},
                                      {FrameShutter{-0.5, 0.5}, true}}) {
    Posed some(false, shutter, {}, next), all(true, shutter, {}, next);
    for (const double frame : {1.0, 2.0, 4.0, 3.0, 5.0, 7.0, 7.5, 4.5, 1.0}) {
      some.pose(frame), all.pose(frame);
      EXPECT_TRUE(some.scene.GetPrims() == all.scene.GetPrims()) << frame;
      EXPECT_EQ(some.scene.GetName("/eye"), "Eye");
      EXPECT_EQ(some.scene.GetMeshes().size(), frame <= 5 ? 1u : 0u) << frame;
    }
  }
}

TEST(OpenModel, FramesAreTimeCodesUnlessAnotherRateIsAskedFor) {
  Posed own(false), slow(false, {0, 1}, 10);
  own.pose(1), slow.pose(1);
  own.pose(4.25), slow.pose(2);
  EXPECT_EQ(own.scene.GetCameras().at("/eye").transform[3][0], 1.25);
  EXPECT_EQ(own.scene.GetCameras().at("/eye").transform[3][1], 10) << "where the model is put";
  const CameraDescription& camera = slow.scene.GetCameras().at("/eye");
  EXPECT_EQ(camera.transform[3][0], 3) << "frame 2 is code 6";
  EXPECT_EQ(camera.transformSamples.times, (std::vector<double>{0, 0.25, 0.5, 0.75, 1}));
  EXPECT_EQ(camera.transformSamples.values.back()[3][0], 6);
}

// Beside those over the shutter, whose places do not depend on it.
TEST(OpenModel, TheNextFrameIsASample) {
  const auto samples = [](FrameShutter shutter, bool next) {
    Posed posed(false, shutter, {}, next);
    posed.pose(4);
    return posed.scene.GetCameras().at("/eye").transformSamples;
  };
  using Times = std::vector<double>;
  EXPECT_EQ(samples({}, false).times, Times());
  EXPECT_EQ(samples({}, true).times, (Times{0, 1}));
  EXPECT_EQ(samples({-0.5, 0.5}, true).times, (Times{-0.5, -0.25, 0, 0.25, 0.5, 1}));
  EXPECT_EQ(samples({0, 2}, true).times, samples({0, 2}, false).times) << "it is within";
  EXPECT_EQ(samples({2, 3}, true).times, (Times{0, 1, 2, 2.25, 2.5, 2.75, 3}));
  const auto next = samples({}, true);
  EXPECT_EQ(next.values[1][3][0] - next.values[0][3][0], 1);
}

// What stands still is not said again, and has no samples.
TEST(OpenModel, WhatStandsStillIsNotSaidAgain) {
  Posed some(false, {0, 0.5});
  some.pose(1);
  const host::SceneEdits edits = some.pose(2);
  EXPECT_TRUE(edits.prims.empty() && edits.changes.empty() && edits.removed.empty());
  EXPECT_TRUE(some.scene.GetCameras().at("/eye").transformSamples.values.empty());
}

// Categories are of the copy of the model that names them.
TEST(OpenModel, AChangedLinkIsThatOfItsCopy) {
  Posed some(false);
  some.set_root("/copy");
  const auto link = [&] { return some.scene.GetLights().at("/copy/lamp").parameters.at("lightLink").text_or(""); };
  some.pose(1);
  EXPECT_EQ(link(), "/copy early");
  some.pose(5);
  EXPECT_EQ(link(), "/copy late");
}

TEST(OpenModel, APoseAfterOneThatFailedHasAllThatChanged) {
  Posed some(false, {0, 1}), all(true, {0, 1});
  some.pose(1), all.pose(1);
  some.source->fails_after = 6.2;  // within the shutter, after the light and the mesh went
  some.fail(6);
  some.source->fails_after = std::numeric_limits<double>::infinity();
  some.pose(7), all.pose(7);
  EXPECT_TRUE(some.scene.GetPrims() == all.scene.GetPrims());
}

}  // namespace
}  // namespace alabaster::hd::description
