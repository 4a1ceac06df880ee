#include "delegate/usd/usd_child.h"

#include <dlfcn.h>
#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>

namespace alabaster::hd::usd {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr int kProtocol = 1;
constexpr size_t kMostMessage = 1 << 16, kMostSaid = 4096;
constexpr int kSeals = F_SEAL_SHRINK | F_SEAL_GROW | F_SEAL_WRITE | F_SEAL_SEAL;
constexpr const char* kInstall = "Install it with `alabaster usd install`.";

std::string variable(const char* name) {
  const char* const value = std::getenv(name);
  return value ? value : "";
}

bool is_file(const fs::path& path) {
  std::error_code error;
  return fs::is_regular_file(path, error);
}
bool has_usd(const fs::path& folder) {
  return is_file(folder / "pxr/__init__.py");
}

/// The folder of the library that holds this code; empty if it cannot be told.
fs::path own_folder() {
  Dl_info info{};
  if (!dladdr(reinterpret_cast<const void*>(&find_installation), &info) || !info.dli_fname) return {};
  std::error_code error;
  const fs::path file = fs::canonical(info.dli_fname, error);
  return error ? fs::path() : file.parent_path();
}

/// The reader's own files, which lie beside the library in the build and in an installation.
std::string reader_script() {
  const fs::path own = own_folder();
  // In a wheel the library lies in the package's folder of libraries.
  for (const fs::path& folder : {own / "alabaster", own, own.parent_path() / "hdalabaster"})
    if (const fs::path script = folder / "alabaster_usd/child.py"; is_file(script)) return script.string();
  throw Fault("The reader of stages is not installed beside " + own.string() + ". Install Alabaster again.");
}

std::string seconds_text(double seconds) {
  std::array<char, 32> number{};
  std::snprintf(number.data(), number.size(), "%g s", seconds);
  return number.data();
}

std::string ending(int status, double seconds) {
  if (WIFSIGNALED(status) && WTERMSIG(status) == SIGXCPU)
    return "it took more than " + seconds_text(seconds) + " of CPU time. Allow more with --usd-limit SECONDS";
  if (WIFSIGNALED(status)) return std::string("OpenUSD ended by the signal ") + strsignal(WTERMSIG(status));
  return "OpenUSD ended with code " + std::to_string(WEXITSTATUS(status));
}

}  // namespace

Fault fault_of(const json& sent) {
  std::string place = sent.value("file", "");
  if (const int line = sent.value("line", 0); line > 0) place += ":" + std::to_string(line);
  std::string prim = sent.value("prim", "");
  if (!prim.empty()) place += (place.empty() ? "" : ": ") + prim;
  return Fault(sent.value("text", "it cannot be read"), place, sent.value("memory", false));
}

Descriptor::~Descriptor() {
  if (fd_ >= 0) close(fd_);
}

Installation find_installation() {
  const std::string python = "python3";
  if (const std::string named = variable("ALABASTER_USD"); !named.empty())
    return is_file(named) ? Installation{named, ""} : Installation{python, named};
  const fs::path own = own_folder();
  std::vector<fs::path> places = {own.parent_path() / "usd", own.parent_path().parent_path() / "usd",
                                  own / "alabaster/usd"};
  // In a wheel: pxr lies beside the Python module that holds this library.
  for (fs::path place = own; place.has_relative_path(); place = place.parent_path())
    if (place.filename() == "site-packages" || place.filename() == "dist-packages") places.push_back(place);
  if (const std::string data = variable("XDG_DATA_HOME"); !data.empty())
    places.push_back(fs::path(data) / "alabaster/usd");
  if (const std::string home = variable("HOME"); !home.empty())
    places.push_back(fs::path(home) / ".local/share/alabaster/usd");
  for (const fs::path& place : places)
    if (has_usd(place)) return {python, place.string()};
  return {python, ""};
}

Child::Child(const ChildOptions& options) : options_(options) {
  const Installation found = find_installation();
  start(found);
  Answer hello = ask({{"do", "hello"},
                      {"protocol", kProtocol},
                      {"folders", options_.folders},
                      {"everywhere", options_.everywhere},
                      {"bytes", options_.memory},
                      {"seconds", options_.seconds}});
  if (hello.text.contains("missing"))
    throw Fault("Stages of OpenUSD need its Python package (usd-core), and " +
                (found.folder.empty()
                     ? found.interpreter + " has none"
                     : "that in " + found.folder + " cannot be loaded: " + hello.text["missing"].get<std::string>()) +
                ". " + kInstall);
  about_ = std::move(hello.text);
}

