#include "delegate/prims/scene_param.h"

#include <tbb/global_control.h>

#include <algorithm>

#include "delegate/support/process_usage.h"

namespace alabaster::hd::prims {

SceneParam::SceneParam(alabaster::DiagnosticSink sink, std::shared_ptr<TraceDevice> device,
                       std::shared_ptr<const ColorConfig> colors, std::shared_ptr<MemoryBudget> memory)
    : sink_(std::move(sink)),
      device_(std::move(device)),
      colors_(std::move(colors)),
      memory_(std::move(memory)),
      texels_(std::make_shared<TexelStore>(sink_, memory_)) {}

SceneParam::~SceneParam() = default;

// Under mutex_. The texture of that source; with `any`, one of the same image.
std::shared_ptr<const Texture> SceneParam::held_texture(const TextureSource& source, bool any) const {
  const auto [first, last] = textures_.equal_range(source.path);
  for (auto it = first; it != last; ++it)
    if (any ? it->second.source.is_same_image(source) : it->second.source == source)
      if (auto texture = it->second.texture.lock()) return texture;
  return nullptr;
}

// One at a time decodes an image, which others may wait for. It takes up no other task meanwhile: that might wait for
// this very image.
std::shared_ptr<const Texture> SceneParam::texture(const TextureSource& source, std::optional<std::string>* fault,
                                                   const alabaster::DiagnosticSink& sink, const CancelToken& cancel) {
  std::shared_ptr<std::mutex> decoding;
  {
    const std::lock_guard lock(mutex_);
    if (auto texture = held_texture(source, false)) return texture;
    std::weak_ptr<std::mutex>& known = decoding_[source.path];
    if (!(decoding = known.lock())) known = decoding = std::make_shared<std::mutex>();
  }
  const std::lock_guard turn(*decoding);
  uint64_t reloads = 0;
  std::shared_ptr<const Texture> same;
  {
    const std::lock_guard lock(mutex_);
    if (auto texture = held_texture(source, false)) return texture;
    same = held_texture(source, true);
    reloads = reloads_;
  }
  std::shared_ptr<const Texture> loaded = same ? same->placed(source) : nullptr;
  if (!loaded) loaded = load(source, fault, sink, cancel);
  if (!loaded) return nullptr;
  const std::lock_guard lock(mutex_);
  if (reloads != reloads_) return loaded;  // it may be the file before its edit, which nobody else should get
  std::erase_if(textures_, [](const auto& entry) { return entry.second.texture.expired(); });
  std::erase_if(decoding_, [](const auto& entry) { return entry.second.expired(); });
  textures_.emplace(source.path, HeldTexture{source, loaded});
  return loaded;
}

std::shared_ptr<const Texture> SceneParam::load(const TextureSource& source, std::optional<std::string>* fault,
                                                const alabaster::DiagnosticSink& sink, const CancelToken& cancel) {
  std::string refusal;
  const alabaster::DiagnosticSink watched = [&](const alabaster::Diagnostic& d) {
    if (d.code == "texture.memory") {
      refusal = d.text;
      return;
    }
    if (sink) sink(d);
  };
  std::shared_ptr<const Texture> loaded;
  const TextureLoading loading = {.store = texels_, .cancel = cancel};
  run([&] { tbb::this_task_arena::isolate([&] { loaded = load_texture(source, *colors_, watched, loading); }); });
  if (loaded) return loaded;
  if (!refusal.empty()) throw MemoryRefused(refusal, 0, source.path);
  *fault = "the image '" + source.path + "' could not be read";
  return nullptr;
}

std::shared_ptr<const IesProfile> SceneParam::profile(const TextureSource& source, std::optional<std::string>* fault,
                                                      const alabaster::DiagnosticSink& sink) {
  std::shared_ptr<const IesProfile> profile;
  if (!source.fault.empty()) {
    alabaster::report(sink, alabaster::Severity::error, "ies.unreadable", source.path, source.fault);
  } else if (source.bytes) {
    const std::string_view text(reinterpret_cast<const char*>(source.bytes->data()), source.bytes->size());
    profile = IesProfile::parse(text, source.path, sink);
  } else {
    std::error_code none;
    const FileState state{std::filesystem::last_write_time(source.path, none),
                          std::filesystem::file_size(source.path, none)};
    const std::lock_guard turn(profiles_mutex_);
    HeldProfile& held = profiles_[{source.path, source.within}];
    profile = held.profile.lock();
    if (!profile || held.state != state) profile = IesProfile::load(source.path, sink, source.within);
    held = {state, profile};
  }
  if (!profile) *fault = "the IES profile '" + source.path + "' could not be read";
  return profile;
}

TextureSource source_of(const Value& file) {
  TextureSource source;
  source.path = file.text_or("");
  if (const auto* asset = file.get<AssetPath>())
    source.bytes = asset->bytes, source.within = asset->within, source.fault = asset->fault;
  return source;
}

bool names_image(const std::string& name, const std::string& file) {
  if (file.empty() || name == file) return true;
  const std::string mark = "<UDIM>";
  const size_t at = name.find(mark);
  if (at == std::string::npos || file.size() != name.size() - mark.size() + 4) return false;
  return file.compare(0, at, name, 0, at) == 0 && file.compare(at + 4, file.npos, name, at + mark.size()) == 0 &&
         std::all_of(&file[at], &file[at] + 4, [](char c) { return c >= '0' && c <= '9'; });
}

void SceneParam::set_reread(const Path& id, Reread reread) {
  const std::lock_guard lock(mutex_);
  rereads_[id] = std::move(reread);
}

// Materials and lights that hold the old image keep it until they have the new one.
void SceneParam::reload(const std::string& file) {
  std::map<Path, Reread> rereads;
  {
    const std::lock_guard lock(mutex_);
    ++reloads_;
    std::erase_if(textures_, [&](const auto& entry) { return names_image(entry.first, file); });
    rereads = rereads_;
  }
  for (const auto& [id, reread] : rereads) guarded(sink_, id.str(), [&, &again = reread] { again(file); });
}

void SceneParam::set_texture_memory(uint32_t mib) {
  texels_->set_budget(size_t(mib) << 20);
}

void SceneParam::set_memory_limit(uint32_t mib) {
  memory_->set_limit(mib ? size_t(mib) << 20 : support::default_memory_limit());
}

std::shared_ptr<tbb::task_arena> SceneParam::arena() {
  const std::lock_guard lock(mutex_);
  const uint32_t threads = threads_;
  if (!arena_ || arena_threads_ != threads) {
    // More threads than the process may have would make TBB print a warning.
    const auto allowed = tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism);
    constexpr int kAll = tbb::task_arena::automatic;
    arena_ = std::make_shared<tbb::task_arena>(threads ? static_cast<int>(std::min<size_t>(threads, allowed)) : kAll);
    arena_threads_ = threads;
  }
  return arena_;
}

void SceneParam::post(Edit edit) {
  Shard& shard = shards_[(edit.id.hash() >> 5) % shards_.size()];
  const std::lock_guard lock(shard.mutex);
  shard.edits.push_back(std::move(edit));
  ++edits_;
}

void SceneParam::remove(const Path& id) noexcept {
  guarded(sink_, id.str(), [&] {
    {
      const std::lock_guard lock(mutex_);
      rereads_.erase(id);
    }
    post(id, {});
  });
}

std::list<Edit> SceneParam::take_edits() noexcept {
  std::list<Edit> all;
  for (Shard& shard : shards_) {
    const std::lock_guard lock(shard.mutex);
    edits_ -= shard.edits.size();
    all.splice(all.end(), shard.edits);
  }
  return all;
}

void SceneParam::keep(std::shared_ptr<const void> mapped) {
  const std::lock_guard lock(mutex_);
  kept_.push_back(std::move(mapped));
}

}  // namespace alabaster::hd::prims
