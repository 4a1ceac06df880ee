#include "core/geometry/edge_rates.h"

#include <opensubdiv/bfr/surface.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <cmath>

#include "core/geometry/index.h"
#include "core/geometry/mesh_memory.h"
#include "core/geometry/subdivision.h"

namespace alabaster {
namespace {

namespace Bfr = OpenSubdiv::Bfr;
namespace Far = OpenSubdiv::Far;

using Surface = Bfr::Surface<float>;

// Along the limit curve of an edge of the surface's face.
uint32_t segments_of(const Surface& surface, const std::vector<float>& controls, int edge,
                     const RefinementOptions& options) {
  constexpr int kPieces = 4;  // that stand for the curve
  constexpr double kMost = 1 << kMaxSubdivisionLevel;
  double segments = 0;
  Vec3f last(0, 0, 0);
  for (int k = 0; k <= kPieces; ++k) {
    float uv[2];
    Vec3f p;
    surface.GetParameterization().GetEdgeCoord(edge, static_cast<float>(k) / kPieces, uv);
    surface.Evaluate(uv, controls.data(), 3, &p.x);
    if (k) segments += double(options.segments(last, p));
    last = p;
  }
  return segments > 1 ? static_cast<uint32_t>(std::ceil(std::min(segments, kMost))) : 1;
}

// The first face of an edge that has a limit surface measures it.
std::vector<int> owners_of_edges(const Far::TopologyLevel& base, const SurfaceFactories& factories) {
  std::vector<int> owners(at(base.GetNumEdges()), -1);
  for (int face = base.GetNumFaces() - 1; face >= 0; --face)
    if (factories.of(face).FaceHasLimitSurface(face))
      for (const int edge : base.GetFaceEdges(face)) owners[at(edge)] = face;
  return owners;
}

EdgeRates wanted_rates(const Cage& cage, const Far::TopologyRefiner& refiner, const RefinementOptions& options) {
  const Far::TopologyLevel& base = refiner.GetLevel(0);
  const SurfaceFactories factories(refiner, 0);
  const std::vector<int> owners = owners_of_edges(base, factories);
  EdgeRates rates;
  rates.edges.assign(owners.size(), 1);
  const tbb::blocked_range<int> all(0, base.GetNumFaces(), 64);
  tbb::parallel_for(all, [&](const tbb::blocked_range<int>& range) {
    Surface surface;
    std::vector<float> controls;
    options.cancel.check();
    for (int face = range.begin(); face < range.end(); ++face) {
      const auto edges = base.GetFaceEdges(face);
      const auto is_own = [&](int edge) { return owners[at(edge)] == face; };
      if (std::none_of(edges.begin(), edges.end(), is_own)) continue;
      if (!factories.of(face).InitVertexSurface(face, &surface)) continue;
      controls.resize(3 * at(surface.GetNumPatchPoints()));
      surface.PreparePatchPoints(&cage.points[0].x, 3, controls.data(), 3);
      for (int i = 0; i < edges.size(); ++i)
        if (is_own(edges[i])) rates.edges[at(edges[i])] = segments_of(surface, controls, i, options);
    }
  });
  return rates;
}

// An upper estimate.
double triangle_count(const Far::TopologyLevel& base, const EdgeRates& rates) {
  double triangles = 0;
  for (int face = 0; face < base.GetNumFaces(); ++face) {
    const auto edges = base.GetFaceEdges(face);
    double sum = 0;
    for (const int edge : edges) sum += rates.of(edge);
    triangles += sum * sum / (2 * edges.size()) + sum;
  }
  return triangles;
}

}  // namespace

// Bfr isolates extraordinary points by so many levels of subdivision and approximates what is left. Where samples lie
// closer to them than that, its default of 2 is off by a percent of a face at level 3.
SurfaceFactory::Options surface_options(int level) {
  constexpr int kLeastIsolation = 4;  // for the tangents at low levels
  SurfaceFactory::Options options;
  options.SetApproxLevelSmooth(std::max(level, kLeastIsolation));
  options.SetApproxLevelSharp(std::max(level, options.GetApproxLevelSharp()));
  return options;
}

EdgeRates adaptive_rates(const Cage& cage, const Far::TopologyRefiner& refiner, const RefinementOptions& options) {
  EdgeRates rates = wanted_rates(cage, refiner, options);
  const double triangles = triangle_count(refiner.GetLevel(0), rates);
  hold_build(options, triangles, triangles * double(bytes_per_triangle(cage)));
  return rates;
}

}  // namespace alabaster