// Its own environment: nothing of PYTHON*, LD_*, PXR_* and USD* reaches it, and no descriptor but the socket and
// stderr.
void Child::start(const Installation& found) {
  const std::string script = reader_script();
  std::array<int, 2> pair{}, pipe{};
  if (socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, pair.data()) != 0 || pipe2(pipe.data(), O_CLOEXEC) != 0)
    throw Fault(std::string("no process can be started for OpenUSD: ") + std::strerror(errno));
  socket_ = Descriptor(pair[0]), errors_ = Descriptor(pipe[0]);
  const Descriptor theirs(pair[1]), said(pipe[1]);
  fcntl(errors_.get(), F_SETFL, O_NONBLOCK);

  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  // Above those that are given to it, so that none is overwritten before it is copied.
  const Descriptor high(fcntl(theirs.get(), F_DUPFD_CLOEXEC, 10)), high_said(fcntl(said.get(), F_DUPFD_CLOEXEC, 10));
  posix_spawn_file_actions_addopen(&actions, 0, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_addopen(&actions, 1, "/dev/null", O_WRONLY, 0);
  posix_spawn_file_actions_adddup2(&actions, high_said.get(), 2);
  posix_spawn_file_actions_adddup2(&actions, high.get(), 3);
  posix_spawn_file_actions_addclosefrom_np(&actions, 4);
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  sigset_t none, defaults;
  sigemptyset(&none), sigfillset(&defaults);
  posix_spawnattr_setsigmask(&attributes, &none), posix_spawnattr_setsigdefault(&attributes, &defaults);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF);

  std::vector<std::string> words = {found.interpreter, "-I", script, found.folder};
  const std::string path = variable("PATH");
  std::vector<std::string> environment = {"PATH=" + (path.empty() ? "/usr/local/bin:/usr/bin:/bin" : path),
                                          "LANG=C.UTF-8"};
  std::vector<char*> arguments, variables;
  for (std::string& word : words) arguments.push_back(word.data());
  for (std::string& one : environment) variables.push_back(one.data());
  arguments.push_back(nullptr), variables.push_back(nullptr);
  const int error =
      posix_spawnp(&pid_, found.interpreter.c_str(), &actions, &attributes, arguments.data(), variables.data());
  posix_spawn_file_actions_destroy(&actions);
  posix_spawnattr_destroy(&attributes);
  if (error != 0) {
    pid_ = -1;
    throw Fault("Stages of OpenUSD are read by Python 3, and '" + found.interpreter + "' cannot be started (" +
                std::strerror(error) + "). Install Python 3, then OpenUSD with `alabaster usd install`.");
  }
}

Child::~Child() {
  if (pid_ < 0) return;
  socket_ = Descriptor();
  kill(pid_, SIGKILL);
  while (waitpid(pid_, nullptr, 0) < 0 && errno == EINTR) {
  }
}

double Child::used_seconds() const {
  clockid_t clock{};
  timespec used{};
  if (clock_getcpuclockid(pid_, &clock) != 0 || clock_gettime(clock, &used) != 0) return -1;
  return double(used.tv_sec) + 1e-9 * double(used.tv_nsec);
}

bool Child::is_runnable() const {
  std::error_code error;
  for (fs::directory_iterator at("/proc/" + std::to_string(pid_) + "/task", error), end; !error && at != end;
       at.increment(error)) {
    std::string text;
    std::getline(std::ifstream(at->path() / "stat"), text);
    const size_t name_end = text.rfind(") ");
    if (name_end != std::string::npos && text[name_end + 2] == 'R') return true;
  }
  return false;
}

// A limit of what it has used and may use more: a long sequence does not use it up.
void Child::allow_time() {
  const double used = used_seconds();
  if (used < 0) return;
  const double all = std::ceil(std::floor(used) + options_.seconds + 1);
  rlimit limit{};
  if (prlimit(pid_, RLIMIT_CPU, nullptr, &limit) != 0) return;
  limit.rlim_cur = std::min(rlim_t(all), limit.rlim_max);
  prlimit(pid_, RLIMIT_CPU, &limit, nullptr);
}

void Child::drain() {
  std::array<char, 4096> bytes{};
  for (ssize_t n = 0; (n = read(errors_.get(), bytes.data(), bytes.size())) > 0;) {
    said_.append(bytes.data(), size_t(n));
    if (said_.size() > kMostSaid) said_.erase(0, said_.size() - kMostSaid);
  }
}

