// A model of a scene: a file, opened by the reader of its kind, and what is done to its prims, whatever their reader:
// poses over the shutter, a root, a place and a motion. Internal to this room.
#pragma once

#include <set>

#include "core/memory/memory_budget.h"
#include "delegate/description/render_description.h"

namespace alabaster::hd::description {

/// The reader of a file by its extension; null if there is none.
std::unique_ptr<host::SceneSource> source_of(const std::string& file);

/// Where a description puts a model or the camera.
struct Placement {
  std::optional<Matrix4d> transform;  // of a motion that at time 0; empty: nothing is said
  TimeSamples<Matrix4d> motion;
  double target_distance = 0;  // from the eye to the target of lookAt; 0: it has none
};

/// Over what a model is sampled, in frames relative to the one that is drawn; nothing unless it is open for some time.
struct FrameShutter {
  double open = 0, close = 0;
};

class ALABASTER_API OpenModel {
 public:
  std::unique_ptr<host::SceneSource> source;  // open, before the first pose
  Placement placement;
  FrameShutter shutter;
  bool next_frame = false;  // what moves has a sample of the next frame, too, for AOV motion
  std::string root = {};    // before all paths: "/copy2"; empty: nothing
  std::optional<double> frames_per_second = {};
  std::optional<double> own_time = {};  // of the description, to which that of the options is added
  std::shared_ptr<MemoryBudget> memory = {};

  /// The time that options ask for, in the unit of the source. Empty: that in which it is authored.
  std::optional<double> time_of(const LoadOptions& options) const;
  /// What the model has at `time` over the pose that was shown before, as its file says it: prims that are set, and
  /// prims that are removed. What moves or deforms gets samples over the shutter: five, and where it turns by more than
  /// 5 degrees from one to the next, as many as that needs, up to 129, of points 33 (the turns of the five are seen up
  /// to half a turn from one to the next). Lights get none. With next_frame there are samples of this frame and the
  /// next one, too. Throws MemoryRefused.
  host::SourceFault pose(std::optional<double> at, const DiagnosticSink& sink, host::SceneEdits* edits);
  /// Gives edits the model's root and place.
  void place(host::SceneEdits* edits) const;
  /// Makes the edits. A change that is refused is reported, and none is made.
  host::SourceFault apply(host::SceneEdits edits, const DiagnosticSink& sink, host::RetainedSceneDelegate* scene) const;
  /// The last pose is in the scene. What is not, because something else failed, is said again with the next one.
  void shown() { due_.clear(); }

 private:
  struct Sampler;
  double frames_per_unit() const;
  host::SourceFault ask(std::optional<double> at, const DiagnosticSink& sink, std::set<Path>* touched);

  // Where poses at other times differ:
  host::RetainedSceneDelegate now_ = {};                             // as the file says it, in the last pose
  std::map<Path, std::optional<host::PrimDescription>> drawn_ = {};  // what is set or removed, as it is drawn
  std::set<Path> stirred_ = {};                                      // by the last shutter, so that they may differ
  std::set<Path> due_ = {};                                          // posed, and not shown yet: a pose may fail
  MemoryReservation held_ = {};                                      // of samples
};

}  // namespace alabaster::hd::description
