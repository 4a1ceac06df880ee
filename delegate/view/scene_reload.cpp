#include "delegate/view/scene_reload.h"

#include <algorithm>

#include "delegate/cli/exit_codes.h"

namespace alabaster::view {
namespace {

constexpr size_t kLooks = 16;  // files for a picture of the window: a scene may have thousands
constexpr auto kWritten = std::chrono::milliseconds(500);  // without a change, until a file counts as written

}  // namespace

SceneReload::SceneReload(Load load, std::string scene_file, const cli::SceneSession& shown, Time begun,
                         hd::DiagnosticSink sink)
    : load_(std::move(load)), scene_file_(std::move(scene_file)), sink_(std::move(sink)), begun_(begun) {
  watch(shown);
}

std::optional<SceneReload::State> SceneReload::state_of(const std::string& file) {
  std::error_code error;
  const auto time = std::filesystem::last_write_time(file, error);
  if (error) return std::nullopt;
  const uintmax_t size = std::filesystem::file_size(file, error);
  return State{time, error ? 0 : size};
}

// Files that were read before have the state of the moment before they were read again. Others may have been saved
// after they were read.
void SceneReload::watch(const cli::SceneSession& shown) {
  std::set<std::string> now = cli::scene_files(shown, scene_file_);
  now.insert(shown.colors().ocio);
  std::erase_if(files_, [&](const auto& file) { return now.erase(file.name) == 0; });
  for (const std::string& file : now) {
    std::optional<State> state = state_of(file);
    if (state && state->time > begun_) state.reset();
    files_.push_back({file, state});
  }
}

void SceneReload::look() {
  const auto now = std::chrono::steady_clock::now();
  for (size_t i = 0; i < std::min(kLooks, files_.size()) && !is_busy(); ++i) {
    File& file = files_[next_ = (next_ + 1) % files_.size()];
    const std::optional<State> state = state_of(file.name);
    // Programs remove a file before they write it again.
    if (!state || state == file.seen) continue;
    file.seen = state;
    changed_ = true, changed_at_ = now;
  }
  if (changed_ && by_itself && now - changed_at_ > kWritten) begin();
}

void SceneReload::begin() {
  if (is_busy()) return;
  changed_ = false;
  begun_ = Time::clock::now();
  for (File& file : files_) file.seen = state_of(file.name);
  loading_ = std::async(std::launch::async, [this]() -> std::unique_ptr<cli::SceneSession> {
    try {
      return load_();
    } catch (const cli::Exit&) {
    } catch (const std::exception& e) {
      sink_({hd::Severity::error, "view.reload", scene_file_, e.what()});
    }
    sink_({hd::Severity::warning, "view.reload", scene_file_,
           "It could not be loaded again: the scene that is shown stays."});
    return nullptr;
  });
}

std::unique_ptr<cli::SceneSession> SceneReload::take() {
  if (!is_busy() || loading_.wait_for(std::chrono::seconds(0)) != std::future_status::ready) return nullptr;
  std::unique_ptr<cli::SceneSession> loaded = loading_.get();
  if (loaded) watch(*loaded);
  return loaded;
}

}  // namespace alabaster::view
