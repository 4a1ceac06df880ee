// alabaster usd install: brings OpenUSD for Python, by pip, to where stages are read with it.
#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>

#include "delegate/cli/commands.h"
#include "delegate/cli/console.h"
#include "delegate/cli/exit_codes.h"

namespace alabaster::cli {
namespace {

namespace fs = std::filesystem;

// 26.11 refuses crate files older than 0.4.0.
constexpr const char* kPackages[] = {"usd-core==26.8", "MaterialX==1.39.5"};

/// build/usd of the program's own build folder, else the user's folder for data.
fs::path target_folder() {
  std::error_code error;
  const fs::path program = fs::read_symlink("/proc/self/exe", error), build = program.parent_path().parent_path();
  if (!error && fs::exists(build / "CMakeCache.txt", error)) return build.parent_path() / "usd";
  const auto variable = [](const char* name) {
    const char* const value = std::getenv(name);
    return fs::path(value ? value : "");
  };
  if (const fs::path data = variable("XDG_DATA_HOME"); data.is_absolute()) return data / "alabaster/usd";
  if (const fs::path home = variable("HOME"); home.is_absolute()) return home / ".local/share/alabaster/usd";
  return {};
}

/// The exit status of a program, whose messages are ours; -1: it cannot be started.
int run(std::vector<std::string> words) {
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  pid_t pid = -1;
  if (posix_spawnp(&pid, arguments[0], nullptr, nullptr, arguments.data(), environ) != 0) return -1;
  int status = 0;
  while (waitpid(pid, &status, 0) < 0 && errno == EINTR) {
  }
  return WIFEXITED(status) ? WEXITSTATUS(status) : 1;
}

}  // namespace

int run_usd(const UsdArguments& a) {
  Console console(false);
  if (a.action != "install")
    console.usage_error("usd", "'" + a.action + "' is nothing that it does: write `alabaster usd install`.");
  const fs::path target = target_folder();
  if (target.empty()) console.usage_error("usd install", "There is no folder for it: set HOME or XDG_DATA_HOME.");
  std::error_code error;
  fs::create_directories(target.parent_path(), error);
  std::string part = target.string() + ".XXXXXX";
  if (error || !mkdtemp(part.data())) {
    console.error(target.string(), std::string("It cannot be written: ") + std::strerror(errno));
    return kOutput;
  }
  std::vector<std::string> words = {"python3", "-m", "pip", "install", "--target", part};
  for (const char* word : {"--quiet", "--disable-pip-version-check", "--root-user-action=ignore", "--retries=1",
                           "--no-deps", "--only-binary=:all:"})
    words.emplace_back(word);
  if (!a.from.empty())
    for (const std::string& word : {std::string("--no-index"), "--find-links=" + a.from}) words.push_back(word);
  words.insert(words.end(), std::begin(kPackages), std::end(kPackages));
  console.note("installing OpenUSD into " + target.string() + ", which may take a minute");
  const int status = run(words);
  const std::string check =
      "import sys; sys.path.insert(0, sys.argv[1]); from pxr import Usd; print('OpenUSD %d.%d' % Usd.GetVersion()[1:])";
  if (status != 0 || run({"python3", "-I", "-c", check, part}) != 0) {
    fs::remove_all(part, error);
    console.error("usd install",
                  status < 0
                      ? "There is no python3: install it first (Debian: apt-get install python3-pip)."
                      : "It was not installed: see above. It needs Python 3.11 to 3.14 with pip (Debian: apt-get "
                        "install python3-pip), and PyPI, or with --from the wheels in a folder.");
    return kInput;
  }
  fs::remove_all(target, error);
  fs::permissions(part, fs::perms(0755), error);
  fs::rename(part, target, error);
  if (error) {
    console.error(target.string(), "It cannot be written: " + error.message());
    return kOutput;
  }
  console.note("installed in " + target.string());
  return kDone;
}

}  // namespace alabaster::cli
