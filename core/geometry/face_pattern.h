// How a face of a cage is cut into triangles: OpenSubdiv's tessellation of it.
#pragma once

#include <opensubdiv/bfr/parameterization.h>

#include <array>
#include <cstdint>
#include <vector>

namespace alabaster {

/// The tessellation of faces of one size: samples on the boundary first (corner 0, edge 0, corner 1, ...), then the
/// interior.
struct FacePattern {
  uint32_t boundary = 0, samples = 0;
  std::vector<float> coordinates;          // two for each sample
  std::vector<std::array<int, 3>> facets;  // indices of samples; the two halves of a quad are a pair (triangle_pairs.h)
  uint32_t interior() const { return samples - boundary; }
  uint32_t triangles() const { return static_cast<uint32_t>(facets.size()); }
};

/// `rates`: segments, one number for all edges, or one for each.
FacePattern make_pattern(const OpenSubdiv::Bfr::Parameterization& face, const std::vector<int>& rates);

}  // namespace alabaster
