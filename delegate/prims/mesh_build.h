// From a mesh as its prim has pulled it to what is traced, in Sync or at commit.
#pragma once

#include "core/camera/camera.h"
#include "delegate/prims/render_param.h"

namespace alabaster::hd::prims {

struct MeshBuild {
  std::shared_ptr<const MeshPrototype> prototype;  // null: nothing to draw
  std::shared_ptr<const Deformation> deformation;  // as MeshRecord's
  std::optional<SceneFault> fault;
  bool cancelled = false;
};

/// The picture by which adaptive refinement measures.
struct Dicing {
  float edge_length = 0;  // pixels; 0: meshes are refined by their refineLevel
  CameraParameters camera;
  int width = 0, height = 0;
  bool operator==(const Dicing&) const = default;
};

/// Beside the mesh itself, all that decides what it becomes.
struct MeshRequest {
  Displacements displacements;
  Dicing dicing;
  std::vector<Matrix4d> placements;  // object to world of its instances; empty without dicing
  bool operator==(const MeshRequest&) const = default;
};

/// Cage, refinement, displacement, BVH. Runs in the caller's task arena; an empty `cancelled` is never asked.
MeshBuild build_prototype(const PulledMesh& mesh, const Path& id, const MeshRequest& request, SceneParam& param,
                          const std::function<bool()>& cancelled);

/// The meshes that wait for more than their own prim: their materials displace them, or the camera decides how finely
/// they are refined. They are built at commit, where all prims are known, and kept until one of these changes. One
/// thread at a time.
class DeferredMeshes {
 public:
  /// The records, with the meshes that waited; valid until the next call. A mesh that cannot be built is reported and
  /// not drawn.
  const Records& build(const Records& records, const Dicing& dicing, SceneParam& param);

 private:
  struct Held {
    std::shared_ptr<const PulledMesh> source;
    MeshRequest request;
    MeshBuild built;
    bool done = false;  // an exception may have come before it was built
  };
  void update(const Records& records, const Dicing& dicing, SceneParam& param);

  std::map<Path, Held> held_;
  Records complete_;
};

}  // namespace alabaster::hd::prims
