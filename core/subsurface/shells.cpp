#include "core/subsurface/shells.h"

#include <algorithm>
#include <atomic>
#include <bit>
#include <cmath>
#include <span>

#include "core/geometry/grouped_items.h"

namespace alabaster {
namespace {

using Triple = std::array<uint32_t, 3>;

// Sets of triangles, each triangle with its winding relative to the first of its set (union-find with parity).
class Surfaces {
 public:
  explicit Surfaces(size_t count) : parent_(count), turned_(count, 0) {
    for (size_t i = 0; i < count; ++i) parent_[i] = static_cast<uint32_t>(i);
  }

  uint32_t root(uint32_t t) {
    uint32_t top = t;
    uint8_t turned = 0;
    for (; parent_[top] != top; top = parent_[top]) turned ^= turned_[top];
    // All of the way now points to the top.
    while (parent_[t] != top && t != top) {
      const uint32_t next = parent_[t];
      const uint8_t step = turned_[t];
      parent_[t] = top;
      turned_[t] = turned;
      turned ^= step;
      t = next;
    }
    return top;
  }
  bool is_turned(uint32_t t) { return root(t) != t && turned_[t]; }

  /// False: a and b are already one surface, and `turned` contradicts it, as on a Moebius strip.
  bool join(uint32_t a, uint32_t b, bool turned) {
    const uint32_t ra = root(a), rb = root(b);
    const bool apart = (is_turned(a) != is_turned(b)) != turned;
    if (ra == rb) return !apart;
    parent_[std::max(ra, rb)] = std::min(ra, rb);
    turned_[std::max(ra, rb)] = apart;
    return true;
  }

 private:
  std::vector<uint32_t> parent_;
  std::vector<uint8_t> turned_;  // against the parent
};

// An edge of a triangle from or to the point that groups it.
struct Edge {
  uint32_t other;  // point
  uint32_t triangle;
  bool ascending;  // as this triangle runs along it
  bool operator<(const Edge& o) const { return other != o.other ? other < o.other : triangle < o.triangle; }
};

// A triangle among those with the same lowest corner.
struct Fellow {
  std::array<uint32_t, 2> others;  // its other corners, ascending
  uint32_t triangle;
  auto operator<=>(const Fellow&) const = default;
};

struct Shell {
  double volume = 0;           // signed, by the winding of the first triangle
  std::vector<uint32_t> some;  // a few of its triangles
  uint32_t count = 0;
};

class ShellFinder {
 public:
  ShellFinder(const Mesh& mesh, const ObjectScene& object, const CancelToken& cancel)
      : cancel_(cancel),
        mesh_(mesh),
        object_(object),
        surfaces_(mesh.triangles.size()),
        kind_(mesh.triangles.size(), kSingle) {}

  MeshShells find() {
    weld();
    merge_coincident();
    join_by_edges();
    number_shells();
    cancel_.check();
    orient();
    cancel_.check();
    write_flags();
    if (out_.any_closed) {
      find_cavities();
      out_.overlapping = !walls_.empty() || overlaps() || (mesh_.deforms() && shells_.size() > 1);
    }
    auto& flags = out_.triangle_flags;
    if (std::all_of(flags.begin(), flags.end(), [](uint8_t f) { return f == 0; })) flags = {};
    return std::move(out_);
  }

 private:
  enum Kind : uint8_t { kSingle, kCopy, kBackToBack, kDegenerate };
  static constexpr uint32_t kNone = ~0u;

  void weld() {
    const std::vector<int> first = weld_by_position(mesh_.points, cancel_);
    corners_.reserve(mesh_.triangles.size());
    for (const auto& t : mesh_.triangles) {
      corners_.push_back(
          {static_cast<uint32_t>(first[t[0]]), static_cast<uint32_t>(first[t[1]]), static_cast<uint32_t>(first[t[2]])});
      const Triple& c = corners_.back();
      if (c[0] == c[1] || c[1] == c[2] || c[2] == c[0]) kind_[corners_.size() - 1] = kDegenerate;
    }
  }

