#include <algorithm>
#include <condition_variable>
#include <cstdio>
#include <cstdlib>
#include <mutex>
#include <thread>

#include "delegate/cli/commands.h"
#include "delegate/cli/exit_codes.h"
#include "delegate/cli/scene_session.h"

namespace alabaster::cli {
namespace {

constexpr double kForever = 1e9;

/// Ends the program when its time is over. A check writes no files, so that nothing is lost.
class Deadline {
 public:
  Deadline(double seconds, const std::string& file) : watch_([=, this] { wait(seconds, file); }) {}
  ~Deadline() {
    {
      const std::lock_guard lock(mutex_);
      met_ = true;
    }
    changed_.notify_one();
    watch_.join();
  }

 private:
  void wait(double seconds, const std::string& file) {
    std::unique_lock lock(mutex_);
    if (changed_.wait_for(lock, std::chrono::duration<double>(std::min(seconds, kForever)), [this] { return met_; }))
      return;
    std::fprintf(stderr, "error: %s: The check did not end within %g s; allow more with --time-limit\n",
                 printable(file).c_str(), seconds);
    std::_Exit(kRender);
  }

  std::mutex mutex_;
  std::condition_variable changed_;
  bool met_ = false;
  std::thread watch_;
};

// Reports all products that cannot be written; an exit code.
int check_products(const SceneSession& session, const hd::DiagnosticSink& sink) {
  int code = kDone;
  for (const auto& [path, settings] : session.scene.GetAllRenderSettings())
    for (const hd::RenderProduct& product : settings.products) {
      const hd::host::ProductCheck check = hd::host::CheckProduct(product, settings.window(), session.colors(), sink);
      if (!check && code != kRender) code = check.status == hd::host::ProductStatus::out_of_memory ? kRender : kInput;
    }
  return code;
}

int check(const CheckArguments& a, Console* console) {
  SceneSession session;
  std::vector<hd::description::Override> flags;
  if (!a.memory_limit.empty()) flags.emplace_back("--memory-limit " + a.memory_limit, "memoryLimit", a.memory_limit);
  const hd::description::LoadOptions options = scene_load_options(a, std::move(flags));
  session.load(a.scene, options, console->sink());
  session.choose_colors(a.ocio, console->sink(), kInput);
  const int products = check_products(session, console->sink());
  session.start(console->sink());
  if (!session.index()->SyncAll()) return kRender;
  require(session.fault_code());
  return products;
}

}  // namespace

int run_check(const CheckArguments& a) {
  Console console(a.quiet, Console::Like::all);
  const Deadline deadline(a.time_limit, a.scene);
  const int code = check(a, &console);
  if (code == kDone) console.note(a.scene + ": can be rendered");
  return code;
}

}  // namespace alabaster::cli
