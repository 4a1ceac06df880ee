#include "core/subsurface/normalized_diffusion.h"

#include <cmath>
#include <limits>

#include "core/math/frame.h"

namespace alabaster {
namespace {

constexpr double kAxisProbability[3] = {kNormalAxisProbability, kTangentAxisProbability, kTangentAxisProbability};

/// An axis leaves surfaces to the others that it meets at a flatter angle: rounding decides whether a probe along the
/// surface meets it. One of three orthogonal axes always has |N.V| >= 1/sqrt(3).
constexpr double kLeastFacing = 1.0 / 64;

/// Balls below this many rounding errors are not resolved.
constexpr double kLeastBall = 16;

/// 2 pi r R(r) d / A at r = x d, times 4.
double radial_density(double x) {
  const double e = std::exp(-x / 3);
  return e * e * e + e;
}

/// Splits u among probabilities that sum to one; the rest of u is uniform again.
template <size_t N>
size_t choose(const std::array<double, N>& probability, double* u) {
  size_t chosen = 0;
  double below = 0, sum = 0;
  for (size_t i = 0; i < N; ++i) {
    if (!(probability[i] > 0)) continue;
    chosen = i;
    below = sum;
    sum += probability[i];
    if (*u < sum) break;
  }
  *u = std::min((*u - below) / probability[chosen], double(kOneMinusEpsilon));
  return chosen;
}

/// The channels' estimators on one radius, combined by the balance heuristic.
class ChannelEstimators {
 public:
  ChannelEstimators(const Medium& medium, const Rgb& throughput) {
    for (int c = 0; c < 3; ++c) {
      const auto i = static_cast<size_t>(c);
      distance_[i] = medium.scatter_distance[c];
      if (distance_[i] > 0) carried_[i] = double(throughput[c]) * medium.albedo[c];
      sum_ += carried_[i];
    }
    for (size_t c = 0; c < 3; ++c) weight_[c] = carried_[c] / sum_;
  }
  bool empty() const { return !(sum_ > 0) || !std::isfinite(sum_); }
  const std::array<double, 3>& weights() const { return weight_; }
  double distance(size_t channel) const { return distance_[channel]; }

  /// T_c A_c R_c(r) / Sum_j w_j R_j(r): the 1/r of the profile cancels. It cannot underflow: the chosen channel's
  /// radius is at most 100 of its distances.
  std::array<double, 3> throughput(double r) const {
    std::array<double, 3> profile{};
    double pdf = 0;
    for (size_t c = 0; c < 3; ++c) {
      if (!(carried_[c] > 0)) continue;
      // Channels that are alike share their exponential.
      const bool same = c > 0 && carried_[c - 1] > 0 && distance_[c] == distance_[c - 1];
      profile[c] = same ? profile[c - 1] : radial_density(r / distance_[c]) / distance_[c];
      pdf += weight_[c] * profile[c];
    }
    std::array<double, 3> out{};
    if (pdf > 0)
      for (size_t c = 0; c < 3; ++c) out[c] = carried_[c] * (profile[c] / pdf);
    return out;
  }

 private:
  std::array<double, 3> distance_{}, carried_{}, weight_{};
  double sum_ = 0;
};

/// `outward`: geometric normal of the exit, unit, world, by the mesh's winding; a closed shell knows better.
SubsurfaceExit exit_at(const SubsurfaceBody& body, const SubsurfaceEntry& entry, const TriangleHit& where,
                       const Vec3f& outward, const std::array<double, 3>& throughput) {
  const SubsurfaceBody::Member& member = body.members[entry.member];
  const bool closed = !(member.shells->flags(where.triangle) & MeshShells::kOpen);
  SubsurfaceExit exit{where, outward, {}, kManyEvents};
  exit.hit.instance = member.instance_of(entry.triangle);
  if (closed && !body.leaves(entry.member, exit.hit, outward)) exit.direction = -outward;
  for (int c = 0; c < 3; ++c) exit.throughput[c] = static_cast<float>(throughput[static_cast<size_t>(c)]);
  return exit;
}

/// Not normalised; in double, so that the smallest triangle's does not underflow.
Vec3d winding_normal(const Mesh& mesh, const TriangleHit& hit) {
  const auto [p0, p1, p2] = mesh.corners_at(hit.triangle, hit.time);
  return cross(Vec3d(p1) - Vec3d(p0), Vec3d(p2) - Vec3d(p0));
}

struct ProbeAxes {
  Vec3f world[3];   // normal and tangents at the entry, orthonormal
  Vec3d object[3];  // the same, mapped: a triangle's normal n has dot(n, object[k]) ~ N.V_k

