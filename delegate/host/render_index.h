// The index of a host: creates prims through a RenderDelegate, tracks the dirty ones, syncs in the contract's order.
#pragma once

#include "delegate/api/render_delegate.h"
#include "delegate/host/change_tracker.h"

namespace alabaster::hd::host {

class ALABASTER_API RenderIndex {
 public:
  explicit RenderIndex(RenderDelegate* delegate);  // throws std::bad_alloc
  ~RenderIndex();                                  // finalizes and destroys every prim
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
