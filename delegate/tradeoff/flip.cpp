#include "delegate/tradeoff/flip.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>

namespace alabaster::tradeoff {
namespace {

using Plane = std::vector<float>;  // one value a pixel
using Color = std::array<float, 3>;
using Matrix = std::array<Color, 3>;
constexpr double kPi = std::numbers::pi;

struct Size {
  int width, height;
  size_t count() const { return size_t(width) * size_t(height); }
};

// ---- colour ---------------------------------------------------------------------------------------------------------

/// IEC 61966-2-1: linear sRGB to CIE XYZ. The rows sum to white.
constexpr Matrix kToXyz = {{{0.4124f, 0.3576f, 0.1805f}, {0.2126f, 0.7152f, 0.0722f}, {0.0193f, 0.1192f, 0.9505f}}};
constexpr Color kWhite = {0.9505f, 1.0f, 1.0890f};

Matrix inverse(const Matrix& m) {
  const auto minor = [&](size_t r, size_t c) {
    const size_t r1 = (r + 1) % 3, r2 = (r + 2) % 3, c1 = (c + 1) % 3, c2 = (c + 2) % 3;
    return double(m[r1][c1]) * double(m[r2][c2]) - double(m[r1][c2]) * double(m[r2][c1]);
  };
  const double determinant =
      double(m[0][0]) * minor(0, 0) + double(m[0][1]) * minor(0, 1) + double(m[0][2]) * minor(0, 2);
  Matrix out;
  for (size_t r = 0; r < 3; ++r)
    for (size_t c = 0; c < 3; ++c) out[r][c] = float(minor(c, r) / determinant);
  return out;
}

Color times(const Matrix& m, const Color& v) {
  Color out;
  for (size_t i = 0; i < 3; ++i) out[i] = m[i][0] * v[0] + m[i][1] * v[1] + m[i][2] * v[2];
  return out;
}

float to_linear(float v) {
  v = v > 0 ? std::min(v, 1.0f) : 0.0f;  // a NaN is black
  return v <= 0.04045f ? v / 12.92f : std::pow((v + 0.055f) / 1.055f, 2.4f);
}

/// X, Y, Z over those of white.
Color relative_xyz(const Color& linear) {
  const Color xyz = times(kToXyz, linear);
  return {xyz[0] / kWhite[0], xyz[1] / kWhite[1], xyz[2] / kWhite[2]};
}

/// CIELAB after the Hunt adjustment (section "Color Metric"): lighter colours look more colourful.
Color hunt_lab(const Color& linear) {
  const auto curve = [](float t) {
    constexpr float kDelta = 6.0f / 29;
    return t > kDelta * kDelta * kDelta ? std::cbrt(t) : t / (3 * kDelta * kDelta) + 4.0f / 29;
  };
  const Color xyz = relative_xyz(linear);
  const float x = curve(xyz[0]), y = curve(xyz[1]), z = curve(xyz[2]);
  const float lightness = 116 * y - 16;
  const float hunt = 0.01f * lightness;
  return {lightness, hunt * 500 * (x - y), hunt * 200 * (y - z)};
}

/// HyAB (section "Color Metric"): city-block in lightness, Euclidean in the chromatic plane; good for large
/// differences.
float hyab(const Color& a, const Color& b) {
  return std::abs(a[0] - b[0]) + std::hypot(a[1] - b[1], a[2] - b[2]);
}

// ---- separable filters ----------------------------------------------------------------------------------------------

/// Taps from -radius to +radius.
using Kernel = std::vector<float>;

std::vector<double> sampled(int radius, const auto& weight) {
  std::vector<double> taps;
  for (int i = -radius; i <= radius; ++i) taps.push_back(weight(double(i)));
  return taps;
}

/// Scaled so that positive taps sum to 1 and negative ones to -1.
Kernel normalised(const std::vector<double>& taps) {
  double positive = 0, negative = 0;
  for (const double w : taps) (w > 0 ? positive : negative) += w;
  Kernel kernel;
  for (const double w : taps) kernel.push_back(float(w > 0 ? w / positive : w < 0 ? -w / negative : 0));
  return kernel;
}

/// Beyond the border the picture repeats the border's pixels.
Plane filter_rows(const Plane& in, Size size, const Kernel& kernel) {
  const size_t width = size_t(size.width), radius = kernel.size() / 2;
  Plane out(in.size(), 0.0f), padded(width + 2 * radius);
  for (size_t y = 0; y < size_t(size.height); ++y) {
    const float* row = in.data() + y * width;
    std::fill_n(padded.begin(), radius, row[0]);
    std::copy_n(row, width, padded.begin() + std::ptrdiff_t(radius));
    std::fill_n(padded.end() - std::ptrdiff_t(radius), radius, row[width - 1]);
    float* to = out.data() + y * width;
    for (size_t k = 0; k < kernel.size(); ++k)
      for (size_t x = 0; x < width; ++x) to[x] += kernel[k] * padded[x + k];
  }
  return out;
}

Plane filter_columns(const Plane& in, Size size, const Kernel& kernel) {
  const size_t width = size_t(size.width);
  const int radius = int(kernel.size() / 2);
  Plane out(in.size(), 0.0f);
  for (int y = 0; y < size.height; ++y) {
    float* to = out.data() + size_t(y) * width;
    for (size_t k = 0; k < kernel.size(); ++k) {
      const float* from = in.data() + size_t(std::clamp(y + int(k) - radius, 0, size.height - 1)) * width;
      const float weight = kernel[k];
      for (size_t x = 0; x < width; ++x) to[x] += weight * from[x];
    }
  }
  return out;
}

// ---- colour pipeline ------------------------------------------------------------------------------------------------

/// Section "Spatial Filtering": a contrast sensitivity function is a sum of two terms a exp(-b f^2) over f in cycles
/// per degree, so in degrees the filter is a sum of Gaussians a sqrt(pi / b) exp(-(pi d)^2 / b), normalized to unit
/// sum.
struct Sensitivity {
  double a1, b1, a2, b2;
};
constexpr Sensitivity kAchromatic{1, 0.0047, 0, 1e-5}, kRedGreen{1, 0.0053, 0, 1e-5},
    kBlueYellow{34.1, 0.04, 13.5, 0.025};

Plane see(const Plane& in, Size size, const Sensitivity& csf, double pixels_per_degree) {
  // Three standard deviations of the widest Gaussian (b = 0.04). Narrow ones end after six of their own, beyond which
  // floats add nothing.
  const double widest = std::sqrt(kBlueYellow.b1 / (2 * kPi * kPi)) * pixels_per_degree;
  struct Term {
    Kernel kernel;
    double weight;
  };
  const auto term = [&](double a, double b) {
    const double sigma = std::sqrt(b / (2 * kPi * kPi)) * pixels_per_degree;
    const int radius = int(std::ceil(std::min(3 * widest, 6 * sigma)));
    const std::vector<double> taps = sampled(radius, [&](double i) { return std::exp(-i * i / (2 * sigma * sigma)); });
    const double sum = std::accumulate(taps.begin(), taps.end(), 0.0);
    return Term{normalised(taps), a * std::sqrt(kPi / b) * sum * sum};
  };
  const auto blurred = [&](const Kernel& kernel) {
    return filter_columns(filter_rows(in, size, kernel), size, kernel);
  };
  const Term first = term(csf.a1, csf.b1);
  Plane out = blurred(first.kernel);
  if (csf.a2 == 0) return out;
  const Term second = term(csf.a2, csf.b2);
  const Plane other = blurred(second.kernel);
  const float share = float(second.weight / (first.weight + second.weight));
  for (size_t i = 0; i < out.size(); ++i) out[i] += share * (other[i] - out[i]);
  return out;
}

/// A picture in the opponent space YCxCz: linear, so that it may be filtered, and with the axes of CIELAB.
struct Opponent {
  Plane y, cx, cz;
};

Opponent to_opponent(const Image& image, Size size) {
  Opponent out{Plane(size.count()), Plane(size.count()), Plane(size.count())};
  for (size_t i = 0; i < size.count(); ++i) {
    const float* v = image.rgb.data() + 3 * i;
    const Color xyz = relative_xyz({to_linear(v[0]), to_linear(v[1]), to_linear(v[2])});
    out.y[i] = 116 * xyz[1] - 16;
    out.cx[i] = 500 * (xyz[0] - xyz[1]);
    out.cz[i] = 200 * (xyz[1] - xyz[2]);
  }
  return out;
}

/// The picture as the viewer perceives it, in CIELAB after the Hunt adjustment.
std::vector<Color> perceived(const Opponent& image, Size size, double pixels_per_degree) {
  static const Matrix kFromXyz = inverse(kToXyz);
  const Plane y = see(image.y, size, kAchromatic, pixels_per_degree);
  const Plane cx = see(image.cx, size, kRedGreen, pixels_per_degree);
  const Plane cz = see(image.cz, size, kBlueYellow, pixels_per_degree);
  std::vector<Color> out(size.count());
  for (size_t i = 0; i < out.size(); ++i) {
    const float luminance = (y[i] + 16) / 116;
    Color linear = times(kFromXyz, {kWhite[0] * (cx[i] / 500 + luminance), kWhite[1] * luminance,
                                    kWhite[2] * (luminance - cz[i] / 200)});
    for (float& v : linear) v = std::clamp(v, 0.0f, 1.0f);
    out[i] = hunt_lab(linear);
  }
  return out;
}

/// Section "Error Redistribution": differences to the power q_c. Those below p_c of the largest possible, the one
/// between pure green and pure blue, take the range up to p_t.
float redistributed(float difference) {
  constexpr float kPower = 0.7f, kKnee = 0.4f, kKneeValue = 0.95f;
  static const float largest = std::pow(hyab(hunt_lab({0, 1, 0}), hunt_lab({0, 0, 1})), kPower);
  const float knee = kKnee * largest;
  const float e = std::pow(difference, kPower);
  return e < knee ? kKneeValue * e / knee : kKneeValue + (1 - kKneeValue) * (e - knee) / (largest - knee);
}

// ---- feature pipeline -----------------------------------------------------------------------------------------------

struct Features {
  Plane edge, point;  // magnitudes over the two directions
};

/// Section "Feature Detection": first and second derivatives of a Gaussian as wide as the eye sees edges, 0.082
/// degrees.
Features detect_features(const Opponent& image, Size size, double pixels_per_degree) {
  const double sigma = 0.5 * 0.082 * pixels_per_degree;
  const int radius = int(std::ceil(3 * sigma));
  const auto gaussian = [&](double i) { return std::exp(-i * i / (2 * sigma * sigma)); };
  const Kernel smooth = normalised(sampled(radius, gaussian));
  const Kernel slope = normalised(sampled(radius, [&](double i) { return -i * gaussian(i); }));
  const Kernel bend =
      normalised(sampled(radius, [&](double i) { return (i * i / (sigma * sigma) - 1) * gaussian(i); }));

  Plane luminance = image.y;
  for (float& y : luminance) y = (y + 16) / 116;
  const Plane smooth_rows = filter_rows(luminance, size, smooth);
  const auto magnitude = [&](const Kernel& derivative) {
    Plane out = filter_columns(filter_rows(luminance, size, derivative), size, smooth);
    const Plane across = filter_columns(smooth_rows, size, derivative);
    for (size_t i = 0; i < out.size(); ++i) out[i] = std::hypot(out[i], across[i]);
    return out;
  };
  return {magnitude(slope), magnitude(bend)};
}

}  // namespace

FlipDifference flip_difference(const Image& reference, const Image& test, float pixels_per_degree) {
  const Size size{reference.width, reference.height};
  const bool comparable = size.width > 0 && size.height > 0 && test.width == size.width && test.height == size.height &&
                          reference.rgb.size() == 3 * size.count() && test.rgb.size() == 3 * size.count();
  if (!comparable || !(pixels_per_degree >= 1 && pixels_per_degree <= 1000))
    return {{}, std::numeric_limits<double>::quiet_NaN()};

  const double density = double(pixels_per_degree);
  const Opponent a = to_opponent(reference, size), b = to_opponent(test, size);
  const std::vector<Color> seen_a = perceived(a, size, density), seen_b = perceived(b, size, density);
  const Features features_a = detect_features(a, size, density), features_b = detect_features(b, size, density);

  FlipDifference out{Plane(size.count()), 0};
  for (size_t i = 0; i < out.map.size(); ++i) {
    // Section "Feature Difference Metric" (q_f = 0.5), and "Final Difference": features amplify differences of colour.
    const float feature = std::max(std::abs(features_a.edge[i] - features_b.edge[i]),
                                   std::abs(features_a.point[i] - features_b.point[i]));
    const float amplify = std::min(std::sqrt(feature / std::numbers::sqrt2_v<float>), 1.0f);
    out.map[i] = std::pow(redistributed(hyab(seen_a[i], seen_b[i])), 1 - amplify);
    out.mean += double(out.map[i]);
  }
  out.mean /= double(size.count());
  return out;
}

}  // namespace alabaster::tradeoff
