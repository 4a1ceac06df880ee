// A blurred picture is the mean of still ones over the shutter: by z-tests of blocks of pixels against pictures of
// still scenes, each posed at a random time of its stratum of the shutter.
#include <gtest/gtest.h>

#include <array>

#include "testenv/support/memory_texture.h"
#include "testenv/support/scene_builder.h"
#include "testenv/support/z_test.h"

namespace alabaster::testing {
namespace {

constexpr int kSize = 24, kBlock = 6, kBlocks = kSize / kBlock;

Matrix4d turned(const Vec3d& axis, double degrees) {
  return Matrix4d().setAxisAngle(axis, degrees * kPiDouble / 180);
}
Matrix4d shifted(double x, double y, double z) {
  return Matrix4d().setTranslation(Vec3d(x, y, z));
}

/// The placement of a moving thing at a time 0..1 of the shutter.
using Motion = std::function<Matrix4d(double)>;

std::vector<Matrix4d> poses_of(const Motion& motion) {
  TimeSamples<Matrix4d> samples;
  constexpr int kSamples = 32;  // translations along a circle
  for (int i = 0; i <= kSamples; ++i) {
    samples.times.push_back(double(i) / kSamples);
    samples.values.push_back(motion(samples.times.back()));
  }
  return even_poses(samples, {0, 1});
}

// The sphere as a mesh that bulges to one side.
std::vector<Vec3f> bulged(const std::vector<Vec3f>& points, double time) {
  std::vector<Vec3f> out = points;
  const auto t = static_cast<float>(time);
  for (Vec3f& p : out) p = {p.x * (1 + 0.8f * t), p.y * (1 - 0.4f * t) + 0.4f * t * p.x, p.z};
  return out;
}
std::vector<Vec3f> bulged_normals(const std::vector<Vec3f>& points, double time) {
  // Transposed inverse of the linear map of bulged().
  const auto t = static_cast<float>(time);
  const float a = 1 + 0.8f * t, b = 0.4f * t, c = 1 - 0.4f * t;
  std::vector<Vec3f> out;
  for (const Vec3f& p : points) out.push_back(normalize(Vec3f(p.x / a - p.y * b / (a * c), p.y / c, p.z)));
  return out;
}

class MotionBlur : public ::testing::Test {
 protected:
  MotionBlur() {
    DisneyParameters grey;
    grey.base_color = Rgb(0.6f);
    grey.roughness = 0.4f;
    grey_ = builder_.material(grey);
    DisneyParameters wax;
    wax.base_color = {0.9f, 0.7f, 0.5f};
    wax.scatter_distance = {0.2f, 0.1f, 0.05f};
    wax_ = builder_.material(wax);
    DisneyParameters glass;
    glass.spec_trans = 1;
    glass.roughness = 0.2f;
    glass_ = builder_.material(glass);
    DisneyParameters glow;
    glow.emission = Rgb(4.0f);
    glow_ = builder_.material(glow);
    box_ = builder_.prototype(sphere_mesh(0.5f, 2, false));  // an octahedron
    sphere_ = builder_.prototype(sphere_mesh(0.5f, 10, true));
    builder_.add(builder_.prototype(plane_mesh(6)), grey_, shifted(0, -0.6, 0));
    LightParameters key;
    key.type = LightType::sphere;
    key.radius = 0.4f;
    key.intensity = 10;
    key.light_to_world = shifted(1.5, 2.5, 1.5);
    builder_.add(key).add(constant_dome(0.4f, true));
    request_.camera = look_at({0, 1, 4}, {0, 0, 0}, 40);
    request_.width = request_.height = kSize;
    request_.data_window = {0, 0, kSize, kSize};
  }

