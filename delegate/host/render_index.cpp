#include "delegate/host/render_index.h"

#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <set>
#include <type_traits>
#include <unordered_map>

#include "core/math/float_environment.h"
#include "delegate/support/lookup.h"

namespace alabaster::hd::host {
namespace {

enum class PrimType { rprim, sprim, bprim, instancer };

struct Entry {
  PrimType kind = PrimType::rprim;
  Token type;
  SceneDelegate* scene = nullptr;
  Prim* prim = nullptr;  // of an R-, S- or Bprim
  Instancer* instancer = nullptr;
  bool visible = true;  // of an rprim, as last pulled
};

/// A host that throws here throws again when the prim asks, and the prim reports it.
bool pull_visible(const Entry& entry, const Path& id) {
  try {
    return entry.scene->GetVisible(id);
  } catch (...) {
    return true;
  }
}

/// Runs `body`, which may run out of memory or threads. Returns false if it did.
template <class Body>
bool succeeds(const Body& body) noexcept {
  try {
    return body();
  } catch (...) {
    return false;
  }
}

/// One prim of a Sync. Its bits are read before the parallel part and written after it: the tracker needs no lock.
struct Work {
  Path id;
  Entry* entry = nullptr;
  DirtyBits bits = dirty::kClean;
};

}  // namespace

struct RenderIndex::State {
  explicit State(RenderDelegate* d) : delegate(d) {}

  RenderDelegate* delegate;
  ChangeTracker tracker;
  std::map<Path, Entry> entries;
  std::unordered_map<int32_t, Path> path_of_prim_id;
  std::set<int32_t> free_prim_ids;
  int32_t next_prim_id = 0;
  uint64_t synced_version = 0;
  bool queued = false;  // a Sync left bits behind (invisible or unfinished prims)
  std::unique_ptr<tbb::task_arena> arena;
  int arena_threads = -1;

  /// Enters what the delegate has made. Returns false if it has made none (null), or memory ran out.
  template <class Made>
  bool insert(const Path& id, Entry entry, Made* made, void (RenderDelegate::*destroy_made)(Made*));
  int32_t take_prim_id(const Path& id);
  void destroy(const Entry& entry);
  std::vector<Work> dirty_of(PrimType kind, const Token& type);
  void sync_one(Work& work) const;
  tbb::task_arena& sync_arena();
  void sync_kind(PrimType kind, const Token& type, bool parallel);
  void sync_dirty();
};

template <class Made>
bool RenderIndex::State::insert(const Path& id, Entry entry, Made* made, void (RenderDelegate::*destroy_made)(Made*)) {
  if (!made) return false;
  const auto entered = [&] {
    if constexpr (std::is_same_v<Made, Instancer>) {
      entry.instancer = made;
      tracker.MarkDirty(id, dirty::kAll);
    } else {
      entry.prim = made;
      if constexpr (std::is_same_v<Made, Rprim>) made->SetPrimId(take_prim_id(id));
      tracker.MarkDirty(id, made->GetInitialDirtyBitsMask());
    }
    entries.emplace(id, entry);  // last, so that a failure above leaves no entry
    return true;
  };
  if (succeeds(entered)) return true;
  (delegate->*destroy_made)(made);
  return false;
}

// Takes the lowest free number: ids stay small (24 bits) however many prims come and go.
int32_t RenderIndex::State::take_prim_id(const Path& id) {
  int32_t number = next_prim_id;
  if (free_prim_ids.empty()) {
    ++next_prim_id;
  } else {
    number = *free_prim_ids.begin();
    free_prim_ids.erase(free_prim_ids.begin());
  }
  path_of_prim_id[number] = id;
  return number;
}

void RenderIndex::State::destroy(const Entry& entry) {
  RenderParam* param = delegate->GetRenderParam();
  if (entry.kind == PrimType::instancer) {
    entry.instancer->Finalize(param);
    delegate->DestroyInstancer(entry.instancer);
    return;
  }
  entry.prim->Finalize(param);
  if (entry.kind == PrimType::rprim) {
    auto* rprim = static_cast<Rprim*>(entry.prim);
    path_of_prim_id.erase(rprim->GetPrimId());
    succeeds([&] { return free_prim_ids.insert(rprim->GetPrimId()).second; });  // on failure only the number is lost
    delegate->DestroyRprim(rprim);
  } else if (entry.kind == PrimType::sprim) {
    delegate->DestroySprim(static_cast<Sprim*>(entry.prim));
  } else {
    delegate->DestroyBprim(static_cast<Bprim*>(entry.prim));
  }
}

std::vector<Work> RenderIndex::State::dirty_of(PrimType kind, const Token& type) {
  std::vector<Work> work;
  for (const auto& [id, bits] : tracker.GetDirty()) {
    const auto found = entries.find(id);
    if (found == entries.end() || found->second.kind != kind || !(found->second.type == type)) continue;
    work.push_back({id, &found->second, bits});
  }
  return work;
}

void RenderIndex::State::sync_one(Work& work) const {
  Entry& entry = *work.entry;
  RenderParam* param = delegate->GetRenderParam();
  if (entry.kind == PrimType::instancer) return entry.instancer->Sync(entry.scene, param, &work.bits);
  if (entry.kind != PrimType::rprim) return entry.prim->Sync(entry.scene, param, &work.bits);

  if (work.bits & dirty::kVisibility) entry.visible = pull_visible(entry, work.id);
  if (entry.visible) return entry.prim->Sync(entry.scene, param, &work.bits);
  // An invisible prim's geometry is pulled and refined only once it is visible.
  DirtyBits now = work.bits & dirty::kVisibility;
  const DirtyBits later = work.bits & ~dirty::kVisibility;
  if (now) entry.prim->Sync(entry.scene, param, &now);
  work.bits = now | later;
}

// Waiting inside the host's own arena could run, or wait for, tasks of the host's.
tbb::task_arena& RenderIndex::State::sync_arena() {
  const double wanted = delegate->GetRenderSetting("threads").number_or(0);
  // More threads than the process may have would make TBB print a warning.
  const auto allowed = double(tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism));
  const int threads = wanted >= 1 ? static_cast<int>(std::min(wanted, allowed)) : tbb::task_arena::automatic;
  if (!arena || arena_threads != threads) {
    arena = std::make_unique<tbb::task_arena>(threads);
    arena_threads = threads;
  }
  return *arena;
}

