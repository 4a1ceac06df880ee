// Measures for how long each edit holds the host's thread, how long it takes until its snapshot is rendered, and until
// its picture covers the frame.
//   edit_latency [--edits N] [--instances N] [--only PART OF A NAME] [--longest N]
// --longest tells of the N turns that held the host's thread longest where the time went.
// A scene of about 1e6 triangles, all of bodies that scatter below their surface, a thousand more prims, a dome of
// 4096 x 2048 texels, and an instancer of 1e6 points. A render at 1280 x 720 goes on throughout. Uses the public door
// only. Prints Markdown.

#include <sys/resource.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>
#include <thread>

#include "delegate/host/retained_scene_delegate.h"
#include "testenv/benchmark/waiting_times.h"

namespace alabaster::hd {
namespace {

constexpr int kBodies = 64, kPrims = 1000, kWidth = 1280, kHeight = 720;
constexpr const char* kPlaces = "hydra:instanceTranslations";

host::MeshDescription cube(float size, int refine_level) {
  host::MeshDescription mesh;
  mesh.topology.scheme = refine_level > 0 ? "catmullClark" : "none";
  mesh.topology.faceVertexCounts = {4, 4, 4, 4, 4, 4};
  mesh.topology.faceVertexIndices = {0, 2, 3, 1, 4, 5, 7, 6, 0, 1, 5, 4, 2, 6, 7, 3, 0, 4, 6, 2, 1, 3, 7, 5};
  std::vector<Vec3f> points;
  for (int i = 0; i < 8; ++i) points.emplace_back(i & 1 ? size : -size, i & 2 ? size : -size, i & 4 ? size : -size);
  mesh.primvars["points"].value = Array<Vec3f>(std::move(points));
  mesh.displayStyle.refineLevel = refine_level;
  return mesh;
}

MaterialNetwork material(const Vec3f& color, float scatter_distance) {
  MaterialNetwork network;
  MaterialNode& node = network.nodes["surface"];
  node.nodeTypeId = "AlabasterDisney";
  node.parameters["baseColor"] = color;
  if (scatter_distance > 0) node.parameters["scatterDistance"] = Vec3f(scatter_distance);
  network.terminals["surface"] = {"surface", "surface"};
  return network;
}

// A sky with a sun, as a Radiance file.
AssetPath sky(int width, int height) {
  return radiance_image(width, height, [&](int x, int y) {
    const bool sun = std::hypot(x - width / 3, y - height / 4) < height / 100.0;
    const auto level = static_cast<uint8_t>(64 + 128 * y / height);
    return std::array<uint8_t, 4>{level, level, 200, uint8_t(sun ? 140 : 128)};
  });
}

Path body_path(int i) {
  return Path("/body" + std::to_string(i));
}

class Host {
 public:
  explicit Host(int instances) : instances_(instances) {
    DelegateOptions options;
    options.diagnostics = [](const Diagnostic& d) {
      std::fprintf(stderr, "%s %s: %s\n", d.code.c_str(), d.where.c_str(), d.text.c_str());
    };
    options.settings = {{"samples", int64_t(1) << 20}};
    delegate_ = CreateAlabasterRenderDelegate(kAbiVersion, &options);
    if (!delegate_) std::exit(1);
    index_ = std::make_unique<host::RenderIndex>(delegate_);
    fill();
    scene.Populate(index_.get());
    buffer_ = static_cast<RenderBuffer*>(index_->GetBprim("/color"));
    pass_ = delegate_->CreateRenderPass();
    state_.camera = "/camera";
    state_.framing.displayMax = {kWidth, kHeight};
    state_.framing.dataWindow = {0, 0, kWidth, kHeight};
    state_.aovBindings.push_back({"color", buffer_, {}});
  }
  ~Host() {
    pass_.reset();
    scene.Depopulate();
    index_.reset();
    DestroyAlabasterRenderDelegate(delegate_);
  }
  Host(const Host&) = delete;
  Host& operator=(const Host&) = delete;

