#include "delegate/prims/tubes.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <utility>

#include "core/geometry/embree_scene.h"
#include "core/math/transform.h"
#include "delegate/support/mesh_words.h"

namespace alabaster::hd::prims {
namespace {

constexpr size_t kManySegments = 100000;
constexpr double kSharpestCosine = -0.5;  // of a corner: beyond 120 degrees the tube ends, and another begins
constexpr double kShortest = 1e-6;        // a section, over the curve's largest coordinate
constexpr double kThinnest = 1e-4;        // a ring, over the curve's greatest width: else a tip

/// A place on a curve, by the control points and the varying values that it mixes.
struct Spot {
  std::array<uint32_t, 4> vertex{};
  std::array<float, 4> weight{};
  uint32_t from = 0, to = 0;
  float share = 0;  // of `to`
};

/// A cross-section of a tube.
struct Ring {
  Spot spot;
  float radius = 0;
  bool is_tip = false;
  uint32_t point = 0;  // its first point in the mesh
};

/// Rings that are joined, of one curve.
struct Run {
  size_t first = 0, count = 0;  // among all rings
  uint32_t curve = 0;
  bool is_closed = false;
};

/// What the rings of a run are built on, in one pose.
struct Pose {
  std::vector<Vec3d> centre;   // of each ring
  std::vector<Vec3d> section;  // its direction; that of a closed run's last one leads to the first ring
  std::vector<Vec3d> side;     // across the section: the frame
};

// Rotates a vector across `from` by the least rotation that takes `from` to `to`.
Vec3d transported(const Vec3d& across, const Vec3d& from, const Vec3d& to) {
  const double one_and_cosine = 1 + from.dot(to);
  Vec3d turned = across;
  if (one_and_cosine > 1e-6) turned -= (from + to) * (across.dot(to) / one_and_cosine);
  return (turned - to * turned.dot(to)).normalized();  // what rounding has left of it along `to`
}

Vec3d any_across(const Vec3d& v) {
  const Vec3d a(std::abs(v.x), std::abs(v.y), std::abs(v.z));
  const Vec3d axis = a.x <= a.y && a.x <= a.z ? Vec3d(1, 0, 0) : a.y <= a.z ? Vec3d(0, 1, 0) : Vec3d(0, 0, 1);
  return axis.cross(v).normalized();
}

double nearest_turn(double angle, double to) {
  constexpr double kTurn = 2 * std::numbers::pi;
  return angle + kTurn * std::round((to - angle) / kTurn);
}

class TubeMaker {
 public:
  TubeMaker(const PulledMesh& curves, const std::string& where, const alabaster::DiagnosticSink& sink)
      : curves_(curves), topology_(curves.curves), where_(where), sink_(sink) {}

  Tubes run(const NamedPrimvars& named, const std::shared_ptr<MemoryBudget>& budget, const CancelToken& cancel) {
    Tubes out;
    out.mesh = curves_;
    out.mesh.curves = {}, out.mesh.widths = {}, out.mesh.normals = {}, out.mesh.tangents = {};
    out.mesh.topology = {}, out.mesh.tags = {}, out.mesh.normal_samples = {};
    if (!read()) {
      tell_left_out();
      return out;
    }
    check_samples(&out.mesh.point_samples);
    const size_t poses = out.mesh.point_samples.values.size() + 1;
    reserve(budget, poses, &out.memory);
    make_rings(cancel);
    number_points();
    std::vector<Pose> rest;
    out.mesh.points = vertex_values(points_of(curves_.points.value), {}, &rest, &out.mesh.normals);
    for (Value& sample : out.mesh.point_samples.values) {
      cancel.check();
      PulledPrimvar normals;
      sample = vertex_values(points_of(sample), rest, nullptr, &normals).value;
      out.mesh.normal_samples.values.push_back(normals.value);
    }
    out.mesh.normal_samples.times = out.mesh.point_samples.times;
    set_faces(&out.mesh);
    spread_values(&out.mesh);
    out.named.names = named.names;
    if (named.others && !named.names.empty()) {
      auto others = std::make_shared<OtherPrimvars>();
      for (const Token& name : named.names)
        if (const auto held = named.others->by_name.find(name); held != named.others->by_name.end())
          spread(held->second, name.str(), &others->by_name[name]);
      out.named.others = std::move(others);
    }
    tell_left_out();
    return out;
  }

