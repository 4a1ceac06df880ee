#include "core/subsurface/shells.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <numeric>

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include "core/geometry/box_tree.h"

namespace alabaster {
namespace {

class ShellFinder {
 public:
  ShellFinder(const Mesh& mesh, const ObjectScene& object, const CancelToken& cancel, ShellTopologyCache* cache)
      : cancel_(cancel),
        mesh_(mesh),
        object_(object),
        topology_(cache ? cache->get(weld(), mesh.points.size(), cancel)
                        : find_shell_topology(weld(), mesh.points.size(), cancel)),
        volumes_(shells_.size(), 0),
        areas_(shells_.size(), 0) {}

  MeshShells find() {
    cancel_.check();
    orient();
    cancel_.check();
    write_flags();
    if (out_.any_closed) {
      find_thinnest();
      find_cavities();
      out_.overlapping =
          topology_->has_walls || (mesh_.deforms() && shells_.size() > 1) || overlaps() || shells_cross();
    }
    auto& flags = out_.triangle_flags;
    if (std::all_of(flags.begin(), flags.end(), [](uint8_t f) { return f == 0; })) flags = {};
    return std::move(out_);
  }

 private:
  static constexpr auto kSingle = ShellTopology::kSingle, kDegenerate = ShellTopology::kDegenerate;
  static constexpr uint32_t kNone = ShellTopology::kNone;

  // Welded. Triangles whose points coincide have no area.
  std::vector<WeldedCorners> weld() const {
    const std::vector<int> first = weld_by_position(mesh_.points, cancel_);
    std::vector<WeldedCorners> corners;
    corners.reserve(mesh_.triangles.size());
    for (const auto& t : mesh_.triangles)
      corners.push_back(
          {static_cast<uint32_t>(first[t[0]]), static_cast<uint32_t>(first[t[1]]), static_cast<uint32_t>(first[t[2]])});
    return corners;
  }

  // About the centre of the mesh, so that digits do not go where it stands.
  void orient() {
    const Vec3d centre(mesh_.bounds.center());
    for (uint32_t t = 0; t < corners_.size(); ++t) {
      cancel_.check();
      if (kind_[t] != kSingle) continue;
      const auto p = [&](size_t i) { return Vec3d(mesh_.points[corners_[t][i]]) - centre; };
      const double volume = dot(p(0), cross(p(1), p(2)));
      volumes_[shell_[t]] += turned_[t] ? -volume : volume;
      areas_[shell_[t]] += length(cross(p(1) - p(0), p(2) - p(0)));
    }
  }

  void write_flags() {
    out_.triangle_flags.assign(corners_.size(), 0);
    for (uint32_t t = 0; t < corners_.size(); ++t) {
      if (kind_[t] == kDegenerate) continue;
      const uint32_t s = shell_[t];
      uint8_t& flags = out_.triangle_flags[t];
      if (turned_[t] != (volumes_[s] < 0)) flags |= MeshShells::kReversed;
      if (inner_[s])
        flags = MeshShells::kInner;
      else if (open_[s])
        flags |= MeshShells::kOpen;
      (open_[s] ? out_.any_open : out_.any_closed) |= !inner_[s];
    }
  }

  void find_thinnest() {
    for (uint32_t s = 0; s < shells_.size(); ++s) {
      if (open_[s] || inner_[s] || !(areas_[s] > 0)) continue;
      const auto thickness = static_cast<float>(2.0 / 3 * std::abs(volumes_[s]) / areas_[s]);
      if (thickness < out_.least_thickness) out_.least_thickness = thickness, out_.thinnest = shells_[s].some.front();
    }
  }

  // The point `beyond` triangle t on its outer side, and the way out.
  Vec3f outside(uint32_t t, const Vec2f& u, Vec3f* out) const {
    const float root = std::sqrt(u.x);
    TriangleHit hit;
    hit.triangle = t;
    hit.u = 1 - root;
    hit.v = u.y * root;
    const SurfacePoint s = surface_point(mesh_, hit, Affine(), Affine());
    *out = out_.flags(t) & MeshShells::kReversed ? -s.ng_object : s.ng_object;
    return offset_point(s.p_object, *out, s.offset_object);
  }

  // The closed shells that contain p; those of `except` do not count.
  int winding(const Vec3f& p, const Vec3f& direction, uint32_t except) const {
    return winding_number(mesh_, out_, object_, {p, direction}, [&](uint32_t t) { return shell_[t] != except; });
  }