  // One turn of a host's loop.
  struct Turn {
    double wall = 0, edit = 0, sync = 0, cpu = 0;  // milliseconds; the rest of `wall` is Execute
    long faults = 0, preempted = 0, waits = 0;
    int number = 0;  // of the edit, from 0
    bool operator<(const Turn& other) const { return wall < other.wall; }
  };
  struct Cost {
    Turn host;            // the one that held the host's thread longest
    double snapshot = 0;  // until the edit is rendered
    double covered = 0;   // until each pixel shows the new scene, be it by a sample beside it
  };
  // One turn of a host's loop after the other, until the edit is rendered.
  template <class Edit>
  Cost measure(const Edit& edit, bool scene_changes) {
    const double before = number();
    const Clock::time_point start = Clock::now();
    Cost cost{turn(edit), 0, 0};
    while ((scene_changes && number() == before) || pass_->GetState() != PassState::rendering) {
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
      cost.host = std::max(cost.host, turn([] {}));
    }
    cost.snapshot = milliseconds_since(start);
    for (; stat("covered") == 0; cost.host = std::max(cost.host, turn([] {})))
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    cost.covered = milliseconds_since(start);
    return cost;
  }

  struct Storm {
    std::vector<double> held;  // milliseconds, by edit
    double seconds = 0, last = 0;
    int snapshots = 0;
  };
  template <class Edit>
  Storm measure_storm(int edits, const Edit& edit) {
    Storm storm;
    const double first = number();
    const Clock::time_point begin = Clock::now();
    for (int i = 0; i < edits; ++i) {
      std::this_thread::sleep_until(begin + std::chrono::milliseconds(10 * i));
      const Clock::time_point start = Clock::now();
      edit();
      index_->SyncAll();
      pass_->Execute(state_);
      storm.held.push_back(milliseconds_since(start));
    }
    const Clock::time_point end = Clock::now();
    storm.seconds = std::chrono::duration<double>(end - begin).count();
    while (pass_->GetState() != PassState::rendering) {
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
      pass_->Execute(state_);
    }
    storm.last = milliseconds_since(end);
    storm.snapshots = static_cast<int>(number() - first);
    return storm;
  }

  // As a host does that opens the scene again.
  void resync() {
    scene.Depopulate();
    scene.Populate(index_.get());
    buffer_ = static_cast<RenderBuffer*>(index_->GetBprim("/color"));
    state_.aovBindings.front().renderBuffer = buffer_;
  }
  void move_instance(int i) {
    const auto place = static_cast<size_t>(i);
    const Value& places = scene.GetInstancers().at("/leaves").primvars.at(kPlaces);
    const Vec3f moved = (*places.get<Array<Vec3f>>())[place] + Vec3f(0, 0.01f, 0);
    scene.SetInstanceValues("/leaves", kPlaces, place, Array<Vec3f>{moved});
  }
  // As a host does that makes a new array of all places for each edit.
  void replace_instances(int i) {
    std::vector<Vec3f> moved(*places_);
    moved[static_cast<size_t>(i)].y += 0.01f;
    places_ = std::make_shared<const std::vector<Vec3f>>(std::move(moved));
    place_instances();
  }

  host::RetainedSceneDelegate scene;

