#include "core/geometry/bounds_tree.h"

#include "core/geometry/embree_handle.h"

namespace alabaster {
namespace {

class EmbreeBoundsTree final : public BoundsTree {
 public:
  EmbreeBoundsTree(std::shared_ptr<TraceDevice> device, std::vector<Bounds> boxes)
      : boxes_(std::move(boxes)), scene_(std::move(device), "a hierarchy of the meshes of a subsurfaceSet") {}

  bool build(const std::function<bool()>& cancelled) {
    return scene_.get() && attach(scene_, {&boxes_, boxes_.size(), &bound, nullptr, nullptr}) &&
           commit(scene_.get(), cancelled) && !scene_.take_error();
  }

  bool any_at(const Vec3f& p, Visit visit, void* data) const override {
    if (!is_finite(p)) return false;
    Query query{boxes_, visit, data};
    RTCPointQuery at{p.x, p.y, p.z, 0, 0};  // members: point, time, radius
    RTCPointQueryContext context;
    rtcInitPointQueryContext(&context);
    rtcPointQuery(scene_.get(), &at, &context, &ask, &query);
    return query.found;
  }

 private:
  struct Query {
    const std::vector<Bounds>& boxes;
    Visit visit;
    void* data;
    bool found = false;
  };
  static bool ask(RTCPointQueryFunctionArguments* args) noexcept {
    auto& query = *static_cast<Query*>(args->userPtr);
    const Vec3f p(args->query->x, args->query->y, args->query->z);
    if (!query.found && query.boxes[args->primID].contains(p)) query.found = query.visit(query.data, args->primID);
    return false;  // the radius stays
  }
  static void bound(const RTCBoundsFunctionArguments* args) noexcept {
    const Bounds& b = (*static_cast<const std::vector<Bounds>*>(args->geometryUserPtr))[args->primID];
    *args->bounds_o = {b.lower.x, b.lower.y, b.lower.z, 0, b.upper.x, b.upper.y, b.upper.z, 0};
  }

  std::vector<Bounds> boxes_;
  SceneHandle scene_;
};

}  // namespace

std::shared_ptr<const BoundsTree> build_bounds_tree(const std::shared_ptr<TraceDevice>& device,
                                                    std::vector<Bounds> boxes, const std::function<bool()>& cancelled) {
  auto tree = std::make_shared<EmbreeBoundsTree>(device, std::move(boxes));
  return tree->build(cancelled) ? tree : nullptr;
}

}  // namespace alabaster
