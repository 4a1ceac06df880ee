#include "delegate/cli/running_mark.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstring>
#include <fstream>
#include <nlohmann/json.hpp>

#include "delegate/cli/interrupt.h"

namespace alabaster::cli {
namespace {

using nlohmann::json;

constexpr std::chrono::seconds kBeat(30);
// File systems of networks tell the time of a file as much as a minute late.
constexpr double kSilence = 180;

/// Another at each start of a machine's kernel, so that marks of this one are known.
std::string boot_id() {
  std::ifstream file("/proc/sys/kernel/random/boot_id");
  std::string id;
  file >> id;
  return id;
}

/// A lock of the open file: it ends with its process, however that ends.
bool lock(int descriptor) {
  struct flock range = {};
  range.l_type = F_WRLCK, range.l_whence = SEEK_SET;
  return fcntl(descriptor, F_OFD_SETLK, &range) == 0;
}

bool is_locked(int descriptor) {
  struct flock range = {};
  range.l_type = F_RDLCK, range.l_whence = SEEK_SET;
  return fcntl(descriptor, F_OFD_GETLK, &range) == 0 && range.l_type != F_UNLCK;
}

std::string text_in(int descriptor) {
  char bytes[4096];
  const ssize_t size = pread(descriptor, bytes, sizeof bytes, 0);
  return {bytes, static_cast<size_t>(std::max<ssize_t>(size, 0))};
}

std::optional<json> mark_in(const std::string& text) {
  json mark = json::parse(text, nullptr, false);
  const auto is = [&](const char* key, auto kind) { return mark.contains(key) && (mark[key].*kind)(); };
  if (!mark.is_object() || !is("host", &json::is_string) || !is("boot", &json::is_string) ||
      !is("locked", &json::is_boolean) || !is("began", &json::is_number) || !is("signal", &json::is_number))
    return std::nullopt;
  return mark;
}

double now() {
  return std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()).count();
}

}  // namespace

std::string host_name() {
  char name[256] = {};
  return gethostname(name, sizeof name - 1) == 0 ? name : "";
}

std::string RunningMark::begin(const std::string& file) {
  const int descriptor = open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
  if (descriptor < 0)
    return "It cannot be written: " + std::string(std::strerror(errno)) + ". Check its folder and your permissions.";
  const std::string before = text_in(descriptor);
  if (!before.empty() && !mark_in(before)) {
    close(descriptor);
    return "It is a file of something else: give another name.";
  }
  const bool locked = lock(descriptor);
  if (!locked && is_locked(descriptor)) {  // the task runs twice; the other one tells
    close(descriptor);
    return {};
  }
  std::string text = json{{"host", host_name()}, {"boot", boot_id()}, {"locked", locked}, {"began", now()}}.dump(
      -1, ' ', false, json::error_handler_t::replace);
  text.back() = ',';
  text += "\"signal\":0}\n";
  set_told_of_end(descriptor, off_t(text.size()) - 3);  // before anybody reads that it runs
  if (ftruncate(descriptor, 0) != 0 || pwrite(descriptor, text.data(), text.size(), 0) != ssize_t(text.size())) {
    const std::string why = std::strerror(errno);
    set_told_of_end(-1, 0);
    close(descriptor);
    return "It cannot be written: " + why + ". Check the space on the disk.";
  }
  file_ = file, descriptor_ = descriptor;
  touching_ = std::jthread([this](const std::stop_token& stop) { touch(stop); });
  return {};
}

RunningMark::~RunningMark() {
  if (descriptor_ < 0) return;
  set_told_of_end(-1, 0);
  touching_.request_stop();
  touching_.join();
  struct stat named = {}, own = {};
  const bool is_own = stat(file_.c_str(), &named) == 0 && fstat(descriptor_, &own) == 0 && named.st_ino == own.st_ino &&
                      named.st_dev == own.st_dev;
  if (is_own) unlink(file_.c_str());  // another farm may have taken its place
  close(descriptor_);
}

void RunningMark::touch(const std::stop_token& stop) {
  std::unique_lock held(mutex_);
  while (!stop.stop_requested()) {
    ended_.wait_for(held, stop, kBeat, [] { return false; });
    futimens(descriptor_, nullptr);
  }
}

std::optional<RunningSign> read_running_mark(const std::string& file) {
  const int descriptor = open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (descriptor < 0) return std::nullopt;
  const bool locked = is_locked(descriptor);
  struct stat about = {};
  const bool is_there = fstat(descriptor, &about) == 0;
  const std::optional<json> mark = mark_in(text_in(descriptor));
  close(descriptor);
  if (!mark || !is_there) return std::nullopt;
  RunningSign sign;
  sign.host = mark->at("host");
  sign.told_to_end = mark->at("signal") != 0;
  const double last = double(about.st_mtim.tv_sec) + 1e-9 * double(about.st_mtim.tv_nsec);
  sign.began = std::max(0.0, now() - mark->at("began").get<double>());
  sign.age = std::max(0.0, now() - last);
  sign.is_known = locked || (mark->at("locked") && mark->at("boot") == boot_id());
  sign.lives = sign.is_known ? locked : sign.age < kSilence;
  return sign;
}

}  // namespace alabaster::cli
