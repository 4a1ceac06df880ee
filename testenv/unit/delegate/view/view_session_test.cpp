// A scene on show, without a window.
#include "delegate/view/view_session.h"

#include <chrono>
#include <thread>

#include "testenv/unit/delegate/description/scene_fixture.h"

namespace alabaster::view {
namespace {

using hd::description::LoadOptions;
using hd::host::RetainedSceneDelegate;

class ViewSessionTest : public hd::description::SceneFiles {
 protected:
  ~ViewSessionTest() override { session.reset(); }

  // The patch before its camera below a white sky, in 32 x 24 pixels, refined nearly without end.
  void open(std::vector<std::string> overrides = {}, const std::string& file = "lit.gltf") {
    LoadOptions options;
    options.dome = "1";
    options.overrides = {"resolution=[32,24]", "samples=1000000"};
    options.overrides.insert(options.overrides.end(), overrides.begin(), overrides.end());
    const hd::DiagnosticSink sink = [this](const hd::Diagnostic& d) {
      const std::lock_guard lock(mutex_);
      diagnostics.push_back(d);
    };
    ASSERT_NO_THROW(loaded.load(folder_ / file, options, sink)) << errors();
    ASSERT_NO_THROW(loaded.choose_colors("built-in", sink, 3));
    ASSERT_NO_THROW(loaded.start(sink));
    session = std::make_unique<ViewSession>(&loaded, sink);
  }

  std::vector<std::string> told() {
    const std::lock_guard lock(mutex_);
    std::vector<std::string> texts;
    for (const hd::Diagnostic& d : diagnostics) texts.push_back(d.text);
    return texts;
  }

  double alpha(double x, double y) {
    const std::vector<float> color = session->values_at(x, y);
    return color.size() == 4 ? double(color[3]) : -1;
  }

  // Updates until `condition` of the status holds; false after a minute.
  template <class Condition>
  bool update_until(const Condition& condition) {
    const auto start = std::chrono::steady_clock::now();
    while (std::chrono::steady_clock::now() - start < std::chrono::minutes(1)) {
      session->update();
      if (condition(session->status())) return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    return false;
  }

  cli::SceneSession loaded;
  std::unique_ptr<ViewSession> session;

 private:
  std::mutex mutex_;
};

TEST_F(ViewSessionTest, TheNoiseIsKnownWhileItRefinesWithoutATarget) {
  open();
  EXPECT_TRUE(update_until([](const ViewStatus& s) { return s.noise > 0 && s.noise_samples > 0; }));
  const ViewStatus status = session->status();
  EXPECT_EQ(status.state, hd::PassState::rendering);
  EXPECT_LE(status.noise_samples, double(status.samples) + 1);
  EXPECT_EQ(session->setting("targetError").number_or(-1), 0) << "nobody has asked for one";
  EXPECT_EQ(status.samples_total, 1000000u);
}

// The patch moves by its width while the shutter is open, and so does the camera, upwards.
TEST_F(ViewSessionTest, APlacedCameraStandsStillAndObjectsGoOnMoving) {
  write("scene.json", R"({"gltf": [{"file": "lit.gltf", "motion": [{"time": 0, "transform": {}},
      {"time": 1, "transform": {"translate": [2, 0, 0]}}]}],
    "camera": {"motion": [{"time": 0, "transform": {"translate": [0, 0, 8]}},
      {"time": 1, "transform": {"translate": [0, 0.5, 8]}}], "shutterOpen": 0, "shutterClose": 1}})");
  open({"samples=64"}, "scene.json");
  ASSERT_TRUE(session->camera_moves());
  const auto done = [](const ViewStatus& s) { return s.state == hd::PassState::converged; };
  hd::CameraDescription camera = session->camera();
  camera.parameters["fStop"] = 8.0f;
  session->set_camera(camera);
  EXPECT_TRUE(session->is_camera_motion_kept()) << "another lens is no other place";
  EXPECT_EQ(told(), std::vector<std::string>());
  for (int i = 1; i <= 2; ++i) {
    camera = session->camera();
    camera.transform[3][0] += 0.01;
    session->set_camera(camera);
    EXPECT_FALSE(session->is_camera_motion_kept());
    ASSERT_EQ(told().size(), 1u) << "it is said once";
    EXPECT_NE(told()[0].find("stands still"), std::string::npos);
  }
  ASSERT_TRUE(update_until(done));
  // Half of the time the patch is left of x = 1, where it ends at first, and half of the time right of it.
  const Sight sight = session->sight();
  const auto column = [&](double x) { return 0.5 + x / 8 / sight.width; };
  EXPECT_NEAR(alpha(column(0), 0.5), 0.5, 0.15);
  EXPECT_NEAR(alpha(column(2), 0.5), 0.5, 0.15);
  EXPECT_NEAR(alpha(column(1), 0.5), 1, 0.1);
  session->reset_camera();
  EXPECT_TRUE(session->is_camera_motion_kept());
}

TEST_F(ViewSessionTest, AnEditThatTheSceneRefusesIsReported) {
  open({"samples=1"});
  const hd::Path gone("/materials/gone");
  const ParameterRow row = parameter_rows("disney_material").front();
  session->edit(gone, [&] { return session->edits().set(gone, row, row.default_value); });
  ASSERT_EQ(told().size(), 1u);
  EXPECT_EQ(diagnostics[0].code, "view.edit");
  EXPECT_EQ(diagnostics[0].where, gone.str());
}

TEST(SecondsTo, CountsFromNowOn) {
  ViewStatus status;
  EXPECT_LT(seconds_to(status, 0.01), 0) << "nothing is known yet";
  status.noise = 0.1, status.noise_samples = 4, status.samples = 8, status.seconds = 10;
  EXPECT_DOUBLE_EQ(seconds_to(status, 0.05), 4 * 5 - 10) << "a quarter of the noise's square; it was that after 5 s";
  EXPECT_EQ(seconds_to(status, 0.2), 0) << "reached";
}

}  // namespace
}  // namespace alabaster::view
