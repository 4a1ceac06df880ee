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

bool check_products(const SceneSession& session, const hd::DiagnosticSink& sink) {
  bool ok = true;
  for (const auto& [path, settings] : session.scene.GetAllRenderSettings())
    for (const hd::RenderProduct& product : settings.products)
      ok = hd::host::CheckProduct(product, session.colors(), sink) &&
           hd::host::CheckProductSize(product, settings.window(), sink) && ok;
  return ok;
}

int check(const CheckArguments& a, Console* console) {
  SceneSession session;
  hd::description::LoadOptions options;
  if (!a.memory_limit.empty()) options.overrides.push_back("memoryLimit=" + a.memory_limit);
  options.overrides.insert(options.overrides.end(), a.overrides.begin(), a.overrides.end());
  options.allow_outside = a.allow_outside;
  if (!session.load(a.scene, options, console->sink())) return load_failure(console->last_error(), options);
  if (!session.choose_colors("", console->sink())) return kInput;
  const bool products_ok = check_products(session, console->sink());
  if (!session.start(console->sink())) return kRender;
  if (!session.index()->SyncAll()) return kRender;
  if (const int code = session.scene_faults(); code != kDone) return code;
  return products_ok ? kDone : kInput;
}

}  // namespace

int run_check(const CheckArguments& a) {
  Console console(a.quiet);
  const auto seconds = a.time_limit.empty() ? kDefaultSeconds : parse_nonnegative(a.time_limit);
  if (seconds.value_or(0) == 0)
    return console.usage_error("--time-limit", "'" + a.time_limit + "' is not a number of seconds above 0.");
  const Deadline deadline(*seconds, a.scene);
  const int code = console.final_code(check(a, &console));
  if (code == kDone) console.note(a.scene + ": can be rendered");
  return code;
}

}  // namespace alabaster::cli
