#include "core/session/render_session.h"

#if defined(CHECK) || defined(DCHECK)
#error "a program may have macros of these names"
#endif

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <numeric>
#include <thread>
#include <type_traits>
#include <variant>

#include "core/session/pass_schedule.h"
#include "testenv/support/same_bytes.h"
#include "testenv/support/scene_builder.h"

namespace alabaster {
namespace {

using testing::mixed_request;
using testing::same_bytes;

std::vector<float> color(const RenderRequest& request) {
  return testing::render(request)->resolve_float(Aov::color);
}

// Color and every layer, one after the other.
std::vector<float> light(const Film& film) {
  std::vector<float> all = film.resolve_float(Aov::color);
  for (const AovInfo& info : kAovs)
    if (info.source == AovSource::layer) {
      const auto layer = film.resolve_float(info.aov);
      all.insert(all.end(), layer.begin(), layer.end());
    }
  return all;
}

std::vector<float> light(const RenderRequest& request) {
  return light(*testing::render(request));
}

TEST(RenderSession, BytesDoNotDependOnThreads) {
  const tbb::global_control more_than_cores(tbb::global_control::max_allowed_parallelism, 8);
  RenderRequest request = mixed_request(12);
  request.settings.threads = 1;
  const auto one = light(request);
  for (const uint32_t threads : {2u, 3u, 8u}) {
    request.settings.threads = threads;
    EXPECT_TRUE(same_bytes(one, light(request))) << threads << " threads";
  }
}

TEST(RenderSession, TheErrorAskedEndsItAtTheSameBytesForAnyThreads) {
  const tbb::global_control more_than_cores(tbb::global_control::max_allowed_parallelism, 8);
  RenderRequest request = mixed_request(4096);
  request.settings.target_error = 0.05f;
  std::vector<float> first;
  for (const uint32_t threads : {1u, 5u}) {
    request.settings.threads = threads;
    RenderProgress progress;
    const auto film = testing::render(request, &progress);
    EXPECT_TRUE(progress.noise.known);
    EXPECT_LE(progress.noise.relative_rmse, 0.05 * 1.1) << "other pixels decide than those that are counted";
    EXPECT_GT(progress.samples_done, 16u * 72 * 72);
    EXPECT_LT(progress.samples_done, 4096u * 72 * 72);
    EXPECT_EQ(progress.fraction, 1);
    const auto pixels = film->resolve_float(Aov::color);
    EXPECT_TRUE(first.empty() || same_bytes(first, pixels));
    first = pixels;
  }
}

TEST(RenderSession, AdaptiveSamplesAreAllocatedTheSameForAnyThreads) {
  const tbb::global_control more_than_cores(tbb::global_control::max_allowed_parallelism, 8);
  RenderRequest request = mixed_request(48);
  request.settings.adaptive = true;
  std::vector<float> first;
  for (const uint32_t threads : {1u, 5u}) {
    request.settings.threads = threads;
    RenderProgress progress;
    const auto film = testing::render(request, &progress);
    const auto counts = film->resolve_int(Aov::sample_count);
    EXPECT_GE(*std::min_element(counts.begin(), counts.end()), 16);
    EXPECT_GT(*std::max_element(counts.begin(), counts.end()), 64);
    EXPECT_NEAR(double(progress.samples_done) / double(counts.size()), 48, 1) << "of each pixel in the mean";
    const auto pixels = film->resolve_float(Aov::color);
    EXPECT_TRUE(first.empty() || same_bytes(first, pixels));
    first = pixels;
  }
  request.settings.samples = 31;
  for (const int32_t n : testing::render(request)->resolve_int(Aov::sample_count))
    ASSERT_EQ(n, 31) << "too few to allocate";
}

TEST(RenderSession, ATimeLimitEndsItOnceEveryPixelHasASample) {
  RenderRequest request = mixed_request(1000000);
  for (const float limit : {0.0001f, 0.3f}) {
    request.settings.time_limit = limit;
    RenderProgress progress;
    const auto film = testing::render(request, &progress);
    EXPECT_EQ(progress.state, SessionState::finished);
    EXPECT_LT(progress.wall_seconds, 3 + limit) << "on a busy machine";
    EXPECT_EQ(progress.pixels_without_sample, 0u) << "a small frame";
    const auto samples = film->resolve_int(Aov::sample_count);
    const auto [least, most] = std::minmax_element(samples.begin(), samples.end());
    EXPECT_GE(*least, 1);
    EXPECT_LT(*most, 100000);
    EXPECT_EQ(progress.noise.known, *least >= 2);
  }
}

TEST(RenderSession, APauseDoesNotCountAgainstTheTimeLimit) {
  RenderRequest request = mixed_request(1000000);
  request.settings.time_limit = 0.3f;
  RenderSession session;
  session.start(request);
  session.pause();
  const double before = session.progress().wall_seconds;
  std::this_thread::sleep_for(std::chrono::milliseconds(1000));
  EXPECT_EQ(session.progress().wall_seconds, before);
  EXPECT_EQ(session.progress().state, SessionState::paused);
  EXPECT_FALSE(session.wait(0));
  session.resume();
  EXPECT_LT(session.progress().wall_seconds, 0.3 + 0.5);
  ASSERT_TRUE(session.wait(60));
  const RenderProgress progress = session.progress();
  EXPECT_EQ(progress.state, SessionState::finished);
  EXPECT_EQ(progress.ended_by, RenderEnd::time_limit);
  EXPECT_GE(progress.wall_seconds, 0.3);
  EXPECT_EQ(progress.pixels_without_sample, 0u) << "a small frame";
}

// Another value of the setting, within its range.
struct Change {
  RenderSettings* settings;
  void operator()(bool RenderSettings::*member) const { settings->*member = !(settings->*member); }
  template <class T>
  void operator()(T RenderSettings::*member) const {
    if constexpr (std::is_enum_v<T>)
      settings->*member = settings->*member == T(0) ? T(1) : T(0);
    else
      settings->*member = settings->*member + T(1);
  }
};

// promise: embedding.edit.settings
TEST(RenderSession, SettingsThatContinueKeepTheSamples) {
  for (const SettingParameter& setting : setting_parameters()) {
    RenderRequest request = mixed_request(2);
    RenderSession session;
    session.start(request);
    ASSERT_TRUE(session.wait(60));
    const auto film = session.film();
    std::visit(Change{&request.settings}, setting.member);
    session.start(request);
    EXPECT_EQ(session.film() == film, (setting.of & setting_use::kContinues) != 0) << setting.name;
    session.stop();
  }
}

// The first samples alone take longer. Layers, crops, a target error and adaptive sampling change nothing about that.
TEST(RenderSession, ATimeLimitEndsAFrameThatIsTooLargeForOneSamplePerPixel) {
  for (const bool decided : {false, true}) {
    RenderRequest request = mixed_request(1000000);
    request.width = request.height = 2048;
    request.data_window = {-10, 0, 1500, 2050};
    request.settings.time_limit = 0.05f;
    request.settings.adaptive = decided;
    request.settings.target_error = decided ? 0.01f : 0.0f;
    request.aovs = aov_bit(Aov::color) | (decided ? aov_bit(Aov::specular) : 0);
    RenderProgress progress;
    const auto film = testing::render(request, &progress);
    EXPECT_EQ(progress.state, SessionState::finished);
    EXPECT_LT(progress.wall_seconds, 3) << "on a busy machine";
    EXPECT_FALSE(progress.noise.known);
    EXPECT_GT(progress.pixels_without_sample, 0u);
    EXPECT_EQ(progress.pixels_without_sample, progress.pixels - progress.samples_done);
    const auto samples = film->resolve_int(Aov::sample_count);
    EXPECT_EQ(std::accumulate(samples.begin(), samples.end(), uint64_t(0)), progress.samples_done);
  }
}

// More workers than tiles run ahead of slow tiles. Progress is read before the film, which only grows.
TEST(RenderSession, FinishedPassesAreInEveryPixel) {
  const tbb::global_control more_than_cores(tbb::global_control::max_allowed_parallelism, 8);
  RenderRequest request = mixed_request(64);
  request.settings.threads = 8;
  const PassSchedule schedule = make_pass_schedule({0, 64});
  const size_t previews = 4;  // of blocks
  RenderSession session;
  session.start(request);
  uint32_t passes = 0;
  for (bool over = false; !over;) {
    over = session.wait(0.001);
    passes = session.progress().passes_done;
    const auto counts = session.film()->resolve_int(Aov::sample_count);
    const auto least = static_cast<uint32_t>(*std::min_element(counts.begin(), counts.end()));
    ASSERT_GE(least, passes > 0 ? schedule[previews + passes - 1].end : 0) << passes << " passes";
  }
  EXPECT_EQ(passes, schedule.size() - previews);
}

TEST(RenderSession, WaitsForeverForInfinityAndHugeTimes) {
  for (const double seconds : {std::numeric_limits<double>::infinity(), std::numeric_limits<double>::max(), 1e12}) {
    RenderSession session;
    session.start(mixed_request(1000000));
    std::thread stopper([&] {
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
      session.stop();
    });
    EXPECT_TRUE(session.wait(seconds)) << seconds;
    EXPECT_EQ(session.progress().state, SessionState::stopped) << seconds;
    stopper.join();
  }
}

TEST(RenderSession, DoesNotWaitForNegativeTimesNorForNaN) {
  RenderSession session;
  session.start(mixed_request(1000000));
  for (const double seconds : {-1.0, -std::numeric_limits<double>::infinity(), std::nan("")})
    EXPECT_FALSE(session.wait(seconds)) << seconds;
}

TEST(RenderSession, StopKeepsAllSamples) {
  RenderSession session;
  const RenderRequest request = mixed_request(100000);
  session.start(request);
  // Noise is known from two samples of each pixel on.
  const uint64_t enough = 4 * uint64_t(request.width) * uint64_t(request.height);
  for (int i = 0; i < 2000 && session.progress().samples_done < enough; ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  const auto before = std::chrono::steady_clock::now();
  session.stop();
  const double latency = std::chrono::duration<double>(std::chrono::steady_clock::now() - before).count();
  EXPECT_LT(latency, 0.2);
  const RenderProgress progress = session.progress();
  EXPECT_EQ(progress.state, SessionState::stopped);
  EXPECT_TRUE(progress.noise.known);
  const auto counts = session.film()->resolve_int(Aov::sample_count);
  EXPECT_GT(progress.samples_done, 0u);
  EXPECT_EQ(std::accumulate(counts.begin(), counts.end(), uint64_t(0)), progress.samples_done);
}

// A stopped render goes on where it was, also with more samples or other threads: the bytes are those of one that was
// never stopped, and no sample is taken twice.
TEST(RenderSession, GoesOnWithTheSamplesItHas) {
  RenderRequest request = mixed_request(40);
  const auto expected = light(request);
  RenderSession session;
  RenderRequest first = request;
  first.settings.samples = 30;
  for (int i = 0; i < 6; ++i) {
    session.start(first);
    std::this_thread::sleep_for(std::chrono::milliseconds(i));
    session.stop();
    first.settings.threads = static_cast<uint32_t>(1 + i % 3);
  }
  first.settings.samples = 40;
  session.start(first);
  const auto film = session.film();
  ASSERT_TRUE(session.wait(60));
  EXPECT_TRUE(same_bytes(expected, light(*film)));
  EXPECT_EQ(session.progress().samples_done, 40u * 72 * 72);

  first.settings.samples = 39;
  session.start(first);
  EXPECT_NE(session.film(), film) << "it has more samples than are asked for";
}

// A host that pauses by a stop, to have what is there denoised, loses nothing where the noise decides either.
TEST(RenderSession, DecisionsGoOnWithTheSamplesTheyHave) {
  const auto stopped_often = [](const RenderRequest& request) {
    RenderSession session;
    uint64_t samples = 0;
    for (int i = 0; i < 12; ++i) {
      session.start(request);
      const bool may_begin_again = request.settings.target_error > 0.01f;
      EXPECT_TRUE(may_begin_again || session.progress().samples_done >= samples) << "stop " << i;
      session.wait(0.003 * i);
      session.stop();
      samples = session.progress().samples_done;
    }
    EXPECT_GT(samples, 0u);
    session.start(request);
    EXPECT_TRUE(session.wait(100));
    return session.film()->resolve_float(Aov::color);
  };
  RenderRequest request = mixed_request(48);
  request.settings.adaptive = true;
  EXPECT_TRUE(same_bytes(color(request), stopped_often(request)));
  request.settings.adaptive = false;
  request.settings.samples = 64;
  request.settings.target_error = 1e-4f;  // which none of its samples reach
  EXPECT_TRUE(same_bytes(color(request), stopped_often(request)));

  request.settings.target_error = 0.1f;  // which some groups of pixels reach before others
  EXPECT_TRUE(same_bytes(color(request), stopped_often(request)));

  // Another target decides otherwise, so it begins again.
  RenderSession session;
  session.start(request);
  session.wait(0.2);
  session.stop();
  request.settings.target_error = 0.2f;
  session.start(request);
  ASSERT_TRUE(session.wait(100));
  EXPECT_TRUE(same_bytes(color(request), session.film()->resolve_float(Aov::color)));
}

// Who asks gets the noise of passes before the last, and who does not pays nothing. Pixels are the same.
TEST(RenderSession, NoiseIsMeasuredWhileItRendersForWhoAsks) {
  RenderSession session;
  const auto wait_for = [&](auto condition) {
    const auto start = std::chrono::steady_clock::now();
    while (!condition(session.progress()) && std::chrono::steady_clock::now() - start < std::chrono::seconds(60))
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
    return session.progress();
  };
  session.start(mixed_request(1000000));
  const uint32_t passes = 4;
  EXPECT_FALSE(wait_for([](const RenderProgress& p) { return p.passes_done >= passes; }).noise.known);
  session.ask_for_noise();
  const RenderProgress first = wait_for([](const RenderProgress& p) { return p.noise.known; });
  EXPECT_EQ(first.state, SessionState::rendering);
  EXPECT_GT(first.noise.relative_rmse, 0);
  EXPECT_GE(first.noise_samples, 2u * 72 * 72);
  EXPECT_LE(first.noise_samples, first.samples_done);
  const auto later = [&](const RenderProgress& p) { return p.passes_done >= first.passes_done + 4; };
  EXPECT_EQ(wait_for(later).noise_samples, first.noise_samples) << "it was asked for once";
  session.ask_for_noise();
  const auto newer = [&](const RenderProgress& p) { return p.noise_samples > first.noise_samples; };
  EXPECT_LT(wait_for(newer).noise.relative_rmse, first.noise.relative_rmse);

  const RenderRequest request = mixed_request(40);
  session.start(request);
  while (!session.wait(0.001)) session.ask_for_noise();
  EXPECT_TRUE(same_bytes(color(request), session.film()->resolve_float(Aov::color)));
  EXPECT_EQ(session.progress().noise_samples, 40u * 72 * 72) << "that of all samples, in the end";
}

// The first samples cover the frame; nothing of it is empty while they are few.
// promise: embedding.first_sample
TEST(RenderSession, TheFirstSamplesCoverTheFrame) {
  RenderRequest request = mixed_request(1);
  request.settings.threads = 1;
  RenderSession session;
  session.start(request);
  const auto film = session.film();
  uint64_t samples = 0;
  while (!film->is_covered()) std::this_thread::yield();
  session.stop();
  const auto counts = film->resolve_int(Aov::sample_count);
  for (const int32_t count : counts) samples += static_cast<uint64_t>(count);
  EXPECT_LT(samples, 72u * 72 / 2) << "covered by blocks";
  const auto pixels = film->resolve_float(Aov::color);
  for (size_t i = 3; i < pixels.size(); i += 4) EXPECT_EQ(pixels[i], 1) << "the dome is opaque";
}

TEST(RenderSession, ControlIsLegalBeforeAndAfterRendering) {
  RenderSession session;
  session.pause();
  session.resume();
  session.stop();
  EXPECT_TRUE(session.wait(0));
  EXPECT_EQ(session.film(), nullptr);
  RenderRequest request = mixed_request(1);
  session.start(request);
  session.start(request);  // replaces
  ASSERT_TRUE(session.wait(60));
  session.pause();
  EXPECT_EQ(session.progress().state, SessionState::finished);
  session.stop();
}

TEST(RenderSession, EmptyWindowFinishesAtOnce) {
  RenderRequest request = mixed_request(4);
  request.data_window = {5, 5, 5, 5};
  RenderSession session;
  session.start(request);
  EXPECT_TRUE(session.wait(5));
  EXPECT_EQ(session.progress().state, SessionState::finished);
}

// promise: pipeline.aov.sample_count
TEST(RenderSession, AovsDescribeTheFirstHit) {
  RenderRequest request = mixed_request(4);
  request.settings.filter = PixelFilter::box;
  const auto film = testing::render(request);
  const size_t centre = 36 * 72 + 36, corner = 0;
  EXPECT_EQ(film->resolve_int(Aov::prim_id)[centre], 0);
  EXPECT_EQ(film->resolve_int(Aov::instance_id)[centre], 0);
  EXPECT_EQ(film->resolve_int(Aov::prim_id)[corner], -1);
  EXPECT_EQ(film->resolve_int(Aov::sample_count)[centre], 4);
  EXPECT_EQ(film->resolve_float(Aov::depth)[corner], 1.0f);
  EXPECT_EQ(film->resolve_float(Aov::alpha)[corner], 1.0f) << "the visible dome is an opaque background";
  const float distance = film->resolve_float(Aov::camera_depth)[centre];
  EXPECT_NEAR(distance, 3.08 - 0.5, 0.02);  // |eye - target| less the radius
}

}  // namespace
}  // namespace alabaster
