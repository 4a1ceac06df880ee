// The C entry points.
#include "delegate/rendering/render_delegate_impl.h"

namespace {

using namespace alabaster;

hd::RenderDelegate* create(const hd::DelegateOptions& options, const DiagnosticSink& sink) {
  hd::Dictionary settings = options.settings;
  const auto ocio = settings.find("ocio");
  const std::string config = ocio == settings.end() ? std::string() : ocio->second.text_or("");
  auto colors = ColorConfig::load(config, sink);
  auto device = colors ? make_trace_device(sink) : nullptr;
  if (!device) return nullptr;  // both have reported why
  auto param = std::make_shared<hd::prims::SceneParam>(sink, std::move(device), std::move(colors));
  auto delegate = std::make_unique<hd::rendering::RenderDelegateImpl>(
      std::make_shared<hd::rendering::RenderCore>(std::move(param), settings));
  // These make their lists at the first call: made here, a failure can still be answered with null.
  delegate->GetSupportedRprimTypes();
  delegate->GetSupportedSprimTypes();
  delegate->GetSupportedBprimTypes();
  return delegate.release();
}

}  // namespace

extern "C" {

hd::RenderDelegate* CreateAlabasterRenderDelegate(uint32_t abi_version, const hd::DelegateOptions* options) {
  hd::RenderDelegate* delegate = nullptr;
  if (abi_version != hd::kAbiVersion) return nullptr;  // the layout of the options is unknown, too
  const hd::DelegateOptions defaults;
  const hd::DelegateOptions& used = options ? *options : defaults;
  DiagnosticSink sink;  // empty if making it fails
  hd::prims::guarded({}, "CreateAlabasterRenderDelegate", [&] { sink = hd::prims::core_sink(used.diagnostics); });
  hd::prims::guarded(sink, "CreateAlabasterRenderDelegate", [&] { delegate = create(used, sink); });
  return delegate;
}

void DestroyAlabasterRenderDelegate(hd::RenderDelegate* delegate) {
  delete delegate;
}

const char* AlabasterVersions() {
  return ALABASTER_VERSIONS;
}
}
