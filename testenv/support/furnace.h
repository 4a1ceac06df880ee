// White furnaces: white albedo under a sky of 1 shows 1, in each pixel.
#pragma once

#include <gtest/gtest.h>

#include <functional>
#include <string>
#include <vector>

#include "testenv/support/path_tracer.h"
#include "testenv/support/z_test.h"

namespace alabaster::testing {

/// No specular reflection. At roughness .5 retro-reflection compensates for the albedo of entry and exit.
inline DisneyParameters white_body(float scatter_distance) {
  DisneyParameters p;
  p.base_color = Rgb(1.0f);
  p.scatter_distance = Rgb(scatter_distance);
  p.specular = 0;
  return p;
}

/// Lossless; walks scatter in it if `scatter_distance` is above 0.
inline DisneyParameters clear_body(float ior, float scatter_distance = 0) {
  DisneyParameters p;
  p.base_color = Rgb(1.0f);
  p.spec_trans = 1;
  p.roughness = 0;
  p.ior = ior;
  p.scatter_distance = Rgb(scatter_distance);
  return p;
}

inline Matrix4d moved_by(double x, double y, double z) {
  return Matrix4d().setTranslation(Vec3d(x, y, z));
}
inline Matrix4d scaled_by(double factor) {
  return Matrix4d().setScale(Vec3d(factor, factor, factor));
}

/// Instances that name the same set scatter as one.
inline void add(SceneBuilder* b, const std::shared_ptr<const MeshPrototype>& mesh, const DisneyParameters& p,
                const Matrix4d& place = Matrix4d(), const char* set = "") {
  b->add(mesh, b->material(p), place);
  b->description.instances.back().subsurface_set = set;
}

class ListedPlaces final : public InstancePlaces {
 public:
  explicit ListedPlaces(std::vector<Matrix4d> places) : places_(std::move(places)) {}
  size_t size() const override { return places_.size(); }
  std::optional<Matrix4d> at(size_t number) const override { return places_[number]; }
  bool stand_alike(const InstancePlaces&, size_t, size_t) const override { return false; }

 private:
  std::vector<Matrix4d> places_;
};

/// The instance that was added last becomes an array.
inline void make_last_an_array(SceneBuilder* b, std::vector<Matrix4d> places) {
  b->description.arrays.push_back(
      {b->description.instances.back(), std::make_shared<const ListedPlaces>(std::move(places))});
  b->description.instances.pop_back();
}

/// Means of runs of 32 samples, which may be stratified.
inline RunningStatistics look(PathTracer* tracer, int runs, const std::function<double(const FilmSample&)>& value) {
  constexpr int kSamples = 32;
  RunningStatistics statistics;
  uint32_t index = 0;
  for (int r = 0; r < run_samples(runs); ++r) {
    double sum = 0;
    for (int i = 0; i < kSamples; ++i) sum += value(tracer->trace(index++));
    statistics.add(sum / kSamples);
  }
  return statistics;
}

struct Sight {
  const char* what;
  Vec3d eye, target{0, 0, 0};
  double level = 1;  // of colour and alpha
};

struct FurnaceTest {
  SubsurfaceMode mode = SubsurfaceMode::walk;
  int runs = 48;
  double slack = 2e-3;           // facets, and how well lobes compensate for each other
  bool sees_background = false;  // by the camera: then alpha is 1
};

/// Each sight has its level under a white sky.
inline void expect_furnace(const SceneBuilder& builder, const std::vector<Sight>& sights, const FurnaceTest& test,
                           const std::string& where) {
  SceneBuilder b = builder;
  b.add(constant_dome(1, test.sees_background));
  const auto scene = b.snapshot();
  for (const Sight& sight : sights) {
    PathTracer tracer(scene, sight.eye, sight.target);
    tracer.settings.max_depth = 256;
    tracer.settings.subsurface = test.mode;
    const ZTestOptions options{.slack = test.slack * sight.level};
    const auto color = look(&tracer, test.runs, [](const FilmSample& s) { return double(s.color.g); });
    const auto seen = z_test(color, sight.level, options);
    EXPECT_TRUE(plausible(seen)) << where << ", " << sight.what << ", mode " << int(test.mode);
    if (test.sees_background) continue;
    const auto alpha = look(&tracer, test.runs, [](const FilmSample& s) { return double(s.alpha); });
    const auto covered = z_test(alpha, sight.level, options);
    EXPECT_TRUE(plausible(covered)) << where << ", " << sight.what << ", alpha: ";
  }
}

}  // namespace alabaster::testing
