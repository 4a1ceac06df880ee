#include "delegate/gltf/gltf_accessor.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

namespace alabaster::hd::gltf {
namespace {

template <class T>
T load(const uint8_t* p) {
  T value;
  std::memcpy(&value, p, sizeof(T));
  return value;
}

template <class T>
float to_float(const uint8_t* p, bool normalized) {
  const T value = load<T>(p);
  if (!normalized) return float(value);
  return std::max(float(value) / float(std::numeric_limits<T>::max()), -1.0f);
}

float component_to_float(const uint8_t* p, int type, bool normalized) {
  switch (type) {
    case kByte:
      return to_float<int8_t>(p, normalized);
    case kUnsignedByte:
      return to_float<uint8_t>(p, normalized);
    case kShort:
      return to_float<int16_t>(p, normalized);
    case kUnsignedShort:
      return to_float<uint16_t>(p, normalized);
    case kUnsignedInt:
      return float(load<uint32_t>(p));
    default:
      return load<float>(p);
  }
}

// Replaces elements of the base accessor by the sparse entries (glTF 2.0, section 3.6.2.3).
template <class Put>
void for_each_sparse(const AccessorView& accessor, Put put) {
  const size_t element_size = component_size(accessor.component_type) * accessor.components;
  for (size_t k = 0; k < accessor.sparse_count; ++k) {
    const uint8_t* index = accessor.sparse_indices + k * component_size(accessor.sparse_index_type);
    put(read_index(index, accessor.sparse_index_type), accessor.sparse_values + k * element_size);
  }
}

}  // namespace

size_t component_size(int component_type) {
  switch (component_type) {
    case kByte:
    case kUnsignedByte:
      return 1;
    case kShort:
    case kUnsignedShort:
      return 2;
    case kUnsignedInt:
    case kFloat:
      return 4;
    default:
      return 0;
  }
}

uint32_t read_index(const uint8_t* p, int component_type) {
  if (component_type == kUnsignedByte) return *p;
  if (component_type == kUnsignedShort) return load<uint16_t>(p);
  return load<uint32_t>(p);
}

std::vector<float> read_floats(const AccessorView& accessor, const std::vector<uint32_t>& wanted) {
  const size_t n = accessor.components, size = component_size(accessor.component_type);
  std::vector<float> values((wanted.empty() ? accessor.count : wanted.size()) * n, 0.0f);
  const auto read_element = [&](size_t to, const uint8_t* from) {
    for (size_t c = 0; c < n; ++c)
      values[to * n + c] = component_to_float(from + c * size, accessor.component_type, accessor.normalized);
  };
  if (accessor.data)
    for (size_t i = 0; i < values.size() / n; ++i)
      read_element(i, accessor.data + (wanted.empty() ? i : wanted[i]) * accessor.stride);
  for_each_sparse(accessor, [&](size_t element, const uint8_t* from) {
    if (wanted.empty()) return read_element(element, from);
    const auto found = std::lower_bound(wanted.begin(), wanted.end(), element);
    if (found != wanted.end() && *found == element) read_element(size_t(found - wanted.begin()), from);
  });
  return values;
}

std::optional<size_t> first_not_finite(const AccessorView& accessor) {
  const std::vector<float> values = read_floats(accessor);
  const auto found = std::find_if(values.begin(), values.end(), [](float v) { return !std::isfinite(v); });
  if (found == values.end()) return {};
  return size_t(found - values.begin()) / accessor.components;
}

std::vector<uint32_t> read_indices(const AccessorView& accessor) {
  std::vector<uint32_t> values(accessor.count, 0);
  if (accessor.data)
    for (size_t i = 0; i < accessor.count; ++i)
      values[i] = read_index(accessor.data + i * accessor.stride, accessor.component_type);
  for_each_sparse(accessor, [&](size_t element, const uint8_t* from) {
    values[element] = read_index(from, accessor.component_type);
  });
  return values;
}

}  // namespace alabaster::hd::gltf
