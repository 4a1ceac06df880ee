// Loads glTF 2.0 (.gltf, .glb): reads a document, checks all of it before using any of it, and adds it to a
// RetainedSceneDelegate.
//
// Paths begin with `root` and /gltf/<stem>, followed by /nodes/<index>_<name>/<mesh primitive index>, or for several
// primitives that are one mesh /mesh_<index of the first>, whose subsets have the paths of the primitives,
// /materials/<index>_<name>, and /cameras/<index>_<name> or /lights/<index>_<name> with the index and name of the
// camera's or light's node. A mesh used by several nodes, or by one with EXT_mesh_gpu_instancing, lies below the first
// of them, placed by that node's /instancer; nodes with a skin or with morph weights of their own have meshes of their
// own. Units are metres, as in glTF, for cameras and lights too.
#pragma once

#include <optional>

#include "delegate/host/retained_scene_delegate.h"

namespace alabaster::hd::gltf {

struct GltfOptions {
  Path root = "/";     // prims are created below it
  Matrix4d transform;  // applied after the node transforms
  size_t max_file_bytes = size_t(4) << 30;
  size_t memory_limit = 0;     // bytes that reading may take; 0: three quarters of what the process may use
  bool allow_outside = false;  // buffers and images may lie outside the folder of the file, links followed
  std::string within;          // as of an AssetPath: where the file and its folder must lie
  int refine_level = 2;        // of meshes with FB_ngon_encoding (cages); other meshes are drawn as they are
  // Each of these is a name, or an index as a whole number.
  std::string scene;      // empty: the file's default, else the first
  std::string animation;  // empty: the first
  std::string variant;    // of KHR_materials_variants; empty: the materials that primitives name themselves
  /// The pose of the animation in seconds. Empty: the pose in which the nodes are authored; but the animation at time 0
  /// if one is named. After the last key it is held.
  std::optional<double> time;
  /// Seconds, relative to `time`. Over an interval with a length, what the animation moves or deforms gets time
  /// samples, five of them, in frames. Things that stand still in it, and lights, get none.
  double shutter_open = 0, shutter_close = 0;
  double frames_per_second = 24;
};

struct GltfAnimation {
  std::string name;
  double seconds = 0;  // the time of the last key
};

/// The cause of a failed load. `choice`: the document lacks the scene, animation or variant that the options name.
enum class GltfFault { none, document, choice, out_of_memory };

struct GltfSummary {
  bool ok = false;  // false: nothing was added, for the reason reported
  GltfFault fault = GltfFault::none;
  std::vector<Path> meshes, materials, cameras, lights;
  std::vector<std::string> extensionsUsed, extensionsRequired, extensionsIgnored;
  std::vector<std::string> files;             // that were read: the document and its buffers
  size_t memory_bytes = 0;                    // of the geometry that was added
  std::vector<std::string> scenes, variants;  // names, empty where the file gives none
  std::vector<GltfAnimation> animations;
};

/// Adds the document's scene to `scene`. Never throws. Errors name the file, the element ("buffers[0].uri") and a
/// remedy. A harmless fault is a warning, and everything else is loaded.
ALABASTER_API GltfSummary LoadGltf(const std::string& file, const GltfOptions& options,
                                   host::RetainedSceneDelegate* scene, const DiagnosticSink& sink);

/// Makes a control mesh of the triangles of a loaded mesh, whose vertices glTF splits at seams: all that lie at one
/// position, to the bit, become one point. Other primvars become face-varying, and tangents go. Triangles with fewer
/// than three points are left out; returns how many.
ALABASTER_API size_t WeldVertices(host::MeshDescription* mesh);

struct GltfPrims {
  host::Prims prims;
  std::vector<Path> removed;  // of the pose before, which this pose lacks
};

/// A document that is read once and posed at any number of times. It keeps what poses need: the nodes, the animation,
/// and the buffers if the animation deforms a mesh; nothing without an animation. One thread.
class ALABASTER_API GltfSource {
 public:
  GltfSource();
  ~GltfSource();
  GltfSource(GltfSource&&) noexcept;
  GltfSource& operator=(GltfSource&&) noexcept;

  /// LoadGltf, with the document kept. A pose needs an animation: give GltfOptions::time or name one.
  GltfSummary Load(const std::string& file, const GltfOptions& options, host::RetainedSceneDelegate* scene,
                   const DiagnosticSink& sink);
  /// All prims that the animation moves or deforms, at `time` in place of GltfOptions::time and with samples over the
  /// shutter about it: with those that stand still they are what LoadGltf adds for this time. They may be equal to
  /// those of the pose before. Warnings are not given again. Empty after a reported error, with its cause.
  std::optional<GltfPrims> Pose(double time, const DiagnosticSink& sink, GltfFault* fault);

 private:
  struct Open;
  std::unique_ptr<Open> open_;  // null: nothing moves
};

}  // namespace alabaster::hd::gltf
