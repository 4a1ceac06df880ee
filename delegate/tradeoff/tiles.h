// The same part of several pictures side by side, for a person to compare.
#pragma once

#include <span>
#include <string>

#include "delegate/tradeoff/analysis.h"

namespace alabaster::tradeoff {

/// Draws the tiles, which have one size, enlarged and with their names into `file` (.png), written under a temporary
/// name and renamed. Needs the program gnuplot. Empty on success, else the problem and its remedy.
std::string draw_tiles(std::span<const Tile> tiles, const std::string& file);

}  // namespace alabaster::tradeoff
