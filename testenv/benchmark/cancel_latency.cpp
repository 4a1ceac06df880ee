// How soon a build gives way to newer edits, stage by stage: for each stage a scene in which it takes most of the time.
// While the scene is being built the host takes the heavy prim away again, at times that are spread over the whole
// build, and waits until the scene without it stands. Uses the public door only. Prints Markdown.
//   cancel_latency [--repeats N] [--only PART OF A NAME]
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <string>
#include <thread>

#include "delegate/host/retained_scene_delegate.h"
#include "testenv/benchmark/waiting_times.h"

namespace alabaster::hd {
namespace {

// A closed ball of cages: a cube's faces, each cut into n x n quads.
host::MeshDescription ball(int n, int refine_level, const char* material) {
  host::MeshDescription mesh;
  std::vector<Vec3f> points;
  std::vector<int32_t> indices;
  for (int side = 0; side < 6; ++side) {
    const auto first = static_cast<int32_t>(points.size());
    for (int y = 0; y <= n; ++y)
      for (int x = 0; x <= n; ++x) {
        const float u = 2.0f * float(x) / float(n) - 1, v = 2.0f * float(y) / float(n) - 1;
        const float sign = side % 2 ? 1.0f : -1.0f;
        Vec3f p(u * sign, v, sign);
        if (side / 2 == 1) p = {p.z, p.x, p.y};
        if (side / 2 == 2) p = {p.y, p.z, p.x};
        points.push_back(p.normalized());
      }
    for (int y = 0; y < n; ++y)
      for (int x = 0; x < n; ++x) {
        const int32_t corner = first + y * (n + 1) + x;
        indices.insert(indices.end(), {corner, corner + 1, corner + n + 2, corner + n + 1});
      }
  }
  mesh.topology.scheme = refine_level > 0 ? "catmullClark" : "none";
  mesh.topology.faceVertexCounts = std::vector<int32_t>(indices.size() / 4, 4);
  mesh.topology.faceVertexIndices = std::move(indices);
  mesh.primvars["points"].value = Array<Vec3f>(std::move(points));
  mesh.displayStyle.refineLevel = refine_level;
  mesh.material = material;
  return mesh;
}

MaterialNetwork surface(std::map<Token, Value> parameters) {
  MaterialNetwork network;
  network.nodes["surface"].nodeTypeId = "AlabasterDisney";
  network.nodes["surface"].parameters = std::move(parameters);
  network.terminals["surface"] = {"surface", "surface"};
  return network;
}

AssetPath sky(int width, int height) {
  return radiance_image(width, height, [](int x, int y) {
    return std::array<uint8_t, 4>{uint8_t(x), uint8_t(y), 200, uint8_t(x % 512 ? 128 : 133)};
  });
}

class Host {
 public:
  Host() {
    DelegateOptions options;
    options.diagnostics = [](const Diagnostic& d) {
      if (d.severity == Severity::error) std::fprintf(stderr, "%s: %s\n", d.where.c_str(), d.text.c_str());
    };
    delegate_ = CreateAlabasterRenderDelegate(kAbiVersion, &options);
    if (!delegate_) std::exit(1);
    index_ = std::make_unique<host::RenderIndex>(delegate_);
    scene.SetMaterial("/matte", surface({{"baseColor", Vec3f(0.5f)}}));
    scene.SetMaterial("/wax", surface({{"baseColor", Vec3f(0.8f)}, {"scatterDistance", Vec3f(0.01f)}}));
    scene.SetMaterial("/lamp", surface({{"emission", Vec3f(1.0f)}}));
    scene.SetMesh("/small", ball(8, 0, "/wax"));
    scene.Populate(index_.get());
    sync();
    wait();
  }
  ~Host() {
    scene.Depopulate();
    index_.reset();
    DestroyAlabasterRenderDelegate(delegate_);
  }
  Host(const Host&) = delete;
  Host& operator=(const Host&) = delete;

  void sync() {
    index_->SyncAll();
    delegate_->CommitResources();
  }
  void wait() { delegate_->InvokeCommand("waitForScene", {}); }

