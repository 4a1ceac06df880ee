#include "core/subsurface/mesh_interior.h"

#include <tbb/task_arena.h>

namespace alabaster {
namespace {

// Both builds run parallel loops under the lock. A thread that waits for its part of one must not take up another task
// meanwhile: that task may ask for the same part of the same mesh, and would wait for its own thread.
template <class T, class Build>
const T& build_once(std::mutex* mutex, std::optional<T>* part, const Build& build) {
  const std::scoped_lock lock(*mutex);
  if (!*part) tbb::this_task_arena::isolate([&] { part->emplace(build()); });
  return **part;
}

}  // namespace

const MeshShells& MeshInterior::shells(const Mesh& mesh, const ObjectScene& object) const {
  return build_once(&mutex_, &shells_, [&] { return find_shells(mesh, object); });
}

const DistanceGrid* MeshInterior::distances(const Mesh& mesh) const {
  constexpr uint32_t kResolution = 128;  // 2 MB at most
  return build_once(&mutex_, &grid_, [&] { return build_distance_grid(mesh, kResolution); }).get();
}

}  // namespace alabaster
