#include "core/color/blackbody.h"

#include "core/math/vector.h"

namespace alabaster {

Rgb blackbody(float kelvin, const Chromaticities& space) {
  const double t = kelvin > 0 ? std::clamp(static_cast<double>(kelvin), 1000.0, 15000.0) : 6500.0, t2 = t * t;
  const double u =
      (0.860117757 + 1.54118254e-4 * t + 1.28641212e-7 * t2) / (1 + 8.42420235e-4 * t + 7.08145163e-7 * t2);
  const double v =
      (0.317398726 + 4.22806245e-5 * t + 4.20481691e-8 * t2) / (1 - 2.89741816e-5 * t + 1.61456053e-7 * t2);
  const double x = 3 * u, y = 2 * v, sum = 2 * u - 8 * v + 4;
  const Vec3d xyz(x / y, 1, (sum - x - y) / y);
  const XyzColumns columns = xyz_d65_columns(space);
  Imath::M33d to_xyz;  // row vectors
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) to_xyz[i][j] = columns[size_t(i)][size_t(j)];
  const Vec3d rgb = xyz * to_xyz.inverse();
  const auto channel = [](double c) { return static_cast<float>(std::max(c, 0.0)); };
  return {channel(rgb.x), channel(rgb.y), channel(rgb.z)};
}

}  // namespace alabaster