 private:
  template <class Edit>
  Turn turn(const Edit& edit) {
    rusage before{}, after{};
    getrusage(RUSAGE_THREAD, &before);
    Turn turn;
    const Clock::time_point start = Clock::now();
    edit();
    turn.edit = milliseconds_since(start);
    index_->SyncAll();
    turn.sync = milliseconds_since(start) - turn.edit;
    pass_->Execute(state_);
    turn.wall = milliseconds_since(start);
    getrusage(RUSAGE_THREAD, &after);
    const auto spent = [](const timeval& a, const timeval& b) {
      return 1e3 * static_cast<double>(b.tv_sec - a.tv_sec) + 1e-3 * static_cast<double>(b.tv_usec - a.tv_usec);
    };
    turn.cpu = spent(before.ru_utime, after.ru_utime) + spent(before.ru_stime, after.ru_stime);
    turn.faults = after.ru_minflt - before.ru_minflt;
    turn.preempted = after.ru_nivcsw - before.ru_nivcsw;
    turn.waits = after.ru_nvcsw - before.ru_nvcsw;
    return turn;
  }
  double stat(const char* name) const { return delegate_->GetRenderStats()[name].number_or(0); }
  double number() const { return stat("sceneNumber"); }

  void fill() {
    host::CameraDescription camera;
    camera.transform[3][1] = 2, camera.transform[3][2] = 24;
    camera.parameters = {{"focalLength", 1.0f}, {"horizontalAperture", 1.6f}, {"verticalAperture", 0.9f}};
    scene.SetCamera("/camera", camera);
    scene.SetRenderBuffer("/color", {.dimensions = {kWidth, kHeight, 1}, .format = Format::float32vec4});
    scene.SetMaterial("/wax", material({0.8f, 0.6f, 0.4f}, 0.05f));
    scene.SetMaterial("/matte", material({0.5f, 0.5f, 0.5f}, 0));
    scene.SetLight("/dome", {.type = "domeLight", .transform = {}, .parameters = {{"texture:file", sky(4096, 2048)}}});
    for (int i = 0; i < 2; ++i) scene.SetLight(i ? "/key" : "/rim", quad_light(i ? 8.0 : -8.0));
    host::MeshDescription hero = cube(2, 7);
    hero.material = "/wax";
    scene.SetMesh("/hero", hero);
    for (int i = 0; i < kBodies; ++i) {
      host::MeshDescription body = cube(0.5f, 5);
      body.material = "/wax";
      body.transform[3][0] = 1.5 * (i % 8) - 5, body.transform[3][2] = 1.5 * (i / 8) - 5;
      scene.SetMesh(body_path(i), body);
    }
    for (int i = 0; i < kPrims; ++i) {
      host::MeshDescription prim = cube(0.05f, 0);
      prim.material = "/matte";
      prim.transform[3][0] = 0.5 * (i % 40) - 10, prim.transform[3][1] = -1, prim.transform[3][2] = 0.5 * (i / 40) - 6;
      scene.SetMesh(Path("/prim" + std::to_string(i)), prim);
    }
    host::MeshDescription ground = cube(20, 0);  // holds all else, so edits leave the bounds of the scene
    ground.transform[1][1] = 0.5;
    ground.material = "/matte";
    scene.SetMesh("/room", ground);
    if (instances_ > 0) fill_instances();
  }

  void fill_instances() {
    std::vector<Vec3f> places;
    std::vector<int32_t> indices;
    for (int i = 0; i < instances_; ++i) {
      const auto spread = [i](double step) { return static_cast<float>(std::fmod(0.5 + i * step, 1.0)); };
      places.emplace_back(18 * spread(0.8191725134) - 9, 3 + 4 * spread(0.6710436067), 18 * spread(0.5497004779) - 9);
      indices.push_back(i);
    }
    places_ = std::make_shared<const std::vector<Vec3f>>(std::move(places));
    indices_ = Array<int32_t>(std::move(indices));
    place_instances();
    host::MeshDescription leaf = cube(0.01f, 0);
    leaf.material = "/matte";
    leaf.instancer = "/leaves";
    scene.SetMesh("/leaf", leaf);
  }

  void place_instances() {
    host::InstancerDescription leaves;
    leaves.primvars[kPlaces] = Array<Vec3f>(places_, places_->data(), places_->size());
    leaves.indices["/leaf"] = indices_;
    scene.SetInstancer("/leaves", leaves);
  }