  void merge_coincident() {
    const auto each = [&](const auto& add) {
      for (uint32_t t = 0; t < corners_.size(); ++t) {
        cancel_.check();
        Triple key = corners_[t];
        std::sort(key.begin(), key.end());
        if (kind_[t] == kSingle) add(key[0], Fellow{{key[1], key[2]}, t});
      }
    };
    const GroupedItems<Fellow> triangles(mesh_.points.size(), each, cancel_);
    for (size_t point = 0; point < triangles.size(); ++point)
      for_each_run(
          triangles[point], [](const Fellow& a, const Fellow& b) { return a.others == b.others; },
          [&](std::span<const Fellow> coincident) {
            if (coincident.size() > 1) merge(coincident);
          });
  }

  void merge(std::span<const Fellow> group) {
    const auto is_even = [&](size_t i) { return even_permutation(corners_[group[i].triangle]); };
    const size_t count = group.size();
    size_t even = 0;
    for (size_t i = 0; i < count; ++i) even += is_even(i) ? 1 : 0;
    if (2 * even == count) {
      for (size_t i = 0; i < count; ++i) kind_[group[i].triangle] = kBackToBack;
      return;
    }
    const bool majority = 2 * even > count;
    uint32_t kept = kNone;
    for (size_t i = 0; i < count; ++i)
      if (kept == kNone && is_even(i) == majority) kept = group[i].triangle;
    for (size_t i = 0; i < count; ++i) {
      if (group[i].triangle == kept) continue;
      kind_[group[i].triangle] = kCopy;
      surfaces_.join(kept, group[i].triangle, is_even(i) != majority);
    }
  }

  static bool even_permutation(const Triple& c) {
    return (c[0] < c[1] && c[1] < c[2]) || (c[1] < c[2] && c[2] < c[0]) || (c[2] < c[0] && c[0] < c[1]);
  }

  void join_by_edges() {
    const auto each = [&](const auto& add) {
      for (uint32_t t = 0; t < corners_.size(); ++t) {
        cancel_.check();
        if (kind_[t] == kCopy || kind_[t] == kDegenerate) continue;
        for (size_t i = 0; i < 3; ++i) {
          const uint32_t a = corners_[t][i], b = corners_[t][(i + 1) % 3];
          add(std::min(a, b), Edge{std::max(a, b), t, a < b});
        }
      }
    };
    const GroupedItems<Edge> edges(mesh_.points.size(), each, cancel_);
    for (size_t point = 0; point < edges.size(); ++point) {
      cancel_.check();
      for_each_run(
          edges[point], [](const Edge& a, const Edge& b) { return a.other == b.other; },
          [&](std::span<const Edge> edge) { join_at_edge(edge); });
    }
  }

  void join_at_edge(std::span<const Edge> edge) {
    const size_t count = edge.size();
    std::array<const Edge*, 2> pair{};
    size_t single = 0;
    const Edge* back_to_back = nullptr;
    for (size_t i = 0; i < count; ++i) {
      if (kind_[edge[i].triangle] == kBackToBack) {
        if (back_to_back) surfaces_.join(back_to_back->triangle, edge[i].triangle, false);
        back_to_back = &edge[i];
      } else if (single++ < 2) {
        pair[single - 1] = &edge[i];
      }
    }
    if (single % 2 == 1)
      for (size_t i = 0; i < count; ++i) torn_.push_back(edge[i].triangle);
    if (single == 2 && !surfaces_.join(pair[0]->triangle, pair[1]->triangle, pair[0]->ascending == pair[1]->ascending))
      torn_.push_back(pair[0]->triangle);
    if (single > 0 && back_to_back) walls_.push_back(back_to_back->triangle);
  }

  void number_shells() {
    shell_.assign(corners_.size(), kNone);
    for (uint32_t t = 0; t < corners_.size(); ++t) {
      if (kind_[t] == kDegenerate) continue;
      const uint32_t root = surfaces_.root(t);
      if (shell_[root] == kNone) {
        shell_[root] = static_cast<uint32_t>(shells_.size());
        shells_.emplace_back();
      }
      shell_[t] = shell_[root];
      Shell& shell = shells_[shell_[t]];
      if (std::has_single_bit(++shell.count) && shell.some.size() < kProbes) shell.some.push_back(t);
    }
    open_.assign(shells_.size(), false);
    inner_.assign(shells_.size(), false);
    for (uint32_t t = 0; t < corners_.size(); ++t)
      if (kind_[t] == kBackToBack) open_[shell_[t]] = true;
    for (uint32_t t : torn_) open_[shell_[t]] = true;
    for (uint32_t t : walls_) inner_[shell_[t]] = true;
  }

