// Python's lock around calls of the library, at the end of the interpreter and after a fork. Internal to this room.
#pragma once

#include <cxxabi.h>
#include <pybind11/pybind11.h>

#include <functional>
#include <utility>

namespace alabaster::python {

namespace py = pybind11;

/// Releases Python's lock while it lives, for one call into the library. The lock is held when it is made.
///
/// At the end of the interpreter CPython ends every other thread that takes the lock, and a C++ destructor on its stack
/// then aborts the process. Such threads wait here for the end of the process. Before it, while functions run at the
/// exit that may join them, a thread that enters the library is refused after a second (std::runtime_error).
class Unlocked {
 public:
  Unlocked();
  ~Unlocked();
  Unlocked(const Unlocked&) = delete;
  Unlocked& operator=(const Unlocked&) = delete;

  /// Holds the lock again while it lives, for a callback in the thread of `unlocked`.
  class Locked {
   public:
    explicit Locked(Unlocked& unlocked);
    ~Locked();
    Locked(const Locked&) = delete;
    Locked& operator=(const Locked&) = delete;

   private:
    Unlocked& unlocked_;
  };

 private:
  PyThreadState* state_;
};

[[noreturn]] void wait_for_the_end();

/// Runs `call`, which runs Python code of the host.
template <class Call>
auto with_host_code(const Call& call) {
  try {
    return call();
  } catch (abi::__forced_unwind&) {
    wait_for_the_end();
  }
}

/// True after leave_library(): no callback runs Python code any more.
bool interpreter_ends();
/// True after leave_library() of another thread.
bool is_closed_here();

/// For the end of the interpreter: calls `stop`, without the lock, until all other threads have left the library, for
/// some seconds at most. From then on other threads do not enter it.
void leave_library(const std::function<void()>& stop);

/// For the child of a fork: the threads of the parent are in no call here.
void forget_threads();

/// False: a thread has not left the library at the end of the interpreter, which uses its handles, or this thread must
/// not enter it any more.
bool may_destroy();

/// Destroys without Python's lock: the library may have to wait for a thread that wants it.
template <class T>
void drop(T& held) {
  if (!may_destroy()) {
    static_cast<void>(new T(std::move(held)));
    return;
  }
  const Unlocked unlocked;
  const T gone = std::move(held);
}

}  // namespace alabaster::python
