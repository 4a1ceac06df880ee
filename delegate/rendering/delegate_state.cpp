#include "delegate/rendering/delegate_state.h"

#include <algorithm>
#include <chrono>
#include <limits>

#include "delegate/prims/parameters.h"
#include "delegate/rendering/render_pass.h"
#include "delegate/support/nearest_name.h"
#include "delegate/support/parameters.h"

namespace alabaster::hd::rendering {
namespace {

const SettingParameter* find_setting(const Token& key) {
  const auto table = setting_parameters();
  const auto found = std::find_if(table.begin(), table.end(), [&](const auto& p) { return key.str() == p.name; });
  return found == table.end() ? nullptr : &*found;
}

constexpr double kUnlimited = std::numeric_limits<double>::infinity();

}  // namespace

DelegateState::DelegateState(std::shared_ptr<prims::SceneParam> scene_param, const Dictionary& initial_settings)
    : param(std::move(scene_param)),
      builder_(param, {[this] { drop_old_request(); }, [this] { start_deferred_passes(); }}) {
  set_settings(initial_settings);
}

// The host's thread alone changes settings. All that may throw comes before the swap, or takes it back.
void DelegateState::set_settings(const Dictionary& given) {
  std::map<Token, Value> next = settings_;
  uint32_t changes = 0;
  bool views = false;
  for (const auto& [name, value] : given) {
    const Token key(name);
    const auto held = next.find(key);
    if (held == next.end() ? value.empty() : held->second == value) continue;
    if (value.empty())
      next.erase(held);
    else
      next.insert_or_assign(key, value);
    ++changes;
    const SettingParameter* parameter = find_setting(key);
    RenderSettings unused;
    if (parameter && !value.empty())
      prims::report_fault(param->sink(), "render settings", name, support::set_parameter(*parameter, value, &unused),
                          value);
    views |= name == "refineEdgeLength" || name == "motionShutter" || name == "renderSettingsPrimPath";
  }
  const auto exchange = [&](uint32_t change) {
    const std::lock_guard lock(mutex_);
    settings_.swap(next);
    settings_version_ += change;
  };
  if (changes == 0) return;
  exchange(changes);
  try {
    apply_services();
  } catch (...) {
    exchange(0u - changes);
    throw;
  }
  if (views) wanted_changed_ = true;
}

// Threads and memory take effect at once, all or none: the limit alone may throw, before it is set.
void DelegateState::apply_services() {
  const RenderSettings settings = render_settings();
  param->set_memory_limit(settings.memory_limit);
  param->set_threads(settings.threads);
  param->set_texture_memory(settings.texture_memory);
}

void DelegateState::take_up_settings() {
  split_edits();
  views_changed_ = true;
  apply_services();
}

Value DelegateState::setting(const Token& key) const {
  {
    const std::lock_guard lock(mutex_);
    const auto held = settings_.find(key);
    if (held != settings_.end()) return held->second;
  }
  const SettingParameter* parameter = find_setting(key);
  return parameter ? support::get_parameter(*parameter, render_settings()) : Value();
}

uint32_t DelegateState::settings_version() const {
  const std::lock_guard lock(mutex_);
  return settings_version_;
}

// The prim that setting "renderSettingsPrimPath" names, else the first by path.
const prims::SettingsRecord* DelegateState::settings_prim() const {
  if (const auto held = settings_.find("renderSettingsPrimPath"); held != settings_.end())
    if (const Path named(held->second.text_or("")); !named.empty()) {
      return prims::find_record<prims::SettingsRecord>(cameras_and_settings_, named);
    }
  for (const auto& [path, record] : cameras_and_settings_)
    if (const auto* settings = std::any_cast<prims::SettingsRecord>(&record)) return settings;
  return nullptr;
}

RenderSettings DelegateState::render_settings() const {
  RenderSettings out;
  const std::lock_guard lock(mutex_);
  const prims::SettingsRecord* prim = settings_prim();
  for (const SettingParameter& parameter : setting_parameters()) {
    if (prim) {
      if (Token("frame") == Token(parameter.name)) support::set_parameter(parameter, prim->settings.frame, &out);
      const auto value = prim->settings.settings.find(parameter.name);
      if (value != prim->settings.settings.end()) support::set_parameter(parameter, value->second, &out);
    }
    const auto value = settings_.find(parameter.name);
    if (value != settings_.end()) support::set_parameter(parameter, value->second, &out);
  }
  return out;
}

Path DelegateState::settings_camera() const {
  const std::lock_guard lock(mutex_);
  const prims::SettingsRecord* prim = settings_prim();
  return prim ? prim->settings.camera : Path();
}

std::optional<CameraParameters> DelegateState::camera(const Path& path, const Shutter& of_scene,
                                                      const prims::MotionTime& motion) const {
  const std::lock_guard lock(mutex_);
  const auto* record = prims::find_record<prims::CameraRecord>(cameras_and_settings_, path);
  if (!record) return std::nullopt;
  return prims::posed_camera(*record, of_scene, motion);
}

std::string DelegateState::nearest_camera(const Path& path) const {
  std::vector<std::string> known;
  const std::lock_guard lock(mutex_);
  for (const auto& [name, record] : cameras_and_settings_)
    if (std::any_cast<prims::CameraRecord>(&record)) known.push_back(name.str());
  return support::DidYouMean(path.str(), known);
}

void DelegateState::set_last_request(const RenderRequest& request, std::weak_ptr<PassControl> pass) {
  auto last = std::make_shared<const RenderRequest>(request);
  const std::lock_guard lock(mutex_);
  last_request_.swap(last);
  last_pass_ = std::move(pass);
}

std::shared_ptr<PassControl> DelegateState::last_pass() const {
  const std::lock_guard lock(mutex_);
  return last_pass_.lock();
}

// If its scene is no longer one of those that passes draw.
void DelegateState::drop_old_request() {
  std::shared_ptr<const RenderRequest> last;
  {
    const std::lock_guard lock(mutex_);
    last = last_request_;
  }
  if (!last || scene(last->scene)) return;
  const std::lock_guard lock(mutex_);
  if (last_request_ == last) last_request_.reset();
}

// Passes whose Execute came before the scene was there. On the builder's thread, before a stop returns.
void DelegateState::start_deferred_passes() noexcept {
  prims::guarded(param->sink(), "render pass", [&] {
    for (const auto& pass : passes())
      if (!prims::guarded(param->sink(), "render pass", [&] { pass->start_deferred(); })) pass->abandon();
  });
}

std::shared_ptr<const RenderRequest> DelegateState::last_request() const {
  std::shared_ptr<const RenderRequest> last;
  {
    const std::lock_guard lock(mutex_);
    last = last_request_;
  }
  return last && scene(last->scene) ? last : nullptr;
}

std::shared_ptr<const Denoiser> DelegateState::denoiser(std::string* problem) {
  const std::lock_guard lock(denoiser_mutex_);
  if (!denoiser_ && denoiser_problem_.empty()) denoiser_ = Denoiser::load(&denoiser_problem_);
  *problem = denoiser_problem_;
  return denoiser_;
}

// Takes up edits of cameras and settings prims, and leaves all others to the builder (scene_edits_). Memory may run out
// at any step: an edit leaves the list once it is applied whole. The record of a prim that is gone does not tell its
// kind.
void DelegateState::split_edits() {
  edits_.splice(edits_.end(), param->take_edits());
  while (!edits_.empty()) {
    prims::Edit& edit = edits_.front();
    bool is_own = prims::is_camera_or_settings(edit.record);
    {
      const std::lock_guard lock(mutex_);
      if (is_own)
        cameras_and_settings_[edit.id] = std::move(edit.record);
      else if (!edit.record.has_value())
        is_own = cameras_and_settings_.erase(edit.id) != 0;
    }
    if (is_own)
      edits_.pop_front();
    else
      scene_edits_.splice(scene_edits_.end(), edits_, edits_.begin());
  }
}

// Measured from the camera of the RenderSettings prim, in its picture.
prims::Dicing DelegateState::dicing(const Shutter& shutter) const {
  prims::Dicing out;
  out.edge_length = render_settings().refine_edge_length;
  if (out.edge_length == 0) return {};
  const std::optional<CameraParameters> seen_by = camera(settings_camera(), shutter);
  const std::lock_guard lock(mutex_);
  const prims::SettingsRecord* const prim = settings_prim();
  if (!prim || !seen_by) return {};
  out.camera = *seen_by;
  out.width = prim->settings.width, out.height = prim->settings.height;
  return out;
}

void DelegateState::note_executed(const support::Selection& selection, bool view_changed) {
  selection_ = selection;
  views_changed_ |= view_changed;
}

// As all passes together look at the scene, but for the selection.
SnapshotBuilder::View DelegateState::wanted_view() {
  SnapshotBuilder::View view;
  std::optional<Shutter> shutter;
  bool shows_motion = false;
  {
    const std::lock_guard lock(mutex_);
    shutter = prims::shutter_of(cameras_and_settings_);
  }
  for (const auto& pass : passes()) {
    const std::optional<PassView> seen = pass->view();
    if (!seen) continue;
    if (seen->shutter) shutter = shutter ? united(*shutter, *seen->shutter) : *seen->shutter;
    shown_primvars_.insert(seen->primvars.begin(), seen->primvars.end());
    shows_motion |= seen->shows_motion;
  }
  view.selection = selection_;
  view.version = version_;
  view.shutter = shutter.value_or(Shutter());
  if (shows_motion && render_settings().motion_shutter == MotionShutter::frame) view.motion = {0, 1};
  view.meshes = {dicing(view.shutter), {shown_primvars_.begin(), shown_primvars_.end()}};
  return view;
}

void DelegateState::hand_over() {
  split_edits();
  apply_services();
  const RenderSettings settings = render_settings();
  wanted_changed_ = false;
  views_changed_ = false;
  SnapshotBuilder::View view = wanted_view();
  if (settings.refine_edge_length > 0 && view.meshes.dicing == prims::Dicing())
    alabaster::report(param->sink(), alabaster::Severity::warning, "settings.refineEdgeLength", "render settings",
                      "refineEdgeLength needs a RenderSettings prim with a camera; refineLevel is used");
  if (scene_edits_.empty() && view_ == view && !builder_.has_failed()) return;
  const bool is_edited = !scene_edits_.empty() || !view_ || view_->shutter != view.shutter ||
                         view_->motion != view.motion || view_->meshes != view.meshes;
  view.version += is_edited ? 1 : 0;
  builder_.post(&scene_edits_, view);
  version_ = view.version;
  view_ = std::move(view);
  for (const auto& pass : passes()) {
    const std::optional<PassView> seen = pass->view();
    const auto shown = seen ? scene(seen->selection) : nullptr;
    if (!shown || !is_current(*shown)) pass->expect_new_scene();
  }
}

void DelegateState::commit() {
  const auto start = std::chrono::steady_clock::now();
  if (!needs_commit() && edits_.empty() && scene_edits_.empty() && !builder_.has_failed() && !commit_failed_) return;
  committed_ = true;
  const bool handed_over = prims::guarded(
      param->sink(), "CommitResources", [&] { hand_over(); }, prims::kEarlierStateIsKept);
  param->set_failed(&commit_failed_, !handed_over);
  failed_ = !handed_over;
  const std::chrono::duration<double> spent = std::chrono::steady_clock::now() - start;
  commit_seconds_ = commit_seconds_ + spent.count();
}

std::string DelegateState::dump() {
  builder_.wait(kUnlimited);
  const auto built = scene();
  const prims::Translation nothing;
  const std::lock_guard lock(mutex_);
  return prims::dump_scene(built ? built->translation : nothing, cameras_and_settings_);
}

std::string DelegateState::requirements() {
  builder_.wait(kUnlimited);
  const auto built = scene();
  return built ? prims::describe_requirements(*built->snapshot, built->translation) : std::string();
}

Dictionary DelegateState::names() {
  if (const auto shown = checkpoints.shown_names()) return prims::describe_names(*shown);
  builder_.wait(kUnlimited);
  const auto built = scene();
  return prims::describe_names(built ? *names_of(*built) : prims::IdNames());
}

std::shared_ptr<const prims::IdNames> DelegateState::names_of(const BuiltScene& scene) const {
  const std::lock_guard lock(names_mutex_);
  if (!names_ || named_version_ != scene.version || named_selection_ != scene.selection)
    names_ = std::make_shared<const prims::IdNames>(prims::name_ids(scene.translation));
  named_version_ = scene.version, named_selection_ = scene.selection;
  return names_;
}

// A pass keeps the scene that it draws while the builder makes those of others.
template <class IsWanted>
std::shared_ptr<const BuiltScene> DelegateState::find_scene(const IsWanted& is_wanted) const {
  for (const auto& pass : passes()) {
    auto drawn = pass->scene();
    if (drawn && is_current(*drawn) && is_wanted(*drawn)) return drawn;
  }
  auto built = builder_.built();
  return built && is_wanted(*built) ? built : nullptr;
}

std::shared_ptr<const BuiltScene> DelegateState::scene(const support::Selection& selection) const {
  return find_scene([&](const BuiltScene& scene) { return scene.selection == selection; });
}

std::shared_ptr<const BuiltScene> DelegateState::scene(const std::shared_ptr<const SceneSnapshot>& snapshot) const {
  return find_scene([&](const BuiltScene& scene) { return scene.snapshot == snapshot; });
}

std::shared_ptr<const BuiltScene> DelegateState::scene() const {
  const auto all = passes();
  for (auto pass = all.rbegin(); pass != all.rend(); ++pass)
    if (const auto view = (*pass)->view()) return scene(view->selection);
  return builder_.built();
}

std::shared_ptr<const SceneSnapshot> DelegateState::snapshot() const {
  const auto built = scene();
  return built ? built->snapshot : nullptr;
}

std::vector<std::string> DelegateState::scene_faults(bool* input) const {
  std::vector<std::string> texts;
  *input = true;
  const auto built = scene();
  if (std::string refusal = builder_.refusal(); !refusal.empty()) {
    texts.push_back(std::move(refusal));
    *input = false;
  }
  for (const auto& [prim, fault] : built ? built->faults : prims::SceneFaults())
    texts.push_back(prim.str() + ": " + fault);
  if (const int failed = param->failed() + (builder_.has_failed() && *input); failed > 0) {
    texts.push_back(std::to_string(failed) + " prims or commits failed, for want of memory or by the host's scene");
    *input = false;
  }
  if (param->has_lost_texels()) {
    texts.emplace_back("the temporary file of textures cannot be read: parts of textures are black");
    *input = false;
  }
  if (built) {
    const SceneSnapshot* const held = built->snapshot.get();
    for (const std::string& name : held->left_out) texts.push_back(name + ": could not be placed");
    texts.insert(texts.end(), held->faults.begin(), held->faults.end());
  }
  return texts;
}

std::string DelegateState::commit_error(const SceneSnapshot* snapshot) const {
  return has_failed() && !is_building() && !snapshot ? "the scene could not be built" : "";
}

void DelegateState::add_pass(const std::shared_ptr<PassControl>& pass) {
  const std::lock_guard lock(mutex_);
  std::erase_if(passes_, [](const auto& weak) { return weak.expired(); });
  passes_.push_back(pass);
}

std::vector<std::shared_ptr<PassControl>> DelegateState::passes() const {
  std::vector<std::shared_ptr<PassControl>> alive;
  const std::lock_guard lock(mutex_);
  for (const auto& weak : passes_)
    if (auto pass = weak.lock()) alive.push_back(std::move(pass));
  return alive;
}

void DelegateState::keep_stats_of_last_pass(Dictionary stats) {
  const std::lock_guard lock(mutex_);
  last_pass_stats_.swap(stats);
}

Dictionary DelegateState::stats_of_last_pass() const {
  const std::lock_guard lock(mutex_);
  return last_pass_stats_;
}

// Halts the passes, or has them start again once nothing stops them.
void DelegateState::apply_stops() {
  stopped_ = stop_latched_ || stop_holds_ > 0;
  builder_.set_stopped(stopped_);
  if (!stopped_) ++restarts_;
  for (const auto& pass : passes()) stopped_ ? pass->stop() : pass->invalidate();
}

void DelegateState::stop() {
  const std::lock_guard lock(stop_mutex_);
  stop_latched_ = true;
  apply_stops();
}

void DelegateState::restart() {
  const std::lock_guard lock(stop_mutex_);
  if (!stop_latched_) return;
  stop_latched_ = false;
  apply_stops();
}

void DelegateState::hold_stopped(int change) {
  const std::lock_guard lock(stop_mutex_);
  stop_holds_ += change;
  apply_stops();
}

void DelegateState::pause() {
  paused_ = true;
  for (const auto& pass : passes()) pass->pause();
}

void DelegateState::resume() {
  paused_ = false;
  for (const auto& pass : passes()) pass->resume();
}

}  // namespace alabaster::hd::rendering
