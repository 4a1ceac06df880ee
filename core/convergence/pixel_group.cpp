#include "core/convergence/pixel_group.h"

#include <algorithm>

#include <tbb/parallel_for.h>

namespace alabaster {

GroupImage group_image(const PixelRect& window, const std::vector<PixelNoise>& noise, int group) {
  GroupImage image;
  image.y0 = window.y0 + ((group >= 2) != ((window.y0 & 1) != 0) ? 1 : 0);
  const bool right = group == 1 || group == 2;
  image.x0 = window.x0 + (right != ((window.x0 & 1) != 0) ? 1 : 0);
  image.noise.width = std::max(0, (window.x1 - image.x0 + 1) / 2);
  image.noise.height = image.noise.width > 0 ? std::max(0, (window.y1 - image.y0 + 1) / 2) : 0;
  const auto own = static_cast<size_t>(image.noise.width), all = static_cast<size_t>(window.width());
  image.noise.pixels.resize(own * static_cast<size_t>(image.noise.height));
  tbb::parallel_for(size_t(0), static_cast<size_t>(image.noise.height), [&](size_t row) {
    const PixelNoise* from = noise.data() + (static_cast<size_t>(image.y0 - window.y0) + 2 * row) * all +
                             static_cast<size_t>(image.x0 - window.x0);
    for (size_t x = 0; x < own; ++x) image.noise.pixels[row * own + x] = from[2 * x];
  });
  return image;
}

namespace {

void copy_pixels(const PixelRect& rect, uint32_t groups, const FilmTile& from, FilmTile* to) {
  size_t pixel = 0;
  for (int y = rect.y0; y < rect.y1; ++y)
    for (int x = rect.x0; x < rect.x1; ++x, ++pixel)
      if (groups >> pixel_group(x, y) & 1) to->take(pixel, from);
}

}  // namespace

void copy_groups(const Film& from, uint32_t groups, Film* to) {
  tbb::parallel_for(0, to->tile_count(), [&](int t) {
    FilmTile pixels = to->load_tile(t);
    copy_pixels(to->tile_rect(t), groups, from.load_tile(t), &pixels);
    to->store_tile(t, pixels);
  });
}

void exchange_groups(const PixelRect& rect, uint32_t groups, FilmTile* a, FilmTile* b) {
  const FilmTile a_before = *a;
  copy_pixels(rect, groups, *b, a);
  copy_pixels(rect, groups, a_before, b);
}

void exchange_groups(uint32_t groups, Film* a, Film* b) {
  tbb::parallel_for(0, a->tile_count(), [&](int t) {
    FilmTile of_a = a->load_tile(t), of_b = b->load_tile(t);
    exchange_groups(a->tile_rect(t), groups, &of_a, &of_b);
    a->store_tile(t, of_a);
    b->store_tile(t, of_b);
  });
}

}  // namespace alabaster
