// A scene on show: a pass that is always running, its buffers, the camera, the edits. Knows neither window nor widgets.
#pragma once

#include <algorithm>
#include <optional>

#include "delegate/cli/scene_session.h"
#include "delegate/host/display_transform.h"
#include "delegate/host/picker.h"
#include "delegate/host/product_writer.h"
#include "delegate/view/kept_picture.h"
#include "delegate/view/light_placement.h"
#include "delegate/view/orbit_camera.h"
#include "delegate/view/picture_fetcher.h"
#include "delegate/view/scene_edits.h"

namespace alabaster::view {

struct ViewStatus {
  hd::PassState state = hd::PassState::idle;
  std::string state_name;
  uint32_t samples = 0, samples_total = 0;  // per pixel
  double seconds = 0;                       // of rendering
  bool covered = false;                     // the picture covers the frame
  /// Relative RMSE of the picture as rendered, and its 95 % interval; below 0: not known yet.
  double noise = -1, noise_low = -1, noise_high = -1;
  double noise_samples = 0;  // per pixel, when the noise was measured
  double denoised = -1;      // share of the denoising that is done; below 0: not begun
  std::string denoiser;      // name and version, once its picture is there
  std::string fault;         // of a render or denoiser that failed
  int scene_faults = 0;
};

/// Seconds of rendering from now on until the noise is `target`, if it goes on falling with the root of time; below 0
/// if nothing is known yet.
double seconds_to(const ViewStatus& status, double target);

struct Picked {
  hd::host::PickHit hit;
  hd::Path material;          // of the face
  hd::Vec2d place{0.5, 0.5};  // in the picture, from 0 to 1, y down
};

/// Keeps what a buffer holds as numbers, for single pixels.
class PixelReader {
 public:
  /// Brings them up to date. False: the buffer shows nothing yet.
  bool read(hd::RenderBuffer* buffer);
  /// The values of the pixel at a place from 0 to 1, y down, as many as the buffer has, as they were read last; empty
  /// if nothing was.
  std::vector<float> values(double x, double y) const;
  std::vector<float> values(hd::RenderBuffer* buffer, double x, double y) {
    return read(buffer) ? values(x, y) : std::vector<float>();
  }

 private:
  hd::RenderBuffer* buffer_ = nullptr;
  hd::PixelMemory memory_;
  std::vector<float> pixels_;
};

enum class Compare { rendered, denoised, side_by_side };

/// A look that was kept: its picture as it was, and what makes it again.
struct KeptLook {
  std::shared_ptr<KeptPicture> picture;
  std::string aov, layer;  // what was asked for, and the AOV that the picture is of: "denoised" for a "color"
  bool is_denoised = false;
  uint32_t samples = 0;
  double noise = -1;  // as of a status
  int scene = 0;      // of the scenes that were loaded
  hd::CameraDescription camera;
  EditRecord edits;
  std::map<std::string, hd::Value> settings;
};

/// One thread, but for the diagnostics sink.
class ViewSession {
 public:
  /// `loaded` has been loaded and started.
  ViewSession(std::unique_ptr<cli::SceneSession> loaded, hd::DiagnosticSink sink);
  ~ViewSession();

  /// Shows a scene in the place of the present one, with its edits, its settings and the camera; one that nobody has
  /// placed is the new scene's. What the new scene has no place for is reported. No one may still use a buffer.
  void reload(std::unique_ptr<cli::SceneSession> loaded);
  const cli::SceneSession& loaded() const { return *loaded_; }

  /// Syncs what was edited and restarts what it changes; to be called for each picture of the window. Never renders.
  void update();
  ViewStatus status() const;

  /// Width over height of the frame as a screen shows it.
  double aspect() const;
  /// The axis of the scene that points up.
  hd::Vec3d up() const { return loaded_->file.info.up == hd::Token("Z") ? hd::Vec3d(0, 0, 1) : hd::Vec3d(0, 1, 0); }
  void set_size(hd::Vec2i size);
  hd::Vec2i size() const { return size_; }

  /// AOVs that were shown once stay bound, so that looking at them again renders nothing.
  void show_aov(const std::string& aov);
  const std::string& aov() const { return aov_; }
  void compare(Compare how);
  Compare compared() const { return compare_; }

  /// Keeps the look that is shown, A, left of the divider; the present one, B, is right of it. False: there is no
  /// picture of the present edits yet that covers the frame.
  bool keep_look();
  void drop_look() { kept_.reset(); }
  /// Null: none is kept.
  const KeptLook* kept_look() const { return kept_ ? &*kept_ : nullptr; }
  /// The present camera sees what the kept picture shows.
  bool is_kept_framing() const;
  /// Makes the edits and settings of the kept look, and keeps the present one. False: none is kept, or as keep_look().
  bool swap_looks();
  /// The picture of the present look from when it was last shown, in the place of the one that is rendered until that
  /// has as many samples. Null: the one that is rendered is shown.
  const KeptLook* stand_in() const { return stand_in_ ? &*stand_in_ : nullptr; }
  /// The picture has a divider, at this share of its width.
  bool is_divided() const { return kept_ || (compare_ == Compare::side_by_side && aov_ == "color"); }
  double divider() const { return divider_; }
  void set_divider(double share) { divider_ = std::clamp(share, 0.0, 1.0); }

