#include "delegate/tradeoff/tiles.h"

#include <algorithm>
#include <cmath>

#include "delegate/tradeoff/gnuplot.h"

namespace alabaster::tradeoff {
namespace {

constexpr size_t kMostColumns = 4;
constexpr int kTileWidth = 300, kGap = 10, kName = 26;  // pixels

int byte_of(float v) {
  return static_cast<int>(std::lround(255 * std::clamp(v, 0.0f, 1.0f)));
}

/// The tile as a block of gnuplot data: x, y, red, green and blue of each of its pixels, each of them `scale` pixels
/// wide and high so that none is blurred.
std::string block_of(const Tile& tile, size_t number, int scale) {
  std::string text = "$tile" + std::to_string(number) + " << EOD\n";
  const Image& image = tile.pixels;
  for (int y = 0; y < image.height * scale; ++y)
    for (int x = 0; x < image.width * scale; ++x) {
      const size_t i =
          3 * (static_cast<size_t>(y / scale) * static_cast<size_t>(image.width) + static_cast<size_t>(x / scale));
      text += std::to_string(x) + " " + std::to_string(image.height * scale - 1 - y);
      for (size_t c = 0; c < 3; ++c) text += " " + std::to_string(byte_of(image.rgb[i + c]));
      text += "\n";
    }
  return text + "EOD\n";
}

std::string name_of(const Tile& tile) {
  if (tile.samples == 0) return tile.name;
  return tile.name + ", " + std::to_string(tile.samples) + (tile.samples == 1 ? " sample" : " samples");
}

std::string script(std::span<const Tile> tiles, const std::string& output) {
  const Image& first = tiles.front().pixels;
  const int scale = std::max(1, kTileWidth / first.width);
  const int width = first.width * scale, height = first.height * scale;
  const size_t columns = std::min(kMostColumns, tiles.size()), rows = (tiles.size() + columns - 1) / columns;
  const int across = int(columns) * (width + kGap) + kGap, down = int(rows) * (height + kName + kGap) + kGap;
  std::string text = "set terminal pngcairo size " + std::to_string(across) + "," + std::to_string(down) +
                     " noenhanced font 'sans,11' background '#FFFFFF'\nset output " + gnuplot_quoted(output) +
                     "\nset encoding utf8\nunset key\nunset border\nunset tics\nset multiplot\n";
  const auto share = [](int pixels, int of) { return std::to_string(double(pixels) / of); };
  for (size_t i = 0; i < tiles.size(); ++i) {
    const int left = kGap + int(i % columns) * (width + kGap), top = kGap + int(i / columns) * (height + kName + kGap);
    text += block_of(tiles[i], i, scale) + "set lmargin at screen " + share(left, across) + "\nset rmargin at screen " +
            share(left + width, across) + "\nset tmargin at screen " + share(down - top - kName, down) +
            "\nset bmargin at screen " + share(down - top - kName - height, down) +
            "\nset xrange [-0.5:" + std::to_string(width) + "-0.5]\nset yrange [-0.5:" + std::to_string(height) +
            "-0.5]\nset label 1 " + gnuplot_quoted(name_of(tiles[i])) + " at screen " + share(left, across) + "," +
            share(down - top - kName / 2, down) + " left noenhanced\nplot $tile" + std::to_string(i) +
            " using 1:2:3:4:5 with rgbimage\n";
  }
  return text + "unset multiplot\n";
}

}  // namespace

std::string draw_tiles(std::span<const Tile> tiles, const std::string& file) {
  return draw_with_gnuplot([&](const std::string& drawn) { return script(tiles, drawn); }, file);
}

}  // namespace alabaster::tradeoff
