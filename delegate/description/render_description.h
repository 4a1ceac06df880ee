// The render description (.json, schemas/render_description.json), for everything that glTF cannot express, and
// LoadScene, which loads any scene file: .json, .gltf, .glb, .alab (archive/archive.h) and stages of OpenUSD.
#pragma once

#include "delegate/host/scene_fields.h"
#include "delegate/host/scene_source.h"

namespace alabaster::hd::description {

/// A value that comes over those of the scene.
struct ALABASTER_API Override {
  /// "place=value", with the value as JSON or bare text: "samples=16", "materials/skin.roughness=0.3",
  /// "lights/key.intensity=4", "meshes/head.refineLevel=3", "camera.fStop=2.8".
  Override(const std::string& assignment);                                 // NOLINT(google-explicit-constructor)
  Override(const char* assignment) : Override(std::string(assignment)) {}  // NOLINT(google-explicit-constructor)
  /// `option` names the value in messages: "--spp 16".
  Override(std::string option, std::string where, Value given)
      : origin(std::move(option)), place(std::move(where)), value(std::move(given)) {}

  std::string origin;  // as messages name it: the option, or the whole assignment
  std::string place;   // left of "=" in an assignment
  Value value;         // a text may be JSON. Empty: `origin` is no assignment
};

/// Changes to a scene while it is loaded: layers over its file. They pass the same checks as a file.
struct LoadOptions {
  std::vector<Override> overrides;  // a later one comes over those before it
  /// Name or path of the camera to render from, in place of the file's camera with its changes; empty for the scene's
  /// own choice.
  std::string camera;
  /// Replaces every dome light by an image file, or by a colour as one or three numbers. A last comma may add an
  /// intensity: "sky.hdr", "sky.hdr,0.5", "0.2,0.3,0.4", "0.2,0.3,0.4,2". Empty keeps the scene's own.
  std::string dome;
  /// Leaves images that are missing or damaged to the renderer, which reports them and can go on without. Else they are
  /// errors at once.
  bool keep_going = false;
  /// A description names files in its own folder or below only, symbolic links followed, for reading and for writing,
  /// and so does a glTF file. True lifts this. Overrides and the dome are the user's own words, and name any file.
  bool allow_outside = false;
  /// Of stages of OpenUSD alone; the shutter and the camera are those below.
  host::StageOptions stage;
  /// Subdivision level of stages.
  std::optional<int> complexity;
  /// Of the models' animations, added to each description's `time`: seconds, or time codes of a model that has these.
  /// Empty: models without a `time` keep the pose in which they are authored.
  std::optional<double> time;
  /// In place of the time: the time of this frame, at `frames_per_second`.
  std::optional<double> frame;
  /// The shutter of the camera, in frames relative to the one that is drawn, in place of the description's. Animations
  /// are sampled over it; models without a time are then posed at 0.
  struct Shutter {
    double open = 0, close = 0;
  };
  std::optional<Shutter> shutter;
  /// AOV motion shows the way to the next frame (setting motionShutter): what the models' animations move gets a sample
  /// of that, too. Empty: where a product has the AOV.
  std::optional<bool> next_frame;
  std::optional<double> frames_per_second;  // empty: as many as a model has time codes, else 24
  /// In place of those of the settings, of overrides and of all products.
  std::optional<Vec2i> size;
  std::optional<Rect2i> crop;
  /// As in host::SourceOptions, in place of the description's; an error if it has several models.
  std::string scene, animation, variant;
  /// Messages name these options as flags, "--camera NAME"; else as arguments, "camera=NAME".
  bool are_flags = false;
};

/// The cause of a failed load. `option`: LoadOptions name or set something that the scene does not have or take; a file
/// that is missing or unreadable is `input`, wherever it is named.
enum class LoadCause { none, input, option, out_of_memory };

struct SceneFile {
  bool ok = false;
  LoadCause cause = LoadCause::none;
  Path settings;                       // the RenderSettings prim, from the file or else from defaults
  std::vector<Path> further_settings;  // one for each further resolution or crop of the products
  std::string color_config;            // OCIO config that the description names; empty if none
  std::string color_config_within;     // as of an AssetPath
  struct Model : host::SceneFacts {
    std::vector<Path> meshes, lights, cameras;
  };
  std::vector<Model> models;
  host::SceneInfo info;            // up axis, unit and time codes of the first model, which are the scene's
  bool has_light = true;           // of its own, or a studio that was asked for
  bool framed = false;             // there was no camera, and one was placed to show all of the scene
  std::optional<Vec3d> look_at;    // the point that a camera of the description looks at
  std::vector<std::string> notes;  // "no camera: framed the scene", "no light: added a soft dome", as the program says
};

/// Loads a scene and completes it: frames the scene if it has no camera, and adds a studio if it has no light
/// (settings.studio; both are noted). An unknown key is an error that names the nearest known key and the place (JSON
/// pointer, line). Never throws. After a reported error `ok` is false, and the content of `scene` is undefined but
/// harmless.
ALABASTER_API SceneFile LoadScene(const std::string& file, host::RetainedSceneDelegate* scene,
                                  const DiagnosticSink& sink, const LoadOptions& options = {});

/// A scene that is read once and posed at any number of times. It keeps what poses need. One thread.
class ALABASTER_API OpenScene {
 public:
  OpenScene();
  ~OpenScene();
  OpenScene(OpenScene&&) noexcept;
  OpenScene& operator=(OpenScene&&) noexcept;

