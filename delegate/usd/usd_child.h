// The process that reads a stage of OpenUSD (alabaster_usd/child.py), and what it is asked. Faults of OpenUSD end it,
// not the program; it may read some folders only.
#pragma once

#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <vector>

namespace alabaster::hd::usd {

/// Where a stage lies, and what is wrong with it.
struct Fault : std::runtime_error {
  explicit Fault(const std::string& text, std::string place = {}, bool memory = false)
      : std::runtime_error(text), where(std::move(place)), out_of_memory(memory) {}
  std::string where;  // a file with its line, or a prim; empty: the stage
  bool out_of_memory;
};
/// The text and the place of a fault as the child sends it.
Fault fault_of(const nlohmann::json& sent);

/// A descriptor, closed at the end.
class Descriptor {
 public:
  explicit Descriptor(int fd = -1) : fd_(fd) {}
  ~Descriptor();
  Descriptor(Descriptor&& o) noexcept : fd_(o.fd_) { o.fd_ = -1; }
  Descriptor& operator=(Descriptor&& o) noexcept {
    std::swap(fd_, o.fd_);
    return *this;
  }
  int get() const { return fd_; }
  explicit operator bool() const { return fd_ >= 0; }

 private:
  int fd_;
};

struct ChildOptions {
  std::vector<std::string> folders;  // real paths that may be read
  bool everywhere = false;           // all may
  size_t memory = 0;                 // bytes of its address space; 0: no limit
  double seconds = 30;               // CPU time of one request; and how long it may wait without using any
};

/// Where OpenUSD for Python lies: a folder that holds `pxr`, and the interpreter. The folder is empty for the
/// interpreter's own, which may have none.
struct Installation {
  std::string interpreter, folder;
};
Installation find_installation();

/// One thread.
class Child {
 public:
  /// Throws Fault where it cannot be started, or there is no OpenUSD.
  explicit Child(const ChildOptions& options);
  ~Child();
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;

  struct Answer {
    nlohmann::json text;
    Descriptor file;  // a sealed file, if the answer has one
  };
  /// Throws Fault: that of the answer, or the end of the child with its reason.
  Answer ask(const nlohmann::json& request);
  /// The answer to the greeting: versions, and "landlock" or null.
  const nlohmann::json& about() const { return about_; }

 private:
  void start(const Installation& found);
  double used_seconds() const;  // CPU time; below 0: it has ended
  bool is_runnable() const;     // a thread of it runs, or would if it got a processor
  void allow_time();
  void drain();
  [[noreturn]] void fail_ended();

  ChildOptions options_;
  nlohmann::json about_;
  int pid_ = -1;
  Descriptor socket_, errors_;
  std::string said_;  // the last 4 KiB of its standard error
};

/// The bytes of a sealed file. Throws Fault.
std::string contents(const Descriptor& file);

}  // namespace alabaster::hd::usd
