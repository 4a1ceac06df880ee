// A scene archive (.alab): all prims of a scene in one file, without loss, for farms, reports of faults and captures;
// the edits of a reader at rest. The layout is that of safetensors (8 bytes with the length of the header, a JSON
// header, tensors), so that numpy reads the arrays. Prims are JSON in the tensor "scene.json".
#pragma once

#include "delegate/host/scene_source.h"

namespace alabaster::hd::archive {

/// Rises when older readers cannot read what is written. Archives of later versions are refused, earlier ones read.
/// 2 has names of prims, and the scene's up axis, unit and time codes.
inline constexpr int kVersion = 2;

using host::SceneInfo;

struct WriteOptions {
  /// Images are stored in the archive. Else they are named by path and digest.
  bool embed_images = false;
  DiagnosticSink sink = {};  // reports files outside of the archive's folder, which readers refuse by default
};
/// Writes all prims. Files of products that lie in their own folder (RenderProduct::within) are named relative to it,
/// and lie below the archive's folder when it is read. The file is replaced whole or stays as it was. Returns "", or
/// the reason. Never throws.
ALABASTER_API std::string WriteArchive(const std::string& file, const host::Prims& prims, const SceneInfo& info = {},
                                       const WriteOptions& options = {});

/// Writes all prims, with render settings that draw what a pass of `state` draws: they are those of the scene that
/// `settings` name by "renderSettingsPrimPath", else new ones, with the camera and the framing of the state and with
/// `settings` over theirs. Without a product they have NAME.exr, of floats, beside the archive. "ocio" names the
/// OpenColorIO config. Meshes beyond the state's collection are hidden. The state's bindings are ignored. `info` has
/// the scene's other facts. Returns "", or the reason. Never throws.
ALABASTER_API std::string WritePass(const std::string& file, const host::Prims& prims, const RenderPassState& state,
                                    const std::map<Token, Value>& settings, SceneInfo info = {});

struct ReadOptions {
  /// An archive names files in its own folder or below only, symbolic links followed. True lifts this.
  bool allow_outside = false;
  std::string within = {};           // for the archive itself, as of an AssetPath
  size_t memory_limit = ~size_t(0);  // bytes that reading may hold at a time
  /// Of an archive in memory, in the place of its own folder: real paths of the folders that its files lie in or below,
  /// unless outside is allowed. Empty: it names no file.
  std::vector<std::string> folders = {};
  /// The answer of a reader that follows time. It may have prims that are gone ("removed"), and changes: prims without
  /// a kind. Other archives are refused for these.
  bool is_answer = false;
};
struct ReadResult {
  bool ok = false;
  bool out_of_memory = false;  // the cause, if not
  SceneInfo info = {};
  size_t memory_bytes = 0;  // of the file, whose memory the arrays of the scene share, and of images stored in it
};
/// Adds the prims of an archive, which is checked as an untrusted file. An image whose digest differs is a warning.
/// After an error `ok` is false, and the edits are to be dropped. Never throws. The file is read, not mapped: reading
/// memory that is mapped to a file which another process has truncated ends the program.
ALABASTER_API ReadResult ReadArchive(const std::string& file, host::SceneEdits* edits, const DiagnosticSink& sink,
                                     const ReadOptions& options = {});
/// The same, with the prims in a scene; after an error, none, unless memory ran out while they were set.
ALABASTER_API ReadResult ReadArchive(const std::string& file, host::RetainedSceneDelegate* scene,
                                     const DiagnosticSink& sink, const ReadOptions& options = {});
/// The same of an archive in memory (memfd_create), which messages call `name`. It is mapped, and refused unless it is
/// sealed for good against shrinking, growing and writing. It names files by absolute paths. The descriptor stays open.
ALABASTER_API ReadResult ReadSealedArchive(int descriptor, const std::string& name, host::SceneEdits* edits,
                                           const DiagnosticSink& sink, const ReadOptions& options = {});

/// An archive as a source of one pose.
ALABASTER_API std::unique_ptr<host::SceneSource> MakeArchiveSource();

}  // namespace alabaster::hd::archive
