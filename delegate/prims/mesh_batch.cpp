#include "delegate/prims/mesh_batch.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <chrono>
#include <system_error>

#include "core/math/float_environment.h"

namespace alabaster::hd::prims {
namespace {

// Smaller batches react to a cancel within the time of a few frames, and need no thread of their own.
constexpr double kLargeFaces = 250e3;
constexpr std::chrono::milliseconds kLook(1);      // between looks at the caller's token
constexpr std::chrono::milliseconds kPatience(4);  // what is left costs memory, and the next build half of the cores

double faces_of(const PulledMesh& mesh) {
  return static_cast<double>(mesh.topology.faceVertexIndices.size()) / 4 *
         static_cast<double>(1 << (2 * refine_level(mesh)));
}

}  // namespace

MeshBatch::MeshBatch(std::vector<std::shared_ptr<const MeshJob>> jobs, SceneParam* param)
    : param_(param), items_(jobs.size()) {
  for (size_t i = 0; i < jobs.size(); ++i) items_[i].job = std::move(jobs[i]);
}

MeshBatch::~MeshBatch() {
  cancelled_ = true;
  if (thread_.joinable()) thread_.join();
}

bool MeshBatch::is_large() const {
  double faces = 0;
  for (const Item& item : items_)
    if (!item.job->shape) faces += faces_of(*item.job->source);
  return faces >= kLargeFaces;
}

bool MeshBatch::build(const CancelToken& cancel) {
  if (is_large()) {
    try {
      thread_ = std::thread([this] { run(); });
      return await(cancel);
    } catch (const std::system_error&) {
      // The system has no more threads.
    }
  }
  build_all(cancel);
  return true;
}

void MeshBatch::build_all(const CancelToken& cancel) {
  param_->run([&] { tbb::parallel_for(size_t(0), items_.size(), [&](size_t i) { build_one(&items_[i], cancel); }); });
}

void MeshBatch::build_one(Item* item, const CancelToken& cancel) {
  if (cancel.is_cancelled()) return;
  bool cancelled = false;
  MeshResult result;
  const auto keep = [&](const alabaster::Diagnostic& d) { result.failure = d; };
  const auto build = [&] {
    try {
      result = build_mesh_job(*item->job, param_, cancel);
    } catch (const BuildCancelled&) {
      cancelled = true;
    }
  };
  const bool built = guarded(keep, item->job->path.str(), build, "; the mesh is not drawn");
  if (cancelled) return;
  if (!built) result.built.fault = SceneFault{false, "the mesh could not be built"};
  item->result = std::move(result);
  item->ended.store(true, std::memory_order_release);
}

void MeshBatch::run() {
  const FloatEnvironment environment;
  std::exception_ptr error;
  try {
    build_all(CancelToken(&cancelled_));
  } catch (...) {
    error = std::current_exception();
  }
  {
    std::vector<Item> unasked;
    const std::lock_guard lock(mutex_);
    over_ = true;
    error_ = error;
    if (left_) unasked.swap(items_);
    over_changed_.notify_all();
  }
  ended_ = true;
}

// False: it was cancelled and has not ended.
bool MeshBatch::await(const CancelToken& cancel) {
  std::unique_lock lock(mutex_);
  const auto over = [&] { return over_; };
  while (!over_changed_.wait_for(lock, kLook, over)) {
    if (!cancel.is_cancelled()) continue;
    cancelled_ = true;
    if (!over_changed_.wait_for(lock, kPatience, over)) return false;
  }
  if (error_) std::rethrow_exception(error_);
  return true;
}

std::optional<MeshResult> MeshBatch::result(size_t job) {
  Item& item = items_[job];
  if (!item.ended.exchange(false, std::memory_order_acquire)) return std::nullopt;
  return std::move(item.result);
}

void MeshBatch::leave() {
  param_->leave_arena();
  const std::lock_guard lock(mutex_);
  left_ = true;
  if (over_) items_.clear();
}

}  // namespace alabaster::hd::prims
