// The file that tells that a task of a farm is running: there while its process lives, locked by it, and touched each
// half minute. A process that is killed leaves it behind.
#pragma once

#include <condition_variable>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

namespace alabaster::cli {

class RunningMark {
 public:
  RunningMark() = default;
  /// Removes the file.
  ~RunningMark();
  RunningMark(const RunningMark&) = delete;
  RunningMark& operator=(const RunningMark&) = delete;

  /// Makes the file, unless another process that lives has it. Returns nothing, or why it cannot be made.
  std::string begin(const std::string& file);

 private:
  void touch(const std::stop_token& stop);

  std::string file_;
  int descriptor_ = -1;
  std::mutex mutex_;
  std::condition_variable_any ended_;
  std::jthread touching_;
};

/// What a mark tells. Processes of this machine are known to live or not, by the lock; of others, and where the file
/// system has no locks, one lives that gave a sign not long ago.
struct RunningSign {
  std::string host;
  double began = 0, age = 0;  // seconds since it began, and since its last sign
  bool lives = false, is_known = false;
  bool told_to_end = false;  // by a signal, before there was anything to save
};
/// Nothing: there is no such file, or no mark in it.
std::optional<RunningSign> read_running_mark(const std::string& file);

/// The name of this machine.
std::string host_name();

}  // namespace alabaster::cli
