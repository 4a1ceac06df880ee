#include "core/session/sample_report.h"

#include <gtest/gtest.h>

#include <limits>

#include "core/session/render_session.h"
#include "testenv/support/scene_builder.h"

namespace alabaster {
namespace {

using testing::SceneBuilder;

RenderRequest wax_ball(SceneBuilder* b) {
  DisneyParameters p;
  p.base_color = {0.9f, 0.6f, 0.45f};
  p.scatter_distance = Rgb(0.1f);
  b->add(b->prototype(testing::sphere_mesh(1, 24, true)), b->material(p)).add(testing::constant_dome(1, true));
  LightParameters lamp;
  lamp.light_to_world = Matrix4d(1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 3, 1);
  b->add(lamp);
  RenderRequest request;
  request.scene = b->snapshot();
  request.camera = testing::look_at({0, 1, 4}, {0, 0, 0}, 40);
  request.width = request.height = 16;
  request.data_window = {0, 0, 16, 16};
  request.settings.samples = 8;
  return request;
}

size_t count(const std::string& text, const std::string& part) {
  size_t n = 0;
  for (size_t i = text.find(part); i != std::string::npos; i = text.find(part, i + 1)) ++n;
  return n;
}

// The sample that is written down is the one that the frame takes, to the bit.
TEST(SampleReport, ARecordedPathHasTheColorOfTheFrames) {
  SceneBuilder b;
  const RenderRequest request = wax_ball(&b);
  const TileRenderer renderer(request);
  RenderCounters counters;
  LightLayers layers;
  for (const SampleAddress at : {SampleAddress{8, 8, 0}, {8, 8, 5}, {3, 9, 2}, {0, 0, 1}}) {
    const Rgb color = renderer.trace_sample(at, &counters, &layers).color;
    char last[128];
    std::snprintf(last, sizeof last, "sample %u of pixel %d,%d: colour (%.9g %.9g %.9g)\n", at.sample, at.x, at.y,
                  double(color.r), double(color.g), double(color.b));
    const std::string text = report_sample(request, at.x, at.y, at.sample);
    EXPECT_TRUE(text.ends_with(last)) << text << last;
    EXPECT_EQ(count(text, "ends: "), std::max<size_t>(1, count(text, ", which counts 1/"))) << text;
  }
}

TEST(SampleReport, NamesHitsLobesLightsAndWalkEvents) {
  SceneBuilder b;
  const RenderRequest request = wax_ball(&b);
  std::string text;
  for (uint32_t s = 0; s < 8; ++s) text += report_sample(request, 8, 8, s);
  for (const char* part : {"vertex 0, distance ", "primId 0", "samples the lobe subsurface",
                           "path 2 of 2, which counts 1/2", "scatter after ", "surface after ", "leaves the body at ",
                           "light towards ", "lobe pdf ", "light pdf ", "weight ", "; adds ("})
    EXPECT_NE(text.find(part), std::string::npos) << part << " is missing in\n" << text;
}

TEST(SampleReport, WithoutASampleNumberTheBrightestPathIsPrinted) {
  SceneBuilder b;
  const RenderRequest request = wax_ball(&b);
  const std::string text = report_sample(request, 8, 8, std::nullopt);
  EXPECT_EQ(count(text, "of pixel 8,8: colour ("), request.settings.samples + 1u);
  const TileRenderer renderer(request);
  RenderCounters counters;
  LightLayers layers;
  float most = -1;
  uint32_t brightest = 0;
  for (uint32_t s = 0; s < 8; ++s) {
    const float level = max_component(renderer.trace_sample({8, 8, s}, &counters, &layers).color);
    if (level > most) most = level, brightest = s;
  }
  EXPECT_EQ(text.substr(text.rfind("sample ")).find("sample " + std::to_string(brightest) + " of"), 0u) << text;
}

// The first sample that is not finite is known, whatever the threads; its report says so. All are counted, by cause and
// in an AOV.
TEST(SampleReport, NonfiniteSamplesAreFound) {
  SceneBuilder b;
  RenderRequest request = wax_ball(&b);
  const auto broken = std::make_shared<DisneyMaterial>();
  broken->constants.emission = Rgb(std::numeric_limits<float>::infinity());  // no delegate lets that pass
  b.description.instances[0].materials = {broken};
  request.scene = b.snapshot(2);
  request.aovs |= aov_bit(Aov::nonfinite);
  RenderProgress one, three;
  request.settings.threads = 1;
  const auto film = testing::render(request, &one);
  uint64_t shown = 0;
  for (const int32_t count : film->resolve_int(Aov::nonfinite)) shown += static_cast<uint64_t>(count);
  EXPECT_EQ(shown, one.counters.nonfinite_samples);
  EXPECT_EQ(one.counters.nonfinite_causes[static_cast<size_t>(NonfiniteCause::emission)], shown);
  request.settings.threads = 3;
  testing::render(request, &three);
  ASSERT_TRUE(one.counters.first_nonfinite);
  EXPECT_EQ(one.counters.first_nonfinite, three.counters.first_nonfinite);
  const SampleAddress first = *one.counters.first_nonfinite;
  EXPECT_EQ(first.sample, 0u);
  const std::string text = report_sample(request, first.x, first.y, std::nullopt);
  EXPECT_NE(text.find("not finite: the film takes black"), std::string::npos) << text;
  EXPECT_NE(text.find("vertex 0"), std::string::npos) << text;
}

// A check that fails in one sample fails the render, names the sample, and is part of its report.
TEST(SampleReport, AFailedCheckNamesItsSample) {
  SceneBuilder b;
  RenderRequest request = wax_ball(&b);
  auto broken = std::make_shared<SceneSnapshot>(*request.scene);
  broken->instances[0].body = nullptr;
  request.scene = broken;
  RenderSession session;
  session.start(request);
  ASSERT_TRUE(session.wait(60));
  const RenderProgress progress = session.progress();
  EXPECT_EQ(progress.state, SessionState::failed);
  ASSERT_TRUE(progress.failed_sample);
  const SampleAddress at = *progress.failed_sample;
  EXPECT_NE(progress.error.find("check failed: instance->body"), std::string::npos) << progress.error;
  EXPECT_NE(progress.error.find("of pixel " + std::to_string(at.x) + "," + std::to_string(at.y)), std::string::npos);
  const std::string text = report_sample(request, at.x, at.y, at.sample);
  EXPECT_NE(text.find("vertex 0"), std::string::npos) << text;
  EXPECT_NE(text.find("check failed: "), std::string::npos) << text;
}

}  // namespace
}  // namespace alabaster
