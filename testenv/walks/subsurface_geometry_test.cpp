// Subsurface scattering on artists' geometry: sets and overlaps are their union, open meshes lose only the energy that
// is counted, inverted meshes look like correct ones, and a camera may stand in the medium.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "testenv/support/medium_bodies.h"

namespace alabaster {
namespace {

using testing::box_mesh;
using testing::expect_same;
using testing::kExit;
using testing::MeanError;
using testing::medium_only;
using testing::merged;
using testing::request_of;
using testing::SceneBuilder;

Mesh turned(Mesh mesh) {
  for (auto& t : mesh.triangles) std::swap(t[1], t[2]);
  for (Vec3f& n : mesh.normals) n = -n;
  return mesh;
}

Mesh without_triangles(Mesh mesh, const std::function<bool(const Vec3f& centroid)>& gone) {
  std::erase_if(mesh.triangles, [&](const auto& t) {
    return gone((mesh.points[t[0]] + mesh.points[t[1]] + mesh.points[t[2]]) / 3.0f);
  });
  mesh.closed = false;
  return mesh;
}

// A bar lit from the side; light travels through it along x.
RenderRequest bar(const std::function<void(SceneBuilder*)>& add, uint32_t seed) {
  SceneBuilder b;
  add(&b);
  LightParameters key;
  key.type = LightType::sphere;
  key.radius = 0.4f;
  key.intensity = 40;
  key.light_to_world.setTranslation(Vec3d(-2, 1.0, 0.5));
  b.add(key);
  RenderRequest request = request_of(&b, testing::look_at({1, 2, 2.5}, {1, 0.3, 0.3}, 40), 64, 24);
  request.settings.seed = seed;
  request.settings.max_depth = 1;  // one walk from entry to visible exit
  return request;
}

const DisneyParameters kWax = medium_only(0.9f, 0.6f);

std::shared_ptr<const Film> whole_bar() {
  return testing::render(bar(
      [](SceneBuilder* b) {
        b->add(b->prototype(box_mesh({0, 0, 0}, {2, 0.6f, 0.6f})), b->material(kWax));
      },
      0));
}

TEST(UnionOfBodies, OverlappingMembersOfASetAreOneBody) {
  const auto set = testing::render(bar(
      [](SceneBuilder* b) {
        const auto material = b->material(kWax);
        // The second one is a cube, stretched and mirrored by its instance.
        b->add(b->prototype(box_mesh({0, 0, 0}, {1.2f, 0.6f, 0.6f})), material);
        b->add(b->prototype(box_mesh({0, 0, 0}, {1, 1, 1})), material,
               Matrix4d(-1.2, 0, 0, 0, 0, 0.6, 0, 0, 0, 0, 0.6, 0, 2, 0, 0, 1));
        for (auto& instance : b->description.instances) instance.subsurface_set = "bar";
      },
      1));
  expect_same(*set, *whole_bar(), "set");
}

TEST(UnionOfBodies, OverlappingShellsOfAMeshAreOneBody) {
  const auto shells = testing::render(bar(
      [](SceneBuilder* b) {
        b->add(b->prototype(
                   merged(box_mesh({0, 0, 0}, {1.2f, 0.6f, 0.6f}), turned(box_mesh({0.7f, 0, 0}, {2, 0.6f, 0.6f})))),
               b->material(kWax));
      },
      2));
  expect_same(*shells, *whole_bar(), "shells");
}

TEST(UnionOfBodies, TouchingBodiesPassTheLightOn) {
  const auto touching = testing::render(bar(
      [](SceneBuilder* b) {
        const auto material = b->material(kWax);
        b->add(b->prototype(box_mesh({0, 0, 0}, {1, 0.6f, 0.6f}, 3)), material);
        b->add(b->prototype(box_mesh({1, 0, 0}, {2, 0.6f, 0.6f}, 2)), material);
        for (auto& instance : b->description.instances) instance.subsurface_set = "bar";
      },
      3));
  expect_same(*touching, *whole_bar(), "touching members");
  const auto walled = testing::render(bar(
      [](SceneBuilder* b) {
        b->add(b->prototype(merged(box_mesh({0, 0, 0}, {1, 0.6f, 0.6f}, 2), box_mesh({1, 0, 0}, {2, 0.6f, 0.6f}, 2))),
               b->material(kWax));
      },
      4));
  expect_same(*walled, *whole_bar(), "welded wall");
}

TEST(UnionOfBodies, DuplicatedFacesAreOne) {
  const auto twice = testing::render(bar(
      [](SceneBuilder* b) {
        const Mesh one = box_mesh({0, 0, 0}, {2, 0.6f, 0.6f});
        b->add(b->prototype(merged(one, one)), b->material(kWax));
      },
      5));
  expect_same(*twice, *whole_bar(), "duplicated");
}

// These tests would detect a failure: without a set the light stops at the seam.
TEST(UnionOfBodies, WithoutASetEachObjectScattersForItself) {
  const auto apart = testing::render(bar(
      [](SceneBuilder* b) {
        const auto material = b->material(kWax);
        b->add(b->prototype(box_mesh({0, 0, 0}, {1, 0.6f, 0.6f})), material);
        b->add(b->prototype(box_mesh({1, 0, 0}, {2, 0.6f, 0.6f})), material);
      },
      6));
  const auto quarters = testing::compare_quarters(*apart, *whole_bar());
  EXPECT_TRUE(
      std::any_of(quarters.begin(), quarters.end(), [](const auto& quarter) { return bool(noticed(quarter)); }));
}

// Two white boxes that overlap to form a longer one.
SceneBuilder white_pair(bool set) {
  SceneBuilder b;
  const auto box = b.prototype(box_mesh({-1, -1, -1}, {1, 1, 1}, 4));
  for (const double x : {-0.5, 0.5})
    b.add(box, b.material(medium_only(1, 0.3f)), Matrix4d().setTranslation(Vec3d(x, 0, 0)));
  if (set)
    for (auto& instance : b.description.instances) instance.subsurface_set = "pair";
  b.add(testing::constant_dome(1, false));
  return b;
}

// Without a set each walk starts again where it leaves one body within the other, without an entry. Entry and exit take
// 1/42 once, as in a set.
TEST(UnionOfBodies, WhiteOverlapsStayWhite) {
  for (const bool set : {true, false}) {
    SceneBuilder b = white_pair(set);
    RenderRequest request = request_of(&b, testing::look_at({0, 0, 9}, {0, 0, 0}, 12), 16);
    request.settings.max_depth = 1000;
    RenderProgress progress;
    const MeanError m = testing::film_mean(*testing::render(request, &progress), 1);
    EXPECT_TRUE(plausible(testing::z_test(m.mean, m.standard_error, kExit, {.slack = set ? 1e-6 : 1e-3})));
    EXPECT_EQ(progress.counters.walk_lost, 0u) << "set " << set;
  }
}

// ---- orientation

TEST(Orientation, AnInvertedMeshLooksLikeASoundOne) {
  const auto picture = [](bool inverted, uint32_t seed) {
    SceneBuilder b;
    const Mesh sphere = testing::sphere_mesh(1, 24, true);
    b.add(b.prototype(inverted ? turned(sphere) : sphere), b.material(medium_only(0.8f, 0.3f)));
    LightParameters key;
    key.type = LightType::sphere;
    key.radius = 0.4f;
    key.intensity = 40;
    key.light_to_world.setTranslation(Vec3d(-2, 2, 1));
    b.add(key);
    RenderRequest request = request_of(&b, testing::look_at({0, 0, 4}, {0, 0, 0}, 35), 64);
    request.settings.seed = seed;
    return testing::render(request);
  };
  expect_same(*picture(false, 0), *picture(true, 1), "inverted");
}

// ---- open meshes

TEST(OpenMesh, APlaneIsAHalfSpace) {
  for (const float albedo : {0.5f, 0.9f}) {
    SceneBuilder b;
    b.add(b.prototype(testing::plane_mesh(40)), b.material(medium_only(albedo, 0.02f)));
    b.add(testing::constant_dome(1, false));
    CameraParameters camera = testing::look_at({0, 5, 0}, {0, 0, 0}, 30);
    camera.orthographic = true;
    camera.horizontal_aperture = camera.vertical_aperture = 2;
    RenderProgress progress;
    const MeanError m = testing::film_mean(*testing::render(request_of(&b, camera, 24), &progress), 1);
    EXPECT_TRUE(plausible(testing::z_test(m.mean, m.standard_error, albedo * kExit)));
    EXPECT_EQ(progress.counters.walk_lost, 0u);
    // Seen from below it is a half-space as well.
    b.description.instances[0].object_to_world = Matrix4d().setScale(Vec3d(1, -1, 1));
    const MeanError below = testing::film_mean(*testing::render(request_of(&b, camera, 24), &progress), 1);
    EXPECT_TRUE(plausible(testing::z_test(below.mean, below.standard_error, albedo * kExit)));
  }
}

// White and open: the light that does not come back equals the counter, to the last walk.
TEST(OpenMesh, LostLightIsCounted) {
  SceneBuilder b;
  const float hole = 0.9f;  // cosine of its half angle: a cap of 5 % of the sphere
  b.add(b.prototype(without_triangles(testing::sphere_mesh(1, 96, false), [&](const Vec3f& c) { return c.y > hole; })),
        b.material(medium_only(1, 0.3f)));
  b.add(testing::constant_dome(1, false));
  CameraParameters camera = testing::look_at({0, -5, 0}, {0, 0, 0}, 30);
  camera.orthographic = true;
  camera.horizontal_aperture = camera.vertical_aperture = 0.05f;
  RenderRequest request = request_of(&b, camera, 64);
  request.settings.max_depth = 1;
  RenderProgress progress;
  const MeanError m = testing::film_mean(*testing::render(request, &progress), 1);
  const auto& n = progress.counters;
  const double lost = n.walk_lost_energy / static_cast<double>(n.walks);
  EXPECT_GT(lost, 0.002);
  EXPECT_LT(lost, 0.05) << "less than 5 % escapes through a hole of 5 % on the opposite side";
  EXPECT_TRUE(plausible(testing::z_test(m.mean, m.standard_error, kExit * (1 - lost), {.slack = 1e-6})));
  EXPECT_EQ(n.walks, n.walk_exits + n.walk_lost + n.walk_roulette_ends);
}

// ---- camera inside: no entry, and the exit lobe is normalised

TEST(CameraWithin, WhiteStaysWhite) {
  for (const bool inverted : {false, true}) {
    SceneBuilder b;
    const Mesh sphere = testing::sphere_mesh(1, 32, true);
    b.add(b.prototype(inverted ? turned(sphere) : sphere), b.material(medium_only(1, 0.2f)));
    b.add(testing::constant_dome(1, false));
    RenderProgress progress;
    const MeanError m = testing::film_mean(
        *testing::render(request_of(&b, testing::look_at({0.3, 0.1, 0.2}, {1, 0, 0}, 90), 32), &progress), 1);
    EXPECT_TRUE(plausible(testing::z_test(m.mean, m.standard_error, 1, {.slack = 1e-6})));
    EXPECT_EQ(progress.counters.walk_lost, 0u);
  }
}

// In a set, where the first surface met belongs to a body that is entered.
TEST(CameraWithin, ASetIsOneBody) {
  SceneBuilder b = white_pair(true);
  RenderProgress progress;
  const MeanError m = testing::film_mean(
      *testing::render(request_of(&b, testing::look_at({-1.2, 0, 0}, {1, 0.1, 0.1}, 40), 32), &progress), 1);
  EXPECT_TRUE(plausible(testing::z_test(m.mean, m.standard_error, 1, {.slack = 1e-6})));
}

TEST(CameraWithin, MovingThroughTheSurfaceIsHarmless) {
  for (const double z : {1.5, 1.01, 1.0001, 1.0, 0.9999, 0.99, 0.5}) {
    SceneBuilder b;
    b.add(b.prototype(testing::sphere_mesh(1, 24, true)), b.material(medium_only(0.8f, 0.3f)));
    b.add(testing::constant_dome(1, false));
    RenderProgress progress;
    const MeanError m = testing::film_mean(
        *testing::render(request_of(&b, testing::look_at({0, 0, z}, {0, 0, -1}, 50), 16), &progress), 1);
    EXPECT_EQ(progress.counters.nonfinite_samples, 0u) << z;
    EXPECT_GT(m.mean, 0.6) << z;
    EXPECT_LT(m.mean, 1) << z;
  }
}

// ---- smooth normals

// Mean colour of the covered pixels. Coarse meshes have smaller silhouettes, which is not a fault of the shading.
double covered_mean(const Film& film) {
  const auto color = film.resolve_float(Aov::color);
  double sum = 0, coverage = 0;
  for (size_t i = 0; i < color.size(); i += 4) {
    sum += color[i + 1];
    coverage += color[i + 3];
  }
  return sum / coverage;
}

std::shared_ptr<const Film> smooth_sphere(int rings, const DisneyParameters& material, bool furnace) {
  SceneBuilder b;
  b.add(b.prototype(testing::sphere_mesh(1, rings, true)), b.material(material));
  LightParameters sun;
  sun.type = LightType::distant;
  sun.intensity = 3;
  sun.light_to_world = Matrix4d(0, 0, -1, 0, 0, 1, 0, 0, 1, 0, 0, 0, 0, 0, 0, 1);  // from +x
  b.add(furnace ? testing::constant_dome(1, false) : sun);
  return testing::render(request_of(&b, testing::look_at({0, 0, 8}, {0, 0, 0}, 15), 64, 48));
}

TEST(SmoothNormals, ACoarseSphereIsAsBrightAsAFineOne) {
  for (const float scatter_distance : {0.0f, 0.05f}) {
    DisneyParameters material = medium_only(0.8f, scatter_distance);
    const double fine = covered_mean(*smooth_sphere(96, material, false));
    for (const int rings : {8, 16, 32}) {
      const double coarse = covered_mean(*smooth_sphere(rings, material, false));
      EXPECT_NEAR(coarse / fine, 1, 0.02) << rings << " rings, scatterDistance " << scatter_distance;
    }
  }
}

TEST(SmoothNormals, WhiteStaysWhite) {
  for (const float scatter_distance : {0.0f, 0.05f})
    for (const int rings : {8, 32}) {
      // The view takes (1-.5F_V) of the Lambertian lobe, and the exit takes 1/42 of both. A fine sphere gives
      // (1-.5F_V).
      const double fine = covered_mean(*smooth_sphere(96, medium_only(1, scatter_distance), true));
      const double coarse = covered_mean(*smooth_sphere(rings, medium_only(1, scatter_distance), true));
      EXPECT_NEAR(coarse / fine, 1, 0.01) << rings << " rings, scatterDistance " << scatter_distance;
    }
}

// A lamp below a thin floor does not light the ball that rests on it.
TEST(SmoothNormals, NoLightLeaksWhereSurfacesTouch) {
  for (const float scatter_distance : {0.0f, 0.05f}) {
    SceneBuilder b;
    b.add(b.prototype(testing::sphere_mesh(1, 8, true)), b.material(medium_only(0.8f, scatter_distance)));
    b.add(b.prototype(testing::plane_mesh(40)), b.material(medium_only(0, 0)),
          Matrix4d().setTranslation(Vec3d(0, -1, 0)));
    LightParameters lamp;
    lamp.type = LightType::sphere;
    lamp.radius = 0.5f;
    lamp.intensity = 1000;
    lamp.light_to_world.setTranslation(Vec3d(0, -2.5, 0));
    b.add(lamp);
    const MeanError m =
        testing::film_mean(*testing::render(request_of(&b, testing::look_at({0, -0.5, 6}, {0, -0.5, 0}, 20), 64)), 1);
    EXPECT_EQ(m.mean, 0) << "scatterDistance " << scatter_distance;
  }
}

}  // namespace
}  // namespace alabaster
