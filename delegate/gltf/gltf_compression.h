// Compressed geometry: EXT_meshopt_compression (buffer views) and KHR_draco_mesh_compression (primitives).
#pragma once

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "delegate/gltf/gltf_container.h"

namespace alabaster::hd::gltf {

/// The bytes of a document, valid as long as its buffers.
struct ByteRange {
  const uint8_t* data = nullptr;
  size_t size = 0;
};

/// Decoded bytes for each compressed one, at most. The vertex codec needs at least a bit for two bytes of a vertex's
/// neighbours: 4 bytes for 256 (its version 0). The index codecs need a byte for each triangle or index.
inline constexpr uint64_t kMostMeshoptGrowth = 64;

/// Decodes the buffer view that an EXT_meshopt_compression object describes. Null and `reason` if the bytes are not
/// what the object says, or if it declares more than they can hold.
Bytes decode_meshopt(const Json& extension, ByteRange compressed, std::string* reason);

/// The data of accessors, tightly packed, by their index.
using AccessorBytes = std::map<size_t, Bytes>;

struct DracoPrimitive {
  std::map<size_t, std::vector<uint8_t>> accessors;  // tightly packed, by their index
  float step = 0;                                    // of the grid to which positions were rounded; 0: they were not
};

/// Decodes the accessors of a primitive that has KHR_draco_mesh_compression. False and `reason` if the bytes do not
/// hold the elements that the accessors declare. Larger ones are refused before they are decoded.
bool decode_draco(const Json& root, const Json& primitive, ByteRange compressed, DracoPrimitive* decoded,
                  std::string* reason);

/// Upper bounds of the memory of join_draco_seams(). An index takes its copy and an edge, and a point takes its copy
/// and nodes of two maps and a set.
inline constexpr uint64_t kSeamBytesOfIndex = 40, kSeamBytesOfPoint = 280;

/// Joins the seams between the primitives of one mesh. Draco rounds each to a grid of its own, which parts what was one
/// surface.
void join_draco_seams(const Json& root, const std::vector<std::pair<const Json*, DracoPrimitive*>>& primitives);

}  // namespace alabaster::hd::gltf
