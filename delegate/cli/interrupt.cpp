#include "delegate/cli/interrupt.h"

#include <signal.h>
#include <unistd.h>

#include "delegate/cli/exit_codes.h"

namespace alabaster::cli {
namespace {

std::atomic<bool> g_interrupted{false};
std::atomic<bool> g_worth_saving{false};
std::atomic<bool> g_writing{false};
std::atomic<int> g_told{-1};
std::atomic<off_t> g_told_at{0};
static_assert(std::atomic<bool>::is_always_lock_free, "used in a signal handler");

void on_signal(int number) {
  const bool repeats = number == SIGPIPE || number == SIGXCPU || number == SIGXFSZ;
  if (repeats) signal(number, SIG_IGN);
  if (g_worth_saving && !g_interrupted.exchange(true)) return;
  if (g_writing) return;
  if (g_told >= 0) {
    [[maybe_unused]] const ssize_t told = pwrite(g_told, "1", 1, g_told_at);
  }
  if (number == SIGPIPE) _exit(kInterrupted);
  constexpr char kText[] = "\ninterrupted\n";
  [[maybe_unused]] const ssize_t ignored = write(STDERR_FILENO, kText, sizeof kText - 1);
  _exit(kInterrupted);
}

}  // namespace

void catch_interrupts() {
  struct sigaction action = {};
  action.sa_handler = on_signal;
  sigemptyset(&action.sa_mask);
  action.sa_flags = SA_RESTART;
  for (const int number : {SIGINT, SIGTERM, SIGHUP, SIGPIPE, SIGXCPU, SIGXFSZ}) {
    struct sigaction before = {};
    sigaction(number, nullptr, &before);
    if (before.sa_handler != SIG_IGN) sigaction(number, &action, nullptr);
  }
}

void set_worth_saving(bool worth_saving) {
  g_worth_saving = worth_saving;
}

void set_writing(bool writing) {
  g_writing = writing;
}

void set_told_of_end(int descriptor, off_t place) {
  g_told_at = place;
  g_told = descriptor;
}

const std::atomic<bool>& interrupted() {
  return g_interrupted;
}

}  // namespace alabaster::cli
