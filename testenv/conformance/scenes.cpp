#include "testenv/conformance/scenes.h"

#include <cmath>

namespace conformance {

Mesh rectangle(double x0, double y0, double x1, double y1, int n, double z) {
  Mesh mesh;
  std::vector<Vec3f> points;
  std::vector<int32_t> counts, indices;
  for (int j = 0; j <= n; ++j)
    for (int i = 0; i <= n; ++i)
      points.emplace_back(static_cast<float>(x0 + (x1 - x0) * i / n), static_cast<float>(y0 + (y1 - y0) * j / n),
                          static_cast<float>(z));
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) {
      const int corner = j * (n + 1) + i;
      counts.push_back(4);
      indices.insert(indices.end(), {corner, corner + 1, corner + n + 2, corner + n + 1});
    }
  mesh.topology.faceVertexCounts = counts;
  mesh.topology.faceVertexIndices = indices;
  mesh.primvars["points"] = {Array<Vec3f>(points), Interpolation::vertex, "point", {}};
  return mesh;
}

Mesh cube(double half) {
  Mesh mesh;
  const auto h = static_cast<float>(half);
  std::vector<Vec3f> points;
  for (int i = 0; i < 8; ++i) points.emplace_back(i & 1 ? h : -h, i & 2 ? h : -h, i & 4 ? h : -h);
  mesh.topology.faceVertexCounts = {4, 4, 4, 4, 4, 4};
  mesh.topology.faceVertexIndices = {0, 2, 3, 1, 4, 5, 7, 6, 0, 1, 5, 4, 2, 6, 7, 3, 0, 4, 6, 2, 1, 3, 7, 5};
  mesh.primvars["points"] = {Array<Vec3f>(points), Interpolation::vertex, "point", {}};
  return mesh;
}

MaterialNetwork glow(const Vec3f& color) {
  MaterialNetwork network;
  network.nodes["surface"] = {"UsdPreviewSurface", {{"diffuseColor", kBlack}, {"emissiveColor", color}}, {}};
  network.terminals["surface"] = {"surface", "surface"};
  return network;
}

MaterialNetwork glow_of_display_color() {
  MaterialNetwork network = glow(Vec3f(1));
  network.nodes["reader"] = {"UsdPrimvarReader_float3", {{"varname", "displayColor"}}, {}};
  network.nodes["surface"].inputConnections["emissiveColor"] = {{"reader", "result"}};
  return network;
}

MaterialNetwork matte(const Vec3f& color) {
  MaterialNetwork network;
  network.nodes["surface"] = {"UsdPreviewSurface", {{"diffuseColor", color}, {"roughness", 1.0f}}, {}};
  network.terminals["surface"] = {"surface", "surface"};
  return network;
}

Matrix4d moved(double x, double y, double z) {
  Matrix4d matrix;
  matrix.setTranslation(Vec3d(x, y, z));
  return matrix;
}

void add_noisy_scene(Host& host) {
  host.material("/matte") = matte({0.75f, 0.5f, 0.25f});
  host.mesh("/cube") = cube(0.4);
  host.mesh("/cube").material = "/matte";
  host.mesh("/floor") = rectangle(-2, -2, 2, 2, 2, -0.5);
  host.mesh("/floor").material = "/matte";
  host.light("/dome", "domeLight").parameters = {{"intensity", 0.5f}};
  Light& quad = host.light("/quad", "rectLight");
  quad.parameters = {{"intensity", 4.0f}};
  quad.transform = moved(1, 1, 2);
}

void add_halves(Host& host) {
  host.material("/red") = glow(kRed);
  host.material("/green") = glow(kGreen);
  host.mesh("/left") = rectangle(-1, -1, 0, 1);
  host.mesh("/left").material = "/red";
  host.mesh("/right") = rectangle(0, -1, 1, 1);
  host.mesh("/right").material = "/green";
}

bool near(const Vec3f& a, const Vec3f& b, float tolerance) {
  return std::abs(a.x - b.x) < tolerance && std::abs(a.y - b.y) < tolerance && std::abs(a.z - b.z) < tolerance;
}

}  // namespace conformance
