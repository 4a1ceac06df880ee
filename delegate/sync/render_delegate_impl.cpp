#include "delegate/sync/render_delegate_impl.h"

#include "delegate/sync/pixel_format.h"
#include "delegate/sync/prims.h"
#include "delegate/sync/render_pass.h"

namespace alabaster::hd::sync {

RenderDelegateImpl::~RenderDelegateImpl() {
  core_->stop();  // also what a host forgot to end
}

const std::vector<Token>& RenderDelegateImpl::GetSupportedRprimTypes() const {
  static const std::vector<Token> types{"mesh"};
  return types;
}

const std::vector<Token>& RenderDelegateImpl::GetSupportedSprimTypes() const {
  static const std::vector<Token> types{"camera", "material", "rectLight", "sphereLight", "distantLight", "domeLight"};
  return types;
}

const std::vector<Token>& RenderDelegateImpl::GetSupportedBprimTypes() const {
  static const std::vector<Token> types{"renderSettings", "renderBuffer"};
  return types;
}

Rprim* RenderDelegateImpl::CreateRprim(const Token& type, const Path& id) {
  return type == Token("mesh") ? new MeshPrim(id) : nullptr;
}

Sprim* RenderDelegateImpl::CreateSprim(const Token& type, const Path& id) {
  if (type == Token("camera")) return new CameraPrim(id);
  if (type == Token("material")) return new MaterialPrim(id);
  if (type == Token("rectLight")) return new LightPrim(id, LightType::rect);
  if (type == Token("sphereLight")) return new LightPrim(id, LightType::sphere);
  if (type == Token("distantLight")) return new LightPrim(id, LightType::distant);
  if (type == Token("domeLight")) return new LightPrim(id, LightType::dome);
  return nullptr;
}

Bprim* RenderDelegateImpl::CreateBprim(const Token& type, const Path& id) {
  if (type == Token("renderSettings")) return new RenderSettingsPrim(id);
  if (type == Token("renderBuffer")) return new RenderBufferPrim(id, core_->param);
  return nullptr;
}

Instancer* RenderDelegateImpl::CreateInstancer(const Path& id) {
  return new InstancerPrim(id);
}

std::unique_ptr<RenderPass> RenderDelegateImpl::CreateRenderPass() {
  return std::make_unique<RenderPassImpl>(core_);
}

void RenderDelegateImpl::CommitResources() {
  guarded(core_->param->sink(), "CommitResources", [&] { core_->commit(); });
}

void RenderDelegateImpl::SetRenderSetting(const Token& key, const Value& value) {
  guarded(core_->param->sink(), "SetRenderSetting", [&] { core_->set_setting(key, value); });
}

std::vector<RenderSettingDescriptor> RenderDelegateImpl::GetRenderSettingDescriptors() const {
  std::vector<RenderSettingDescriptor> descriptors;
  const RenderSettings defaults;
  for (const SettingParameter& parameter : setting_parameters()) {
    RenderSettingDescriptor d;
    d.name = parameter.name;
    d.key = parameter.name;
    d.defaultValue = get_setting(parameter, defaults);
    if (parameter.choices.empty()) {
      d.minimum = static_cast<int64_t>(parameter.minimum);
      d.maximum = static_cast<int64_t>(parameter.maximum);
    }
    d.choices = parameter.choices;
    d.documentation = parameter.documentation;
    d.effect = SettingEffect::restart;
    descriptors.push_back(std::move(d));
  }
  return descriptors;
}

AovDescriptor RenderDelegateImpl::GetDefaultAovDescriptor(const Token& aov) const {
  return default_aov_descriptor(aov);
}

Value RenderDelegateImpl::InvokeCommand(const Token& command, const Dictionary&) {
  Value answer;
  guarded(core_->param->sink(), "InvokeCommand", [&] {
    if (command == Token("dumpScene")) answer = core_->dump();
    if (command == Token("requirements")) answer = core_->requirements();
  });
  return answer;
}

}  // namespace alabaster::hd::sync
