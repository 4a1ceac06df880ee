#include "delegate/description/soft_dome.h"

#include <cmath>

namespace alabaster::hd::description {
namespace {

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

host::LightDescription soft_dome(const Matrix4d& camera) {
  Vec3d viewer(camera[2][0], 0, camera[2][2]);
  viewer = viewer.length() > 0 ? viewer.normalized() : Vec3d(0, 0, 1);
  host::LightDescription dome;
  dome.type = "domeLight";
  dome.transform = Matrix4d(viewer.z, 0, -viewer.x, 0, 0, 1, 0, 0, viewer.x, 0, viewer.z, 0, 0, 0, 0, 1);
  dome.parameters["texture:file"] = AssetPath{"soft dome", "", image()};
  return dome;
}

}  // namespace alabaster::hd::description
