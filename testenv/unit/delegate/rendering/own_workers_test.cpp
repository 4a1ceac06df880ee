// Renders run on threads of their own, and share the cores with those of other delegates. The conformance suite tests
// that the host's TBB keeps its workers.
#include <gtest/gtest.h>

#include <chrono>
#include <memory>
#include <thread>

#include "testenv/support/stage.h"

namespace alabaster::hd {
namespace {

// A render without end, on as many threads as there are.
struct Endless {
  static constexpr int kSide = 96;
  Endless() : stage({{"samples", 1 << 20}}) {
    stage.add_basic_scene();
    pass = stage.delegate->CreateRenderPass();
    state = Stage::state_for(kSide, kSide, "color", stage.add_buffer("/buffer", kSide, kSide, Format::float32vec4));
    stage.index->SyncAll();
    for (int i = 0; i < 2000 && cpu_seconds() == 0; ++i) {
      pass->Execute(state);
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
  }
  ~Endless() { pass.reset(); }
  double cpu_seconds() const { return stage.delegate->GetRenderStats()["cpuSeconds"].number_or(0); }

  Stage stage;
  std::unique_ptr<RenderPass> pass;
  RenderPassState state;
};

TEST(OwnWorkers, TwoDelegatesShareTheCores) {
  Endless first, second;
  const double begun[] = {first.cpu_seconds(), second.cpu_seconds()};
  double spent[] = {0, 0};
  for (int i = 0; i < 2000 && spent[0] + spent[1] < 1; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
    spent[0] = first.cpu_seconds() - begun[0], spent[1] = second.cpu_seconds() - begun[1];
  }
  ASSERT_GE(spent[0] + spent[1], 1);
  EXPECT_GT(spent[0], 0.3 * (spent[0] + spent[1]));
  EXPECT_GT(spent[1], 0.3 * (spent[0] + spent[1]));
}

}  // namespace
}  // namespace alabaster::hd
