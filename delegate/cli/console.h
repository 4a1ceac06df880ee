// The program's output to people: diagnostics and progress, all on standard error.
#pragma once

#include <map>
#include <mutex>
#include <string>

#include "delegate/host/frame_recorder.h"
#include "delegate/support/output_file.h"

namespace alabaster::cli {

/// `text` without characters that a terminal would obey: each control character as \xNN, and further lines indented, so
/// that no name in a file can pass for a message of ours.
std::string printable(const std::string& text);

/// Any thread. After a hundred errors or warnings further ones are only counted, but for those that end a run. With
/// `quiet` only errors and warnings are shown.
class Console {
 public:
  /// Like warnings begin with the same words, as those of several meshes do. `all` shows each; else the first three are
  /// shown and the others counted.
  enum class Like { counted, all };
  explicit Console(bool quiet, Like like = Like::counted);
  ~Console() { count_rest(); }
  Console(const Console&) = delete;
  Console& operator=(const Console&) = delete;

  /// A sink that prints here and lives no longer than this console.
  hd::DiagnosticSink sink();
  void note(const std::string& text);
  void error(const std::string& where, const std::string& text);
  /// Reports an error and ends the command with the exit code.
  [[noreturn]] void fail(int code, const std::string& where, const std::string& text);
  /// The same for a fault of the command line.
  [[noreturn]] void usage_error(const std::string& where, const std::string& text);
  // These do so if there is a fault or a problem, a sentence.
  void require(int code, const std::string& where, const std::string& fault);
  void require_usage(const std::string& where, const std::string& fault);

  /// Writes a file, or reports that `what` could not be written and ends the command.
  void write_file(const std::string& file, const std::string& text, const std::string& what,
                  hd::support::Flush flush = hd::support::Flush::disk);

  /// Shows a bar that redraws itself on a terminal, within the width of its window. Elsewhere prints a line at every
  /// tenth, but not within five seconds of the last one. `noise`: the relative RMSE so far; negative: not known.
  void progress(const hd::host::RecordProgress& progress, double noise = -1);
  /// Leaves the bar as it is; the next text starts on a new line.
  void end_progress();
  /// The number of warnings so far.
  size_t warnings() const;
  /// The error that was told last, in a line; empty: none.
  std::string last_error() const;

 private:
  void show(const hd::Diagnostic& diagnostic);
  bool is_counted(const hd::Diagnostic& diagnostic);
  void tell_counted();
  void count_rest();
  void print_line(const std::string& text);
  void print_bar(double done, const std::string& text);

  const bool quiet_, terminal_;
  const Like like_;
  mutable std::mutex mutex_;
  std::string last_error_;
  bool bar_shown_ = false;
  size_t counts_[3] = {0, 0, 0}, unshown_[3] = {0, 0, 0};  // of messages, by severity
  std::map<std::string, size_t> like_counts_;              // of warnings, by their code and first words
  int tenths_shown_ = 0;
  double seconds_shown_ = 0;
};

/// The text that printf would print.
[[gnu::format(printf, 1, 2)]] std::string formatted(const char* pattern, ...);

/// "1:02:03" or "2:03"; "--:--" of a time that is not known.
std::string time_text(double seconds);

}  // namespace alabaster::cli
