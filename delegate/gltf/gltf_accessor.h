// Typed data of a document: accessors all of whose bytes are known to lie inside their buffers.
#pragma once

#include <compare>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace alabaster::hd::gltf {

enum ComponentType : int { kByte = 5120, kUnsignedByte, kShort, kUnsignedShort, kUnsignedInt = 5125, kFloat };

/// Bytes of one component; 0 for a type glTF does not know.
size_t component_size(int component_type);

/// Only load_accessors makes these, after checking that all `count` elements and all sparse entries are in range.
/// Pointers lead into the document's buffers and are valid as long as those.
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
  int buffer_view = -1;                    // -1: none
  bool has_stride = false;                 // its buffer view has a byteStride
  bool has_bounds = false;                 // min and max are given
  auto operator<=>(const AccessorView&) const = default;
};

/// One integer component at `p`, which need not be aligned.
uint32_t read_index(const uint8_t* p, int component_type);

/// The elements that `wanted` lists, which rise, all if it is empty: components interleaved, normalized integers mapped
/// to [0,1] or [-1,1] (glTF 2.0, section 3.6.2.2), and sparse values applied. No matrices but MAT4 of floats.
std::vector<float> read_floats(const AccessorView& accessor, const std::vector<uint32_t>& wanted = {});

/// The first element that is not finite; empty if all are.
std::optional<size_t> first_not_finite(const AccessorView& accessor);

/// The values of a scalar accessor of unsigned integers.
std::vector<uint32_t> read_indices(const AccessorView& accessor);

}  // namespace alabaster::hd::gltf
