#include "core/texture/cube_map.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <span>

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
struct FaceTaps {
  size_t first = 0, second = 0;
  float weight = 0;  // of the second
};

FaceTaps face_taps(double place, size_t size) {
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
  const FaceTaps x = face_taps(place.right, size), y = face_taps(place.down, size);
  const std::vector<Rgb>& texels = faces[place.face];
  const auto row = [&](size_t at) { return lerp(texels[at * size + x.first], texels[at * size + x.second], x.weight); };
  return lerp(row(y.first), row(y.second), y.weight);
}

std::vector<Rgb> to_lat_long(const CubeMap& cube) {
  const size_t width = 4 * cube.size, height = 2 * cube.size;
  const std::vector<Angle> longitudes = looks_along(width, kPiDouble, -kPiDouble),
                           colatitudes = looks_along(height, 0, kPiDouble);
  std::vector<Rgb> texels(width * height);
  const auto add_looks = [&](const Angle& colatitude, float weight, Rgb* row) {
    for (size_t column = 0; column < longitudes.size(); ++column) {
      const Angle& longitude = longitudes[column];
      const Vec3d direction(colatitude.sine * longitude.sine, colatitude.cosine, colatitude.sine * longitude.cosine);
      row[column / kLooks] += cube.look(direction) * weight;
    }
  };
  tbb::parallel_for(size_t(0), height, [&](size_t row) {
    const std::span<const Angle> looks(&colatitudes[row * kLooks], kLooks);
    double sines = 0;  // the looks weigh by their solid angle
    for (const Angle& look : looks) sines += look.sine;
    for (const Angle& look : looks) add_looks(look, float(look.sine / (sines * kLooks)), &texels[row * width]);
  });
  return texels;
}

}  // namespace alabaster
