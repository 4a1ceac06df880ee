#include "testenv/support/scene_builder.h"

#include <gtest/gtest.h>

#include <cmath>
#include <utility>

#include "testenv/support/statistics.h"

namespace alabaster::testing {
namespace {

// As delegates read parameters: within their ranges, the default where they are not finite.
DisneyParameters clamped(const DisneyParameters& parameters) {
  DisneyParameters p = parameters;
  const DisneyParameters defaults;
  for (const MaterialParameter& row : material_parameters()) {
    const auto clamp = [&](float value, float fallback) {
      constexpr double kLargest = std::numeric_limits<float>::max();
      return std::isfinite(value)
                 ? static_cast<float>(std::clamp(double(value), row.minimum, std::min(row.maximum, kLargest)))
                 : fallback;
    };
    if (const auto* number = std::get_if<float DisneyParameters::*>(&row.member))
      p.** number = clamp(p.**number, defaults.**number);
    if (const auto* color = std::get_if<Rgb DisneyParameters::*>(&row.member))
      for (int c = 0; c < 3; ++c) (p.**color)[c] = clamp((p.**color)[c], (defaults.**color)[c]);
  }
  return p;
}

const DiagnosticSink kFailOnReport = [](const Diagnostic& d) {
  if (d.severity == Severity::error) ADD_FAILURE() << d.code << " " << d.where << ": " << d.text;
};

Mesh with_bounds(Mesh mesh) {
  for (const auto& p : mesh.points) mesh.bounds.extend(p);
  for (size_t i = 0; i < mesh.triangles.size(); ++i) mesh.triangle_face.push_back(static_cast<int32_t>(i));
  return mesh;
}

}  // namespace

Mesh plane_mesh(float size) {
  Mesh mesh;
  const float h = size / 2;
  mesh.points = {{-h, 0, -h}, {-h, 0, h}, {h, 0, h}, {h, 0, -h}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  return with_bounds(std::move(mesh));
}

Mesh sphere_mesh(float radius, int rings, bool smooth) {
  Mesh mesh;
  const int segments = 2 * rings;
  const auto point = [&](int ring, int segment) {
    const double theta = M_PI * ring / rings, phi = 2 * M_PI * segment / segments;
    return Vec3f(Vec3d(std::sin(theta) * std::cos(phi), std::cos(theta), std::sin(theta) * std::sin(phi)) *
                 double(radius));
  };
  mesh.points.push_back({0, radius, 0});
  for (int r = 1; r < rings; ++r)
    for (int s = 0; s < segments; ++s) mesh.points.push_back(point(r, s));
  mesh.points.push_back({0, -radius, 0});
  const auto index = [&](int r, int s) { return static_cast<uint32_t>(1 + (r - 1) * segments + (s % segments)); };
  const auto last = static_cast<uint32_t>(mesh.points.size() - 1);
  for (int s = 0; s < segments; ++s) {
    mesh.triangles.push_back({0, index(1, s + 1), index(1, s)});
    for (int r = 1; r + 1 < rings; ++r) {
      mesh.triangles.push_back({index(r, s), index(r, s + 1), index(r + 1, s + 1)});
      mesh.triangles.push_back({index(r, s), index(r + 1, s + 1), index(r + 1, s)});
    }
    mesh.triangles.push_back({index(rings - 1, s), index(rings - 1, s + 1), last});
  }
  if (smooth)
    for (const auto& p : mesh.points) mesh.normals.push_back(normalize(p));
  mesh.closed = mesh.outward = true;
  return with_bounds(std::move(mesh));
}

SceneBuilder::SceneBuilder() : device_(make_trace_device(kFailOnReport)) {}

std::shared_ptr<const DisneyMaterial> SceneBuilder::material(const DisneyParameters& parameters) {
  auto m = std::make_shared<DisneyMaterial>();
  m->constants = clamped(parameters);
  return m;
}

std::shared_ptr<const MeshPrototype> SceneBuilder::prototype(Mesh mesh) {
  auto p = std::make_shared<MeshPrototype>();
  p->mesh = std::move(mesh);
  p->object = build_object_scene(device_, p->mesh, {});
  return p;
}

SceneBuilder& SceneBuilder::add(const std::shared_ptr<const MeshPrototype>& prototype,
                                const std::shared_ptr<const DisneyMaterial>& material,
                                const Matrix4d& object_to_world) {
  InstanceDescription instance;
  instance.prototype = prototype;
  instance.materials = {material};
  instance.object_to_world = object_to_world;
  instance.prim_id = static_cast<int32_t>(description.instances.size());
  instance.name = "/test/" + std::to_string(instance.prim_id);
  description.instances.push_back(instance);
  return *this;
}

SceneBuilder& SceneBuilder::add(const LightParameters& light) {
  description.lights.push_back(light);
  return *this;
}

std::shared_ptr<const SceneSnapshot> SceneBuilder::snapshot(uint64_t number) {
  return compile_snapshot(description, number, device_, kFailOnReport);
}

LightParameters constant_dome(float radiance, bool visible_to_camera) {
  LightParameters dome;
  dome.type = LightType::dome;
  dome.intensity = radiance;
  dome.visible_to_camera = visible_to_camera;
  return dome;
}

CameraParameters look_at(const Vec3d& eye, const Vec3d& target, double fov_degrees) {
  const Vec3d z = normalize(eye - target);
  const Vec3d up = std::abs(z.y) > 0.99 ? Vec3d(0, 0, 1) : Vec3d(0, 1, 0);
  const Vec3d x = normalize(cross(up, z)), y = cross(z, x);
  CameraParameters camera;
  camera.camera_to_world = Matrix4d(x.x, x.y, x.z, 0, y.x, y.y, y.z, 0, z.x, z.y, z.z, 0, eye.x, eye.y, eye.z, 1);
  camera.focal_length = 1;
  camera.horizontal_aperture = camera.vertical_aperture = static_cast<float>(2 * std::tan(fov_degrees * M_PI / 360));
  return camera;
}

RenderRequest mixed_request(uint32_t samples) {
  SceneBuilder b;
  DisneyParameters skin;
  skin.base_color = {0.9f, 0.6f, 0.45f};
  skin.scatter_distance = {0.1f, 0.05f, 0.03f};
  DisneyParameters floor;
  floor.roughness = 0.3f;
  b.add(b.prototype(sphere_mesh(0.5f, 16, true)), b.material(skin), Matrix4d().setTranslation(Vec3d(0, 0.5, 0)));
  b.add(b.prototype(plane_mesh(4)), b.material(floor));
  LightParameters key;
  key.type = LightType::sphere;
  key.radius = 0.3f;
  key.intensity = 20;
  key.light_to_world.setTranslation(Vec3d(2, 3, 1));
  b.add(key).add(constant_dome(0.3f, true));
  RenderRequest request;
  request.scene = b.snapshot();
  request.camera = look_at({0, 1.2, 3}, {0, 0.5, 0}, 35);
  request.width = request.height = 72;
  request.data_window = {0, 0, 72, 72};
  request.aovs = ~AovSet{0};
  request.settings.samples = samples;
  return request;
}

std::shared_ptr<const Film> render(const RenderRequest& of_first_run, RenderProgress* progress) {
  RenderRequest request = of_first_run;
  request.settings.seed = run_seed(request.settings.seed);
  request.settings.samples = run_samples(request.settings.samples);
  RenderSession session;
  session.start(request);
  EXPECT_TRUE(session.wait(600));
  EXPECT_EQ(session.progress().state, SessionState::finished) << session.progress().error;
  if (progress) *progress = session.progress();
  return session.film();
}

MeanError film_mean(const Film& film, int channel) {
  const auto color = film.resolve_float(Aov::color);
  const auto n = static_cast<double>(color.size() / 4);
  double sum = 0, squares = 0;
  for (size_t i = static_cast<size_t>(channel); i < color.size(); i += 4) {
    sum += color[i];
    squares += static_cast<double>(color[i]) * color[i];
  }
  const double mean = sum / n;
  return {mean, std::sqrt(std::max(0.0, squares / n - mean * mean) / (n - 1))};
}

}  // namespace alabaster::testing
