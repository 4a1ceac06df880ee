#include "delegate/description/studio.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/math/bounds.h"
#include "delegate/description/placement.h"

namespace alabaster::hd::description {
namespace {

constexpr double kDegrees = std::numbers::pi / 180;

/// A rect light that faces the objects. Lengths are in radii of the objects.
struct StudioLight {
  const char* name;
  double azimuth, elevation;  // degrees, from the viewer to the right and from the horizon up
  double distance, size;
  float radiance;
  Vec3f color;
};
// Radiances give a white surface that faces the key about one, what the usual views show a little below white.
constexpr float kDomeRadiance = 0.2f;
const StudioLight kLights[] = {
    {"studio_key", -46, 40, 4.5, 2.8, 8.0f, {1.0f, 0.975f, 0.94f}},
    {"studio_fill", 58, 12, 5.0, 4.0, 0.8f, {0.94f, 0.97f, 1.0f}},
    {"studio_rim", 160, 37, 5.6, 3.5, 21.0f, {1.0f, 0.99f, 0.97f}},
};

// The backdrop is a surface of revolution, so that a camera that turns around sees no edge: a flat floor, which ends
// this far behind the objects' middle, then an arc up to this angle. Lengths are in radii of the objects.
constexpr double kBehind = 3, kArcRadius = 6, kArcEnd = 80 * kDegrees;
constexpr int kArcRings = 24, kSegments = 96;
constexpr float kBackdropAlbedo = 0.14f;

// The horizontal direction to the viewer: the camera's +z, or for a camera that looks straight down or up the one that
// the lower edge of its picture shows.
Vec3d viewer(const Matrix4d& camera) {
  const Vec3d back(camera[2][0], camera[2][1], camera[2][2]), up(camera[1][0], camera[1][1], camera[1][2]);
  Vec3d toward(back.x, 0, back.z);
  if (!(toward.length() > 0.1 * back.length())) toward = Vec3d(up.x, 0, up.z) * (back.y > 0 ? -1 : 1);
  return toward.length() > 0 ? toward.normalized() : Vec3d(0, 0, 1);
}

// A round floor of this radius, whose rim bends up.
host::MeshDescription bowl(double floor) {
  std::vector<Vec3f> points{{0, 0, 0}}, normals{{0, 1, 0}};
  std::vector<int32_t> counts, indices;
  for (int ring = 0; ring <= kArcRings; ++ring) {
    const double t = kArcEnd * ring / kArcRings, sin = std::sin(t), cos = std::cos(t);
    const double r = floor + kArcRadius * sin, y = kArcRadius * (1 - cos);
    const int first = 1 + ring * kSegments;
    for (int s = 0; s < kSegments; ++s) {
      const double phi = 360 * kDegrees * s / kSegments, x = std::sin(phi), z = std::cos(phi);
      points.emplace_back(Vec3d(r * x, y, r * z));
      normals.emplace_back(Vec3d(-sin * x, cos, -sin * z));
      const int here = first + s, next = first + (s + 1) % kSegments;
      std::vector<int32_t> face{0, here, next};
      if (ring > 0) face = {here - kSegments, here, next, next - kSegments};
      counts.push_back(int32_t(face.size()));
      indices.insert(indices.end(), face.begin(), face.end());
    }
  }
  host::MeshDescription mesh;
  mesh.topology.faceVertexCounts = std::move(counts);
  mesh.topology.faceVertexIndices = std::move(indices);
  mesh.primvars["points"] = {Interpolation::vertex, "point", Array<Vec3f>(std::move(points)), {}};
  mesh.primvars["normals"] = {Interpolation::vertex, "normal", Array<Vec3f>(std::move(normals)), {}};
  return mesh;
}

// The soft dome: a sky that is brighter above, a broad key from the viewer's upper left and a rim from behind, so that
// shapes are readable and thin parts glow.
constexpr int kWidth = 128, kHeight = 64;

// A soft spot around `axis`. Radiance falls to 1/e where 1 - cos = 1/sharpness.
double spot(const Vec3d& direction, const Vec3d& axis, double sharpness) {
  return std::exp(sharpness * (direction.dot(axis.normalized()) - 1));
}

// Local frame: +z towards the viewer, +x to the viewer's right, +y up.
Vec3d radiance(const Vec3d& direction) {
  const double up = direction.y;
  const double sky = up > 0 ? 0.34 + 0.36 * up : 0.34 * (1 + 0.45 * up);
  const double key = 8.0 * spot(direction, {-0.65, 0.75, 0.60}, 30);
  const double rim = 9.0 * spot(direction, {0.60, 0.50, -0.75}, 30);
  return Vec3d(0.97, 1.0, 1.04) * sky + Vec3d(1.05, 1.0, 0.94) * key + Vec3d(1.0, 1.0, 1.0) * rim;
}

// Ward 1991, "Real Pixels": a shared exponent, mantissas of 8 bits.
void append_rgbe(const Vec3d& color, std::vector<uint8_t>* bytes) {
  const double largest = std::max(color.x, std::max(color.y, color.z));
  int exponent = 0;
  const double scale = std::frexp(largest, &exponent) * 256 / largest;
  for (const double c : {color.x, color.y, color.z}) bytes->push_back(static_cast<uint8_t>(c * scale));
  bytes->push_back(static_cast<uint8_t>(exponent + 128));
}

// A lat-long image as in UsdLux: top row +y, centre +z, +x a quarter of the width left of the centre.
std::shared_ptr<const std::vector<uint8_t>> image() {
  const std::string header = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 64 +X 128\n";
  auto bytes = std::make_shared<std::vector<uint8_t>>(header.begin(), header.end());
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) {
      const double theta = M_PI * (y + 0.5) / kHeight, phi = 2 * M_PI * (0.5 - (x + 0.5) / kWidth);
      append_rgbe(radiance({std::sin(theta) * std::sin(phi), std::cos(theta), std::sin(theta) * std::cos(phi)}),
                  bytes.get());
    }
  return bytes;
}

}  // namespace

