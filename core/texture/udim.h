// Sets of image files, one for each unit square of texture coordinates.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "core/math/vector.h"

namespace alabaster {

struct UdimTile {
  Vec2i place;  // the square's lower left corner
  std::string path;
  std::shared_ptr<const std::vector<uint8_t>> bytes = {};  // of a set in memory: the encoded image
};

/// The files of a set, by number: `path` with a number in place of "<UDIM>" in its last component, 1001 + u + 10 v for
/// the square (u, v), u below 10. Empty if `path` has no "<UDIM>" there, or there is no such file.
std::vector<UdimTile> udim_tiles(const std::string& path);
/// The images of a set in memory, as of a package: "UDIM", and for each its number and its size, as four and eight
/// bytes with the lowest first, and the encoded image. Empty: it is no set, or damaged.
std::vector<UdimTile> udim_tiles(const std::string& path, const std::vector<uint8_t>& set);

}  // namespace alabaster
