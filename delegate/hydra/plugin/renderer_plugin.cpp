// The library that OpenUSD loads. It holds the plug-in's type and nothing else: the adaptor and the renderer are loaded
// when a delegate is first made, in scopes of their own, so that their libraries do not meet the host's.
#include <dlfcn.h>
#include <pxr/base/tf/diagnostic.h>
#include <pxr/imaging/hd/rendererPlugin.h>
#include <pxr/imaging/hd/rendererPluginRegistry.h>

#include <string>

PXR_NAMESPACE_OPEN_SCOPE

class HdAlabasterRendererPlugin final : public HdRendererPlugin {
 public:
  HdRenderDelegate* CreateRenderDelegate() override { return CreateRenderDelegate({}); }
  HdRenderDelegate* CreateRenderDelegate(const HdRenderSettingsMap& settings) override;
  void DeleteRenderDelegate(HdRenderDelegate* delegate) override { delete delegate; }
  bool IsSupported(bool) const override { return true; }
};

namespace {

using MakeDelegate = HdRenderDelegate* (*)(const HdRenderSettingsMap*);

// Null after a warning. The libraries stay: other delegates of the process use them.
void* load(const std::string& file) {
  void* const library = dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (!library)
    TF_WARN(
        "Alabaster cannot be loaded: %s. Install it again, or set LD_LIBRARY_PATH to the folder of the library "
        "that is missing.",
        dlerror());
  return library;
}

MakeDelegate find_maker() {
  Dl_info self{};
  if (!dladdr(reinterpret_cast<const void*>(&find_maker), &self)) return nullptr;
  const std::string file = self.dli_fname;
  const std::string folder = file.substr(0, file.rfind('/') + 1);
  // The renderer comes first: its symbols are then found among its own libraries, not among the adaptor's.
  if (!load(folder + ALABASTER_RENDERER_FILE)) return nullptr;
  void* const adaptor = load(folder + ALABASTER_ADAPTOR_FILE);
  if (!adaptor) return nullptr;
  void* const maker = dlsym(adaptor, "AlabasterCreateHydraDelegate");
  if (!maker) TF_WARN("Alabaster: %s is of another version than the plug-in.", ALABASTER_ADAPTOR_FILE);
  return reinterpret_cast<MakeDelegate>(maker);
}

}  // namespace

HdRenderDelegate* HdAlabasterRendererPlugin::CreateRenderDelegate(const HdRenderSettingsMap& settings) {
  static const MakeDelegate make = find_maker();
  return make ? make(&settings) : nullptr;
}

TF_REGISTRY_FUNCTION(TfType) {
  HdRendererPluginRegistry::Define<HdAlabasterRendererPlugin>();
}

PXR_NAMESPACE_CLOSE_SCOPE
