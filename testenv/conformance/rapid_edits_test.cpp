// Contract 4.7: many edits in a short time. repetitions() gives their number; --repeat 10 under ThreadSanitizer finds
// more.
#include <gtest/gtest.h>
#include <malloc.h>
#include <unistd.h>

#include <atomic>
#include <cmath>
#include <fstream>
#include <thread>

#include "testenv/conformance/scenes.h"

namespace conformance {
namespace {

// Leaves the scene as `step` says, whatever the steps before were.
void edit(Host& host, int step) {
  host.mesh("/cube", dirty::kTransform).transform = moved(0.05 * (step % 7), 0);
  host.material("/matte", dirty::kResource) = matte(Vec3f(0.1f * float(step % 9), 0.5f, 0.25f));
  host.light("/quad", "rectLight", dirty::kTransform).transform = moved(0.2 * (step % 11), 1, 2);
  host.mesh("/floor", dirty::kVisibility).visible = step % 4 != 1;
  host.mesh("/floor", dirty::kPrimvar | dirty::kPoints | dirty::kTopology) =
      rectangle(-2, -2, 2, 2, 1 + step % 3, -0.5);
  host.mesh("/floor", dirty::kMaterialId).material = step % 5 ? "/matte" : "";
  host.mesh("/floor", dirty::kVisibility).visible = step % 4 != 1;
  host.camera(dirty::kTransform).transform = moved(0.01 * (step % 13), 0, 2);
  if (step % 3 == 0) {
    if (host.has("/extra")) host.remove("/extra");
  } else {
    Mesh& extra = host.mesh("/extra") = cube(0.1 + 0.05 * (step % 3));
    extra.transform = moved(-0.5, 0.5);
    extra.topology.scheme = "catmullClark";
    extra.style.refineLevel = step % 3;
  }
}

// husk renders miss the last update (arnold#2154).
TEST(RapidEdits, NoEditIsLost) {
  const int steps = repetitions(60, 20);
  Host host, fresh;
  add_noisy_scene(host), add_noisy_scene(fresh);
  host.buffer();
  for (int step = 0; step < steps; ++step) {
    edit(host, step);
    host.sync();
    host.pass->Execute(host.state);
    if (step % 16 == 5) host.take_up();
    if (step % 16 == 9) host.converge();
  }
  edit(fresh, steps - 1);
  EXPECT_TRUE(host.render() == fresh.render());
}

// Leaves the instancer as `step` says: from none to twenty thousand tiles, which stand elsewhere at every step.
void scatter_tiles(Host& host, int step) {
  constexpr int kCounts[] = {20000, 8200, 8192, 8191, 12000, 3, 0};
  const int count = kCounts[step % 7];
  std::vector<Vec3f> places;
  std::vector<int32_t> drawn;
  for (int i = 0; i < count; ++i) {
    const double across = std::fmod(0.6180339887 * i + 0.01 * step, 1.0);
    places.emplace_back(float(2 * across - 1), float(2.0 * i / count - 1), 0.001f * float(i % 100));
    if (step % 3 != 1 || i % 4) drawn.push_back(i);
  }
  InstancerData& tiles = host.instancer("/tiles", dirty::kPrimvar | dirty::kInstanceIndex | dirty::kTransform);
  tiles.primvars["hydra:instanceTranslations"] = Array<Vec3f>(std::move(places));
  tiles.indices["/tile"] = Array<int32_t>(std::move(drawn));
  tiles.transform = moved(0.1 * (step % 5), 0);
  host.mesh("/tile", dirty::kInstanceIndex | dirty::kVisibility).visible = step % 8 != 5;
}

void add_tiles(Host& host) {
  add_noisy_scene(host);
  host.mesh("/tile") = rectangle(0, 0, 0.02, 0.02);
  host.mesh("/tile").instancer = "/tiles";
  host.instancer("/tiles");
}

// Delegates that treat many instances in another way than few must not lose any between the two.
TEST(RapidEdits, NoInstanceIsLost) {
  const int steps = repetitions(40, 5);  // the last of which draws thousands
  Host host(16, 16, {{"samples", 64}}), fresh(16, 16, {{"samples", 64}});
  add_tiles(host), add_tiles(fresh);
  host.buffer(), host.buffer("instanceId");
  for (int step = 0; step < steps; ++step) {
    scatter_tiles(host, step);
    host.sync();
    host.pass->Execute(host.state);
    if (step % 8 == 3 || step == steps - 2) host.take_up();  // the last edit comes while a render goes on
    if (step % 8 == 6) host.converge();
  }
  scatter_tiles(fresh, steps - 1);
  EXPECT_TRUE(host.render("instanceId") == fresh.render("instanceId"));
  EXPECT_TRUE(host.render() == fresh.render());
}

// An edit while the render of the one before goes on.
TEST(RapidEdits, TheLastOfTwoEditsIsDrawn) {
  Host host(16, 16, {{"samples", 32}}), fresh(16, 16, {{"samples", 32}});
  add_noisy_scene(host), add_noisy_scene(fresh);
  host.buffer();
  for (double x : {0.1, 0.2}) {
    host.mesh("/cube", dirty::kTransform).transform = moved(x, 0);
    host.sync();
    host.take_up();
  }
  fresh.mesh("/cube").transform = moved(0.2, 0);
  EXPECT_TRUE(host.render() == fresh.render());
}

// Everything that any thread may call at any time, from two threads, while a third edits and executes.
// promise: embedding.threads.cpp
TEST(RapidEdits, ControlFromOtherThreadsLosesNoEdit) {
  Host host(16, 16, {{"samples", 32}}), fresh(16, 16, {{"samples", 32}});
  add_noisy_scene(host), add_noisy_scene(fresh);
  RenderBuffer& color = host.buffer();
  host.sync();
  const int steps = repetitions(50, 15);
  std::atomic<bool> over = false;
  std::thread control([&] {
    while (!over) {
      host.delegate->Pause();
      host.delegate->GetRenderStats();
      host.delegate->Stop();
      host.pass->GetState();
      host.delegate->HoldStopped();
      host.delegate->Resume();
      host.delegate->Restart();
      std::this_thread::yield();
    }
  });
  std::thread reader([&] {
    while (!over) {
      color.Resolve();
      if (color.Map()) color.Unmap();
      color.IsMapped();
      host.delegate->GetRenderStats();
      host.pass->WaitForConvergence(1e-4);
    }
  });
  for (int step = 0; step < steps; ++step) {
    edit(host, step);
    host.sync();
    for (int i = 0; i < 5; ++i) host.pass->Execute(host.state);
  }
  over = true;
  control.join();
  reader.join();
  host.delegate->Restart();
  host.delegate->Resume();
  edit(fresh, steps - 1);
  EXPECT_TRUE(host.render() == fresh.render());
}

TEST(RapidEdits, LastSettingsAreRendered) {
  Host host, fresh;
  add_noisy_scene(host), add_noisy_scene(fresh);
  host.buffer();
  host.sync();
  for (int i = 0; i < repetitions(200, 50); ++i) {
    host.delegate->SetRenderSetting("seed", i);
    host.delegate->SetRenderSetting("samples", 1 + i % 3);
    host.delegate->SetRenderSetting("threads", 1 + i % 2);
    host.delegate->SetRenderSetting("maxDepth", i % 4);
    host.pass->Execute(host.state);
  }
  for (Host* one : {&host, &fresh}) {
    one->delegate->SetRenderSetting("seed", 77);
    one->delegate->SetRenderSetting("samples", 3);
    one->delegate->SetRenderSetting("maxDepth", 2);
  }
  EXPECT_TRUE(host.render() == fresh.render());
}

// arnold#2566.
TEST(Delegates, DelegateMayEndWhileAnotherRenders) {
  Host survivor(16, 16, {{"samples", 64}}), plain(16, 16, {{"samples", 64}});
  add_noisy_scene(survivor), add_noisy_scene(plain);
  const Picture picture = plain.render();
  survivor.buffer();
  survivor.sync();
  survivor.take_up();
  for (int i = 0; i < repetitions(8, 3); ++i) {
    Host other(16, 16, {{"samples", 1 << 20}});
    add_noisy_scene(other);
    other.buffer();
    other.sync();
    if (i % 2) other.take_up();  // else it ends while its scene is built
    survivor.pass->Execute(survivor.state);
    EXPECT_NE(survivor.pass->GetState(), PassState::stopped);
  }
  EXPECT_TRUE(survivor.render() == picture);
}

TEST(Delegates, DelegatesShareNoSettings) {
  Host host(16, 16, {{"samples", 4}}), other(16, 16, {{"samples", 2}});
  add_noisy_scene(host), add_noisy_scene(other);
  host.delegate->SetRenderSetting("seed", 3);
  EXPECT_EQ(other.delegate->GetRenderSetting("seed").number_or(-1), 0);
  EXPECT_EQ(other.delegate->GetRenderSetting("samples").number_or(-1), 2);
  host.delegate->Stop();
  EXPECT_FALSE(other.delegate->IsStopped());
  other.render();
  EXPECT_EQ(other.pass->GetState(), PassState::converged);
}

size_t resident_bytes() {
  malloc_trim(0);
  size_t total = 0, resident = 0;
  std::ifstream("/proc/self/statm") >> total >> resident;
  return resident * static_cast<size_t>(sysconf(_SC_PAGESIZE));
}

// arnold#1356. Pools of libraries grow by some megabytes, the more the busier the machine is. A delegate that keeps one
// scene in three grows by more: this one's are of 150 kB.
TEST(RapidEdits, MemoryDoesNotGrowWithEdits) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "sanitizers keep memory that was freed";
#endif
  Host host(16, 16, {{"samples", 1}});
  add_noisy_scene(host);
  host.buffer();
  const auto run = [&](int from, int to) {
    for (int step = from; step < to; ++step) {
      edit(host, step);
      host.mesh("/extra") = rectangle(-1, -1, 1, 1, 32, -0.4 - 0.001 * step);
      host.render();
    }
    return resident_bytes();
  };
  run(0, repetitions(100, 10));
  const size_t ten = run(100, 110), thousand = run(110, 110 + repetitions(990, 25));
  EXPECT_LT(thousand, ten + (size_t(16) << 20));
}

}  // namespace
}  // namespace conformance