 private:
  enum class Basis { linear, bezier, bspline, catmull_rom };
  enum class Wrap { nonperiodic, periodic, pinned };

  void warn(const char* code, const std::string& text) const {
    alabaster::report(sink_, alabaster::Severity::warning, code, where_, text);
  }
  void fail(const char* code, const std::string& text) const {
    alabaster::report(sink_, alabaster::Severity::error, code, where_, text);
  }
  static const Array<Vec3f>& points_of(const Value& value) {
    static const Array<Vec3f> none;
    const auto* points = value.get<Array<Vec3f>>();
    return points ? *points : none;
  }
  template <class Words>
  size_t word(const Token& token, const Words& words, const char* what) const {
    const auto found = token.empty() ? words.begin() : std::find(words.begin(), words.end(), token.str());
    if (found != words.end()) return static_cast<size_t>(found - words.begin());
    warn("curves.token", std::string(what) + " '" + token.str() + "' of curves is not known; " + words[0] + " is used");
    return 0;
  }

  // The topology ------------------------------------------------------------------------------------
  bool read() {
    const bool is_linear = word(topology_.type, support::kCurveTypes, "type") == 1;
    basis_ = is_linear ? Basis::linear : static_cast<Basis>(1 + word(topology_.basis, support::kCurveBases, "basis"));
    wrap_ = static_cast<Wrap>(word(topology_.wrap, support::kCurveWraps, "wrap"));
    if (wrap_ == Wrap::pinned && (basis_ == Basis::linear || basis_ == Basis::bezier)) wrap_ = Wrap::nonperiodic;
    if (curves_.normals.present && !curves_.normals.value.empty())
      warn("curves.ribbons", "normals make ribbons of curves; they are drawn as tubes");
    points_ = points_of(curves_.points.value);
    size_t vertex = 0;
    uint32_t curve = 0;
    for (const int32_t count : topology_.curveVertexCounts) {
      const size_t vertices = static_cast<size_t>(std::max(count, 0));
      first_vertex_.push_back(static_cast<uint32_t>(vertex)), first_varying_.push_back(varyings_);
      const size_t segments = segments_of(vertices);
      const bool exists = vertex + vertices <= points_.size();
      vertex += vertices;
      varyings_ += segments + (wrap_ == Wrap::periodic ? 0 : 1);
      segments_.push_back(exists ? static_cast<uint32_t>(segments) : 0);
      all_segments_ += segments_.back();
      if (exists && segments == 0) leave_out(curve, &too_short_);
      if (exists && segments > 0 && has_loose_points(vertices)) leave_out(curve, &loose_);
      ++curve;
    }
    if (vertex != points_.size()) {
      const std::string text = "curveVertexCounts add up to " + std::to_string(vertex) + ", and there are " +
                               std::to_string(points_.size()) + " points; ";
      fail("curves.counts", text + (vertex > points_.size() ? "curves beyond the points are not drawn"
                                                            : "points beyond the curves are not used"));
    }
    sides_ = all_segments_ > kManySegments ? 6 : 12;
    // The area of the polygon is that of the circle.
    const double step = 2 * std::numbers::pi / sides_;
    widen_ = std::sqrt(step / std::sin(step));
    read_radii();
    return all_segments_ > 0;
  }

  size_t segments_of(size_t vertices) const {
    if (wrap_ == Wrap::periodic) {
      if (basis_ == Basis::linear) return vertices >= 3 ? vertices : 0;
      return vertices >= 3 ? vertices / step_of_basis() : 0;
    }
    if (basis_ == Basis::linear || wrap_ == Wrap::pinned) return vertices >= 2 ? vertices - 1 : 0;
    return vertices >= 4 ? (vertices - 4) / step_of_basis() + 1 : 0;
  }
  bool has_loose_points(size_t vertices) const {
    return basis_ == Basis::bezier && (wrap_ == Wrap::periodic ? vertices : vertices - 1) % step_of_basis() != 0;
  }
  size_t step_of_basis() const { return basis_ == Basis::bezier ? 3 : 1; }

