#include "delegate/python/lock.h"

#include <unistd.h>

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <thread>

namespace alabaster::python {
namespace {

/// The threads that are in a call of the library.
struct Calls {
  std::mutex mutex;
  std::condition_variable left;
  int threads = 0;
  std::atomic<bool> closed{false}, stuck{false};
  std::thread::id closer;
};
Calls* g_calls = new Calls;    // threads may outlive static objects
thread_local int t_calls = 0;  // of this thread: callbacks may call the library

// CPython before 3.14 ends a thread by pthread_exit, whose unwinding is caught here and does not continue.
void take_lock(PyThreadState* state) noexcept {
  try {
    PyEval_RestoreThread(state);
  } catch (...) {
    wait_for_the_end();
  }
}

/// The interpreter ends, in another thread.
bool must_wait() {
  return g_calls->closed && g_calls->closer != std::this_thread::get_id();
}

void enter() {
  Calls& calls = *g_calls;
  const std::lock_guard lock(calls.mutex);
  ++calls.threads, ++t_calls;
}

void leave() {
  Calls& calls = *g_calls;
  const std::lock_guard lock(calls.mutex);
  --calls.threads, --t_calls;
  calls.left.notify_all();
}

}  // namespace

void wait_for_the_end() {
  for (;;) pause();
}

Unlocked::Unlocked() : state_(nullptr) {
  const bool ends = must_wait();
  if (!ends) enter();
  state_ = PyEval_SaveThread();
  if (ends) wait_for_the_end();
}

Unlocked::~Unlocked() {
  leave();
  if (must_wait()) wait_for_the_end();
  take_lock(state_);
}

Unlocked::Locked::Locked(Unlocked& unlocked) : unlocked_(unlocked) {
  take_lock(unlocked_.state_);
}

Unlocked::Locked::~Locked() {
  unlocked_.state_ = PyEval_SaveThread();
}

bool interpreter_ends() {
  return g_calls->closed;
}

bool may_destroy() {
  return !g_calls->stuck;
}

void leave_library(const std::function<void()>& stop) {
  constexpr auto kLook = std::chrono::milliseconds(50);
  constexpr int kMostLooks = 200;
  Calls& calls = *g_calls;
  calls.closer = std::this_thread::get_id();
  calls.closed = true;
  PyThreadState* const state = PyEval_SaveThread();
  bool left = false;
  for (int look = 0; look < kMostLooks && !left; ++look) {
    stop();
    std::unique_lock lock(calls.mutex);
    left = calls.left.wait_for(lock, kLook, [&] { return calls.threads == t_calls; });
  }
  stop();  // a thread may have started a render before it left
  calls.stuck = !left;
  take_lock(state);
}

void forget_threads() {
  g_calls = new Calls;
  g_calls->threads = t_calls;
}

}  // namespace alabaster::python
