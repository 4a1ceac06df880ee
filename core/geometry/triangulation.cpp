#include "core/geometry/triangulation.h"

#include <algorithm>
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

// Points by the cells of a grid. Points may be removed.
class PointGrid {
 public:
  explicit PointGrid(const std::vector<Point2>& points) : points_(points), there_(points.size()) {}

  void fill(const std::vector<int>& those) {
    for (const int i : those) there_[index(i)] = true;
    sort(those);
  }
  // Removed points are looked at until half of all are removed: then the rest is sorted into larger cells.
  void remove(int i) {
    if (!there_[index(i)]) return;
    there_[index(i)] = false;
    if (--left_ * 2 > sorted_.size() || left_ == 0) return;
    std::vector<int> rest;
    for (const int other : sorted_)
      if (there_[index(other)]) rest.push_back(other);
    sort(rest);
  }
  bool has(int i) const { return there_[index(i)]; }

  /// True if `found` is for one of the points in the cells about these three. Adds those that it looks at to *looks.
  template <class Found>
  bool any_about(const Point2& a, const Point2& b, const Point2& c, size_t* looks, const Found& found) const {
    if (left_ == 0) return false;
    const size_t x0 = column(std::min({a.x, b.x, c.x})), x1 = column(std::max({a.x, b.x, c.x}));
    const size_t y0 = row(std::min({a.y, b.y, c.y})), y1 = row(std::max({a.y, b.y, c.y}));
    for (size_t y = y0; y <= y1; ++y) {
      *looks += 1 + begins_[y * side_ + x1 + 1] - begins_[y * side_ + x0];
      for (size_t k = begins_[y * side_ + x0]; k < begins_[y * side_ + x1 + 1]; ++k)
        if (there_[index(sorted_[k])] && found(sorted_[k])) return true;
    }
    return false;
  }

 private:
  static size_t index(int i) { return static_cast<size_t>(i); }
  size_t cell(double place, double first, double cells_per_unit) const {
    // Bounded before the conversion: a corner far outside of the grid may lie more cells away than size_t holds.
    const double cells = std::max(0.0, (place - first) * cells_per_unit);  // of 0 times infinity, too, 0
    return static_cast<size_t>(std::min(cells, static_cast<double>(side_ - 1)));
  }
  size_t column(double x) const { return cell(x, low_.x, scale_.x); }
  size_t row(double y) const { return cell(y, low_.y, scale_.y); }

  void sort(const std::vector<int>& those) {
    left_ = those.size();
    side_ = std::max(size_t(1), static_cast<size_t>(std::sqrt(static_cast<double>(left_))));
    Point2 high = low_ = left_ ? points_[index(those[0])] : Point2{0, 0};
    for (const int i : those) {
      const Point2& p = points_[index(i)];
      low_ = {std::min(low_.x, p.x), std::min(low_.y, p.y)};
      high = {std::max(high.x, p.x), std::max(high.y, p.y)};
    }
    const auto scale = [&](double extent) { return extent > 0 ? static_cast<double>(side_) / extent : 0; };
    scale_ = {scale(high.x - low_.x), scale(high.y - low_.y)};
    begins_.assign(side_ * side_ + 1, 0);
    const auto cell_of = [&](int i) { return row(points_[index(i)].y) * side_ + column(points_[index(i)].x); };
    for (const int i : those) ++begins_[cell_of(i) + 1];
    for (size_t k = 1; k < begins_.size(); ++k) begins_[k] += begins_[k - 1];
    std::vector<size_t> next(begins_.begin(), begins_.end() - 1);
    sorted_.resize(left_);
    for (const int i : those) sorted_[next[cell_of(i)]++] = i;
  }

  const std::vector<Point2>& points_;
  std::vector<bool> there_;
  size_t left_ = 0, side_ = 1;
  Point2 low_{0, 0}, scale_{0, 0};  // cells per unit
  std::vector<size_t> begins_;      // of each cell in sorted_, row by row
  std::vector<int> sorted_;
};

// Meisters 1975: a simple polygon with more than three corners has two ears. Corners form a ring of links.
class EarCutter {
 public:
  explicit EarCutter(const std::vector<Point2>& flat)
      : flat_(flat), next_(flat.size()), previous_(flat.size()), reflex_(flat), looks_left_(kMostLooks * flat.size()) {
    const int n = static_cast<int>(flat.size());
    for (int i = 0; i < n; ++i) {
      next_[index(i)] = (i + 1) % n;
      previous_[index(i)] = (i + n - 1) % n;
    }
    std::vector<int> reflex;
    for (int i = 0; i < n; ++i)
      if (turn(i) < 0) reflex.push_back(i);
    reflex_.fill(reflex);
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
      reflex_.remove(corner);
      for (const int i : {before, after})
        if (reflex_.has(i) && turn(i) >= 0) reflex_.remove(i);
      corner = after;
    }
    triangles->push_back({previous_[index(corner)], corner, next_[index(corner)]});
  }

 private:
  static constexpr size_t kMostLooks = 1000;  // for each corner: simple polygons need a few tens

  static size_t index(int i) { return static_cast<size_t>(i); }
  const Point2& at(int i) const { return flat_[index(i)]; }
  double turn(int i) const { return area2(at(previous_[index(i)]), at(i), at(next_[index(i)])); }

  bool is_ear(int i) {
    const Point2 &a = at(previous_[index(i)]), &b = at(i), &c = at(next_[index(i)]);
    size_t looks = 1;
    if (!(turn(i) > 0)) return spend(looks), false;
    const bool met = reflex_.any_about(a, b, c, &looks, [&](int r) {
      const Point2& p = at(r);
      return r != i && !same(p, a) && !same(p, b) && !same(p, c) && inside(p, a, b, c);
    });
    spend(looks);
    return !met;
  }
  void spend(size_t looks) { looks_left_ -= std::min(looks, looks_left_); }

  // The next ear; failing that (collinear corners, self-intersection) the next corner that is at least not reflex. Once
  // all looks are spent, any corner.
  int find_ear(int start, size_t left) {
    int flat = -1;
    for (size_t k = 0; k < left && looks_left_ > 0; ++k, start = next_[index(start)]) {
      if (is_ear(start)) return start;
      if (flat < 0 && turn(start) == 0) flat = start;
    }
    return flat >= 0 ? flat : start;
  }

  const std::vector<Point2>& flat_;
  std::vector<int> next_, previous_;
  PointGrid reflex_;
  size_t looks_left_;
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