  struct LeftOut {
    size_t count = 0;
    uint32_t first = 0;
  };
  void leave_out(uint32_t curve, LeftOut* why) const {
    if (why->count++ == 0) why->first = curve;
  }
  void tell_left_out() const {
    const auto tell = [&](const LeftOut& out, const char* code, const char* text) {
      if (out.count > 0)
        warn(code, std::to_string(out.count) + " curves " + text + " (first: curve " + std::to_string(out.first) + ")");
    };
    tell(too_short_, "curves.short", "have too few points for a segment, and are not drawn");
    tell(loose_, "curves.loose", "have points beyond their last segment, which are not used");
    tell(without_length_, "curves.length", "have all points in one place, and are not drawn");
    tell(not_finite_, "curves.points.nonfinite", "have points that are not finite or beyond 1e17, and are not drawn");
  }

  // Rings -------------------------------------------------------------------------------------------
  Spot spot_at(uint32_t curve, size_t segment, double t) const {
    const auto count = static_cast<size_t>(topology_.curveVertexCounts[curve]);
    Spot spot;
    const size_t varying = wrap_ == Wrap::periodic && segment + 1 == segments_[curve] ? 0 : segment + 1;
    spot.from = static_cast<uint32_t>(first_varying_[curve] + segment);
    spot.to = static_cast<uint32_t>(first_varying_[curve] + varying);
    spot.share = static_cast<float>(t);
    std::array<double, 4> w{1 - t, t, 0, 0};
    const double s = 1 - t, t2 = t * t, t3 = t2 * t;
    if (basis_ == Basis::bezier) w = {s * s * s, 3 * s * s * t, 3 * s * t2, t3};
    if (basis_ == Basis::bspline) w = {s * s * s / 6, (3 * t3 - 6 * t2 + 4) / 6, (3 * (t + t2 - t3) + 1) / 6, t3 / 6};
    if (basis_ == Basis::catmull_rom)
      w = {(2 * t2 - t3 - t) / 2, (3 * t3 - 5 * t2 + 2) / 2, (4 * t2 - 3 * t3 + t) / 2, (t3 - t2) / 2};
    const size_t before = wrap_ == Wrap::pinned ? 1 : 0;  // a phantom point, from which the curve begins in its first
    const size_t window = segment * step_of_basis();
    const size_t used = basis_ == Basis::linear ? 2 : 4;
    for (size_t i = 0; i < used; ++i) {
      const size_t at = std::min(std::max(window + i, before) - before, wrap_ == Wrap::pinned ? count - 1 : ~size_t(0));
      spot.vertex[i] = static_cast<uint32_t>(first_vertex_[curve] + at % count);
    }
    for (size_t i = used; i < 4; ++i) spot.vertex[i] = spot.vertex[0];
    if (wrap_ == Wrap::pinned && segment == 0) w[1] += 2 * w[0], w[2] -= w[0], w[0] = 0;
    if (wrap_ == Wrap::pinned && segment + 1 == segments_[curve]) w[2] += 2 * w[3], w[1] -= w[3], w[3] = 0;
    for (size_t i = 0; i < 4; ++i) spot.weight[i] = static_cast<float>(w[i]);
    return spot;
  }

  static Vec3d place(const Spot& spot, const Array<Vec3f>& points) {
    Vec3d sum(0);
    for (size_t i = 0; i < 4; ++i)
      if (spot.weight[i] != 0) sum += Vec3d(points[spot.vertex[i]]) * double(spot.weight[i]);
    return sum;
  }

