#include "core/color/chromaticities.h"

#include <algorithm>
#include <cmath>

#include "core/math/vector.h"

namespace alabaster {
namespace {

using Matrix33d = Imath::M33d;  // row vectors: v' = v * M

constexpr std::array<Chromaticities, 5> kKnownSpaces = {{
    kRec709,
    {0.7347f, 0.2653f, 0.0f, 1.0f, 0.0001f, -0.0770f, 0.32168f, 0.33767f},  // ACES AP0 (SMPTE ST 2065-1)
    {0.713f, 0.293f, 0.165f, 0.830f, 0.128f, 0.044f, 0.32168f, 0.33767f},   // ACES AP1 (S-2014-004, ACEScg)
    {0.680f, 0.320f, 0.265f, 0.690f, 0.150f, 0.060f, 0.3127f, 0.3290f},     // P3-D65
    {0.708f, 0.292f, 0.170f, 0.797f, 0.131f, 0.046f, 0.3127f, 0.3290f},     // ITU-R BT.2020
}};

Vec3d xyz_of_xy(double x, double y) {
  return {x / y, 1, (1 - x - y) / y};
}

// Bradford's cone response (Lam 1985), as published by the ICC, transposed for row vectors.
const Matrix33d kBradford(0.8951, -0.7502, 0.0389, 0.2664, 1.7135, -0.0685, -0.1614, 0.0367, 1.0296);

Matrix33d bradford_adaptation(const Vec3d& from_white, const Vec3d& to_white) {
  const Vec3d from = from_white * kBradford, to = to_white * kBradford;
  const Matrix33d scale(to.x / from.x, 0, 0, 0, to.y / from.y, 0, 0, 0, to.z / from.z);
  return kBradford * scale * kBradford.inverse();
}

double largest_difference(const XyzColumns& a, const XyzColumns& b) {
  double largest = 0;
  for (size_t i = 0; i < 3; ++i)
    for (size_t j = 0; j < 3; ++j) largest = std::max(largest, std::abs(a[i][j] - b[i][j]));
  return largest;
}

}  // namespace

XyzColumns xyz_d65_columns(const Chromaticities& c) {
  // SMPTE RP 177: scale each primary so that together they make the white.
  Matrix33d primaries;
  for (int i = 0; i < 3; ++i) {
    const size_t at = 2 * size_t(i);
    const double x = c[at], y = c[at + 1];
    const Vec3d xyz(x, y, 1 - x - y);
    for (int j = 0; j < 3; ++j) primaries[i][j] = xyz[j];
  }
  const Vec3d white = xyz_of_xy(c[6], c[7]);
  const Vec3d scale = white * primaries.inverse();
  const Matrix33d adapt = bradford_adaptation(white, xyz_of_xy(kRec709[6], kRec709[7]));
  XyzColumns columns{};
  for (int i = 0; i < 3; ++i) {
    const Vec3d xyz = Vec3d(primaries[i][0], primaries[i][1], primaries[i][2]) * scale[i] * adapt;
    columns[size_t(i)] = {xyz.x, xyz.y, xyz.z};
  }
  return columns;
}

std::optional<std::array<std::array<float, 3>, 3>> rgb_to_rgb(const Chromaticities& from, const Chromaticities& to) {
  // Row i: XYZ of the unit vector i. Primaries that are CIE X, Y and Z are no lights, and have no white to adapt.
  const auto matrix_of = [](const Chromaticities& c) {
    Matrix33d matrix;
    if (std::array{c[0], c[1], c[2], c[3], c[4], c[5]} == std::array{1.0f, 0.0f, 0.0f, 1.0f, 0.0f, 0.0f}) return matrix;
    const XyzColumns columns = xyz_d65_columns(c);
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) matrix[i][j] = columns[size_t(i)][size_t(j)];
    return matrix;
  };
  const Matrix33d rgb_to_xyz = matrix_of(from), result = rgb_to_xyz * matrix_of(to).inverse();
  std::array<std::array<float, 3>, 3> rows{};
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      rows[size_t(j)][size_t(i)] = float(result[i][j]);
      if (!std::isfinite(result[i][j])) return std::nullopt;
    }
  if (!(std::abs(rgb_to_xyz.determinant()) > 1e-6)) return std::nullopt;
  return rows;
}

Chromaticities chromaticities_of(const XyzColumns& columns) {
  std::array<double, 3> white{};
  for (const auto& column : columns)
    for (size_t j = 0; j < 3; ++j) white[j] += column[j];
  if (!std::isfinite(white[0] + white[1] + white[2]) || !(white[1] > 0)) return kRec709;

  XyzColumns scaled = columns;
  for (auto& column : scaled)
    for (double& v : column) v /= white[1];
  // Published matrices are rounded to about four digits; the nearest two known spaces differ by far more.
  for (const Chromaticities& known : kKnownSpaces)
    if (largest_difference(scaled, xyz_d65_columns(known)) < 1.5e-3) return known;

  Chromaticities result{};
  for (size_t i = 0; i < 4; ++i) {
    const auto& xyz = i < 3 ? columns[i] : white;
    const double sum = xyz[0] + xyz[1] + xyz[2];
    if (!(std::abs(sum) > 1e-9)) return kRec709;
    result[2 * i] = float(xyz[0] / sum);
    result[2 * i + 1] = float(xyz[1] / sum);
  }
  return result;
}

}  // namespace alabaster
