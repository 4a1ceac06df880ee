#include "delegate/prims/render_param.h"

namespace alabaster::hd::prims {

SceneParam::SceneParam(alabaster::DiagnosticSink sink, std::shared_ptr<TraceDevice> device,
                       std::shared_ptr<const ColorConfig> colors)
    : sink_(std::move(sink)),
      device_(std::move(device)),
      colors_(std::move(colors)),
      texels_(std::make_shared<TexelStore>(sink_)) {}

SceneParam::~SceneParam() = default;

// Two materials that ask for one image at the same moment both decode it, and one copy is kept: waiting for each other
// could make a thread wait for work that it has itself put aside.
std::shared_ptr<const Texture> SceneParam::texture(const TextureSource& source, std::optional<SceneFault>* fault) {
  const auto held = [&]() -> std::shared_ptr<const Texture> {
    const auto [first, last] = textures_.equal_range(source.path);
    for (auto it = first; it != last; ++it)
      if (it->second.source == source)
        if (auto texture = it->second.texture.lock()) return texture;
    return nullptr;
  };
  {
    const std::lock_guard lock(mutex_);
    if (auto texture = held()) return texture;
  }
  std::shared_ptr<const Texture> loaded;
  bool input = true;
  const alabaster::DiagnosticSink sink = [&](const alabaster::Diagnostic& d) {
    input = d.code != "texture.memory";
    if (sink_) sink_(d);
  };
  run([&] { loaded = load_texture(source, *colors_, sink, texels_); });
  if (!loaded) {
    *fault = SceneFault{input, "the image '" + source.path + "' could not be read"};
    return nullptr;
  }
  const std::lock_guard lock(mutex_);
  if (auto texture = held()) return texture;
  std::erase_if(textures_, [](const auto& entry) { return entry.second.texture.expired(); });
  textures_.emplace(source.path, HeldTexture{source, loaded});
  return loaded;
}

void SceneParam::set_texture_memory(uint32_t mib, bool by_host) {
  if (by_host) host_set_texels_ = true;
  if (by_host || !host_set_texels_) texels_->set_budget(size_t(mib) << 20);
}

std::shared_ptr<tbb::task_arena> SceneParam::arena() {
  const std::lock_guard lock(mutex_);
  const uint32_t threads = threads_;
  if (!arena_ || arena_threads_ != threads) {
    arena_ = std::make_shared<tbb::task_arena>(threads ? static_cast<int>(threads) : tbb::task_arena::automatic);
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
  guarded(sink_, id.str(), [&] { post(id, {}); });
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
