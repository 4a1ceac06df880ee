#include "delegate/rendering/snapshot_builder.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <chrono>
#include <utility>

#include "core/math/float_environment.h"
#include "delegate/rendering/scene_lacks.h"

namespace alabaster::hd::rendering {

namespace {

constexpr std::chrono::seconds kEditsEnd(2);         // without an edit for so long, the next one may be slower
constexpr std::chrono::microseconds kHostTurn(300);  // longer than most calls of Execute
constexpr const char *kNoMemory = "scene.memory", *kWhere = "CommitResources";
constexpr const char* kNotDrawn = "; the scene is not drawn, and the next commit builds it again";
constexpr const char* kStays = "; the scene stays as it is, and the next commit builds it again";

SceneLacks lacks_of(const SceneSnapshot& snapshot) {
  SceneLacks lacks;
  lacks.add(snapshot);
  return lacks;
}

SceneLacks lacks_of(const BuiltScene& scene) {
  SceneLacks lacks;
  lacks.add(scene.faults, scene.translation.scene);
  if (scene.snapshot) lacks.add(*scene.snapshot);
  return lacks;
}

}  // namespace

SnapshotBuilder::SnapshotBuilder(std::shared_ptr<prims::SceneParam> param, Events events)
    : param_(std::move(param)),
      events_(std::move(events)),
      notifier_(std::make_shared<DeferredNotifier>([this] { wake_.notify_all(); }, kHostTurn)),
      translator_(param_->sink()) {}

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

std::shared_ptr<const BuiltScene> SnapshotBuilder::built(const support::Selection& selection) const {
  const std::lock_guard lock(mutex_);
  if (lost_) return nullptr;
  for (const auto& scene : built_)
    if (scene->selection == selection) return scene;
  return nullptr;
}

std::shared_ptr<const BuiltScene> SnapshotBuilder::built(const std::shared_ptr<const SceneSnapshot>& snapshot) const {
  const std::lock_guard lock(mutex_);
  if (lost_ || !snapshot) return nullptr;
  for (const auto& scene : built_)
    if (scene->snapshot == snapshot) return scene;
  return nullptr;
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
    changed_ |= !posted_.empty() || !view_ || *view_ != *posted_view_;
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
  bool cancelled = false;
  const auto build_it = [&] {
    try {
      update(CancelToken(&cancel_));
    } catch (const BuildCancelled&) {
      cancelled = true;
    }
  };
  const bool done = prims::guarded(param_->sink(), kWhere, build_it, changed_ ? kNotDrawn : kStays);
  if (!done)  // for want of memory, mostly
    for (Variant& variant : variants_) variant.compiler.forget();
  {
    const std::lock_guard lock(mutex_);
    // After a failure no scene is given: the earlier one would be taken for the new one. A scene that lacks parts stays
    // while no try to add them succeeds.
    lost_ = (lost_ && (cancelled || !done)) || (!done && changed_);
    failed_ = lost_ || !done || in_vain_ ||
              (!cancelled && (meshes_.incomplete() || deformations_.incomplete() || lacks_snapshots()));
    changed_ &= cancelled || !done;
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

// The materials of visible meshes, as they are once these edits are applied.
std::set<Path> SnapshotBuilder::used_materials(const std::map<Path, prims::Edit*>& edits) const {
  std::set<Path> used;
  const auto add = [&](const prims::Record& record) {
    const auto* mesh = std::get_if<prims::MeshRecord>(&record);
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
  const auto read_one = [&](prims::Edit* edit) {
    if (cancel.is_cancelled()) return;
    edit->record = edit->read(cancel);
    edit->read = nullptr;
  };
  param_->run([&] { tbb::parallel_for(size_t(0), unread.size(), [&](size_t i) { read_one(unread[i]); }); });
  param_->file_faults().report(param_->sink());
  cancel.check();
  edits_.remove_if([&](const prims::Edit& edit) { return edit.read && last.at(edit.id) != &edit; });
}

prims::SceneFaults SnapshotBuilder::faults(const support::Selection& selection) const {
  prims::SceneFaults all = meshes_.faults(records_, selection);
  deformations_.add_faults(records_, selection, &all);
  for (const auto& [path, record] : records_) {
    const auto* material = std::get_if<prims::MaterialRecord>(&record);
    const auto* light = std::get_if<prims::LightRecord>(&record);
    const std::optional<prims::SceneFault>& fault = material ? material->fault : light ? light->fault : std::nullopt;
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
    scenes_stale_ |= held != edit->record;
    replaced_.push_back(std::move(held));
    held = std::move(edit->record);
    if (std::holds_alternative<std::monostate>(held)) records_.erase(edit->id);
    edit = edits_.erase(edit);
  }
}

void SnapshotBuilder::update(const CancelToken& cancel) {
  replaced_.clear();
  in_vain_ = false;
  read_files(cancel);
  apply_edits();
  const View& view = *view_;
  const auto is_current = [&](const support::Selection& selection) {
    const auto last = built(selection);
    return last && last->snapshot && last->translation.shutter == view.shutter;
  };
  scenes_stale_ |= meshes_.incomplete() || deformations_.incomplete() || !meshes_.is_built_for(view.meshes);
  choose_variants(view.selections);
  if (scenes_stale_ || !std::all_of(view.selections.begin(), view.selections.end(), is_current)) {
    scenes_stale_ = true;  // until all of it is done
    meshes_.build({records_, view.selections, view.meshes}, param_.get(), cancel);
    const auto start = std::chrono::steady_clock::now();
    const prims::DeformedMeshes deformed = deformations_.in(view.shutter, meshes_, param_.get(), cancel);
    translator_.begin();
    for (Variant& variant : variants_) translate(&variant, deformed, cancel);
    translator_.report();
    {
      const std::lock_guard lock(mutex_);
      scenes_stale_ = in_vain_ || lacks_snapshots();
    }
    const std::chrono::duration<double> spent = std::chrono::steady_clock::now() - start;
    compile_seconds_ = compile_seconds_ + spent.count();
  }
  retire_unselected();
}

// A new selection shares parts with the scene of one that no pass asks for any more. Only the allocation of the new
// list may run out of memory.
void SnapshotBuilder::choose_variants(const std::vector<support::Selection>& selections) {
  std::vector<Variant> chosen;
  chosen.reserve(selections.size());
  for (const support::Selection& selection : selections)
    chosen.push_back({selection, SnapshotCompiler(param_->device(), param_->sink()), false});
  const auto find = [](std::vector<Variant>& in, const support::Selection& selection) {
    return std::find_if(in.begin(), in.end(), [&](const Variant& v) { return v.selection == selection; });
  };
  auto unused = variants_.begin();
  for (Variant& now : chosen) {
    auto from = find(variants_, now.selection);
    if (from == variants_.end()) {
      while (unused != variants_.end() && find(chosen, unused->selection) != chosen.end()) ++unused;
      if (unused == variants_.end()) continue;
      from = unused++;
    }
    std::swap(now.compiler, from->compiler);
    std::swap(now.has_failed, from->has_failed);
  }
  variants_ = std::move(chosen);
}

void SnapshotBuilder::translate(Variant* variant, const prims::DeformedMeshes& deformed, const CancelToken& cancel) {
  BuiltScene scene{variant->selection, {}, nullptr, {}};
  param_->run([&] {
    scene.translation = translator_.translate(
        {records_, variant->selection, view_->shutter, meshes_, deformed, param_->memory(), edits_});
  });
  scene.faults = faults(variant->selection);
  scene.faults.insert(scene.translation.faults.begin(), scene.translation.faults.end());
  const std::shared_ptr<const BuiltScene> drawn = unedited(variant->selection);
  if (drawn && !lacks_of(scene).shows_all_of(lacks_of(*drawn))) {
    in_vain_ = true;
  } else if (auto same = snapshot_of(scene.translation.scene)) {  // faults and paths may still differ
    scene.snapshot = std::move(same);
    publish(std::make_shared<const BuiltScene>(std::move(scene)));
  } else {
    compile(variant, std::move(scene), drawn, cancel);
  }
}

// The scene that is drawn of records that nothing has edited since, or null.
std::shared_ptr<const BuiltScene> SnapshotBuilder::unedited(const support::Selection& selection) const {
  if (changed_) return nullptr;
  auto held = built(selection);
  return held && held->snapshot ? held : nullptr;
}

// The snapshot of a scene that is the same to the bit, or null.
template <class IsSame>
std::shared_ptr<const SceneSnapshot> SnapshotBuilder::find_held(const SceneDescription& scene,
                                                                const IsSame& is_same) const {
  std::vector<std::shared_ptr<const BuiltScene>> known;
  {
    const std::lock_guard lock(mutex_);
    known = built_;
  }
  for (const auto& held : known)
    if (held->snapshot && is_same(*held->snapshot) && held->translation.scene == scene) return held->snapshot;
  return nullptr;
}

std::shared_ptr<const SceneSnapshot> SnapshotBuilder::snapshot_of(const SceneDescription& scene) const {
  return find_held(scene, [](const SceneSnapshot& held) { return held.lacks.empty(); });
}

// Null, or a held snapshot of the same scene than which the new one, which may be null, is no better. The new one would
// start its renders again at the first sample.
std::shared_ptr<const SceneSnapshot> SnapshotBuilder::as_incomplete(const BuiltScene& scene) const {
  const SceneSnapshot* const now = scene.snapshot.get();
  if (now && now->lacks.empty()) return nullptr;
  return find_held(scene.translation.scene,
                   [now](const SceneSnapshot& held) { return !now || !lacks_of(*now).is_better_than(lacks_of(held)); });
}

// Makes the scene's snapshot. False: an exception ended it, and the failure is to be reported with its outcome. Throws
// BuildCancelled.
bool SnapshotBuilder::try_compile(Variant* variant, BuiltScene* scene, alabaster::Diagnostic* failure,
                                  const CancelToken& cancel) {
  const auto run = [&] {
    scene->snapshot = variant->compiler.compile(scene->translation.scene, scene_number_ + 1, cancel);
  };
  bool cancelled = false, refused = false;
  const auto compile_it = [&] {
    try {
      param_->run(run);
    } catch (const BuildCancelled&) {
      cancelled = true;
    } catch (const std::bad_alloc& e) {
      refused = true;
      failure->text = MemoryLacks::reason_of(e);
      failure->code = kNoMemory;
    }
  };
  const bool done = prims::guarded([&](const alabaster::Diagnostic& d) { *failure = d; }, kWhere, compile_it);
  if (cancelled) throw BuildCancelled();
  if (scene->snapshot) return true;
  variant->compiler.forget();
  if (done && !refused) return true;  // Embree has refused, and reported it
  if (failure->text.empty()) *failure = {alabaster::Severity::error, kNoMemory, kWhere, "not enough memory"};
  return false;
}

// `drawn`: unedited(). The new scene takes its place where it lacks nothing, or less.
void SnapshotBuilder::compile(Variant* variant, BuiltScene scene, const std::shared_ptr<const BuiltScene>& drawn,
                              const CancelToken& cancel) {
  alabaster::Diagnostic failure{alabaster::Severity::error, "", kWhere, ""};
  const bool done = try_compile(variant, &scene, &failure, cancel);
  const SceneLacks lacks = lacks_of(scene);
  const bool is_better = scene.snapshot && (lacks.empty() || (drawn && lacks.is_better_than(lacks_of(*drawn))));
  const bool stays = drawn && !is_better;
  auto held = stays ? drawn->snapshot : as_incomplete(scene);
  const bool is_known = std::exchange(variant->has_failed, !done);
  if (!done && (changed_ || !is_known))
    alabaster::report(param_->sink(), failure.severity, failure.code, failure.where,
                      failure.text + (held ? kStays : kNotDrawn));
  if (stays) {
    variant->compiler.continue_from(std::move(held), drawn->translation.scene);
    in_vain_ = true;
    return;
  }
  prims::guarded(param_->sink(), kWhere, [&] { variant->compiler.report_faults(); });
  if (held) {
    variant->compiler.continue_from(held, scene.translation.scene);
    scene.snapshot = std::move(held);
  } else {
    // A scene that could not be compiled has no snapshot: the old one would be taken for it.
    ++scene_number_;
  }
  publish(std::make_shared<const BuiltScene>(std::move(scene)));
}

void SnapshotBuilder::publish(std::shared_ptr<const BuiltScene> scene) {
  {
    const std::lock_guard lock(mutex_);
    const auto same = std::find_if(built_.begin(), built_.end(),
                                   [&](const auto& held) { return held->selection == scene->selection; });
    if (same == built_.end()) {
      built_.push_back(std::move(scene));
    } else {
      retired_.push_back(*same);
      *same = std::move(scene);
    }
  }
  events_.published();
}

// Retires the scenes of selections that no pass asks for any more.
void SnapshotBuilder::retire_unselected() {
  {
    const std::lock_guard lock(mutex_);
    const auto is_selected = [&](const std::shared_ptr<const BuiltScene>& scene) {
      return std::any_of(variants_.begin(), variants_.end(),
                         [&](const Variant& v) { return v.selection == scene->selection; });
    };
    const auto unselected = std::stable_partition(built_.begin(), built_.end(), is_selected);
    if (unselected == built_.end()) return;
    retired_.insert(retired_.end(), unselected, built_.end());
    built_.erase(unselected, built_.end());
  }
}

// True if a variant has no snapshot, or one that lacks something for want of memory.
bool SnapshotBuilder::lacks_snapshots() const {
  return !std::all_of(variants_.begin(), variants_.end(), [&](const Variant& variant) {
    return std::any_of(built_.begin(), built_.end(), [&](const auto& scene) {
      return scene->selection == variant.selection && scene->snapshot && scene->snapshot->lacks.empty() &&
             !scene->translation.lacks_memory;
    });
  });
}

// Passes hold snapshots, which hold most of what a scene is. Several retired scenes may have one.
void SnapshotBuilder::destroy_unused() {
  meshes_.release_dropped();
  replaced_.clear();
  std::vector<std::shared_ptr<const BuiltScene>> unused;
  const std::lock_guard guard(mutex_);
  const auto is_unused = [&](const std::shared_ptr<const BuiltScene>& scene) {
    const auto has_same = [&](const auto& held) { return held && held->snapshot == scene->snapshot; };
    if (!scene->snapshot || std::any_of(built_.begin(), built_.end(), has_same)) return true;
    return scene->snapshot.use_count() == std::count_if(retired_.begin(), retired_.end(), has_same) +
                                              std::count_if(unused.begin(), unused.end(), has_same);
  };
  unused.reserve(retired_.size());
  for (auto& scene : retired_)
    if (is_unused(scene)) unused.push_back(std::move(scene));
  std::erase(retired_, nullptr);
}

}  // namespace alabaster::hd::rendering
