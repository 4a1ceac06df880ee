#include "delegate/rendering/render_pass.h"

#include <algorithm>
#include <chrono>
#include <utility>

#include "core/denoise/denoise_film.h"
#include "core/session/frame_memory.h"
#include "delegate/prims/prims.h"
#include "delegate/rendering/pixel_format.h"
#include "delegate/support/nearest_name.h"
#include "delegate/support/size_text.h"

namespace alabaster::hd::rendering {

namespace {
constexpr const char* kFreeCamera = "free camera";  // in reports

// Of the film. Shadow catchers give alpha, which is always there, what AOV shadow needs.
AovSet aovs_of(const PassInputs& in) {
  AovSet aovs = 0;
  for (const auto& binding : in.bindings) aovs |= aov_bit(binding.aov);
  if (aovs && in.scene && !in.shows_checkpoint && in.scene->features.shadow_catchers) aovs |= aov_bit(Aov::shadow);
  return aovs;
}

// The memory of the session for a frame of these inputs, that of the denoiser, and each bound buffer twice: as shown
// and as being resolved (or as the host's copy). `more`: AOVs of the film besides those that are bound.
size_t bytes_of(const PassInputs& in, AovSet more = 0) {
  constexpr double kMost = 0x1p60;
  const AovSet aovs = with_guides(aovs_of(in)) | more;
  double bytes = 0;
  for (const auto& binding : in.bindings) {
    const RenderBufferDescriptor buffer = binding.buffer->wanted();
    bytes += 2.0 * buffer.dimensions.x * buffer.dimensions.y * static_cast<double>(FormatSize(buffer.format));
  }
  if (aovs && in.denoiser) bytes += denoise_bytes(in.framed.data_window);
  if (aovs) bytes += static_cast<double>(frame_bytes(in.framed.data_window, aovs, in.settings, in.light_groups.size()));
  return static_cast<size_t>(std::min(bytes, kMost));
}

std::string frame_text(const PassInputs& in) {
  return "a frame of " + support::size_text(in.framed.data_window.width(), in.framed.data_window.height()) + " pixels";
}

RenderRequest request_of(const PassInputs& in) {
  RenderRequest request;
  request.scene = in.shows_checkpoint ? nullptr : in.scene;
  request.camera = in.framed.camera;
  request.width = in.framed.width;
  request.height = in.framed.height;
  request.data_window = in.framed.data_window;
  request.settings = in.settings;
  request.aovs = aovs_of(in);
  request.primvars = in.primvars;
  request.light_groups = in.light_groups;
  request.denoiser = in.denoiser;
  return request;
}

// A part of a frame's samples has no samples of others that could decide where its own go.
std::string part_fault(const RenderSettings& s) {
  if (s.first_sample == 0) return {};
  if (s.first_sample >= s.samples)
    return "firstSample is " + std::to_string(s.first_sample) + ", but must be below samples, " +
           std::to_string(s.samples);
  const char* const decides = s.target_error > 0 ? "targetError"
                              : s.adaptive       ? "adaptive"
                              : s.time_limit > 0 ? "timeLimit"
                                                 : nullptr;
  if (!decides) return {};
  return std::string("firstSample cannot be given with ") + decides +
         ", which decides from all samples of a frame how many there are: render it in one";
}

// The AOV of that name and its plane; one of a primvar takes the first free place. Nothing: there is none, or no place
// is left.
std::optional<std::pair<Aov, int>> aov_of(const std::string& name, const std::vector<std::string>& light_groups,
                                          std::vector<UvSetName>* primvars) {
  const AovInfo* const known = find_aov(name);
  if (!known) return std::nullopt;
  if (is_light_group(name)) {
    const auto group = std::find(light_groups.begin(), light_groups.end(), light_group_of_aov(name));
    if (group == light_groups.end()) return std::nullopt;
    return std::pair(known->aov, static_cast<int>(group - light_groups.begin()));
  }
  if (!is_primvar(known->aov)) return std::pair(known->aov, rank_pair(name).number);
  const std::string primvar(primvar_of_aov(name));
  const auto held =
      std::find_if(primvars->begin(), primvars->end(), [&](const UvSetName& other) { return other.text() == primvar; });
  const auto place = static_cast<size_t>(held - primvars->begin());
  if (place == kMostPrimvarAovs) return std::nullopt;
  if (held == primvars->end()) primvars->emplace_back(primvar);
  return std::pair(primvar_aov(place), 0);
}

std::vector<std::string> supported_aovs() {
  std::vector<std::string> names;
  for (const AovInfo& aov : kAovs) names.emplace_back(aov.name);
  return names;
}

// Those that the bindings name, in order.
std::vector<std::string> light_groups_of(const RenderPassState& state) {
  std::set<std::string> names;
  for (const AovBinding& binding : state.aovBindings)
    if (const std::string& name = binding.aovName.str(); is_light_group(name)) names.emplace(light_group_of_aov(name));
  std::vector<std::string> all(names.begin(), names.end());
  if (all.size() > kMostLightGroups) all.resize(kMostLightGroups);
  return all;
}

// Empty: AOV `name` is drawn as asked.
std::string light_group_fault(const std::string& name, const std::vector<std::string>& groups) {
  const std::string group(light_group_of_aov(name));
  if (group.empty() || std::binary_search(groups.begin(), groups.end(), group)) return {};
  return "no light or mesh has lightGroup '" + group + "', and the AOV is black" + support::DidYouMean(group, groups);
}

// The data window must lie in the buffer, which may be larger. Empty: it does.
std::string size_fault(const Framing& framing, const RenderBufferDescriptor& buffer) {
  const Rect2i& window = framing.dataWindow;
  const Vec3i& size = buffer.dimensions;
  if (window.empty() || (window.minX >= 0 && window.minY >= 0 && window.maxX <= size.x && window.maxY <= size.y))
    return {};
  const bool is_moved = window.minX != 0 || window.minY != 0;
  return "has " + support::size_text(size.x, size.y) + " pixels, but the frame has " +
         support::size_text(window.width(), window.height()) +
         (is_moved ? " from pixel (" + std::to_string(window.minX) + ", " + std::to_string(window.minY) + ")" : "") +
         ": the part outside of the buffer is not shown; allocate the buffer in the size of the frame";
}

// Those of the bindings. Null: no buffer of this delegate is bound.
std::vector<std::shared_ptr<BufferState>> buffers_of(const RenderPassState& state) {
  std::vector<std::shared_ptr<BufferState>> buffers;
  for (const AovBinding& binding : state.aovBindings) {
    const auto* buffer = dynamic_cast<const RenderBufferPrim*>(binding.renderBuffer);
    buffers.push_back(buffer ? buffer->state() : nullptr);
  }
  return buffers;
}

// Those that the bindings name.
std::vector<Token> primvars_of(const RenderPassState& state) {
  std::vector<Token> names;
  for (const AovBinding& binding : state.aovBindings)
    if (const auto primvar = primvar_of_aov(binding.aovName.str()); !primvar.empty()) names.emplace_back(primvar);
  return names;
}

bool shows_motion(const RenderPassState& state) {
  return std::any_of(state.aovBindings.begin(), state.aovBindings.end(),
                     [](const AovBinding& binding) { return binding.aovName == Token(aov_info(Aov::motion).name); });
}

}  // namespace

// Buffers keep the session longer than the pass, but stopped.
PassControl::PassControl(std::shared_ptr<DelegateState> delegate)
    : delegate_(std::move(delegate)), frame_memory_(delegate_->param->memory(), MemoryUse::frames) {
  SessionOwner owner;
  owner.released = [held = delegate_.get()] { held->release_retired(); };
  owner.notifier = delegate_->notifier();
  session_ = std::make_shared<RenderSession>(std::move(owner));
}

std::optional<CameraParameters> PassControl::camera_of(const RenderPassState& state, const Path& path,
                                                       const prims::Translation* scene) const {
  const Shutter shutter = scene ? scene->shutter : Shutter();
  const prims::MotionTime motion = scene && shows_motion(state) ? scene->motion : std::nullopt;
  return state.freeCamera ? prims::posed_camera(free_record_, shutter, motion)
                          : delegate_->camera(path, shutter, motion);
}

void PassControl::add_bindings(const DrawRequest& asked, bool waits, PassInputs* in,
                               std::vector<alabaster::Diagnostic>* faults) {
  const auto shown = delegate_->checkpoints.shown_names();
  // Of what a scene lacks that is on its way, or a checkpoint's, nothing is known.
  const SceneSnapshot* const known = waits || shown ? nullptr : in->scene.get();
  in->light_groups = shown ? shown->light_groups : light_groups_of(asked.state);
  for (size_t i = 0; i < asked.buffers.size(); ++i) {
    const AovBinding& binding = asked.state.aovBindings[i];
    const std::shared_ptr<BufferState>& buffer = asked.buffers[i];
    const std::string& name = binding.aovName.str();
    const auto aov = buffer ? aov_of(name, in->light_groups, &in->primvars) : std::nullopt;
    if (!aov) {
      if (shown && is_light_group(name)) in->error = "the checkpoints have no AOV '" + name + "'";
      faults->push_back({alabaster::Severity::warning, "pass.binding", name,
                         !buffer                ? "no buffer of this delegate is bound; the AOV is not drawn"
                         : is_light_group(name) ? "a frame shows " + std::to_string(kMostLightGroups) +
                                                      " light groups at most; this is not drawn"
                         : find_aov(name) ? "a frame shows " + std::to_string(kMostPrimvarAovs) +
                                                " primvars at most; this is not drawn"
                                          : "the renderer has no such AOV, and its buffer is not drawn" +
                                                support::DidYouMean(name, supported_aovs())});
      continue;
    }
    const Value clear =
        binding.clearValue.empty() ? default_aov_descriptor(binding.aovName).clearValue : binding.clearValue;
    in->bindings.push_back({aov->first, buffer, buffer->allocation(), clear, aov->second});
    if (known && is_light_group(name))
      if (const std::string fault = light_group_fault(name, known->light_groups); !fault.empty())
        faults->push_back({alabaster::Severity::warning, "pass.lightGroup", name, fault});
    if (known && aov->first == Aov::shadow && !known->features.shadow_catchers)
      faults->push_back(
          {alabaster::Severity::warning, "pass.shadow", name, "no mesh is a shadowCatcher, and the AOV is black"});
    if (const std::string fault = size_fault(asked.state.framing, buffer->wanted()); !fault.empty())
      faults->push_back(
          {alabaster::Severity::warning, "pass.size", buffer->id().str(), "the buffer of AOV '" + name + "' " + fault});
  }
}

PassInputs PassControl::inputs(const DrawRequest& asked, const BuiltScene* scene, bool waits,
                               std::vector<alabaster::Diagnostic>* faults) {
  PassInputs in;
  const RenderPassState& state = asked.state;
  if (scene) in.scene = scene->snapshot;
  in.settings = delegate_->render_settings();
  // A picture depends on these by its scene alone.
  in.settings.texture_memory = {};
  in.settings.memory_limit = {};
  in.settings.refine_edge_length = {};
  in.settings.crypto_ranks = {};  // of files alone
  in.restarts = delegate_->restarts();
  add_bindings(asked, waits, &in, faults);
  const Path camera = state.freeCamera       ? Path(kFreeCamera)
                      : state.camera.empty() ? delegate_->settings_camera()
                                             : state.camera;
  const std::optional<CameraParameters> parameters = camera_of(state, camera, scene ? &scene->translation : nullptr);
  in.shows_checkpoint = delegate_->checkpoints.is_shown();
  if (in.shows_checkpoint)
    in.framed = frame_camera(CameraParameters(), state.framing, state.windowPolicy);
  else if (!in.scene)
    in.error = delegate_->commit_error(in.scene.get());
  else if (!parameters)
    in.error = camera.empty() ? "no camera is named: name one for the pass or in the render settings"
                              : "camera " + camera.str() + " does not exist" + delegate_->nearest_camera(camera);
  else if (!is_valid_affine(parameters->camera_to_world))
    in.error = "the transform of camera " + camera.str() + " is not finite or not invertible";
  else if (const std::string fault = framing_fault(state.framing); !fault.empty())
    in.error = fault;
  else if (state.framing.valid())
    in.framed = frame_camera(*parameters, state.framing, state.windowPolicy);
  in.refused = in.scene && !in.error.empty();
  if (in.error.empty() && !(in.error = part_fault(in.settings)).empty()) in.refused = true;
  if (in.error.empty()) choose_denoiser(&in);
  if (in.error.empty() && (in.scene || in.shows_checkpoint) &&
      !(in.error = delegate_->checkpoints.fault(*delegate_, scene, request_of(in))).empty())
    in.refused = true;
  if (in.error.empty()) {
    // Linux grants memory that it does not have and ends the process that uses it, without a report.
    const size_t needed = bytes_of(in), held = frame_memory_.bytes();
    const MemoryBudget& memory = *delegate_->param->memory();
    if (needed > held && needed - held > memory.left())
      in.error = memory.refusal(MemoryUse::frames, needed - held, frame_text(in));
  }
  if (!in.error.empty()) faults->push_back({alabaster::Severity::error, "pass.failed", camera.str(), in.error});
  return in;
}

// With setting `denoise`, a host that knows nothing of AOV `denoised` sees it as color.
void PassControl::choose_denoiser(PassInputs* in) {
  const auto shows = [&](Aov aov) {
    return std::any_of(in->bindings.begin(), in->bindings.end(), [&](const auto& b) { return b.aov == aov; });
  };
  if (in->settings.denoise && !shows(Aov::denoised))
    for (PassInputs::Binding& binding : in->bindings)
      if (binding.aov == Aov::color) binding.aov = Aov::denoised;
  if (shows(Aov::denoised)) in->denoiser = delegate_->denoiser(&in->error);
}

void PassControl::set_converged(bool converged) {
  for (const auto& binding : running_.bindings) binding.buffer->set_converged(converged);
  converged_ = converged;
}

// A failure converges: a host that waits for the frame must not wait without end.
void PassControl::fail(std::string error) {
  {
    const std::lock_guard lock(error_mutex_);
    error_ = std::move(error);
  }
  failed_ = true;
  set_converged(true);
}

void PassControl::note_start() {
  const std::lock_guard lock(error_mutex_);
  error_.clear();
  const bool has_camera = running_.error.empty() && !running_.shows_checkpoint && running_.framed.width > 0;
  camera_ = has_camera ? std::optional(running_.framed.camera) : std::nullopt;
}

// The render before this one ends in the session's thread. If no render follows, it is stopped here.
void PassControl::start(PassInputs next) {
  set_converged(false);
  const bool first = !active_;
  running_ = std::move(next);
  active_ = true;
  cancelled_ = false;
  failed_ = false;
  refused_ = running_.refused;
  finish_seen_ = false;
  note_start();
  set_converged(false);
  const bool is_empty = running_.bindings.empty() || running_.framed.data_window.empty() || running_.framed.width <= 0;
  if (is_empty || !running_.error.empty()) session_->stop();
  if (!running_.error.empty()) return fail(running_.error);
  frame_memory_.resize(std::max(frame_memory_.bytes(), bytes_of(running_)), frame_text(running_));
  if (is_empty) return set_converged(true);  // nothing to draw

  RenderRequest request = request_of(running_);
  std::shared_ptr<const IdKeys> keys;
  if (request.aovs & (kMaterialIdAovs | kIdsAovs)) {
    auto names = delegate_->checkpoints.shown_names();
    if (!names) names = delegate_->names_of(*scene());
    request.memory = delegate_->param->memory();
    request.materials = names->numbers;
    request.mattes = names->mattes;
    keys = names->keys;
  }
  delegate_->set_last_request(request, weak_from_this());
  request.resumed = delegate_->checkpoints.take();
  for (const auto& binding : running_.bindings) binding.buffer->release_film();
  session_->start(request);
  // A film that another render or a checkpoint leaves may have more AOVs: its memory is held already.
  frame_memory_.try_resize(bytes_of(running_, session_->film()->aovs()));
  for (const auto& binding : running_.bindings) {
    BufferSource source{session_->film(), binding.aov, running_.framed.buffer_x, running_.framed.buffer_y,
                        binding.clear};
    source.keys = keys, source.plane = binding.plane;
    if (binding.aov == Aov::denoised)
      source.complete = [session = session_, film = source.film.get()] { session->denoise_stopped(film); };
    binding.buffer->bind(std::move(source));
  }
  // A pause from before the first render holds it; a later restart ends the pause.
  if (delegate_->is_paused() && first)
    session_->pause();
  else
    delegate_->end_pause();
}

void PassControl::update(PassInputs next, bool building, std::vector<alabaster::Diagnostic>* faults) {
  const std::lock_guard lock(control_);
  if (delegate_->is_stopped()) return;
  picture_stale_ = building;
  if (!active_ || cancelled_ || running_ != next) return start(std::move(next));
  const RenderProgress progress = session_->progress();
  if (building) return;
  if (failed_ || converged_) return set_converged(converged_);
  if (progress.state == SessionState::failed) {
    faults->push_back({alabaster::Severity::error, "pass.failed", "render", progress.error});
    return fail(progress.error);
  }
  if (progress.state != SessionState::finished) return;
  // The final pixels can be resolved from now on. Convergence is reported one Execute later, when a host that resolves
  // before it asks has seen them.
  if (finish_seen_) return set_converged(true);
  finish_seen_ = true;
}

// Reads the free camera again only if it differs.
void PassControl::set_view(const RenderPassState& state) {
  if (state.freeCamera && state.freeCamera != free_camera_)
    free_record_ = prims::record_of(*state.freeCamera, kFreeCamera, delegate_->param->sink(), &free_faults_);
  free_camera_ = state.freeCamera;
  PassView now{support::Selection(state.renderTags, state.collection), std::nullopt, primvars_of(state),
               shows_motion(state)};
  if (state.freeCamera) now.shutter = free_record_.shutter();
  const std::lock_guard lock(view_mutex_);
  delegate_->note_executed(now.selection, view_ != now);
  view_ = std::move(now);
}

std::optional<PassView> PassControl::view() const {
  const std::lock_guard lock(view_mutex_);
  return view_;
}

std::shared_ptr<const BuiltScene> PassControl::scene() const {
  const std::lock_guard lock(view_mutex_);
  return scene_;
}

void PassControl::execute(const RenderPassState& state) {
  const std::lock_guard lock(executing_);
  set_view(state);
  if (delegate_->needs_commit() && !delegate_->is_stopped()) delegate_->commit();
  draw({state, buffers_of(state)});
}

bool PassControl::start_deferred() {
  const std::lock_guard lock(executing_);
  if (deferred_ && !delegate_->is_building() && !delegate_->is_stopped()) {
    const std::optional<DrawRequest> asked = std::exchange(deferred_, std::nullopt);
    draw(*asked);
  }
  return !deferred_;
}

void PassControl::retire() {
  const std::lock_guard lock(executing_);
  deferred_.reset();
}

void PassControl::draw(const DrawRequest& asked) {
  executed_ = true;
  deferred_.reset();
  const bool building = delegate_->is_building();  // asked before the scene is taken
  const support::Selection selection = view()->selection;
  auto scene = delegate_->scene(selection);
  const bool waits = scene ? building && !delegate_->is_current(*scene)
                           : building || !(delegate_->has_failed(selection) || delegate_->is_stopped());
  if (waits) {
    deferred_ = asked;
    if (!building) delegate_->build_for(selection);
    if (!scene || delegate_->checkpoints.is_pending()) return expect_new_scene();
  }
  std::vector<alabaster::Diagnostic> faults;
  PassInputs next = inputs(asked, scene.get(), waits, &faults);
  {
    const std::lock_guard lock(view_mutex_);
    scene_.swap(scene);
  }
  scene.reset();  // the old one, which the builder may destroy once the session has let go of it
  update(std::move(next), waits, &faults);
  std::vector<std::pair<std::string, std::string>> now;
  for (const auto& fault : faults) {
    now.emplace_back(fault.where, fault.text);
    const bool known = std::find(reported_.begin(), reported_.end(), now.back()) != reported_.end();
    if (!known) alabaster::report(delegate_->param->sink(), fault.severity, fault.code, fault.where, fault.text);
  }
  reported_ = std::move(now);
}

void PassControl::abandon() {
  retire();
  const std::lock_guard lock(control_);
  session_->stop();
  cancelled_ = true;
  fail("the render could not be started");
}

void PassControl::stop() {
  const std::lock_guard lock(control_);
  session_->stop();
}

void PassControl::invalidate() {
  const std::lock_guard lock(control_);
  session_->stop();
  cancelled_ = true;
  set_converged(false);
}

void PassControl::pause() {
  const std::lock_guard lock(control_);
  session_->pause();
}

void PassControl::resume() {
  const std::lock_guard lock(control_);
  session_->resume();
}

void PassControl::expect_new_scene() {
  const std::lock_guard lock(control_);
  picture_stale_ = true;
  for (const auto& binding : running_.bindings) binding.buffer->set_converged(false);
}

bool PassControl::wait(double seconds) {
  const auto start = std::chrono::steady_clock::now();
  const auto left = [&] {
    return seconds - std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  };
  if (delegate_->is_building() && !delegate_->wait_for_build(seconds) && !delegate_->is_stopped()) return false;
  while (!start_deferred() && !delegate_->is_stopped())  // the scene of another pass came first
    if (!delegate_->wait_for_build(left()) && !delegate_->is_stopped()) return false;
  if (!active_ || failed_ || is_converged()) return true;
  if (!session_->wait(left())) return false;
  const std::string failure = see_end();
  if (!failure.empty())
    alabaster::report(delegate_->param->sink(), alabaster::Severity::error, "pass.failed", "render", failure);
  return true;
}

std::string PassControl::see_end() {
  const std::lock_guard lock(control_);
  if (!active_ || picture_stale_ || cancelled_) return {};
  const RenderProgress progress = session_->progress();
  if (progress.state == SessionState::finished) finish_seen_ = true;
  if (progress.state != SessionState::failed || failed_) return {};
  fail(progress.error);
  return progress.error;
}

PassState PassControl::state() const {
  if (delegate_->is_stopped()) return PassState::stopped;
  if (executed_ && picture_stale_) return PassState::preparing;
  if (failed_) return PassState::failed;
  if (converged_) return PassState::converged;
  if (!active_) return PassState::idle;
  if (cancelled_) return PassState::stopped;  // until the next Execute, whatever Restart has done
  switch (session_->progress().state) {
    case SessionState::paused:
      return PassState::paused;
    case SessionState::idle:
      return PassState::preparing;
    case SessionState::stopped:
      return PassState::stopped;
    case SessionState::failed:
      return PassState::failed;
    case SessionState::rendering:
    case SessionState::finished:
      return PassState::rendering;
  }
  return PassState::idle;
}

std::string PassControl::error() const {
  const std::lock_guard lock(error_mutex_);
  return error_;
}

std::optional<CameraParameters> PassControl::camera() const {
  const std::lock_guard lock(error_mutex_);
  return camera_;
}

size_t PassControl::film_memory() const {
  const std::shared_ptr<const Film> film = session_->film();
  return film ? film_bytes(film->data_window(), film->aovs(), film->extras()) : 0;
}

RenderPassImpl::RenderPassImpl(std::shared_ptr<DelegateState> delegate)
    : delegate_(std::move(delegate)), control_(std::make_shared<PassControl>(delegate_)) {
  delegate_->add_pass(control_);
}

RenderPassImpl::~RenderPassImpl() {
  prims::guarded(delegate_->param->sink(), "render pass", [&] {
    control_->retire();
    control_->stop();
    delegate_->keep_stats_of_last_pass(pass_stats(*control_));
  });
}

void RenderPassImpl::Execute(const RenderPassState& state) {
  const auto& sink = delegate_->param->sink();
  if (!prims::guarded(sink, "render pass", [&] { control_->execute(state); }))
    prims::guarded(sink, "render pass", [&] { control_->abandon(); });
}

PassState RenderPassImpl::GetState() const {
  PassState state = PassState::failed;
  prims::guarded(delegate_->param->sink(), "render pass", [&] { state = control_->state(); });
  return state;
}

bool RenderPassImpl::WaitForConvergence(double seconds) {
  bool over = false;
  prims::guarded(delegate_->param->sink(), "render pass", [&] { over = control_->wait(seconds); });
  return over;
}

}  // namespace alabaster::hd::rendering
