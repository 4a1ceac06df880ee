// Translates the committed records into the scene that core renders. Paths are resolved here and nowhere else: to
// materials and instancers that exist, or to their fallbacks.
#pragma once

#include <array>

#include "core/scene/scene.h"
#include "delegate/prims/diagnostics.h"
#include "delegate/prims/records.h"
#include "delegate/prims/scene_param.h"
#include "delegate/support/selection.h"

namespace alabaster::hd::prims {

/// The shapes of meshes that deform, by prim: in the shutter, and at the ends of the time that AOV motion shows.
struct DeformedMeshes {
  std::map<Path, std::shared_ptr<const MeshPrototype>> traced;
  std::map<Path, std::shared_ptr<const MeshEnds>> ends;
};

/// The shutter of the scene, from the first camera's that opens to the last one's that closes; whichever camera a pass
/// takes later. The times of a snapshot count from 0 to 1 through it. Empty: there is no camera.
std::optional<Shutter> shutter_of(const Records& records);
/// The time that AOV motion shows, beside the camera's shutter; empty: the AOV is not asked for, or shows that.
using MotionTime = std::optional<Shutter>;
/// The camera with its poses in its own shutter, which lies in that of the scene.
CameraParameters posed_camera(const CameraRecord& record, const Shutter& of_scene, const MotionTime& motion);

/// A frame has mattes of so many instances at most: the manifests of more would be too large for compositors.
inline constexpr uint32_t kMostInstanceMattes = 100'000;

struct Translation {
  SceneDescription scene;
  Shutter shutter;
  MotionTime motion;
  std::vector<Path> material_paths;                   // of all instances' materials, in order; empty path: default
  std::vector<std::vector<Path>> array_materials;     // the same of each array's look
  std::vector<Path> light_paths;                      // parallel to scene.lights
  std::vector<std::pair<Path, Token>> display_names;  // of meshes and materials that have one
  std::vector<Token> categories;                      // that lights name: the first is 1 in scene.lights
  SceneFaults faults;                                 // meshes of too many places (reported)
  std::shared_ptr<MemoryReservation> memory;          // of the instances
};

class BuiltMeshes;

/// A fault is reported once instead of at every commit, and again when it returns.
class SceneTranslator {
 public:
  explicit SceneTranslator(alabaster::DiagnosticSink sink);
  struct Parts {
    const Records& records;
    const support::Selection& selection;
    const Shutter& shutter;
    const MotionTime& motion;
    const BuiltMeshes& meshes;
    const DeformedMeshes& deformed;  // traced in the place of those of `meshes` that deform
    const std::shared_ptr<MemoryBudget>& memory;
    const std::vector<Token>& shown_primvars;  // by AOVs; sorted
    const std::list<Edit>& unread;             // materials that wait for a mesh that uses them are among these
  };
  /// Throws std::bad_alloc.
  Translation translate(const Parts& parts);

 private:
  struct Run;
  void warn(const char* code, const Path& where, const std::string& text);
  void fail(const char* code, const Path& where, const std::string& text);
  const OpenEdges::Kind& reversed_edges_of(const std::shared_ptr<const MeshPrototype>& mesh);

  alabaster::DiagnosticSink sink_;
  // Without displayColor, with it, with displayOpacity, with both.
  std::array<std::shared_ptr<const DisneyMaterial>, 4> default_materials_;
  std::vector<alabaster::Diagnostic> found_;
  KnownFaults faults_;
  std::map<std::weak_ptr<const MeshPrototype>, OpenEdges::Kind, std::owner_less<>> reversed_edges_;
};

/// Stable text of a translated scene and its cameras: the answer to command "dumpScene".
std::string dump_scene(const Translation& translation, const Records& cameras);
/// The features that a snapshot requires, each with a prim that is the reason: the answer to command "requirements".
std::string describe_requirements(const SceneSnapshot& snapshot, const Translation& translation);

}  // namespace alabaster::hd::prims
