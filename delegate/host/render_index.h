// The host kit's index: creates prims through a RenderDelegate, tracks what is dirty, syncs in the contract's order.
#pragma once

#include "delegate/api/render_delegate.h"

namespace alabaster::hd::host {

/// Dirty bits by prim. One thread at a time, never during Sync.
class ALABASTER_API ChangeTracker {
 public:
  void MarkDirty(const Path& id, DirtyBits bits);
  DirtyBits Get(const Path& id) const;
  void Set(const Path& id, DirtyBits bits);
  void Remove(const Path& id);
  /// The dirty prims alone, so that a Sync does not look at the others.
  const std::map<Path, DirtyBits>& GetDirty() const { return bits_; }
  /// Rises with every MarkDirty.
  uint64_t GetVersion() const { return version_; }

 private:
  std::map<Path, DirtyBits> bits_;  // none is clean
  uint64_t version_ = 0;
};

class ALABASTER_API RenderIndex {
 public:
  explicit RenderIndex(RenderDelegate* delegate);
  ~RenderIndex();  // finalizes and destroys every prim
  RenderIndex(const RenderIndex&) = delete;
  RenderIndex& operator=(const RenderIndex&) = delete;

  /// Returns false if the delegate does not know the type, the id is taken, or memory ran out.
  bool InsertRprim(const Token& type, SceneDelegate* scene, const Path& id);
  bool InsertSprim(const Token& type, SceneDelegate* scene, const Path& id);
  bool InsertBprim(const Token& type, SceneDelegate* scene, const Path& id);
  bool InsertInstancer(SceneDelegate* scene, const Path& id);
  void Remove(const Path& id);
  bool Has(const Path& id) const;
  Sprim* GetSprim(const Path& id) const;
  Bprim* GetBprim(const Path& id) const;
  /// Empty when no prim has this id.
  Path GetRprimPathFromPrimId(int32_t prim_id) const;

  ChangeTracker& GetChangeTracker();
  RenderDelegate* GetRenderDelegate() const;

  /// Syncs Bprims, Sprims (type by type), instancers and Rprims (in parallel), then calls CommitResources. Only the
  /// visibility of invisible rprims is synced; their other bits stay dirty. Returns false if memory or threads ran out:
  /// the prims that were not synced stay dirty for the next call.
  bool SyncAll();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace alabaster::hd::host
