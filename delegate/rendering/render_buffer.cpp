#include "delegate/rendering/render_buffer.h"

#include <algorithm>
#include <cstring>

#include "delegate/rendering/pixel_format.h"

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

size_t pixel_offset(const RenderBufferDescriptor& d, int x, int y_down) {
  const auto row = static_cast<size_t>(d.dimensions.y - 1 - y_down);  // rows of a buffer run bottom-up
  return (row * static_cast<size_t>(d.dimensions.x) + static_cast<size_t>(x)) * FormatSize(d.format);
}

/// Converts a row of the film's pixels, which begins at (x, y), as far as it lies in the buffer.
template <class T>
void store_row(const RenderBufferDescriptor& d, const BufferSource& source, int x, int y, std::span<const T> values,
               uint8_t* pixels) {
  const auto components = static_cast<size_t>(aov_info(source.aov).components());
  const int row = y + source.buffer_y, column = x + source.buffer_x;
  const int first = std::max(column, 0);
  const int last = std::min(column + static_cast<int>(values.size() / components), d.dimensions.x);
  if (row < 0 || row >= d.dimensions.y || first >= last) return;
  const auto inside =
      values.subspan(static_cast<size_t>(first - column) * components, static_cast<size_t>(last - first) * components);
  uint8_t* out = pixels + pixel_offset(d, first, row);
  if constexpr (std::is_same_v<T, int32_t>)
    write_pixels(inside, d.format, out);
  else
    write_pixels(inside, components, d.format, out);
}

bool covers_buffer(const RenderBufferDescriptor& d, const BufferSource& source) {
  if (!source.film) return false;
  const PixelRect& window = source.film->data_window();
  return window.x0 + source.buffer_x <= 0 && window.y0 + source.buffer_y <= 0 &&
         window.x1 + source.buffer_x >= d.dimensions.x && window.y1 + source.buffer_y >= d.dimensions.y;
}

void clear_pixels(const Value& clear, Format format, std::vector<uint8_t>* pixels) {
  const size_t size = FormatSize(format);
  write_clear(clear, format, pixels->data());
  for (size_t at = size; at < pixels->size(); at += size) std::memcpy(pixels->data() + at, pixels->data(), size);
}

}  // namespace

