#include "delegate/view/picture_fetcher.h"

#include <algorithm>

namespace alabaster::view {
namespace {

// The range of the numbers that a buffer holds now.
std::array<float, 2> range_of(hd::RenderBuffer* buffer) {
  buffer->Resolve();
  hd::PixelMemory memory;
  const hd::Vec2i size(buffer->GetWidth(), buffer->GetHeight());
  const auto components = size_t(std::max(1, hd::FormatComponents(buffer->GetFormat())));
  // Two and three components come out as four.
  memory.format = components == 1 ? hd::Format::float32 : hd::Format::float32vec3;
  const size_t kept = components == 1 ? 1 : 3, count = size_t(size.x) * size_t(size.y);
  std::vector<float> values(kept * count);
  memory.size = size, memory.pixels = values.data();
  memory.rowBytes = kept * sizeof(float) * size_t(size.x);
  if (values.empty() || !buffer->ResolveTo(&memory)) return {0, 1};
  return finite_range(values.data(), nullptr, count, kept);
}

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
  }
}

void PictureFetcher::make(Side* side, const PictureRequest& request) {
  const bool ranged = request.kind == DataKind::number || request.kind == DataKind::vector;
  const auto range = ranged ? range_of(request.buffer) : std::array{0.0f, 1.0f};
  const bool other = !(side->request == request) || range != side->range;
  side->request = request, side->range = range;
  if (other) {
    side->memory.shown = 0;
    side->data = request.kind == DataKind::light ? nullptr : std::make_unique<DataView>(request.kind, range);
    side->memory.transform = side->data ? side->data.get() : request.display.get();
  }
  hd::PixelMemory& memory = side->memory;
  memory.format = hd::Format::unorm8vec4;
  const uint64_t before = memory.shown;
  for (int tries = 0; tries < 3 && !request.buffer->ResolveTo(&memory); ++tries) {
    side->made.size = memory.size;
    side->made.rgba.resize(size_t(memory.size.x) * size_t(memory.size.y) * 4);
    memory.pixels = side->made.rgba.data();
    memory.rowBytes = size_t(memory.size.x) * 4;
    memory.shown = 0;
  }
  if (memory.shown == before || memory.shown == 0) return;
  ++side->made.number;
  const std::lock_guard lock(mutex_);
  side->ready.size = side->made.size;
  side->ready.rgba = side->made.rgba;
  side->ready.number = side->made.number;
}

}  // namespace alabaster::view
