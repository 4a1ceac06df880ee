// The faces of a cube, and the latitude-longitude image that they become.
#include "core/texture/cube_map.h"

#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include <cmath>
#include <functional>

namespace alabaster {
namespace {

const Vec3d kAxes[6] = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};

// The direction of a place of a face, -1..1 to the right and down, as a camera at the centre sees it.
Vec3d direction_of(size_t face, double right, double down) {
  const Vec3d up = face == 2 ? Vec3d(0, 0, -1) : face == 3 ? Vec3d(0, 0, 1) : Vec3d(0, 1, 0);
  return kAxes[face] + kAxes[face].cross(up) * right - up * down;
}

CubeMap cube_of(size_t size, const std::function<Rgb(const Vec3d&)>& radiance) {
  CubeMap cube;
  cube.size = size;
  for (size_t f = 0; f < 6; ++f)
    for (size_t y = 0; y < size; ++y)
      for (size_t x = 0; x < size; ++x) {
        const auto place = [&](size_t i) { return (double(i) + 0.5) / double(size) * 2 - 1; };
        cube.faces[f].push_back(radiance(direction_of(f, place(x), place(y)).normalized()));
      }
  return cube;
}

// The cube's power in the measure of its texels, which bilinear interpolation within faces keeps nearly.
double power_of(const CubeMap& cube) {
  double sum = 0;
  for (size_t f = 0; f < 6; ++f)
    for (size_t y = 0; y < cube.size; ++y)
      for (size_t x = 0; x < cube.size; ++x) {
        const auto place = [&](size_t i) { return (double(i) + 0.5) / double(cube.size) * 2 - 1; };
        const double distance = direction_of(f, place(x), place(y)).length();
        sum += double(cube.faces[f][y * cube.size + x].g) * 4 / double(cube.size * cube.size) /
               (distance * distance * distance);
      }
  return sum;
}

double power_of(const std::vector<Rgb>& lat_long, size_t width) {
  const size_t height = width / 2;
  double sum = 0;
  for (size_t i = 0; i < lat_long.size(); ++i)
    sum += double(lat_long[i].g) * 2 * std::sin(kPiDouble * (double(i / width) + 0.5) / double(height)) *
           std::sin(kPiDouble / 2 / double(height)) * 2 * kPiDouble / double(width);
  return sum;
}

TEST(CubeMap, FacesAreWhatACameraSees) {
  for (size_t f = 0; f < 6; ++f)
    for (const auto& [x, y] : {std::pair<size_t, size_t>(0, 0), {3, 0}, {0, 3}, {2, 1}}) {
      CubeMap cube = cube_of(4, [](const Vec3d&) { return Rgb(0); });
      cube.faces[f][y * 4 + x] = Rgb(1);
      const Vec3d at = direction_of(f, (double(x) + 0.5) / 2 - 1, (double(y) + 0.5) / 2 - 1);
      EXPECT_NEAR(cube.look(at).r, 1, 1e-6) << "face " << f << ", texel " << x << ", " << y;
    }
}

TEST(CubeMap, ConvertsToLatitudeAndLongitude) {
  const auto sky = [](const Vec3d& d) { return Rgb(1 + float(d.x) / 2, 1 + float(d.y) / 2, 1 + float(d.z) / 2); };
  const CubeMap cube = cube_of(32, sky);
  const std::vector<Rgb> image = to_lat_long(cube);
  ASSERT_EQ(image.size(), 128u * 64u);
  double largest = 0, looked = 0;
  for (size_t i = 0; i < image.size(); ++i) {
    const double longitude = 2 * kPiDouble * (0.5 - (double(i % 128) + 0.5) / 128);
    const double colatitude = kPiDouble * (double(i / 128) + 0.5) / 64;
    const Vec3d d(std::sin(colatitude) * std::sin(longitude), std::cos(colatitude),
                  std::sin(colatitude) * std::cos(longitude));
    for (int c = 0; c < 3; ++c) {
      largest = std::max(largest, double(std::abs(image[i][c] - sky(d)[c])));
      looked = std::max(looked, double(std::abs(image[i][c] - cube.look(d)[c])));
    }
  }
  // Half a texel at the faces' edges is constant, and texels are means.
  std::printf("smooth sky: %.4f of the sky, %.4f of a look; power %.5f\n", largest, looked,
              power_of(image, 128) / power_of(cube));
  EXPECT_LT(largest, 0.005);
  EXPECT_LT(looked, 0.01);
  EXPECT_NEAR(power_of(image, 128) / power_of(cube), 1, 1e-3);
}

TEST(CubeMap, DoesNotDependOnThreads) {
  const CubeMap cube =
      cube_of(16, [](const Vec3d& d) { return Rgb(float(std::exp(3 * d.x)), float(d.y * d.y), 0.3f); });
  std::vector<Rgb> one, four;
  tbb::task_arena(1).execute([&] { one = to_lat_long(cube); });
  tbb::task_arena(4).execute([&] { four = to_lat_long(cube); });
  EXPECT_EQ(one, four);
}

// A sun of one texel, wherever it stands, keeps its power.
TEST(CubeMap, KeepsThePowerOfASmallSun) {
  double least = 2, most = 0;
  for (const auto& [face, x, y] : std::vector<std::array<size_t, 3>>{
           {0, 16, 16}, {0, 5, 24}, {1, 30, 1}, {2, 16, 15}, {2, 28, 3}, {3, 9, 9}, {4, 2, 16}, {5, 24, 29}}) {
    CubeMap cube = cube_of(32, [](const Vec3d&) { return Rgb(0); });
    cube.faces[face][y * 32 + x] = Rgb(1000);
    const double share = power_of(to_lat_long(cube), 128) / power_of(cube);
    least = std::min(least, share), most = std::max(most, share);
  }
  std::printf("power of a sun: %.4f to %.4f\n", least, most);
  EXPECT_GT(least, 0.985);
  EXPECT_LT(most, 1.005);
}

}  // namespace
}  // namespace alabaster
