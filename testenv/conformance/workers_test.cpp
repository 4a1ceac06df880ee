// Renders run on threads of their own: the host's TBB keeps its workers.
#include <gtest/gtest.h>

#include <tbb/info.h>
#include <tbb/parallel_for.h>

#include <atomic>
#include <chrono>
#include <thread>

#include "testenv/conformance/host.h"
#include "testenv/conformance/scenes.h"

namespace conformance {
namespace {

// Each iteration waits until all threads of the loop have one. The limit is for delegates that hold the workers.
bool a_loop_has_all_threads(int threads) {
  std::atomic<int> arrived{0};
  std::atomic<bool> all{true};
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(20);
  tbb::parallel_for(
      0, threads,
      [&](int) {
        ++arrived;
        while (arrived < threads && all) {
          if (std::chrono::steady_clock::now() > end) all = false;
          std::this_thread::yield();
        }
      },
      tbb::simple_partitioner());
  return all;
}

TEST(Workers, ALoopOfTheHostHasAllItsThreadsWhileARenderGoesOn) {
  Host host(256, 256, {{"samples", 1 << 20}});
  add_noisy_scene(host);
  host.buffer();
  host.sync();
  host.take_up();
  for (int i = 0; i < 20; ++i) ASSERT_TRUE(a_loop_has_all_threads(tbb::info::default_concurrency()));
  EXPECT_EQ(host.pass->GetState(), PassState::rendering);
}

}  // namespace
}  // namespace conformance