// One that has shut its socket is about to end; one that does not within two seconds is ended.
void Child::fail_ended() {
  int status = 0;
  for (int waits = 0; waitpid(pid_, &status, WNOHANG) == 0; ++waits) {
    if (waits == 200) kill(pid_, SIGKILL);
    poll(nullptr, 0, 10);
  }
  pid_ = -1;
  drain();
  const size_t end = said_.find_last_not_of(" \n");
  const size_t line = end == std::string::npos ? 0 : said_.rfind('\n', end) + 1;
  const std::string last = end == std::string::npos ? "" : said_.substr(line, end + 1 - line);
  const bool memory = said_.find("MemoryError") != std::string::npos || said_.find("bad_alloc") != std::string::npos;
  throw Fault(
      "The stage was not read: " + (memory ? "OpenUSD had not enough memory" : ending(status, options_.seconds)) +
          (last.empty() ? "." : ". Its last words: " + last),
      {}, memory);
}

Child::Answer Child::ask(const json& request) {
  const std::string text = request.dump(-1, ' ', false, json::error_handler_t::replace);
  if (text.size() > kMostMessage)
    throw Fault("a request to OpenUSD is too long: give fewer folders, masks and variants");
  allow_time();
  if (send(socket_.get(), text.data(), text.size(), MSG_NOSIGNAL) < 0) fail_ended();
  json parts = json::object();  // of the answer, which come before it
  double used = -1;
  int idle = 0;  // seconds, counted by themselves: a program that is stopped does not wait
  for (;;) {
    std::array<pollfd, 2> wait = {{{socket_.get(), POLLIN, 0}, {errors_.get(), POLLIN, 0}}};
    const int ready = poll(wait.data(), wait.size(), 1000);
    if (ready < 0 && errno != EINTR) fail_ended();
    if (ready == 0) {
      const double now = used_seconds();
      // OpenUSD's threads look now and then. One that gets no processor does not wait for a file.
      idle = now < used + 0.02 && !is_runnable() ? idle + 1 : 0, used = now;
      if (idle > options_.seconds)
        throw Fault("The stage was not read: OpenUSD waited more than " + seconds_text(options_.seconds) +
                    " for a file: a pipe, or a share that does not answer. Allow more with --usd-limit SECONDS.");
      continue;
    }
    idle = 0;
    drain();
    if (!(wait[0].revents & (POLLIN | POLLHUP))) {
      if (wait[1].revents & POLLHUP) fail_ended();
      continue;
    }
    std::string got(kMostMessage, '\0');
    alignas(cmsghdr) std::array<char, CMSG_SPACE(sizeof(int))> control{};
    iovec part = {got.data(), got.size()};
    msghdr message{};
    message.msg_iov = &part, message.msg_iovlen = 1;
    message.msg_control = control.data(), message.msg_controllen = control.size();
    const ssize_t size = recvmsg(socket_.get(), &message, MSG_CMSG_CLOEXEC);
    if (size < 0 && errno == EINTR) continue;
    if (size <= 0) fail_ended();
    Answer answer;
    if (const cmsghdr* const sent = CMSG_FIRSTHDR(&message); sent && sent->cmsg_type == SCM_RIGHTS) {
      int fd = -1;
      std::memcpy(&fd, CMSG_DATA(sent), sizeof fd);
      answer.file = Descriptor(fd);
      if ((fcntl(fd, F_GET_SEALS) & kSeals) != kSeals) throw Fault("the reader's answer is not sealed");
    }
    answer.text = json::parse(got.begin(), got.begin() + size, nullptr, false);
    if (!answer.text.is_object() || (message.msg_flags & MSG_TRUNC))
      throw Fault("the reader's answer is no JSON object, or too long");
    if (answer.text.contains("progress")) continue;
    if (answer.text.contains("part")) {
      for (const auto& [name, list] : answer.text["part"].items())
        for (const json& one : list) parts[name].push_back(one);
      continue;
    }
    for (const auto& [name, list] : parts.items())
      for (const json& one : answer.text[name]) parts[name].push_back(one);
    answer.text.update(parts);
    if (answer.text.contains("fault")) throw fault_of(answer.text["fault"]);
    return answer;
  }
}

std::string contents(const Descriptor& file) {
  struct stat status {};
  if (!file || fstat(file.get(), &status) != 0) throw Fault("the reader's answer has no file");
  std::string text(size_t(status.st_size), '\0');
  size_t at = 0;
  for (ssize_t n = 0; at < text.size(); at += size_t(n))
    if ((n = pread(file.get(), text.data() + at, text.size() - at, off_t(at))) <= 0)
      throw Fault("the reader's answer cannot be read");
  return text;
}

}  // namespace alabaster::hd::usd