  const std::vector<hd::host::ColorDisplay>& displays() const { return displays_; }
  /// False after a report. Empty names: the configuration's defaults.
  bool set_display(const std::string& display, const std::string& view);
  const std::string& display() const { return display_name_; }
  const std::string& display_view() const { return view_name_; }
  void set_exposure(float stops);
  float exposure() const { return exposure_; }
  /// A colour of the rendering space as the display shows it.
  hd::Vec3f shown(const hd::Vec3f& color) const;

  /// Ends rendering until it is resumed, and then denoises the samples so far if the denoised picture is shown.
  void pause(bool paused);
  bool paused() const { return paused_; }

  SceneEdits& edits() { return edits_; }
  /// Makes an edit of edits(), and has the picture follow. A fault that it returns is reported.
  template <class Edit>
  void edit(const hd::Path& prim, const Edit& make) {
    if (const std::string fault = make(); !fault.empty()) sink_({hd::Severity::error, "view.edit", prim.str(), fault});
    changed();
  }
  /// Adds a light of a type of kNewLights for what the camera sees at a place; its path.
  hd::Path add_light(const std::string& type, double x, double y);
  /// Binds what surface_at() needs.
  void bind_surface() { bind("normal"); }
  /// Reads the pixels that surface_at() is about. False: they are not known yet.
  bool read_surface();
  std::optional<SurfacePoint> surface_at(double x, double y) const;
  /// From a point to the eye; of length 1.
  hd::Vec3d to_eye(const hd::Vec3d& point) const;
  const hd::CameraDescription& camera() const { return camera_; }
  /// A camera that moves in the scene stands still once it is placed elsewhere. The first time a message says so. Its
  /// lens stands still from now on.
  void set_camera(hd::CameraDescription camera);
  /// The scene's camera moves while the shutter is open.
  bool camera_moves() const;
  /// The picture shows its motion.
  bool is_camera_motion_kept() const { return camera_.transformSamples.values.size() > 1; }
  void reset_camera();
  Sight sight() const { return sight(camera_); }
  /// Length of the diagonal of the meshes' points; 1 if they have none.
  double scene_size() const { return scene_size_; }
  double units_per_millimetre() const { return double(loaded_->file.info.units_per_millimetre()); }

  hd::Value setting(const std::string& key) const;
  void set_setting(const ParameterRow& row, const hd::Value& value);
  void reset_setting(const std::string& key);
  bool is_setting_changed(const std::string& key) const { return changed_settings_.contains(key); }
  /// Takes the settings of schemas/quality_presets.json.
  void apply_quality(const std::string& preset);
  /// The preset whose settings are in force; "": none was chosen; nothing: some of its settings were changed.
  std::optional<std::string> quality() const;

  /// Places are those of the picture, from 0 to 1, with y down.
  std::optional<Picked> pick(double x, double y);
  /// Distance along the view axis; empty where the background is.
  std::optional<double> depth_at(double x, double y);
  /// The values of what is shown at a place, as rendered or denoised.
  std::vector<float> values_at(double x, double y);

  /// The picture left of the divider, and the one right of it (null buffer: none).
  PictureRequest left() const;
  PictureRequest right() const;

  /// Files appear whole. False after a report.
  /// `scene_file`: that was loaded. No file of the scene is overwritten.
  bool save_picture(const std::string& file, const std::string& scene_file);
  bool save_description(const std::string& file, const std::string& scene_file);

 private:
  void begin();
  std::string shown_aov() const;
  std::optional<KeptLook> present_look() const;
  void restore(const EditRecord& edits, const std::map<std::string, hd::Value>& settings);
  bool is_input(const std::string& file, const std::string& scene_file) const;
  void hold_camera();
  void heed_state();
  void picture_ends();
  hd::RenderBuffer* buffer(const std::string& aov) const;
  void bind(const std::string& aov);
  bool set_buffer(const std::string& aov);
  Sight sight(const hd::CameraDescription& camera) const;
  PictureRequest request(const std::string& aov) const;
  void changed();

  std::unique_ptr<cli::SceneSession> loaded_;
  hd::DiagnosticSink sink_;
  SceneEdits edits_;
  hd::RenderSettingsDescription settings_;
  hd::CameraDescription camera_, first_camera_;
  double scene_size_ = 1;
  std::unique_ptr<hd::RenderPass> pass_;
  hd::RenderPassState state_;
  std::vector<std::string> bound_;
  hd::Vec2i size_{0, 0};
  std::string aov_ = "color";
  Compare compare_ = Compare::rendered;
  bool paused_ = false, dirty_ = true, camera_motion_told_ = false;
  bool is_current_ = false;  // what is rendered has the present edits, settings and camera
  int scene_ = 0;            // of the scenes that were loaded
  std::vector<hd::host::ColorDisplay> displays_;
  std::string display_name_, view_name_;
  float exposure_ = 0;
  std::shared_ptr<hd::host::DisplayTransform> display_;
  uint64_t display_version_ = 0;
  std::map<std::string, hd::Value> changed_settings_;
  std::optional<KeptLook> kept_, stand_in_;
  double divider_ = 0.5;
  PixelReader depths_, normals_, values_;
};

}  // namespace alabaster::view
