// The thread in which a RenderSession renders.
#pragma once

#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <thread>

#include "core/session/running_render.h"

namespace alabaster {

/// Runs one render at a time. Who hands it the next need not wait for the last.
class RenderSession::Driver {
 public:
  /// `released` is called in the driver's thread, before each render. Empty: nobody wants to know.
  explicit Driver(std::function<void()> released) : released_(std::move(released)) {}
  ~Driver();
  Driver(const Driver&) = delete;
  Driver& operator=(const Driver&) = delete;

  /// Starts the thread unless it is there. May throw.
  void begin();
  /// After begin(): runs it once the render that runs now has ended. One that has not begun by then never does.
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
