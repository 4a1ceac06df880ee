// A scene on show, without a window.
#include "delegate/view/view_session.h"

#include <chrono>
#include <fstream>
#include <functional>
#include <thread>

#include "testenv/unit/delegate/description/scene_fixture.h"
#include "testenv/unit/delegate/view/row_of.h"

namespace alabaster::view {
namespace {

using hd::description::LoadOptions;
using hd::host::RetainedSceneDelegate;

class ViewSessionTest : public hd::description::SceneFiles {
 protected:
  ~ViewSessionTest() override { session.reset(); }

  std::unique_ptr<cli::SceneSession> load_session(const std::string& file, const LoadOptions& options,
                                                  const hd::DiagnosticSink& sink) const {
    auto loaded = std::make_unique<cli::SceneSession>();
    loaded->load(folder_ / file, options, sink);
    loaded->choose_colors("built-in", sink, 3);
    loaded->start(sink);
    return loaded;
  }

  // The patch before its camera below a white sky, in 32 x 24 pixels, refined nearly without end.
  void open(std::vector<std::string> overrides = {}, const std::string& file = "lit.gltf") {
    options.dome = "1";
    options.overrides = {"resolution=[32,24]", "samples=1000000"};
    options.overrides.insert(options.overrides.end(), overrides.begin(), overrides.end());
    sink = [this](const hd::Diagnostic& d) {
      const std::lock_guard lock(mutex_);
      diagnostics.push_back(d);
    };
    std::unique_ptr<cli::SceneSession> loaded;
    ASSERT_NO_THROW(loaded = load_session(file, options, sink)) << errors();
    session = std::make_unique<ViewSession>(std::move(loaded), sink);
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

  LoadOptions options;
  hd::DiagnosticSink sink;
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

bool converged(const ViewStatus& s) {
  return s.state == hd::PassState::converged;
}

// As the textures of the window have it.
std::vector<uint8_t> levels(const PictureRequest& request) {
  hd::PixelMemory memory;
  memory.format = hd::Format::unorm8vec4, memory.transform = request.display.get();
  std::vector<uint8_t> rgba;
  EXPECT_TRUE(resolve(request.buffer, 4, &memory, &rgba));
  return rgba;
}

TEST_F(ViewSessionTest, AKeptPictureIsShownAsTheBufferWas) {
  open({"samples=4"});
  EXPECT_FALSE(session->keep_look()) << "nothing is rendered yet";
  ASSERT_TRUE(update_until(converged));
  for (const char* aov : {"color", "cameraDepth", "normal"}) {
    session->show_aov(aov);
    ASSERT_TRUE(update_until(converged));
    const std::vector<uint8_t> live = levels(session->left());
    EXPECT_GT(std::count_if(live.begin(), live.end(), [](uint8_t level) { return level > 0 && level < 255; }), 100);
    ASSERT_TRUE(session->keep_look());
    EXPECT_EQ(session->kept_look()->samples, 4u);
    EXPECT_NE(session->left().buffer, session->right().buffer);
    EXPECT_EQ(levels(session->left()), live) << aov;
    session->set_exposure(session->exposure() + 1);
    EXPECT_EQ(levels(session->left()), levels(session->right())) << aov << ", brighter";
    session->drop_look();
  }
}

TEST_F(ViewSessionTest, ValuesAreThoseOfTheSideThatIsPointedAt) {
  open({"samples=1"});
  ASSERT_TRUE(update_until(converged));
  session->set_divider(0.6);
  const std::vector<float> before = session->values_at(0.55, 0.5);
  ASSERT_TRUE(session->keep_look());
  const hd::Path dome("/lights/dome");
  const ParameterRow intensity = row_of("lights", "intensity");
  session->edit(dome, [&] { return session->edits().set(dome, intensity, 0.25); });
  ASSERT_TRUE(update_until(converged));
  const std::vector<float> kept = session->values_at(0.55, 0.5), live = session->values_at(0.65, 0.5);
  ASSERT_EQ(live.size(), 4u);
  EXPECT_EQ(kept, before);
  EXPECT_LT(live[0], 0.8f * kept[0]);
}

TEST_F(ViewSessionTest, LooksAreSwappedWithTheirLightsAndSettings) {
  open({"samples=1"});
  ASSERT_TRUE(update_until(converged));
  ASSERT_TRUE(session->keep_look());
  const hd::Path added = session->add_light("rectLight", 0.5, 0.5);
  EXPECT_FALSE(session->swap_looks()) << "the picture is still that without the light";
  const ParameterRow depth = row_of("render_settings", "maxDepth");
  session->set_setting(depth, 3);
  ASSERT_TRUE(update_until(converged));
  session->swap_looks();
  EXPECT_TRUE(session->edits().record().added.empty());
  EXPECT_FALSE(session->is_setting_changed("maxDepth"));
  ASSERT_TRUE(update_until(converged));
  session->swap_looks();
  EXPECT_EQ(session->edits().lights().size(), 3u);
  EXPECT_TRUE(session->edits().is_added(added));
  EXPECT_EQ(session->setting("maxDepth").number_or(0), 3);
}

// Until the edited scene is built, the pass has the picture of the one before.
TEST_F(ViewSessionTest, APictureOfEarlierEditsIsNotKept) {
  open({"samples=1"});
  ASSERT_TRUE(update_until(converged));
  const hd::Path dome("/lights/dome");
  const ParameterRow intensity = row_of("lights", "intensity");
  float before = session->values_at(0.5, 0.5)[0];
  for (const double factor : {0.25, 0.0625}) {
    session->edit(dome, [&] { return session->edits().set(dome, intensity, factor); });
    ASSERT_TRUE(update_until([&](const ViewStatus&) { return session->keep_look(); }));
    const float kept = session->values_at(0.25, 0.5)[0];  // left of the divider
    EXPECT_LT(kept, 0.8f * before);
    before = kept;
    session->drop_look();
  }
  hd::CameraDescription away = session->camera();
  away.transform[3][0] += 1;
  session->set_camera(away);
  EXPECT_FALSE(session->keep_look()) << "the picture is of the camera before";
}

TEST_F(ViewSessionTest, ALookThatIsSwappedToAndFroLosesNoSample) {
  open({"samples=64"});
  ASSERT_TRUE(update_until(converged));
  const std::vector<uint8_t> first = levels(session->left());
  ASSERT_TRUE(session->keep_look());
  const hd::Path dome("/lights/dome");
  const ParameterRow intensity = row_of("lights", "intensity");
  session->edit(dome, [&] { return session->edits().set(dome, intensity, 0.25); });
  ASSERT_TRUE(update_until(converged));
  const std::vector<uint8_t> second = levels(session->right());
  for (int i = 0; i < 2; ++i) {
    ASSERT_TRUE(session->swap_looks()) << "at once";
    session->update();
    const bool is_first = i == 0;
    EXPECT_EQ(levels(session->right()), is_first ? first : second);
    EXPECT_EQ(levels(session->left()), is_first ? second : first);
    EXPECT_EQ(session->kept_look()->samples, 64u);
  }
  EXPECT_TRUE(update_until([&](const ViewStatus&) { return !session->stand_in(); })) << "it is rendered again";
  EXPECT_EQ(session->status().samples, 64u);
  EXPECT_EQ(levels(session->right()), second);

  const std::pair<const char*, std::function<void()>> kEnds[] = {
      {"an edit", [&] { session->edit(dome, [&] { return session->edits().set(dome, intensity, 0.5); }); }},
      {"another lens",
       [&] {
         hd::CameraDescription camera = session->camera();
         camera.parameters["fStop"] = 8.0f;
         session->set_camera(camera);
       }},
      {"another AOV", [&] { session->show_aov("cameraDepth"); }}};
  for (const auto& [name, end] : kEnds) {
    ASSERT_TRUE(session->swap_looks());
    ASSERT_NE(session->stand_in(), nullptr) << name;
    end();
    EXPECT_EQ(session->stand_in(), nullptr) << name;
    session->reset_camera();
    session->show_aov("color");
    session->drop_look();
    ASSERT_TRUE(update_until([&](const ViewStatus& s) { return converged(s) && session->keep_look(); }));
  }
  session->reload(load_session("lit.gltf", options, sink));
  ASSERT_TRUE(update_until(converged));
  ASSERT_TRUE(session->swap_looks());
  EXPECT_EQ(session->stand_in(), nullptr) << "its picture is of the file before";
}

TEST_F(ViewSessionTest, TheQualityIsThatOfTheSettingsInForce) {
  open({"samples=1"});
  EXPECT_EQ(session->quality(), "");
  ASSERT_TRUE(update_until(converged));
  ASSERT_TRUE(session->keep_look());
  session->apply_quality("preview");
  EXPECT_EQ(session->quality(), "preview");
  ASSERT_TRUE(update_until([](const ViewStatus& s) { return s.covered; }));
  ASSERT_TRUE(update_until([&](const ViewStatus&) { return session->swap_looks(); }));
  EXPECT_EQ(session->quality(), "");
  ASSERT_TRUE(session->swap_looks());
  EXPECT_EQ(session->quality(), "preview");
  session->set_setting(row_of("render_settings", "maxDepth"), 3);
  EXPECT_EQ(session->quality(), std::nullopt);
}

TEST_F(ViewSessionTest, ANewLightFallsOnWhatTheCameraSees) {
  open({"samples=64"});
  ASSERT_TRUE(update_until(converged));
  const double before = double(session->values_at(0.5, 0.5)[0]);
  for (const char* type : kNewLights) {
    const hd::Path path = session->add_light(type, 0.5, 0.5);
    ASSERT_TRUE(update_until(converged));
    const double more = double(session->values_at(0.5, 0.5)[0]) - before;
    EXPECT_GT(more, 0.05) << type;
    EXPECT_LT(more, 1.2) << type;
    session->edit(path, [&] { return session->edits().remove_light(path), std::string(); });
  }
}

TEST_F(ViewSessionTest, AReloadKeepsEditsSettingsAndTheCameraThatWasPlaced) {
  open({"samples=1"});
  ASSERT_TRUE(update_until(converged));
  const hd::Path skin = session->edits().materials()[0], light = session->add_light("diskLight", 0.5, 0.5);
  const ParameterRow roughness = row_of("disney_material", "roughness");
  session->edit(skin, [&] { return session->edits().set(skin, roughness, 0.125); });
  session->set_setting(row_of("render_settings", "maxDepth"), 3);
  ASSERT_TRUE(update_until(converged));

  session->reload(load_session("lit.gltf", options, sink));
  EXPECT_EQ(session->edits().value(skin, roughness), hd::Value(0.125f));
  EXPECT_TRUE(session->edits().is_added(light));
  EXPECT_EQ(session->setting("maxDepth").number_or(0), 3);
  ASSERT_TRUE(update_until(converged));
  EXPECT_NEAR(alpha(0.5, 0.5), 1, 1e-6);
  EXPECT_EQ(told(), std::vector<std::string>());

  const auto moved_to = [this](double z) {
    std::string text = hd::description::patch_gltf(true, true);
    text.replace(text.find("[0, 0, 5]"), 9, "[0, 0, " + std::to_string(int(z)) + "]");
    write("lit.gltf", text);
    session->reload(load_session("lit.gltf", options, sink));
  };
  moved_to(6);
  EXPECT_EQ(session->camera().transform[3][2], 6) << "nobody has placed it";
  hd::CameraDescription placed = session->camera();
  placed.transform[3][0] = 0.5;
  session->set_camera(placed);
  moved_to(7);
  EXPECT_EQ(session->camera().transform, placed.transform);
  session->reset_camera();
  EXPECT_EQ(session->camera().transform[3][2], 7);
}

// A file without a camera is framed by one that is made for it.
TEST_F(ViewSessionTest, AReloadFramesTheNewSceneUnlessTheCameraWasPlaced) {
  open({"samples=1"}, "patch.gltf");
  ASSERT_TRUE(session->loaded().file.framed);
  const double before = session->camera().transform[3][2];
  const float points[12] = {-9, -9, 0, 9, -9, 0, 9, 9, 0, -9, 9, 0};
  std::fstream(folder_ / "patch.bin", std::ios::binary | std::ios::in | std::ios::out)
      .write(reinterpret_cast<const char*>(points), sizeof points);
  session->reload(load_session("patch.gltf", options, sink));
  EXPECT_GT(session->camera().transform[3][2], 5 * before);
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
