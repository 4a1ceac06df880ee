#include "delegate/c_api/handles.h"

#include "delegate/support/nearest_name.h"

namespace alabaster::hd::c_api {

// An array: a thread_local string would keep the library loaded until the thread ends.
static thread_local char g_last_error[2048];

AlabasterStatus fail(AlabasterStatus status, const char* text) noexcept {
  std::strncpy(g_last_error, text, sizeof g_last_error - 1);
  return status;
}
const char* last_error() noexcept {
  return g_last_error;
}

thread_local int CallbackScope::depth = 0;

namespace {
std::atomic<Handle*> g_put_off{nullptr};
}

void destroy(Handle* handle) noexcept {
  if (!handle || handle->process.is_another()) return;
  const FloatEnvironment environment;
  if (!CallbackScope::is_open()) {
    delete handle;
    destroy_put_off();
    return;
  }
  handle->next = g_put_off;
  while (!g_put_off.compare_exchange_weak(handle->next, handle)) {
  }
}

void destroy_put_off() noexcept {
  if (!g_put_off) return;
  for (Handle* handle = g_put_off.exchange(nullptr); handle;) {
    Handle* const next = handle->next;
    if (!handle->process.is_another()) delete handle;
    handle = next;
  }
}

void Reports::operator()(const Diagnostic& diagnostic) {
  if (diagnostic.severity == Severity::error) {
    const std::lock_guard lock(mutex_);
    error_ = diagnostic.where.empty() ? diagnostic.text : diagnostic.where + ": " + diagnostic.text;
  }
  if (!report_) return;
  const AlabasterDiagnostic told = {int32_t(diagnostic.severity), diagnostic.code.c_str(), diagnostic.where.c_str(),
                                    diagnostic.text.c_str()};
  const CallbackScope scope;
  report_(user_, &told);
}

std::string Reports::take_error(const std::string& fallback) {
  const std::lock_guard lock(mutex_);
  return error_.empty() ? fallback : std::exchange(error_, {});
}

DiagnosticSink sink_of(const std::shared_ptr<Reports>& reports) {
  return [reports](const Diagnostic& diagnostic) { (*reports)(diagnostic); };
}

void refuse_while_recording(const DelegateData& data, const char* function) {
  if (data.records)
    throw bad_argument(std::string(function) +
                       " is called by the progress callback of record: it must wait until that record returns");
}

DelegateData::~DelegateData() {
  try {
    show(nullptr);
  } catch (...) {  // memory ran out
    static_cast<void>(index.release());
    static_cast<void>(new (std::nothrow) std::shared_ptr<SceneData>(std::move(scene)));  // the index points at it
    return;
  }
  index.reset();
  DestroyAlabasterRenderDelegate(delegate);
}

namespace {

/// Marks a scene as drawn, until release() or for good.
class ShownMark {
 public:
  explicit ShownMark(SceneData* scene) : scene_(scene) {
    if (!scene || !scene->is_shown.exchange(true)) return;
    throw bad_argument("another delegate draws this scene: destroy it, or let it show another one");
  }
  ~ShownMark() {
    if (scene_) scene_->is_shown = false;
  }
  ShownMark(const ShownMark&) = delete;
  ShownMark& operator=(const ShownMark&) = delete;
  void keep() { scene_ = nullptr; }

 private:
  SceneData* scene_;
};

}  // namespace

void DelegateData::show(const std::shared_ptr<SceneData>& shown) {
  if (shown != scene) {
    ShownMark mark(shown.get());
    if (scene) {
      const SceneLock lock(*scene);
      scene->scene.Depopulate();
      scene->is_shown = false;
    }
    scene = shown;
    mark.keep();
    if (!scene) return;
    const SceneLock lock(*scene);
    scene->scene.Populate(index.get());
  }
  if (!scene) return;
  const SceneLock lock(*scene);
  if (!scene->scene.PopulateRest())
    throw Failure(ALABASTER_OUT_OF_MEMORY, "memory ran out for the scene's prims: show it again");
}

BufferData::~BufferData() {
  if (!buffer) return;
  const HostLock lock(*owner);
  buffer->Finalize(owner->delegate->GetRenderParam());
  owner->delegate->DestroyBprim(buffer);
}

PassData::~PassData() {
  const HostLock lock(*owner);
  pass.reset();
  bound.clear();
}

Path settings_path(const host::RetainedSceneDelegate& scene, const char* path) {
  const auto all = scene.GetAllRenderSettings();
  if (path && !all.contains(path))
    throw Failure(ALABASTER_NOT_FOUND,
                  std::string("there are no render settings ") + path + support::DidYouMeanPath(path, all));
  if (path) return path;
  const auto first = all.begin();  // a walk through the scene
  return first == all.end() ? Path() : first->first;
}

}  // namespace alabaster::hd::c_api

using namespace alabaster::hd;

// The numbers that cross the interface are those of the contract.
static_assert(int(Format::unorm8) == ALABASTER_UNORM8 && int(Format::float16) == ALABASTER_HALF &&
              int(Format::float32) == ALABASTER_FLOAT32 && int(Format::float32vec4) == ALABASTER_FLOAT32_4 &&
              int(Format::int32) == ALABASTER_INT32);
static_assert(int(PassState::idle) == ALABASTER_IDLE && int(PassState::stopped) == ALABASTER_STOPPED &&
              int(PassState::failed) == ALABASTER_FAILED);
static_assert(int(WindowPolicy::matchVertically) == ALABASTER_MATCH_VERTICALLY &&
              int(WindowPolicy::dontConform) == ALABASTER_DONT_CONFORM);
static_assert(int(Severity::info) == ALABASTER_INFO && int(Severity::error) == ALABASTER_ERROR);

extern "C" const AlabasterApi* alabaster_api(uint32_t version) {
  static const AlabasterApi api = [] {
    AlabasterApi made{};
    made.size = sizeof made;
    made.version = ALABASTER_API_VERSION;
    made.versions = AlabasterVersions();
    made.last_error = c_api::last_error;
    c_api::add_scene_functions(&made);
    c_api::add_delegate_functions(&made);
    c_api::add_pass_functions(&made);
    c_api::add_display_functions(&made);
    return made;
  }();
  return version == ALABASTER_API_VERSION ? &api : nullptr;
}
