#include "delegate/hydra/plugin/hydra_delegate.h"

#include <pxr/base/tf/diagnostic.h>
#include <pxr/imaging/hd/aov.h>
#include <pxr/imaging/hd/extComputation.h>
#include <pxr/imaging/hd/tokens.h>

#include <algorithm>

#include "delegate/hydra/plugin/hydra_buffer.h"
#include "delegate/hydra/plugin/hydra_pass.h"
#include "delegate/hydra/plugin/hydra_prims.h"
#include "delegate/hydra/plugin/hydra_settings.h"

using namespace pxr;  // the macros of diagnostics name its types

namespace alabaster::hydra {
namespace {

// Settings of the plug-in's own, and Hydra's.
constexpr const char *kSceneSetting = "writeScene", *kDomeSetting = "domeLightCameraVisibility";
constexpr const char* kInteractiveSetting = "enableInteractive";
constexpr const char* kDriver = "driver:";  // Houdini's: of products and their variables

// Errors, too, are warnings for OpenUSD: its own become exceptions in hosts in Python, which end their render.
void tell(const hd::Diagnostic& d) {
  if (d.severity == hd::Severity::info) return;
  const char* const word = d.severity == hd::Severity::error ? "error: " : "";
  TF_WARN("Alabaster: %s%s: %s [%s]", word, d.where.c_str(), d.text.c_str(), d.code.c_str());
}

pxr::TfTokenVector to_tokens(const std::vector<hd::Token>& types) {
  pxr::TfTokenVector theirs;
  for (const hd::Token& type : types) theirs.emplace_back(type.str());
  return theirs;
}

/// Reads an image again that was edited on disk.
class Registry final : public pxr::HdResourceRegistry {
 public:
  explicit Registry(hd::RenderDelegate* delegate) : delegate_(delegate) {}
  void ReloadResource(const pxr::TfToken&, const std::string& path) override {
    const hd::CommandResult result = delegate_->InvokeCommand("reloadResource", {{"file", path}});
    if (!result.ok()) TF_WARN("Alabaster: %s", result.fault.c_str());
  }