  /// LoadScene, with the models kept open. `scene` must outlive the source. A pose needs LoadOptions::time or frame, or
  /// a time or an animation of a model in the description.
  SceneFile Load(const std::string& file, host::RetainedSceneDelegate* scene, const DiagnosticSink& sink,
                 const LoadOptions& options = {});
  /// Gives the models of the scene the pose at `time`, in place of LoadOptions::time, or that of a frame, in place of
  /// LoadOptions::frame, with the changes that the description and the options make: their prims are those that a load
  /// for it makes. Only what the animations move or deform is set again, without what others changed of it, and prims
  /// that the pose lacks are removed. A camera that was framed, and the lights of a studio, stay as they were loaded.
  /// Warnings are not given again. `none`, or the cause of a reported error, after which the scene is as it was.
  LoadCause Pose(double time, const DiagnosticSink& sink);
  LoadCause PoseFrame(double frame, const DiagnosticSink& sink);

 private:
  struct State;
  LoadCause pose(const LoadOptions& at, const DiagnosticSink& sink);

  std::unique_ptr<State> open_;  // null: nothing is loaded
};

/// The render description `text` with the options as a load takes them, but for the dome, which is a light of the
/// loaded scene. `place` turns each name of a file to read into the one that is written; the names of options are
/// absolute by then. Empty: `text` is no description.
ALABASTER_API std::string WithOptions(const std::string& text, const LoadOptions& options,
                                      const std::function<std::string(const std::string&)>& place);

/// Millimetres that `camera` of a description and --set take for a length of lens or film, which is in scene units:
/// they are read as just this length.
ALABASTER_API double Millimetres(float length, const host::SceneInfo& scene);

/// A box in world space; without points `min` is above `max`.
struct WorldBox {
  Vec3d min = Vec3d(std::numeric_limits<double>::infinity()), max = -min;
};
/// The box of each mesh: of the points of its faces as they are modelled, before subdivision and displacement, at all
/// its instances. Hidden meshes have one, too.
ALABASTER_API std::map<Path, WorldBox> MeshBoxes(host::RetainedSceneDelegate& scene);

/// The keys of a part of descriptions, in the order of its table: "settings", "camera", or of an entry of "models",
/// "meshes", "lights" and "products"; of "materials" those of `set`.
ALABASTER_API std::vector<host::FieldRow> DescriptionKeys(const std::string& part);

/// The text of a schema by name: disney_material, texture_node, displacement_node, textures, mesh, lights, camera,
/// render_settings, render_description, or quality_presets, which holds settings and measurements rather than a schema.
/// Null if unknown. Schemas are written from tables.
ALABASTER_API const char* SchemaText(const std::string& name);

}  // namespace alabaster::hd::description
