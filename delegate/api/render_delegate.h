// The factory a host holds. Made by CreateAlabasterRenderDelegate; several may live in one process.
//
// A frame: Sync of Bprims, then Sprims (in the order of GetSupportedSprimTypes), then instancers and Rprims (parallel)
// -> CommitResources -> RenderPass::Execute. None of them builds: a thread of the delegate refines meshes, resolves
// paths and compiles an immutable numbered snapshot, which passes then draw. Until then the old one goes on
// being rendered, and no pass reports convergence. A newer edit may cancel the build (delegate/manual/embedding.md,
// "Edits during a render"). Threads: one host thread at a time, except Stop, HoldStopped, Pause, Resume,
// GetRenderStats, RenderPass::GetState and RenderBuffer::Map/Resolve/Unmap, which any thread may call at any time. No
// call throws.
#pragma once

#include "delegate/api/prims.h"

namespace alabaster::hd {

/// The effect of a new value of a setting on a frame that is being rendered or is done. A value that is set again
/// unchanged has none.
enum class SettingEffect {
  live,       // none: it counts for what is loaded from then on
  continues,  // the render keeps its samples if they are also the first samples of the new frame
  restarts,   // the frame is rendered again from its first sample
  resyncs,    // meshes are built again, and then the frame is rendered again
};

struct RenderSettingDescriptor {
  std::string name;  // shown to people
  Token key;
  Value defaultValue;
  Value minimum, maximum;  // of the default's type; empty: unbounded
  SettingEffect effect = SettingEffect::restarts;
  std::vector<std::string> choices;  // of a string setting
  std::string documentation;
};

enum class CommandStatus {
  done,
  unknown,        // there is no such command
  invalid,        // an argument is missing, unknown, of another type or out of range
  failed,         // also where the delegate fails before it can tell why
  out_of_memory,  // memory ran out, or the memory limit refused it
};

/// The end of a command, and its answer.
struct CommandResult {
  CommandStatus status = CommandStatus::failed;
  std::string fault;  // why it is not done, for people
  Value value;        // the answer of a command that has one and is done

  bool ok() const { return status == CommandStatus::done; }
};

class ALABASTER_API RenderDelegate {
 public:
  virtual ~RenderDelegate();

  // Prims. Unknown types give null and the host goes on. The host destroys through the delegate, after Finalize.
  // Rprims: mesh. Sprims: camera, material, rectLight, diskLight, cylinderLight, sphereLight, distantLight, domeLight.
  // Bprims: renderSettings, renderBuffer.
  virtual const std::vector<Token>& GetSupportedRprimTypes() const = 0;
  virtual const std::vector<Token>& GetSupportedSprimTypes() const = 0;
  virtual const std::vector<Token>& GetSupportedBprimTypes() const = 0;
  virtual Rprim* CreateRprim(const Token& type, const Path& id) = 0;
  virtual Sprim* CreateSprim(const Token& type, const Path& id) = 0;
  virtual Sprim* CreateFallbackSprim(const Token& type) = 0;
  virtual Bprim* CreateBprim(const Token& type, const Path& id) = 0;
  virtual Bprim* CreateFallbackBprim(const Token& type) = 0;
  virtual Instancer* CreateInstancer(const Path& id) = 0;
  virtual void DestroyRprim(Rprim* prim) = 0;
  virtual void DestroySprim(Sprim* prim) = 0;
  virtual void DestroyBprim(Bprim* prim) = 0;
  virtual void DestroyInstancer(Instancer* instancer) = 0;

  virtual std::unique_ptr<RenderPass> CreateRenderPass() = 0;  // dies before the delegate; null: failed (reported)
  virtual RenderParam* GetRenderParam() = 0;
  /// Hands the edits to the builder, and returns at once.
  virtual void CommitResources() = 0;

  // Settings: names of schemas/render_settings.json; unknown keys are kept and ignored. The version rises only when a
  // value changes. Layers: defaults < a RenderSettings prim < SetRenderSetting (an empty value takes a key back). The
  // prim is the one that key "renderSettingsPrimPath" names, else the first by path.
  virtual void SetRenderSetting(const Token& key, const Value& value) = 0;
  /// Several, all or none. False: memory ran out (reported), all are unchanged.
  virtual bool SetRenderSettings(const Dictionary& settings) = 0;
  virtual Value GetRenderSetting(const Token& key) const = 0;
  virtual std::vector<RenderSettingDescriptor> GetRenderSettingDescriptors() const = 0;
  virtual uint32_t GetRenderSettingsVersion() const = 0;