void RenderIndex::State::sync_kind(PrimType kind, const Token& type, bool parallel) {
  std::vector<Work> work = dirty_of(kind, type);
  if (work.empty()) return;
  if (parallel && work.size() > 1) {
    sync_arena().execute([&] {
      tbb::parallel_for(
          size_t(0), work.size(), [&](size_t i) { sync_one(work[i]); }, tbb::simple_partitioner());
    });
  } else {
    for (Work& one : work) sync_one(one);
  }
  for (const Work& one : work) {
    tracker.Set(one.id, one.bits);
    queued = queued || one.bits != dirty::kClean;
  }
}

RenderIndex::RenderIndex(RenderDelegate* delegate) : state_(std::make_unique<State>(delegate)) {}

RenderIndex::~RenderIndex() {
  for (const auto& [id, entry] : state_->entries) state_->destroy(entry);
}

bool RenderIndex::InsertRprim(const Token& type, SceneDelegate* scene, const Path& id) {
  const Entry entry{.kind = PrimType::rprim, .type = type, .scene = scene};
  return !Has(id) && state_->insert(id, entry, state_->delegate->CreateRprim(type, id), &RenderDelegate::DestroyRprim);
}

bool RenderIndex::InsertSprim(const Token& type, SceneDelegate* scene, const Path& id) {
  const Entry entry{.kind = PrimType::sprim, .type = type, .scene = scene};
  return !Has(id) && state_->insert(id, entry, state_->delegate->CreateSprim(type, id), &RenderDelegate::DestroySprim);
}

bool RenderIndex::InsertBprim(const Token& type, SceneDelegate* scene, const Path& id) {
  const Entry entry{.kind = PrimType::bprim, .type = type, .scene = scene};
  return !Has(id) && state_->insert(id, entry, state_->delegate->CreateBprim(type, id), &RenderDelegate::DestroyBprim);
}

bool RenderIndex::InsertInstancer(SceneDelegate* scene, const Path& id) {
  const Entry entry{.kind = PrimType::instancer, .type = Token(), .scene = scene};
  return !Has(id) &&
         state_->insert(id, entry, state_->delegate->CreateInstancer(id), &RenderDelegate::DestroyInstancer);
}

void RenderIndex::Remove(const Path& id) {
  const auto found = state_->entries.find(id);
  if (found == state_->entries.end()) return;
  state_->destroy(found->second);
  state_->entries.erase(found);
  state_->tracker.Remove(id);
}

bool RenderIndex::Has(const Path& id) const {
  return state_->entries.contains(id);
}

Sprim* RenderIndex::GetSprim(const Path& id) const {
  const Entry* entry = support::find_in(state_->entries, id);
  return entry && entry->kind == PrimType::sprim ? static_cast<Sprim*>(entry->prim) : nullptr;
}

Bprim* RenderIndex::GetBprim(const Path& id) const {
  const Entry* entry = support::find_in(state_->entries, id);
  return entry && entry->kind == PrimType::bprim ? static_cast<Bprim*>(entry->prim) : nullptr;
}

Path RenderIndex::GetRprimPathFromPrimId(int32_t prim_id) const {
  return support::value_in(state_->path_of_prim_id, prim_id);
}

ChangeTracker& RenderIndex::GetChangeTracker() {
  return state_->tracker;
}

RenderDelegate* RenderIndex::GetRenderDelegate() const {
  return state_->delegate;
}

void RenderIndex::State::sync_dirty() {
  for (const Token& type : delegate->GetSupportedBprimTypes()) sync_kind(PrimType::bprim, type, false);
  // Sync of Sprims only copies values: the builder decodes images. Hosts expect them one at a time.
  for (const Token& type : delegate->GetSupportedSprimTypes()) sync_kind(PrimType::sprim, type, false);
  sync_kind(PrimType::instancer, Token(), false);
  for (const Token& type : delegate->GetSupportedRprimTypes()) sync_kind(PrimType::rprim, type, true);
}

bool RenderIndex::SyncAll() {
  const FloatEnvironment environment;
  State& s = *state_;
  bool synced = true;
  if (s.queued || s.synced_version != s.tracker.GetVersion()) {
    s.queued = false;
    s.synced_version = s.tracker.GetVersion();
    synced = succeeds([&] { return s.sync_dirty(), true; });
    s.queued = s.queued || !synced;
  }
  s.delegate->CommitResources();
  return synced;
}

}  // namespace alabaster::hd::host
