// The paper's headline (Chiang, Kutz, Burley 2016, section 4): with parameters typical of skin, path-traced subsurface
// scattering renders in time, and with noise, comparable to ray-traced diffusion. Prints the cost and noise of the walk
// and of normalized diffusion as Markdown.
//   subsurface_headline [--repeats N] [--size PIXELS] [--samples N]
// Both modes render the same frames in turn, in one thread of one process, each repeat with another seed: time is CPU
// time, variance is that of a pixel over the repeats. Bodies: a torus, and the dragon of the test assets if
// ALABASTER_TEST_ASSETS names their folder.

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <string>

#include "delegate/support/process_usage.h"
#include "testenv/support/mesh_bodies.h"
#include "testenv/support/scene_builder.h"
#include "testenv/support/z_test.h"

namespace alabaster {
namespace {

/// The only mesh of a .glb with 32-bit floats and 16-bit indices, as in the test assets.
Mesh read_asset(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  const std::string bytes(std::istreambuf_iterator<char>(file), {});
  Mesh mesh;
  if (bytes.size() < 28) return mesh;
  uint32_t length = 0;
  std::memcpy(&length, &bytes[12], 4);
  const auto json = nlohmann::json::parse(bytes.substr(20, length));
  const auto& primitive = json["meshes"][0]["primitives"][0];
  const auto data = [&](int accessor) {
    const auto& view =
        json["bufferViews"][json["accessors"][static_cast<size_t>(accessor)]["bufferView"].get<size_t>()];
    return &bytes[28 + length + view.value("byteOffset", size_t(0))];
  };
  const auto count = [&](int accessor) {
    return json["accessors"][static_cast<size_t>(accessor)]["count"].get<size_t>();
  };
  const int positions = primitive["attributes"]["POSITION"], indices = primitive["indices"];
  mesh.points.resize(count(positions));
  for (size_t i = 0; i < 3 * mesh.points.size(); ++i)
    std::memcpy(&mesh.points[i / 3][static_cast<int>(i % 3)], data(positions) + 4 * i, 4);
  mesh.triangles.resize(count(indices) / 3);
  for (size_t i = 0; i < 3 * mesh.triangles.size(); ++i) {
    uint16_t index = 0;
    std::memcpy(&index, data(indices) + 2 * i, 2);
    mesh.triangles[i / 3][i % 3] = index;
  }
  return mesh;
}

/// The mesh centred at the origin, with 1 as the longest side of its bounds.
Mesh unit_size(Mesh mesh) {
  Bounds bounds;
  for (const auto& p : mesh.points) bounds.extend(p);
  const float scale = 1 / max_component(bounds.extent());
  mesh.bounds = {};
  for (auto& p : mesh.points) {
    p = (p - bounds.center()) * scale;
    mesh.bounds.extend(p);
  }
  return mesh;
}

struct Mode {
  const char* name;
  SubsurfaceMode subsurface;
  AlbedoInversion inversion = AlbedoInversion::exact;
};
constexpr Mode kModes[] = {
    {"diffusion", SubsurfaceMode::diffusion},
    {"reference, chiang2016", SubsurfaceMode::reference, AlbedoInversion::chiang2016},
    {"reference", SubsurfaceMode::reference},
    {"walk", SubsurfaceMode::walk},
};

struct Measured {
  double seconds = 0;
  RenderCounters counters;
  std::vector<testing::RunningStatistics> values;  // of each pixel and channel over the repeats

