// Segments per edge of a refined cage. Used by the tessellator.
#pragma once

#include <opensubdiv/bfr/refinerSurfaceFactory.h>

#include <algorithm>
#include <bit>
#include <mutex>
#include <shared_mutex>
#include <vector>

#include "core/geometry/mesh.h"

namespace alabaster {

using SurfaceFactory = OpenSubdiv::Bfr::RefinerSurfaceFactory<OpenSubdiv::Bfr::SurfaceFactoryCacheThreaded<
    std::shared_mutex, std::shared_lock<std::shared_mutex>, std::unique_lock<std::shared_mutex>>>;

/// For samples as close to each other as those of a level of uniform refinement.
SurfaceFactory::Options surface_options(int level);

/// Faces on both sides of an edge have the same points there, so that no crack opens.
struct EdgeRates {
  uint32_t uniform = 0;         // of all regular edges; 0: `edges` has them
  std::vector<uint32_t> edges;  // by the cage's edges, at least 1 each
  uint32_t of(int edge) const { return uniform ? uniform : edges[static_cast<size_t>(edge)]; }
  /// The level of uniform refinement that has as many segments as the longest edge, rounded up.
  int level() const {
    const uint32_t most = uniform ? uniform : *std::max_element(edges.begin(), edges.end());
    return static_cast<int>(std::bit_width(most - 1));
  }
};

/// As many as options.segments asks for; options.memory then holds the mesh (MemoryRefused). The limit surface is
/// measured at five points of each edge.
EdgeRates adaptive_rates(const Cage& cage, const OpenSubdiv::Far::TopologyRefiner& refiner,
                         const RefinementOptions& options);

}  // namespace alabaster
