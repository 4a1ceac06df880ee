#include <tbb/task_arena.h>

#include <algorithm>
#include <chrono>
#include <cstring>
#include <thread>

#include "testenv/conformance/bad_delegate/misbehaviour.h"

namespace bad {

void Buffer::Sync(SceneDelegate* scene, RenderParam* param, DirtyBits* bits) {
  if (*bits & dirty::kDescription && !may_allocate(scene->GetRenderBufferDescriptor(GetId()))) {
    *bits = dirty::kClean;
    return;
  }
  real->Sync(scene, param, bits);
}

// Sees every description that is asked for.
bool Buffer::may_allocate(const RenderBufferDescriptor& description) {
  const bool equal = wanted_ == description;
  wanted_ = description;
  if (is("restarts_on_equal_allocation") && equal) memory_->must_restart = true;
  if (is("scribbles_over_mapped_pixels") && !equal) std::fill(own_.begin(), own_.end(), uint8_t(0));
  return !is("keeps_its_first_size") || allocations_++ == 0;
}

bool Buffer::Allocate(const RenderBufferDescriptor& description) {
  if (!may_allocate(description)) return true;
  return real->Allocate(description) || is("allocates_anything");
}

void Buffer::Resolve() {
  real->Resolve();
}

const void* Buffer::Map() {
  const void* pixels = real->Map();
  const size_t size = size_t(real->GetWidth()) * size_t(real->GetHeight()) * FormatSize(real->GetFormat());
  const char* const spoiling[] = {
      "scribbles_over_mapped_pixels",   "empty_after_restart", "averages_ids", "background_is_zero", "flips_rows",
      "instance_ids_outermost_fastest", "averages_depth"};
  if (!pixels || std::none_of(std::begin(spoiling), std::end(spoiling), is)) return pixels;
  const auto* bytes = static_cast<const uint8_t*>(pixels);
  if (own_.size() < size) own_.reserve(size_t(1) << 20);  // never moved: a reader may be there
  own_.assign(bytes, bytes + size);
  spoil(&own_);
  return own_.data();
}

void Buffer::spoil(std::vector<uint8_t>* pixels) const {
  if (is("empty_after_restart") && memory_->waiting && aov == Token("color"))
    std::fill(pixels->begin(), pixels->end(), uint8_t(0));
  const auto height = static_cast<size_t>(real->GetHeight());
  if (is("flips_rows") && height) {
    const size_t row = pixels->size() / height;
    for (size_t y = 0; y < height / 2; ++y)
      std::swap_ranges(pixels->data() + y * row, pixels->data() + (y + 1) * row,
                       pixels->data() + (height - 1 - y) * row);
  }
  if (real->GetFormat() == Format::int32 || is("averages_depth")) average(pixels);
}

// Ids, and depths by their bits.
void Buffer::average(std::vector<uint8_t>* pixels) const {
  std::vector<int32_t> ids(pixels->size() / 4);
  std::memcpy(ids.data(), pixels->data(), ids.size() * 4);
  if (is("averages_ids"))
    for (size_t i = 0; i + 1 < ids.size(); ++i) ids[i] = (ids[i] + ids[i + 1]) / 2;
  if (is("background_is_zero"))
    for (int32_t& id : ids) id = std::max(id, 0);
  if (is("instance_ids_outermost_fastest") && aov == Token("instanceId"))
    for (int32_t& id : ids) id = id == 1 ? 2 : id == 2 ? 1 : id;
  if (is("averages_depth") && aov == Token("cameraDepth"))
    for (int32_t& bits : ids) {
      float depth = 0;
      std::memcpy(&depth, &bits, 4);
      depth *= 1.1f;
      std::memcpy(&bits, &depth, 4);
    }
  std::memcpy(pixels->data(), ids.data(), ids.size() * 4);
}

uint64_t Buffer::GetGeneration() const {
  return real->GetGeneration() + (is("generation_always_rises") ? ++asked_ : 0);
}

bool Buffer::ResolveTo(PixelMemory* memory) {
  const Vec2i wanted(wanted_.dimensions.x, wanted_.dimensions.y);
  return (is("size_is_ahead_of_pixels") && memory->size == wanted) || real->ResolveTo(memory);
}

// The real pass knows the real buffers alone.
RenderPassState Pass::translated(const RenderPassState& state) const {
  RenderPassState real = state;
  for (AovBinding& binding : real.aovBindings) {
    auto* buffer = static_cast<Buffer*>(binding.renderBuffer);
    if (!buffer) continue;
    buffer->aov = binding.aovName;
    binding.renderBuffer = buffer->real;
    if (is("ignores_clear_values")) binding.clearValue = {};
  }
  Framing& framing = real.framing;
  const Rect2i& window = framing.dataWindow;
  const bool part = window.minX != int(framing.displayMin.x) || window.minY != int(framing.displayMin.y) ||
                    window.maxX != int(framing.displayMax.x) || window.maxY != int(framing.displayMax.y);
  if (is("moves_crops") && part) framing.displayMin.x += 1, framing.displayMax.x += 1;
  if (is("ignores_the_passes_purposes")) real.renderTags = RenderPassState().renderTags;
  if (is("ignores_collections")) real.collection = {};
  if (is("ignores_free_cameras") && real.freeCamera) real.freeCamera.reset(), real.camera = "/camera";
  if (memory_->poisoned) real.camera = "/poisoned";
  return real;
}

// For half a minute at most, because the host's own thread may take such a task.
void Memory::hold_workers() {
  if (holds_workers->exchange(true)) return;
  for (int i = 1; i < tbb::this_task_arena::max_concurrency(); ++i)
    tbb::this_task_arena::enqueue([held = holds_workers] {
      for (int ms = 0; ms < 30000 && *held; ++ms) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    });
}

void Pass::Execute(const RenderPassState& state) {
  RenderDelegate& delegate = *memory_->real;
  if (is("takes_the_hosts_workers")) memory_->hold_workers();
  if (is("stop_does_not_latch") && delegate.IsStopped()) delegate.Restart();
  if (memory_->must_restart.exchange(false)) {  // equal requests would continue
    const Value seed = delegate.GetRenderSetting("seed");
    delegate.SetRenderSetting("seed", static_cast<int32_t>(seed.number_or(0)) + 1);
    real_->Execute(translated(state));
    delegate.SetRenderSetting("seed", seed);
  }
  if (is("seed_is_of_the_threads")) delegate.SetRenderSetting("seed", delegate.GetRenderSetting("threads"));
  if (is("seed_is_of_the_edits")) delegate.SetRenderSetting("seed", memory_->network_syncs.load());
  real_->Execute(translated(state));
  memory_->waiting = !real_->IsConverged();
  lied_ = lied_ && memory_->waiting && real_->GetState() == PassState::rendering && real_->WaitForConvergence(0);
}

bool Pass::IsConverged() const {
  const PassState state = real_->GetState();
  if (is("a_failure_never_converges") && state == PassState::failed) return false;
  if (is("a_stop_converges") && state == PassState::stopped) return true;
  // The picture is whole when this is said, but was not when the host resolved.
  if (is("converges_before_the_last_picture") && state == PassState::rendering && real_->WaitForConvergence(0.1))
    lied_ = true;
  if (lied_) return true;
  return real_->IsConverged();
}

}  // namespace bad
