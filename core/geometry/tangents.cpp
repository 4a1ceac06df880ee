#include "core/geometry/tangents.h"

#include <tbb/parallel_sort.h>
#include <tbb/task_arena.h>

#include <bit>
#include <cmath>

namespace alabaster {
namespace {

// Corners that share a tangent have these in common: bits of position, normal and uv (both zeros are one), winding in
// uv.
struct Corner {
  std::array<uint32_t, 9> key{};
  uint32_t index = 0;  // 3 * triangle + corner
  bool operator<(const Corner& o) const { return key != o.key ? key < o.key : index < o.index; }
};

uint32_t bits(float x) {
  return std::bit_cast<uint32_t>(x + 0.0f);
}

class TangentBuilder {
 public:
  TangentBuilder(const Mesh& mesh, const MeshAttribute<Vec2f>& uvs) : mesh_(mesh), uvs_(uvs) {}

  MeshAttribute<Vec4f> run() {
    std::vector<Corner> corners(3 * mesh_.triangles.size());
    for (uint32_t i = 0; i < corners.size(); ++i) corners[i] = make_corner(i / 3, i % 3);
    tbb::parallel_sort(corners.begin(), corners.end());
    MeshAttribute<Vec4f> tangents;
    tangents.triangles.resize(mesh_.triangles.size());
    for (size_t first = 0; first < corners.size();) {
      size_t end = first;
      Vec3d sum(0, 0, 0);
      for (; end < corners.size() && corners[end].key == corners[first].key; ++end) {
        const uint32_t index = corners[end].index;
        sum += weighted_tangent(index / 3, index % 3);
        tangents.triangles[index / 3][index % 3] = static_cast<uint32_t>(tangents.values.size());
      }
      const double l = length(sum);
      const Vec3d t = l > 0 ? sum / l : Vec3d(0, 0, 0);
      const float sign = corners[first].key.back() ? 1.0f : -1.0f;
      tangents.values.emplace_back(float(t.x), float(t.y), float(t.z), sign);
      first = end;
    }
    return tangents;
  }

 private:
  Vec3d point(uint32_t triangle, uint32_t corner) const {
    return Vec3d(mesh_.points[mesh_.triangles[triangle][corner % 3]]);
  }
  const Vec2f& uv(uint32_t triangle, uint32_t corner) const {
    const Corners& c = uvs_.triangles.empty() ? mesh_.triangles[triangle] : uvs_.triangles[triangle];
    return uvs_.values[c[corner]];
  }
  Vec3d normal(uint32_t triangle, uint32_t corner) const {
    if (mesh_.normals.empty())
      return cross(point(triangle, 1) - point(triangle, 0), point(triangle, 2) - point(triangle, 0));
    const Corners& c = mesh_.normal_triangles.empty() ? mesh_.triangles[triangle] : mesh_.normal_triangles[triangle];
    return Vec3d(mesh_.normals[c[corner]]);
  }
  double uv_area(uint32_t triangle) const {
    const Vec2f &a = uv(triangle, 0), b = uv(triangle, 1) - a, c = uv(triangle, 2) - a;
    return double(b.x) * double(c.y) - double(c.x) * double(b.y);
  }

  Corner make_corner(uint32_t triangle, uint32_t corner) const {
    const Vec3f& p = mesh_.points[mesh_.triangles[triangle][corner]];
    const Vec3f n(normal(triangle, corner));
    const Vec2f& t = uv(triangle, corner);
    return {{bits(p.x), bits(p.y), bits(p.z), bits(n.x), bits(n.y), bits(n.z), bits(t.x), bits(t.y),
             uv_area(triangle) >= 0 ? 1u : 0u},
            3 * triangle + corner};
  }

  static Vec3d across(const Vec3d& v, const Vec3d& n) { return v - n * (dot(v, n) / dot(n, n)); }

