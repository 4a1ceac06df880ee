#include "core/subsurface/half_space.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/math/vector.h"
#include "core/subsurface/dwivedi.h"

namespace alabaster {
namespace {

/// Gauss-Legendre's rule on [0, 1].
template <size_t kNodes>
struct GaussRule {
  std::array<double, kNodes> at{}, weight{};

  GaussRule() {
    for (size_t i = 0; i < kNodes; ++i) {
      // Newton's method on the Legendre polynomial, from Tricomi's guess.
      double z = std::cos(kPiDouble * (double(i) + 0.75) / (double(kNodes) + 0.5)), slope = 1;
      for (int step = 0; step < 20; ++step) {
        double p = 1, before = 0;
        for (size_t j = 0; j < kNodes; ++j) {
          const double k = double(j), next = ((2 * k + 1) * z * p - k * before) / (k + 1);
          before = p, p = next;
        }
        slope = double(kNodes) * (z * p - before) / (z * z - 1);
        z -= p / slope;
      }
      at[i] = 0.5 * (1 - z);
      weight[i] = 1 / ((1 - z * z) * slope * slope);
    }
  }
};

/// J(t) exp(x t) over s = sqrt(1-alpha) and y, t = (y/(1-y))^2: smooth in both, and bounded.
class EscapeTable {
 public:
  EscapeTable() {
    for (size_t row = 0; row <= kRows; ++row) fill(row);
  }

  double operator()(double s, double y) const {
    const double u = s * kRows, v = y * kColumns;
    const size_t row = std::min(static_cast<size_t>(u), kRows - 1),
                 column = std::min(static_cast<size_t>(v), kColumns - 1);
    const double fu = u - double(row), fv = v - double(column);
    const auto in = [&](const Row& values) { return values[column] * (1 - fv) + values[column + 1] * fv; };
    return in(rows_[row]) * (1 - fu) + in(rows_[row + 1]) * fu;
  }

 private:
  static constexpr size_t kRows = 128, kColumns = 64, kNodes = 48;
  using Row = std::array<double, kColumns + 1>;

  /// The continuum of a medium: weights w dnu at nodes nu.
  struct Continuum {
    std::array<double, kNodes> nu{}, weight{};
    double operator()(double t, double x) const {
      double sum = 0;
      for (size_t i = 0; i < kNodes; ++i) sum += weight[i] * std::exp(t * (x - 1 / nu[i]));
      return sum;
    }
  };

  /// ln H = -(mu/pi) Int_0^{pi/2} ln(1 - alpha a cot a) / (cos^2 a + mu^2 sin^2 a) da (Chandrasekhar 1960, section 39).
  static Continuum continuum(double alpha, double s) {
    static const GaussRule<64> angles;
    static const GaussRule<kNodes> nodes;
    std::array<double, 64> logarithm{}, cosine2{};
    for (size_t i = 0; i < angles.at.size(); ++i) {
      const double a = 0.5 * kPiDouble * angles.at[i];
      logarithm[i] = 0.5 * kPiDouble * angles.weight[i] * std::log(1 - alpha * a / std::tan(a));
      cosine2[i] = std::cos(a) * std::cos(a);
    }
    Continuum c;
    for (size_t i = 0; i < kNodes; ++i) {
      const double v = nodes.at[i], nu = v * v * (3 - 2 * v);  // dense at both ends
      double log_h = 0;
      for (size_t k = 0; k < angles.at.size(); ++k) log_h += logarithm[k] / (cosine2[k] + nu * nu * (1 - cosine2[k]));
      const double h = std::exp(-nu / kPiDouble * log_h);
      const double lambda = 1 - alpha * nu * std::atanh(nu), jump = 0.5 * kPiDouble * alpha * nu;
      c.nu[i] = nu;
      c.weight[i] = s * nodes.weight[i] * 6 * v * (1 - v) / (2 * h * (lambda * lambda + jump * jump));
    }
    return c;
  }

  void fill(size_t row) {
    const double s = double(row) / kRows, x = dwivedi_mode(s * s).x;
    const Continuum transient = continuum(1 - s * s, s);
    const double mode = std::max(0.0, 1 / (1 + s) - transient(0, 0));
    for (size_t column = 0; column <= kColumns; ++column) {
      const double y = std::min(double(column) / kColumns, 0.999), root = y / (1 - y);
      rows_[row][column] = mode + transient(root * root, x);
    }
  }

  std::array<Row, kRows + 1> rows_;
};

}  // namespace

double escape_probability(double one_minus_alpha, double x, double optical_depth) {
  static const EscapeTable table;
  const double root = std::sqrt(optical_depth);
  return table(std::sqrt(one_minus_alpha), root / (1 + root)) * std::exp(-x * optical_depth);
}

}  // namespace alabaster
