// A minimal embedding host: a delegate, a scene, a frame, its pixels.
#include <chrono>
#include <cstdio>

#include "delegate/api/render_delegate.h"
#include "delegate/host/retained_scene_delegate.h"

using namespace alabaster::hd;

namespace {

host::MeshDescription Square() {
  host::MeshDescription mesh;
  mesh.topology.faceVertexCounts = {4};
  mesh.topology.faceVertexIndices = {0, 1, 2, 3};
  mesh.primvars["points"].value = Array<Vec3f>{{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}};
  mesh.material = "/materials/wax";
  return mesh;
}

MaterialNetwork Wax() {
  MaterialNetwork network;
  network.nodes["/materials/wax/surface"] = {"AlabasterDisney", {{"baseColor", Vec3f(0.9f, 0.6f, 0.3f)}}, {}};
  network.terminals["surface"] = {"/materials/wax/surface", "out"};
  return network;
}

void Describe(host::RetainedSceneDelegate* scene) {
  scene->SetMesh("/square", Square());
  scene->SetMaterial("/materials/wax", Wax());
  scene->SetLight("/dome", {"domeLight", {}, {{"intensity", 1.0f}}});
  host::CameraDescription camera;
  camera.transform.setTranslation(Vec3d(0, 0, 6));
  camera.parameters = {{"focalLength", 0.05f}, {"horizontalAperture", 0.036f}, {"verticalAperture", 0.036f}};
  scene->SetCamera("/camera", camera);
  scene->SetRenderBuffer("/color", {{16, 16, 1}, Format::float32vec4});
}

}  // namespace

int main() {
  DelegateOptions options;
  options.diagnostics = [](const Diagnostic& d) { std::fprintf(stderr, "%s: %s\n", d.where.c_str(), d.text.c_str()); };
  options.settings = {{"samples", 4}};
  RenderDelegate* delegate = CreateAlabasterRenderDelegate(kAbiVersion, &options);
  if (!delegate) return 1;
  int status = 1;
  {
    host::RenderIndex index(delegate);
    host::RetainedSceneDelegate scene;
    Describe(&scene);
    scene.Populate(&index);
    index.SyncAll();

    const std::unique_ptr<RenderPass> pass = delegate->CreateRenderPass();
    auto* color = static_cast<RenderBuffer*>(index.GetBprim("/color"));
    RenderPassState state;
    state.camera = "/camera";
    state.framing = {{0, 0}, {16, 16}, {0, 0, 16, 16}, 1};
    state.aovBindings = {{"color", color, {}}};
    do {
      pass->Execute(state);
    } while (!pass->WaitForConvergence(0.1) || !pass->IsConverged());

    color->Resolve();
    const auto* pixels = static_cast<const float*>(color->Map());
    const float* centre = pixels + 4 * (8 * 16 + 8);
    std::printf("centre: %g %g %g %g\n", centre[0], centre[1], centre[2], centre[3]);
    status = centre[3] == 1 && centre[0] > centre[2] && centre[2] > 0 ? 0 : 1;
    color->Unmap();
    scene.Depopulate();
  }
  DestroyAlabasterRenderDelegate(delegate);
  return status;
}
