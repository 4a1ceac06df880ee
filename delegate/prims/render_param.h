// The one channel from prims to the renderer: services that Sync needs, and the edit transaction that it fills.
#pragma once

#include <array>
#include <atomic>
#include <list>
#include <map>
#include <mutex>
#include <optional>
#include <set>

#include <tbb/task_arena.h>

#include "core/color/color_config.h"
#include "core/texture/texel_store.h"
#include "delegate/api/prims.h"
#include "delegate/prims/diagnostics.h"
#include "delegate/prims/records.h"
#include "delegate/prims/sync_clock.h"

namespace alabaster::hd::prims {

struct Edit {
  Path id;
  Record record;  // monostate: the prim is gone
};

/// Something that a prim could not read, build or light as it was asked to. It has been reported as an error, and the
/// frame is drawn without it.
struct SceneFault {
  bool input = true;  // false: memory or threads ran out
  std::string text;
};
using SceneFaults = std::map<Path, SceneFault>;

class SceneParam final : public RenderParam {
 public:
  SceneParam(alabaster::DiagnosticSink sink, std::shared_ptr<TraceDevice> device,
             std::shared_ptr<const ColorConfig> colors);
  ~SceneParam() override;
  static SceneParam& of(RenderParam* param) { return *static_cast<SceneParam*>(param); }

  // Services, from any thread.
  const alabaster::DiagnosticSink& sink() const { return sink_; }
  const std::shared_ptr<TraceDevice>& device() const { return device_; }
  const ColorConfig& colors() const { return *colors_; }
  /// Shared by all materials and lights that name the same image; null (reported, and in *fault) if it cannot be had.
  std::shared_ptr<const Texture> texture(const TextureSource& source, std::optional<SceneFault>* fault);
  /// Runs heavy work in the delegate's own arena: never in the host's, never on more than `threads` threads.
  template <class F>
  void run(F&& work) {
    arena()->execute(work);
  }
  void set_threads(uint32_t threads) { threads_ = threads; }
  /// MiB, for images that are read from then on. A value of the host counts before that of a settings prim.
  void set_texture_memory(uint32_t mib, bool by_host);

  // The edit transaction.
  void post(const Path& id, Record record);
  /// Posts that the prim is gone. Never throws: no call of the prim follows Finalize.
  void remove(const Path& id) noexcept;
  bool has_edits() const { return edits_.load() != 0; }
  /// All edits since the last call; those of one prim in the order in which it posted them. Takes no memory.
  std::list<Edit> take_edits() noexcept;

  /// The fault that a prim's last Sync found; none: it went well. Those of meshes are found when they are built.
  void set_fault(const Path& id, std::optional<SceneFault> fault);
  SceneFaults faults() const;
  /// Counts the prims whose last Sync threw. `held` is the prim's own note of it. Takes no memory.
  void set_failed(bool* held, bool failed) noexcept {
    if (*held != failed) failed_ += failed ? 1 : -1;
    *held = failed;
  }
  int failed() const { return failed_; }

  /// Keeps pixels that a host may still have mapped when their buffer was destroyed until the delegate dies.
  void keep(std::shared_ptr<const void> mapped);

  SyncClock clock;

 private:
  struct Shard {
    std::mutex mutex;
    std::list<Edit> edits;
  };
  struct HeldTexture {
    TextureSource source;
    std::weak_ptr<const Texture> texture;
  };
  std::shared_ptr<tbb::task_arena> arena();

  alabaster::DiagnosticSink sink_;
  std::shared_ptr<TraceDevice> device_;
  std::shared_ptr<const ColorConfig> colors_;
  std::shared_ptr<TexelStore> texels_;
  std::atomic<bool> host_set_texels_{false};
  std::atomic<uint32_t> threads_{0};
  std::atomic<size_t> edits_{0};
  std::atomic<int> failed_{0};
  std::array<Shard, 16> shards_;
  SceneFaults faults_;
  mutable std::mutex mutex_;  // guards faults_ and what follows, for look-ups only
  std::multimap<std::string, HeldTexture> textures_;
  std::shared_ptr<tbb::task_arena> arena_;
  uint32_t arena_threads_ = 0;
  std::vector<std::shared_ptr<const void>> kept_;
};

}  // namespace alabaster::hd::prims
