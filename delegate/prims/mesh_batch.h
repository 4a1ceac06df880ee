// Meshes that are built together.
#pragma once

#include <condition_variable>
#include <mutex>
#include <thread>

#include "delegate/prims/mesh_build.h"

namespace alabaster::hd::prims {

/// Builds in the delegate's arena. Embree and OpenSubdiv cannot be cancelled at each moment of a large mesh. Such a
/// batch is built on a thread of its own, so that a cancelled caller need not wait for its end.
class MeshBatch {
 public:
  MeshBatch(std::vector<std::shared_ptr<const MeshJob>> jobs, SceneParam* param);
  ~MeshBatch();  // waits until all have ended
  MeshBatch(const MeshBatch&) = delete;
  MeshBatch& operator=(const MeshBatch&) = delete;

  /// Called once. False: it was cancelled, and some have not ended yet.
  bool build(const CancelToken& cancel);
  /// The result of a job, once; null: it was cancelled, or it has not ended.
  std::optional<MeshResult> result(size_t job);
  /// No result is asked for any more: the thread frees them when it ends.
  void leave();
  bool has_ended() const { return ended_; }

 private:
  struct Item {
    std::shared_ptr<const MeshJob> job;
    MeshResult result;
    std::atomic<bool> ended{false};
  };
  bool is_large() const;
  void build_all(const CancelToken& cancel);
  void build_one(Item* item, const CancelToken& cancel);
  void run();
  bool await(const CancelToken& cancel);

  SceneParam* const param_;
  std::vector<Item> items_;
  std::atomic<bool> cancelled_{false}, ended_{false};

  std::mutex mutex_;
  std::condition_variable over_changed_;
  bool over_ = false, left_ = false;
  std::exception_ptr error_;
  std::thread thread_;
};

}  // namespace alabaster::hd::prims
