// Names our nodes to OpenUSD's registry of shaders. OpenUSD drops nodes that it has no definition of from materials,
// and its own parser reads the definitions from shaders.usda beside this library.
#include <pxr/base/plug/plugin.h>
#include <pxr/base/plug/thisPlugin.h>
#include <pxr/usd/ndr/discoveryPlugin.h>

PXR_NAMESPACE_OPEN_SCOPE

class AlabasterDiscoveryPlugin final : public NdrDiscoveryPlugin {
 public:
  NdrNodeDiscoveryResultVec DiscoverNodes(const Context&) override {
    NdrNodeDiscoveryResultVec found;
    const std::string file = PlugFindPluginResource(PLUG_THIS_PLUGIN, "shaders.usda");
    if (file.empty()) return found;
    const NdrVersion version = NdrVersion().GetAsDefault();
    for (const char* name : {"AlabasterDisney", "AlabasterDisplacement", "AlabasterTexture", "AlabasterPrimvar"})
      found.emplace_back(NdrIdentifier(name), version, name, TfToken(), TfToken("usda"), TfToken("alabaster"), file,
                         file);
    return found;
  }
  const NdrStringVec& GetSearchURIs() const override {
    static const NdrStringVec folders = {PLUG_THIS_PLUGIN->GetResourcePath()};
    return folders;
  }
};

NDR_REGISTER_DISCOVERY_PLUGIN(AlabasterDiscoveryPlugin)

PXR_NAMESPACE_CLOSE_SCOPE
