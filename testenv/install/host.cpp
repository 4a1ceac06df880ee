// A host in C++17 that sees nothing but the C interface: a mesh whose points it lends, a material, a light, a camera;
// two AOVs; a written scene.
#include <alabaster/alabaster.hpp>
#include <cstdio>

using namespace alabaster::c_api;

namespace {

constexpr int kSide = 16;

void add_mesh(const Scene& scene, const std::shared_ptr<const std::vector<float>>& points) {
  set(scene, "/square", "mesh",
      {{"faceVertexCounts", Value::of<int32_t>(ALABASTER_INT, {4})},
       {"faceVertexIndices", Value::of<int32_t>(ALABASTER_INT, {0, 1, 2, 3})},
       {"primvars:points", Value::lend(ALABASTER_FLOAT3, points, points->data(), points->size() / 3)},
       {"primvars:points:role", "point"},
       {"categories", Value::tokens({"lit"})},
       {"material", Value::path("/wax")}});
}

void add_rest(const Scene& scene) {
  set(scene, "/wax", "material",
      {{"surface.type", "AlabasterDisney"}, {"surface.baseColor", std::array<float, 3>{0.9f, 0.6f, 0.3f}}});
  set(scene, "/dome", "domeLight", {{"lightLink", "lit"}});
  // Samples of a camera that stands still.
  const std::array<double, 16> away = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 5, 1};
  set(scene, "/camera", "camera",
      {{"focalLength", 0.05f},
       {"horizontalAperture", 0.036f},
       {"verticalAperture", 0.036f},
       {"transform:samples", Value::samples({{0, away}, {1, away}})}});
  const std::array<double, 16> further = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 6, 1};
  edit(scene, "/camera", {{"transform", further}});
}

}  // namespace

// Writes its scene to the file that it is given.
int main(int argc, char** argv) try {
  auto points = std::make_shared<const std::vector<float>>(std::vector<float>{-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0});
  float centre[4] = {}, depth = 0;
  {
    const Scene scene = make_scene();
    add_mesh(scene, points);
    add_rest(scene);
    const Delegate delegate = make_delegate(scene, {{"samples", 4}});
    const Buffer color = make_buffer(delegate, "color", kSide, kSide);
    const Buffer depths = make_buffer(delegate, "cameraDepth", kSide, kSide);
    const Pass pass = make_pass(delegate);
    const AlabasterBinding bindings[] = {{"color", color.get()}, {"cameraDepth", depths.get()}};
    auto frame = sized<AlabasterFrame>();
    frame.bindings = bindings, frame.binding_count = 2;
    frame.camera = "/camera";
    frame.width = frame.height = kSide;
    if (argc > 1) write_scene(scene, argv[1], &frame, {{"samples", 4}});
    check(api().pass_start(pass.get(), &frame));
    check(api().pass_wait(pass.get(), -1, nullptr));
    const Pixels pixels(color), distances(depths);
    const size_t middle = kSide / 2 * kSide + kSide / 2;
    for (int i = 0; i < 4; ++i) centre[i] = static_cast<const float*>(pixels.get().data)[4 * middle + size_t(i)];
    depth = static_cast<const float*>(distances.get().data)[middle];
  }
  std::printf("C++17 host: %g %g %g %g, depth %g\n", centre[0], centre[1], centre[2], centre[3], depth);
  const bool seen = centre[3] == 1 && centre[0] > centre[2] && centre[2] > 0 && depth > 5.9f && depth < 6.1f;
  return seen && points.use_count() == 1 ? 0 : 1;
} catch (const Error& error) {
  std::fprintf(stderr, "error %d: %s\n", error.status, error.what());
  return 1;
}
