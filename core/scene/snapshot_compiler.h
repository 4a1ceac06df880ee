// Compiles snapshots of one scene as it is edited, one after the other. Parts that two of them have in common are built
// once.
#pragma once

#include "core/diagnostics/cancel.h"
#include "core/scene/scene.h"

namespace alabaster {

/// Radii (SceneSnapshot::radius) between which a scene renders right. One beyond them is a fault of the snapshot:
/// products of lengths leave the floats there, and light is lost. A large one is none where an instance smaller than
/// kSmallInHuge stands in it: then some instance alone is too large, or has a stray point.
inline constexpr float kLeastRadius = 0x1p-40f, kLargestRadius = 0x1p41f;
inline constexpr double kSmallInHuge = 0x1p20;

/// One thread at a time. A snapshot is a function of its description alone: it does not depend on those before it.
class SnapshotCompiler {
 public:
  SnapshotCompiler(std::shared_ptr<TraceDevice> device, DiagnosticSink sink)
      : device_(std::move(device)), sink_(std::move(sink)) {}

  /// Shares with the last snapshot: the top level, where all shapes and places are equal; the BVHs of bodies of several
  /// members; the densities of images of lights; emissive meshes that stand where they stood; and where light falls on
  /// bodies, if shapes, places, lights and links are all equal. Reports faults of bodies, unless the last snapshot had
  /// them, too. Null when Embree refuses (reported). Where memory runs out, throws MemoryRefused, which names the prim,
  /// or std::bad_alloc. Throws BuildCancelled. After an exception the next snapshot shares as this one would have.
  std::shared_ptr<const SceneSnapshot> compile(const SceneDescription& description, uint64_t number,
                                               const CancelToken& cancel = {});
  /// Gives up the last snapshot: the next one shares nothing.
  void forget() { last_ = nullptr; }

 private:
  struct Compilation;

  std::shared_ptr<TraceDevice> device_;
  DiagnosticSink sink_;
  std::shared_ptr<const SceneSnapshot> last_;
  std::vector<LightParameters> last_lights_;
  std::vector<std::vector<uint32_t>> last_category_sets_;
  std::vector<Diagnostic> reported_;  // faults of bodies of the last snapshot
};

}  // namespace alabaster