  // By how much the segment bends: from one of four parts to the next. A straight one has pieces, too, because cubics
  // give it values that are none of its ends'.
  size_t pieces_of(uint32_t curve, size_t segment) const {
    if (basis_ == Basis::linear) return 1;
    const bool many = all_segments_ > kManySegments;
    Vec3d before(0), at = place(spot_at(curve, segment, 0), points_);
    double bend = 0;
    for (int i = 1; i <= 4; ++i) {
      const Vec3d next = place(spot_at(curve, segment, i * 0.25), points_), part = next - at;
      if (before.length2() > 0 && part.length2() > 0) bend += std::atan2(before.cross(part).length(), before.dot(part));
      if (part.length2() > 0) before = part;
      at = next;
    }
    const double step = (many ? 20 : 10) * std::numbers::pi / 180;
    return std::clamp(static_cast<size_t>(std::ceil(bend * 4 / 3 / step)), size_t(many ? 1 : 4), size_t(many ? 8 : 16));
  }

  bool is_finite_curve(uint32_t curve) const {
    const auto begin = points_.begin() + first_vertex_[curve];
    return std::all_of(begin, begin + topology_.curveVertexCounts[curve],
                       [](const Vec3f& p) { return is_finite(p) && max_abs_component(p) <= kTraceLimit; });
  }

  void reserve(const std::shared_ptr<MemoryBudget>& budget, size_t poses, MemoryReservation* memory) {
    size_t rings = all_segments_;  // a sharp corner at the end of a segment has two
    for (uint32_t curve = 0; curve < segments_.size(); ++curve) {
      if (segments_[curve] > 0 && !is_finite_curve(curve)) leave_out(curve, &not_finite_), segments_[curve] = 0;
      for (size_t segment = 0; segment < segments_[curve]; ++segment) rings += pieces_of(curve, segment);
      rings += segments_[curve] > 0;
    }
    const auto sides = static_cast<size_t>(sides_);
    const size_t of_ring =
        sizeof(Ring) + 3 * sizeof(Vec3d) + sides * (2 * poses * sizeof(Vec3f) + 11 * sizeof(int32_t));
    const std::string what = "a mesh of the tubes of " + std::to_string(all_segments_) + " curve segments";
    *memory = MemoryReservation(budget, MemoryUse::meshes, rings * of_ring, what);
    if (rings * sides > size_t(std::numeric_limits<int32_t>::max()))
      throw MemoryRefused(what + " has more than 2^31 points; divide the curves among several prims");
    rings_.reserve(rings);
  }

  void make_rings(const CancelToken& cancel) {
    for (uint32_t curve = 0; curve < segments_.size(); ++curve) {
      if (segments_[curve] == 0) continue;
      if (curve % 1024 == 0) cancel.check();
      std::vector<Ring> rings;
      std::vector<Vec3d> places;
      double largest = 0;
      float thickest = 0;
      const auto add = [&](const Spot& spot) {
        const Vec3d p = place(spot, points_);
        largest = std::max({largest, std::abs(p.x), std::abs(p.y), std::abs(p.z)});
        if (!places.empty() && (p - places.back()).length() <= kShortest * largest) return;
        rings.push_back({spot, radius_at(curve, spot)});
        places.push_back(p);
      };
      for (size_t segment = 0; segment < segments_[curve]; ++segment) {
        const size_t pieces = pieces_of(curve, segment);
        for (size_t i = 0; i < pieces; ++i) add(spot_at(curve, segment, double(i) / double(pieces)));
      }
      const bool wraps = wrap_ == Wrap::periodic;
      if (!wraps) add(spot_at(curve, segments_[curve] - 1, 1));
      while (wraps && rings.size() > 1 && (places.back() - places[0]).length() <= kShortest * largest)
        rings.pop_back(), places.pop_back();
      for (const Ring& ring : rings) thickest = std::max(thickest, ring.radius);
      if (rings.size() < (wraps ? 3u : 2u))
        leave_out(curve, &without_length_);
      else if (thickest > 0)
        add_runs(curve, std::move(rings), places, thickest);
    }
  }

