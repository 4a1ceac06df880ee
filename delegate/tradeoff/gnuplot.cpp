#include "delegate/tradeoff/gnuplot.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cctype>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>
#include <system_error>

#include "delegate/support/output_file.h"
#include "delegate/tradeoff/temporary_folder.h"

namespace alabaster::tradeoff {
namespace {

namespace fs = std::filesystem;

constexpr const char* kNotInstalled = "The program gnuplot is not installed: install Debian's package gnuplot-nox.";

std::string content_of(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

/// Runs gnuplot without a shell, without the user's start-up files, and in a process group of its own: Ctrl-C in a
/// terminal goes to a whole group, but the caller decides if the plot is still drawn. Empty on success.
std::string run_gnuplot(const fs::path& script, const fs::path& messages) {
  posix_spawn_file_actions_t actions;
  ::posix_spawn_file_actions_init(&actions);
  ::posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  ::posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
  ::posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, messages.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
  std::string arguments[] = {"gnuplot", "--default-settings", script.string()};
  char* argv[] = {arguments[0].data(), arguments[1].data(), arguments[2].data(), nullptr};
  posix_spawnattr_t attributes;
  ::posix_spawnattr_init(&attributes);
  ::posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP);
  ::posix_spawnattr_setpgroup(&attributes, 0);
  pid_t child = 0;
  const int error = ::posix_spawnp(&child, argv[0], &actions, &attributes, argv, environ);
  ::posix_spawnattr_destroy(&attributes);
  ::posix_spawn_file_actions_destroy(&actions);
  if (error == ENOENT) return kNotInstalled;
  if (error != 0) return "The program gnuplot could not be started: " + std::generic_category().message(error) + ".";
  int status = 0;
  while (::waitpid(child, &status, 0) < 0)
    if (errno != EINTR)
      return "Waiting for the program gnuplot failed: " + std::generic_category().message(errno) + ".";
  if (WIFEXITED(status) && WEXITSTATUS(status) == 0) return {};
  return "gnuplot failed: " + content_of(messages) + "\nInstall Debian's package gnuplot-nox, or repair it.";
}

}  // namespace

std::string gnuplot_fault() {
  const char* const path = std::getenv("PATH");
  std::istringstream folders(path ? path : "");
  for (std::string folder; std::getline(folders, folder, ':');)
    if (::access((fs::path(folder) / "gnuplot").c_str(), X_OK) == 0) return {};
  return kNotInstalled;
}

// Double quotes, because gnuplot 5.4 misreads a doubled single quote at the beginning of a text.
std::string gnuplot_quoted(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    const bool plain = byte >= 128 || std::isalnum(byte) || std::strchr(" .,:-+=/%()_", c);
    char octal[8];
    std::snprintf(octal, sizeof octal, "\\%03o", unsigned(byte < 32 ? ' ' : byte));
    out += plain && c != 0 ? std::string(1, c) : std::string(octal);
  }
  return out + "\"";
}

std::string draw_with_gnuplot(const std::function<std::string(const std::string&)>& script, const std::string& file) {
  const TemporaryFolder folder("alabaster-plot-");
  if (folder.path().empty()) return "No temporary folder could be made for the plot: set $TMPDIR to a writable folder.";
  const fs::path text = folder.path() / "plot.gnuplot", drawn = folder.path() / "plot";
  std::ofstream(text) << script(drawn.string());
  std::string problem = run_gnuplot(text, folder.path() / "messages");
  if (!problem.empty()) return problem;
  const std::string bytes = content_of(drawn);
  if (bytes.empty()) return "gnuplot drew nothing: " + content_of(folder.path() / "messages");
  problem = hd::support::WriteOutputFile(file, {reinterpret_cast<const uint8_t*>(bytes.data()), bytes.size()});
  return problem.empty() ? problem : "'" + file + "' cannot be written: " + problem + ".";
}

}  // namespace alabaster::tradeoff
