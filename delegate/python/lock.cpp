#include "delegate/python/lock.h"

#include <unistd.h>

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <stdexcept>
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

bool is_finalizing() {
#if PY_VERSION_HEX >= 0x030D0000
  return Py_IsFinalizing() != 0;
#else
  return _Py_IsFinalizing() != 0;
#endif
}

/// Python's lock is not held. Waits for the end of the process, or returns: functions that run at the exit after ours
/// may wait for this thread.
void wait_for_finalization() {
  constexpr std::chrono::milliseconds kPatience(1000), kLook(5);
  const auto begin = std::chrono::steady_clock::now();
  while (!is_finalizing() && std::chrono::steady_clock::now() - begin < kPatience) std::this_thread::sleep_for(kLook);
  if (is_finalizing()) wait_for_the_end();
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
  const bool ends = is_closed_here();
  if (!ends) enter();
  state_ = PyEval_SaveThread();
  if (!ends) return;
  wait_for_finalization();
  take_lock(state_);
  throw std::runtime_error("the interpreter ends: only the thread that ends it may use hdalabaster");
}

Unlocked::~Unlocked() {
  leave();
  if (is_closed_here()) wait_for_finalization();
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

bool is_closed_here() {
  return g_calls->closed && g_calls->closer != std::this_thread::get_id();
}

bool may_destroy() {
  return !g_calls->stuck && !is_closed_here();
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
