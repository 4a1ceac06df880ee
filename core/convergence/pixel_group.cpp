#include "core/convergence/pixel_group.h"

#include <utility>

namespace alabaster {

GroupImage group_image(const PixelRect& window, const std::vector<PixelNoise>& noise, int group) {
  GroupImage image;
  image.y0 = window.y0 + ((group >= 2) != ((window.y0 & 1) != 0) ? 1 : 0);
  const bool right = group == 1 || group == 2;
  image.x0 = window.x0 + (right != ((window.x0 & 1) != 0) ? 1 : 0);
  for (int y = image.y0; y < window.y1; y += 2) {
    const auto row = static_cast<size_t>(y - window.y0) * static_cast<size_t>(window.width());
    for (int x = image.x0; x < window.x1; x += 2)
      image.noise.pixels.push_back(noise[row + static_cast<size_t>(x - window.x0)]);
    ++image.noise.height;
  }
  image.noise.width = image.noise.height > 0 ? static_cast<int>(image.noise.pixels.size()) / image.noise.height : 0;
  return image;
}

void take_groups(const Film& from, uint32_t groups, Film* to) {
  for (int t = 0; t < to->tile_count(); ++t) {
    const FilmTile source = from.load_tile(t);
    FilmTile pixels = to->load_tile(t);
    const PixelRect r = to->tile_rect(t);
    size_t pixel = 0;
    for (int y = r.y0; y < r.y1; ++y)
      for (int x = r.x0; x < r.x1; ++x, ++pixel)
        if (groups >> pixel_group(x, y) & 1) pixels.take(pixel, source);
    to->store_tile(t, pixels);
  }
}

}  // namespace alabaster
