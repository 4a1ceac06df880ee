#include <algorithm>
#include <condition_variable>
#include <cstdio>
#include <cstdlib>
#include <mutex>
#include <thread>

#include "delegate/cli/commands.h"
#include "delegate/cli/exit_codes.h"
#include "delegate/cli/outputs.h"
#include "delegate/cli/scene_session.h"
#include "delegate/host/product_limits.h"

namespace alabaster::cli {
namespace {

constexpr double kDefaultSeconds = 60, kForever = 1e9;

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
      hd::host::ProductCheck check = hd::host::CheckProduct(product, session.colors(), sink);
      if (check) check = hd::host::CheckProductSize(product, settings.window(), sink);
      if (!check && code != kRender) code = check.status == hd::host::ProductStatus::out_of_memory ? kRender : kInput;
    }
  return code;
}

int check(const CheckArguments& a, Console* console) {
  SceneSession session;
  hd::description::LoadOptions options;
  if (!a.memory_limit.empty()) options.overrides.push_back("memoryLimit=" + a.memory_limit);
  options.overrides.insert(options.overrides.end(), a.overrides.begin(), a.overrides.end());
  options.allow_outside = a.allow_outside;
  if (const int code = session.load(a.scene, options, console->sink()); code != kDone) return code;
  if (!session.choose_colors("", console->sink())) return kInput;
  const int products = check_products(session, console->sink());
  if (!session.start(console->sink())) return kRender;
  if (!session.index()->SyncAll()) return kRender;
  if (const int code = session.scene_faults(); code != kDone) return code;
  return products;
}

}  // namespace

int run_check(const CheckArguments& a) {
  Console console(a.quiet);
  const auto seconds = a.time_limit.empty() ? kDefaultSeconds : parse_nonnegative(a.time_limit);
  if (seconds.value_or(0) == 0)
    return console.usage_error("--time-limit", "'" + a.time_limit + "' is not a number of seconds above 0.");
  const Deadline deadline(*seconds, a.scene);
  const int code = check(a, &console);
  if (code == kDone) console.note(a.scene + ": can be rendered");
  return code;
}

}  // namespace alabaster::cli
