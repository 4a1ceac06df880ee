#include "core/geometry/face_pattern.h"

#include <opensubdiv/bfr/tessellation.h>

#include "core/geometry/triangle_pairs.h"

namespace alabaster {

FacePattern make_pattern(const OpenSubdiv::Bfr::Parameterization& face, const std::vector<int>& rates) {
  const OpenSubdiv::Bfr::Tessellation tessellation(face, static_cast<int>(rates.size()), rates.data());
  FacePattern pattern;
  pattern.boundary = static_cast<uint32_t>(tessellation.GetNumBoundaryCoords());
  pattern.samples = static_cast<uint32_t>(tessellation.GetNumCoords());
  pattern.coordinates.resize(2 * size_t(pattern.samples));
  tessellation.GetCoords(pattern.coordinates.data());
  std::vector<std::array<int, 3>>& facets = pattern.facets;
  facets.resize(static_cast<size_t>(tessellation.GetNumFacets()));
  tessellation.GetFacets(facets.data()->data());
  for (size_t t = 0; t + 1 < facets.size(); t += 2)
    if (const auto turns = turns_to_pair(facets[t], facets[t + 1]))
      turn(&facets[t], turns->first), turn(&facets[t + 1], turns->second);
  return pattern;
}

}  // namespace alabaster
