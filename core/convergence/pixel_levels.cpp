#include "core/convergence/pixel_levels.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

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

// Sums over rectangles of a part of an image.
class AreaSums {
 public:
  struct Sums {
    double values = 0, squares = 0;
  };
  /// The part from (x0, y0) up to (x1, y1); all values are 0.
  void reset(int x0, int y0, int x1, int y1) {
    x0_ = x0, y0_ = y0, width_ = x1 - x0, height_ = y1 - y0;
    sums_.assign(size_t(width_ + 1) * size_t(height_ + 1), {});
  }
  void set(int x, int y, double value) { at(x - x0_ + 1, y - y0_ + 1) = {value, value * value}; }
  void add_up() {
    for (int y = 1; y <= height_; ++y)
      for (int x = 1; x <= width_; ++x) {
        const Sums &left = at(x - 1, y), &above = at(x, y - 1), &corner = at(x - 1, y - 1);
        at(x, y).values += left.values + above.values - corner.values;
        at(x, y).squares += left.squares + above.squares - corner.squares;
      }
  }
  /// Over the pixels within `reach` of (x, y), and how many those are. The part ends where the image does, or further
  /// away.
  Sums around(int x, int y, int reach, double* pixels) const {
    const int x0 = std::max(0, x - x0_ - reach), x1 = std::min(width_, x - x0_ + reach + 1);
    const int y0 = std::max(0, y - y0_ - reach), y1 = std::min(height_, y - y0_ + reach + 1);
    *pixels = double(x1 - x0) * double(y1 - y0);
    const Sums &a = at(x1, y1), &b = at(x0, y1), &c = at(x1, y0), &d = at(x0, y0);
    return {a.values - b.values - c.values + d.values, a.squares - b.squares - c.squares + d.squares};
  }

 private:
  Sums& at(int x, int y) { return sums_[size_t(y) * size_t(width_ + 1) + size_t(x)]; }
  const Sums& at(int x, int y) const { return sums_[size_t(y) * size_t(width_ + 1) + size_t(x)]; }
  int x0_ = 0, y0_ = 0, width_ = 0, height_ = 0;
  std::vector<Sums> sums_;
};

constexpr int kBlockSide = 128, kFarReach = 8;

int blocks_along(int pixels) {
  return (pixels + kBlockSide - 1) / kBlockSide;
}

/// Pixels that stand out of their neighbours tell of light that few samples find. The mean excess of such pixels within
/// some distance, without this one, estimates that light here. From k of them it is uncertain by 1 / sqrt(k) of itself
/// (frame_error.md, "Rare light").
LevelRange level_range(const AreaSums& excesses, double share, const Surroundings& own, int x, int y) {
  LevelRange range{own.level, own.level, own.excess};
  if (!(own.excess > 0)) return range;
  double more_low = 0, more_high = 0;
  for (const int reach : {3, kFarReach}) {
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

// Visits the pixels of the set in columns x0 to x1 of row y: visit(i, x).
template <class Visit>
void visit_row(const PixelSet& pixels, int y, int x0, int x1, const Visit& visit) {
  const size_t row = size_t(y) * size_t(pixels.image().width);
  const size_t end = pixels.first_from(row + size_t(x1));
  for (size_t i = pixels.first_from(row + size_t(x0)); i < end; ++i) visit(i, pixels.x(i));
}

}  // namespace

size_t level_blocks(const NoiseImage& image) {
  return size_t(blocks_along(image.width)) * size_t(blocks_along(image.height));
}

void visit_levels(const PixelSet& pixels, const TakeLevel& take, const CancelToken& cancel) {
  const NoiseImage& image = pixels.image();
  const auto blocks_across = size_t(blocks_along(image.width));
  const double share = double(pixels.size()) / double(image.pixels.size());
  tbb::enumerable_thread_specific<AreaSums> excesses_of_threads;
  tbb::parallel_for(size_t(0), level_blocks(image), [&](size_t block) {
    if (cancel.is_cancelled()) return;
    const FloatEnvironment environment;
    const int x0 = int(block % blocks_across) * kBlockSide, x1 = std::min(image.width, x0 + kBlockSide);
    const int y0 = int(block / blocks_across) * kBlockSide, y1 = std::min(image.height, y0 + kBlockSide);
    const int near_x0 = std::max(0, x0 - kFarReach), near_x1 = std::min(image.width, x1 + kFarReach);
    const int near_y0 = std::max(0, y0 - kFarReach), near_y1 = std::min(image.height, y1 + kFarReach);
    AreaSums& excesses = excesses_of_threads.local();
    excesses.reset(near_x0, near_y0, near_x1, near_y1);
    for (int y = near_y0; y < near_y1; ++y)
      visit_row(pixels, y, near_x0, near_x1,
                [&](size_t i, int x) { excesses.set(x, y, surroundings(pixels, i).excess); });
    excesses.add_up();
    for (int y = y0; y < y1; ++y)
      visit_row(pixels, y, x0, x1,
                [&](size_t i, int x) { take(block, i, level_range(excesses, share, surroundings(pixels, i), x, y)); });
  });
  cancel.check();
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
