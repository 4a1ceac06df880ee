#include "core/subsurface/random_walk.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>

#include "testenv/support/analytic_bodies.h"
#include "testenv/support/lone_body.h"

namespace alabaster {
namespace {

using testing::carry;
using testing::EllipsoidTracer;
using testing::entry_at_point;
using testing::lone_body;
using testing::SphereTracer;
using testing::walk_body;

Medium skin() {
  return make_medium({0.9f, 0.6f, 0.45f}, {1.0f, 0.35f, 0.2f}, AlbedoInversion::exact);
}

// The unit sphere, with the conventions of a mesh: float rays, both sides hit, t in units of |dir|. `triangle` is 1
// where it was hit from outside.
class UnitSphereScene final : public ObjectScene {
 public:
  bool intersect(const Ray& ray, TriangleHit* hit) const override {
    if (!is_traceable(ray)) return false;
    const Vec3d org = testing::to_double(ray.org), dir = testing::to_double(ray.dir);
    const double a = dot(dir, dir), b = dot(org, dir), c = dot(org, org) - 1;
    const double discriminant = b * b - a * c;
    if (discriminant < 0) return false;
    const double root = std::sqrt(discriminant);
    const double t = c > 0 ? (-b - root) / a : b > 0 ? -c / (b + root) : (root - b) / a;
    if (!(t >= 0 && t <= ray.tmax)) return false;
    hit->triangle = c > 0;
    hit->t = static_cast<float>(t);
    return true;
  }
  void intersect_all(const Ray&, std::pmr::vector<TriangleHit>*) const override { FAIL() << "a walk never asks"; }
  size_t memory_bytes() const override { return 0; }
};

// No surface at all: a mesh whose hole the walk always finds.
class EmptyScene final : public ObjectScene {
 public:
  bool intersect(const Ray&, TriangleHit*) const override { return false; }
  void intersect_all(const Ray&, std::pmr::vector<TriangleHit>* hits) const override { hits->clear(); }
  size_t memory_bytes() const override { return 0; }
};

TEST(ChromaticSegment, GreyMediaLoseExactlyTheirAbsorption) {
  // No rounding may masquerade as absorption: at A = 0.9999 an event takes 2e-9.
  const Medium medium = make_medium(Rgb(0.9999f), Rgb(0.1f), AlbedoInversion::exact);
  const WalkMedium walk_medium(medium);
  Rng rng(3, 1);
  for (int i = 0; i < 1000; ++i) {
    const ChromaticSegment segment(walk_medium, {1, 1, 1});
    for (const double channel : segment.scatter_throughput(segment.sample_distance({rng.uniform(), rng.uniform()})))
      EXPECT_NEAR((1 - channel) / medium.one_minus_alpha.r, 1, 1e-6);
  }
}

TEST(ChromaticSegment, ExtremesGiveNoNan) {
  const float infinity = std::numeric_limits<float>::infinity();
  const Rgb distances[] = {{1e-38f, 1.0f, infinity}, {1e-45f, 3e38f, 1.0f}, {1e-30f, 1e30f, 0.0f}};
  const Rgb albedos[] = {Rgb(0.0f), Rgb(1.0f), {1e-38f, 0.5f, 1.0f}};
  Rng rng(4, 1);
  for (const Rgb& distance : distances)
    for (const Rgb& albedo : albedos) {
      RenderCounters counters;
      WalkSettings settings;
      settings.safety_cap = 2000;  // white and thick: the walk may be endless
      const Medium medium = make_medium(albedo, distance, AlbedoInversion::exact);
      for (int i = 0; i < 500; ++i) {
        SphereTracer tracer(1);
        const auto end = walk_body(tracer, medium, settings, rng, counters);
        if (!end) continue;
        for (const double channel : end->throughput) ASSERT_TRUE(std::isfinite(channel) && channel >= 0);
      }
      EXPECT_EQ(counters.walks, 500u);
      EXPECT_EQ(counters.walk_lost, 0u);
    }
}

TEST(Survives, WithTheProbabilityAsked) {
  Rng rng(5, 1);
  int deaths = 0;
  for (int i = 0; i < 1000000; ++i) deaths += survives(1 - 1e-4, rng) ? 0 : 1;
  EXPECT_NEAR(deaths, 100, 40);  // four standard deviations
  for (int i = 0; i < 1000; ++i) {
    EXPECT_FALSE(survives(0, rng));
    EXPECT_TRUE(survives(1, rng));
  }
}

TEST(RandomWalkLoop, CountersAddUp) {
  Rng rng(7, 1);
  RenderCounters counters;
  uint64_t exits = 0, events_of_exits = 0;
  for (int i = 0; i < 5000; ++i) {
    SphereTracer tracer(2);
    if (const auto end = walk_body(tracer, skin(), {}, rng, counters)) {
      ++exits;
      events_of_exits += end->events;
    }
  }
  EXPECT_EQ(counters.walks, 5000u);
  EXPECT_EQ(counters.walk_exits, exits);
  EXPECT_EQ(counters.walks, counters.walk_exits + counters.walk_roulette_ends);
  EXPECT_EQ(counters.walk_rays, counters.walk_events + counters.walk_exits);
  EXPECT_GT(counters.walk_events, events_of_exits);
  EXPECT_EQ(counters.walk_lost, 0u);
  EXPECT_EQ(counters.walk_safety_cap, 0u);
}

TEST(RandomWalkLoop, SafetyCapEndsAndIsCounted) {
  Rng rng(8, 1);
  RenderCounters counters;
  WalkSettings settings;
  settings.safety_cap = 3;
  const Medium white = make_medium(Rgb(1.0f), Rgb(1e-3f), AlbedoInversion::exact);
  for (int i = 0; i < 100; ++i) {
    SphereTracer tracer(1);
    walk_body(tracer, white, settings, rng, counters);
  }
  EXPECT_GT(counters.walk_safety_cap, 0u);
  EXPECT_EQ(counters.walk_safety_cap + counters.walk_exits, 100u);
}

TEST(RandomWalkLoop, LongWalksAreLeftWhenCancelled) {
  const Medium white = make_medium(Rgb(1.0f), Rgb(1e-3f), AlbedoInversion::exact);
  const auto count_left = [&](const std::atomic<bool>& stop, uint64_t* longest) {
    Rng rng(8, 1);
    WalkSettings settings;
    settings.guiding = settings.sphere_steps = false;
    settings.cancel = CancelToken(&stop);
    int left = 0;
    for (int i = 0; i < 400; ++i) {
      SphereTracer tracer(1);
      RenderCounters counters;
      try {
        walk_body(tracer, white, settings, rng, counters);
      } catch (const BuildCancelled&) {
        ++left;
      }
      *longest = std::max(*longest, counters.walk_events);
    }
    return left;
  };
  uint64_t longest = 0, longest_cancelled = 0;
  EXPECT_EQ(count_left(std::atomic<bool>(false), &longest), 0);
  EXPECT_GT(longest, 8 * kEventsPerLook);
  EXPECT_GT(count_left(std::atomic<bool>(true), &longest_cancelled), 0);
  EXPECT_EQ(longest_cancelled, kEventsPerLook);
}

TEST(RandomWalkLoop, InactiveChannelsCarryNothing) {
  Rng rng(9, 1);
  RenderCounters counters;
  const Medium medium = make_medium(Rgb(0.9f), {1.0f, 0.0f, 1.0f}, AlbedoInversion::exact);
  for (int i = 0; i < 200; ++i) {
    SphereTracer tracer(1);
    if (const auto end = walk_body(tracer, medium, {}, rng, counters)) {
      EXPECT_EQ(end->throughput[1], 0);
      EXPECT_GT(end->throughput[0], 0);
    }
  }
  SphereTracer tracer(1);
  EXPECT_FALSE(walk_body(tracer, Medium(), {}, rng, counters));
}

TEST(RandomWalk, EntryIsInwardAndKeepsItsMass) {
  Rng rng(10, 1);
  const Vec3f ng = {0, 0, 1}, ns = normalize(Vec3f(0.9f, 0.1f, 0.3f));
  for (int i = 0; i < 10000; ++i) {
    const float u = rng.uniform();
    const Vec2f sample(u, rng.uniform());
    const Vec3f direction = sample_entry_direction(ns, ng, sample), lobe = sample_entry_direction(ns, ns, sample);
    EXPECT_NEAR(length(direction), 1, 1e-6);
    EXPECT_GE(direction.z, 0);
    EXPECT_FLOAT_EQ(direction.z, std::abs(lobe.z));  // the lobe itself, mirrored where it left
    EXPECT_NEAR(direction.x, lobe.x, 1e-6);
  }
}

// The same walk, once through an instance transform in the unit sphere's space, once in the world's ellipsoid.
TEST(RandomWalk, DistancesAreWorldDistancesUnderNonUniformScale) {
  const UnitSphereScene sphere;
  const Vec3d scale(2, 0.5, 5), pole = normalize(Vec3d(1, -2, 0.5));
  const Mesh no_mesh;
  // The translation must not matter: only the linear part is used.
  const SubsurfaceBody body =
      lone_body(sphere, no_mesh, Affine{{0.5f, 0, 0}, {0, 2, 0}, {0, 0, 0.2f}, {1e3f, 1e3f, 1e3f}});
  const Vec3d normal = normalize(Vec3d(pole.x / scale.x, pole.y / scale.y, pole.z / scale.z));
  const Vec3f inward(static_cast<float>(-normal.x), static_cast<float>(-normal.y), static_cast<float>(-normal.z));
  const double inside = 1 - 1e-6;
  const Vec3f p(static_cast<float>(pole.x * inside), static_cast<float>(pole.y * inside),
                static_cast<float>(pole.z * inside));
  const WalkMedium medium = skin();
  const SubsurfaceEntry entry = entry_at_point(p, -inward, medium);
  int different = 0, exits = 0;
  RenderCounters mesh_counters, counters;
  for (uint64_t i = 0; i < 4000; ++i) {
    Rng rng(i, 3);
    SubsurfaceNumbers numbers(rng), same(rng);
    const auto mesh_exit = RandomWalk{}.carry(body, entry, numbers, mesh_counters);
    EllipsoidTracer tracer(scale, pole * inside);
    const WalkStart start{
        sample_entry_direction(inward, inward, {same.first()[0], same.first()[1]}), inward, {1, 1, 1}};
    const auto exit = run_walk(tracer, start, medium, {}, same, counters);
    if (mesh_exit.has_value() != exit.has_value() || (exit && mesh_exit->events != exit->events)) {
      ++different;  // a hit at the very end of a segment, decided by rounding
      continue;
    }
    if (!exit) continue;
    ++exits;
    EXPECT_EQ(mesh_exit->direction, exit->direction);
    EXPECT_NEAR(mesh_exit->hit.t, exit->hit.t, 1e-4);
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(mesh_exit->throughput[c], exit->throughput[static_cast<size_t>(c)], 1e-3);
  }
  EXPECT_LE(different, 4);
  EXPECT_GT(exits, 2000);
  EXPECT_EQ(mesh_counters.walk_lost, 0u);
}

TEST(RandomWalk, RoundingDoesNotLeakThroughTheSurface) {
  // A mean free path of 160 ulps of the coordinates. Without the step back some 20 of these walks come in again from
  // outside, and several hundred segments start there.
  const UnitSphereScene sphere;
  const Mesh no_mesh;
  const SubsurfaceBody body = lone_body(sphere, no_mesh);
  const WalkMedium medium = make_medium(Rgb(0.9f), Rgb(1e-5f), AlbedoInversion::exact);
  RenderCounters counters;
  uint32_t from_outside = 0;
  double out = 0;
  for (uint64_t i = 0; i < 20000; ++i) {
    Rng rng(i, 13);
    const Vec3f normal = sample_uniform_sphere({rng.uniform(), rng.uniform()});
    const SubsurfaceEntry entry = entry_at_point(normal * (1 - 2e-7f), normal, medium);
    const auto exit = carry(RandomWalk{}, body, entry, rng, counters);
    if (!exit) continue;
    from_outside += exit->hit.triangle;
    out += exit->throughput.r / 20000;
  }
  EXPECT_LE(from_outside, 4u);
  EXPECT_NEAR(out, 0.9, 0.01);
}

TEST(RandomWalk, LeavingThroughAHoleIsCountedAndEnds) {
  const EmptyScene hole;
  const Mesh no_mesh;
  SubsurfaceBody body = lone_body(hole, no_mesh);
  body.bounds.extend(Vec3f(-1, -1, -1));
  body.bounds.extend(Vec3f(1, 1, 1));
  RenderCounters counters;
  Rng rng(11, 1);
  const WalkMedium white = make_medium(Rgb(1.0f), Rgb(0.1f), AlbedoInversion::exact);
  for (int i = 0; i < 100; ++i)
    EXPECT_FALSE(carry(RandomWalk{}, body, entry_at_point({0, 0, 0}, {0, 0, -1}, white), rng, counters));
  EXPECT_EQ(counters.walk_lost, 100u);
  // Nothing to collide with and nowhere to go: lost on the first segment, not a NaN.
  const WalkMedium clear = make_medium(Rgb(0.5f), Rgb(std::numeric_limits<float>::infinity()), AlbedoInversion::exact);
  EXPECT_FALSE(carry(RandomWalk{}, body, entry_at_point({0, 0, 0}, {0, 0, -1}, clear), rng, counters));
  EXPECT_EQ(counters.walk_lost, 101u);
}

TEST(RandomWalk, WithoutExtinctionLightCrosses) {
  const UnitSphereScene sphere;
  const Mesh no_mesh;
  const SubsurfaceBody body = lone_body(sphere, no_mesh);
  RenderCounters counters;
  Rng rng(12, 1);
  const WalkMedium clear = make_medium(Rgb(0.5f), Rgb(std::numeric_limits<float>::infinity()), AlbedoInversion::exact);
  for (int i = 0; i < 100; ++i) {
    const auto exit = carry(RandomWalk{}, body, entry_at_point({0, 0, -0.999999f}, {0, 0, -1}, clear), rng, counters);
    ASSERT_TRUE(exit);
    EXPECT_EQ(exit->events, 0u);
    EXPECT_EQ(exit->throughput, Rgb(1.0f));
  }
}

TEST(RandomWalk, ARecordedWalkIsTheSameWalk) {
  const UnitSphereScene sphere;
  const Mesh no_mesh;
  const SubsurfaceBody body = lone_body(sphere, no_mesh);
  const WalkMedium medium = make_medium(Rgb(0.8f), Rgb(0.2f), AlbedoInversion::exact);
  const SubsurfaceEntry entry = entry_at_point({0, 0, -0.999999f}, {0, 0, -1}, medium);
  RenderCounters counters;
  int exits = 0;
  for (uint64_t i = 0; i < 200; ++i) {
    Rng rng(i, 14), same(i, 14);
    WalkRecord record;
    const auto plain = carry(RandomWalk{}, body, entry, rng, counters);
    const auto recorded = carry(RandomWalk{{}, &record}, body, entry, same, counters);
    ASSERT_EQ(plain.has_value(), recorded.has_value());
    if (!plain) continue;
    ++exits;
    EXPECT_EQ(plain->throughput, recorded->throughput);
    ASSERT_EQ(record.size(), plain->events + 1u) << "every event, then the exit";
    EXPECT_EQ(record.back().kind, WalkStep::Kind::exit);
    EXPECT_EQ(record.back().direction, plain->direction);
    Vec3d p(0, 0, -0.999999);
    for (const WalkStep& step : record) p += testing::to_double(step.direction) * step.distance;
    EXPECT_NEAR(length(p), 1, 1e-5) << "the steps lead from the entry to the surface";
  }
  EXPECT_GT(exits, 50);
}

// Events of walks from the pole of the unit sphere, behind shells that are open or not.
uint64_t events_of_walks(float albedo, bool open, bool guiding) {
  const UnitSphereScene sphere;
  const Mesh no_mesh;
  SubsurfaceBody body = lone_body(sphere, no_mesh);
  MeshShells shells;
  shells.any_open = open;
  body.members.front().shells = &shells;
  const WalkMedium medium = make_medium(Rgb(albedo), Rgb(0.02f), AlbedoInversion::exact);
  WalkSettings settings;
  settings.guiding = guiding;
  RenderCounters counters;
  Rng rng(17, 1);
  for (int i = 0; i < 200; ++i)
    carry(RandomWalk{settings}, body, entry_at_point({0, 0, -1}, {0, 0, -1}, medium), rng, counters);
  return counters.walk_events;
}

TEST(RandomWalk, ClearClosedBodiesAreNotGuidedBackToTheSurface) {
  EXPECT_EQ(events_of_walks(0.95f, false, true), events_of_walks(0.95f, false, false));
  EXPECT_NE(events_of_walks(0.95f, true, true), events_of_walks(0.95f, true, false)) << "without end";
  EXPECT_NE(events_of_walks(0.8f, false, true), events_of_walks(0.8f, false, false));
}

}  // namespace
}  // namespace alabaster
