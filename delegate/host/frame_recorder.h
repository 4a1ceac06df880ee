// Renders one RenderSettings prim to its products and waits for it, for headless hosts.
#pragma once

#include <atomic>

#include "delegate/host/product_writer.h"
#include "delegate/host/retained_scene_delegate.h"

namespace alabaster::hd::host {

/// `interrupted`: cancelled, or stopped by another thread, which alone may restart the delegate.
/// `degraded`: rendered and written by RecordOptions::keep_going, although the scene has faults.
/// `render_failed`: also where memory was refused, to whatever it was.
enum class RecordStatus { done, input_failed, render_failed, output_failed, interrupted, degraded };

/// How a recording ended. Where it failed, `cause` is the code of the report about it ("record.scene"), and `text` says
/// the same to people.
struct RecordEnd {
  RecordStatus status = RecordStatus::done;
  std::string cause, text;
};

struct FrameRequest;
/// What RecordFrame will render and write, checked before anything is rendered.
struct FramePlan : RecordEnd {                  // `done`: nothing is known that would fail
  ProductStatus product = ProductStatus::done;  // the fault of a file, if that is why it cannot be rendered
  std::shared_ptr<const ColorConfig> colors;    // held, because its files may vanish while the picture is made
  std::shared_ptr<const std::vector<FrameRequest>> pictures;  // null: there is no plan
};

struct RecordProgress {
  double fraction = 0;
  double seconds = 0;  // since rendering began
  double rays_per_second = 0;
  double seconds_left = 0;                       // of rendering this picture; estimate; < 0: unknown yet
  double denoised = -1;                          // share of the denoising that is done; < 0: not begun
  uint64_t samples_done = 0, samples_total = 0;  // per pixel
};

struct RecordOptions {
  OutputColors colors;
  std::vector<RenderProduct> products;  // in the place of those of the settings; empty: those
  /// Renders a scene that has faults (see RenderDelegate::GetRenderStats) without what they leave out, and marks its
  /// files with the attribute "alabaster/sceneFaults". Else such a scene is not rendered.
  bool keep_going = false;
  std::vector<std::string> faults;  // that reading the scene left out, beside those that the delegate tells
  Dictionary metadata;              // added to that of the files
  std::vector<std::string> aovs;    // that `picture` gets besides those of the products
  /// Of checkpoints that are shown: AOV lightGroup:* stands for these. Empty: for those of the scene.
  std::vector<std::string> light_groups;
  /// A file that the state of the render is written to every so many seconds, when it is cancelled and at its end; each
  /// time, the file holds either the last state or the one before. Empty: none.
  std::string checkpoint;
  double checkpoint_seconds = 60;
  std::vector<RenderProduct> of_frame;  // of the frame that a part without products belongs to, told by its checkpoint
  /// Go on from that file. The picture is, to the bit, the one that a render without interruption gives.
  bool resume = false;
  /// Polled at least every 20 ms. Once it is set the render ends, and the samples so far are written, marked
  /// incomplete.
  const std::atomic<bool>* cancel = nullptr;
  /// The products are written every so many seconds, too, marked incomplete. Once they cannot be, a warning tells, and
  /// the render goes on without. 0: at the end alone.
  double live_seconds = 0;
  bool drops_incomplete = false;  // the products of a render that is cancelled are not written
  FramePlan plan;  // PlanFrame's of the same settings and options; without pictures RecordFrame makes its own
  // Called from the calling thread. They may edit the scene, and even depopulate it: the recording owns its buffers.
  std::function<void(const RecordProgress&)> progress;  // about ten times a second
  std::function<void()> writing;                        // once a picture, when its files are to be written
  std::function<void(const ProductImage&)>
      picture;  // called once with each picture; its pixels are valid during the call
  DiagnosticSink diagnostics;
};

/// Width and height of a picture that a file holds whole; of an EXR those of its display window.
ALABASTER_API std::optional<Vec2i> PictureSize(const std::string& file);

struct RecordResult : RecordEnd {
  /// True if texels of a degraded picture were lost, or memory ran out in a later Sync.
  bool out_of_memory = false;
  Dictionary stats;  // RenderDelegate::GetRenderStats at the end, plus phase.<sync|render|write>.wall / .cpu seconds
  std::vector<std::string> written;  // files
};

/// Refuses, with a report, every frame that is known to fail: a bad size, crop or camera transform, an AOV that
/// `delegate` lacks, a product that cannot be written, a checkpoint of several pictures. A camera that does not exist
/// is the pass's to refuse.
ALABASTER_API FramePlan PlanFrame(const RetainedSceneDelegate& scene, const Path& settings,
                                  const RenderDelegate& delegate, const RecordOptions& options);

/// `settings`: path of a RenderSettings prim that `scene` knows. Plans the frame, if RecordOptions::plan does not.
/// Makes a render buffer for every AOV that the products name (color if there is no product), syncs, renders to
/// convergence and writes the products: a picture for each camera and size that they have, one after the other, and
/// `stats` of the last. Throws nothing: an exception of a callback of `options` fails the recording. Where the denoiser
/// fails, files show color in the place of AOV denoised, and the status is output_failed; it also is where the last
/// checkpoint could not be written. However it ends, its render buffers are destroyed and the delegate's settings are
/// as before. A delegate that is stopped renders nothing and stays stopped.
ALABASTER_API RecordResult RecordFrame(RenderIndex* index, RetainedSceneDelegate* scene, const Path& settings,
                                       const RecordOptions& options);

/// The frame that a checkpoint of a recording is of, without the limits of memory and threads. Its products tell how
/// its files show the frame.
struct FrameNote {
  RenderSettingsDescription frame;
  bool degraded = false;                   // rendered without all of its scene
  Dictionary metadata;                     // of its files, that a merge does not know: the matrices of its camera
  std::string color_config, color_digest;  // its origin, and ColorInputs::all()
};
/// `text`: the note of a checkpoint, as command describeCheckpoint has it. Empty if RecordFrame did not write it.
ALABASTER_API std::optional<FrameNote> ReadFrameNote(const std::string& text);

/// A message: there is no AOV of that name, and which one may be meant.
ALABASTER_API std::string NoSuchAov(const std::string& name);

}  // namespace alabaster::hd::host