  void add(const std::shared_ptr<const MeshPrototype>& shape, const std::shared_ptr<const DisneyMaterial>& material,
           const Motion& motion) {
    builder_.add(shape, material);
    motions_.emplace_back(builder_.description.instances.size() - 1, motion);
  }
  void add(const LightParameters& light, const Motion& motion) {
    builder_.add(light);
    light_motions_.emplace_back(builder_.description.lights.size() - 1, motion);
  }
  /// One of each kind that moves; the sphere is seen. `others`: point lights that stand still.
  void add_moving_lights(int others) {
    LightParameters lamp;
    lamp.visible_to_camera = true;
    lamp.intensity = 6, lamp.width = lamp.height = 0.5f, lamp.radius = 0.15f, lamp.angle = 8;
    add(lamp, [](double t) { return turned({1, 0, 0}, 20 - 60 * t) * shifted(-1 + 2 * t, 1, 0.5); });
    lamp.type = LightType::sphere;
    add(lamp, [](double t) { return shifted(0.8 - t, 0.1 + 0.4 * t, 0.3); });
    lamp.type = LightType::distant, lamp.intensity = 30;
    add(lamp, [](double t) { return turned({0, 1, 0}, 80 * t - 40) * turned({1, 0, 0}, -50); });
    lamp.type = LightType::sphere, lamp.treat_as_point = true, lamp.intensity = 0.1f;
    for (int i = 0; i < others; ++i) {
      lamp.light_to_world = shifted(-2 + 0.05 * i, 2, -1);
      builder_.add(lamp);
    }
  }
  /// Names the set of the last object.
  void scatter_in(const char* set) { builder_.description.instances.back().subsurface_set = set; }

  using BlockMeans = std::array<double, size_t(kBlocks* kBlocks * 3)>;
  static BlockMeans block_means(const Film& film) {
    BlockMeans means{};
    const auto color = film.resolve_float(Aov::color);
    for (int y = 0; y < kSize; ++y)
      for (int x = 0; x < kSize; ++x)
        for (int c = 0; c < 3; ++c)
          means[static_cast<size_t>(((y / kBlock) * kBlocks + x / kBlock) * 3 + c)] +=
              double(color[static_cast<size_t>((y * kSize + x) * 4 + c)]) / (kBlock * kBlock);
    return means;
  }

  BlockMeans still_picture(double time, uint32_t seed) {
    SceneBuilder still = builder_;
    for (const auto& [index, motion] : motions_) still.description.instances[index].object_to_world = motion(time);
    for (const auto& [index, motion] : light_motions_) still.description.lights[index].light_to_world = motion(time);
    if (deform_) still.description.instances[deforming_].prototype = deform_(time);
    RenderRequest request = request_;
    request.scene = still.snapshot();
    request.settings.seed = seed;
    request.settings.samples = 1;
    if (camera_) request.camera.camera_to_world = camera_(time);
    if (lens_) lens_(time, &request.camera);
    return block_means(*render(request));
  }

  void expect_mean_of_stills() {
    constexpr uint32_t kReplicas = 24, kStrata = 24;
    RenderRequest blurred = request_;
    {
      SceneBuilder moving = builder_;
      for (const auto& [index, motion] : motions_) {
        moving.description.instances[index].poses = poses_of(motion);
        moving.description.instances[index].object_to_world = motion(0);
      }
      for (const auto& [index, motion] : light_motions_) {
        LightParameters& light = moving.description.lights[index];
        light.poses = poses_of(motion);
        light.light_to_world = light.poses.front();
      }
      if (moving_shape_) moving.description.instances[deforming_].prototype = moving_shape_;
      if (camera_) blurred.camera.poses = poses_of(camera_);
      blurred.camera.opens = 0, blurred.camera.closes = 1;
      if (lens_) {
        blurred.camera.shutter_close = 1;
        for (const double time : {0.0, 1.0}) {
          CameraParameters then = request_.camera;
          lens_(time, &then);
          for (const auto& [value, samples] : {std::pair(then.focal_length, &blurred.camera.focal_lengths),
                                               std::pair(then.f_stop, &blurred.camera.f_stops),
                                               std::pair(then.focus_distance, &blurred.camera.focus_distances)})
            samples->times.push_back(time), samples->values.push_back(value);
        }
        open_lens(&blurred.camera);
      }
      blurred.scene = moving.snapshot();
    }
    std::vector<RunningStatistics> with(BlockMeans().size()), without(BlockMeans().size());
    Rng rng(run_seed(1), 2);
    for (uint32_t replica = 0; replica < run_samples(kReplicas); ++replica) {
      blurred.settings.seed = 1000 + replica;
      blurred.settings.samples = kStrata;
      const BlockMeans means = block_means(*render(blurred));
      BlockMeans stills{};
      for (uint32_t i = 0; i < kStrata; ++i) {
        const double time = (i + double(rng.uniform())) / kStrata;
        const BlockMeans one = still_picture(time, replica * kStrata + i);
        for (size_t b = 0; b < one.size(); ++b) stills[b] += one[b] / kStrata;
      }
      for (size_t b = 0; b < means.size(); ++b) with[b].add(means[b]), without[b].add(stills[b]);
    }
    for (size_t b = 0; b < with.size(); ++b) {
      // Rounding, of blocks that show the dome alone.
      EXPECT_TRUE(plausible(z_test(with[b], without[b], {.slack = 1e-6}))) << "block " << b / 3 << " channel " << b % 3;
    }
  }

