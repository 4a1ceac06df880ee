// The state of a load, and the steps that change it, each in a file of its own. All values have been checked by their
// tables already; the steps check the rest (names, indices, contradictions), and edit prims by their fields.
#pragma once

#include <map>
#include <optional>
#include <set>

#include "core/memory/memory_budget.h"
#include "delegate/description/json_document.h"
#include "delegate/description/model.h"
#include "delegate/description/name_match.h"
#include "delegate/description/render_description.h"
#include "delegate/host/scene_fields.h"

namespace alabaster::hd::description {

/// The camera as the description and the options over it have it.
struct CameraPlan {
  std::string use;  // path of an existing camera
  Placement placement;
  std::map<Token, Value> parameters;  // in the contract's units
};

/// What an entry of a list says of one prim.
struct PrimEdit {
  const std::string& pointer;
  const nlohmann::json& entry;
  const Path& path;
  bool is_new = false;
  Token kind = {};           // of a new prim
  host::Fields fields = {};  // that it sets, in this order
  bool may_wait = false;     // until other fields of the prim are set: nothing that follows reads them
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
  std::string place = {};      // its pointer in the description
};

/// Which scenes a studio lights: those without light, all, or none.
enum class StudioChoice { when_dark, on, off };

/// Thrown after the report of a fault that ends a load or a pose.
struct LoadFailed {};

/// A scene that is being loaded or posed: its description, with the options over it, and what comes of it.
struct LoadState {
  JsonDocument document;
  std::string folder, within;  // of the file: its folder, and the real one that its files must lie in; empty: anywhere
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
  std::map<std::array<std::string, 3>, std::string> image_faults;  // by path, folder and layer; empty: it is an image
  std::shared_ptr<MemoryBudget> memory;            // of loading: the description, and the models one after the other
  MemoryReservation held, read;                    // by what is loaded already, and by the description
  std::vector<std::unique_ptr<OpenModel>> models;  // to be posed
  std::set<Path> archive_paths;       // of models without a root, of this load: those of earlier loads are replaced
  std::set<Path> model_names;         // "/gltf/head": paths of a model whose prims have a root begin so
  bool is_complete = false;           // the first model is: no light is added, and a camera only if there is none
  std::map<std::string, int> copies;  // the last number that a path was given in order to differ, by that path
  std::map<std::string, std::map<std::string, MaterialNetwork>> looks;  // of MaterialX files, by file and name
  bool studio_is_alone = false;  // it was asked for, in place of the scene's lights
  /// Categories of lights: the meshes that a pattern matches have them.
  std::map<Token, std::vector<std::string>> links;
  std::map<std::string_view, NameIndex> names;  // of the scene's prims, by kind; made when they are first asked for
  std::map<std::string, Path> mesh_materials;   // that meshes were given, by pattern
  /// `scene` holds only the prims that a pose moves, so that a name may match none.
  bool posing = false;
  LoadCause cause = LoadCause::none;  // of the failure; the first that is noted counts

  void note_cause(LoadCause noted) {
    if (cause == LoadCause::none) cause = noted;
  }
  /// The list or object of that name in the description; null: it has none.
  const nlohmann::json* part(const char* name) const;
  /// Calls apply(pointer, entry) for each entry of a list of the description.
  template <class Apply>
  void for_each_entry(const char* list, const Apply& apply) const {
    const nlohmann::json* entries = part(list);
    for (size_t i = 0; entries && i < entries->size(); ++i)
      apply("/" + std::string(list) + "/" + std::to_string(i), (*entries)[i]);
  }
  // These throw LoadFailed after a report.
  /// Changes the named fields of a prim, or makes it if a kind is given; a fault is reported at the pointer.
  void edit(const std::string& pointer, const Path& prim, const Token& new_kind, const host::Fields& fields);
  void report(Severity severity, const char* code, const std::string& where, const std::string& text) const;
  [[noreturn]] void fail(LoadCause noted, const char* code, const std::string& where, const std::string& text);
  /// Reports an error at the origin of the value.
  [[noreturn]] void fail(const std::string& pointer, const std::string& text);
  /// The path of a file for reading or writing that the value at the pointer names. An option names any file, from the
  /// working folder on, and the description those that it may name.
  std::string resolve(const std::string& pointer, const std::string& file);
  /// An existing file.
  AssetPath asset(const std::string& pointer, const std::string& file);
  /// An existing image of a kind that can be read, which has the layer. With keep_going any name will do.
  AssetPath image(const std::string& pointer, const std::string& file, const std::string& layer);

  void warn(const std::string& pointer, const std::string& text) const;
  /// The folder that a file named at the pointer must lie in.
  std::string within_of(const std::string& pointer) const;
};

/// Loads a scene file of any kind and completes it, with the state's options. Throws LoadFailed, MemoryRefused and what
/// the standard library throws.
void load_scene(const std::string& file, LoadState* state);

/// True if a memory limit in MiB, of a description, is none or above the one that holds without it.
bool loosens_memory_limit(double mib);
/// The warning that a limit of a file is not taken.
std::string refused_limit_text(const LoadOptions& options);

/// True if a path is, or lies below, the root of a model.
bool is_of_model(const LoadState& state, const std::string& path);
/// `wanted`, or with a number behind it where this load has prims there.
Path free_path(LoadState* state, const std::string& wanted);

void apply_models(LoadState& load);
/// Makes the edits of materials, meshes and lights. Of a scene that is posed, those of the prims that it has.
void edit_prims(LoadState& load);
void apply_camera(LoadState& load);
void apply_settings(LoadState& load);
void apply_products(LoadState& load);

// Each reads an entry as fields of a prim.
void read_material(LoadState& load, PrimEdit* edit);
void read_mesh(LoadState& load, PrimEdit* edit);
void read_light(LoadState& load, PrimEdit* edit);
/// A value of a field whose numbers are floats and never integers.
Value field_value(const nlohmann::json& value);

/// True if a material lights a scene, which then needs no light of its own.
bool gives_light(const MaterialNetwork& material);

/// Makes the camera, default lights and RenderSettings prims, after everything else has been applied.
void complete_scene(LoadState* state);

/// Removes all domes, or all other lights.
void remove_lights(host::RetainedSceneDelegate* scene, bool domes);
/// Puts the meshes of the scene in the categories of lights, or takes them out.
void apply_links(LoadState& load);
/// Makes the camera again from that of a model, once this one is posed.
void pose_camera(LoadState* state);

/// The prims of one kind that `pattern` matches, and the meshes that have subsets which it matches. If there is none,
/// reports the nearest existing name, but not while posing.
std::vector<Path> find_prims(LoadState& load, std::string_view kind, const std::string& pattern,
                             const std::string& pointer);
/// The path of a prim that an entry makes, which none must have yet.
Path new_path(LoadState& load, const std::string& kind, const Path& folder, const std::string& pointer,
              const std::string& name);
/// The subsets of a mesh that `pattern` matches, unless it matches the mesh.
std::vector<size_t> find_parts(LoadState& load, const std::string& pattern, const Path& mesh);
/// Tells that the scene has a new prim.
void add_name(LoadState& load, std::string_view kind, const Path& path);

/// A larger description is refused.
inline constexpr uintmax_t kMaxDescriptionBytes = 64u << 20;

}  // namespace alabaster::hd::description
