#include "delegate/tradeoff/tiles.h"

#include <algorithm>
#include <cmath>

#include "delegate/tradeoff/gnuplot.h"

namespace alabaster::tradeoff {
namespace {

constexpr size_t kMostColumns = 4;
constexpr int kTileWidth = 300, kGap = 10, kName = 26, kDetail = 18;  // pixels

int byte_of(float v) {
  return static_cast<int>(std::lround(255 * std::clamp(v, 0.0f, 1.0f)));
}

/// The tile as a block of gnuplot data: x, y, red, green and blue of each of its pixels, each of them `scale` pixels
/// wide and high so that none is blurred.
std::string block_of(const Image& image, size_t number, int scale) {
  std::string text = "$tile" + std::to_string(number) + " << EOD\n";
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

std::string script(std::span<const CaptionedTile> tiles, const std::string& output) {
  const Image& first = *tiles.front().pixels;
  const int scale = std::max(1, kTileWidth / first.width);
  const int width = first.width * scale, height = first.height * scale;
  const size_t columns = std::min(kMostColumns, tiles.size()), rows = (tiles.size() + columns - 1) / columns;
  const bool has_details = std::any_of(tiles.begin(), tiles.end(), [](const auto& t) { return !t.detail.empty(); });
  const int caption = kName + (has_details ? kDetail : 0);
  const int across = int(columns) * (width + kGap) + kGap, down = int(rows) * (height + caption + kGap) + kGap;
  std::string text = "set terminal pngcairo size " + std::to_string(across) + "," + std::to_string(down) +
                     " noenhanced font 'sans,11' background '#FFFFFF'\nset output " + gnuplot_quoted(output) +
                     "\nset encoding utf8\nunset key\nunset border\nunset tics\nset multiplot\n";
  const auto share = [](int pixels, int of) { return std::to_string(double(pixels) / of); };
  for (size_t i = 0; i < tiles.size(); ++i) {
    const int left = kGap + int(i % columns) * (width + kGap);
    const int top = kGap + int(i / columns) * (height + caption + kGap);
    const auto line = [&](int number, const std::string& words, int below) {
      return "set label " + std::to_string(number) + " " + gnuplot_quoted(words) + " at screen " + share(left, across) +
             "," + share(down - top - below, down) + " left noenhanced\n";
    };
    text += block_of(*tiles[i].pixels, i, scale) + "set lmargin at screen " + share(left, across) +
            "\nset rmargin at screen " + share(left + width, across) + "\nset tmargin at screen " +
            share(down - top - caption, down) + "\nset bmargin at screen " +
            share(down - top - caption - height, down) + "\nset xrange [-0.5:" + std::to_string(width) +
            "-0.5]\nset yrange [-0.5:" + std::to_string(height) + "-0.5]\n" + line(1, tiles[i].name, kName / 2) +
            (has_details ? line(2, tiles[i].detail, kName + kDetail / 3) : "") + "plot $tile" + std::to_string(i) +
            " using 1:2:3:4:5 with rgbimage\n";
  }
  return text + "unset multiplot\n";
}

}  // namespace

std::string draw_tiles(std::span<const CaptionedTile> tiles, const std::string& file) {
  return draw_with_gnuplot([&](const std::string& drawn) { return script(tiles, drawn); }, file);
}

}  // namespace alabaster::tradeoff
