// A scene whose files may change on disk while it is shown: it is loaded again in a thread of its own.
#pragma once

#include <chrono>
#include <filesystem>
#include <functional>
#include <future>

#include "delegate/cli/scene_session.h"

namespace alabaster::view {

class SceneReload {
 public:
  /// Loads and starts the scene; any thread. Reports faults and throws, as commands do.
  using Load = std::function<std::unique_ptr<cli::SceneSession>()>;
  using Time = std::filesystem::file_time_type;
  /// `begun`: when the load of what is shown began.
  SceneReload(Load load, std::string scene_file, const cli::SceneSession& shown, Time begun, hd::DiagnosticSink sink);

  /// Looks at some of the files; for each picture of the window.
  void look();
  /// A file that the scene was read from is another one now.
  bool has_changed() const { return changed_; }
  /// Begins to load, unless that goes on.
  void begin();
  bool is_busy() const { return loading_.valid(); }
  /// What was loaded, once. Null: nothing is ready, or the files could not be loaded, which was reported.
  std::unique_ptr<cli::SceneSession> take();

  bool by_itself = false;  // begins when a file has changed and rests

 private:
  struct State {
    Time time;
    uintmax_t size = 0;
    bool operator==(const State&) const = default;
  };
  struct File {
    std::string name;
    std::optional<State> seen;  // the last state that was looked at, at first that which was read; empty: any is news
  };
  static std::optional<State> state_of(const std::string& file);  // empty: there is none
  void watch(const cli::SceneSession& shown);

  const Load load_;
  const std::string scene_file_;
  const hd::DiagnosticSink sink_;
  std::vector<File> files_;
  size_t next_ = 0;  // to look at
  Time begun_;       // of the last load
  bool changed_ = false;
  std::chrono::steady_clock::time_point changed_at_;  // when the last change was seen
  std::future<std::unique_ptr<cli::SceneSession>> loading_;
};

}  // namespace alabaster::view