  // Corners that are too sharp for a ring end a run.
  void add_runs(uint32_t curve, std::vector<Ring> rings, const std::vector<Vec3d>& places, float thickest) {
    for (Ring& ring : rings) ring.is_tip = double(ring.radius) <= kThinnest * double(thickest);
    const size_t count = rings.size();
    const bool wraps = wrap_ == Wrap::periodic;
    const auto is_sharp = [&](size_t i) {
      const Vec3d in = places[i] - places[(i + count - 1) % count], on = places[(i + 1) % count] - places[i];
      return in.dot(on) < kSharpestCosine * in.length() * on.length();
    };
    size_t start = 0;
    while (wraps && start < count && !is_sharp(start)) ++start;
    if (wraps && start == count) return add_run(curve, rings, true);
    std::vector<Ring> part;
    for (size_t i = 0; i < count + (wraps ? 1 : 0); ++i) {
      const size_t at = (start + i) % count;
      const bool is_end = i == 0 || i + 1 == count + (wraps ? 1 : 0);
      part.push_back(rings[at]);
      if (is_end || !is_sharp(at)) continue;
      add_run(curve, part, false);
      part = {rings[at]};
    }
    add_run(curve, part, false);
  }
  void add_run(uint32_t curve, const std::vector<Ring>& rings, bool is_closed) {
    runs_.push_back({rings_.size(), rings.size(), curve, is_closed});
    rings_.insert(rings_.end(), rings.begin(), rings.end());
  }

  void number_points() {
    for (Ring& ring : rings_) {
      ring.point = static_cast<uint32_t>(ring_of_point_.size());
      ring_of_point_.insert(ring_of_point_.end(), ring.is_tip ? 1u : static_cast<size_t>(sides_),
                            static_cast<int32_t>(&ring - rings_.data()));
    }
  }

  // Points and normals ------------------------------------------------------------------------------
  Pose pose_of(const Run& run, const Array<Vec3f>& points, const Pose* rest) const {
    Pose pose;
    for (size_t i = 0; i < run.count; ++i) pose.centre.push_back(place(rings_[run.first + i].spot, points));
    const size_t sections = run.is_closed ? run.count : run.count - 1;
    for (size_t i = 0; i < sections; ++i) {
      const Vec3d way = pose.centre[(i + 1) % run.count] - pose.centre[i];
      const Vec3d otherwise = i > 0 ? pose.section.back() : rest ? rest->section[0] : Vec3d(0, 0, 1);
      pose.section.push_back(way.length2() > 0 ? way.normalized() : otherwise);
    }
    // Poses of what moves begin alike, so that their points do not turn about the curve.
    Vec3d side = rest ? transported(rest->side[0], rest->section[0], pose.section[0]) : any_across(pose.section[0]);
    pose.side.push_back(side);
    for (size_t i = 1; i < sections; ++i)
      pose.side.push_back(side = transported(side, pose.section[i - 1], pose.section[i]));
    return pose;
  }

  // The angle from the frame that has come around to the one that it began with.
  static double twist_of(const Pose& pose) {
    const Vec3d &first = pose.side[0], &section = pose.section[0];
    const Vec3d back = transported(pose.side.back(), pose.section.back(), section);
    return -std::atan2(section.cross(first).dot(back), first.dot(back));
  }

  PulledPrimvar vertex_values(const Array<Vec3f>& points, const std::vector<Pose>& rest, std::vector<Pose>* keep,
                              PulledPrimvar* normals) const {
    std::vector<Vec3f> places(ring_of_point_.size()), sides;
    sides.reserve(rings_.size() * static_cast<size_t>(sides_) + 2 * runs_.size());
    for (size_t r = 0; r < runs_.size(); ++r) {
      const Run& run = runs_[r];
      const Pose* const before = rest.empty() ? nullptr : &rest[r];
      Pose pose = pose_of(run, points, before);
      double twist = run.is_closed ? twist_of(pose) : 0;
      if (run.is_closed && before) twist = nearest_turn(twist, twist_of(*before));
      for (size_t i = 0; i < run.count; ++i)
        add_ring(run, i, pose, twist * double(i) / double(run.count), &places, &sides);
      if (!run.is_closed) sides.emplace_back(-pose.section.front()), sides.emplace_back(pose.section.back());
      if (keep) keep->push_back(std::move(pose));
    }
    *normals = {true, hd::Interpolation::faceVarying, Array<Vec3f>(std::move(sides)), {}};
    return {true, hd::Interpolation::vertex, Array<Vec3f>(std::move(places)), {}};
  }