  bool is_nested(uint32_t s) const {
    for (uint32_t t : shells_[s].some) {
      cancel_.check();
      Vec3f out;
      const Vec3f p = outside(t, {4.0f / 9, 0.5f}, &out);  // the centroid
      if (winding(p, out, s) < 1) return false;
    }
    return true;
  }

  // The largest shell shows how the mesh is meant to wind.
  void find_cavities() {
    uint32_t largest = kNone;
    const auto closed = [&](uint32_t s) { return !open_[s] && !inner_[s]; };
    for (uint32_t s = 0; s < shells_.size(); ++s)
      if (closed(s) && (largest == kNone || std::abs(volumes_[s]) > std::abs(volumes_[largest]))) largest = s;
    std::vector<bool> cavity(shells_.size(), false);
    for (uint32_t s = 0; s < shells_.size(); ++s)
      cavity[s] = largest != kNone && closed(s) && volumes_[s] * volumes_[largest] < 0 && is_nested(s);
    for (uint32_t t = 0; t < corners_.size(); ++t)
      if (shell_[t] != kNone && cavity[shell_[t]]) out_.triangle_flags[t] ^= MeshShells::kReversed;
  }

  // Looks at points over all of the mesh, and over each shell: a small one may have none of the former.
  bool overlaps() const {
    constexpr size_t kOfMesh = 4096, kOfShell = 16, kOfShells = 65536;
    std::vector<uint32_t> order(corners_.size());
    std::iota(order.begin(), order.end(), 0u);
    std::stable_sort(order.begin(), order.end(), [&](uint32_t a, uint32_t b) { return shell_[a] < shell_[b]; });
    std::vector<double> area(order.size() + 1, 0);
    std::vector<std::array<size_t, 2>> parts;  // of `order`
    for (size_t i = 0; i < order.size(); ++i) {
      const auto& c = corners_[order[i]];
      const Vec3d p(mesh_.points[c[0]]);
      area[i + 1] = area[i] + length(cross(Vec3d(mesh_.points[c[1]]) - p, Vec3d(mesh_.points[c[2]]) - p));
      if (i == 0 || shell_[order[i]] != shell_[order[i - 1]]) parts.push_back({i, i});
      parts.back()[1] = i + 1;
    }
    std::atomic<bool> found = false;
    const auto look = [&](const std::array<size_t, 2>& part, size_t i, size_t count) {
      cancel_.check();
      const double first = area[part[0]], all = area[part[1]] - first;
      const double at = first + all * (static_cast<double>(i) + 0.5) / static_cast<double>(count);
      const auto above = std::upper_bound(area.begin(), area.end(), at);
      if (!(all > 0) || above == area.end() || above == area.begin()) return;
      const double u = (at - above[-1]) / (*above - above[-1]);
      const uint32_t t = order[size_t(above - area.begin() - 1)];
      if (lies_inside(t, {static_cast<float>(u), radical_inverse(static_cast<uint32_t>(i))})) found = true;
    };
    tbb::parallel_for(tbb::blocked_range<size_t>(0, kOfMesh, 64), [&](const tbb::blocked_range<size_t>& range) {
      for (size_t i = range.begin(); i < range.end() && !found; ++i) look({0, order.size()}, i, kOfMesh);
    });
    if (shells_.size() < 2) return found;
    const size_t of_shell = std::clamp(kOfShells / shells_.size(), size_t(1), kOfShell);
    tbb::parallel_for(size_t(0), parts.size(), [&](size_t part) {
      if (shell_[order[parts[part][0]]] == kNone) return;
      for (size_t i = 0; i < of_shell && !found; ++i) look(parts[part], i, of_shell);
    });
    return found;
  }

  // True if an edge of some shell goes through the surface of another one that is closed.
  bool shells_cross() const {
    if (shells_.size() < 2) return false;
    std::vector<Bounds> boxes(shells_.size());
    for (uint32_t t = 0; t < corners_.size(); ++t)
      if (is_wall(t))
        for (const uint32_t corner : corners_[t]) boxes[shell_[t]].extend(mesh_.points[corner]);
    std::vector<uint32_t> closed;
    std::vector<Bounds> of_closed;
    for (uint32_t s = 0; s < shells_.size(); ++s)
      if (!open_[s] && !boxes[s].empty()) closed.push_back(s), of_closed.push_back(boxes[s]);
    const BoxTree tree(std::move(of_closed));
    std::atomic<bool> found = false;
    tbb::parallel_for(
        tbb::blocked_range<uint32_t>(0, static_cast<uint32_t>(corners_.size()), 256),
        [&](const tbb::blocked_range<uint32_t>& range) {
          cancel_.check();
          for (uint32_t t = range.begin(); t < range.end() && !found; ++t) {
            if (!is_wall(t)) continue;
            Bounds box;
            for (const uint32_t corner : corners_[t]) box.extend(mesh_.points[corner]);
            bool near = false;
            tree.search([&](const Bounds& b) { return !near && overlap(b, box); },
                        [&](uint32_t i) { near = near || closed[i] != shell_[t]; });
            for (size_t e = 0; near && e < 3 && !found; ++e)
              if (goes_into_another(t, mesh_.points[corners_[t][e]], mesh_.points[corners_[t][(e + 1) % 3]]))
                found = true;
          }
        });
    return found;
  }

