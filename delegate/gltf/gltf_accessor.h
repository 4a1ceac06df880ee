// Typed data of a document: accessors whose every byte is known to lie inside its buffer.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace alabaster::hd::gltf {

enum ComponentType : int { kByte = 5120, kUnsignedByte, kShort, kUnsignedShort, kUnsignedInt = 5125, kFloat };

/// Bytes of one component; 0 for a type glTF does not know.
size_t component_size(int component_type);

/// Pointers are into the document's buffers and live as long as they do. Built by load_accessors alone, which checks
/// that all `count` elements and all sparse entries are in range.
struct AccessorView {
  std::string type;  // SCALAR, VEC2, ...
  int component_type = kFloat;
  bool normalized = false;
  size_t count = 0, components = 0;
  const uint8_t* data = nullptr;  // null: zeros
  size_t stride = 0;
  size_t sparse_count = 0;
  const uint8_t* sparse_indices = nullptr;
  int sparse_index_type = kUnsignedShort;
  const uint8_t* sparse_values = nullptr;  // tightly packed
};

/// One integer component at `p`, which need not be aligned.
uint32_t read_index(const uint8_t* p, int component_type);

/// All elements, components interleaved, normalized integers mapped to [0,1] or [-1,1] (glTF 2.0, section 3.6.2.2),
/// sparse values put in. Not for matrices.
std::vector<float> read_floats(const AccessorView& accessor);

/// A scalar accessor of unsigned integers.
std::vector<uint32_t> read_indices(const AccessorView& accessor);

}  // namespace alabaster::hd::gltf
