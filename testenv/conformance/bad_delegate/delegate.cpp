#include <dlfcn.h>

#include <cstdlib>
#include <ctime>
#include <sstream>

#include "testenv/conformance/bad_delegate/misbehaviour.h"

namespace bad {

bool is(const char* name) {
  static const std::set<std::string> chosen = [] {
    std::set<std::string> names;
    const char* list = std::getenv("CONFORMANCE_BAD");
    std::istringstream text(list ? list : "");
    for (std::string one; std::getline(text, one, ',');) names.insert(one);
    return names;
  }();
  return chosen.contains(name);
}

namespace {

template <class Base>
class Wrapped final : public Base {
 public:
  Wrapped(const Path& id, Base* real, Memory* memory) : Base(id), real(real), memory_(memory) {}
  DirtyBits GetInitialDirtyBitsMask() const override { return real->GetInitialDirtyBitsMask(); }
  void Finalize(RenderParam* param) override { real->Finalize(param); }
  void Sync(SceneDelegate* host, RenderParam* param, DirtyBits* bits) override {
    Scene scene(host, memory_);
    if constexpr (std::is_same_v<Base, Rprim>)
      if (!before_rprim(host, bits)) return;
    if (is("keeps_old_networks") && (*bits & dirty::kResource) && networks_++ > 0) *bits &= ~dirty::kResource;
    if (is("keeps_old_points") && *bits == dirty::kPoints) *bits = dirty::kClean;
    real->Sync(&scene, param, bits);
    if (is("leaves_bits_dirty")) *bits |= dirty::kRenderTag;
  }

  Base* const real;

 private:
  // False: the edit is not passed on.
  bool before_rprim(SceneDelegate*, DirtyBits* bits) {
    if (!is("keeps_old_prim_ids") || syncs_ == 0) real->SetPrimId(this->GetPrimId());
    ++syncs_;
    if (is("pulls_everything")) *bits |= dirty::kAll;
    if (is("an_edit_ends_a_pause")) memory_->real->Resume();
    if (is("leaks_edits")) {
      const std::lock_guard lock(memory_->mutex);
      memory_->leaked.emplace_back(size_t(1) << 20, 'x');
    }
    if (is("loses_edits_while_rendering") && memory_->waiting && !(*bits & dirty::kSubdivTags)) {
      *bits = dirty::kClean;
      return false;
    }
    return true;
  }

  Memory* memory_;
  int syncs_ = 0, networks_ = 0;
};

class WrappedInstancer final : public Instancer {
 public:
  WrappedInstancer(const Path& id, Instancer* real, Memory* memory) : Instancer(id), real(real), memory_(memory) {}
  void Sync(SceneDelegate* host, RenderParam* param, DirtyBits* bits) override {
    Scene scene(host, memory_);
    real->Sync(&scene, param, bits);
  }
  void Finalize(RenderParam* param) override { real->Finalize(param); }
  Instancer* const real;

 private:
  Memory* memory_;
};

void destroy_real(RenderDelegate* real);

std::set<RenderDelegate*> all_delegates;
std::mutex all_mutex;

class Delegate final : public RenderDelegate {
 public:
  explicit Delegate(RenderDelegate* real) {
    memory_.real = real;
    const std::lock_guard lock(all_mutex);
    all_delegates.insert(real);
  }
  ~Delegate() override {
    {
      const std::lock_guard lock(all_mutex);
      all_delegates.erase(memory_.real);
      if (is("one_delegates_end_stops_all"))
        for (RenderDelegate* other : all_delegates) other->Stop();
    }
    *memory_.holds_workers = false;  // the last delegate's end waits for them
    destroy_real(memory_.real);
  }

  const std::vector<Token>& GetSupportedRprimTypes() const override { return real().GetSupportedRprimTypes(); }
  const std::vector<Token>& GetSupportedSprimTypes() const override { return real().GetSupportedSprimTypes(); }
  const std::vector<Token>& GetSupportedBprimTypes() const override { return real().GetSupportedBprimTypes(); }
  Rprim* CreateRprim(const Token& type, const Path& id) override {
    return wrap<Rprim>(id, real().CreateRprim(is("makes_any_type") ? Token("mesh") : type, id));
  }
  Sprim* CreateSprim(const Token& type, const Path& id) override {
    const std::lock_guard lock(memory_.mutex);
    if (type == Token("material")) memory_.materials.insert(id);
    return wrap<Sprim>(id, real().CreateSprim(type, id));
  }
  Sprim* CreateFallbackSprim(const Token& type) override {
    return is("has_no_fallbacks") ? nullptr : wrap<Sprim>(Path(), real().CreateFallbackSprim(type));
  }
  Bprim* CreateBprim(const Token& type, const Path& id) override {
    return wrap(type, id, real().CreateBprim(type, id));
  }
  Bprim* CreateFallbackBprim(const Token& type) override {
    return wrap(type, Path(), real().CreateFallbackBprim(type));
  }
  Instancer* CreateInstancer(const Path& id) override {
    return new WrappedInstancer(id, real().CreateInstancer(id), &memory_);
  }
  void DestroyRprim(Rprim* prim) override {
    real().DestroyRprim(static_cast<Wrapped<Rprim>*>(prim)->real);
    delete prim;
  }
  void DestroySprim(Sprim* prim) override {
    real().DestroySprim(static_cast<Wrapped<Sprim>*>(prim)->real);
    delete prim;
  }
  void DestroyBprim(Bprim* prim) override {
    auto* buffer = dynamic_cast<Buffer*>(prim);
    if (buffer) memory_.kept.push_back(buffer->take_own());
    real().DestroyBprim(buffer ? buffer->real : static_cast<Wrapped<Bprim>*>(prim)->real);
    delete prim;
  }
  void DestroyInstancer(Instancer* instancer) override {
    real().DestroyInstancer(static_cast<WrappedInstancer*>(instancer)->real);
    delete instancer;
  }