  // The edge from p to q of triangle t. It must reach deeper than its own corners are rounded.
  bool goes_into_another(uint32_t t, const Vec3f& p, const Vec3f& q) const {
    constexpr float kBesideCorners = 0x1p-10f;  // where it meets its neighbours
    const float reach = length(q - p);
    if (!(reach > 0)) return false;
    Ray ray{p + (q - p) * kBesideCorners, (q - p) / reach, reach * (1 - 2 * kBesideCorners)};
    TriangleHit hit;
    for (int i = 0; i < kMaxCrossings && ray.tmax > 0 && object_.intersect(ray, &hit); ++i) {
      const Crossed crossed = cross_surface(mesh_, out_, hit, ray.dir);
      if (shell_[hit.triangle] != shell_[t] && crossed.crossing() != 0) {
        const SurfacePoint s = surface_point(mesh_, hit, Affine(), Affine());
        const float depth = std::abs(dot(s.ng_object, (crossed.leaves ? p : q) - s.p_object));
        if (depth > 4 * s.offset_object) return true;
      }
      ray.tmax -= hit.t;
      ray.org = crossed.beyond;
    }
    return false;
  }

  bool is_wall(uint32_t t) const { return kind_[t] != kDegenerate && shell_[t] != kNone && !inner_[shell_[t]]; }

  // True for a point of the surface that a closed shell of the mesh contains.
  bool lies_inside(uint32_t t, const Vec2f& u) const {
    if (kind_[t] == kDegenerate || out_.flags(t) & MeshShells::kInner) return false;
    Vec3f out;
    const Vec3f p = outside(t, u, &out);
    return winding(p, out, kNone) > 0;
  }

  static float radical_inverse(uint32_t i) {
    float value = 0, digit = 0.5f;
    for (; i; i >>= 1, digit *= 0.5f) value += static_cast<float>(i & 1) * digit;
    return value;
  }

  const CancelToken cancel_;
  const Mesh& mesh_;
  const ObjectScene& object_;
  const std::shared_ptr<const ShellTopology> topology_;
  const std::vector<WeldedCorners>& corners_ = topology_->corners;
  const std::vector<ShellTopology::Kind>& kind_ = topology_->kind;
  const std::vector<bool>& turned_ = topology_->turned;
  const std::vector<uint32_t>& shell_ = topology_->shell;
  const std::vector<ShellTopology::Shell>& shells_ = topology_->shells;
  const std::vector<bool>&open_ = topology_->open, &inner_ = topology_->inner;
  std::vector<double> volumes_;  // six times those of shells, signed, by the winding of their first triangle
  std::vector<double> areas_;    // twice those of shells
  MeshShells out_;
};

}  // namespace

MeshShells find_shells(const Mesh& mesh, const ObjectScene& object, const CancelToken& cancel,
                       ShellTopologyCache* cache) {
  return ShellFinder(mesh, object, cancel, cache).find();
}

Crossed cross_surface(const Mesh& mesh, const MeshShells& shells, const TriangleHit& hit, const Vec3f& direction) {
  const SurfacePoint s = surface_point(mesh, hit, Affine(), Affine());
  const float side = dot(s.ng_object, direction) >= 0 ? 1.0f : -1.0f;
  return {shells.flags(hit.triangle), leaves(mesh, shells, hit, direction),
          offset_point(s.p_object, s.ng_object * side, s.offset_object)};
}

bool leaves(const Mesh& mesh, const MeshShells& shells, const TriangleHit& hit, const Vec3f& direction) {
  const auto [p, p1, p2] = mesh.corners_at(hit.triangle, hit.time);
  // In double: the product of three lengths, of which a scene may have large and small ones.
  const double along = dot(Vec3d(direction), cross(Vec3d(p1 - p), Vec3d(p2 - p)));
  return (along >= 0) != ((shells.flags(hit.triangle) & MeshShells::kReversed) != 0);
}

}  // namespace alabaster