  ProbeAxes(const Affine& to_object, const Vec3f& ng) {
    const Frame frame = frame_from_normal(ng);
    world[0] = frame.n, world[1] = frame.s, world[2] = frame.t;
    for (int k = 0; k < 3; ++k) object[k] = Vec3d(to_object.vector(world[k]));
  }
  /// The unit normal of a triangle, world space, in the axes' coordinates; zero for a degenerate one.
  Vec3d normal(const Mesh& mesh, const TriangleHit& hit) const {
    const Vec3d n = winding_normal(mesh, hit);
    const Vec3d a(dot(n, object[0]), dot(n, object[1]), dot(n, object[2]));
    const double l = length(a);
    return l > 0 ? a * (1 / l) : Vec3d(0, 0, 0);
  }
  Vec3f to_world(const Vec3d& n) const {
    return world[0] * static_cast<float>(n.x) + world[1] * static_cast<float>(n.y) + world[2] * static_cast<float>(n.z);
  }
};

/// The chord of a ball about the entry: t runs along `axis` and is zero on the disk.
struct Probe {
  size_t axis = 0;
  double radius = 0;       // of the chord from the ball's centre
  double half_length = 0;  // lengthened by what rounding can displace the surface by
  Ray ray;                 // object space; t in world units, from -half_length
};

Probe make_probe(const Affine& to_object, const SurfaceHit& entry, const ProbeAxes& axes, size_t axis, double ball,
                 const Vec2f& u) {
  Probe probe;
  probe.axis = axis;
  probe.radius = ball * std::sqrt(double(u.x));
  probe.half_length = ball * std::sqrt(1 - double(u.x)) + 2 * double(entry.offset);
  const Vec3f &v = axes.world[axis], &x = axes.world[(axis + 1) % 3], &y = axes.world[(axis + 2) % 3];
  const auto r = static_cast<float>(probe.radius), h = static_cast<float>(probe.half_length);
  const float phi = kTwoPi * u.y;
  const Vec3f to_start = x * (r * std::cos(phi)) + y * (r * std::sin(phi)) - v * h;
  probe.ray = {entry.p_object + to_object.vector(to_start), to_object.vector(v), 2 * h};
  return probe;
}

/// A probe through an edge meets both its triangles, and one through coincident faces all of them: they are one
/// surface, and counted twice they would shine.
class RepeatedHits {
 public:
  /// True if a surface of the same orientation was met at the same t, up to what the plane test rounds. By ascending t.
  bool repeats(const Mesh& mesh, const TriangleHit& hit, const Ray& ray, double facing) {
    constexpr double kRounding = 0x1p-20;
    double size = 0;
    for (const Vec3f& corner : mesh.corners_at(hit.triangle, hit.time))
      size = std::max(size, double(max_abs_component(corner)));
    const double t = hit.t, tolerance = kRounding * size / (length(Vec3d(ray.dir)) * std::abs(facing));
    double& last = last_[facing > 0];
    if (t - last <= tolerance) return true;
    last = t;
    return false;
  }

 private:
  double last_[2] = {-std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};
};

/// One of the hits, by reservoir.
class ExitReservoir {
 public:
  void add(const TriangleHit& hit, const Vec3d& normal, const std::array<double, 3>& throughput, Rng& rng) {
    const double weight = std::max(throughput[0], std::max(throughput[1], throughput[2]));
    if (!(weight > 0)) return;
    sum_ += weight;
    // The first is taken without a number: most probes meet one surface.
    if (sum_ > weight && !(rng.uniform() * sum_ < weight)) return;
    hit_ = hit, normal_ = normal, throughput_ = throughput, weight_ = weight;
  }
  bool empty() const { return !(sum_ > 0); }
  const TriangleHit& hit() const { return hit_; }
  const Vec3d& normal() const { return normal_; }
  std::array<double, 3> throughput() const {
    std::array<double, 3> out = throughput_;
    for (double& t : out) t *= sum_ / weight_;
    return out;
  }

