#include "delegate/rendering/snapshot_builder.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <chrono>
#include <utility>

#include "core/math/float_environment.h"

namespace alabaster::hd::rendering {

namespace {

constexpr std::chrono::seconds kEditsEnd(2);         // without an edit for so long, the next one may be slower
constexpr std::chrono::microseconds kHostTurn(300);  // longer than most calls of Execute
constexpr const char* kWhere = "CommitResources";
constexpr const char* kNotDrawn = "; the scene is not drawn, and the next commit builds it again";

}  // namespace

SnapshotBuilder::SnapshotBuilder(std::shared_ptr<prims::SceneParam> param, Events events)
    : param_(std::move(param)),
      events_(std::move(events)),
      notifier_(std::make_shared<DeferredNotifier>([this] { wake_.notify_all(); }, kHostTurn)),
      translator_(param_->sink()),
      compiler_(param_->device(), param_->sink()) {}

SnapshotBuilder::~SnapshotBuilder() {
  {
    const std::lock_guard lock(mutex_);
    quit_ = true;
    cancel_ = true;
  }
  wake_.notify_all();
  if (thread_.joinable()) thread_.join();
}

void SnapshotBuilder::post(std::list<prims::Edit>* edits, const View& view) {
  if (!thread_.joinable()) thread_ = std::thread([this] { run(); });
  auto posted_view = std::make_shared<const View>(view);
  {
    const std::lock_guard lock(mutex_);
    posted_.splice(posted_.end(), *edits);
    posted_view_ = std::move(posted_view);
    requested_ = pending_ = true;
    if (building_ && !cancelled_before_) cancel_ = true;
  }
  notifier_->request();
}

void SnapshotBuilder::build_for(const support::Selection& selection) {
  {
    const std::lock_guard lock(mutex_);
    if (requested_ || !posted_view_) return;
    auto view = std::make_shared<View>(*posted_view_);
    view->selection = selection;
    posted_view_ = std::move(view);
    requested_ = pending_ = true;
  }
  notifier_->request();
}

void SnapshotBuilder::set_stopped(bool stopped) {
  std::unique_lock lock(mutex_);
  stopped_ = stopped;
  if (stopped) {
    cancel_ = true;
    rested_.notify_all();
    rested_.wait(lock, [&] { return !building_; });
  } else {
    wake_.notify_all();
  }
}

bool SnapshotBuilder::wait(double seconds) {
  std::unique_lock lock(mutex_);
  const auto over = [&] { return !pending_ || stopped_; };
  if (seconds > 1e6)
    rested_.wait(lock, over);
  else if (seconds > 0)
    rested_.wait_for(lock, std::chrono::duration<double>(seconds), over);
  return !pending_;
}

std::shared_ptr<const BuiltScene> SnapshotBuilder::built() const {
  const std::lock_guard lock(mutex_);
  return failed_ ? nullptr : built_;
}

std::string SnapshotBuilder::refusal() const {
  const std::lock_guard lock(mutex_);
  return refusal_;
}

bool SnapshotBuilder::has_failed(const support::Selection& selection) const {
  const std::lock_guard lock(mutex_);
  return failed_ && failed_selection_ == selection;
}

void SnapshotBuilder::release_retired() {
  const std::lock_guard lock(mutex_);
  if (retired_.empty()) return;
  release_ = true;
  wake_.notify_all();
}

void SnapshotBuilder::run() {
  const FloatEnvironment environment;
  while (take_work()) build();
}

// Waits for a request, a release or the end.
void SnapshotBuilder::await_work(std::unique_lock<std::mutex>* lock) {
  const auto wanted = [&] { return quit_ || release_ || (requested_ && !stopped_); };
  if (wake_.wait_for(*lock, kEditsEnd, wanted)) return;
  lock->unlock();
  meshes_.rest();
  lock->lock();
  wake_.wait(*lock, wanted);
}

// Waits for a request, and takes its edits and view. False: the builder ends.
bool SnapshotBuilder::take_work() {
  std::unique_lock lock(mutex_);
  for (;;) {
    await_work(&lock);
    if (quit_) return false;
    if (release_) {
      release_ = false;
      lock.unlock();
      prims::guarded(param_->sink(), kWhere, [&] { destroy_unused(); });
      lock.lock();
      continue;
    }
    edits_.splice(edits_.end(), posted_);
    view_ = posted_view_;
    requested_ = false;
    building_ = true;
    cancel_ = false;
    return true;
  }
}

void SnapshotBuilder::build() {
  notifier_->begin_work();
  bool cancelled = false, refused = false;
  const auto build_it = [&] {
    try {
      update(CancelToken(&cancel_));
      refusals_.report(param_->sink(), {});
    } catch (const BuildCancelled&) {
      cancelled = true;
    } catch (const std::bad_alloc& e) {
      refused = true;
      refuse(e);
    }
  };
  const bool done = prims::guarded(param_->sink(), kWhere, build_it, kNotDrawn) && !refused;
  {
    const std::lock_guard lock(mutex_);
    // After a failure no scene is given: the earlier one would be taken for the new one.
    if (!cancelled) failed_ = !done;
    if (!done) failed_selection_ = view_->selection;
    if (!cancelled && !refused) refusal_.clear();
    cancelled_before_ = cancelled && requested_;
    if (cancelled) requested_ = true;
    pending_ = requested_;
    release_ |= !cancelled;
  }
  notifier_->end_work();
  rested_.notify_all();
  if (!pending_) events_.built();
  const std::lock_guard lock(mutex_);
  building_ = false;
  rested_.notify_all();
}

// Reported once, whatever the numbers in it, until a build succeeds.
void SnapshotBuilder::refuse(const std::bad_alloc& e) {
  // The next try may need the memory of what only the builder holds.
  meshes_.rest();
  replaced_.clear();
  compiler_.forget();
  const MemoryRefused refused = refusal_of(e);
  const std::string refusal = (refused.prim().empty() ? "" : refused.prim() + ": ") + refused.what();
  {
    const std::lock_guard lock(mutex_);
    refusal_ = refusal;
    if (built_) retired_.push_back(std::exchange(built_, nullptr));
  }
  refusals_.report(param_->sink(),
                   {{alabaster::Severity::error, "scene.memory", refused.prim().empty() ? kWhere : refused.prim(),
                     std::string(refused.what()) + kNotDrawn}});
}

// The materials of visible meshes, as they are once these edits are applied.
std::set<Path> SnapshotBuilder::used_materials(const std::map<Path, prims::Edit*>& edits) const {
  std::set<Path> used;
  const auto add = [&](const prims::Record& record) {
    const auto* mesh = std::any_cast<prims::MeshRecord>(&record);
    if (mesh && mesh->visible) used.insert(mesh->materials.begin(), mesh->materials.end());
  };
  for (const auto& [path, record] : records_)
    if (!edits.contains(path)) add(record);
  for (const auto& [path, edit] : edits) add(edit->record);
  return used;
}

// Makes the records of edits that have files to read: of those of one prim the last alone. Images are decoded on all
// threads. Records that are made when the build is cancelled stay. So do edits of materials that no mesh uses, unread.
void SnapshotBuilder::read_files(const CancelToken& cancel) {
  std::map<Path, prims::Edit*> last;
  for (prims::Edit& edit : edits_) last[edit.id] = &edit;
  std::set<Path> used;
  if (std::any_of(edits_.begin(), edits_.end(), [](const prims::Edit& edit) { return edit.waits_for_use; }))
    used = used_materials(last);
  std::vector<prims::Edit*> unread;
  for (const auto& [id, edit] : last)
    if (edit->read && (!edit->waits_for_use || used.contains(id))) unread.push_back(edit);
  Refusals refusals;
  const auto read_one = [&](prims::Edit* edit) {
    if (cancel.is_cancelled()) return;
    refusals.run(edit->id.str(), [&] {
      edit->record = edit->read(cancel);
      edit->read = nullptr;
    });
  };
  param_->run([&] { tbb::parallel_for(size_t(0), unread.size(), [&](size_t i) { read_one(unread[i]); }); });
  param_->file_faults().report(param_->sink());
  cancel.check();
  refusals.check();
  edits_.remove_if([&](const prims::Edit& edit) { return edit.read && last.at(edit.id) != &edit; });
}

prims::SceneFaults SnapshotBuilder::faults() const {
  prims::SceneFaults all = meshes_.faults(records_, view_->selection);
  for (const auto& [path, record] : records_) {
    const auto* material = std::any_cast<prims::MaterialRecord>(&record);
    const auto* light = std::any_cast<prims::LightRecord>(&record);
    const std::optional<std::string>& fault = material ? material->fault : light ? light->fault : std::nullopt;
    if (fault) all.emplace(path, *fault);
  }
  return all;
}

// Memory may run out at any step: an edit leaves the list once it is applied whole.
void SnapshotBuilder::apply_edits() {
  for (auto edit = edits_.begin(); edit != edits_.end();) {
    if (edit->read) {
      ++edit;
      continue;
    }
    prims::Record& held = records_[edit->id];
    replaced_.push_back(std::move(held));
    held = std::move(edit->record);
    if (!held.has_value()) records_.erase(edit->id);
    edit = edits_.erase(edit);
  }
}

void SnapshotBuilder::update(const CancelToken& cancel) {
  replaced_.clear();
  read_files(cancel);
  apply_edits();
  if (built_ && built_->version == view_->version && built_->selection == view_->selection) return;
  meshes_.build({records_, view_->selection, view_->meshes}, param_.get(), cancel);
  const auto start = std::chrono::steady_clock::now();
  translate(cancel);
  const std::chrono::duration<double> spent = std::chrono::steady_clock::now() - start;
  compile_seconds_ = compile_seconds_ + spent.count();
}

// A scene that is the same to the bit as the last one has its snapshot, though faults and paths may differ.
void SnapshotBuilder::translate(const CancelToken& cancel) {
  const prims::DeformedMeshes deformed = deformations_.in(view_->shutter, view_->motion, meshes_, param_.get(), cancel);
  BuiltScene scene{view_->selection, view_->version, {}, nullptr, {}};
  param_->run([&] {
    scene.translation = translator_.translate({records_, view_->selection, view_->shutter, view_->motion, meshes_,
                                               deformed, param_->memory(), view_->meshes.primvars, edits_});
  });
  scene.faults = faults();
  scene.faults.insert(scene.translation.faults.begin(), scene.translation.faults.end());
  const SceneDescription& description = scene.translation.scene;
  if (built_ && built_->translation.scene == description) {
    scene.snapshot = built_->snapshot;
  } else {
    param_->run([&] { scene.snapshot = compiler_.compile(description, scene_number_ + 1, cancel); });
    if (!scene.snapshot) throw MemoryRefused("Embree built no hierarchy of the scene; lower refineLevel");
    ++scene_number_;
  }
  publish(std::make_shared<const BuiltScene>(std::move(scene)));
}

void SnapshotBuilder::publish(std::shared_ptr<const BuiltScene> scene) {
  {
    const std::lock_guard lock(mutex_);
    if (built_) retired_.push_back(built_);
    built_ = std::move(scene);
  }
  events_.published();
}

// Passes hold snapshots, which hold most of what a scene is. Several retired scenes may have one.
void SnapshotBuilder::destroy_unused() {
  meshes_.release_dropped();
  replaced_.clear();
  std::vector<std::shared_ptr<const BuiltScene>> unused;
  const std::lock_guard guard(mutex_);
  const auto is_unused = [&](const std::shared_ptr<const BuiltScene>& scene) {
    if (scene.use_count() > 1) return false;
    const auto has_same = [&](const auto& held) { return held && held->snapshot == scene->snapshot; };
    if (has_same(built_)) return true;
    return scene->snapshot.use_count() == std::count_if(retired_.begin(), retired_.end(), has_same) +
                                              std::count_if(unused.begin(), unused.end(), has_same);
  };
  unused.reserve(retired_.size());
  for (auto& scene : retired_)
    if (is_unused(scene)) unused.push_back(std::move(scene));
  std::erase(retired_, nullptr);
}

}  // namespace alabaster::hd::rendering
