#include "core/scene/clear_bodies.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/sampling/pixel_sampler.h"
#include "testenv/support/furnace.h"

namespace alabaster {
namespace {

using testing::add;
using testing::clear_body;
using testing::moved_by;
using testing::scaled_by;
using testing::SceneBuilder;

constexpr int kMany = 1100;

// Rows of balls of radius .4, with 1 between their centres.
Matrix4d place(int i) {
  return scaled_by(0.4) * moved_by(i % 40, i / 40, 0);
}

// However many bodies there are, only where two may touch are surfaces sought that coincide.
TEST(ClearBodies, ManyBodiesMeetWhereTwoDo) {
  SceneBuilder b;
  const auto ball = b.prototype(testing::sphere_mesh(1, 8, false));
  for (int i = 0; i < kMany; ++i) add(&b, ball, clear_body(1.33f), place(i));
  EXPECT_TRUE(b.snapshot()->clear_meetings.empty());
  add(&b, ball, clear_body(1.33f), scaled_by(0.1) * moved_by(3.4, 2, 0));
  const auto snapshot = b.snapshot(2);
  EXPECT_LT(length(snapshot->clear_meetings.extent()), 0.4f);
  EXPECT_GT(length(snapshot->clear_meetings.extent()), 0.2f);
}

// So may a clear body and an opaque surface.
TEST(ClearBodies, OpaqueSurfacesMeetClearBodies) {
  SceneBuilder b;
  const auto ball = b.prototype(testing::sphere_mesh(1, 8, false));
  for (int i = 0; i < kMany; ++i) add(&b, ball, testing::white_body(0), place(i));
  EXPECT_TRUE(b.snapshot()->clear_meetings.empty());
  add(&b, ball, clear_body(1.33f), scaled_by(0.1) * moved_by(3.4, 2, 0));
  const auto snapshot = b.snapshot(2);
  EXPECT_LT(length(snapshot->clear_meetings.extent()), 0.4f);
  EXPECT_GT(length(snapshot->clear_meetings.extent()), 0.2f);
}

// A small clear body within the box of one that light walks in comes before it, and one beside it behind it.
TEST(ClearBodies, ManyCloudyBodiesRankWhatLiesWithin) {
  SceneBuilder b;
  const auto ball = b.prototype(testing::sphere_mesh(1, 8, false));
  for (int i = 0; i < kMany; ++i) add(&b, ball, clear_body(1.3f, 0.2f), place(i));
  add(&b, ball, clear_body(1.33f), scaled_by(0.1) * moved_by(3, 2, 0));
  add(&b, ball, clear_body(1.33f), scaled_by(0.1) * moved_by(3.4, 2, 0));
  const auto snapshot = b.snapshot();
  const auto rank = [&](int i) { return snapshot->instances[static_cast<size_t>(i)].clear_rank; };
  EXPECT_GT(rank(kMany), rank(0));
  EXPECT_LT(rank(kMany + 1), rank(0));
}

Vec3f random_point(Rng& rng) {
  const float x = rng.uniform(), y = rng.uniform();
  return {x, y, rng.uniform()};
}

struct Case {
  const char* name;
  Bounds (*box)(Rng& rng, int i, int count);
};
const Case kCases[] = {
    {"drops",
     [](Rng& rng, int, int count) {
       const Vec3f at = random_point(rng);
       return Bounds{at, at + Vec3f(0.7f / std::cbrt(float(count)))};
     }},
    {"fibres",
     [](Rng& rng, int, int count) {
       const Vec3f at(0, rng.uniform(), rng.uniform());
       return Bounds{at, at + Vec3f(1, 0.5f / std::sqrt(float(count)), 0.5f / std::sqrt(float(count)))};
     }},
    {"all at one point",
     [](Rng& rng, int, int) {
       return Bounds{-random_point(rng), random_point(rng)};
     }},
    {"each in the next",
     [](Rng&, int i, int) {
       return Bounds{Vec3f(-1 - float(i)), Vec3f(1 + float(i))};
     }},
};

TEST(ClearBodies, MeetingsAreThoseOfAllPairs) {
  for (const Case& c : kCases) {
    Rng rng(3, 8);
    std::vector<Bounds> boxes;
    for (int i = 0; i < 500; ++i) boxes.push_back(c.box(rng, i, 500));
    Bounds expected, found;
    for (size_t i = 0; i < boxes.size(); ++i)
      for (size_t k = 0; k < i; ++k) {
        Bounds both;
        for (int axis = 0; axis < 3; ++axis) {
          both.lower[axis] = std::max(boxes[i].lower[axis], boxes[k].lower[axis]);
          both.upper[axis] = std::min(boxes[i].upper[axis], boxes[k].upper[axis]);
        }
        expected.extend(both);
      }
    const BoxTree tree(boxes);
    extend_by_meetings(tree, tree, &found);
    EXPECT_EQ(found.lower, expected.lower) << c.name;
    EXPECT_EQ(found.upper, expected.upper) << c.name;
  }
}

// Pairs that are compared grow as n log n.
TEST(ClearBodies, MeetingsOfManyBodiesCostLittle) {
  for (const Case& c : kCases)
    for (const int count : {1000, 10000}) {
      Rng rng(3, 8);
      std::vector<Bounds> boxes;
      for (int i = 0; i < count; ++i) boxes.push_back(c.box(rng, i, count));
      Bounds found;
      const BoxTree tree(std::move(boxes));
      const size_t compared = extend_by_meetings(tree, tree, &found);
      EXPECT_LT(static_cast<double>(compared), 12 * count * std::log2(count)) << c.name;
    }
}

}  // namespace
}  // namespace alabaster
