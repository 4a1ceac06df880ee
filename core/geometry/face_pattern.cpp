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
  pattern.facets.resize(static_cast<size_t>(tessellation.GetNumFacets()));
  tessellation.GetFacets(pattern.facets.data()->data());
  pair_up(&pattern.facets);
  return pattern;
}

}  // namespace alabaster
