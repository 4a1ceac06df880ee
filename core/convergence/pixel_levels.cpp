#include "core/convergence/pixel_levels.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/convergence/pixel_loop.h"

namespace alabaster {
namespace {

// Neighbours of one kind: beside a pixel, above and below it, or across its corners.
struct Neighbours {
  double sum = 0;
  int members = 0, in_frame = 0;
};

// The surroundings of a pixel.
struct Surroundings {
  double level = 0;   // mean of the 3 x 3 pixels, in which its own level counts at most as its brightest neighbour's
  double excess = 0;  // of its own level over its brightest neighbour's
};

/// The neighbours of each kind that are in the groups stand for all of that kind. A sample that found much light by
/// chance must not excuse the noise that it is, so the level leaves out the excess.
Surroundings surroundings(const PixelSet& pixels, size_t i) {
  const NoiseImage& image = pixels.image();
  const int x = pixels.x(i), y = pixels.y(i);
  const auto level = [&](int nx, int ny) -> double {
    return image.pixels[size_t(ny) * size_t(image.width) + size_t(nx)].level;
  };
  std::array<Neighbours, 3> kinds;
  double brightest = 0;
  for (int ny = std::max(0, y - 1); ny <= std::min(image.height - 1, y + 1); ++ny)
    for (int nx = std::max(0, x - 1); nx <= std::min(image.width - 1, x + 1); ++nx) {
      if (nx == x && ny == y) continue;
      Neighbours& kind = kinds[ny == y ? 0 : nx == x ? 1 : 2];
      ++kind.in_frame;
      if (!is_in(pixels.groups(), image.x0 + nx, image.y0 + ny)) continue;
      kind.sum += level(nx, ny);
      ++kind.members;
      brightest = std::max(brightest, level(nx, ny));
    }
  double sum = 0;
  int count = 1;
  for (const Neighbours& kind : kinds) {
    if (kind.members == 0) continue;
    sum += kind.in_frame * kind.sum / kind.members;
    count += kind.in_frame;
  }
  const double own = level(x, y);
  if (count == 1) return {own, 0};
  return {(sum + std::min(own, brightest)) / count, std::max(0.0, own - brightest)};
}

// Sums over rectangles of an image.
class AreaSums {
 public:
  AreaSums(int width, int height)
      : width_(width), height_(height), sums_(size_t(width + 1) * size_t(height + 1), {0, 0}) {}
  struct Sums {
    double values = 0, squares = 0;
  };
  void set(int x, int y, double value) { at(x + 1, y + 1) = {value, value * value}; }
  void add_up() {
    for (int y = 1; y <= height_; ++y)
      for (int x = 1; x <= width_; ++x) {
        const Sums &left = at(x - 1, y), &above = at(x, y - 1), &corner = at(x - 1, y - 1);
        at(x, y).values += left.values + above.values - corner.values;
        at(x, y).squares += left.squares + above.squares - corner.squares;
      }
  }
  /// Over the pixels within `reach` of (x, y), and how many those are.
  Sums around(int x, int y, int reach, double* pixels) const {
    const int x0 = std::max(0, x - reach), x1 = std::min(width_, x + reach + 1);
    const int y0 = std::max(0, y - reach), y1 = std::min(height_, y + reach + 1);
    *pixels = double(x1 - x0) * double(y1 - y0);
    const Sums &a = at(x1, y1), &b = at(x0, y1), &c = at(x1, y0), &d = at(x0, y0);
    return {a.values - b.values - c.values + d.values, a.squares - b.squares - c.squares + d.squares};
  }

 private:
  Sums& at(int x, int y) { return sums_[size_t(y) * size_t(width_ + 1) + size_t(x)]; }
  const Sums& at(int x, int y) const { return sums_[size_t(y) * size_t(width_ + 1) + size_t(x)]; }
  int width_, height_;
  std::vector<Sums> sums_;
};

/// Pixels that stand out of their neighbours tell of light that few samples find. The mean excess of such pixels within
/// some distance, without this one, estimates that light here. From k of them it is uncertain by 1 / sqrt(k) of itself
/// (frame_error.md, "Rare light").
LevelRange level_range(const AreaSums& excesses, double share, const Surroundings& own, int x, int y) {
  LevelRange range{own.level, own.level, own.excess};
  if (!(own.excess > 0)) return range;
  double more_low = 0, more_high = 0;
  for (const int reach : {3, 8}) {
    double pixels = 0;
    AreaSums::Sums others = excesses.around(x, y, reach, &pixels);
    others.values = std::max(0.0, others.values - own.excess);
    others.squares = std::max(0.0, others.squares - own.excess * own.excess);
    if (!(others.squares > 0)) continue;
    const double k = std::max(1.0, others.values * others.values / others.squares);
    const double mean = std::min(others.values, k * own.excess) / std::max(1.0, share * pixels - 1);
    more_low = std::max(more_low, mean * (1 - 1 / std::sqrt(k)));
    more_high = std::max(more_high, mean * (1 + 1 / std::sqrt(k)));
  }
  range.low += std::min(more_low, own.excess);
  range.high += more_high;
  return range;
}

}  // namespace

std::vector<LevelRange> level_ranges(const PixelSet& pixels, const CancelToken& cancel) {
  const size_t n = pixels.size();
  std::vector<LevelRange> ranges(n);
  const auto for_all = [&](const auto& visit) {
    for_pixel_blocks(
        n,
        [&](size_t, size_t begin, size_t end) {
          for (size_t i = begin; i < end; ++i) visit(i);
        },
        cancel);
  };
  std::vector<Surroundings> around(n);
  AreaSums excesses(pixels.image().width, pixels.image().height);
  for_all([&](size_t i) {
    around[i] = surroundings(pixels, i);
    excesses.set(pixels.x(i), pixels.y(i), around[i].excess);
  });
  excesses.add_up();
  const double share = double(n) / double(pixels.image().pixels.size());
  for_all([&](size_t i) { ranges[i] = level_range(excesses, share, around[i], pixels.x(i), pixels.y(i)); });
  return ranges;
}

double error_floor(const PixelSet& pixels, const CancelToken& cancel) {
  const size_t n = pixels.size();
  const auto mean = sum_over_pixels<double>(
      n, [&](size_t i, double* sum) { *sum += double(pixels[i].level) / double(n); }, cancel);
  return mean == 0 ? 0 : kErrorFloor * mean;
}

std::vector<size_t> places_of(const NoiseImage& image, uint32_t groups) {
  std::vector<size_t> places;
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x)
      if (is_in(groups, image.x0 + x, image.y0 + y)) places.push_back(size_t(y) * size_t(image.width) + size_t(x));
  return places;
}

}  // namespace alabaster
