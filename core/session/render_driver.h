// The thread in which a RenderSession renders.
#pragma once

#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <thread>

#include "core/session/running_render.h"

namespace alabaster {

/// Runs one render at a time. run() does not wait for the last one.
class RenderSession::Driver {
 public:
  /// `released` (SessionOwner::released) is called in the driver's thread, before each render. It may be empty.
  explicit Driver(std::function<void()> released) : released_(std::move(released)) {}
  ~Driver();
  Driver(const Driver&) = delete;
  Driver& operator=(const Driver&) = delete;

  /// Starts the thread unless it is there. May throw.
  void begin();
  /// After begin(): runs it once the running render has ended. A render handed over before, which has not begun, is
  /// dropped.
  void run(std::shared_ptr<Render> render);
  /// Blocks until no render runs or is to run.
  void wait();

 private:
  void loop();
  std::shared_ptr<Render> take_next();

  const std::function<void()> released_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::shared_ptr<Render> next_;
  bool busy_ = false, quit_ = false;
  std::thread thread_;
};

}  // namespace alabaster