  host::RetainedSceneDelegate scene;

 private:
  RenderDelegate* delegate_ = nullptr;
  std::unique_ptr<host::RenderIndex> index_;
};

struct Stage {
  const char* name;
  std::function<void(host::RetainedSceneDelegate&)> add, take_away;
};

void take_heavy(host::RetainedSceneDelegate& scene) {
  for (const char* path : {"/heavy", "/places", "/sky"}) scene.Remove(path);
}

std::vector<Stage> stages() {
  using Scene = host::RetainedSceneDelegate;
  const auto mesh = [](int n, int level, const char* material) {
    return [heavy = ball(n, level, material)](Scene& scene) { scene.SetMesh("/heavy", heavy); };
  };
  const auto dome = [image = sky(8192, 4096)](Scene& scene) {
    scene.SetLight("/sky", {.type = "domeLight", .transform = {}, .parameters = {{"texture:file", image}}});
  };
  const auto instances = [](Scene& scene) {
    constexpr int kCount = 500000;
    std::vector<Vec3f> places;
    std::vector<int32_t> indices;
    for (int i = 0; i < kCount; ++i) {
      places.emplace_back(float(i % 1000), float(i / 1000), 0.0f);
      indices.push_back(i);
    }
    host::InstancerDescription placed;
    placed.primvars["hydra:instanceTranslations"] = Array<Vec3f>(std::move(places));
    placed.indices["/heavy"] = Array<int32_t>(std::move(indices));
    scene.SetInstancer("/places", placed);
    host::MeshDescription leaf = ball(1, 0, "/matte");
    leaf.instancer = "/places";
    scene.SetMesh("/heavy", leaf);
  };
  return {{"a cage of 24 faces, refined to 1.6 million quads", mesh(2, 8, "/matte"), take_heavy},
          {"a cage of 380,000 quads, refined once", mesh(252, 1, "/matte"), take_heavy},
          {"a mesh of 3 million triangles", mesh(500, 0, "/matte"), take_heavy},
          {"the same, which scatters: shells, distances", mesh(500, 0, "/wax"), take_heavy},
          {"the same, which emits", mesh(500, 0, "/lamp"), take_heavy},
          {"500,000 instances", instances, take_heavy},
          {"a dome of 8192 x 4096 texels", dome, take_heavy}};
}

void measure(Host& host, const Stage& stage, int repeats) {
  const auto settle = [&] {
    stage.take_away(host.scene);
    host.sync();
    host.wait();
  };
  stage.add(host.scene);
  host.sync();
  const Clock::time_point start = Clock::now();
  host.wait();
  const double whole = milliseconds_since(start);
  settle();
  std::vector<double> times;
  for (int i = 0; i < repeats; ++i) {
    stage.add(host.scene);
    host.sync();
    const double share = std::fmod(0.5 + i * 0.6180339887498949, 1.0);
    std::this_thread::sleep_for(std::chrono::duration<double, std::milli>(whole * share));
    const Clock::time_point edit = Clock::now();
    settle();
    times.push_back(milliseconds_since(edit));
  }
  std::printf("| %s | %.0f | %.1f | %.1f | %.1f |\n", stage.name, whole, percentile(times, 0.5),
              percentile(times, 0.99), percentile(times, 1));
  std::fflush(stdout);
}

}  // namespace
}  // namespace alabaster::hd

int main(int argc, char** argv) {
  int repeats = 40;
  std::string only;
  for (int i = 1; i + 1 < argc; i += 2) {
    if (!std::strcmp(argv[i], "--repeats")) repeats = std::max(1, std::atoi(argv[i + 1]));
    if (!std::strcmp(argv[i], "--only")) only = argv[i + 1];
  }
  std::printf("| build of | whole, ms | newer scene after: p50, ms | p99, ms | worst, ms |\n|---|---|---|---|---|\n");
  alabaster::hd::Host host;
  for (const auto& stage : alabaster::hd::stages())
    if (std::string(stage.name).find(only) != std::string::npos) alabaster::hd::measure(host, stage, repeats);
  return 0;
}
