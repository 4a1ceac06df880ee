// The host-readable buffer as a state machine:
//
//   Allocate   -> `wanted`; at once while nothing is shown or drawn, else at the next Execute
//   Execute    -> binds a film: Resolve reads it from then on
//   Resolve    -> a store with what is newer replaces the current one. The old picture stays until a film of another
//                 size covers its window or its render ends
//   Map        -> the store that is current; it lives until the last Unmap, whatever happens meanwhile
#pragma once

#include <mutex>

#include "delegate/prims/scene_param.h"
#include "delegate/rendering/buffer_store.h"

namespace alabaster::hd::rendering {

/// Shared by the prim and by passes that draw into it, so that neither outlives what it needs.
class BufferState {
 public:
  explicit BufferState(Path id) : id_(id) {}
  const Path& id() const { return id_; }
  bool allocate(const RenderBufferDescriptor& description, const alabaster::DiagnosticSink& sink);
  /// Execute: the wanted description takes effect, and Resolve reads `source` from now on.
  void bind(BufferSource source);
  /// Lets go of the film, so that the session may use it again. The picture stays.
  void release_film();
  /// Rises with every allocation that is not a no-op.
  uint64_t allocation() const { return locked(allocation_); }
  RenderBufferDescriptor wanted() const { return locked(wanted_); }

  RenderBufferDescriptor shown() const;
  void resolve();
  const void* map();
  void unmap();
  bool is_mapped() const;
  void set_converged(bool converged) { converged_ = converged; }
  bool converged() const { return converged_; }
  uint64_t generation() const { return locked(generation_); }
  /// The store that is current; a blank one before the first Resolve, null before Allocate.
  std::shared_ptr<const BufferStore> picture();
  /// Stores that a host may still read.
  std::vector<std::shared_ptr<const void>> mapped_stores() const;

 private:
  const std::shared_ptr<BufferStore>& current() const;
  template <class T>
  T locked(const T& member) const {
    const std::lock_guard lock(mutex_);
    return member;
  }

  const Path id_;
  mutable std::mutex mutex_;          // held for pointers and numbers only, never while pixels are converted
  RenderBufferDescriptor wanted_;     // as last allocated
  RenderBufferDescriptor effective_;  // as of the last Execute
  uint64_t allocation_ = 0, generation_ = 0, binding_ = 0;
  BufferSource source_;
  std::shared_ptr<BufferStore> store_;  // never changed while it is here
  uint64_t store_binding_ = 0;          // whose film it shows
  std::shared_ptr<BufferStore> spare_;  // the one before
  std::vector<std::shared_ptr<BufferStore>> mapped_;
  int map_count_ = 0;
  std::atomic<bool> converged_{false};
};

class RenderBufferPrim final : public RenderBuffer {
 public:
  RenderBufferPrim(const Path& id, std::shared_ptr<prims::SceneParam> param);
  ~RenderBufferPrim() override;
  const std::shared_ptr<BufferState>& state() const { return state_; }

  DirtyBits GetInitialDirtyBitsMask() const override { return dirty::kDescription; }
  void Sync(SceneDelegate* scene, RenderParam* param, DirtyBits* bits) override;
  void Finalize(RenderParam* param) override;
  bool Allocate(const RenderBufferDescriptor& description) override;
  int GetWidth() const override { return state_->shown().dimensions.x; }
  int GetHeight() const override { return state_->shown().dimensions.y; }
  Format GetFormat() const override { return state_->shown().format; }
  void Resolve() override;
  const void* Map() override;
  void Unmap() override { state_->unmap(); }
  bool IsMapped() const override { return state_->is_mapped(); }
  bool IsConverged() const override { return state_->converged(); }
  uint64_t GetGeneration() const override { return state_->generation(); }
  bool ResolveTo(PixelMemory* memory) override;

 private:
  std::shared_ptr<prims::SceneParam> param_;
  std::shared_ptr<BufferState> state_;
  std::atomic<bool> unresolved_{false};  // memory ran out in the last Resolve
};

}  // namespace alabaster::hd::rendering
