// The C entry points.
#include <dlfcn.h>
#include <tbb/global_control.h>
#include <tbb/version.h>
#include <unistd.h>

#include <atomic>

#include "delegate/rendering/render_delegate_impl.h"
#include "delegate/support/lookup.h"
#include "delegate/support/process_usage.h"

namespace {

using namespace alabaster;

std::atomic<int> g_delegates{0};
std::atomic<pid_t> g_workers_of{0};  // the process whose delegates have used TBB's workers; 0: there are none

/// Ends TBB's workers, which would run on in a library that a host unloads. They stay where another thread has used
/// TBB, and TBB then stays with them.
void end_workers() {
  tbb::task_scheduler_handle handle{tbb::attach()};
  Dl_info info{};
  if (tbb::finalize(handle, std::nothrow)) {
    g_workers_of = 0;
    if (g_delegates > 0) g_workers_of = getpid();  // another thread has made one meanwhile, which counted it before
    return;
  }
  if (!dladdr(reinterpret_cast<const void*>(&TBB_runtime_version), &info)) return;
  if (void* held = dlopen(info.dli_fname, RTLD_NOW | RTLD_NOLOAD | RTLD_NODELETE)) dlclose(held);
}

/// False in a child that was forked from a process with workers. TBB counts on them there, and waits without end for a
/// lock that one of them held at the fork.
bool may_use_workers() {
  pid_t none = 0;
  const pid_t self = getpid();
  return g_workers_of.compare_exchange_strong(none, self) || none == self;
}

/// Counts a delegate from before it is made, unless making it fails.
class Counted {
 public:
  Counted() { ++g_delegates; }
  ~Counted() {
    if (!made_) --g_delegates;
  }
  Counted(const Counted&) = delete;
  Counted& operator=(const Counted&) = delete;
  void keep() { made_ = true; }

 private:
  bool made_ = false;
};

hd::RenderDelegate* create(const hd::DelegateOptions& options, const DiagnosticSink& sink) {
  Counted counted;
  if (!may_use_workers()) {
    report(sink, Severity::error, "delegate.fork", "TBB",
           "this process was forked from one that has renderers, and lacks the threads of TBB; begin it with exec "
           "(Python: multiprocessing's spawn or forkserver), or destroy all renderers before the fork");
    return nullptr;
  }
  hd::Dictionary settings = options.settings;
  const hd::Value ocio = hd::support::value_in(settings, "ocio");
  const auto* const named = ocio.get<hd::AssetPath>();
  auto colors = ColorConfig::load(ocio.text_or(""), sink, named ? named->within : std::string());
  auto memory = std::make_shared<MemoryBudget>(hd::support::default_memory_limit());
  auto device = colors ? make_trace_device(sink, memory) : nullptr;
  if (!device) return nullptr;  // both have reported why
  auto param = std::make_shared<hd::prims::SceneParam>(sink, std::move(device), std::move(colors), std::move(memory));
  auto delegate = std::make_unique<hd::rendering::RenderDelegateImpl>(
      std::make_shared<hd::rendering::DelegateState>(std::move(param), settings));
  // These make their lists at the first call: made here, a failure can still be answered with null.
  delegate->GetSupportedRprimTypes();
  delegate->GetSupportedSprimTypes();
  delegate->GetSupportedBprimTypes();
  counted.keep();
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
  if (!delegate || static_cast<hd::rendering::RenderDelegateImpl*>(delegate)->is_of_another_process()) return;
  delete delegate;
  if (--g_delegates == 0) end_workers();
}

const char* AlabasterVersions() {
  return ALABASTER_VERSIONS;
}
}
