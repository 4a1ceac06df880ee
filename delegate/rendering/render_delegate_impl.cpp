#include "delegate/rendering/render_delegate_impl.h"

#include "delegate/prims/prims.h"
#include "delegate/rendering/commands.h"
#include "delegate/rendering/pixel_format.h"
#include "delegate/rendering/render_pass.h"
#include "delegate/support/parameters.h"

namespace alabaster::hd::rendering {

RenderDelegateImpl::~RenderDelegateImpl() {
  RenderDelegateImpl::Stop();  // also what a host forgot to end
}

const std::vector<Token>& RenderDelegateImpl::GetSupportedRprimTypes() const {
  static const std::vector<Token> types(std::begin(kRprimTypes), std::end(kRprimTypes));
  return types;
}

const std::vector<Token>& RenderDelegateImpl::GetSupportedSprimTypes() const {
  static const std::vector<Token> types = [] {
    std::vector<Token> all{"camera", "material"};
    all.insert(all.end(), std::begin(kLightTypes), std::end(kLightTypes));
    return all;
  }();
  return types;
}

const std::vector<Token>& RenderDelegateImpl::GetSupportedBprimTypes() const {
  static const std::vector<Token> types{"renderSettings", "renderBuffer"};
  return types;
}

Rprim* RenderDelegateImpl::CreateRprim(const Token& type, const Path& id) {
  return answer<Rprim*>("CreateRprim", [&](Rprim*& prim) {
    const std::vector<Token>& known = GetSupportedRprimTypes();
    if (std::find(known.begin(), known.end(), type) != known.end()) prim = new prims::MeshPrim(id, type);
  });
}

Sprim* RenderDelegateImpl::CreateSprim(const Token& type, const Path& id) {
  return answer<Sprim*>("CreateSprim", [&](Sprim*& prim) {
    if (type == Token("camera")) prim = new prims::CameraPrim(id);
    if (type == Token("material")) prim = new prims::MaterialPrim(id);
    for (size_t i = 0; i < std::size(kLightTypes); ++i)
      if (type == Token(kLightTypes[i])) prim = new prims::LightPrim(id, static_cast<LightType>(i));
  });
}

Bprim* RenderDelegateImpl::CreateBprim(const Token& type, const Path& id) {
  return answer<Bprim*>("CreateBprim", [&](Bprim*& prim) {
    if (type == Token("renderSettings"))
      prim = new prims::RenderSettingsPrim(id, [delegate = delegate_] { delegate->take_up_settings(); });
    else if (type == Token("renderBuffer"))
      prim = new RenderBufferPrim(id, delegate_->param);
  });
}

Instancer* RenderDelegateImpl::CreateInstancer(const Path& id) {
  return answer<Instancer*>("CreateInstancer",
                            [&](Instancer*& instancer) { instancer = new prims::InstancerPrim(id); });
}

std::unique_ptr<RenderPass> RenderDelegateImpl::CreateRenderPass() {
  return answer<std::unique_ptr<RenderPass>>("CreateRenderPass",
                                             [&](auto& pass) { pass = std::make_unique<RenderPassImpl>(delegate_); });
}

void RenderDelegateImpl::CommitResources() {
  delegate_->commit();
}

void RenderDelegateImpl::SetRenderSetting(const Token& key, const Value& value) {
  prims::guarded(delegate_->param->sink(), "SetRenderSetting", [&] { delegate_->set_settings({{key.str(), value}}); });
}

bool RenderDelegateImpl::SetRenderSettings(const Dictionary& settings) {
  return prims::guarded(
      delegate_->param->sink(), "SetRenderSettings", [&] { delegate_->set_settings(settings); },
      prims::kEarlierStateIsKept);
}

Value RenderDelegateImpl::GetRenderSetting(const Token& key) const {
  return answer<Value>("GetRenderSetting", [&](Value& value) { value = delegate_->setting(key); });
}

namespace {
SettingEffect effect_of(const SettingParameter& setting) {
  if (setting.of & setting_use::kContinues) return SettingEffect::continues;
  if (setting.of & setting_use::kLive) return SettingEffect::live;
  return setting.of & setting_use::kResyncs ? SettingEffect::resyncs : SettingEffect::restarts;
}
std::vector<RenderSettingDescriptor> make_setting_descriptors() {
  const RenderSettings defaults;
  std::vector<RenderSettingDescriptor> descriptors;
  for (const SettingParameter& parameter : setting_parameters()) {
    RenderSettingDescriptor d;
    d.name = parameter.name;
    d.key = parameter.name;
    d.effect = effect_of(parameter);
    d.defaultValue = support::get_parameter(parameter, defaults);
    if (parameter.maximum > parameter.minimum && parameter.maximum < kUnbounded) {
      const bool real = d.defaultValue.get<float>() != nullptr;
      const auto bound = [&](double n) { return real ? Value(static_cast<float>(n)) : Value(static_cast<int64_t>(n)); };
      d.minimum = bound(parameter.minimum);
      d.maximum = bound(parameter.maximum);
    }
    for (const char* word : parameter.words)
      if (word) d.choices.emplace_back(word);
    d.documentation = parameter.text;
    descriptors.push_back(std::move(d));
  }
  return descriptors;
}

}  // namespace

std::vector<RenderSettingDescriptor> RenderDelegateImpl::GetRenderSettingDescriptors() const {
  return answer<std::vector<RenderSettingDescriptor>>("GetRenderSettingDescriptors", [](auto& descriptors) {
    static const std::vector<RenderSettingDescriptor> all = make_setting_descriptors();
    descriptors = all;
  });
}

void RenderDelegateImpl::Pause() {
  prims::guarded(delegate_->param->sink(), "Pause", [&] { delegate_->pause(); });
}

void RenderDelegateImpl::Resume() {
  prims::guarded(delegate_->param->sink(), "Resume", [&] { delegate_->resume(); });
}

void RenderDelegateImpl::Stop() {
  prims::guarded(delegate_->param->sink(), "Stop", [&] { delegate_->stop(); });
}

void RenderDelegateImpl::Restart() {
  prims::guarded(delegate_->param->sink(), "Restart", [&] { delegate_->restart(); });
}

namespace {
struct StopHold {
  explicit StopHold(std::shared_ptr<DelegateState> held) : delegate(std::move(held)) { count(1); }
  ~StopHold() { count(-1); }
  StopHold(const StopHold&) = delete;
  StopHold& operator=(const StopHold&) = delete;
  void count(int change) const {
    prims::guarded(delegate->param->sink(), "HoldStopped", [&] { delegate->hold_stopped(change); });
  }
  std::shared_ptr<DelegateState> delegate;
};
}  // namespace

std::shared_ptr<const void> RenderDelegateImpl::HoldStopped() {
  return answer<std::shared_ptr<const void>>("HoldStopped",
                                             [&](auto& hold) { hold = std::make_shared<const StopHold>(delegate_); });
}

AovDescriptor RenderDelegateImpl::GetDefaultAovDescriptor(const Token& aov) const {
  return answer<AovDescriptor>("GetDefaultAovDescriptor", [&](auto& d) { d = default_aov_descriptor(aov); });
}

CommandResult RenderDelegateImpl::InvokeCommand(const Token& command, const Dictionary& arguments) {
  return answer<CommandResult>("InvokeCommand",
                               [&](CommandResult& result) { result = run_command(*delegate_, command, arguments); });
}

}  // namespace alabaster::hd::rendering
