// Contract 1.2, 4.5 rule 6: Stop, Restart, Pause and Resume.
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <ctime>
#include <thread>

#include "testenv/conformance/scenes.h"

namespace conformance {
namespace {

const Dictionary kEndless = {{"samples", 1 << 20}};

// Samples of all pixels so far.
double samples_so_far(Host& host) {
  const Picture counts = read(host.buffer("sampleCount"));
  double sum = 0;
  for (int y = 0; y < counts.height; ++y)
    for (int x = 0; x < counts.width; ++x)
      sum += counts.format == Format::int32 ? counts.integer(x, y) : double(counts.number(x, y));
  return sum;
}

TEST(Control, IsLegalBeforeTheFirstRender) {
  Host host;
  add_halves(host);
  host.delegate->Pause();
  EXPECT_TRUE(host.delegate->IsPaused());
  host.delegate->Resume();
  host.delegate->Stop();
  EXPECT_TRUE(host.delegate->IsStopped());
  host.delegate->Restart();
  EXPECT_FALSE(host.delegate->IsStopped());
  EXPECT_TRUE(near(host.render().color(-0.5, 0), kRed));
}

TEST(Control, IsLegalWhenNothingRenders) {
  Host host;
  add_halves(host);
  const Picture picture = host.render();
  host.delegate->Pause();
  host.delegate->Resume();
  host.delegate->Stop();
  host.delegate->Stop();
  host.delegate->Restart();
  host.delegate->Restart();
  EXPECT_TRUE(host.render() == picture);
}

// promise: embedding.stop
TEST(Control, StopLatchesUntilRestart) {
  Host host;
  add_noisy_scene(host);
  const Picture whole = host.render();
  host.delegate->Stop();
  host.delegate->SetRenderSetting("seed", 7);
  for (int i = 0; i < 100; ++i) {
    host.pass->Execute(host.state);
    ASSERT_EQ(host.pass->GetState(), PassState::stopped) << i;
    ASSERT_TRUE(host.delegate->IsStopped());
  }
  host.delegate->Restart();
  host.delegate->SetRenderSetting("seed", 0);
  EXPECT_TRUE(host.render() == whole);
}

// Resume restarted from zero (arnold#595, #2719).
TEST(Control, APauseKeepsItsSamples) {
  constexpr double kMany = 60000;
  Host host(16, 16, kEndless);
  add_noisy_scene(host);
  host.buffer("sampleCount");
  host.sync();
  host.take_up();
  const auto end = std::chrono::steady_clock::now() + std::chrono::minutes(1);
  while (samples_so_far(host) < kMany && std::chrono::steady_clock::now() < end) host.pass->Execute(host.state);
  host.delegate->Pause();
  EXPECT_TRUE(host.delegate->IsPaused());
  const double before = samples_so_far(host);
  EXPECT_GE(before, kMany);
  host.delegate->Resume();
  // A delegate that begins again shows the old counts where nothing is drawn yet, and then smaller ones.
  const uint64_t news = host.buffer("sampleCount").GetGeneration() + 3;
  while (host.buffer("sampleCount").GetGeneration() < news && std::chrono::steady_clock::now() < end) {
    host.pass->Execute(host.state);
    ASSERT_GE(samples_so_far(host), before);
  }
  EXPECT_FALSE(host.delegate->IsPaused());
}

// Workers that are parked take no samples, and none is lost: the picture is that of a render without a pause.
TEST(Control, APauseParksTheWorkers) {
  Host host(16, 16, kEndless), plain(16, 16, {{"samples", 32}});
  add_noisy_scene(host), add_noisy_scene(plain);
  host.buffer("sampleCount"), host.buffer();
  host.sync();
  host.take_up();
  host.delegate->Pause();
  // Samples that had begun are finished, and nothing more: ten readings that agree follow soon.
  double last = -1;
  int equal = 0;
  for (int i = 0; i < 60 && equal < 10; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
    const double now = samples_so_far(host);
    equal = now == last ? equal + 1 : 0;
    last = now;
  }
  EXPECT_EQ(equal, 10);
  host.delegate->Resume();
  host.delegate->SetRenderSetting("samples", 32);
  EXPECT_TRUE(host.render() == plain.render());
}

// The clock is the process's own: a busy machine does not change it. Workers of two threads may use 20 ms each.
TEST(Control, StopIsSeenSoon) {
  Host host(256, 256, kEndless);
  add_noisy_scene(host);
  host.buffer();
  host.sync();
  host.take_up();
  std::vector<double> spent;
  for (int i = 0; i < repetitions(25, 9); ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
    const std::clock_t begin = std::clock();
    host.delegate->Stop();
    spent.push_back(1e3 * double(std::clock() - begin) / CLOCKS_PER_SEC);
    host.delegate->Restart();
    host.pass->Execute(host.state);
  }
  std::sort(spent.begin(), spent.end());
  EXPECT_LT(spent[spent.size() / 2], 40) << "milliseconds of CPU, median";
}

TEST(Control, TenThousandStopsAndStarts) {
  Host host(4, 4, kEndless), plain(4, 4, {{"samples", 2}});  // endless: no frame ends between its start and its stop
  add_noisy_scene(host), add_noisy_scene(plain);
  host.buffer();
  host.sync();
  host.take_up();
  for (int i = 0; i < repetitions(10000, 100); ++i) {
    host.delegate->SetRenderSetting("seed", 1 + i);  // each start is a new frame
    host.pass->Execute(host.state);
    host.delegate->Stop();
    ASSERT_FALSE(host.pass->IsConverged());
    host.delegate->Restart();
  }
  host.delegate->SetRenderSetting("seed", 0);
  host.delegate->SetRenderSetting("samples", 2);
  EXPECT_TRUE(host.render() == plain.render());
}

// promise: embedding.stop
TEST(Control, AHoldUndoesNoStop) {
  Host host(16, 16, kEndless);
  add_halves(host);
  host.buffer();
  host.sync();
  host.take_up();
  std::shared_ptr<const void> hold = host.delegate->HoldStopped();
  ASSERT_TRUE(hold);
  host.delegate->Restart();
  EXPECT_TRUE(host.delegate->IsStopped()) << "the hold is still there";
  host.delegate->Stop();
  hold.reset();
  EXPECT_TRUE(host.delegate->IsStopped()) << "the host's own Stop is still there";
  host.delegate->Restart();
  EXPECT_FALSE(host.delegate->IsStopped());
}

TEST(Stats, HaveTheKeysThatHostsAskForAtAnyTime) {
  Host host;
  const auto keys_are_there = [&](const char* when) {
    const Dictionary stats = host.delegate->GetRenderStats();
    for (const char* key : {"percentDone", "fractionDone", "totalClockTime", "numCompletedSamples", "rendererName",
                            "renderProgressAnnotation", "totalMemory", "peakMemory"})
      EXPECT_TRUE(stats.contains(key)) << key << " " << when;
  };
  keys_are_there("before the first render");
  add_noisy_scene(host);
  host.buffer();
  host.sync();
  host.take_up();
  keys_are_there("while rendering");
  host.render();
  EXPECT_EQ(host.stat("percentDone"), 100);
  EXPECT_EQ(host.stat("numCompletedSamples"), 4);
}

}  // namespace
}  // namespace conformance