  void add_ring(const Run& run, size_t i, const Pose& pose, double twist, std::vector<Vec3f>* places,
                std::vector<Vec3f>* normals) const {
    const Ring& ring = rings_[run.first + i];
    const size_t sections = pose.section.size(), on = std::min(i, sections - 1);
    const size_t in = run.is_closed ? (i + sections - 1) % sections : i > 0 ? i - 1 : 0;
    const Vec3d &ahead = pose.section[on], &behind = pose.section[in];
    const Vec3d both = ahead + behind, middle = both.length2() > 1e-6 ? both.normalized() : ahead;
    // How fast the tube widens here.
    const size_t last = run.count - 1;
    const size_t a = i > 0 ? i - 1 : run.is_closed ? last : 0, b = i < last ? i + 1 : run.is_closed ? 0 : last;
    const double way = (pose.centre[b] - pose.centre[i]).length() + (pose.centre[i] - pose.centre[a]).length();
    const double more = widen_ * double(rings_[run.first + b].radius - rings_[run.first + a].radius);
    const double slope = way > 0 ? more / way : 0;
    const Vec3d side = pose.side[on], up = ahead.cross(side);
    const double radius = widen_ * double(ring.radius);
    for (int k = 0; k < sides_; ++k) {
      // The middles of sides lie along the frame, which follows the axes: there the outline is off by least.
      const double angle = 2 * std::numbers::pi * (k + 0.5) / sides_ + twist;
      const Vec3d across = side * std::cos(angle) + up * std::sin(angle);
      // Where the plane between the sections cuts the edge that runs along them.
      const Vec3d edge = across - ahead * (across.dot(middle) / std::max(ahead.dot(middle), 0.5));
      if (!ring.is_tip) (*places)[ring.point + static_cast<uint32_t>(k)] = Vec3f(pose.centre[i] + edge * radius);
      Vec3d out = across - middle * across.dot(middle);
      out = out.length2() > 1e-12 ? out.normalized() : across;
      normals->emplace_back((out - middle * slope).normalized());
    }
    if (ring.is_tip) (*places)[ring.point] = Vec3f(pose.centre[i]);
  }

  // Faces -------------------------------------------------------------------------------------------
  void set_faces(PulledMesh* mesh) {
    std::vector<int32_t> counts, corners, normals;
    int32_t normal = 0;  // the first of a ring's
    const auto add = [&](std::initializer_list<std::pair<uint32_t, int32_t>> face, uint32_t curve) {
      for (const auto& [point, its_normal] : face) {
        corners.push_back(static_cast<int32_t>(point));
        normals.push_back(its_normal);
      }
      counts.push_back(static_cast<int32_t>(face.size()));
      curve_of_face_.push_back(static_cast<int32_t>(curve));
    };
    for (const Run& run : runs_) {
      const auto corner = [&](size_t i, int k) {
        const Ring& ring = rings_[run.first + i];
        const int side = k % sides_;
        return std::pair(ring.point + (ring.is_tip ? 0u : static_cast<uint32_t>(side)),
                         normal + static_cast<int32_t>(i) * sides_ + side);
      };
      const auto is_tip = [&](size_t i) { return rings_[run.first + i].is_tip; };
      for (size_t i = 0; i + (run.is_closed ? 0 : 1) < run.count; ++i) {
        const size_t j = (i + 1) % run.count;
        if (is_tip(i) && is_tip(j)) continue;
        for (int k = 0; k < sides_; ++k) {
          const auto a = corner(i, k), b = corner(i, k + 1), c = corner(j, k + 1), d = corner(j, k);
          if (is_tip(i))
            add({a, c, d}, run.curve);
          else if (is_tip(j))
            add({a, b, d}, run.curve);
          else
            add({a, b, c, d}, run.curve);
        }
      }
      normal += static_cast<int32_t>(run.count) * sides_;
      if (run.is_closed) continue;
      for (const size_t end : {size_t(0), run.count - 1}) {
        for (int k = 0; k < sides_ && !is_tip(end); ++k) {
          corners.push_back(static_cast<int32_t>(corner(end, end == 0 ? sides_ - 1 - k : k).first));
          normals.push_back(normal);
        }
        if (!is_tip(end)) counts.push_back(sides_), curve_of_face_.push_back(static_cast<int32_t>(run.curve));
        ++normal;
      }
    }
    mesh->topology.faceVertexCounts = std::move(counts), mesh->topology.faceVertexIndices = std::move(corners);
    mesh->normals.indices = std::move(normals);
  }

