#include "delegate/rendering/snapshot_builder.h"

#include <tbb/parallel_for_each.h>

#include <chrono>

namespace alabaster::hd::rendering {

SnapshotBuilder::SnapshotBuilder(std::shared_ptr<prims::SceneParam> param, std::function<void()> published)
    : param_(std::move(param)),
      published_(std::move(published)),
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
  {
    const std::lock_guard lock(mutex_);
    posted_.splice(posted_.end(), *edits);
    posted_view_ = view;
    requested_ = pending_ = true;
    if (building_ && !cancelled_before_) cancel_ = true;
  }
  wake_.notify_all();
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
  return lost_ ? nullptr : built_;
}

void SnapshotBuilder::release_retired() {
  const std::lock_guard lock(mutex_);
  if (retired_.empty()) return;
  release_ = true;
  wake_.notify_all();
}

void SnapshotBuilder::run() {
  while (take_work()) build();
}

// Waits for a request, and makes it this thread's; false: the builder ends.
bool SnapshotBuilder::take_work() {
  std::unique_lock lock(mutex_);
  for (;;) {
    wake_.wait(lock, [&] { return quit_ || release_ || (requested_ && !stopped_); });
    if (quit_) return false;
    if (release_) {
      release_ = false;
      lock.unlock();
      destroy_retired();
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
  bool cancelled = false;
  const bool done = prims::guarded(param_->sink(), "CommitResources", [&] {
    try {
      update(CancelToken(&cancel_));
    } catch (const BuildCancelled&) {
      cancelled = true;
    }
  });
  if (!done) compiler_.forget();  // for want of memory, mostly
  {
    const std::lock_guard lock(mutex_);
    // The scene of before would pass for the new one.
    lost_ = !done || (cancelled && lost_);
    failed_ = lost_ || (!cancelled && (meshes_.incomplete() || !built_ || !built_->snapshot));
    cancelled_before_ = cancelled && requested_;
    if (cancelled) requested_ = true;
    building_ = false;
    pending_ = requested_;
  }
  rested_.notify_all();
}

// Makes the records of edits that have files to read: of those of one prim the last alone. Images are decoded on all
// threads; what is read when the build is cancelled stays read.
void SnapshotBuilder::read_files(const CancelToken& cancel) {
  std::map<Path, prims::Edit*> last;
  for (prims::Edit& edit : edits_) last[edit.id] = &edit;
  std::vector<prims::Edit*> unread;
  for (const auto& [id, edit] : last)
    if (edit->read) unread.push_back(edit);
  const auto read_one = [&](prims::Edit* edit) {
    if (cancel.is_cancelled()) return;
    edit->record = edit->read();
    edit->read = nullptr;
  };
  param_->run([&] { tbb::parallel_for_each(unread, read_one); });
  cancel.check();
  edits_.remove_if([](const prims::Edit& edit) { return edit.read != nullptr; });
}

prims::SceneFaults SnapshotBuilder::faults() const {
  prims::SceneFaults all = meshes_.faults();
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
  for (; !edits_.empty(); edits_.pop_front()) {
    prims::Edit& edit = edits_.front();
    prims::Record& held = records_[edit.id];
    stale_ |= held != edit.record;
    held = std::move(edit.record);
    if (std::holds_alternative<std::monostate>(held)) records_.erase(edit.id);
  }
}

void SnapshotBuilder::update(const CancelToken& cancel) {
  read_files(cancel);
  apply_edits();
  const View view = view_;
  const auto last = built();
  const bool same_shutter = last && view.shutter == last->translation.shutter;
  stale_ |= meshes_.incomplete() || !meshes_.is_diced_by(view.dicing);
  if (!stale_ && same_shutter) return;
  stale_ = true;  // until all of it is done
  meshes_.build(records_, view.dicing, *param_, cancel);
  const auto start = std::chrono::steady_clock::now();
  prims::Translation translation = translator_.translate(records_, view.shutter, meshes_,
                                                         deformations_.in(view.shutter, meshes_, param_.get(), cancel));
  if (last && last->snapshot && translation.scene == last->translation.scene)
    publish(std::make_shared<const BuiltScene>(
        BuiltScene{std::move(translation), last->snapshot, faults()}));  // faults may differ, and paths
  else
    compile(std::move(translation), cancel);
  const std::chrono::duration<double> spent = std::chrono::steady_clock::now() - start;
  compile_seconds_ = compile_seconds_ + spent.count();
}

void SnapshotBuilder::compile(prims::Translation translation, const CancelToken& cancel) {
  BuiltScene scene{std::move(translation), nullptr, faults()};
  const auto run = [&] { scene.snapshot = compiler_.compile(scene.translation.scene, scene_number_ + 1, cancel); };
  // A scene that could not be compiled leaves no snapshot: the old one would pass for it.
  bool cancelled = false;
  prims::guarded(param_->sink(), "CommitResources", [&] {
    try {
      param_->run(run);
    } catch (const BuildCancelled&) {
      cancelled = true;
    }
  });
  if (cancelled) throw BuildCancelled();
  ++scene_number_;
  if (!scene.snapshot) compiler_.forget();
  const bool compiled = scene.snapshot != nullptr;
  publish(std::make_shared<const BuiltScene>(std::move(scene)));
  stale_ = !compiled;
}

void SnapshotBuilder::publish(std::shared_ptr<const BuiltScene> scene) {
  {
    const std::lock_guard lock(mutex_);
    if (built_) retired_.push_back(built_);
    built_ = std::move(scene);
  }
  stale_ = false;
  published_();
  destroy_retired();
}

// Passes hold snapshots, which hold most of what a scene is.
void SnapshotBuilder::destroy_retired() {
  std::vector<std::shared_ptr<const BuiltScene>> unused;
  const std::lock_guard guard(mutex_);
  const auto is_unused = [&](const std::shared_ptr<const BuiltScene>& scene) {
    const bool shared = scene->snapshot && built_ && scene->snapshot == built_->snapshot;
    return shared || !scene->snapshot || scene->snapshot.use_count() == 1;
  };
  for (auto& scene : retired_)
    if (is_unused(scene)) unused.push_back(std::move(scene));
  std::erase(retired_, nullptr);
}

}  // namespace alabaster::hd::rendering
