// The C entrance.
#include "delegate/rendering/render_delegate_impl.h"

namespace {

using namespace alabaster;

hd::RenderDelegate* create(const hd::DelegateOptions& options, const DiagnosticSink& sink) {
  hd::Dictionary settings = options.settings;
  const auto ocio = settings.find("ocio");
  const std::string config = ocio == settings.end() ? std::string() : ocio->second.text_or("");
  auto colors = ColorConfig::load(config, sink);
  auto device = colors ? make_trace_device(sink) : nullptr;
  if (!device) return nullptr;  // both have told why
  auto param = std::make_shared<hd::sync::SceneParam>(sink, std::move(device), std::move(colors));
  auto delegate = std::make_unique<hd::sync::RenderDelegateImpl>(
      std::make_shared<hd::sync::RenderCore>(std::move(param), settings));
  // Lists made at the first call are made here, where failing is still an answer.
  delegate->GetSupportedRprimTypes();
  delegate->GetSupportedSprimTypes();
  delegate->GetSupportedBprimTypes();
  return delegate.release();
}

}  // namespace

extern "C" {

hd::RenderDelegate* CreateAlabasterRenderDelegate(uint32_t abi_version, const hd::DelegateOptions* options) {
  hd::RenderDelegate* delegate = nullptr;
  if (abi_version != hd::kAbiVersion) return nullptr;  // the options' layout is not known either
  const hd::DelegateOptions defaults;
  const hd::DelegateOptions& used = options ? *options : defaults;
  DiagnosticSink sink;  // empty should it be what fails
  hd::sync::guarded({}, "CreateAlabasterRenderDelegate", [&] { sink = hd::sync::core_sink(used.diagnostics); });
  hd::sync::guarded(sink, "CreateAlabasterRenderDelegate", [&] { delegate = create(used, sink); });
  return delegate;
}

void DestroyAlabasterRenderDelegate(hd::RenderDelegate* delegate) {
  delete delegate;
}

const char* AlabasterVersions() {
  return ALABASTER_VERSIONS;
}
}
