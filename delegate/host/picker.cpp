#include "delegate/host/picker.h"

#include <algorithm>
#include <set>
#include <tuple>

namespace alabaster::hd::host {
namespace {

/// The ids that an AOV shows, the uppermost row first. Empty if it is not bound, or to a buffer of another format.
struct Ids {
  Vec2i size{0, 0};
  std::vector<int32_t> values;

  Ids(const RenderPassState& state, const char* aov) {
    for (const AovBinding& binding : state.aovBindings)
      if (binding.aovName == Token(aov) && binding.renderBuffer && binding.renderBuffer->GetFormat() == Format::int32)
        read(*binding.renderBuffer);
  }
  void read(RenderBuffer& buffer) {
    PixelMemory memory;
    memory.format = Format::int32;
    memory.size = {buffer.GetWidth(), buffer.GetHeight()};
    memory.rowBytes = size_t(memory.size.x) * sizeof(int32_t);
    values.resize(size_t(memory.size.x) * size_t(memory.size.y));
    memory.pixels = values.data();
    size = buffer.ResolveTo(&memory) ? memory.size : Vec2i(0);
  }
  int32_t at(int x, int y) const { return values[size_t(y) * size_t(size.x) + size_t(x)]; }
};

/// Takes a flattened number apart, from the innermost instancer outwards.
std::vector<PickedInstance> instances_of(SceneDelegate& scene, const Path& mesh, int32_t number) {
  std::vector<PickedInstance> instances;
  std::set<Path> seen;
  Path prototype = mesh;
  for (Path instancer = scene.GetInstancerId(mesh); !instancer.empty() && seen.insert(instancer).second;
       instancer = scene.GetInstancerId(instancer)) {
    const Array<int32_t> indices = scene.GetInstanceIndices(instancer, prototype);
    if (indices.empty()) break;
    const auto count = static_cast<int32_t>(indices.size());
    instances.push_back({instancer, indices[static_cast<size_t>(number % count)]});
    number /= count;
    prototype = instancer;
  }
  return instances;
}

}  // namespace

std::vector<PickHit> Pick(const RenderIndex& index, SceneDelegate& scene, const RenderPassState& state,
                          const Rect2i& rect) {
  const Ids prims(state, "primId"), numbers(state, "instanceId"), faces(state, "elementId");
  // Keep the nearest pixel of each face, by its doubled distance to the middle, squared.
  using Face = std::tuple<int32_t, int32_t, int32_t>;
  std::map<Face, std::tuple<double, int, int>> nearest;
  for (int y = std::max(rect.minY, 0); y < std::min(rect.maxY, prims.size.y); ++y)
    for (int x = std::max(rect.minX, 0); x < std::min(rect.maxX, prims.size.x); ++x) {
      const int32_t prim = prims.at(x, y);
      if (prim < 0) continue;
      const double dx = 2.0 * x + 1 - rect.minX - rect.maxX, dy = 2.0 * y + 1 - rect.minY - rect.maxY;
      const Face face(prim, numbers.size == prims.size ? std::max(numbers.at(x, y), 0) : 0,
                      faces.size == prims.size ? faces.at(x, y) : -1);
      const std::tuple found(dx * dx + dy * dy, y, x);
      const auto [held, is_new] = nearest.emplace(face, found);
      if (!is_new) held->second = std::min(held->second, found);
    }
  std::vector<std::pair<std::tuple<double, int, int>, Face>> ordered;
  for (const auto& [face, where] : nearest) ordered.emplace_back(where, face);
  std::sort(ordered.begin(), ordered.end());

  std::vector<PickHit> hits;
  for (const auto& [where, face] : ordered) {
    const auto [prim, number, element] = face;
    const Path path = index.GetRprimPathFromPrimId(prim);
    if (path.empty()) continue;  // gone since
    hits.push_back({path, number, instances_of(scene, path, number), element, std::get<2>(where), std::get<1>(where)});
  }
  return hits;
}

}  // namespace alabaster::hd::host