  /// Never blocks. Keys hosts know: percentDone, fractionDone, totalClockTime, numCompletedSamples, rendererName,
  /// renderProgressAnnotation, totalMemory, peakMemory; and ours: state, sceneNumber, samplesTotal, passesDone, covered
  /// (true once its samples, if in blocks, are all over the frame), pixelsWithoutSample (of a render that a stop or the
  /// time limit has ended before each pixel had one; absent where none is), cpuSeconds, filmMemory (bytes of the
  /// accumulators), rays.camera, rays.bounce, rays.shadow, rays.walk, walk.count, walk.events, walk.exits, walk.lost,
  /// walk.lostEnergy, walk.safetyCap, walk.maxWeight, nonfiniteSamples with nonfiniteSamples.emission, .light, .lobe,
  /// .walk, .exposure and .other (where a sample ceased to be finite), suspectSample ("x,y,sample" for tracePixel: the
  /// sample whose failed check ended the render, which may be another one in the next render where several fail; else
  /// the first that was not finite, by sample number, row and column, whatever the threads), rejectedRays, error (of a
  /// failed render), refused (true if its camera, framing or size cannot be rendered), error.relativeRmse with
  /// error.low and error.high (the noise that the frame estimates in itself and its 95 % interval; never of AOV
  /// denoised) after error.samples per pixel: when the render is over, where the noise decides about it (targetError,
  /// adaptive), and after command "measureNoise". Where error.isKnown is false, too few samples found light, and the
  /// error is at least error.low. Once a render is over: endedBy (samples, targetError or timeLimit); with targetError
  /// target.error and target.missed, and where it is or may be missed target.message (a sentence) with target.samples
  /// (per pixel), target.seconds and target.cpuSeconds that it would take, and error.groupsOverFrame (the error of
  /// groups of pixels over the frame's). Where AOV denoised is drawn, denoise.fraction, denoise.seconds and
  /// denoise.cpuSeconds (of the whole process meanwhile) once the denoiser has begun, denoiser (its name and version)
  /// once the AOV shows its picture, or denoise.error (why it does not); of Sync, summed up:
  /// - sync.refineWallSeconds, sync.bvhWallSeconds: wall time during which at least one mesh was being refined, or its
  ///   BVH built (not a sum over meshes: those that are synced in parallel count once);
  /// - sync.refineSeconds, sync.bvhSeconds: CPU time of the whole process during those times, shared between the two in
  ///   proportion to the meshes in each while both go on. A render that continues meanwhile is in it;
  /// - sync.commitSeconds: wall time of CommitResources, and of resolving paths and compiling snapshots after it.
  /// Numbers of meshes, and faults of the scene, are those of the last snapshot: command "waitForScene" waits for it.
  /// Where the scene could not be read, built or lit as asked (each fault has been reported as an error, and the frame
  /// is drawn without): scene.faultCount, scene.faults (text, a line for each, at most a hundred) and
  /// scene.outOfMemory (true: memory ran out, and the first line says for what; a scene that it does not hold is not
  /// drawn). All three are absent where the scene is whole. A fault that an edit mends is gone.
  virtual Dictionary GetRenderStats() const = 0;

  // Background control: legal at any time, also before the first render.
  virtual void Pause() = 0;
  virtual void Resume() = 0;
  virtual bool IsPaused() const = 0;
  virtual void Stop() = 0;             // blocks until no worker runs; latches until Restart
  virtual void Restart() = 0;          // undoes Stop: the next Execute of a pass renders again; without one, nothing
  virtual bool IsStopped() const = 0;  // by Stop or HoldStopped
  /// Stops like Stop until the result is destroyed, whatever Stop and Restart do meanwhile: for code that stops a
  /// delegate which is not its own, and must undo no Stop but its own. Null after a report if memory runs out.
  virtual std::shared_ptr<const void> HoldStopped() = 0;