  std::unique_ptr<RenderPass> CreateRenderPass() override {
    return std::make_unique<Pass>(real().CreateRenderPass(), &memory_);
  }
  RenderParam* GetRenderParam() override { return real().GetRenderParam(); }
  void CommitResources() override {
    real().CommitResources();
    if (is("restarts_on_every_sync")) memory_.must_restart = true;
  }

  void SetRenderSetting(const Token& key, const Value& value) override;
  bool SetRenderSettings(const Dictionary& settings) override {
    for (const auto& [name, value] : settings) Delegate::SetRenderSetting(Token(name), value);
    return true;
  }
  Value GetRenderSetting(const Token& key) const override {
    if (is("drops_unknown_settings") && key.str().find(':') != std::string::npos) return {};
    return real().GetRenderSetting(key);
  }
  std::vector<RenderSettingDescriptor> GetRenderSettingDescriptors() const override;
  uint32_t GetRenderSettingsVersion() const override { return real().GetRenderSettingsVersion(); }
  Dictionary GetRenderStats() const override;

  void Pause() override {
    memory_.paused = true;
    if (!is("does_not_pause")) real().Pause();
  }
  void Resume() override {
    if (is("resumes_from_zero") && memory_.paused) memory_.must_restart = true;
    memory_.paused = false;
    real().Resume();
  }
  bool IsPaused() const override { return is("does_not_pause") ? memory_.paused.load() : real().IsPaused(); }
  void Stop() override;
  void Restart() override { real().Restart(); }
  bool IsStopped() const override { return real().IsStopped(); }
  std::shared_ptr<const void> HoldStopped() override { return real().HoldStopped(); }
  AovDescriptor GetDefaultAovDescriptor(const Token& aov) const override {
    return real().GetDefaultAovDescriptor(is("takes_any_aov") && aov.str()[0] == 'n' ? Token("color") : aov);
  }
  CommandResult InvokeCommand(const Token& command, const Dictionary& arguments) override;

 private:
  RenderDelegate& real() const { return *memory_.real; }
  template <class Base>
  Base* wrap(const Path& id, Base* prim) {
    return prim ? new Wrapped<Base>(id, prim, &memory_) : nullptr;
  }
  Bprim* wrap(const Token& type, const Path& id, Bprim* prim) {
    if (type != Token("renderBuffer")) return wrap<Bprim>(id, prim);
    return new Buffer(id, static_cast<RenderBuffer*>(prim), &memory_);
  }
  Memory memory_;
  int stops_ = 0;
};

void Delegate::SetRenderSetting(const Token& key, const Value& value) {
  if (is("restarts_on_equal_setting") && GetRenderSetting(key) == value) memory_.must_restart = true;
  if (is("ignores_settings") && key == Token("maxDepth")) return;
  if (is("one_set_of_settings_for_all")) {
    const std::lock_guard lock(all_mutex);
    for (RenderDelegate* other : all_delegates) other->SetRenderSetting(key, value);
  }
  real().SetRenderSetting(key, value);
}

std::vector<RenderSettingDescriptor> Delegate::GetRenderSettingDescriptors() const {
  std::vector<RenderSettingDescriptor> all = real().GetRenderSettingDescriptors();
  if (is("describes_settings_that_no_host_shows")) all[0].defaultValue = Matrix4d();
  return all;
}

Dictionary Delegate::GetRenderStats() const {
  Dictionary stats = real().GetRenderStats();
  if (is("lacks_a_statistic")) stats.erase("percentDone");
  if (is("keeps_quiet_about_failures")) stats.erase("error");
  return stats;
}

void Delegate::Stop() {
  if (is("is_slow_to_stop") && stops_++ < 9)
    for (const std::clock_t end = std::clock() + CLOCKS_PER_SEC / 15; std::clock() < end;) continue;
  real().Stop();
}

CommandResult Delegate::InvokeCommand(const Token& command, const Dictionary& arguments) {
  if (is("resumes_with_another_seed") && command == Token("resumeCheckpoint")) {
    real().SetRenderSetting("seed", 1);
    return {CommandStatus::done, {}, {}};
  }
  if (is("resumes_anything") && command == Token("resumeCheckpoint")) return {CommandStatus::done, {}, {}};
  if (is("shows_the_first_part_alone") && command == Token("showCheckpoints")) {
    const auto files = arguments.at("files").get_or(Array<std::string>());
    return real().InvokeCommand(command, {{"files", Array<std::string>{files[0]}}});
  }
  return real().InvokeCommand(command, arguments);
}

/// The good delegate's function of the same name.
template <class Function>
Function next(const char* name, Function) {
  return reinterpret_cast<Function>(dlsym(RTLD_NEXT, name));
}
void destroy_real(RenderDelegate* real) {
  next("DestroyAlabasterRenderDelegate", &DestroyAlabasterRenderDelegate)(real);
}

}  // namespace
}  // namespace bad

extern "C" {
bad::RenderDelegate* CreateAlabasterRenderDelegate(uint32_t abi_version, const bad::DelegateOptions* options) {
  using namespace bad;
  if (is("takes_any_version")) abi_version = kAbiVersion;
  DelegateOptions changed = *options;
  static std::atomic<int> count = 0;
  if (is("seed_is_of_the_delegate")) changed.settings["seed"] = ++count;
  RenderDelegate* real = next(__func__, &CreateAlabasterRenderDelegate)(abi_version, &changed);
  return real ? new Delegate(real) : nullptr;
}
void DestroyAlabasterRenderDelegate(bad::RenderDelegate* delegate) {
  delete delegate;
}
}
