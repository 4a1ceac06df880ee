// The C interface's handles and how its calls end. Internal to this room.
#pragma once

#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cstring>
#include <mutex>
#include <optional>
#include <set>
#include <span>
#include <stdexcept>

#include "core/math/float_environment.h"
#include "delegate/c_api/alabaster.h"
#include "delegate/description/render_description.h"
#include "delegate/host/frame_recorder.h"

namespace alabaster::hd::c_api {

/// Ends a call with a status and a text for last_error.
struct Failure : std::runtime_error {
  Failure(AlabasterStatus failed_with, const std::string& text) : std::runtime_error(text), status(failed_with) {}
  AlabasterStatus status;
};
inline Failure bad_argument(const std::string& text) {
  return {ALABASTER_INVALID_ARGUMENT, text};
}

/// Keeps the text for last_error of this thread; returns `status`.
AlabasterStatus fail(AlabasterStatus status, const char* text) noexcept;
const char* last_error() noexcept;

/// While it lives, this thread runs a callback that must not call the library: guarded() refuses what it calls.
class CallbackScope {
 public:
  CallbackScope() { ++depth; }
  ~CallbackScope() { --depth; }
  CallbackScope(const CallbackScope&) = delete;
  CallbackScope& operator=(const CallbackScope&) = delete;
  static bool is_open() { return depth > 0; }

 private:
  static thread_local int depth;
};

/// The process that made a handle. One that was forked from it has none of its threads, and locks may be held by them.
class Process {
 public:
  bool is_another() const { return getpid() != id_; }
  void check(const char* what) const {
    if (is_another())
      throw bad_argument(std::string(what) +
                         " belongs to the process that made it, and this one was forked from it: spawn, do not fork");
  }

 private:
  pid_t id_ = getpid();
};

/// A handle of a host. A callback that must not call the library may destroy it: the next call does so.
struct Handle {
  Handle() = default;
  Handle(const Handle&) = delete;
  Handle& operator=(const Handle&) = delete;
  virtual ~Handle() = default;
  Handle* next = nullptr;
  const Process process{};
};
/// A handle to data that other handles may share.
template <class Data>
struct HandleTo : Handle {
  explicit HandleTo(std::shared_ptr<Data> held) : data(std::move(held)) {}
  const std::shared_ptr<Data> data;
};
/// Frees nothing in a process that was forked from the handle's.
void destroy(Handle* handle) noexcept;
void destroy_put_off() noexcept;
template <class AnyHandle>
void destroy_handle(AnyHandle* handle) {
  destroy(handle);
}

/// Runs a call that may come at any time and waits for no other; no exception leaves it.
template <class Call>
AlabasterStatus guarded_at_any_time(const Call& call) noexcept {
  const FloatEnvironment environment;
  try {
    if (CallbackScope::is_open())
      throw bad_argument("the library is called by a report or release callback, which must not call it");
    call();
    return ALABASTER_OK;
  } catch (const Failure& failure) {
    return fail(failure.status, failure.what());
  } catch (const std::bad_alloc&) {
    return fail(ALABASTER_OUT_OF_MEMORY, "memory ran out");
  } catch (const std::exception& e) {
    return fail(ALABASTER_INTERNAL, e.what());
  } catch (...) {
    return fail(ALABASTER_INTERNAL, "unknown reason");
  }
}

/// Runs any other call. Handles that callbacks have destroyed go before it, which may wait for other calls.
template <class Call>
AlabasterStatus guarded(const Call& call) noexcept {
  return guarded_at_any_time([&] {
    destroy_put_off();
    call();
  });
}

template <class T>
T& required(T* pointer, const char* name) {
  if (!pointer) throw bad_argument(std::string(name) + " is null");
  return *pointer;
}

/// Runs `call` with the data of a handle, which lives until it returns. `name` is that of messages.
template <class AnyHandle, class Call>
AlabasterStatus with_data(AnyHandle* handle, const char* name, const Call& call) {
  return guarded([&] {
    const auto data = required(handle, name).data;
    call(*data);
  });
}

inline std::string text_or(const char* text, const char* fallback) {
  return text ? text : fallback;
}

/// The size of a struct in the first version of the header: no host has a shorter one.
template <class T>
inline constexpr size_t kFirstSize = sizeof(T);
/// Some version of the header may have it. Members that follow the first version are whole words.
template <class T>
bool is_size_of(size_t size) {
  return size >= kFirstSize<T> && size % alignof(T) == 0;
}

/// A struct that the host may know shorter or longer: members that it does not have are zero. If the size is wrong,
/// it has those of the first version.
template <class T>
T members_of(const T& in) {
  T out{};
  std::memcpy(static_cast<void*>(&out), &in, is_size_of<T>(in.size) ? std::min(in.size, sizeof out) : kFirstSize<T>);
  return out;
}
template <class T>
T sized(const T* in, const char* name) {
  const size_t size = required(in, name).size;
  if (size == 0) throw bad_argument(std::string(name) + ": `size` is not set");
  if (!is_size_of<T>(size))
    throw bad_argument(std::string(name) + ": `size` is " + std::to_string(size) +
                       ", which is not the size of this struct in any version: set it to sizeof the struct");
  return members_of(*in);
}

/// An array of a host's. A count without one is refused.
template <class T>
std::span<const T> items(const T* first, size_t count, const char* name) {
  if (count > 0 && !first)
    throw bad_argument(std::string(name) + " is null, but the count is " + std::to_string(count));
  return {first, count};
}
template <class T>
void answer(T* out, T value, const char* name) {
  const size_t size = required(out, name).size;
  if (size < sizeof size) throw bad_argument(std::string(name) + ": `size` is not set");
  value.size = size;
  std::memcpy(static_cast<void*>(out), &value, std::min(size, sizeof value));
}

/// Hands diagnostics to the host, and keeps the last error for the text of the call that fails by it.
class Reports {
 public:
  Reports(AlabasterReport report, void* user) : report_(report), user_(user) {}
  void operator()(const Diagnostic& diagnostic);
  /// "where: text" of the last error since the last call; `fallback` if there is none.
  std::string take_error(const std::string& fallback);

