#include "delegate/view/picture_fetcher.h"

#include <algorithm>

namespace alabaster::view {
namespace {

constexpr auto kRangeRest = std::chrono::milliseconds(500);  // between two ranges of a picture that goes on changing

}  // namespace

PictureFetcher::PictureFetcher() : thread_([this] { run(); }) {}

PictureFetcher::~PictureFetcher() {
  {
    const std::lock_guard lock(mutex_);
    end_ = true;
  }
  wake_.notify_one();
  thread_.join();
}

void PictureFetcher::fetch(const PictureRequest& left, const PictureRequest& right) {
  {
    const std::lock_guard lock(mutex_);
    if (busy_ || asked_) return;
    requests_[0] = left, requests_[1] = right;
    asked_ = true;
  }
  wake_.notify_one();
}

bool PictureFetcher::take(bool right, Picture* picture) {
  const std::lock_guard lock(mutex_);
  Picture& ready = sides_[right].ready;
  if (ready.number <= picture->number) return false;
  std::swap(ready, *picture);
  ready.number = 0;
  return true;
}

bool PictureFetcher::busy() const {
  const std::lock_guard lock(mutex_);
  return busy_ || asked_;
}

void PictureFetcher::forget() {
  std::unique_lock lock(mutex_);
  idle_.wait(lock, [this] { return !busy_ && !asked_; });
  for (Side& side : sides_) side.request = {}, side.memory = {}, side.numbers = {};
}

void PictureFetcher::run() {
  std::unique_lock lock(mutex_);
  for (;;) {
    wake_.wait(lock, [this] { return asked_ || end_; });
    if (end_) return;
    asked_ = false, busy_ = true;
    const PictureRequest requests[2] = {requests_[0], requests_[1]};
    lock.unlock();
    try {
      for (int i = 0; i < 2; ++i)
        if (requests[i].buffer) make(&sides_[i], requests[i]);
    } catch (const std::exception&) {
      // Without memory for a picture the last one stays.
    }
    lock.lock();
    busy_ = false;
    idle_.notify_one();
  }
}

// Finds the range again where pixels have changed; while they go on changing, twice a second at most, since another
// range has all pixels written again.
std::array<float, 2> PictureFetcher::Range::of(hd::RenderBuffer* now) {
  now->Resolve();
  const auto time = std::chrono::steady_clock::now();
  const uint64_t generation = now->GetGeneration();
  const bool other = now != buffer || memory.shown == 0;
  if (!other && (generation == found_in || (!now->IsConverged() && time - found_at < kRangeRest))) return range;
  const auto components = size_t(std::max(1, hd::FormatComponents(now->GetFormat())));
  // Two and three components come out as four.
  const hd::Format format = components == 1 ? hd::Format::float32 : hd::Format::float32vec3;
  const size_t kept = components == 1 ? 1 : 3;
  if (other || memory.format != format) memory = {}, memory.format = format;
  buffer = now, found_in = generation, found_at = time;
  range = resolve(now, kept, &memory, &values) ? finite_range(values.data(), nullptr, values.size() / kept, kept)
                                               : std::array{0.0f, 1.0f};
  return range;
}

void PictureFetcher::make(Side* side, const PictureRequest& request) {
  const bool ranged = request.kind == DataKind::number || request.kind == DataKind::vector;
  const auto range = ranged ? side->numbers.of(request.buffer) : std::array{0.0f, 1.0f};
  const bool other = !(side->request == request) || range != side->range;
  side->request = request, side->range = range;
  if (other) {
    side->memory.shown = 0;
    side->data.reset();
    if (request.kind != DataKind::light)
      side->data = std::make_unique<DataView>(request.kind, range);
    else if (hd::FormatComponents(request.buffer->GetFormat()) == 1)
      side->data = std::make_unique<GrayLight>(request.display);
    side->memory.transform = side->data ? side->data.get() : request.display.get();
  }
  hd::PixelMemory& memory = side->memory;
  memory.format = hd::Format::unorm8vec4;
  const uint64_t before = memory.shown;
  if (!resolve(request.buffer, 4, &memory, &side->made.rgba) || memory.shown == before) return;
  side->made.size = memory.size;
  ++side->made.number;
  const std::lock_guard lock(mutex_);
  side->ready.size = side->made.size;
  side->ready.rgba = side->made.rgba;
  side->ready.number = side->made.number;
}

}  // namespace alabaster::view