std::optional<StudioPlan> plan_studio(const std::vector<Vec3d>& world, const Matrix4d& camera, const Token& up) {
  const std::vector<Vec3d> points = from_world(world, up);
  if (points.empty()) return std::nullopt;
  BoundsDouble box;
  for (const Vec3d& p : points) box.extend(p);
  StudioPlan plan;
  plan.up = up;
  plan.center = box.center();
  for (const Vec3d& p : points) plan.radius = std::max(plan.radius, (p - plan.center).length());
  if (!(plan.radius > 0) || !std::isfinite(plan.radius)) return std::nullopt;
  plan.floor = box.lower.y;
  plan.camera = from_world(camera, up);
  const Vec3d eye = plan.camera.translation();
  plan.inside = box.contains(eye);
  plan.below = eye.y < plan.floor;
  return plan;
}

void add_studio_lights(const StudioPlan& plan, bool dome, host::RetainedSceneDelegate* scene) {
  const Vec3d front = viewer(plan.camera), up(0, 1, 0), right = up.cross(front);
  for (const StudioLight& light : kLights) {
    const double azimuth = light.azimuth * kDegrees, elevation = light.elevation * kDegrees;
    const Vec3d way =
        (front * std::cos(azimuth) + right * std::sin(azimuth)) * std::cos(elevation) + up * std::sin(elevation);
    host::LightDescription rect;
    rect.type = "rectLight";
    rect.transform = *look_at(way, Vec3d(0), up, true);
    const Vec3d position = plan.center + way * (light.distance * plan.radius);
    for (int i = 0; i < 3; ++i) rect.transform[3][i] = position[i];
    rect.transform = to_world(rect.transform, plan.up);
    rect.parameters = {{"color", light.color},
                       {"intensity", light.radiance},
                       {"width", float(light.size * plan.radius)},
                       {"height", float(light.size * plan.radius)}};
    scene->SetLight(Path("/lights").append(light.name), std::move(rect));
  }
  if (!dome) return;
  host::LightDescription sky;
  sky.type = "domeLight";
  sky.parameters = {{"intensity", kDomeRadiance}};
  scene->SetLight("/lights/studio_dome", std::move(sky));
}

void add_studio_backdrop(const StudioPlan& plan, host::RetainedSceneDelegate* scene) {
  // Stand the camera on the floor, too.
  const Vec3d eye = plan.camera.translation();
  const double away = std::hypot(eye.x - plan.center.x, eye.z - plan.center.z) / plan.radius;
  const double floor = std::max(kBehind, (1.1 * away + kBehind) / 2);

  // A floor that a model brings along hides ours.
  Vec3d middle = plan.center + viewer(plan.camera) * ((floor - kBehind) * plan.radius);
  middle.y = plan.floor - 1e-4 * plan.radius;

  host::MeshDescription mesh = bowl(floor);
  mesh.transform = to_world(Matrix4d().setScale(plan.radius) * Matrix4d().setTranslation(middle), plan.up);
  mesh.material = "/materials/studio_backdrop";
  MaterialNetwork network;
  const Path surface = mesh.material.append("surface");
  network.nodes[surface] = {
      "AlabasterDisney", {{"baseColor", Vec3f(kBackdropAlbedo)}, {"roughness", 1.0f}, {"specular", 0.0f}}, {}};
  network.terminals["surface"] = {surface, "surface"};
  scene->SetMaterial(mesh.material, std::move(network));
  scene->SetMesh("/studio/backdrop", std::move(mesh));
}

host::LightDescription soft_dome(const Matrix4d& world_camera, const Token& up) {
  const Matrix4d camera = from_world(world_camera, up);
  Vec3d viewer(camera[2][0], 0, camera[2][2]);
  viewer = viewer.length() > 0 ? viewer.normalized() : Vec3d(0, 0, 1);
  host::LightDescription dome;
  dome.type = "domeLight";
  dome.transform = to_world(Matrix4d(viewer.z, 0, -viewer.x, 0, 0, 1, 0, 0, viewer.x, 0, viewer.z, 0, 0, 0, 0, 1), up);
  dome.parameters["texture:file"] = AssetPath{"soft dome", "", image()};
  return dome;
}

}  // namespace alabaster::hd::description
