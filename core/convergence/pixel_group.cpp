#include "core/convergence/pixel_group.h"

#include <tbb/parallel_for.h>

namespace alabaster {

namespace {

void copy_pixels(const PixelRect& rect, uint32_t groups, const FilmTile& from, FilmTile* to) {
  size_t pixel = 0;
  for (int y = rect.y0; y < rect.y1; ++y)
    for (int x = rect.x0; x < rect.x1; ++x, ++pixel)
      if (is_in(groups, x, y)) to->take(pixel, from);
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