  // The triangle's direction of u in the plane across the corner's normal, times its angle there.
  Vec3d weighted_tangent(uint32_t triangle, uint32_t corner) const {
    const Vec3d n = normal(triangle, corner);
    if (!(dot(n, n) > 0)) return Vec3d(0, 0, 0);
    const Vec3d e1 = point(triangle, 1) - point(triangle, 0), e2 = point(triangle, 2) - point(triangle, 0);
    const Vec2f d1 = uv(triangle, 1) - uv(triangle, 0), d2 = uv(triangle, 2) - uv(triangle, 0);
    const double area = uv_area(triangle);
    if (area == 0) return Vec3d(0, 0, 0);
    const Vec3d t = across((e1 * double(d2.y) - e2 * double(d1.y)) * std::copysign(1.0, area), n);
    const Vec3d a = across(point(triangle, corner + 1) - point(triangle, corner), n);
    const Vec3d b = across(point(triangle, corner + 2) - point(triangle, corner), n);
    const double angle = std::atan2(length(cross(a, b)), dot(a, b)), l = length(t);
    return l > 0 && std::isfinite(angle) ? t * (angle / l) : Vec3d(0, 0, 0);
  }

  const Mesh& mesh_;
  const MeshAttribute<Vec2f>& uvs_;
};

}  // namespace

MeshAttribute<Vec4f> compute_tangents(const Mesh& mesh, const MeshAttribute<Vec2f>& uvs) {
  return TangentBuilder(mesh, uvs).run();
}

namespace {

size_t bytes_of(const MeshAttribute<Vec4f>& tangents) {
  return tangents.values.capacity() * sizeof(Vec4f) + tangents.triangles.capacity() * sizeof(Corners);
}

}  // namespace

TangentCache::Counted TangentCache::compute(const Mesh& mesh, const MeshAttribute<Vec2f>& uvs, const Axes* axes) const {
  constexpr size_t kBuildBytes = 276;  // of a triangle: its corners while they are sorted, and tangents while they grow
  const size_t triangles = mesh.triangles.size();
  const size_t turned_bytes = axes ? uvs.values.size() * sizeof(Vec2f) + uvs.triangles.size() * sizeof(Corners) : 0;
  Counted counted{{},
                  {budget_, MemoryUse::meshes, kBuildBytes * triangles + turned_bytes,
                   "the tangents of a mesh of " + std::to_string(triangles) + " triangles"}};
  MeshAttribute<Vec2f> turned;
  if (axes) {
    const auto& [u, v] = *axes;
    turned = uvs;
    for (Vec2f& st : turned.values) st = {u.x * st.x + u.y * st.y, v.x * st.x + v.y * st.y};
  }
  // A thread that waits for the sort must not take up a task that asks for the lock of the cache.
  tbb::this_task_arena::isolate([&] { counted.tangents = compute_tangents(mesh, axes ? turned : uvs); });
  counted.memory.shrink(bytes_of(counted.tangents));
  return counted;
}

// Positive scales do not change directions. A map of area 0 has no directions, so the plain ones are used.
bool TangentCache::turns(const Axes& axes) {
  const auto& [u, v] = axes;
  const float area = u.x * v.y - u.y * v.x;
  return std::isfinite(area) && area != 0 && !(u.x > 0 && v.y > 0 && u.y == 0 && v.x == 0);
}

TangentCache::Tangents TangentCache::of(const Mesh& mesh, const UvSetName& uv_set, const Axes& axes) const {
  if (!mesh.tangents.empty()) return {std::shared_ptr<const void>(), &mesh.tangents};
  const UvSet* const uvs = mesh.uv_set(uv_set);
  if (!uvs) return nullptr;
  std::string key = uv_set.text();
  const bool turned = turns(axes);
  if (turned)
    for (const Vec2f& axis : axes)
      for (const float part : {axis.x, axis.y}) key += '\n' + std::to_string(std::bit_cast<uint32_t>(part));
  const std::scoped_lock lock(mutex_);
  const auto found = computed_.find(key);
  std::shared_ptr<const Counted> counted = found == computed_.end() ? nullptr : found->second.lock();
  if (!counted) {
    std::erase_if(computed_, [](const auto& entry) { return entry.second.expired(); });
    counted = std::make_shared<const Counted>(compute(mesh, *uvs, turned ? &axes : nullptr));
    computed_[key] = counted;
  }
  return {counted, &counted->tangents};
}

size_t TangentCache::memory_bytes() const {
  const std::scoped_lock lock(mutex_);
  size_t bytes = 0;
  for (const auto& [name, held] : computed_)
    if (const std::shared_ptr<const Counted> counted = held.lock()) bytes += bytes_of(counted->tangents);
  return bytes;
}

}  // namespace alabaster