 public:
  static host::LightDescription quad_light(double x) {
    host::LightDescription light{.type = "rectLight", .transform = {}, .parameters = {{"intensity", 5.0f}}};
    light.transform[3][0] = x, light.transform[3][2] = 8;
    return light;
  }

 private:
  int instances_;
  RenderDelegate* delegate_ = nullptr;
  std::unique_ptr<host::RenderIndex> index_;
  RenderBuffer* buffer_ = nullptr;
  std::unique_ptr<RenderPass> pass_;
  RenderPassState state_;
  std::shared_ptr<const std::vector<Vec3f>> places_;
  Array<int32_t> indices_;
};

int longest = 0;  // turns to tell of

void tell_longest(std::vector<Host::Turn> turns) {
  std::sort(turns.rbegin(), turns.rend());
  turns.resize(std::min(turns.size(), static_cast<size_t>(longest)));
  for (const Host::Turn& t : turns)
    std::printf(
        "  no. %d, %.1f ms: edit %.1f, sync %.1f, execute %.1f; CPU %.1f; %ld faults, %ld times preempted, %ld waits\n",
        t.number, t.wall, t.edit, t.sync, t.wall - t.edit - t.sync, t.cpu, t.faults, t.preempted, t.waits);
}

// `edit(i)` is the i-th of them.
template <class Edit>
void row(Host& host, const char* name, int edits, const Edit& edit, bool scene_changes = true) {
  std::vector<double> held, shown, covered;
  std::vector<Host::Turn> turns;
  for (int i = 0; i < edits; ++i) {
    const Host::Cost cost = host.measure([&] { edit(i); }, scene_changes);
    held.push_back(cost.host.wall), shown.push_back(cost.snapshot), covered.push_back(cost.covered);
    turns.push_back(cost.host);
    turns.back().number = i;
    std::this_thread::sleep_for(std::chrono::milliseconds(5));  // the render gets under way
  }
  std::printf("| %s |", name);
  for (const std::vector<double>& times : {held, shown, covered})
    std::printf(" %.1f | %.1f |", percentile(times, 0.5), percentile(times, 0.99));
  std::printf("\n");
  tell_longest(std::move(turns));
  std::fflush(stdout);
}

// A hundred edits a second for ten seconds: they must not queue up. No scene is like another: a build that finds the
// last scene again makes none.
void storm(Host& host) {
  constexpr int kEdits = 1000;
  const Host::Storm storm = host.measure_storm(kEdits, [&] {
    host::MeshDescription mesh = host.scene.GetMeshes().at(body_path(20));
    mesh.transform[3][1] += 1e-4;
    host.scene.SetMesh(body_path(20), mesh);
  });
  std::printf(
      "\n100 transforms of a body a second, for %.1f s: the host is held %.1f ms (p50), %.1f ms (p99); %d of %d edits "
      "were rendered; the last one after %.1f ms.\n",
      storm.seconds, percentile(storm.held, 0.5), percentile(storm.held, 0.99), storm.snapshots, kEdits, storm.last);
}

// Moves a point of the mesh.
void reshape(Host& host, const Path& id, int i) {
  host::MeshDescription mesh = host.scene.GetMeshes().at(id);
  const auto& points = *mesh.primvars["points"].value.get<Array<Vec3f>>();
  std::vector<Vec3f> other(points.begin(), points.end());
  other[0] *= i % 2 ? 1.02f : 1 / 1.02f;
  mesh.primvars["points"].value = Array<Vec3f>(std::move(other));
  host.scene.SetMesh(id, mesh);
}

// Gives another of the hero's six faces another material.
void choose_subset(Host& host, int i) {
  host::MeshDescription mesh = host.scene.GetMeshes().at("/hero");
  mesh.topology.geomSubsets = {{"/hero/part", "/matte", {i % 6}}};
  host.scene.SetMesh("/hero", mesh);
}

void run(int edits, int instances, const std::string& only) {
  Host host(instances);
  const Host::Cost first = host.measure([] {}, true);
  std::printf("The first snapshot: host %.0f ms, rendered after %.0f ms.\n\n", first.host.wall, first.snapshot);
  std::printf("| edit | host p50, ms | p99 | rendered p50, ms | p99 | frame covered p50, ms | p99 |\n");
  std::printf("|---|---|---|---|---|---|---|\n");
  const auto wanted = [&](const char* name) { return std::string(name).find(only) != std::string::npos; };
  const auto moved = [&](const Path& id) {
    return [&host, id](int i) {
      host::MeshDescription mesh = host.scene.GetMeshes().at(id);
      mesh.transform[3][1] += i % 2 ? 0.01 : -0.01;
      host.scene.SetMesh(id, mesh);
    };
  };
  const auto shifted = [](int i) { return i % 2 ? 0.1f : 0.2f; };
  if (wanted("nothing"))
    row(
        host, "nothing", edits, [](int) {}, false);
  if (wanted("camera"))
    row(
        host, "camera moved", edits,
        [&](int i) {
          host::CameraDescription camera = host.scene.GetCameras().at("/camera");
          camera.transform[3][0] = shifted(i);
          host.scene.SetCamera("/camera", camera);
        },
        false);
  if (wanted("prim")) row(host, "transform of a prim", edits, moved("/prim500"));
  if (wanted("body")) row(host, "transform of a body", edits, moved(body_path(20)));
  if (wanted("constant"))
    row(host, "constant of the bodies' material", edits, [&](int i) {
      host.scene.SetMaterial("/wax", material({0.8f, 0.6f, 0.4f + shifted(i)}, 0.05f));
    });
  if (wanted("light"))
    row(host, "light moved", edits,
        [&](int i) { host.scene.SetLight("/key", Host::quad_light(8.0 + double(shifted(i)))); });
  if (wanted("dome"))
    row(host, "dome turned", edits, [&](int i) {
      host::LightDescription dome = host.scene.GetLights().at("/dome");
      dome.transform.rotate(Imath::V3d(0, 0.01 + double(shifted(i)), 0));
      host.scene.SetLight("/dome", dome);
    });
  if (wanted("points")) {
    row(host, "points of a body, 12,288 triangles", edits, [&](int i) { reshape(host, body_path(20), i); });
    row(host, "points of the hero, 196,608 triangles", edits, [&](int i) { reshape(host, "/hero", i); });
  }
  if (wanted("subsets")) row(host, "subsets of the hero", edits, [&](int i) { choose_subset(host, i); });
  if (wanted("everything")) row(host, "everything synced again", std::min(edits, 20), [&](int) { host.resync(); });
  const std::string one = "one of " + std::to_string(instances) + " instances";
  if (wanted("instance") && instances > 0) {
    row(host, one.c_str(), edits, [&](int i) { host.move_instance(int(int64_t(i) * 7919 % instances)); });
    row(host, (one + ", by a new array of all").c_str(), edits,
        [&](int i) { host.replace_instances(int(int64_t(i) * 7919 % instances)); });
  }
  if (wanted("storm")) storm(host);
}

}  // namespace
}  // namespace alabaster::hd

int main(int argc, char** argv) {
  int edits = 20, instances = 1000000;
  std::string only;
  for (int i = 1; i + 1 < argc; i += 2) {
    if (!std::strcmp(argv[i], "--edits")) edits = std::atoi(argv[i + 1]);
    if (!std::strcmp(argv[i], "--instances")) instances = std::atoi(argv[i + 1]);
    if (!std::strcmp(argv[i], "--longest")) alabaster::hd::longest = std::max(std::atoi(argv[i + 1]), 0);
    if (!std::strcmp(argv[i], "--only")) only = argv[i + 1];
  }
  alabaster::hd::run(std::max(edits, 1), instances, only);
  return 0;
}