  // Values ------------------------------------------------------------------------------------------
  // How many values there must be; 0: curves have none of that rate.
  size_t wanted(hd::Interpolation interpolation) const {
    if (interpolation == hd::Interpolation::constant) return 1;
    if (interpolation == hd::Interpolation::uniform) return topology_.curveVertexCounts.size();
    if (interpolation == hd::Interpolation::varying && basis_ != Basis::linear) return varyings_;
    const bool is_of_points = interpolation == hd::Interpolation::vertex || interpolation == hd::Interpolation::varying;
    return is_of_points ? points_.size() : 0;
  }

  template <class T>
  static T value_at(const PulledPrimvar& values, const Array<T>& array, size_t i) {
    return array[values.indices.empty() ? i : static_cast<size_t>(values.indices[i])];
  }
  template <class T>
  T value_at(const PulledPrimvar& values, const Array<T>& array, const Spot& spot) const {
    if (values.interpolation == hd::Interpolation::varying && basis_ != Basis::linear) {
      const T a = value_at(values, array, spot.from), b = value_at(values, array, spot.to);
      return a + (b - a) * spot.share;
    }
    T sum(0);
    for (size_t i = 0; i < 4; ++i)
      if (spot.weight[i] != 0) sum += value_at(values, array, spot.vertex[i]) * spot.weight[i];
    return sum;
  }

  // Null: the values cannot be used (reported), or there are none. One value stands for all.
  template <class T>
  std::optional<PulledPrimvar> usable(const PulledPrimvar& given, const Array<T>& array, const std::string& name,
                                      const char* otherwise) const {
    if (!given.present || array.empty()) return std::nullopt;
    PulledPrimvar values = given;
    const size_t count = given.indices.empty() ? array.size() : given.indices.size();
    if (count == 1) values.interpolation = hd::Interpolation::constant;
    const size_t needed = wanted(values.interpolation);
    const bool indices_fit = std::all_of(given.indices.begin(), given.indices.end(),
                                         [&](int32_t i) { return i >= 0 && static_cast<size_t>(i) < array.size(); });
    constexpr const char* kRates[] = {"one for all", "one per curve", "one per end of a segment", "one per point"};
    if (count == needed && indices_fit) return values;
    std::string text = name + " of curves ";
    if (!indices_fit)
      text += "has indices outside of its " + std::to_string(array.size()) + " values";
    else if (needed == 0)
      text += "cannot be one per corner of a face or per instance";
    else
      text += "has " + std::to_string(count) + " values, and " + std::to_string(needed) + " are needed (" +
              kRates[static_cast<size_t>(values.interpolation)] + ")";
    warn("curves.values", text + "; " + otherwise);
    return std::nullopt;
  }

  void read_radii() {
    const auto* widths = curves_.widths.value.get<Array<float>>();
    if (curves_.widths.present && !curves_.widths.value.empty() && !widths)
      warn("curves.values", "widths of curves must be numbers; 1 is used");
    if (widths) widths_ = usable(curves_.widths, *widths, "widths", "1 is used");
    const auto bad = widths ? widths->size() - size_t(std::count_if(widths->begin(), widths->end(), is_width)) : 0;
    if (bad > 0)
      warn("curves.widths",
           std::to_string(bad) +
               " widths of curves are negative, not finite or beyond 1e17; 0 is used "
               "(first: width " +
               std::to_string(std::find_if_not(widths->begin(), widths->end(), is_width) - widths->begin()) + ")");
  }
  static bool is_width(float width) { return width >= 0 && width <= float(kTraceLimit); }
  float radius_at(uint32_t curve, const Spot& spot) const {
    if (!widths_) return 0.5f;
    const auto& widths = *widths_->value.get<Array<float>>();
    const bool is_constant = widths_->interpolation == hd::Interpolation::constant;
    float width = 0;
    if (is_constant || widths_->interpolation == hd::Interpolation::uniform)
      width = value_at(*widths_, widths, is_constant ? 0 : curve);
    else
      width = value_at(*widths_, widths, spot);
    return is_width(width) ? width / 2 : 0;  // cubics overshoot below 0
  }

