// A render that replaces another one, and wake-ups that threads which render pass on.
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <future>
#include <mutex>
#include <thread>

#include "core/session/render_session.h"
#include "testenv/support/same_bytes.h"
#include "testenv/support/scene_builder.h"

namespace alabaster {
namespace {

using testing::mixed_request;

// Holds who passes until it is open.
class Gate {
 public:
  void pass() {
    std::unique_lock lock(mutex_);
    ++passing_;
    changed_.notify_all();
    changed_.wait(lock, [&] { return open_; });
  }
  void await_one() {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return passing_ > 0; });
  }
  void open() {
    const std::lock_guard lock(mutex_);
    open_ = true;
    changed_.notify_all();
  }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  bool open_ = false;
  int passing_ = 0;
};

RenderRequest seeded_request(uint32_t seed) {
  RenderRequest request = mixed_request(4);
  request.settings.seed = seed;
  return request;
}

bool same_picture(const Film& a, const Film& b) {
  return testing::same_bytes(a.resolve_float(Aov::color), b.resolve_float(Aov::color));
}

TEST(RenderHandover, StartDoesNotWaitForTheLastRender) {
  Gate gate;
  SessionOwner owner;
  owner.released = [&] { gate.pass(); };
  RenderSession session(owner);
  session.start(seeded_request(1));
  gate.await_one();
  std::future<void> started = std::async(std::launch::async, [&] {
    session.start(seeded_request(2));
    session.start(seeded_request(3));
  });
  const bool returned = started.wait_for(std::chrono::seconds(20)) == std::future_status::ready;
  EXPECT_TRUE(returned);
  if (returned) {
    EXPECT_EQ(session.progress().state, SessionState::rendering);
    EXPECT_EQ(session.progress().samples_done, 0u);
    EXPECT_FALSE(session.wait(0.01)) << "the last of them has not begun";
    EXPECT_EQ(session.film()->revision(), 0u);
  }
  gate.open();
  started.wait();
  EXPECT_TRUE(session.wait(1e9));
  EXPECT_EQ(session.progress().state, SessionState::finished);
  EXPECT_TRUE(same_picture(*session.film(), *testing::render(seeded_request(3))));
}

TEST(RenderHandover, AStopEndsARenderThatHasNotBegun) {
  Gate gate;
  SessionOwner owner;
  owner.released = [&] { gate.pass(); };
  RenderSession session(owner);
  session.start(seeded_request(1));
  gate.await_one();
  session.start(seeded_request(2));
  std::thread opener([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    gate.open();
  });
  session.stop();
  opener.join();
  EXPECT_EQ(session.progress().state, SessionState::stopped);
  EXPECT_EQ(session.progress().samples_done, 0u);
}

// A thread that waits for a picture waits for the one that replaces it.
TEST(RenderHandover, WaitsForTheRenderThatReplacesAnother) {
  RenderSession session;
  RenderRequest endless = mixed_request(1u << 20);
  session.start(endless);
  std::future<bool> over = std::async(std::launch::async, [&] { return session.wait(1e9); });
  for (uint32_t seed = 1; seed < 20; ++seed) {
    endless.settings.seed = seed;
    session.start(endless);
  }
  EXPECT_EQ(over.wait_for(std::chrono::milliseconds(50)), std::future_status::timeout);
  session.start(seeded_request(20));
  EXPECT_TRUE(over.get());
  EXPECT_EQ(session.progress().state, SessionState::finished);
  EXPECT_TRUE(same_picture(*session.film(), *testing::render(seeded_request(20))));
}

TEST(RenderHandover, AFilmTakesTheMemoryOfTheLastOfItsShape) {
  const RenderRequest request = seeded_request(1);
  const auto drawn = testing::render(request);
  Film old(drawn->data_window(), drawn->aovs()), next(drawn->data_window(), drawn->aovs());
  for (int tile = 0; tile < drawn->tile_count(); ++tile) old.store_tile(tile, drawn->load_tile(tile));
  const FilmTile* held = nullptr;
  old.change_tile(0, [&](FilmTile& tile) { held = &tile; });
  next.take_memory(&old);
  EXPECT_FALSE(next.is_covered());
  EXPECT_TRUE(same_picture(next, Film(drawn->data_window(), drawn->aovs()))) << "old samples show";
  next.change_tile(0, [&](FilmTile& tile) { EXPECT_EQ(held, &tile); });
  for (int tile = 0; tile < drawn->tile_count(); ++tile) next.store_tile(tile, drawn->load_tile(tile));
  EXPECT_TRUE(same_picture(next, *drawn));
}

TEST(WakeRelay, WakesAtOnceWithoutACarrier) {
  int wakes = 0;
  WakeRelay relay([&] { ++wakes; }, {});
  relay.ask();
  EXPECT_EQ(wakes, 1);
  {
    const WakeRelay::Carrier carrier(&relay);
    relay.ask();
    relay.ask();
    EXPECT_EQ(wakes, 1);
    carrier.pass_on();
    carrier.pass_on();
    EXPECT_EQ(wakes, 2);
    {
      relay.ask();
      EXPECT_EQ(wakes, 2);
      const WakeRelay::Rest rest(&relay);
      EXPECT_EQ(wakes, 3) << "who rests has passed on before";
      relay.ask();
      EXPECT_EQ(wakes, 4);
    }
    relay.ask();
    EXPECT_EQ(wakes, 4);
  }
  EXPECT_EQ(wakes, 5) << "who stops carrying passes on";
}

