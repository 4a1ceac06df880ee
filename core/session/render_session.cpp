#include "core/session/render_session.h"

#include <algorithm>
#include <chrono>
#include <limits>

#include "core/session/render_driver.h"
#include "core/session/running_render.h"

namespace alabaster {

RenderSession::RenderSession(SessionOwner owner)
    : notifier_(std::move(owner.notifier)),
      current_(std::make_shared<Render>()),
      driver_(std::make_unique<Driver>(std::move(owner.released))) {}

RenderSession::~RenderSession() {
  stop();
}

std::shared_ptr<RenderSession::Render> RenderSession::current() const {
  const std::lock_guard lock(mutex_);
  return current_;
}

// A render that continues the last one waits here for its end. Any other begins in the driver's thread, once the last
// one has ended there.
void RenderSession::start(const RenderRequest& request) {
  RenderRequest guided = request;
  guided.aovs = with_guides(request.aovs);
  driver_->begin();
  const std::shared_ptr<Render> last = current();
  if (request.resumed || can_continue(last->request, guided)) {
    last->request_stop();
    driver_->wait();
  }
  auto next = std::make_shared<Render>(guided, last.get(), notifier_.get());
  {
    const std::lock_guard lock(mutex_);
    current_ = next;
  }
  last->request_stop();  // after the swap: wait() then finds the next render
  driver_->run(std::move(next));
}

void RenderSession::pause() {
  current()->set_paused(true);
}

void RenderSession::resume() {
  current()->set_paused(false);
}

void RenderSession::stop() {
  current()->request_stop();
  driver_->wait();
}

void RenderSession::ask_for_noise() {
  current()->noise_asked = true;
}

void RenderSession::denoise_stopped(const Film* film) {
  const std::shared_ptr<Render> render = current();
  const std::lock_guard one_at_a_time(render->stopped_denoise);
  if (film) render->denoise(film);
}

bool RenderSession::wait(double seconds) {
  const SessionClock::time_point begun = SessionClock::now();
  for (;;) {
    const std::shared_ptr<Render> render = current();
    if (!render->wait(seconds - seconds_since(begun))) return false;
    if (render == current()) return true;  // else another has replaced it
  }
}

bool RenderSession::save(const BlockSink& sink) {
  return current()->save(sink);
}

RenderProgress RenderSession::progress() const {
  return current()->report();
}

std::shared_ptr<const Film> RenderSession::film() const {
  const std::shared_ptr<Render> render = current();
  const std::lock_guard lock(render->mutex);
  return render->film;
}

}  // namespace alabaster