 private:
  AlabasterReport report_;
  void* user_;
  std::mutex mutex_;
  std::string error_;
};
DiagnosticSink sink_of(const std::shared_ptr<Reports>& reports);

// Locks are taken in this order: the delegate's, the scene's, a buffer's. The first two are recursive: the progress
// callback of record may call the library. An edit of a shown scene calls into its delegate, and so needs the scene's
// lock to keep others out of both.
struct SceneData {
  std::recursive_mutex mutex;
  host::RetainedSceneDelegate scene;
  std::shared_ptr<Reports> reports;
  description::SceneFile loaded;
  std::set<std::string> loaded_texts;  // those of every load: another thread may still read them
  std::atomic<bool> is_shown{false};   // a delegate draws it
  std::set<Path> unmatched;            // instancers, and meshes with one, that the host has set since the last frame
  std::set<Path> told_instancers;      // with a fault of what they list, which has been reported
  const Process process{};
};

/// Held by the one thread that calls into a scene.
class SceneLock {
 public:
  explicit SceneLock(SceneData& data) {
    data.process.check("the scene");
    lock_ = std::unique_lock(data.mutex);
  }

 private:
  std::unique_lock<std::recursive_mutex> lock_;
};

struct DelegateData {
  ~DelegateData();
  /// A failure may leave a scene half drawn; another call then goes on where it failed.
  void show(const std::shared_ptr<SceneData>& shown);

  std::recursive_mutex mutex;
  std::shared_ptr<Reports> reports;
  host::OutputColors colors;
  bool names_colors = false;  // the host does
  std::string told_colors;    // a scene's configuration that has been reported
  RenderDelegate* delegate = nullptr;
  std::unique_ptr<host::RenderIndex> index;
  std::shared_ptr<SceneData> scene;
  bool records = false;  // what then comes is called by the progress callback
  const Process process{};
};

/// Reports, once, that the scene names a colour configuration which the delegate, made before, does not have.
void tell_other_colors(DelegateData& data);
/// Reports, once for each instancer, names that instancers and meshes which the host has set do not have for each
/// other. Only in what the host has set: readers of files may leave out a prototype, and an index has no such lists.
void tell_unmatched_instancers(DelegateData& data);
/// Refuses what cannot happen in the midst of a recording.
void refuse_while_recording(const DelegateData& data, const char* function);

/// Held by the one thread that calls into a delegate and its scene.
class HostLock {
 public:
  explicit HostLock(DelegateData& data) {
    data.process.check("the delegate");
    delegate_ = std::unique_lock(data.mutex);
    scene_ = data.scene;
    if (scene_) scene_lock_.emplace(*scene_);
  }

 private:
  std::unique_lock<std::recursive_mutex> delegate_;
  std::shared_ptr<SceneData> scene_;  // outlives its lock
  std::optional<SceneLock> scene_lock_;
};

struct BufferData {
  ~BufferData();
  std::shared_ptr<DelegateData> owner;
  RenderBuffer* buffer = nullptr;
  Vec2i size{0, 0};  // as allocated last; takes effect at the next start
  std::mutex mutex;  // between Resolve and the reading of its size
};

struct PassData {
  ~PassData();
  std::shared_ptr<DelegateData> owner;
  std::unique_ptr<RenderPass> pass;
  std::vector<std::shared_ptr<BufferData>> bound;
  RenderPassState state;  // of the last start
};

// The functions of the table, by the files that have them.
void add_scene_functions(AlabasterApi* api);
void add_delegate_functions(AlabasterApi* api);
void add_pass_functions(AlabasterApi* api);
void add_display_functions(AlabasterApi* api);

/// The render settings of that path, or fails. Of null, the first; an empty path where there are none.
Path settings_path(const host::RetainedSceneDelegate& scene, const char* path);

}  // namespace alabaster::hd::c_api

struct AlabasterScene final : alabaster::hd::c_api::HandleTo<alabaster::hd::c_api::SceneData> {
  using HandleTo::HandleTo;
};
struct AlabasterDelegate final : alabaster::hd::c_api::HandleTo<alabaster::hd::c_api::DelegateData> {
  using HandleTo::HandleTo;
};
struct AlabasterBuffer final : alabaster::hd::c_api::HandleTo<alabaster::hd::c_api::BufferData> {
  using HandleTo::HandleTo;
};
struct AlabasterPass final : alabaster::hd::c_api::HandleTo<alabaster::hd::c_api::PassData> {
  using HandleTo::HandleTo;
};
