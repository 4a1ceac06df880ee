#include "core/texture/cube_map.h"

#include <algorithm>
#include <cmath>

namespace alabaster {
namespace {

constexpr size_t kLooks = 4;  // along each axis of a texel

struct FacePlace {
  size_t face = 0;
  double right = 0, down = 0;  // -1..1
};

FacePlace place_of(const Vec3d& d) {
  const double x = std::abs(d.x), y = std::abs(d.y), z = std::abs(d.z);
  if (x >= y && x >= z) return {d.x > 0 ? size_t(0) : 1, d.z / d.x, -d.y / x};
  if (y >= z) return {d.y > 0 ? size_t(2) : 3, -d.x / y, d.z / d.y};
  return {d.z > 0 ? size_t(4) : 5, -d.x / d.z, -d.y / z};
}

// The texels on both sides of a place along one axis.
struct Taps {
  size_t first = 0, second = 0;
  float weight = 0;  // of the second
};

Taps taps_of(double place, size_t size) {
  const double at = std::clamp((place + 1) / 2 * double(size) - 0.5, 0.0, double(size - 1));
  const auto first = size_t(at);
  return {first, std::min(first + 1, size - 1), float(at - double(first))};
}

struct Angle {
  double sine = 0, cosine = 1;
};

// The angles of all looks along one axis.
std::vector<Angle> looks_along(size_t texels, double first_angle, double last_angle) {
  std::vector<Angle> looks(texels * kLooks);
  for (size_t i = 0; i < looks.size(); ++i) {
    const double angle = first_angle + (last_angle - first_angle) * (double(i) + 0.5) / double(looks.size());
    looks[i] = {std::sin(angle), std::cos(angle)};
  }
  return looks;
}

}  // namespace

Rgb CubeMap::look(const Vec3d& direction) const {
  const FacePlace place = place_of(direction);
  const Taps x = taps_of(place.right, size), y = taps_of(place.down, size);
  const std::vector<Rgb>& texels = faces[place.face];
  const auto row = [&](size_t at) { return lerp(texels[at * size + x.first], texels[at * size + x.second], x.weight); };
  return lerp(row(y.first), row(y.second), y.weight);
}

std::vector<Rgb> to_lat_long(const CubeMap& cube) {
  const size_t width = 4 * cube.size, height = 2 * cube.size;
  const std::vector<Angle> longitudes = looks_along(width, kPiDouble, -kPiDouble),
                           colatitudes = looks_along(height, 0, kPiDouble);
  std::vector<Rgb> texels(width * height);
  for (size_t row = 0; row < colatitudes.size(); ++row) {
    const double sine = colatitudes[row].sine;
    double sines = 0;  // of the texel's rows of looks, which weigh by their solid angle
    for (size_t k = 0; k < kLooks; ++k) sines += colatitudes[row / kLooks * kLooks + k].sine;
    const auto weight = float(sine / (sines * kLooks));
    for (size_t column = 0; column < longitudes.size(); ++column) {
      const Vec3d direction(sine * longitudes[column].sine, colatitudes[row].cosine, sine * longitudes[column].cosine);
      texels[row / kLooks * width + column / kLooks] += cube.look(direction) * weight;
    }
  }
  return texels;
}

}  // namespace alabaster