 private:
  double sum_ = 0, weight_ = 1;
  TriangleHit hit_;
  Vec3d normal_{0, 0, 0};
  std::array<double, 3> throughput_{};
};

/// Sum_k P_k |N.V_k| over the axes that take such surfaces; zero if `axis` is none of them.
double coverage(const Vec3d& normal, size_t axis) {
  const double facing[3] = {std::abs(normal.x), std::abs(normal.y), std::abs(normal.z)};
  if (!(facing[axis] >= kLeastFacing)) return 0;
  double sum = 0;
  for (size_t k = 0; k < 3; ++k)
    if (facing[k] >= kLeastFacing) sum += kAxisProbability[k] * facing[k];
  return sum;
}

}  // namespace

double sample_diffusion_ball(double d, float u, Rng& rng) {
  const uint32_t kind = rng.next() >> 29;
  double logarithm = std::log1p(-double(u));
  if (kind & 1) logarithm += std::log1p(-double(rng.uniform()));
  return (kind < 2 ? d : 3 * d) * -logarithm;
}

std::optional<SubsurfaceExit> NormalizedDiffusion::carry(const SubsurfaceBody& body, const SubsurfaceEntry& entry,
                                                         SubsurfaceNumbers& numbers, RenderCounters& counters) const {
  // Sample the axis, the channel and the ball.
  const ChannelEstimators channels(entry.medium->medium, entry.throughput);
  if (channels.empty()) return std::nullopt;
  const auto& u = numbers.first();
  double u_choice = u[0];
  const size_t axis = choose(std::to_array(kAxisProbability), &u_choice);
  const double ball =
      sample_diffusion_ball(channels.distance(choose(channels.weights(), &u_choice)), u[1], numbers.rng());
  if (!(ball > kLeastBall * double(entry.hit.offset)))
    return exit_at(body, entry, entry.triangle, entry.hit.ng, channels.throughput(ball * std::sqrt(double(u[2]))));

  // Trace the probe.
  const SubsurfaceBody::Member& member = body.members[entry.member];
  std::optional<SubsurfaceBody::Maps> moved;
  const Affine& to_object = member.at(entry.triangle, &moved).to_object;
  const ProbeAxes axes(to_object, entry.hit.ng);
  Probe probe = make_probe(to_object, entry.hit, axes, axis, ball, {u[2], u[3]});
  probe.ray.time = entry.triangle.time;
  std::array<TriangleHit, 32> storage;
  std::pmr::monotonic_buffer_resource memory(storage.data(), sizeof(storage));
  std::pmr::vector<TriangleHit> hits(&memory);
  hits.reserve(storage.size());
  member.object->intersect_all(probe.ray, &hits);
  ++counters.probe_rays;
  counters.probe_hits += hits.size();

  // Keep one of the hits, in proportion to what it carries.
  ExitReservoir chosen;
  RepeatedHits repeated;
  for (const TriangleHit& hit : hits) {
    const Vec3d normal = axes.normal(*member.mesh, hit);
    const double covered = coverage(normal, axis);
    if (!(covered > 0) || repeated.repeats(*member.mesh, hit, probe.ray, normal[static_cast<int>(axis)])) continue;
    std::array<double, 3> throughput = channels.throughput(std::hypot(probe.radius, hit.t - probe.half_length));
    for (double& t : throughput) t /= covered;
    chosen.add(hit, normal, throughput, numbers.rng());
  }
  if (chosen.empty()) return std::nullopt;
  // The exit's normal lies on the same side of the mesh as the entry's.
  const bool reversed = dot(winding_normal(*member.mesh, entry.triangle), Vec3d(entry.hit.ng_object)) < 0;
  return exit_at(body, entry, chosen.hit(), axes.to_world(reversed ? -chosen.normal() : chosen.normal()),
                 chosen.throughput());
}

}  // namespace alabaster
