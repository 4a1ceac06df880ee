// Files of models, each kind with a reader of its own. A source opens one file and says its prims as edits, at one time
// after another. What a scene does with them is done outside of readers, once: roots, transforms and their motion,
// poses over the shutter (description/model.h).
#pragma once

#include <array>

#include "delegate/host/scene_fields.h"

namespace alabaster::hd::host {

/// What a reader says of prims. It takes effect in the order of the members.
struct SceneEdits {
  Prims prims;                        // made, or set in the place of what has their paths
  std::map<Path, Fields> changes;     // of prims that were set before; other fields stay
  std::vector<Path> removed;          // of the prims that were set before
  std::map<Path, std::string> names;  // the artist's, of `prims` whose path does not end with it

  void set(const Path& path, PrimDescription prim, std::string name = {}) {
    prims.insert_or_assign(path, std::move(prim));
    if (!name.empty()) names.insert_or_assign(path, std::move(name));
  }
};

/// Returns the fault of a change, or "": after one the scene is as it was. A change of a prim that is not there is
/// none.
[[nodiscard]] ALABASTER_API std::string ApplyEdits(SceneEdits edits, RetainedSceneDelegate* scene);

/// Of stages of OpenUSD alone.
struct StageOptions {
  std::string session_layer;   // a file
  std::string settings, pass;  // paths of prims; empty: the stage's own choice, and none
  std::string camera;          // a path or a name: whose shutter and film count; empty: that of the settings
  std::vector<std::string> mask, purposes;                 // paths of prims to read; empty: all, and default and render
  std::vector<std::string> search_paths, allowed_folders;  // of the default resolver; that may be read, too
  std::optional<std::array<double, 2>> shutter = {};  // in time codes relative to the pose, in place of the camera's
  std::optional<bool> next_frame =
      {};               // what moves has a sample of the next time code, too; empty: where a variable is AOV motion
  double seconds = 30;  // CPU time of a request to the reader
  /// usdrecord's rules: settings count that the stage names, and a picture is this wide and as high as the camera's
  /// film asks. Empty: the only settings there are count, too.
  std::optional<int> recorded_width = {};
  bool hides_domes = false;      // from the camera
  bool at_default_time = false;  // poses without a time are of the stage's default values
};

struct SourceOptions {
  bool allow_outside = false;  // files that it names may lie outside of its folder, links followed
  std::string within = {};     // as of an AssetPath: where the file and its folder must lie
  size_t memory_limit = 0;     // bytes that reading may take; 0: three quarters of what the process may use
  // Each of these is a name, or an index as a whole number; empty: the file's own choice.
  std::string scene = {}, animation = {}, variant = {};
  bool is_timed = false;    // poses have a time: without it an animation is used only if it is named
  int refine_level = 2;     // of control meshes in glTF (FB_ngon_encoding), and of a stage's subdivision surfaces
  bool keep_going = false;  // what the file names and lacks is told in SceneFacts::faults, and is no fault of Open
  StageOptions stage = {};
};

struct SceneAnimation {
  std::string name;
  double seconds = 0;  // the time of the last key
};

/// Facts of a scene beside its prims. The defaults are those of glTF.
struct SceneInfo {
  Path settings = {};           // the render settings that a render takes; empty: the first ones
  AssetPath color_config = {};  // of OpenColorIO; empty: none
  Token up = "Y";               // the axis that points up, or "Z"
  double metersPerUnit = 1;
  double timeCodesPerSecond = 0;                    // 0: times are seconds
  std::optional<std::array<double, 2>> range = {};  // its first and last time
  std::map<Path, std::string> names = {};           // as in SceneEdits
  bool operator==(const SceneInfo&) const = default;
  float units_per_millimetre() const { return static_cast<float>(0.001 / metersPerUnit); }
};

struct SceneFacts : SceneInfo {
  std::vector<std::string> files = {};                  // that were read, the scene's own first
  Path root = {};                                       // below which all its prims lie; empty: anywhere
  std::vector<std::string> scenes = {}, variants = {};  // names, empty where the file gives none
  std::vector<SceneAnimation> animations = {};
  bool is_complete = false;                           // it is drawn as it is: no light is added to it
  bool varies = false;                                // poses at other times differ
  std::vector<std::string> unread = {};               // kinds of what it has and the reader leaves out, as warned of
  std::vector<std::string> faults = {};               // what it lacks, by SourceOptions::keep_going
  std::map<std::string, std::string> libraries = {};  // versions of those that read it, and are not the program's own
  size_t memory_bytes = 0;  // of what was read for the first pose, as long as its prims are held
};

/// `choice`: the file lacks the scene, animation or variant that the options name.
enum class SourceFault { none, input, choice, out_of_memory };

/// One thread. Calls never throw; they report what is wrong with the file, the place in it and a remedy.
class ALABASTER_API SceneSource {
 public:
  virtual ~SceneSource() = default;
  /// Reads and checks what poses need. Once, before all else.
  virtual SourceFault Open(const std::string& file, const SourceOptions& options, const DiagnosticSink& sink) = 0;
  /// Once it is open; after the first pose with its memory.
  virtual const SceneFacts& Facts() const = 0;
  /// Adds what the scene at `time` has over the pose before, or over an empty scene. Prims that did not change may be
  /// set again. Without a time it is the scene as it is authored. The unit of time is the second, or the time code of a
  /// scene that has them.
  virtual SourceFault Pose(std::optional<double> time, const DiagnosticSink& sink, SceneEdits* edits) = 0;
};

}  // namespace alabaster::hd::host
