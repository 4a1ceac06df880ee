// Sets of image files, one for each unit square of texture coordinates.
#pragma once

#include <string>
#include <vector>

#include "core/math/vector.h"

namespace alabaster {

struct UdimTile {
  Vec2i place;  // the square's lower left corner
  std::string path;
};

/// The files of a set, by number: `path` with a number in place of "<UDIM>" in its last component, 1001 + u + 10 v for
/// the square (u, v), u below 10. Empty if `path` has no "<UDIM>" there, or there is no such file.
std::vector<UdimTile> udim_tiles(const std::string& path);

}  // namespace alabaster
