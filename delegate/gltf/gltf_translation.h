// A document's nodes as prims: all at once, and then those that its animation moves or deforms, once for each pose.
#pragma once

#include "delegate/gltf/gltf_mesh.h"
#include "delegate/gltf/gltf_nodes.h"

namespace alabaster::hd::gltf {

/// The name of a prim, "3_name" or "3": unique within its array and without '/', blanks and control characters.
std::string prim_name(size_t index, const std::string& name);
/// "name" of it, or "3".
std::string artist_name(size_t index, const std::string& name);
/// The path below which the prims of a document lie.
Path root_of(const Document& document);

/// One thread. The document must outlive it. Translation reads the document's nodes as they are at that time.
class SceneTranslator {
 public:
  SceneTranslator(const Document& document, int refine_level);

  /// The materials, and all prims that the animation neither moves nor deforms.
  void add_still_prims(host::SceneEdits* edits, Report& report);
  /// The other prims, in the pose that the document's nodes have. Shapes of the call before are not translated again.
  void add_moving_prims(host::SceneEdits* edits, Report& report);

  /// True if the animation deforms a mesh, so that add_moving_prims() reads accessors.
  bool deforms() const;

 private:
  using Shape = std::shared_ptr<const TranslatedMesh>;  // not placed

  struct KeptShape {
    Shape shape;
    size_t call = 0;  // the last of add_moving_prims() that used it
  };

  // The nodes that use a mesh with a skin. Those whose morph weights are equal share one shape.
  struct MeshUsers {
    size_t mesh = 0;
    int skin = -1;                            // -1: none
    std::vector<size_t> nodes;                // places in tree_
    bool moves = false, deforms = false;      // by the animation
    std::map<std::string, KeptShape> shapes;  // by weights and joint matrices, of what moves
  };

  // A mesh in one shape, and where it is placed.
  struct MeshUse {
    std::vector<size_t> nodes;         // that use it
    std::vector<Matrix4d> placements;  // of all their instances
  };

  void find_users();
  void find_what_moves();
  void add_users(MeshUsers& users, host::SceneEdits* edits, Report& report);
  void add_mesh(const MeshUsers& users, const MeshUse& use, const TranslatedMesh& shape, host::SceneEdits* edits) const;
  void add_views(bool moving, host::SceneEdits* edits) const;
  Shape shape_of(MeshUsers& users, const std::vector<double>& weights, Report& report);
  Shape translate(size_t mesh, const PrimitiveShape& shape, const std::pair<size_t, std::string>& key, Report& report);
  std::vector<Matrix4d> joints_of(const MeshUsers& users) const;
  const std::vector<Matrix4d>& instances_of(size_t node);
  Path child(const char* folder, size_t node) const;

  const Document& document_;
  const tinygltf::Model& model_;
  const int refine_level_;
  const Path root_;
  NodeTree tree_;                      // of the scene
  std::optional<NodeTree> all_nodes_;  // of the document, for joints; none: there is no skin
  std::vector<size_t> places_;         // in all_nodes_, by node
  std::vector<Path> material_paths_;
  std::map<std::pair<int, int>, MeshUsers> users_;     // by mesh and skin
  std::map<size_t, std::vector<Matrix4d>> instances_;  // by node, relative to it
  size_t calls_ = 0;                                   // of add_moving_prims() so far
  // During a call: the shapes of meshes, which those that are alike share.
  std::map<std::pair<size_t, std::string>, Shape> shared_;
};

/// EXT_lights_image_based: a dome light with the largest of the light's cube maps as its image, resampled to latitude
/// and longitude and encoded as EXR. Its colours are radiance. The smaller maps and the irradiance coefficients, which
/// an engine without shadow rays needs, are not read. A face that cannot be used leaves an image that is not there, so
/// that the renderer refuses it as it refuses every missing image. `document.image_light` has a value. Throws
/// MemoryRefused.
host::LightDescription translate_image_light(Document* document, Report& report);

}  // namespace alabaster::hd::gltf