  virtual AovDescriptor GetDefaultAovDescriptor(const Token& aov) const = 0;  // format invalid: unsupported

  /// Runs a command by name. An unknown command or argument is an error, which names the nearest known one. The first
  /// four wait until the scene that was committed last has been built, unless the delegate is stopped. Values
  /// answered:
  /// - "dumpScene": string, stable text of the translated scene.
  /// - "requirements": string, the features that the committed snapshot requires, and why.
  /// - "names": a dictionary of dictionaries, of the scene or the checkpoints that are shown: "primId" and "materialId"
  ///   {number: name}; "cryptoObject", "cryptoMaterial" and "cryptoAsset" {name: its hash, 8 hexadecimal digits}. The
  ///   name is GetDisplayName's where it is unique, else the path; meshes may name their mattes (schemas/mesh.json).
  /// - "waitForScene" {optionally seconds, the longest to wait}: bool, the snapshot is there.
  /// - "tracePixel" {x, y, and optionally sample}: string, the path of a sample of the frame that Execute drew last,
  ///   vertex by vertex, traced with that frame's random numbers. Without a sample: the colour of each of the pixel's
  ///   samples, and the path of the first that fails a check, else of the first that is not finite, else of the
  ///   brightest. x counts to the right and y down from the upper left corner of the display window. Fails before the
  ///   first frame; pixels outside of the data window and numbers that are not whole are invalid.
  /// - "describeCheckpoint" {file, and optionally measure: bool}: a dictionary {firstSample, samples, complete: bool,
  ///   note, lightGroups: Array<string>}. `measure` reads the pixels, too: meanSamples, which they have of these so
  ///   far, and, where it is known, error.relativeRmse of their picture.
  /// The others answer no value:
  /// - "reloadResource" {file}: an image that materials or lights name has been edited on disk, or one of a set that
  ///   they name by "<UDIM>", or a missing one has appeared. The builder reads it again for those that use it, and
  ///   the picture follows as after an edit.
  /// - "flush": the same for all images.
  /// - "measureNoise": GetRenderStats has a newer error.* after a pass. That takes a twentieth of one thread at most.
  /// - "writeCheckpoint" {file, and optionally note: string, up to 64 KiB}: writes the state of the frame that Execute
  ///   drew last, while it is rendered or after, but not once a stop has ended a render with targetError. The file is
  ///   replaced whole.
  /// - "resumeCheckpoint" {file}: the next render that Execute starts continues it, to the very bits of a render
  ///   without interruption. A render of another scene, camera, framing, setting or version than the file's fails and
  ///   says what differs; setting samples may be larger. Without a file: takes that back.
  /// - "showCheckpoints" {files: Array<string>}: Execute shows the sum of these, which must be parts of one frame
  ///   (setting firstSample) that begin with sample 0 and leave out none, instead of the scene; bound AOVs must be
  ///   among theirs, and the framing must be theirs. Without files: the scene again.
  virtual CommandResult InvokeCommand(const Token& command, const Dictionary& arguments) = 0;
};

/// Bumped whenever a class above changes its layout or meaning.
inline constexpr uint32_t kAbiVersion = 13;

struct DelegateOptions {
  DiagnosticSink diagnostics;  // empty: discarded
  Dictionary settings;         // initial render settings; also "ocio": path of an OCIO config
};

}  // namespace alabaster::hd

extern "C" {
/// The one exported factory. Null if the ABI versions differ or the renderer cannot start (reported to the sink), as in
/// a process that was forked from one with delegates: TBB cannot be used without its threads.
ALABASTER_API alabaster::hd::RenderDelegate* CreateAlabasterRenderDelegate(
    uint32_t abi_version, const alabaster::hd::DelegateOptions* options);
/// The last delegate of a process ends TBB's workers, so that the library can be unloaded: this waits until the host's
/// own tasks in them have ended, unless another thread uses TBB. In a process that was forked from the delegate's,
/// which has none of its threads, this does nothing.
ALABASTER_API void DestroyAlabasterRenderDelegate(alabaster::hd::RenderDelegate* delegate);
/// "0.1.0", then one line per library it stands on with its version.
ALABASTER_API const char* AlabasterVersions();
}
