// Sets of images (UDIM) that lack one where a mesh needs it.
#pragma once

#include <set>
#include <string>
#include <tuple>
#include <vector>

#include "core/scene/scene.h"

namespace alabaster {

/// Reports, once for all instances of a mesh with a material, the texture coordinates for which a set has no image.
class MissingTiles {
 public:
  MissingTiles(const DiagnosticSink& sink, std::vector<std::string>* faults) : sink_(sink), faults_(faults) {}

  void find(const InstanceDescription& d, const Instance& instance);

 private:
  void find(const InstanceDescription& d, const Instance& instance, const DisneyMaterial* material,
            const TextureLookup& lookup);

  const DiagnosticSink& sink_;
  std::vector<std::string>* faults_;
  /// Instances share these.
  std::set<std::tuple<const MeshPrototype*, const TriangleSlots*, const DisneyMaterial*>> seen_;
};

}  // namespace alabaster
