// The same part of several pictures side by side, for a person to compare.
#pragma once

#include <span>
#include <string>

#include "delegate/tradeoff/image.h"

namespace alabaster::tradeoff {

struct CaptionedTile {
  std::string name, detail;  // a line each, above the picture
  const Image* pixels = nullptr;
};

/// Draws the tiles, which have one size, small ones enlarged, with their captions into `file` (.png), written under a
/// temporary name and renamed. Needs the program gnuplot. Empty on success, else the problem and its remedy.
std::string draw_tiles(std::span<const CaptionedTile> tiles, const std::string& file);

}  // namespace alabaster::tradeoff
