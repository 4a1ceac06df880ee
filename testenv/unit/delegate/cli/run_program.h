// Runs the program alabaster as a person would, and keeps its output.
#pragma once

#include <fcntl.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <functional>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include "testenv/support/build_paths.h"

namespace alabaster::cli {

/// A running `alabaster ARGUMENTS` in `folder`, with its outputs in files there. The destructor kills it if it still
/// runs.
class Program {
 public:
  /// `prepare` runs in the child before the program does: it may set limits or redirect outputs.
  Program(const std::filesystem::path& folder, const std::vector<std::string>& arguments,
          const std::function<void()>& prepare = {})
      : folder_(folder) {
    std::vector<std::string> words{testing::kProgram};
    words.insert(words.end(), arguments.begin(), arguments.end());
    std::vector<char*> argv;
    for (std::string& word : words) argv.push_back(word.data());
    argv.push_back(nullptr);
    const std::string out = folder / "stdout.txt", err = folder / "stderr.txt", where = folder;
    for (const std::string& earlier : {out, err})
      std::filesystem::remove(earlier);  // an earlier run's, which wait_for must not see
    pid_ = fork();
    if (pid_ != 0) return;
    const int out_file = open(out.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
    const int err_file = open(err.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
    if (dup2(out_file, STDOUT_FILENO) < 0 || dup2(err_file, STDERR_FILENO) < 0 || chdir(where.c_str()) != 0) _exit(99);
    unsetenv("OCIO");
    if (prepare) prepare();
    execv(argv[0], argv.data());
    _exit(99);
  }
  ~Program() {
    if (pid_ <= 0 || waited_) return;
    kill(pid_, SIGKILL);
    wait();
  }
  Program(const Program&) = delete;
  Program& operator=(const Program&) = delete;

  pid_t pid() const { return pid_; }
  void interrupt() const { send(SIGINT); }
  void send(int signal) const { kill(pid_, signal); }
  /// The exit code; -1 if a signal ended it.
  int wait() {
    int status = 0;
    while (!waited_ && waitpid(pid_, &status, 0) < 0 && errno == EINTR) {
    }
    waited_ = true;
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }
  std::string out() const { return read("stdout.txt"); }
  std::string err() const { return read("stderr.txt"); }
  /// Waits until standard error contains `text`; false after `seconds`.
  bool wait_for(const std::string& text, double seconds) const {
    const auto until = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
    while (err().find(text) == std::string::npos) {
      if (std::chrono::steady_clock::now() > until) return false;
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    return true;
  }

 private:
  std::string read(const char* name) const {
    std::ifstream file(folder_ / name, std::ios::binary);
    std::ostringstream text;
    text << file.rdbuf();
    return text.str();
  }

  std::filesystem::path folder_;
  pid_t pid_ = -1;
  bool waited_ = false;
};

struct Outcome {
  int code;
  std::string out, err;
};

/// Runs `alabaster ARGUMENTS` to its end.
inline Outcome run_program(const std::filesystem::path& folder, const std::vector<std::string>& arguments,
                           const std::function<void()>& prepare = {}) {
  Program program(folder, arguments, prepare);
  const int code = program.wait();
  return {code, program.out(), program.err()};
}

}  // namespace alabaster::cli