 private:
  hd::RenderDelegate* delegate_;
};

}  // namespace

std::unique_ptr<HydraDelegate> HydraDelegate::Create(const pxr::HdRenderSettingsMap& settings) {
  hd::DelegateOptions options;
  options.diagnostics = tell;
  hd::RenderDelegate* const delegate = CreateAlabasterRenderDelegate(hd::kAbiVersion, &options);
  if (!delegate) {
    TF_WARN("Alabaster: the renderer cannot start. libhdAlabaster may be of another version than the plug-in.");
    return nullptr;
  }
  RegisterSettingsSceneIndex();
  std::unique_ptr<HydraDelegate> made(new HydraDelegate(delegate, options.diagnostics));
  for (const auto& [key, value] : settings) made->SetRenderSetting(key, value);
  return made;
}

HydraDelegate::HydraDelegate(hd::RenderDelegate* delegate, const hd::DiagnosticSink& sink)
    : delegate_(delegate),
      param_(std::make_unique<HydraParam>(delegate, sink)),
      settings_(delegate->GetRenderSettingDescriptors()),
      rprims_(to_tokens(delegate->GetSupportedRprimTypes())),
      sprims_(to_tokens(delegate->GetSupportedSprimTypes())),
      bprims_{pxr::HdPrimTypeTokens->renderBuffer, pxr::HdPrimTypeTokens->renderSettings},
      registry_(std::make_shared<Registry>(delegate)) {
  sprims_.push_back(pxr::HdPrimTypeTokens->extComputation);
  _PopulateDefaultSettings(GetRenderSettingDescriptors());
}

HydraDelegate::~HydraDelegate() {
  param_.reset();
  DestroyAlabasterRenderDelegate(delegate_);
}

void HydraDelegate::SetRenderSetting(const pxr::TfToken& key, const pxr::VtValue& value) {
  HdRenderDelegate::SetRenderSetting(key, value);
  const Setting setting = TranslateSetting(ToToken(key), ToValue(value), settings_);
  host_settings_[setting.key] = setting.value;
  const auto scene = scene_settings_.find(setting.key);
  apply(scene == scene_settings_.end()
            ? setting
            : Setting{setting.key, WithinHostLimits(setting.key, scene->second, setting.value)});
}

bool HydraDelegate::is_for_scenes(const hd::Token& key) const {
  return key == hd::Token(kDomeSetting) ||
         std::any_of(settings_.begin(), settings_.end(), [&](const auto& setting) { return setting.key == key; });
}

void HydraDelegate::SetSceneSettings(const pxr::SdfPath& prim, const pxr::VtDictionary& settings) {
  std::map<hd::Token, hd::Value> now;
  for (const auto& [key, value] : settings) {
    if (key.starts_with(kDriver)) continue;
    const Setting setting = TranslateSetting(key, ToValue(value), settings_);
    if (!is_for_scenes(setting.key))
      param_->warn(prim, "settings.unknown", "the renderer has no setting '" + key + "' for scenes; it is ignored");
    else if (!setting.value.empty())
      now[setting.key] = setting.value;
    if (const hd::Value host = host_setting(setting.key); WithinHostLimits(setting.key, setting.value, host) == host &&
                                                          !(setting.value == host) && !setting.value.empty())
      param_->warn(prim, "settings.limit", "the application's " + setting.key.str() + " is lower, and holds");
  }
  settings_prim_ = prim;
  apply_scene(std::move(now));
}

void HydraDelegate::DropSceneSettings(const pxr::SdfPath& prim) {
  if (settings_prim_ != prim) return;  // another one is active already
  settings_prim_ = {};
  apply_scene({});
  param_->products().set({}, {});
}

void HydraDelegate::apply_scene(std::map<hd::Token, hd::Value> now) {
  for (const auto& [key, value] : scene_settings_)
    if (!now.contains(key)) apply({key, host_setting(key)});
  for (const auto& [key, value] : now) apply({key, WithinHostLimits(key, value, host_setting(key))});
  scene_settings_ = std::move(now);
}

hd::Value HydraDelegate::host_setting(const hd::Token& key) const {
  if (const auto found = host_settings_.find(key); found != host_settings_.end()) return found->second;
  for (const hd::RenderSettingDescriptor& setting : settings_)
    if (setting.key == key) return setting.defaultValue;
  return {};
}

void HydraDelegate::apply(const Setting& setting) {
  if (setting.key == hd::Token(kDomeSetting)) param_->set_domes_visible(setting.value.number_or(1) != 0);
  if (setting.key == hd::Token(kInteractiveSetting)) param_->is_batch = setting.value.number_or(1) == 0;
  if (setting.key == hd::Token(kSceneSetting)) param_->set_scene_file(setting.value.text_or(""));
  delegate_->SetRenderSetting(setting.key, setting.value);
}

pxr::HdRenderSettingDescriptorList HydraDelegate::GetRenderSettingDescriptors() const {
  pxr::HdRenderSettingDescriptorList theirs;
  for (const hd::RenderSettingDescriptor& setting : settings_)
    theirs.push_back({setting.name, pxr::TfToken("alabaster:" + setting.key.str()), FromValue(setting.defaultValue)});
  return theirs;
}

pxr::VtDictionary HydraDelegate::GetRenderStats() const {
  return FromDictionary(HostStatistics(delegate_->GetRenderStats()));
}

bool HydraDelegate::Stop(bool) {
  delegate_->Stop();
  return true;
}

pxr::HdRenderPassSharedPtr HydraDelegate::CreateRenderPass(pxr::HdRenderIndex* index,
                                                           const pxr::HdRprimCollection& collection) {
  auto pass = delegate_->CreateRenderPass();
  return pass ? std::make_shared<HydraPass>(index, collection, std::move(pass), param_.get()) : nullptr;
}

pxr::HdInstancer* HydraDelegate::CreateInstancer(pxr::HdSceneDelegate* scene, const pxr::SdfPath& id) {
  return new HydraInstancer(delegate_->CreateInstancer(ToPath(id)), scene, id);
}

void HydraDelegate::DestroyInstancer(pxr::HdInstancer* instancer) {
  delegate_->DestroyInstancer(static_cast<HydraInstancer*>(instancer)->prim());
  delete instancer;
}

pxr::HdRprim* HydraDelegate::CreateRprim(const pxr::TfToken& type, const pxr::SdfPath& id) {
  hd::Rprim* const prim = delegate_->CreateRprim(ToToken(type), ToPath(id));
  if (!prim) return nullptr;
  if (type == pxr::HdPrimTypeTokens->basisCurves) return new HydraCurves(prim, id);
  if (type == pxr::HdPrimTypeTokens->points) return new HydraPoints(prim, id);
  return new HydraMesh(prim, id);
}

void HydraDelegate::DestroyRprim(pxr::HdRprim* prim) {
  if (const auto* mesh = dynamic_cast<HydraMesh*>(prim)) delegate_->DestroyRprim(mesh->prim());
  if (const auto* curves = dynamic_cast<HydraCurves*>(prim)) delegate_->DestroyRprim(curves->prim());
  if (const auto* points = dynamic_cast<HydraPoints*>(prim)) delegate_->DestroyRprim(points->prim());
  delete prim;
}

pxr::HdSprim* HydraDelegate::CreateSprim(const pxr::TfToken& type, const pxr::SdfPath& id) {
  if (type == pxr::HdPrimTypeTokens->camera) return new HydraCamera(id);
  if (type == pxr::HdPrimTypeTokens->extComputation) return new pxr::HdExtComputation(id);
  hd::Sprim* const prim = delegate_->CreateSprim(ToToken(type), ToPath(id));
  if (!prim) return nullptr;
  if (type == pxr::HdPrimTypeTokens->material) return new HydraMaterial(prim, id);
  return new HydraLight(prim, id, type);
}

pxr::HdSprim* HydraDelegate::CreateFallbackSprim(const pxr::TfToken& type) {
  return CreateSprim(type, pxr::SdfPath::EmptyPath());
}

void HydraDelegate::DestroySprim(pxr::HdSprim* prim) {
  if (const auto* material = dynamic_cast<HydraMaterial*>(prim)) delegate_->DestroySprim(material->prim());
  if (const auto* light = dynamic_cast<HydraLight*>(prim)) {
    param_->remove_light(light->GetId());  // an index that is destroyed finalizes nothing
    delegate_->DestroySprim(light->prim());
  }
  delete prim;
}

pxr::HdBprim* HydraDelegate::CreateBprim(const pxr::TfToken& type, const pxr::SdfPath& id) {
  if (type == pxr::HdPrimTypeTokens->renderSettings) return new HydraRenderSettings(id, this);
  if (type != pxr::HdPrimTypeTokens->renderBuffer) return nullptr;
  hd::Bprim* const prim = delegate_->CreateBprim("renderBuffer", ToPath(id));
  return prim ? new HydraBuffer(id, static_cast<hd::RenderBuffer*>(prim)) : nullptr;
}

pxr::HdBprim* HydraDelegate::CreateFallbackBprim(const pxr::TfToken& type) {
  return CreateBprim(type, pxr::SdfPath::EmptyPath());
}

void HydraDelegate::DestroyBprim(pxr::HdBprim* prim) {
  if (const auto* buffer = dynamic_cast<HydraBuffer*>(prim)) delegate_->DestroyBprim(buffer->buffer());
  if (dynamic_cast<HydraRenderSettings*>(prim)) DropSceneSettings(prim->GetId());
  delete prim;
}

void HydraDelegate::CommitResources(pxr::HdChangeTracker*) {
  delegate_->CommitResources();
}

pxr::TfToken HydraDelegate::GetMaterialBindingPurpose() const {
  return pxr::HdTokens->full;
}

// Our own nodes say most, and MaterialX more than UsdPreviewSurface, which has no subsurface scattering.
pxr::TfTokenVector HydraDelegate::GetMaterialRenderContexts() const {
  return {pxr::TfToken("alabaster"), pxr::TfToken("mtlx"), pxr::TfToken()};
}

pxr::TfTokenVector HydraDelegate::GetRenderSettingsNamespaces() const {
  return {pxr::TfToken("alabaster"), pxr::TfToken("driver")};
}

pxr::HdAovDescriptor HydraDelegate::GetDefaultAovDescriptor(const pxr::TfToken& aov) const {
  const hd::AovDescriptor ours = delegate_->GetDefaultAovDescriptor(ToToken(aov));
  return {FromFormat(ours.format), false, FromValue(ours.clearValue)};
}

}  // namespace alabaster::hydra

/// The one symbol that the stub looks up. Null after a warning.
extern "C" __attribute__((visibility("default"))) pxr::HdRenderDelegate* AlabasterCreateHydraDelegate(
    const pxr::HdRenderSettingsMap* settings) {
  try {
    return alabaster::hydra::HydraDelegate::Create(*settings).release();
  } catch (const std::exception& e) {
    TF_WARN("Alabaster: the render delegate could not be made: %s", e.what());
    return nullptr;
  }
}