bool BufferState::allocate(const RenderBufferDescriptor& description, const Path& where,
                           const alabaster::DiagnosticSink& sink) {
  if (const char* fault = allocation_fault(description)) {
    alabaster::report(sink, alabaster::Severity::error, "buffer.allocate", where.str(),
                      std::string(fault) + "; the buffer stays as it was");
    return false;
  }
  const std::lock_guard lock(mutex_);
  if (wanted_ == description) return true;
  wanted_ = description;
  ++allocation_;
  if (!source_.film) {  // nothing was ever drawn into it: nothing is lost by resizing now
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

uint64_t BufferState::allocation() const {
  const std::lock_guard lock(mutex_);
  return allocation_;
}

RenderBufferDescriptor BufferState::wanted() const {
  const std::lock_guard lock(mutex_);
  return wanted_;
}

const std::shared_ptr<const BufferState::Store>& BufferState::current() const {
  return mapped_.empty() ? store_ : mapped_.back();
}

RenderBufferDescriptor BufferState::shown() const {
  const std::lock_guard lock(mutex_);
  return current() ? current()->description : effective_;
}

std::shared_ptr<const BufferState::Store> BufferState::make_store(const RenderBufferDescriptor& description,
                                                                  const BufferSource& source) {
  auto store = std::make_shared<Store>();
  store->description = description;
  const size_t size = FormatSize(description.format);
  store->pixels.resize(static_cast<size_t>(description.dimensions.x) * static_cast<size_t>(description.dimensions.y) *
                       size);
  if (store->pixels.empty()) return store;
  if (!covers_buffer(description, source)) clear_pixels(source.clear, description.format, &store->pixels);
  if (!source.film) return store;
  const auto take = [&](int x, int y, const auto& values) {
    store_row(description, source, x, y, values, store->pixels.data());
  };
  if (aov_info(source.aov).is_integer())
    source.film->resolve_int(source.aov, take);
  else
    source.film->resolve_float(source.aov, take);
  return store;
}

// Converts outside the lock. Two Resolves may run at once: the one that saw the later film wins.
void BufferState::resolve() {
  BufferSource source;
  RenderBufferDescriptor description;
  uint64_t binding = 0;
  {
    const std::lock_guard lock(mutex_);
    if (!source_.film) return;
    source = source_;
    description = effective_;
    binding = binding_;
  }
  if (source.complete) source.complete();
  const uint64_t revision = source.film->revision();
  {
    const std::lock_guard lock(mutex_);
    if (store_ && binding == store_binding_ && revision == store_revision_) return;
    // A render that has nothing to show yet does not wipe what is shown.
    if (store_ && revision == 0) return;
  }
  auto store = make_store(description, source);
  const std::lock_guard lock(mutex_);
  if (binding < store_binding_ || (binding == store_binding_ && store_ && revision < store_revision_)) return;
  store_binding_ = binding;
  store_revision_ = revision;
  const bool same = store_ && store_->description == store->description && store_->pixels == store->pixels;
  if (same) return;
  store_ = std::move(store);
  ++generation_;
}

const void* BufferState::map() {
  BufferSource source;
  RenderBufferDescriptor description;
  bool missing = false;
  {
    const std::lock_guard lock(mutex_);
    missing = !store_;
    description = effective_;
    source.clear = source_.clear;
  }
  if (missing && FormatComponents(description.format) == 0) return nullptr;
  std::shared_ptr<const Store> blank = missing ? make_store(description, source) : nullptr;
  const std::lock_guard lock(mutex_);
  if (!store_ && effective_ == description) store_ = blank;
  if (!store_) return nullptr;
  if (mapped_.empty() || mapped_.back() != store_) mapped_.push_back(store_);
  ++map_count_;
  return store_->pixels.data();
}

void BufferState::unmap() {
  std::vector<std::shared_ptr<const Store>> released;  // freed outside the lock
  const std::lock_guard lock(mutex_);
  if (map_count_ > 0 && --map_count_ == 0) released.swap(mapped_);
}

bool BufferState::is_mapped() const {
  const std::lock_guard lock(mutex_);
  return map_count_ > 0;
}

uint64_t BufferState::generation() const {
  const std::lock_guard lock(mutex_);
  return generation_;
}

Vec2i BufferState::copy(std::vector<uint8_t>* out, bool y_down) const {
  std::shared_ptr<const Store> store;
  {
    const std::lock_guard lock(mutex_);
    store = store_;
  }
  out->clear();
  if (!store) return {0, 0};
  const Vec3i size = store->description.dimensions;
  if (!y_down || store->pixels.empty()) {
    *out = store->pixels;
  } else {
    const size_t row = store->pixels.size() / static_cast<size_t>(size.y);
    out->reserve(store->pixels.size());
    for (size_t at = store->pixels.size(); at > 0; at -= row)
      out->insert(out->end(), store->pixels.data() + (at - row), store->pixels.data() + at);
  }
  return {size.x, size.y};
}

std::vector<std::shared_ptr<const void>> BufferState::mapped_stores() const {
  const std::lock_guard lock(mutex_);
  return {mapped_.begin(), mapped_.end()};
}

RenderBufferPrim::RenderBufferPrim(const Path& id, std::shared_ptr<prims::SceneParam> param)
    : RenderBuffer(id), param_(std::move(param)) {}

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
  prims::guarded(param_->sink(), GetId().str(),
                 [&] { allocated = state_->allocate(description, GetId(), param_->sink()); });
  return allocated;
}

void RenderBufferPrim::Resolve() {
  prims::guarded(param_->sink(), GetId().str(), [&] { state_->resolve(); });
}

const void* RenderBufferPrim::Map() {
  const void* pixels = nullptr;
  prims::guarded(param_->sink(), GetId().str(), [&] { pixels = state_->map(); });
  return pixels;
}

Vec2i RenderBufferPrim::ResolveTo(std::vector<uint8_t>* out, bool y_down) {
  Vec2i size(0, 0);
  prims::guarded(param_->sink(), GetId().str(), [&] {
    state_->resolve();
    size = state_->copy(out, y_down);
  });
  return size;
}

}  // namespace alabaster::hd::rendering