  // About the centre of the mesh, so that digits do not go where it stands.
  void orient() {
    const Vec3d centre(mesh_.bounds.center());
    for (uint32_t t = 0; t < corners_.size(); ++t) {
      if (kind_[t] != kSingle) continue;
      const auto p = [&](size_t i) { return Vec3d(mesh_.points[corners_[t][i]]) - centre; };
      const double volume = dot(p(0), cross(p(1), p(2)));
      shells_[shell_[t]].volume += surfaces_.is_turned(t) ? -volume : volume;
    }
  }

  void write_flags() {
    out_.triangle_flags.assign(corners_.size(), 0);
    for (uint32_t t = 0; t < corners_.size(); ++t) {
      if (kind_[t] == kDegenerate) continue;
      const uint32_t s = shell_[t];
      uint8_t& flags = out_.triangle_flags[t];
      if (surfaces_.is_turned(t) != (shells_[s].volume < 0)) flags |= MeshShells::kReversed;
      if (inner_[s])
        flags = MeshShells::kInner;
      else if (open_[s])
        flags |= MeshShells::kOpen;
      (open_[s] ? out_.any_open : out_.any_closed) |= !inner_[s];
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
      if (closed(s) && (largest == kNone || std::abs(shells_[s].volume) > std::abs(shells_[largest].volume)))
        largest = s;
    std::vector<bool> cavity(shells_.size(), false);
    for (uint32_t s = 0; s < shells_.size(); ++s)
      cavity[s] = largest != kNone && closed(s) && shells_[s].volume * shells_[largest].volume < 0 && is_nested(s);
    for (uint32_t t = 0; t < corners_.size(); ++t)
      if (shell_[t] != kNone && cavity[shell_[t]]) out_.triangle_flags[t] ^= MeshShells::kReversed;
  }

  bool overlaps() const {
    constexpr size_t kSamples = 4096;
    std::vector<double> area(corners_.size() + 1, 0);
    for (size_t t = 0; t < corners_.size(); ++t) {
      const auto& c = corners_[t];
      const Vec3d p(mesh_.points[c[0]]);
      area[t + 1] = area[t] + length(cross(Vec3d(mesh_.points[c[1]]) - p, Vec3d(mesh_.points[c[2]]) - p));
    }
    if (!(area.back() > 0)) return false;
    std::atomic<bool> found = false;
    tbb::parallel_for(tbb::blocked_range<size_t>(0, kSamples, 64), [&](const tbb::blocked_range<size_t>& range) {
      for (size_t i = range.begin(); i < range.end() && !found; ++i) {
        cancel_.check();
        const double at = area.back() * (static_cast<double>(i) + 0.5) / kSamples;
        const auto above = std::upper_bound(area.begin(), area.end(), at);
        const auto t = static_cast<uint32_t>(above - area.begin() - 1);
        if (t >= corners_.size()) continue;
        const double u = (at - area[t]) / (*above - area[t]);
        if (lies_inside(t, {static_cast<float>(u), radical_inverse(static_cast<uint32_t>(i))})) found = true;
      }
    });
    return found;
  }

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

  static constexpr size_t kProbes = 8;

  const CancelToken cancel_;
  const Mesh& mesh_;
  const ObjectScene& object_;
  std::vector<Triple> corners_;  // welded
  Surfaces surfaces_;
  std::vector<Kind> kind_;              // of triangles
  std::vector<uint32_t> torn_, walls_;  // a triangle of each surface that has an open edge; that continues in another
  std::vector<uint32_t> shell_;         // of triangles
  std::vector<Shell> shells_;
  std::vector<bool> open_, inner_;  // of shells
  MeshShells out_;
};

}  // namespace

MeshShells find_shells(const Mesh& mesh, const ObjectScene& object, const CancelToken& cancel) {
  return ShellFinder(mesh, object, cancel).find();
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