  SceneBuilder builder_;
  std::shared_ptr<const DisneyMaterial> grey_, wax_, glass_, glow_;
  std::shared_ptr<const MeshPrototype> box_, sphere_;
  std::vector<std::pair<size_t, Motion>> motions_, light_motions_;
  Motion camera_;
  std::function<void(double, CameraParameters*)> lens_;
  size_t deforming_ = 0;
  std::function<std::shared_ptr<const MeshPrototype>(double)> deform_;
  std::shared_ptr<const MeshPrototype> moving_shape_;
  RenderRequest request_;

  void add_bulging(const std::shared_ptr<const DisneyMaterial>& material) {
    const Mesh rest = sphere_mesh(0.6f, 10, true);
    const auto mesh_at = [this, rest](double time) {
      Mesh mesh = rest;
      mesh.points = bulged(rest.points, time);
      mesh.normals = bulged_normals(rest.points, time);
      mesh.bounds = {};
      for (const Vec3f& p : mesh.points) mesh.bounds.extend(p);
      return mesh;
    };
    Mesh moving = mesh_at(0);
    constexpr int kPoses = 9;  // for the normals, which do not go along straight lines
    for (int i = 1; i < kPoses; ++i) {
      const Mesh later = mesh_at(double(i) / (kPoses - 1));
      moving.later_poses.push_back({later.points, later.normals});
      moving.bounds.extend(later.bounds);
    }
    moving_shape_ = builder_.prototype(std::move(moving));
    builder_.add(builder_.prototype(rest), material);
    deforming_ = builder_.description.instances.size() - 1;
    deform_ = [this, mesh_at](double time) { return builder_.prototype(mesh_at(time)); };
  }
};

TEST_F(MotionBlur, TranslationIsTheMeanOfStills) {
  add(sphere_, grey_, [](double t) { return shifted(-0.8 + 1.6 * t, 0.3 * t, 0); });
  expect_mean_of_stills();
}

TEST_F(MotionBlur, RotationIsTheMeanOfStills) {
  add(box_, grey_, [](double t) { return shifted(0.7, 0, 0) * turned({0, 0, 1}, 150 * t - 40); });
  expect_mean_of_stills();
}

TEST_F(MotionBlur, DeformationIsTheMeanOfStills) {
  add_bulging(grey_);
  expect_mean_of_stills();
}

TEST_F(MotionBlur, CameraMotionIsTheMeanOfStills) {
  add(box_, grey_, [](double) { return Matrix4d(); });
  motions_.clear();
  camera_ = [](double t) { return look_at({1.5 * t - 0.5, 1 + t, 4 - t}, {0.3 * t, 0, 0}, 40).camera_to_world; };
  expect_mean_of_stills();
}

// A zoom with an aperture that opens and a focus that goes from the front to the back.
TEST_F(MotionBlur, ALensThatMovesIsTheMeanOfStills) {
  add(box_, glow_, [](double) { return shifted(0.4, 0, 1); });
  add(sphere_, grey_, [](double) { return shifted(-0.4, 0, -1); });
  motions_.clear();
  lens_ = [focal = request_.camera.focal_length](double t, CameraParameters* camera) {
    const auto share = static_cast<float>(t);
    camera->focal_length = focal * (0.8f + 0.8f * share);
    camera->f_stop = focal * (4 - 3 * share), camera->focus_distance = 3 + 2.5f * share;
  };
  expect_mean_of_stills();
}

TEST_F(MotionBlur, ScatteringBodyIsTheMeanOfStills) {
  add(sphere_, wax_, [](double t) { return turned({0, 0, 1}, 60 * t) * shifted(-0.6 + 1.2 * t, 0, 0); });
  expect_mean_of_stills();
}

TEST_F(MotionBlur, DeformingBodyIsTheMeanOfStills) {
  add_bulging(wax_);
  expect_mean_of_stills();
}

// A ball moves out of another one, and both scatter as one body.
TEST_F(MotionBlur, UnionOfBodiesIsTheMeanOfStills) {
  add(sphere_, wax_, [](double t) { return shifted(-0.3 + 0.1 * t, 0, 0); });
  scatter_in("both");
  add(sphere_, wax_, [](double t) { return shifted(0.8 * t, 0.2 * t, 0); });
  scatter_in("both");
  expect_mean_of_stills();
}

TEST_F(MotionBlur, BodyInModeDiffusionIsTheMeanOfStills) {
  request_.settings.subsurface = SubsurfaceMode::diffusion;
  add(sphere_, wax_, [](double t) { return turned({0, 0, 1}, 60 * t) * shifted(-0.6 + 1.2 * t, 0, 0); });
  expect_mean_of_stills();
}

TEST_F(MotionBlur, GlassIsTheMeanOfStills) {
  add(sphere_, glass_, [](double t) { return shifted(-0.6 + 1.2 * t, 0, 0); });
  expect_mean_of_stills();
}

// In the still pictures its triangles are sampled, in the blurred one lobes find them.
TEST_F(MotionBlur, MeshLightIsTheMeanOfStills) {
  add(box_, glow_, [](double t) { return shifted(-0.6 + 1.2 * t, 0.2, 0); });
  expect_mean_of_stills();
}

// All are sampled.
TEST_F(MotionBlur, LightsAreTheMeanOfStills) {
  builder_.description.lights.clear();
  add_moving_lights(1);
  builder_.add(sphere_, grey_);
  expect_mean_of_stills();
}

// The types that add_moving_lights() has not: a disk and a cylinder that are seen, and a dome with an image that turns.
TEST_F(MotionBlur, OtherLightsAreTheMeanOfStills) {
  builder_.description.lights.clear();
  LightParameters lamp;
  lamp.visible_to_camera = true;
  lamp.type = LightType::disk, lamp.intensity = 8, lamp.radius = 0.3f;
  add(lamp, [](double t) { return turned({1, 0, 0}, 30 - 80 * t) * shifted(-0.9 + 0.6 * t, 0.7, -0.2); });
  lamp.type = LightType::cylinder, lamp.intensity = 3, lamp.radius = 0.1f, lamp.length = 0.6f;
  add(lamp, [](double t) { return turned({0, 0, 1}, 100 * t) * shifted(1 - 0.5 * t, 0.5, 0.2); });
  LightParameters sky;
  sky.type = LightType::dome;
  sky.visible_to_camera = true;
  std::vector<Rgb> texels(size_t{16} * 8, Rgb(0.1f));
  for (size_t y = 1; y < 4; ++y) texels[16 * y + 5] = Rgb(6, 3, 1), texels[16 * y + 11] = Rgb(0.3f, 0.6f, 2);
  sky.texture = std::make_shared<MemoryTexture>(16, texels);
  add(sky, [](double t) { return turned({0, 1, 0}, 90 * t); });
  builder_.add(sphere_, grey_);
  expect_mean_of_stills();
}

// One is chosen, by its importance.
TEST_F(MotionBlur, ChosenLightsAreTheMeanOfStills) {
  add_moving_lights(5);
  builder_.add(sphere_, grey_);
  expect_mean_of_stills();
}

// By the tree.
TEST_F(MotionBlur, LightsOfATreeAreTheMeanOfStills) {
  add_moving_lights(130);
  builder_.add(sphere_, wax_);
  expect_mean_of_stills();
}

}  // namespace
}  // namespace alabaster::testing
