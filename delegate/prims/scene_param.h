// SceneParam, the RenderParam of this delegate: services that Sync needs, and the edit transaction that it fills.
#pragma once

#include <array>
#include <atomic>
#include <filesystem>
#include <functional>
#include <list>
#include <map>
#include <mutex>
#include <optional>

#include <tbb/task_arena.h>

#include "core/color/color_config.h"
#include "core/light/ies_profile.h"
#include "core/texture/texel_store.h"
#include "delegate/api/prims.h"
#include "delegate/prims/build_clock.h"
#include "delegate/prims/diagnostics.h"
#include "delegate/prims/records.h"

namespace alabaster::hd::prims {

/// Makes a record of files. Throws BuildCancelled while it decodes an image.
using ReadRecord = std::function<Record(const CancelToken&)>;

struct Edit {
  Path id;
  Record record;               // nothing: the prim is gone
  ReadRecord read;             // unless empty: makes the record; the builder's to call
  bool waits_for_use = false;  // a material: `read` is called once a visible mesh has it
};

/// True if `file` is the image of that name, or one of a set (`name` with "<UDIM>"), or empty.
bool names_image(const std::string& name, const std::string& file);

/// The image or profile that a parameter names.
TextureSource source_of(const Value& file);

class SceneParam final : public RenderParam {
 public:
  /// `memory` counts what `device` takes, too.
  SceneParam(alabaster::DiagnosticSink sink, std::shared_ptr<TraceDevice> device,
             std::shared_ptr<const ColorConfig> colors, std::shared_ptr<MemoryBudget> memory);
  ~SceneParam() override;
  static SceneParam& of(RenderParam* param) { return *static_cast<SceneParam*>(param); }

  // Services, from any thread.
  const alabaster::DiagnosticSink& sink() const { return sink_; }
  const std::shared_ptr<TraceDevice>& device() const { return device_; }
  const ColorConfig& colors() const { return *colors_; }
  /// Converts colours that are in linear Rec. 709 (support::kColorSpace); null: they are in the rendering space.
  std::shared_ptr<const RgbMatrix> rec709_to_rendering() {
    std::call_once(rec709_made_, [this] { rec709_ = alabaster::rec709_to_rendering(*colors_, sink_); });
    return rec709_;
  }
  const std::shared_ptr<MemoryBudget>& memory() const { return memory_; }
  /// Counts the arrays of meshes.
  BufferReservations& buffers() { return buffers_; }
  /// Shared by all materials and lights that name the same image, whatever their wrap modes and filters; null
  /// (reported, and in *fault) if it cannot be had. Within run() only. Throws BuildCancelled while it decodes, and
  /// MemoryRefused.
  std::shared_ptr<const Texture> texture(const TextureSource& source, std::optional<std::string>* fault,
                                         const alabaster::DiagnosticSink& sink, const CancelToken& cancel);
  /// The same for an IES profile, which lights share. Path, bytes and `within` of the source count.
  std::shared_ptr<const IesProfile> profile(const TextureSource& source, std::optional<std::string>* fault,
                                            const alabaster::DiagnosticSink& sink);
  /// Texels that were in the file of `textureMemory` are gone (reported): they are black.
  bool has_lost_texels() const { return texels_->failed(); }
  /// Reads an image again for a prim, and posts the new record if the prim uses that file; kept until the prim is gone.
  using Reread = std::function<void(const std::string& file)>;
  void set_reread(const Path& id, Reread reread);
  /// An image has been edited on disk; an empty name: any may have. Prims that use it read it again. Not during Sync.
  void reload(const std::string& file);
  /// Runs heavy work in the delegate's own arena: never in the host's, never on more than `threads` threads.
  template <class F>
  void run(F&& work) {
    arena()->execute(work);
  }
  void set_threads(uint32_t threads) { threads_ = threads; }
  /// MiB, for images that are read from then on.
  void set_texture_memory(uint32_t mib);
  /// MiB; 0: default_memory_limit(). The next commit builds the meshes that were refused.
  void set_memory_limit(uint32_t mib);

  /// Faults of files that the builder reads; it reports them once all are read.
  FileFaults& file_faults() { return file_faults_; }

  // The edit transaction.
  void post(const Path& id, Record record) { post(Edit{id, std::move(record), {}, false}); }
  /// Posts a function that makes the record on the builder's thread, because that reads files. A later edit of the prim
  /// may come before the call. `read` is called once, or again after an exception.
  void post_unread(const Path& id, ReadRecord read, bool waits_for_use = false) {
    post(Edit{id, {}, std::move(read), waits_for_use});
  }
  /// Posts that the prim is gone. Never throws: no call of the prim follows Finalize.
  void remove(const Path& id) noexcept;
  bool has_edits() const { return edits_.load() != 0; }
  /// All edits since the last call; those of one prim in the order in which it posted them. Takes no memory.
  std::list<Edit> take_edits() noexcept;

  /// Counts the prims whose last Sync threw. `held` is the prim's own note of it. Takes no memory.
  void set_failed(bool* held, bool failed) noexcept {
    if (*held != failed) failed_ += failed ? 1 : -1;
    *held = failed;
  }
  int failed() const { return failed_; }

  /// Keeps pixels that a host may still have mapped when their buffer was destroyed until the delegate dies.
  void keep(std::shared_ptr<const void> mapped);

  BuildClock build_clock;

 private:
  struct Shard {
    std::mutex mutex;
    std::list<Edit> edits;
  };
  struct HeldTexture {
    TextureSource source;
    std::weak_ptr<const Texture> texture;
  };
  /// They change when it is written.
  using FileState = std::pair<std::filesystem::file_time_type, uintmax_t>;
  struct HeldProfile {
    FileState state;
    std::weak_ptr<const IesProfile> profile;
  };
  std::shared_ptr<const Texture> held_texture(const TextureSource& source, bool any) const;
  std::shared_ptr<const Texture> load(const TextureSource& source, std::optional<std::string>* fault,
                                      const alabaster::DiagnosticSink& sink, const CancelToken& cancel);
  std::shared_ptr<tbb::task_arena> arena();
  void post(Edit edit);

  alabaster::DiagnosticSink sink_;
  std::shared_ptr<TraceDevice> device_;
  std::shared_ptr<const ColorConfig> colors_;
  std::once_flag rec709_made_;
  std::shared_ptr<const RgbMatrix> rec709_;
  std::shared_ptr<MemoryBudget> memory_;
  BufferReservations buffers_{memory_, MemoryUse::scene};
  std::shared_ptr<TexelStore> texels_;
  std::atomic<uint32_t> threads_{0};
  std::atomic<size_t> edits_{0};
  std::atomic<int> failed_{0};
  std::array<Shard, 16> shards_;
  std::mutex profiles_mutex_;                                            // held while one is read
  std::map<std::pair<std::string, std::string>, HeldProfile> profiles_;  // by name and folder
  FileFaults file_faults_;
  mutable std::mutex mutex_;  // guards what follows, for look-ups only
  std::multimap<std::string, HeldTexture> textures_;
  std::map<std::string, std::weak_ptr<std::mutex>> decoding_;  // by path
  std::map<Path, Reread> rereads_;
  uint64_t reloads_ = 0;
  std::shared_ptr<tbb::task_arena> arena_;
  uint32_t arena_threads_ = 0;
  std::vector<std::shared_ptr<const void>> kept_;
};

}  // namespace alabaster::hd::prims
