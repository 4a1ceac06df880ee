// Segments per edge of a refined cage. Used by the tessellator.
#pragma once

#include <opensubdiv/bfr/refinerSurfaceFactory.h>
#include <opensubdiv/far/topologyRefiner.h>

#include <algorithm>
#include <bit>
#include <mutex>
#include <shared_mutex>
#include <vector>

#include "core/geometry/mesh.h"
#include "core/geometry/two_face_vertices.h"

namespace alabaster {

using SurfaceFactory = OpenSubdiv::Bfr::RefinerSurfaceFactory<OpenSubdiv::Bfr::SurfaceFactoryCacheThreaded<
    std::shared_mutex, std::shared_lock<std::shared_mutex>, std::unique_lock<std::shared_mutex>>>;

/// For samples as close to each other as those of a level of uniform refinement.
SurfaceFactory::Options surface_options(int level);

/// The surfaces of a cage's faces. Patches are shared through a cache but for those that its key does not tell apart.
class SurfaceFactories {
 public:
  SurfaceFactories(const OpenSubdiv::Far::TopologyRefiner& refiner, int level)
      : base_(refiner.GetLevel(0)),
        cached_(refiner, surface_options(level)),
        uncached_(refiner, surface_options(level).EnableCaching(false)) {}
  const SurfaceFactory& of(int face) const { return has_two_face_vertex(base_, face) ? uncached_ : cached_; }

 private:
  const OpenSubdiv::Far::TopologyLevel& base_;
  SurfaceFactory cached_, uncached_;
};

/// Faces on both sides of an edge have the same points there, so that no crack opens.
struct EdgeRates {
  uint32_t uniform = 0;         // of all regular edges; 0: `edges` has them
  std::vector<uint32_t> edges;  // by the cage's edges, at least 1 each
  uint32_t of(int edge) const { return uniform ? uniform : edges[static_cast<size_t>(edge)]; }
  /// The level of uniform refinement that has as many segments as the longest edge, rounded up.
  int level() const {
    const uint32_t most = uniform ? uniform : edges.empty() ? 1 : *std::max_element(edges.begin(), edges.end());
    return static_cast<int>(std::bit_width(most - 1));
  }
};

/// As many as options.segments asks for; options.memory then holds the mesh (MemoryRefused). The limit surface is
/// measured at five points of each edge.
EdgeRates adaptive_rates(const Cage& cage, const OpenSubdiv::Far::TopologyRefiner& refiner,
                         const RefinementOptions& options);

}  // namespace alabaster