  void add(const RenderRequest& request) {
    RenderProgress progress;
    const double begin = hd::support::process_cpu_seconds();
    const auto film = testing::render(request, &progress);
    seconds += hd::support::process_cpu_seconds() - begin;
    counters.add(progress.counters);
    const auto color = film->resolve_float(Aov::color);
    values.resize(color.size());
    for (size_t i = 0; i < color.size(); ++i)
      if (i % 4 != 3) values[i].add(color[i]);
  }
  double mean() const {
    double sum = 0;
    for (const auto& v : values) sum += v.mean();
    return sum / static_cast<double>(values.size() * 3 / 4);
  }
  /// The variance of one sample, averaged over pixels and channels.
  double variance(uint32_t samples) const {
    double sum = 0;
    for (const auto& v : values) sum += v.variance();
    return samples * sum / static_cast<double>(values.size() * 3 / 4);
  }
};

struct Lighting {
  const char* name;
  bool key;
};

RenderRequest describe(testing::SceneBuilder* b, const std::shared_ptr<const MeshPrototype>& body, float distance,
                       const Lighting& lighting) {
  DisneyParameters skin;  // subsurface alone: roughness 0 has no retro-reflection, ior 1 no specular lobe
  skin.base_color = {0.9f, 0.6f, 0.45f};
  skin.scatter_distance = Rgb(1, 0.35f, 0.2f) * distance;
  skin.roughness = 0;
  skin.ior = 1;
  skin.specular = 0;
  b->description = {};
  b->add(body, b->material(skin));
  if (lighting.key) {
    LightParameters light;
    light.type = LightType::sphere;
    light.radius = 0.1f;
    light.intensity = 150;
    light.light_to_world.setTranslation(Vec3d(-2, 2.5, 1));
    b->add(light);
  } else {
    b->add(testing::constant_dome(1, false));
  }
  RenderRequest request;
  request.scene = b->snapshot();
  request.camera = testing::look_at({0.3, 1.1, 1.7}, {0, 0, 0}, 28);
  request.settings.threads = 1;
  return request;
}

void measure_body(const char* name, const Mesh& mesh, const RenderRequest& frame, uint32_t repeats) {
  testing::SceneBuilder b;
  const auto body = b.prototype(mesh);
  for (const float distance : {0.003f, 0.01f, 0.03f})
    for (const Lighting& lighting : {Lighting{"dome", false}, Lighting{"key", true}}) {
      RenderRequest request = describe(&b, body, distance, lighting);
      request.width = frame.width, request.height = frame.height, request.data_window = frame.data_window;
      request.settings.samples = frame.settings.samples;
      Measured measured[std::size(kModes)];
      for (uint32_t repeat = 0; repeat < repeats; ++repeat)
        for (size_t m = 0; m < std::size(kModes); ++m) {
          request.settings.seed = repeat;
          request.settings.subsurface = kModes[m].subsurface;
          request.settings.inversion = kModes[m].inversion;
          measured[m].add(request);
        }
      const auto cost = [&](const Measured& m) { return m.seconds * m.variance(request.settings.samples); };
      for (size_t m = 0; m < std::size(kModes); ++m) {
        const Measured& r = measured[m];
        const auto samples = static_cast<double>(r.counters.samples);
        const double exits = static_cast<double>(r.counters.probe_rays + r.counters.walks);
        std::printf("| %s | %g | %s | %s | %.2f | %.1f | %.2f | %.4f | %.4f | %.2f | %.2f | %.2f |\n", name,
                    static_cast<double>(distance), lighting.name, kModes[m].name, 1e6 * r.seconds / samples,
                    static_cast<double>(r.counters.rays()) / samples,
                    static_cast<double>(r.counters.walk_rays + r.counters.probe_rays) / std::max(exits, 1.0), r.mean(),
                    r.variance(request.settings.samples), r.seconds / measured[0].seconds,
                    r.variance(1) / measured[0].variance(1), cost(r) / cost(measured[0]));
      }
      std::fflush(stdout);
    }
}

int run(int argc, char** argv) {
  uint32_t repeats = 12;
  int size = 96;
  RenderRequest frame;
  frame.settings.samples = 4;
  for (int i = 1; i + 1 < argc; i += 2) {
    const std::string flag = argv[i];
    const int value = std::atoi(argv[i + 1]);
    if (flag == "--repeats" && value > 1)
      repeats = static_cast<uint32_t>(value);
    else if (flag == "--size" && value > 0)
      size = value;
    else if (flag == "--samples" && value > 0)
      frame.settings.samples = static_cast<uint32_t>(value);
    else
      return std::fprintf(stderr, "cannot use %s %s\n", argv[i], argv[i + 1]), 2;
  }
  frame.width = frame.height = size;
  frame.data_window = {0, 0, size, size};
  std::printf(
      "| body | d red : size | light | mode | CPU us/sample | rays/sample | segments or probes per exit sample | mean "
      "| "
      "variance/sample | time : diffusion | variance : diffusion | time x variance : diffusion |\n"
      "|--|--|--|--|--|--|--|--|--|--|--|--|\n");
  measure_body("torus", unit_size(testing::torus_mesh(1, 0.4f, 256)), frame, repeats);
  const char* assets = std::getenv("ALABASTER_TEST_ASSETS");
  const Mesh dragon = assets ? read_asset(std::string(assets) + "/sss/dragon_wax.glb") : Mesh();
  if (dragon.triangles.empty())
    std::printf("\nSkipped: the dragon. ALABASTER_TEST_ASSETS does not name a folder with sss/dragon_wax.glb.\n");
  else
    measure_body("dragon", unit_size(dragon), frame, repeats);
  return 0;
}

}  // namespace
}  // namespace alabaster

int main(int argc, char** argv) {
  return alabaster::run(argc, argv);
}
