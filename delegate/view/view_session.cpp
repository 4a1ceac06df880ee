#include "delegate/view/view_session.h"

#include <algorithm>
#include <cmath>

#include "delegate/description/quality_presets.h"
#include "delegate/host/snapshot.h"
#include "delegate/support/lookup.h"
#include "delegate/view/saved_description.h"

namespace alabaster::view {
namespace {

using hd::Matrix4d;
using hd::Path;
using hd::Value;
using hd::Vec2i;
using hd::Vec3d;
using hd::support::number_in;
using hd::support::text_in;

// Always bound: picks need the ids, and a drag needs the distance.
constexpr const char* kBoundAovs[] = {"color", "primId", "instanceId", "elementId", "cameraDepth"};

Path buffer_path(const std::string& aov) {
  return Path("/view/buffers").append(aov);
}

double size_of(hd::host::RetainedSceneDelegate& scene) {
  Vec3d low(1e300), high(-1e300);
  for (const auto& [path, box] : hd::description::MeshBoxes(scene)) {
    if (path.str().starts_with("/studio/")) continue;
    for (int i = 0; i < 3; ++i) low[i] = std::min(low[i], box.min[i]), high[i] = std::max(high[i], box.max[i]);
  }
  const double size = (high - low).length();
  return size > 0 && std::isfinite(size) && size < 1e200 ? size : 1;
}

}  // namespace

double seconds_to(const ViewStatus& status, double target) {
  if (status.noise <= 0 || target <= 0) return -1;
  const double ratio = status.noise / target;
  const double measured = status.samples > 0 ? status.noise_samples / status.samples : 1;  // share of the seconds
  return std::max(0.0, status.seconds * (measured * ratio * ratio - 1));
}

bool PixelReader::read(hd::RenderBuffer* buffer) {
  if (!buffer) return false;
  const auto components = size_t(std::clamp(hd::FormatComponents(buffer->GetFormat()), 1, 4));
  constexpr hd::Format kFormats[] = {hd::Format::float32, hd::Format::float32vec2, hd::Format::float32vec3,
                                     hd::Format::float32vec4};
  const hd::Format format = kFormats[components - 1];
  if (buffer != buffer_ || memory_.format != format) memory_ = {}, memory_.format = format, buffer_ = buffer;
  return resolve(buffer, components, &memory_, &pixels_);
}

std::vector<float> PixelReader::values(double x, double y) const {
  if (pixels_.empty()) return {};
  const auto components = size_t(hd::FormatComponents(memory_.format));
  const int column = std::clamp(int(x * memory_.size.x), 0, memory_.size.x - 1);
  const int row = std::clamp(int(y * memory_.size.y), 0, memory_.size.y - 1);
  const size_t at = (size_t(row) * size_t(memory_.size.x) + size_t(column)) * components;
  return {pixels_.begin() + std::ptrdiff_t(at), pixels_.begin() + std::ptrdiff_t(at + components)};
}

ViewSession::ViewSession(std::unique_ptr<cli::SceneSession> loaded, hd::DiagnosticSink sink)
    : loaded_(std::move(loaded)), sink_(std::move(sink)), edits_(&loaded_->scene) {
  begin();
  set_size({settings_.width, settings_.height});
  for (const char* aov : kBoundAovs) bind(aov);
  set_display("", "");
  if (number_in(settings_.settings, "denoise") != 0) compare(Compare::denoised);
}

// Takes up what was loaded.
void ViewSession::begin() {
  settings_ = loaded_->scene.GetAllRenderSettings().at(loaded_->file.settings);
  camera_ = first_camera_ = loaded_->scene.GetCameras().at(settings_.camera);
  scene_size_ = size_of(loaded_->scene);
  pass_ = loaded_->delegate()->CreateRenderPass();
  state_.camera = settings_.camera;
  state_.windowPolicy = settings_.windowPolicy;
  displays_ = hd::host::ListDisplays(loaded_->colors(), sink_);
  // AOV color is shown as it was rendered; AOV denoised has the other picture.
  loaded_->delegate()->SetRenderSetting("denoise", false);
}

void ViewSession::reload(std::unique_ptr<cli::SceneSession> loaded) {
  const bool is_placed = !(camera_ == first_camera_);
  const hd::CameraDescription camera = camera_;
  const EditRecord edits = edits_.record();
  const auto settings = std::exchange(changed_settings_, {});
  loaded_->delegate()->Stop();
  pass_.reset();
  depths_ = normals_ = values_ = {};
  loaded_ = std::move(loaded);
  ++scene_;
  edits_ = SceneEdits(&loaded_->scene);
  begin();
  if (is_placed) camera_ = camera;
  for (const std::string& aov : bound_) set_buffer(aov);
  if (!set_display(display_name_, view_name_)) set_display("", "");
  restore(edits, settings);
}

void ViewSession::restore(const EditRecord& edits, const std::map<std::string, Value>& settings) {
  for (const auto& [prim, fault] : edits_.restore(edits))
    sink_({hd::Severity::warning, "view.restore", prim.str(), "A change that was made here " + fault + "."});
  for (const auto& [key, value] : changed_settings_)
    if (!settings.contains(key)) loaded_->delegate()->SetRenderSetting(key, {});
  for (const auto& [key, value] : settings) loaded_->delegate()->SetRenderSetting(key, value);
  changed_settings_ = settings;
  changed();
}

ViewSession::~ViewSession() {
  loaded_->delegate()->Stop();
  pass_.reset();
}

void ViewSession::update() {
  if (dirty_) {
    dirty_ = false;
    if (!loaded_->index()->SyncAll()) dirty_ = true;
    state_.aovBindings.clear();
    for (const std::string& aov : bound_)
      if (hd::RenderBuffer* const b = buffer(aov)) state_.aovBindings.push_back({aov, b, {}});
  }
  state_.framing = {{0, 0}, hd::Vec2f(size_), {0, 0, size_.x, size_.y}, 1};  // the window's pixels are square
  state_.freeCamera = camera_;
  if (!pass_) return;
  pass_->Execute(state_);
  loaded_->delegate()->InvokeCommand("measureNoise", {});
  heed_state();
}

// While a scene is being built, the picture and the numbers of the pass are those of the scene before it. A stop says
// nothing about it.
void ViewSession::heed_state() {
  const hd::PassState state = pass_->GetState();
  if (!dirty_ &&
      (state == hd::PassState::rendering || state == hd::PassState::paused || state == hd::PassState::converged))
    is_current_ = true;
  if (!stand_in_ || !is_current_) return;
  const ViewStatus now = status();
  if (now.covered && (now.samples > stand_in_->samples ||
                      (now.samples == stand_in_->samples && (!stand_in_->is_denoised || !now.denoiser.empty()))))
    stand_in_.reset();
}

ViewStatus ViewSession::status() const {
  const hd::Dictionary stats = loaded_->delegate()->GetRenderStats();
  ViewStatus s;
  if (pass_) s.state = pass_->GetState();
  s.state_name = text_in(stats, "state");
  s.samples = uint32_t(number_in(stats, "numCompletedSamples", 0));
  s.samples_total = uint32_t(number_in(stats, "samplesTotal", 0));
  s.seconds = number_in(stats, "totalClockTime", 0);
  s.covered = number_in(stats, "covered", 0) != 0;
  s.noise = number_in(stats, "error.relativeRmse", -1);
  s.noise_low = number_in(stats, "error.low", -1);
  s.noise_high = number_in(stats, "error.high", -1);
  s.noise_samples = number_in(stats, "error.samples", 0);
  s.denoised = number_in(stats, "denoise.fraction", -1);
  s.denoiser = text_in(stats, "denoiser");
  s.fault = text_in(stats, "error");
  if (s.fault.empty()) s.fault = text_in(stats, "denoise.error");
  s.scene_faults = int(number_in(stats, "scene.faultCount", 0));
  return s;
}

double ViewSession::aspect() const {
  return double(settings_.width) / settings_.height * double(settings_.pixelAspectRatio);
}

hd::RenderBuffer* ViewSession::buffer(const std::string& aov) const {
  return static_cast<hd::RenderBuffer*>(loaded_->index()->GetBprim(buffer_path(aov)));
}

bool ViewSession::set_buffer(const std::string& aov) {
  const hd::Format format = loaded_->delegate()->GetDefaultAovDescriptor(aov).format;
  if (format == hd::Format::invalid) return false;
  loaded_->scene.SetRenderBuffer(buffer_path(aov), {{size_.x, size_.y, 1}, format});
  return true;
}

void ViewSession::bind(const std::string& aov) {
  if (std::find(bound_.begin(), bound_.end(), aov) != bound_.end() || !set_buffer(aov)) return;
  bound_.push_back(aov);
  changed();
}

void ViewSession::set_size(Vec2i size) {
  size = {std::clamp(size.x, 1, 16384), std::clamp(size.y, 1, 16384)};
  if (size == size_) return;
  size_ = size;
  for (const std::string& aov : bound_) set_buffer(aov);
  changed();
}

// Another picture begins.
void ViewSession::picture_ends() {
  is_current_ = false;
  stand_in_.reset();
}

void ViewSession::changed() {
  dirty_ = true;
  picture_ends();
  pause(false);
}

void ViewSession::show_aov(const std::string& aov) {
  bind(aov);
  if (aov != aov_) stand_in_.reset();
  aov_ = aov;
}

void ViewSession::compare(Compare how) {
  if (how == compare_) return;
  stand_in_.reset();
  compare_ = how;
  if (how != Compare::rendered) {
    bind("denoised");
  } else if (std::erase(bound_, "denoised") > 0) {
    changed();
  }
}

std::optional<KeptLook> ViewSession::present_look() const {
  if (stand_in_) return stand_in_;
  const ViewStatus now = status();
  KeptLook look;
  if (is_current_ && now.covered) look.picture = KeptPicture::copy(buffer(shown_aov()));
  if (!look.picture) return std::nullopt;
  look.aov = aov_, look.layer = shown_aov();
  look.is_denoised = look.layer == "denoised" && !now.denoiser.empty();
  look.samples = now.samples, look.noise = now.noise, look.scene = scene_;
  look.camera = camera_, look.edits = edits_.record(), look.settings = changed_settings_;
  return look;
}

bool ViewSession::keep_look() {
  if (compare_ == Compare::side_by_side) compare(Compare::denoised);
  kept_ = present_look();
  return kept_.has_value();
}

bool ViewSession::swap_looks() {
  std::optional<KeptLook> present = kept_ ? present_look() : std::nullopt;
  if (!present) return false;
  std::swap(kept_, present);
  restore(present->edits, present->settings);
  const hd::RenderBuffer& picture = *present->picture;
  if (present->scene == scene_ && present->layer == shown_aov() && present->camera == camera_ &&
      hd::Vec2i(picture.GetWidth(), picture.GetHeight()) == size_)
    stand_in_ = std::move(present);
  return true;
}

bool ViewSession::is_kept_framing() const {
  if (!kept_) return false;
  const double width = kept_->picture->GetWidth(), height = kept_->picture->GetHeight();
  const bool same_shape = std::abs(width / height * size_.y / size_.x - 1) < 0.02;  // a scene that was loaded again
  return same_shape && kept_->camera.transform == camera_.transform && sight(kept_->camera) == sight();
}

bool ViewSession::set_display(const std::string& display, const std::string& view) {
  hd::RenderProduct product;
  product.display = display, product.view = view, product.exposure = exposure_;
  std::shared_ptr<hd::host::DisplayTransform> made =
      hd::host::DisplayTransform::Create(product, loaded_->colors(), sink_);
  if (!made) return false;
  display_ = std::move(made);
  ++display_version_;
  display_name_ = display, view_name_ = view;
  if (display_name_.empty() && !displays_.empty()) display_name_ = displays_[0].name;
  for (const hd::host::ColorDisplay& choice : displays_)
    if (choice.name == display_name_ && view_name_.empty() && !choice.views.empty()) view_name_ = choice.views[0];
  return true;
}

void ViewSession::set_exposure(float stops) {
  if (stops == exposure_ || !display_ || !display_->SetExposure(stops)) return;
  exposure_ = stops;
  ++display_version_;
}

hd::Vec3f ViewSession::shown(const hd::Vec3f& color) const {
  float rgba[4] = {color.x, color.y, color.z, 1};
  if (display_) display_->Apply(rgba);
  return {rgba[0], rgba[1], rgba[2]};
}

void ViewSession::pause(bool paused) {
  if (paused == paused_) return;
  paused_ = paused;
  // A stopped render shows its samples denoised, and begins again; a paused one goes on where it was.
  hd::RenderDelegate& delegate = *loaded_->delegate();
  if (paused && compare_ != Compare::rendered)
    delegate.Stop();
  else if (paused)
    delegate.Pause();
  else if (delegate.IsPaused())
    delegate.Resume();
  else
    delegate.Restart();
}

void ViewSession::set_camera(hd::CameraDescription camera) {
  const bool moved = camera.transform != camera_.transform;
  camera_ = std::move(camera);
  std::erase_if(camera_.parameters, [](const auto& one) { return one.first.str().ends_with(":samples"); });
  if (moved) hold_camera();
  picture_ends();
  pause(false);
}

// A camera that the user has placed stands still there. Objects go on moving before it.
void ViewSession::hold_camera() {
  const bool told = std::exchange(camera_motion_told_, camera_motion_told_ || camera_moves());
  if (!told && camera_moves())
    sink_({hd::Severity::info, "view.motion", "camera",
           "The scene's camera moves while the shutter is open. Where it is placed here it stands still; objects keep "
           "their motion. Key R gives the scene's camera back."});
  camera_.transformSamples = {};
}

void ViewSession::reset_camera() {
  camera_ = first_camera_;
  picture_ends();
  pause(false);
}

bool ViewSession::camera_moves() const {
  return first_camera_.transformSamples.values.size() > 1;
}

Sight ViewSession::sight(const hd::CameraDescription& camera) const {
  const hd::Framing framing{{0, 0}, hd::Vec2f(size_), {0, 0, size_.x, size_.y}, 1};
  return sight_of(camera, framing, settings_.windowPolicy);
}

Value ViewSession::setting(const std::string& key) const {
  return loaded_->delegate()->GetRenderSetting(key);
}

void ViewSession::set_setting(const ParameterRow& row, const Value& value) {
  const Value typed = stored_value(row, value);
  loaded_->delegate()->SetRenderSetting(row.name, typed);
  changed_settings_[row.name] = typed;
  changed();
}

void ViewSession::reset_setting(const std::string& key) {
  loaded_->delegate()->SetRenderSetting(key, {});
  changed_settings_.erase(key);
  changed();
}

void ViewSession::apply_quality(const std::string& name) {
  const hd::description::QualityPreset* const preset = hd::description::FindQualityPreset(name);
  if (!preset) return;
  // Settings of another preset do not stay.
  for (const auto& other : hd::description::QualityPresets())
    for (const auto& [key, value] : other.settings) {
      loaded_->delegate()->SetRenderSetting(key, {});
      changed_settings_.erase(key);
    }
  for (const auto& [key, value] : preset->settings) {
    loaded_->delegate()->SetRenderSetting(key, value);
    changed_settings_[key] = value;
  }
  changed();
}

std::optional<std::string> ViewSession::quality() const {
  std::map<std::string, Value> changed;  // of the settings that presets have
  for (const auto& preset : hd::description::QualityPresets())
    for (const auto& [key, value] : preset.settings)
      if (const auto found = changed_settings_.find(key); found != changed_settings_.end()) changed.insert(*found);
  if (changed.empty()) return "";
  for (const auto& preset : hd::description::QualityPresets())
    if (std::equal(changed.begin(), changed.end(), preset.settings.begin(), preset.settings.end())) return preset.name;
  return std::nullopt;
}

std::optional<Picked> ViewSession::pick(double x, double y) {
  const Vec2i pixel(std::clamp(int(x * size_.x), 0, size_.x - 1), std::clamp(int(y * size_.y), 0, size_.y - 1));
  const auto hits =
      hd::host::Pick(*loaded_->index(), loaded_->scene, state_, {pixel.x, pixel.y, pixel.x + 1, pixel.y + 1});
  if (hits.empty()) return std::nullopt;
  Picked picked{hits[0], {}, {(pixel.x + 0.5) / size_.x, (pixel.y + 0.5) / size_.y}};
  const auto* mesh = hd::host::FindPrim<hd::host::MeshDescription>(loaded_->scene.GetPrims(), picked.hit.path);
  if (!mesh) return picked;
  picked.material = mesh->material;
  for (const hd::GeomSubset& subset : mesh->topology.geomSubsets)
    if (std::find(subset.indices.begin(), subset.indices.end(), picked.hit.face) != subset.indices.end())
      picked.material = subset.materialId;
  return picked;
}

std::optional<double> ViewSession::depth_at(double x, double y) {
  const std::vector<float> depth = depths_.values(buffer("cameraDepth"), x, y);
  if (depth.empty() || !(depth[0] > 0) || depth[0] > 1e30f) return std::nullopt;
  return double(depth[0]);
}

hd::Path ViewSession::add_light(const std::string& type, double x, double y) {
  const Vec3d target = point_at(camera_.transform, sight(), x, y, depth_at(x, y).value_or(scene_size_));
  const Path path = edits_.add_light(new_light(type, camera_.transform, target, up()));
  changed();
  return path;
}

bool ViewSession::read_surface() {
  return depths_.read(buffer("cameraDepth")) && normals_.read(buffer("normal"));
}

std::optional<SurfacePoint> ViewSession::surface_at(double x, double y) const {
  const std::vector<float> depth = depths_.values(x, y), normal = normals_.values(x, y);
  if (depth.empty() || normal.size() < 3 || !(depth[0] > 0) || depth[0] > 1e30f) return std::nullopt;
  SurfacePoint surface{point_at(camera_.transform, sight(), x, y, double(depth[0])),
                       Vec3d(double(normal[0]), double(normal[1]), double(normal[2]))};
  if (!(surface.normal.length() > 0.1)) return std::nullopt;  // of pixels that are mostly background
  surface.normal.normalize();
  return surface;
}

Vec3d ViewSession::to_eye(const Vec3d& point) const {
  const Matrix4d& m = camera_.transform;
  return (sight().orthographic ? Vec3d(m[2][0], m[2][1], m[2][2]) : m.translation() - point).normalized();
}

std::vector<float> ViewSession::values_at(double x, double y) {
  const bool on_left = is_divided() && x < divider_;
  return values_.values((on_left || !is_divided() ? left() : right()).buffer, x, y);
}

PictureRequest ViewSession::request(const std::string& aov) const {
  PictureRequest r;
  r.buffer = buffer(aov);
  if (stand_in_ && aov == stand_in_->layer) r.buffer = stand_in_->picture.get(), r.kept = stand_in_->picture;
  r.kind = data_kind(aov);
  r.display = display_;
  r.version = display_version_;
  return r;
}

std::string ViewSession::shown_aov() const {
  return compare_ == Compare::denoised && aov_ == "color" ? "denoised" : aov_;
}

PictureRequest ViewSession::left() const {
  PictureRequest r = request(shown_aov());
  if (kept_) r.buffer = kept_->picture.get(), r.kept = kept_->picture, r.kind = data_kind(kept_->aov);
  return r;
}

PictureRequest ViewSession::right() const {
  return !is_divided() ? PictureRequest() : request(kept_ ? shown_aov() : "denoised");
}

// True, and reported, if the file is one of the scene's.
bool ViewSession::is_input(const std::string& file, const std::string& scene_file) const {
  const std::string problem = cli::input_overwritten({file}, *loaded_, scene_file);
  if (!problem.empty()) sink_({hd::Severity::error, "view.input", file, problem});
  return !problem.empty();
}

bool ViewSession::save_picture(const std::string& file, const std::string& scene_file) {
  if (is_input(file, scene_file)) return false;
  hd::RenderProduct product;
  product.file = file;
  product.display = display_name_, product.view = view_name_, product.exposure = exposure_;
  if (compare_ != Compare::rendered) product.denoise = true;
  if (file.ends_with(".exr")) {
    product.display.clear(), product.view.clear(), product.exposure = 0;
    product.vars = {hd::host::UsualRenderVar("color")};
    if (aov_ != "color") product.vars.push_back(hd::host::UsualRenderVar(aov_));
  }
  return hd::host::WriteSnapshot(*loaded_->delegate(), *pass_, state_, product, loaded_->colors(), sink_);
}

bool ViewSession::save_description(const std::string& file, const std::string& scene_file) {
  ViewChanges changes;
  changes.scene = &loaded_->scene, changes.loaded = &loaded_->file, changes.scene_file = scene_file;
  changes.options = loaded_->options(), changes.ocio = loaded_->colors().ocio;
  const EditRecord made = edits_.made();
  changes.materials = made.materials, changes.lights = made.lights;
  changes.settings = changed_settings_;
  const bool was_denoised = number_in(settings_.settings, "denoise") != 0;
  const bool is_denoised = compare_ != Compare::rendered;
  if (is_denoised != was_denoised) changes.settings["denoise"] = is_denoised;
  changes.is_input = [&](const std::string& output) { return is_input(output, scene_file); };
  if (loaded_->file.framed || !(camera_ == first_camera_)) changes.camera = camera_;
  return WriteDescription(changes, file, sink_);
}

}  // namespace alabaster::view