  template <class T>
  void spread(const PulledPrimvar& given, const Array<T>* array, const std::string& name, PulledPrimvar* out) const {
    if (!array) return;
    const auto values = usable(given, *array, "primvar " + name, "it is left out");
    *out = values.value_or(PulledPrimvar());
    if (!values || values->interpolation == hd::Interpolation::constant) return;
    if (values->interpolation == hd::Interpolation::uniform) {
      std::vector<int32_t> indices = curve_of_face_;
      if (!values->indices.empty())
        for (int32_t& index : indices) index = values->indices[static_cast<size_t>(index)];
      out->indices = std::move(indices);
      return;
    }
    std::vector<T> mixed;
    mixed.reserve(rings_.size());
    for (const Ring& ring : rings_) mixed.push_back(value_at(*values, *array, ring.spot));
    out->value = Array<T>(std::move(mixed));
    out->interpolation = hd::Interpolation::vertex;
    out->indices = ring_indices_;
  }
  void spread(const PulledPrimvar& given, const std::string& name, PulledPrimvar* out) const {
    spread(given, given.value.get<Array<float>>(), name, out);
    spread(given, given.value.get<Array<Vec2f>>(), name, out);
    spread(given, given.value.get<Array<Vec3f>>(), name, out);
    spread(given, given.value.get<Array<Vec4f>>(), name, out);
  }
  void spread_values(PulledMesh* mesh) {
    ring_indices_ = std::move(ring_of_point_);
    spread(curves_.display_color, "displayColor", &mesh->display_color);
    spread(curves_.display_opacity, "displayOpacity", &mesh->display_opacity);
    for (const auto& [name, uvs] : curves_.uvs) spread(uvs, name.str(), &mesh->uvs[name]);
    if (widths_) spread(*widths_, "widths", &mesh->widths);
  }

  void check_samples(TimeSamples<Value>* samples) const {
    for (size_t i = 0; i < samples->values.size(); ++i) {
      const size_t count = points_of(samples->values[i]).size();
      if (count == points_.size()) continue;
      fail("motion.points", "the samples of the points cannot be used: sample " + std::to_string(i) + " has " +
                                std::to_string(count) + " points, the curves have " + std::to_string(points_.size()) +
                                "; they are drawn without deformation");
      *samples = {};
    }
  }

  const PulledMesh& curves_;
  const BasisCurvesTopology& topology_;
  const std::string& where_;
  const alabaster::DiagnosticSink& sink_;
  Basis basis_ = Basis::linear;
  Wrap wrap_ = Wrap::nonperiodic;
  Array<Vec3f> points_;
  std::vector<uint32_t> segments_, first_vertex_;  // by curve
  std::vector<size_t> first_varying_;              // by curve
  size_t varyings_ = 0;
  size_t all_segments_ = 0;
  int sides_ = 12;
  double widen_ = 1;
  std::optional<PulledPrimvar> widths_;
  std::vector<Ring> rings_;
  std::vector<Run> runs_;
  std::vector<int32_t> ring_of_point_, curve_of_face_;
  Array<int32_t> ring_indices_;
  LeftOut too_short_, loose_, without_length_, not_finite_;
};

}  // namespace

Tubes make_tubes(const PulledMesh& curves, const NamedPrimvars& named, const std::string& where,
                 const alabaster::DiagnosticSink& sink, const std::shared_ptr<MemoryBudget>& budget,
                 const CancelToken& cancel) {
  return TubeMaker(curves, where, sink).run(named, budget, cancel);
}

}  // namespace alabaster::hd::prims
