#include "core/geometry/edited_object.h"

#include <mutex>
#include <optional>
#include <utility>

#include "core/geometry/embree_object_scene.h"
#include "core/geometry/hierarchy_cost.h"

namespace alabaster {
namespace {

struct Refitted {
  Refitted(const std::shared_ptr<TraceDevice>& device, const Mesh& mesh, const CancelToken& cancel)
      : memory(memory_of(*device), MemoryUse::tracing, mesh.triangles.size() * kBuildBytes, "groups of triangles"),
        scene(device, mesh, EmbreeObjectScene::Use::refitted),
        groups(mesh, cancel),
        cost(groups.cost(mesh)) {
    memory.shrink(mesh.triangles.size() * sizeof(uint32_t));
  }
  bool fits(const Mesh& mesh, double worn) const {
    return scene.has_triangles_of(mesh) && groups.cost(mesh) <= worn * cost;
  }

  static constexpr size_t kBuildBytes = 16;  // of a triangle, for the groups while they are found
  MemoryReservation memory;
  EmbreeObjectScene scene;
  TriangleGroups groups;
  double cost;         // when it was built
  bool whole = false;  // else it was cancelled, or memory ran out
};

}  // namespace

// One at most. A BVH comes here when its last holder lets go of it, while somebody still edits the mesh.
struct EditedObject::Spares {
  std::mutex mutex;
  std::unique_ptr<Refitted> spare;
  bool resting = false;

  std::unique_ptr<Refitted> take() {
    const std::lock_guard lock(mutex);
    resting = false;
    return std::move(spare);
  }
  // The one before is destroyed outside of the lock.
  void put(std::unique_ptr<Refitted> unused) {
    const std::lock_guard lock(mutex);
    if (!resting && unused->whole) spare.swap(unused);
  }
};

EditedObject::EditedObject(double worn) : worn_(worn), spares_(std::make_shared<Spares>()) {}
EditedObject::~EditedObject() = default;

std::shared_ptr<const ObjectScene> EditedObject::build(const std::shared_ptr<TraceDevice>& device, const Mesh& mesh,
                                                       const CancelToken& cancel) {
  const auto cancelled = [cancel] { return cancel.is_cancelled(); };
  if (mesh.deforms() || mesh.triangles.empty()) return build_object_scene(device, mesh, cancelled);
  std::unique_ptr<Refitted> made = spares_->take();
  bool ready = made && made->fits(mesh, worn_) && made->scene.replace_points(mesh);
  if (!ready) {
    made = nullptr;  // before its successor takes memory
    made = std::make_unique<Refitted>(device, mesh, cancel);
    ready = made->scene.get() && made->scene.attach(mesh);
  }
  made->whole = false;
  const bool committed = ready && commit(made->scene.get(), cancelled);
  cancel.check();
  made->whole = !made->scene.take_error() && committed;
  if (!made->whole) return nullptr;
  // The way back.
  Refitted* const held = made.release();
  const auto give_back = [spares = std::weak_ptr(spares_)](Refitted* unused) {
    std::unique_ptr<Refitted> owned(unused);
    if (const auto kept = spares.lock()) kept->put(std::move(owned));
  };
  const std::shared_ptr<Refitted> shared(held, give_back);
  return std::shared_ptr<const ObjectScene>(shared, &shared->scene);
}

void EditedObject::rest() {
  std::unique_ptr<Refitted> unused;
  const std::lock_guard lock(spares_->mutex);
  spares_->resting = true;
  unused.swap(spares_->spare);
}

}  // namespace alabaster
