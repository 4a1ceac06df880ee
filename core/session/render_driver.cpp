#include "core/session/render_driver.h"

#include <utility>

#include "core/math/float_environment.h"

namespace alabaster {

RenderSession::Driver::~Driver() {
  {
    const std::lock_guard lock(mutex_);
    quit_ = true;
  }
  changed_.notify_all();
  if (thread_.joinable()) thread_.join();
}

void RenderSession::Driver::begin() {
  if (!thread_.joinable()) thread_ = std::thread([this] { loop(); });
}

// A busy driver takes the next render without a notification. The render that this one replaces is marked as stopped,
// for threads may wait for it.
void RenderSession::Driver::run(std::shared_ptr<Render> render) {
  bool idle = false;
  {
    const std::lock_guard lock(mutex_);
    next_.swap(render);
    idle = !busy_;
    busy_ = true;
  }
  if (idle) changed_.notify_all();
  if (render) render->mark_dropped();
}

void RenderSession::Driver::wait() {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [this] { return !busy_; });
}

// Null: the driver ends.
std::shared_ptr<RenderSession::Render> RenderSession::Driver::take_next() {
  std::unique_lock lock(mutex_);
  if (!next_) {
    busy_ = false;
    changed_.notify_all();
  }
  changed_.wait(lock, [this] { return next_ || quit_; });
  return std::exchange(next_, nullptr);
}

void RenderSession::Driver::loop() {
  const FloatEnvironment environment;
  std::shared_ptr<Render> last;
  while (std::shared_ptr<Render> render = take_next()) {
    if (last) render->take_film_memory(last.get());
    last = std::move(render);
    if (released_) released_();
    last->render();
  }
}

}  // namespace alabaster
