#include "delegate/rendering/render_buffer.h"

#include "delegate/rendering/pixel_memory.h"

namespace alabaster::hd::rendering {
namespace {

constexpr int kMaxSize = 1 << 16;
constexpr size_t kMaxBytes = size_t(16) << 30;

const char* allocation_fault(const RenderBufferDescriptor& d) {
  if (d.dimensions.x < 0 || d.dimensions.y < 0 || d.dimensions.x > kMaxSize || d.dimensions.y > kMaxSize)
    return "width and height must be from 0 to 65536";
  if (d.dimensions.z != 1) return "depth must be 1";
  if (FormatComponents(d.format) == 0) return "the format is invalid";
  if (static_cast<size_t>(d.dimensions.x) * static_cast<size_t>(d.dimensions.y) * FormatSize(d.format) > kMaxBytes)
    return "the buffer would exceed 16 GB";
  return nullptr;
}

}  // namespace

bool BufferState::allocate(const RenderBufferDescriptor& description, const alabaster::DiagnosticSink& sink) {
  if (const char* fault = allocation_fault(description)) {
    alabaster::report(sink, alabaster::Severity::error, "buffer.allocate", id_.str(),
                      std::string(fault) + "; the buffer stays as it was");
    return false;
  }
  const std::lock_guard lock(mutex_);
  if (wanted_ == description) return true;
  wanted_ = description;
  ++allocation_;
  if (binding_ == 0) {  // nothing was ever drawn into it: nothing is lost by resizing now
    effective_ = description;
    store_ = nullptr;
  }
  return true;
}

void BufferState::bind(BufferSource source) {
  const std::lock_guard lock(mutex_);
  effective_ = wanted_;
  source_ = std::move(source);
  ++binding_;
}

void BufferState::release_film() {
  const std::lock_guard lock(mutex_);
  source_.film = nullptr;
}

const std::shared_ptr<BufferStore>& BufferState::current() const {
  return mapped_.empty() ? store_ : mapped_.back();
}

RenderBufferDescriptor BufferState::shown() const {
  const std::lock_guard lock(mutex_);
  return current() ? current()->description() : effective_;
}

namespace {

// False: a Resolve has nothing to add to a store of this revision. One that shows another size or AOV stays until the
// new picture is whole.
bool has_news(const Film& film, bool fits, FilmRevision shown) {
  if (film.revision() == 0 || !fits) return film.has_ended() || (film.revision() != 0 && film.is_covered());
  return film.revision() != shown || (film.has_ended() && !film.is_covered());
}

}  // namespace

// Converts outside the lock. Two Resolves may run at once: the one that saw the later film wins.
void BufferState::resolve() {
  BufferSource source;
  RenderBufferDescriptor description;
  uint64_t binding = 0;
  std::shared_ptr<BufferStore> shown, next;
  {
    const std::lock_guard lock(mutex_);
    if (!source_.film) return;
    source = source_;
    description = effective_;
    binding = binding_;
  }
  if (source.complete) source.complete();
  {
    const std::lock_guard lock(mutex_);
    if (store_ && !store_->is_blank()) shown = store_;
    const bool fits = shown && shown->fits(description, source);
    if (shown && !has_news(*source.film, fits, shown->revision())) return;
    if (fits && spare_ && spare_.use_count() == 1 && spare_->fits(description, source)) next = std::move(spare_);
    spare_ = nullptr;
    if (!fits) shown = nullptr;
  }
  if (!next) next = std::make_shared<BufferStore>(description, source);
  const bool differs = next->update(source, shown.get());
  const std::lock_guard lock(mutex_);
  if (binding < store_binding_ || (binding == store_binding_ && store_ && next->revision() < store_->revision()))
    return;
  store_binding_ = binding;
  if (differs) next->set_number(++generation_, shown == store_ ? shown.get() : nullptr);
  spare_ = differs ? std::exchange(store_, std::move(next)) : std::move(next);
}

std::shared_ptr<const BufferStore> BufferState::picture() {
  BufferSource source;
  RenderBufferDescriptor description;
  {
    const std::lock_guard lock(mutex_);
    if (store_) return store_;
    description = effective_;
    source.clear = source_.clear;
  }
  if (FormatComponents(description.format) == 0) return nullptr;
  const auto blank = std::make_shared<BufferStore>(description, source);
  const std::lock_guard lock(mutex_);
  if (!store_ && effective_ == description) store_ = blank;
  return store_;
}

const void* BufferState::map() {
  picture();
  const std::lock_guard lock(mutex_);
  if (!store_) return nullptr;
  if (mapped_.empty() || mapped_.back() != store_) mapped_.push_back(store_);
  ++map_count_;
  return store_->pixels().data();
}

void BufferState::unmap() {
  std::vector<std::shared_ptr<BufferStore>> released;  // freed outside the lock
  const std::lock_guard lock(mutex_);
  if (map_count_ > 0 && --map_count_ == 0) released.swap(mapped_);
}

bool BufferState::is_mapped() const {
  const std::lock_guard lock(mutex_);
  return map_count_ > 0;
}

std::vector<std::shared_ptr<const void>> BufferState::mapped_stores() const {
  const std::lock_guard lock(mutex_);
  return {mapped_.begin(), mapped_.end()};
}

RenderBufferPrim::RenderBufferPrim(const Path& id, std::shared_ptr<prims::SceneParam> param)
    : RenderBuffer(id), param_(std::move(param)), state_(std::make_shared<BufferState>(id)) {}

// A mapping outlives its buffer: the delegate keeps what a host may still read.
RenderBufferPrim::~RenderBufferPrim() {
  prims::guarded(param_->sink(), GetId().str(), [&] {
    for (auto& store : state_->mapped_stores()) param_->keep(std::move(store));
  });
}

void RenderBufferPrim::Sync(SceneDelegate* scene, RenderParam*, DirtyBits* bits) {
  const bool synced = prims::guarded(param_->sink(), GetId().str(), [&] {
    if (*bits & dirty::kDescription) Allocate(scene->GetRenderBufferDescriptor(GetId()));
  });
  if (synced) *bits = dirty::kClean;
}

void RenderBufferPrim::Finalize(RenderParam*) {}

bool RenderBufferPrim::Allocate(const RenderBufferDescriptor& description) {
  bool allocated = false;
  prims::guarded(param_->sink(), GetId().str(), [&] { allocated = state_->allocate(description, param_->sink()); });
  return allocated;
}

void RenderBufferPrim::Resolve() {
  unresolved_ = !prims::guarded(param_->sink(), GetId().str(), [&] { state_->resolve(); });
}

// Pixels of an earlier Resolve would pass for those of the one that failed.
const void* RenderBufferPrim::Map() {
  const void* pixels = nullptr;
  if (unresolved_) Resolve();
  if (unresolved_) return nullptr;
  prims::guarded(param_->sink(), GetId().str(), [&] { pixels = state_->map(); });
  return pixels;
}

bool RenderBufferPrim::ResolveTo(PixelMemory* memory) {
  bool shown = false;
  prims::guarded(param_->sink(), GetId().str(), [&] {
    state_->resolve();
    const std::shared_ptr<const BufferStore> picture = state_->picture();
    const Vec3i dimensions = picture ? picture->description().dimensions : Vec3i(0);
    const Vec2i size(dimensions.x, dimensions.y);
    if (!picture || size != memory->size) {
      memory->size = size, memory->shown = 0;
      return;
    }
    if (const std::string fault = memory_fault(*memory, size); !fault.empty()) {
      alabaster::report(param_->sink(), alabaster::Severity::error, "buffer.memory", GetId().str(),
                        fault + "; nothing is written");
      return;
    }
    show(*picture, memory);
    shown = true;
  });
  return shown;
}

}  // namespace alabaster::hd::rendering
