#include "delegate/cli/console.h"

#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdarg>
#include <cstdio>

#include "delegate/cli/exit_codes.h"
#include "delegate/cli/shell_word.h"

namespace alabaster::cli {
namespace {

using hd::host::RecordProgress;

bool is_denoising(const RecordProgress& p) {
  return p.denoised >= 0 && p.denoised < 1;
}

std::string progress_text(const RecordProgress& p, double noise) {
  if (is_denoising(p)) return formatted("denoising %.0f %%", p.denoised * 100);
  // At its end a render has some samples, though less than one per pixel where the time limit cut it short.
  const std::string done = p.samples_done == 0 && p.fraction >= 1 ? "<1" : std::to_string(p.samples_done);
  return formatted("%3.0f %%", std::clamp(p.fraction, 0.0, 1.0) * 100) + "  " + done + "/" +
         std::to_string(p.samples_total) + " samples" + (noise < 0 ? "" : formatted("  noise %.3g %%", 100 * noise)) +
         "  " + (p.fraction < 1 ? time_text(p.seconds_left) + " left" : time_text(p.seconds));
}

size_t terminal_width() {
  constexpr size_t kUsual = 80;
  winsize size{};
  return ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0 ? size.ws_col : kUsual;
}

constexpr size_t kMostMessages = 100, kMostLike = 3;

}  // namespace

std::string formatted(const char* pattern, ...) {
  va_list values, again;
  va_start(values, pattern);
  va_copy(again, values);
  const int size = std::vsnprintf(nullptr, 0, pattern, values);
  std::string text(static_cast<size_t>(std::max(size, 0)), '\0');
  std::vsnprintf(text.data(), text.size() + 1, pattern, again);
  va_end(again);
  va_end(values);
  return text;
}

std::string time_text(double seconds) {
  if (!(seconds >= 0) || seconds > 1e7) return "--:--";
  const auto whole = static_cast<long>(std::lround(seconds));
  if (whole < 3600) return formatted("%ld:%02ld", whole / 60, whole % 60);
  return formatted("%ld:%02ld:%02ld", whole / 3600, whole / 60 % 60, whole % 60);
}

std::string printable(const std::string& text) {
  std::string out;
  for (size_t begin = 0;;) {
    const size_t end = text.find('\n', begin);
    out += without_control_characters(text.substr(begin, end - begin));
    if (end == std::string::npos) return out;
    begin = end + 1;
    out += text.compare(begin, 2, "  ") == 0 ? "\n" : "\n  ";
  }
}

Console::Console(bool quiet, Like like) : quiet_(quiet), terminal_(isatty(STDERR_FILENO) != 0), like_(like) {}

hd::DiagnosticSink Console::sink() {
  return [this](const hd::Diagnostic& diagnostic) { show(diagnostic); };
}

void Console::show(const hd::Diagnostic& d) {
  const std::lock_guard lock(mutex_);
  const bool error = d.severity == hd::Severity::error;
  if (quiet_ && d.severity == hd::Severity::info) return;
  const auto shortened = [](const std::string& text, size_t longest) {
    return text.size() > longest ? text.substr(0, longest) + "..." : text;
  };
  const std::string line = (d.where.empty() ? "" : shortened(d.where, 1000) + ": ") + shortened(d.text, 4000);
  if (error) last_error_ = line;
  // The end of a run is told, whatever came before.
  const bool told = d.code == "cli" || d.code.starts_with("record.") || d.code.starts_with("product.") ||
                    d.code.starts_with("pass.") || d.code.ends_with(".more");
  if (!told && is_counted(d)) return;
  if (++counts_[int(d.severity)] > kMostMessages && !told) {
    ++unshown_[int(d.severity)];
    return;
  }
  const char* kind = error ? "error: " : d.severity == hd::Severity::warning ? "warning: " : "";
  print_line(kind + line);
}

// True of a warning that is like others which were shown.
bool Console::is_counted(const hd::Diagnostic& d) {
  constexpr size_t kFirstWords = 40, kMostKinds = 1000;
  if (like_ == Like::all || d.severity != hd::Severity::warning) return false;
  const std::string words = d.code + ": " + d.text.substr(0, kFirstWords);
  if (like_counts_.size() >= kMostKinds && !like_counts_.contains(words)) return false;
  return ++like_counts_[words] > kMostLike;
}

void Console::tell_counted() {
  for (auto& [words, count] : like_counts_) {
    if (count <= kMostLike) continue;
    print_line("and " + std::to_string(count - kMostLike) + " more warnings '" + words +
               "...'; 'alabaster check' shows up to " + std::to_string(kMostMessages));
    count = kMostLike;
  }
}

void Console::note(const std::string& text) {
  const std::lock_guard lock(mutex_);
  tell_counted();
  if (!quiet_) print_line(text);
}

void Console::error(const std::string& where, const std::string& text) {
  show({hd::Severity::error, "cli", where, text});
}

void Console::fail(int code, const std::string& where, const std::string& text) {
  error(where, text);
  throw Exit{code};
}

void Console::usage_error(const std::string& where, const std::string& text) {
  fail(kUsage, where, text);
}

void Console::require(int code, const std::string& where, const std::string& fault) {
  if (!fault.empty()) fail(code, where, fault);
}

void Console::require_usage(const std::string& where, const std::string& fault) {
  require(kUsage, where, fault);
}

void Console::write_file(const std::string& file, const std::string& text, const std::string& what,
                         hd::support::Flush flush) {
  const std::string problem =
      hd::support::WriteOutputFile(file, {reinterpret_cast<const uint8_t*>(text.data()), text.size()}, flush);
  if (!problem.empty()) fail(kOutput, file, what + " could not be written: " + problem + ".");
}

void Console::count_rest() {
  tell_counted();
  const char* kinds[] = {"notes", "warnings", "errors"};
  for (size_t kind = 0; kind < std::size(kinds); ++kind)
    if (unshown_[kind] > 0) print_line("and " + std::to_string(unshown_[kind]) + " more " + kinds[kind]);
}

void Console::print_line(const std::string& text) {
  if (bar_shown_) std::fputs("\r\033[K", stderr);
  bar_shown_ = false;
  std::fprintf(stderr, "%s\n", printable(text).c_str());
  std::fflush(stderr);
}

// A line that is longer than the window would wrap, and the next one would not replace it.
void Console::print_bar(double done, const std::string& text) {
  constexpr size_t kWidest = 30, kLeast = 5;
  const size_t width = terminal_width(), taken = text.size() + 4, room = width > taken ? width - taken : 0;
  std::string bar;
  if (room >= kLeast) {
    const size_t cells = std::min(room, kWidest);
    const auto filled = static_cast<size_t>(std::clamp(done, 0.0, 1.0) * double(cells));
    bar = "[" + std::string(filled, '=') + std::string(cells - filled, ' ') + "] ";
  }
  std::fprintf(stderr, "\r%s\033[K", (bar + text).substr(0, width - 1).c_str());
  std::fflush(stderr);
  bar_shown_ = true;
}

void Console::progress(const RecordProgress& p, double noise) {
  constexpr double kPause = 5;  // seconds
  const std::lock_guard lock(mutex_);
  if (quiet_) return;
  const std::string text = progress_text(p, noise);
  if (terminal_) return print_bar(is_denoising(p) ? p.denoised : p.fraction, text);
  const int tenths = static_cast<int>(std::clamp(p.fraction, 0.0, 1.0) * 10);
  if (tenths <= tenths_shown_ || p.seconds < seconds_shown_ + kPause) return;
  tenths_shown_ = tenths;
  seconds_shown_ = p.seconds;
  print_line(text);
}

size_t Console::warnings() const {
  const std::lock_guard lock(mutex_);
  return counts_[int(hd::Severity::warning)];
}

std::string Console::last_error() const {
  const std::lock_guard lock(mutex_);
  return last_error_;
}

void Console::end_progress() {
  const std::lock_guard lock(mutex_);
  if (bar_shown_) std::fputs("\n", stderr);
  bar_shown_ = false;
  tenths_shown_ = 0;
  seconds_shown_ = 0;
}

}  // namespace alabaster::cli
