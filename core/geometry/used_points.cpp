#include "core/geometry/used_points.h"

#include <algorithm>
#include <cstdint>

namespace alabaster {
namespace {

template <class T>
void keep_at(const std::vector<uint32_t>& places, std::vector<T>* values) {
  std::vector<T> kept;
  kept.reserve(places.size());
  for (const uint32_t place : places) kept.push_back((*values)[place]);
  *values = std::move(kept);
}

// In a sanitized cage all primvars but those of face corners have a value for each point.
template <class T>
void keep_primvar(const std::vector<uint32_t>& places, Primvar<T>* primvar) {
  if (primvar->empty() || primvar->interpolation == Interpolation::face_varying) return;
  if (primvar->indices.empty())
    keep_at(places, &primvar->values);
  else
    keep_at(places, &primvar->indices);
}

}  // namespace

void drop_unused_points(Cage* cage) {
  constexpr int kUnused = -1;
  std::vector<int> number(cage->points.size(), kUnused);  // of the points that stay
  const auto each_index = [&](const auto& visit) {
    for (auto* indices : {&cage->face_vertex_indices, &cage->crease_indices, &cage->corner_indices})
      for (int& index : *indices) visit(index);
  };
  each_index([&](const int& index) { number[static_cast<size_t>(index)] = 0; });
  if (std::find(number.begin(), number.end(), kUnused) == number.end()) return;
  std::vector<uint32_t> kept;
  for (uint32_t point = 0; point < number.size(); ++point)
    if (number[point] != kUnused) number[point] = static_cast<int>(kept.size()), kept.push_back(point);
  each_index([&](int& index) { index = number[static_cast<size_t>(index)]; });
  keep_at(kept, &cage->points);
  keep_primvar(kept, &cage->normals);
  keep_primvar(kept, &cage->tangents);
  for_each_refined(*cage, [&](auto& primvar) { keep_primvar(kept, &primvar); });
}

}  // namespace alabaster
