// Applies the parts of a render description to the scene, each in a file of its own. The schema has already accepted
// all values; the readers check the rest (names, indices, contradictions).
#pragma once

#include <map>
#include <optional>
#include <set>

#include "core/memory/memory_budget.h"
#include "delegate/description/json_document.h"
#include "delegate/description/render_description.h"

namespace alabaster::hd::description {

/// The camera under construction: first from the description, then from the overrides.
struct CameraPlan {
  std::string use, use_place;  // name of an existing camera, and the place that asks for it
  std::optional<Matrix4d> transform;
  TimeSamples<Matrix4d> motion;       // in place of the transform, or empty
  std::map<Token, Value> parameters;  // in the contract's units
};

/// Resolution and crop that a product asks for.
struct FramePlan {
  std::optional<Vec2i> resolution;
  std::optional<Rect2i> crop;
  bool operator==(const FramePlan&) const = default;
};
struct ProductPlan {
  FramePlan frame;
  RenderProduct product;
  bool is_of_archive = false;  // products of the description come in the place of those
};

/// A model of the scene, to be posed.
struct OpenModel {
  gltf::GltfSource source;
  double time = 0;               // of the description, to which LoadOptions::time is added
  TimeSamples<Matrix4d> motion;  // of the description, or empty
};

/// A document that changes meshes or lights; each pose applies it again to the prims that it moves.
struct AppliedDocument {
  JsonDocument document;
  std::string folder;
};

/// Meshes that a light is linked to: those that a pattern matches have the category.
struct MeshLink {
  Token category;
  std::vector<std::string> patterns;
};

/// Which scenes a studio lights: those without light, all, or none.
enum class StudioChoice { when_dark, on, off };

/// The state of loading, which all readers share.
struct LoadState {
  host::RetainedSceneDelegate* scene = nullptr;
  const DiagnosticSink* sink = nullptr;
  SceneFile* result = nullptr;
  LoadOptions options;
  CameraPlan camera;
  RenderSettingsDescription settings;
  Path settings_path = "/render", planned_camera = "/camera";  // the prims that loading makes
  bool archive_settings = false;                               // settings_path is that of an archive's settings
  StudioChoice studio = StudioChoice::when_dark;
  std::vector<ProductPlan> products;
  std::map<std::pair<std::string, std::string>, std::string> image_faults;  // by path and folder; empty: it is an image
  std::shared_ptr<MemoryBudget> memory;  // of loading: the description, and the models one after the other
  MemoryReservation held;                // by what is loaded already
  std::vector<OpenModel> models;
  std::set<Path> archive_paths;       // of this load; prims of earlier loads into the scene are replaced
  std::set<std::string> model_names;  // "/gltf/head": paths of a glTF model begin so
  bool has_archive = false;           // as the first model: no light is added, and a camera only if there is none
  std::vector<AppliedDocument> documents;
  std::vector<MeshLink> links;                 // in the order in which they were made
  std::map<std::string, Path> mesh_materials;  // that meshes were given, by pattern
  /// `scene` holds only the prims that a pose moves, so that a name may match none.
  bool posing = false;
  LoadCause cause = LoadCause::none;  // of the failure; the first that is noted counts
  void note_cause(LoadCause noted) {
    if (cause == LoadCause::none) cause = noted;
  }
};

/// One document being applied.
class Reader {
 public:
  /// `folder` is that of the description; empty for the words of the command line.
  Reader(const JsonDocument& document, std::string folder, LoadState* state);

