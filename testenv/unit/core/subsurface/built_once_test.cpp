#include "core/subsurface/built_once.h"

#include <gtest/gtest.h>
#include <tbb/parallel_for.h>
#include <tbb/task_group.h>

#include <atomic>
#include <chrono>
#include <thread>

namespace alabaster {
namespace {

using Clock = std::chrono::steady_clock;

// Three threads share an arena. The builder waits for the part of its loop that the helper has taken, while the spawner
// offers other tasks. Without isolation the builder takes up one of these, and still holds the part's lock.
TEST(BuiltOnce, ABuilderThatWaitsTakesUpNoOtherTask) {
  tbb::task_arena arena(3, 3);
  BuiltOnce<int> part;
  std::atomic<bool> shared{false}, over{false}, taken{false};
  tbb::task_group until_over;  // a thread that waits for it works for others
  tbb::task_handle end_of_help = until_over.defer([] {});
  std::thread helper([&] { arena.execute([&] { until_over.wait(); }); });
  std::thread builder([&] {
    const auto self = std::this_thread::get_id();
    const auto share = [&](int) {
      if (std::this_thread::get_id() == self) {
        while (!shared) std::this_thread::yield();  // the loop must end elsewhere
        return;
      }
      shared = true;
      const auto end = Clock::now() + std::chrono::milliseconds(500);
      while (Clock::now() < end && !taken) std::this_thread::yield();
    };
    arena.execute([&] {
      part.get([&] {
        tbb::parallel_for(0, 2, share, tbb::simple_partitioner());
        return 1;
      });
      over = true;
      until_over.run(std::move(end_of_help));
    });
  });
  std::thread spawner([&, builder_id = builder.get_id()] {
    arena.execute([&] {
      tbb::task_group others;
      while (!over && !taken) {
        if (shared) others.run([&] { taken = taken || std::this_thread::get_id() == builder_id; });
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
      }
      others.wait();
    });
  });
  builder.join();
  spawner.join();
  helper.join();
  EXPECT_TRUE(shared);
  EXPECT_FALSE(taken);
}

}  // namespace
}  // namespace alabaster
