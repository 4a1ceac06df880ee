#include "core/geometry/triangulation.h"

#include <cmath>

namespace alabaster {
namespace {

struct Point2 {
  double x, y;
};

// Twice the signed area of the triangle a, b, c.
double area2(const Point2& a, const Point2& b, const Point2& c) {
  return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

// Drops the axis along which the normal is longest; the kept pair keeps the winding counter-clockwise.
std::vector<Point2> project(const std::vector<Vec3d>& corners) {
  const Vec3d n = polygon_normal(corners);
  const Vec3d a(std::abs(n.x), std::abs(n.y), std::abs(n.z));
  const int axis = a.x >= a.y && a.x >= a.z ? 0 : (a.y >= a.z ? 1 : 2);
  const int first = (axis + 1) % 3, second = (axis + 2) % 3;
  const bool flip = n[axis] < 0;
  std::vector<Point2> flat;
  flat.reserve(corners.size());
  for (const Vec3d& p : corners) flat.push_back(flip ? Point2{p[second], p[first]} : Point2{p[first], p[second]});
  return flat;
}

bool inside(const Point2& p, const Point2& a, const Point2& b, const Point2& c) {
  return area2(a, b, p) >= 0 && area2(b, c, p) >= 0 && area2(c, a, p) >= 0;
}

bool same(const Point2& a, const Point2& b) {
  return a.x == b.x && a.y == b.y;
}

// Meisters 1975: a simple polygon with more than three corners has two ears. Corners form a ring of links.
class EarCutter {
 public:
  explicit EarCutter(const std::vector<Point2>& flat) : flat_(flat), next_(flat.size()), previous_(flat.size()) {
    const int n = static_cast<int>(flat.size());
    for (int i = 0; i < n; ++i) {
      next_[index(i)] = (i + 1) % n;
      previous_[index(i)] = (i + n - 1) % n;
    }
    for (int i = 0; i < n; ++i)
      if (turn(i) < 0) reflex_.push_back(i);
  }

  void cut(std::vector<std::array<int, 3>>* triangles) {
    int corner = 0;
    for (size_t left = flat_.size(); left > 3; --left) {
      corner = find_ear(corner, left);
      const int before = previous_[index(corner)], after = next_[index(corner)];
      triangles->push_back({before, corner, after});
      next_[index(before)] = after;
      previous_[index(after)] = before;
      // Cutting an ear can only straighten its neighbours.
      std::erase_if(reflex_, [&](int i) { return i == corner || ((i == before || i == after) && turn(i) >= 0); });
      corner = after;
    }
    triangles->push_back({previous_[index(corner)], corner, next_[index(corner)]});
  }

 private:
  static size_t index(int i) { return static_cast<size_t>(i); }
  const Point2& at(int i) const { return flat_[index(i)]; }
  double turn(int i) const { return area2(at(previous_[index(i)]), at(i), at(next_[index(i)])); }

  bool is_ear(int i) const {
    const Point2 &a = at(previous_[index(i)]), &b = at(i), &c = at(next_[index(i)]);
    if (!(turn(i) > 0)) return false;
    for (int r : reflex_) {
      const Point2& p = at(r);
      if (r == i || same(p, a) || same(p, b) || same(p, c)) continue;
      if (inside(p, a, b, c)) return false;
    }
    return true;
  }

  // The next ear; failing that (collinear corners, self-intersection) the next corner that is at least not reflex.
  int find_ear(int start, size_t left) const {
    int flat = -1;
    for (size_t k = 0; k < left; ++k, start = next_[index(start)]) {
      if (is_ear(start)) return start;
      if (flat < 0 && turn(start) == 0) flat = start;
    }
    return flat >= 0 ? flat : start;
  }

  const std::vector<Point2>& flat_;
  std::vector<int> next_, previous_, reflex_;
};

bool is_convex(const std::vector<Point2>& p) {
  // All fan triangles turn the same way and add up to one turn: no corner of the fan lies beyond another.
  const size_t n = p.size();
  for (size_t i = 0; i < n; ++i)
    if (area2(p[i], p[(i + 1) % n], p[(i + 2) % n]) < 0) return false;
  for (size_t i = 1; i + 1 < n; ++i)
    if (area2(p[0], p[i], p[i + 1]) < 0) return false;
  return true;
}

}  // namespace

Vec3d polygon_normal(const std::vector<Vec3d>& corners) {
  Vec3d n(0, 0, 0);
  for (size_t i = 1; i + 1 < corners.size(); ++i) n += cross(corners[i] - corners[0], corners[i + 1] - corners[0]);
  return n;
}

void triangulate_polygon(const std::vector<Vec3d>& corners, std::vector<std::array<int, 3>>* triangles) {
  const int n = static_cast<int>(corners.size());
  if (n > 3) {
    const std::vector<Point2> flat = project(corners);
    if (!is_convex(flat)) {
      EarCutter(flat).cut(triangles);
      return;
    }
  }
  for (int i = 1; i + 1 < n; ++i) triangles->push_back({0, i, i + 1});
}

}  // namespace alabaster
