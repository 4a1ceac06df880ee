// The BVHs of a mesh whose points a host edits, one edit after the other.
#pragma once

#include <memory>

#include "core/diagnostics/cancel.h"
#include "core/geometry/embree_scene.h"

namespace alabaster {

/// Makes each BVH from one that nobody holds any more, where the triangles are the same: it is fitted to the new points
/// in a tenth of the time that a build takes. The BVH that is being traced is never touched, so there are two of a mesh
/// that is edited. One thread at a time; the BVHs may be released on any.
class EditedObject {
 public:
  /// Measured (testenv/benchmark/results/refit_wear.md): up to here rays lose about a tenth at most.
  static constexpr double kWorn = 1.1;
  /// `worn`: how many times its cost (TriangleGroups) a hierarchy that is kept may have.
  explicit EditedObject(double worn = kWorn);
  ~EditedObject();
  EditedObject(const EditedObject&) = delete;
  EditedObject& operator=(const EditedObject&) = delete;

  /// As build_object_scene(), but throws BuildCancelled. Where the triangles are not those of the mesh before, or have
  /// moved so far that rays would be slow, it is built.
  std::shared_ptr<const ObjectScene> build(const std::shared_ptr<TraceDevice>& device, const Mesh& mesh,
                                           const CancelToken& cancel = {});
  /// Frees the BVH that nobody holds, and those to come: no other edit is expected.
  void rest();

 private:
  struct Spares;
  const double worn_;
  std::shared_ptr<Spares> spares_;
};

}  // namespace alabaster
