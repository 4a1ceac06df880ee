// Measures whole frames against Embree's own limit: a render's CPU time over that of tracing the same rays alone.
//   render_benchmark [--samples N] [--size N] [--out FILE.json]
// Rays are recorded through wrappers of the two scene interfaces, then replayed in order; render and replay are timed
// in the same process, single-threaded, by CPU time.

#include <cstdio>
#include <fstream>
#include <iostream>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>

#include "core/subsurface/body.h"
#include "delegate/support/process_usage.h"
#include "testenv/support/scene_builder.h"

namespace alabaster {
namespace {

struct RecordedRay {
  Ray ray;
  const ObjectScene* object = nullptr;  // null: the instanced scene
  bool occlusion = false;
};
using Recording = std::vector<RecordedRay>;

class RecordingObject : public ObjectScene {
 public:
  RecordingObject(std::shared_ptr<const ObjectScene> inner, Recording* rays) : inner_(std::move(inner)), rays_(rays) {}
  bool intersect(const Ray& ray, TriangleHit* hit) const override {
    rays_->push_back({ray, inner_.get(), false});
    return inner_->intersect(ray, hit);
  }
  void intersect_all(const Ray& ray, std::pmr::vector<TriangleHit>* hits) const override {
    inner_->intersect_all(ray, hits);  // no mode measured here calls it
  }
  size_t memory_bytes() const override { return inner_->memory_bytes(); }

 private:
  std::shared_ptr<const ObjectScene> inner_;
  Recording* rays_;
};

class RecordingTop : public InstancedScene {
 public:
  RecordingTop(std::shared_ptr<const InstancedScene> inner, Recording* rays) : inner_(std::move(inner)), rays_(rays) {}
  bool intersect(const Ray& ray, TriangleHit* hit) const override {
    rays_->push_back({ray, nullptr, false});
    return inner_->intersect(ray, hit);
  }
  bool occluded(const Ray& ray) const override {
    rays_->push_back({ray, nullptr, true});
    return inner_->occluded(ray);
  }
  size_t memory_bytes() const override { return inner_->memory_bytes(); }