TEST(WakeRelay, CarriersWaitForTheGrace) {
  int wakes = 0;
  WakeRelay relay([&] { ++wakes; }, std::chrono::milliseconds(200));
  const WakeRelay::Carrier carrier(&relay);
  const auto begun = WakeRelay::Clock::now();
  relay.ask();
  while (wakes == 0) {
    relay.ask();  // puts nothing off
    carrier.pass_on();
  }
  const std::chrono::duration<double> waited = WakeRelay::Clock::now() - begun;
  EXPECT_GE(waited.count(), 0.2);
}

// How long lend_core() takes a thread of its own, in seconds, while `meanwhile` runs here.
template <class F>
double lent_seconds(WakeRelay* relay, const std::atomic<bool>& stopped, const F& meanwhile) {
  const auto lend = [&] {
    const WakeRelay::Carrier carrier(relay);
    const auto begun = WakeRelay::Clock::now();
    relay->lend_core(stopped);
    return std::chrono::duration<double>(WakeRelay::Clock::now() - begun).count();
  };
  auto lent = std::async(std::launch::async, lend);
  meanwhile();
  return lent.get();
}

TEST(WakeRelay, OneThreadLendsItsCoreUntilTheWorkEnds) {
  WakeRelay relay([] {}, {});
  const std::atomic<bool> go_on{false};
  relay.lend_core(go_on);  // nobody works: it returns
  EXPECT_FALSE(relay.wants_core());
  relay.begin_work();
  EXPECT_TRUE(relay.wants_core());
  lent_seconds(&relay, go_on, [&] {
    while (relay.wants_core()) std::this_thread::yield();
    relay.lend_core(go_on);  // one lends already: it returns
    relay.end_work();
  });
  EXPECT_FALSE(relay.wants_core());
  relay.begin_work();
  EXPECT_TRUE(relay.wants_core()) << "for other work it is asked again";
  relay.end_work();
}

TEST(WakeRelay, LongWorkAndAStopGetNoCoreForLong) {
  WakeRelay relay([] {}, {});
  std::atomic<bool> stopped{false};
  relay.begin_work();
  EXPECT_GT(lent_seconds(&relay, stopped, [] {}), 0.029);
  EXPECT_FALSE(relay.wants_core()) << "nobody lends twice for the same work";
  relay.begin_work();
  stopped = true;
  EXPECT_LT(lent_seconds(&relay, stopped, [] {}), 0.029);
  relay.end_work();
}

TEST(WakeRelay, AThreadThatLendsItsCoreCarriesNothing) {
  std::atomic<int> wakes{0};
  WakeRelay relay([&] { ++wakes; }, std::chrono::seconds(100));
  const std::atomic<bool> go_on{false};
  relay.begin_work();
  lent_seconds(&relay, go_on, [&] {
    while (relay.wants_core()) std::this_thread::yield();
    relay.ask();
    while (wakes == 0) std::this_thread::yield();  // by this thread, or by the other one when it begins to wait
    relay.end_work();
  });
  EXPECT_EQ(wakes, 1);
}

TEST(WakeRelay, LosesNothingWhileCarriersComeAndGo) {
  std::atomic<int> asked{0}, seen{0};
  WakeRelay relay([&] { seen = asked.load(); }, std::chrono::microseconds(5));
  std::atomic<bool> over{false};
  std::vector<std::thread> carriers;
  for (int i = 0; i < 3; ++i)
    carriers.emplace_back([&] {
      while (!over) {
        const WakeRelay::Carrier carrier(&relay);
        carrier.pass_on();
      }
    });
  for (int i = 1; i <= 20000; ++i) {
    asked = i;
    relay.ask();
    while (seen < i) std::this_thread::yield();  // without end if a wake-up is lost
  }
  over = true;
  for (auto& carrier : carriers) carrier.join();
  EXPECT_EQ(seen, 20000);
}

TEST(WakeRelay, ThreadsThatRenderCarryIt) {
  std::mutex mutex;
  std::condition_variable woken;
  std::thread::id by;
  SessionOwner owner;
  const auto wake = [&] {
    const std::lock_guard lock(mutex);
    by = std::this_thread::get_id();
    woken.notify_all();
  };
  owner.wakes = std::make_shared<WakeRelay>(wake, std::chrono::microseconds(100));
  RenderSession session(owner);
  session.start(mixed_request(1u << 20));
  while (session.progress().samples_done == 0) std::this_thread::yield();
  bool by_another = false;
  for (int attempt = 0; attempt < 1000 && !by_another; ++attempt) {  // between two tiles nobody carries
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
    std::unique_lock lock(mutex);
    by = {};
    lock.unlock();
    owner.wakes->ask();
    lock.lock();
    ASSERT_TRUE(woken.wait_for(lock, std::chrono::seconds(20), [&] { return by != std::thread::id(); }));
    by_another = by != std::this_thread::get_id();
  }
  EXPECT_TRUE(by_another);
  session.stop();
  by = {};
  owner.wakes->ask();
  EXPECT_EQ(by, std::this_thread::get_id()) << "nobody renders";
}

}  // namespace
}  // namespace alabaster
