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

TEST(DeferredNotifier, NotifiesAtOnceWithoutAPoller) {
  int notified = 0;
  DeferredNotifier notifier([&] { ++notified; }, {});
  notifier.request();
  EXPECT_EQ(notified, 1);
  {
    const DeferredNotifier::Poller poller(&notifier);
    notifier.request();
    notifier.request();
    EXPECT_EQ(notified, 1);
    poller.poll();
    poller.poll();
    EXPECT_EQ(notified, 2);
    {
      notifier.request();
      EXPECT_EQ(notified, 2);
      const DeferredNotifier::PollingPause pause(&notifier);
      EXPECT_EQ(notified, 3) << "the pause notifies, for no other thread polls";
      notifier.request();
      EXPECT_EQ(notified, 4);
    }
    notifier.request();
    EXPECT_EQ(notified, 4);
  }
  EXPECT_EQ(notified, 5) << "the end of the last poller notifies";
}

TEST(DeferredNotifier, PollersWaitForTheGrace) {
  int notified = 0;
  DeferredNotifier notifier([&] { ++notified; }, std::chrono::milliseconds(200));
  const DeferredNotifier::Poller poller(&notifier);
  const auto begun = DeferredNotifier::Clock::now();
  notifier.request();
  while (notified == 0) {
    notifier.request();  // puts nothing off
    poller.poll();
  }
  const std::chrono::duration<double> waited = DeferredNotifier::Clock::now() - begun;
  EXPECT_GE(waited.count(), 0.2);
}

// How long yield_core() takes a thread of its own, in seconds, while `meanwhile` runs here.
template <class F>
double yielded_seconds(DeferredNotifier* notifier, const std::atomic<bool>& stopped, const F& meanwhile) {
  const auto yield = [&] {
    const DeferredNotifier::Poller poller(notifier);
    const auto begun = DeferredNotifier::Clock::now();
    notifier->yield_core(stopped);
    return std::chrono::duration<double>(DeferredNotifier::Clock::now() - begun).count();
  };
  auto yielded = std::async(std::launch::async, yield);
  meanwhile();
  return yielded.get();
}

TEST(DeferredNotifier, OneThreadYieldsItsCoreUntilTheWorkEnds) {
  DeferredNotifier notifier([] {}, {});
  const std::atomic<bool> go_on{false};
  notifier.yield_core(go_on);  // no work goes on: it returns
  EXPECT_FALSE(notifier.wants_core());
  notifier.begin_work();
  EXPECT_TRUE(notifier.wants_core());
  yielded_seconds(&notifier, go_on, [&] {
    while (notifier.wants_core()) std::this_thread::yield();
    notifier.yield_core(go_on);  // one thread yields already: it returns
    notifier.end_work();
  });
  EXPECT_FALSE(notifier.wants_core());
  notifier.begin_work();
  EXPECT_TRUE(notifier.wants_core()) << "other work wants a core again";
  notifier.end_work();
}

TEST(DeferredNotifier, LongWorkAndAStopGetNoCoreForLong) {
  DeferredNotifier notifier([] {}, {});
  std::atomic<bool> stopped{false};
  notifier.begin_work();
  EXPECT_GT(yielded_seconds(&notifier, stopped, [] {}), 0.029);
  EXPECT_FALSE(notifier.wants_core()) << "no core is yielded twice for the same work";
  notifier.begin_work();
  stopped = true;
  EXPECT_LT(yielded_seconds(&notifier, stopped, [] {}), 0.029);
  notifier.end_work();
}

TEST(DeferredNotifier, AThreadThatYieldsItsCoreDoesNotPoll) {
  std::atomic<int> notified{0};
  DeferredNotifier notifier([&] { ++notified; }, std::chrono::seconds(100));
  const std::atomic<bool> go_on{false};
  notifier.begin_work();
  yielded_seconds(&notifier, go_on, [&] {
    while (notifier.wants_core()) std::this_thread::yield();
    notifier.request();
    while (notified == 0) std::this_thread::yield();  // by this thread, or by the other one when its pause begins
    notifier.end_work();
  });
  EXPECT_EQ(notified, 1);
}

TEST(DeferredNotifier, LosesNoRequestWhilePollersComeAndGo) {
  std::atomic<int> requested{0}, seen{0};
  DeferredNotifier notifier([&] { seen = requested.load(); }, std::chrono::microseconds(5));
  std::atomic<bool> over{false};
  std::vector<std::thread> pollers;
  for (int i = 0; i < 3; ++i)
    pollers.emplace_back([&] {
      while (!over) {
        const DeferredNotifier::Poller poller(&notifier);
        poller.poll();
      }
    });
  for (int i = 1; i <= 20000; ++i) {
    requested = i;
    notifier.request();
    while (seen < i) std::this_thread::yield();  // without end if a request is lost
  }
  over = true;
  for (auto& thread : pollers) thread.join();
  EXPECT_EQ(seen, 20000);
}

TEST(DeferredNotifier, RenderThreadsNotify) {
  std::mutex mutex;
  std::condition_variable woken;
  std::thread::id by;
  SessionOwner owner;
  const auto wake = [&] {
    const std::lock_guard lock(mutex);
    by = std::this_thread::get_id();
    woken.notify_all();
  };
  owner.notifier = std::make_shared<DeferredNotifier>(wake, std::chrono::microseconds(100));
  RenderSession session(owner);
  session.start(mixed_request(1u << 20));
  while (session.progress().samples_done == 0) std::this_thread::yield();
  bool by_another = false;
  for (int attempt = 0; attempt < 1000 && !by_another; ++attempt) {  // no thread polls between two tiles
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
    std::unique_lock lock(mutex);
    by = {};
    lock.unlock();
    owner.notifier->request();
    lock.lock();
    ASSERT_TRUE(woken.wait_for(lock, std::chrono::seconds(20), [&] { return by != std::thread::id(); }));
    by_another = by != std::this_thread::get_id();
  }
  EXPECT_TRUE(by_another);
  session.stop();
  by = {};
  owner.notifier->request();
  EXPECT_EQ(by, std::this_thread::get_id()) << "no thread renders";
}

}  // namespace
}  // namespace alabaster
