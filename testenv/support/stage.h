// A small stage for tests of the delegate: a real renderer behind the public contract, a retained scene, a quad.
#pragma once

#include <algorithm>
#include <cstring>
#include <map>
#include <mutex>
#include <string>
#include <vector>

#include "delegate/host/retained_scene_delegate.h"
#include "testenv/support/cages.h"

namespace alabaster::hd {

class Stage {
 public:
  explicit Stage(const Dictionary& settings = {}) {
    DelegateOptions options;
    options.diagnostics = [this](const Diagnostic& d) {
      const std::lock_guard lock(mutex_);
      diagnostics_.push_back(d);
    };
    options.settings = settings;
    delegate = CreateAlabasterRenderDelegate(kAbiVersion, &options);
    index = std::make_unique<host::RenderIndex>(delegate);
    scene.Populate(index.get());
  }
  ~Stage() { close(); }
  Stage(const Stage&) = delete;
  Stage& operator=(const Stage&) = delete;

  void close() {
    if (!delegate) return;
    scene.Depopulate();
    index.reset();
    DestroyAlabasterRenderDelegate(delegate);
    delegate = nullptr;
  }

  static host::MeshDescription quad() {
    host::MeshDescription mesh;
    mesh.topology.faceVertexCounts = {4};
    mesh.topology.faceVertexIndices = {0, 1, 2, 3};
    mesh.primvars["points"].value = Array<Vec3f>{{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}};
    return mesh;
  }

  /// A closed mesh of 12 * 4^level triangles.
  static host::MeshDescription cube(int level) {
    const Cage cage = test::cube_cage();
    host::MeshDescription mesh;
    mesh.topology.faceVertexCounts = Array<int32_t>(cage.face_vertex_counts);
    mesh.topology.faceVertexIndices = Array<int32_t>(cage.face_vertex_indices);
    mesh.topology.scheme = "catmullClark";
    mesh.displayStyle.refineLevel = level;
    mesh.primvars["points"].value = Array<Vec3f>(cage.points);
    return mesh;
  }

  void set_surface(const Path& path, const std::map<Token, Value>& parameters) {
    MaterialNetwork network;
    network.nodes["/m/surface"] = {"AlabasterDisney", parameters, {}};
    network.terminals["surface"] = {"/m/surface", "surface"};
    scene.SetMaterial(path, network);
  }

  /// A camera at z = 4 that sees a square of side 4 about the origin; a white dome; the quad at the origin.
  void add_basic_scene() {
    host::CameraDescription camera;
    camera.transform[3][2] = 4;
    camera.parameters = {{"focalLength", 1.0f}, {"horizontalAperture", 1.0f}, {"verticalAperture", 1.0f}};
    scene.SetCamera("/camera", camera);
    scene.SetLight("/dome", {.type = "domeLight", .transform = {}, .parameters = {}});
    scene.SetMesh("/quad", quad());
  }

  RenderBuffer* add_buffer(const char* path, int width, int height, Format format) {
    scene.SetRenderBuffer(path, {.dimensions = {width, height, 1}, .format = format});
    return static_cast<RenderBuffer*>(index->GetBprim(path));
  }

  static RenderPassState state_for(int width, int height, const char* aov, RenderBuffer* buffer) {
    RenderPassState state;
    state.camera = "/camera";
    state.framing.displayMax = {static_cast<float>(width), static_cast<float>(height)};
    state.framing.dataWindow = {0, 0, width, height};
    state.aovBindings.push_back({aov, buffer, {}});
    return state;
  }

  /// Executes until converged; false after 20 seconds.
  static bool finish(RenderPass& pass, const RenderPassState& state) {
    for (int i = 0; i < 1000; ++i) {
      pass.Execute(state);
      if (pass.IsConverged()) return true;
      pass.WaitForConvergence(0.02);
    }
    return false;
  }

  template <class T>
  static std::vector<T> pixels(RenderBuffer* buffer) {
    PixelMemory memory;
    memory.format = buffer->GetFormat();
    buffer->ResolveTo(&memory);  // finds the size
    memory.rowBytes = static_cast<size_t>(memory.size.x) * FormatSize(memory.format);
    std::vector<T> values(memory.rowBytes * static_cast<size_t>(memory.size.y) / sizeof(T));
    memory.pixels = values.data();
    return buffer->ResolveTo(&memory) ? values : std::vector<T>();
  }

  std::string dump() {
    index->SyncAll();
    return delegate->InvokeCommand("dumpScene", {}).value.text_or("");
  }
  /// The builder has made the scene that was committed last.
  void wait_for_scene() const { delegate->InvokeCommand("waitForScene", {}); }
  double stat(const char* key) const {
    wait_for_scene();
    const Dictionary stats = delegate->GetRenderStats();
    const auto found = stats.find(key);
    return found == stats.end() ? -1 : found->second.number_or(-1);
  }
  std::string text_stat(const char* key) const {
    wait_for_scene();
    const Dictionary stats = delegate->GetRenderStats();
    const auto found = stats.find(key);
    return found == stats.end() ? "" : found->second.text_or("");
  }

  std::vector<Diagnostic> take_diagnostics() {
    wait_for_scene();
    const std::lock_guard lock(mutex_);
    return std::move(diagnostics_);
  }
  size_t count(const std::string& code) {
    wait_for_scene();
    const std::lock_guard lock(mutex_);
    return static_cast<size_t>(
        std::count_if(diagnostics_.begin(), diagnostics_.end(), [&](const Diagnostic& d) { return d.code == code; }));
  }

  RenderDelegate* delegate = nullptr;
  std::unique_ptr<host::RenderIndex> index;
  host::RetainedSceneDelegate scene;

 private:
  std::mutex mutex_;
  std::vector<Diagnostic> diagnostics_;
};

}  // namespace alabaster::hd