  const nlohmann::json& value() const { return document_.value; }
  LoadState& state() const { return state_; }
  host::RetainedSceneDelegate& scene() const { return *state_.scene; }
  std::string place(const std::string& pointer) const { return document_.place(pointer); }
  /// Reports an error; returns false.
  bool fail(const std::string& pointer, const std::string& text) const;
  void warn(const std::string& pointer, const std::string& text) const;
  /// True for the words of the command line, which the user wrote.
  bool is_users() const { return folder_.empty(); }
  /// The real path of the folder that files must lie in or below when they are opened; empty: anywhere.
  const std::string& within() const { return within_; }
  /// The path of a file that the description names for reading or writing; empty after an error: it must not name it.
  std::string resolve(const std::string& pointer, const std::string& file) const;
  /// An existing file; empty after an error.
  AssetPath asset(const std::string& pointer, const std::string& file) const;
  /// An existing image of a kind that can be read; empty after an error. With keep_going any name will do.
  AssetPath image(const std::string& pointer, const std::string& file) const;

 private:
  const JsonDocument& document_;
  std::string folder_, within_;
  LoadState& state_;
};

/// Loads a scene file of any kind and completes it. False after a reported error. Throws MemoryRefused and what the
/// standard library throws.
bool load_scene(const std::string& file, const LoadOptions& options, LoadState* state);

/// True if a memory limit in MiB, of a description, is none or above the one that holds without it.
bool loosens_memory_limit(double mib);

/// Adds a model to the scene, and notes the cause if it cannot be read.
bool load_model(const std::string& file, const gltf::GltfOptions& options, OpenModel model, LoadState* state);

/// Adds the prims of a scene archive, below a root of their own where the scene has prims of their paths.
struct ArchiveModel {
  std::string within;
  /// The description's first model: its render settings, camera and products are taken, and the description changes
  /// them.
  bool is_first = true;
  std::optional<Matrix4d> transform;  // of all prims
  TimeSamples<Matrix4d> motion;
};
bool load_archive(const std::string& file, const ArchiveModel& model, LoadState* state);

/// True if an archive of this load has a prim of the path, or one below it.
bool has_archive_prims_at(const LoadState& state, const std::string& path);
/// `wanted`, or with a number behind it where this load has prims there.
Path free_path(const LoadState& state, const std::string& wanted);

/// Has the animation sampled over the shutter, if that is open.
void sample_shutter(const LoadOptions& asked, gltf::GltfOptions* model);

bool apply_models(const Reader& reader);
bool apply_materials(const Reader& reader);
bool apply_meshes(const Reader& reader);
bool apply_lights(const Reader& reader);
bool apply_camera(const Reader& reader);
bool apply_settings(const Reader& reader);
bool apply_products(const Reader& reader);

/// True if a material lights a scene, which then needs no light of its own.
bool gives_light(const MaterialNetwork& material);

/// Makes the camera, default lights and RenderSettings prims, after everything else has been applied.
bool complete_scene(LoadState* state);

/// Places the lights that move where the document has them.
bool place_lights(const Reader& reader);
/// Puts the meshes of the scene in the category, or takes them out of it.
void apply_link(const MeshLink& link, host::RetainedSceneDelegate* scene);
/// Makes the camera again from that of a model, once this one is posed.
void pose_camera(LoadState* state);

/// A number, boolean, text (as std::string) or list of two or three numbers, as a Value of the contract.
Value to_value(const nlohmann::json& value);

enum class PrimKind { mesh, material, light, camera };

/// The prims of one kind that `pattern` matches, and the meshes that have subsets which it matches. If there is none,
/// reports the nearest existing name, but not while posing.
std::vector<Path> find_prims(const Reader& reader, PrimKind kind, const std::string& pattern,
                             const std::string& pointer);

/// Turn an override ("materials/skin.roughness=0.3") and a dome ("sky.hdr,0.5") into render descriptions of their own,
/// so that they pass the same checks and readers.
bool override_document(const std::string& assignment, JsonDocument* document, std::string* error);
JsonDocument dome_document(const std::string& dome);
/// The schema's validator counts characters, and reads beyond a table where bytes are none: texts that come from a
/// command line are checked first.
bool is_utf8(const std::string& text);
/// A larger description is refused.
inline constexpr uintmax_t kMaxDescriptionBytes = 64u << 20;

}  // namespace alabaster::hd::description