 private:
  std::shared_ptr<const InstancedScene> inner_;
  Recording* rays_;
};

/// A lumpy closed body: spherical harmonics-like bumps on a sphere, smooth normals left out (Embree sees triangles
/// only).
Mesh blob_mesh(int rings) {
  Mesh mesh = testing::sphere_mesh(1, rings, true);
  mesh.bounds = {};
  for (auto& p : mesh.points) {
    const float bump = std::sin(5 * p.x + 1) * std::sin(4 * p.y) * std::sin(6 * p.z + 2);
    p *= 0.5f * (1 + 0.25f * bump);
    mesh.bounds.extend(p);
  }
  return mesh;
}

struct Case {
  std::string name;
  DisneyParameters body;
};

std::vector<Case> cases() {
  DisneyParameters plain, skin, marble;
  plain.base_color = {0.9f, 0.6f, 0.45f};
  skin = plain;
  skin.scatter_distance = {0.05f, 0.0175f, 0.01f};
  marble.base_color = {0.99f, 0.97f, 0.9f};
  marble.scatter_distance = {0.05f, 0.045f, 0.04f};
  return {{"no subsurface", plain}, {"skin", skin}, {"marble", marble}};
}

SceneDescription describe(testing::SceneBuilder* builder, const std::shared_ptr<const MeshPrototype>& blob,
                          const Case& c) {
  builder->description = {};
  builder->add(blob, builder->material(c.body), Matrix4d().setTranslation(Vec3d(0, 0.5, 0)));
  builder->add(builder->prototype(testing::plane_mesh(6)), builder->material({}));
  LightDescription key;
  key.type = LightType::sphere;
  key.radius = 0.3f;
  key.intensity = 30;
  key.light_to_world.setTranslation(Vec3d(-2, 3, -1));
  builder->add(key).add(testing::constant_dome(0.3f, true));
  return builder->description;
}

double replay(const Recording& rays, const InstancedScene& top) {
  const double begin = hd::support::process_cpu_seconds();
  size_t hits = 0;
  TriangleHit hit;
  for (const auto& r : rays)
    hits += r.object      ? r.object->intersect(r.ray, &hit)
            : r.occlusion ? top.occluded(r.ray)
                          : top.intersect(r.ray, &hit);
  const double seconds = hd::support::process_cpu_seconds() - begin;
  if (hits == rays.size() + 1) std::puts("");  // uses the hits, so that the loop is not optimized away
  return seconds;
}

nlohmann::json measure(const Case& c, const RenderRequest& base, testing::SceneBuilder* builder,
                       const std::shared_ptr<const MeshPrototype>& blob) {
  describe(builder, blob, c);
  RenderRequest request = base;
  request.scene = builder->snapshot();
  RenderProgress progress;
  testing::render(request, &progress);  // warms caches
  const double begin = hd::support::process_cpu_seconds();
  testing::render(request, &progress);
  const double render_seconds = hd::support::process_cpu_seconds() - begin;

  Recording rays;
  SceneSnapshot recorded = *request.scene;
  recorded.top = std::make_shared<RecordingTop>(request.scene->top, &rays);
  std::vector<std::shared_ptr<MeshPrototype>> wrapped;
  for (auto& instance : recorded.instances) {
    wrapped.push_back(std::make_shared<MeshPrototype>());
    wrapped.back()->mesh = instance.prototype->mesh;
    wrapped.back()->object = std::make_shared<RecordingObject>(instance.prototype->object, &rays);
    instance.prototype = wrapped.back().get();
    if (!instance.body) continue;
    const auto body = std::make_shared<SubsurfaceBody>(*instance.body);
    body->members[instance.member].object = wrapped.back()->object.get();
    instance.body = body.get();
    recorded.bodies.push_back(body);
  }
  RenderRequest recording = request;
  recording.scene = std::make_shared<SceneSnapshot>(recorded);
  testing::render(recording);
  const double embree_seconds = replay(rays, *request.scene->top);

  const auto& n = progress.counters;
  return {{"scene", c.name},
          {"samples", n.samples},
          {"samplesPerCpuSecond", static_cast<double>(n.samples) / render_seconds},
          {"raysPerCpuSecond", static_cast<double>(n.rays()) / render_seconds},
          {"raysPerSample", static_cast<double>(n.rays()) / static_cast<double>(n.samples)},
          {"walkRaysPerWalk", n.walks ? static_cast<double>(n.walk_rays) / static_cast<double>(n.walks) : 0.0},
          {"renderCpuSeconds", render_seconds},
          {"bareEmbreeCpuSeconds", embree_seconds},
          {"renderToBareEmbree", render_seconds / embree_seconds}};
}

int run(int argc, char** argv) {
  RenderRequest request;
  request.settings.samples = 8;
  request.settings.threads = 1;
  int size = 256;
  std::string out;
  for (int i = 1; i + 1 < argc; i += 2) {
    const std::string flag = argv[i];
    if (flag == "--samples")
      request.settings.samples = static_cast<uint32_t>(std::stoi(argv[i + 1]));
    else if (flag == "--size")
      size = std::stoi(argv[i + 1]);
    else if (flag == "--out")
      out = argv[i + 1];
    else
      return std::fprintf(stderr, "unknown option %s\n", argv[i]), 2;
  }
  request.width = request.height = size;
  request.data_window = {0, 0, size, size};
  request.camera = testing::look_at({0, 1.2, 3}, {0, 0.5, 0}, 30);

  testing::SceneBuilder builder;
  const auto blob = builder.prototype(blob_mesh(256));
  nlohmann::json results = nlohmann::json::array();
  std::printf(
      "| scene | samples/s | rays/s | rays/sample | segments/walk | render : bare Embree |\n|--|--|--|--|--|--|\n");
  for (const auto& c : cases()) {
    const auto r = measure(c, request, &builder, blob);
    std::printf("| %s | %.0f | %.0f | %.1f | %.1f | %.2f |\n", c.name.c_str(), r["samplesPerCpuSecond"].get<double>(),
                r["raysPerCpuSecond"].get<double>(), r["raysPerSample"].get<double>(),
                r["walkRaysPerWalk"].get<double>(), r["renderToBareEmbree"].get<double>());
    std::fflush(stdout);
    results.push_back(r);
  }
  if (!out.empty()) std::ofstream(out) << results.dump(2) << "\n";
  return 0;
}

}  // namespace
}  // namespace alabaster

int main(int argc, char** argv) {
  return alabaster::run(argc, argv);
}
