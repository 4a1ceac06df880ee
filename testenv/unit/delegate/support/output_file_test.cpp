// Outputs harm nothing: links, devices and read-only files stay as they are.
#include "delegate/support/output_file.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/sysmacros.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <climits>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <new>
#include <system_error>
#include <thread>

namespace alabaster::hd::support {
namespace {

namespace fs = std::filesystem;

/// Errors that the system answers with, as shares do. 0: it does what it is asked.
struct Errors {
  int file_sync = 0, folder_sync = 0, mode = 0;
};
Errors g_errors;

/// The system answers with them while it lives.
struct Answers {
  explicit Answers(const Errors& errors) { g_errors = errors; }
  ~Answers() { g_errors = {}; }
  Answers(const Answers&) = delete;
  Answers& operator=(const Answers&) = delete;
};

class OutputFile : public ::testing::Test {
 protected:
  void SetUp() override {
    const std::string name = ::testing::UnitTest::GetInstance()->current_test_info()->name();
    folder_ = fs::temp_directory_path() / ("alabaster_" + name + std::to_string(::getpid()));
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  std::string path(const std::string& name) const { return folder_ / name; }
  std::string put(const std::string& name, const std::string& text, mode_t mode = 0644) const {
    std::ofstream(path(name)) << text;
    ::chmod(path(name).c_str(), mode);
    return path(name);
  }
  std::string write(const std::string& name, const std::string& text) const {
    return WriteOutputFile(path(name), {reinterpret_cast<const uint8_t*>(text.data()), text.size()});
  }
  std::string text(const std::string& name) const {
    std::ifstream in(path(name));
    return {std::istreambuf_iterator<char>(in), {}};
  }
  size_t count() const { return size_t(std::distance(fs::directory_iterator(folder_), {})); }
  mode_t mode(const std::string& name) const {
    struct stat now = {};
    return ::lstat(path(name).c_str(), &now) == 0 ? now.st_mode : 0;
  }

  fs::path folder_;
};

// Each fault names its remedy.
TEST_F(OutputFile, FaultsOfFoldersAreNamed) {
  put("a", "text");
  EXPECT_EQ(OutputFault(path("a/b.exr")), "'" + path("a") + "' is a file and not a folder; choose another");
  EXPECT_EQ(OutputFault(path("gone/b.exr")), "there is no folder '" + path("gone") + "'; create it or choose another");
  fs::create_symlink("round", path("round"));
  EXPECT_NE(OutputFault(path("round")).find("correct the links"), std::string::npos) << OutputFault(path("round"));
  struct rlimit before = {};
  ASSERT_EQ(::getrlimit(RLIMIT_NOFILE, &before), 0);
  const struct rlimit none = {0, before.rlim_max};
  ASSERT_EQ(::setrlimit(RLIMIT_NOFILE, &none), 0);
  const std::string fault = OutputFault(path("b.exr"));
  ASSERT_EQ(::setrlimit(RLIMIT_NOFILE, &before), 0);
  EXPECT_NE(fault.find("Too many open files"), std::string::npos) << fault;
  EXPECT_NE(fault.find("ulimit -n"), std::string::npos) << fault;
}

// promise: pipeline.output.new, pipeline.output.replaced
TEST_F(OutputFile, ANewFileIsMadeAndAnOldOneReplacedWithItsMode) {
  EXPECT_EQ(write("a", "one"), "");
  EXPECT_EQ(text("a"), "one");
  put("b", "before", 0600);
  EXPECT_EQ(write("b", "two"), "");
  EXPECT_EQ(text("b"), "two");
  EXPECT_EQ(mode("b"), mode_t(S_IFREG | 0600));
  EXPECT_EQ(count(), 2u);
}

// promise: pipeline.output.link
TEST_F(OutputFile, SymbolicLinksAreFollowed) {
  put("target", "before");
  fs::create_symlink("target", path("link"));
  fs::create_symlink("later", path("dangling"));
  EXPECT_EQ(write("link", "one"), "");
  EXPECT_EQ(write("dangling", "two"), "");
  EXPECT_TRUE(S_ISLNK(mode("link")) && S_ISLNK(mode("dangling")));
  EXPECT_EQ(text("target"), "one");
  EXPECT_EQ(text("later"), "two");
  fs::create_symlink("circle", path("circle"));
  EXPECT_NE(write("circle", "three"), "");
  EXPECT_NE(OutputFault(path("circle")), "");
}

// An output of a file from a stranger stays in that file's folder, wherever its name leads.
// promise: security.writes
TEST_F(OutputFile, AFolderThatIsGivenIsNotLeft) {
  fs::create_directories(folder_ / "in" / "below");
  fs::create_directories(folder_ / "out");
  put("out/precious", "before");
  const std::string in = fs::canonical(folder_ / "in").string();
  const auto write_in = [&](const std::string& name, const std::string& contents) {
    return WriteOutputFile(path(name), {reinterpret_cast<const uint8_t*>(contents.data()), contents.size()},
                           Flush::none, in);
  };
  fs::create_symlink("../out/precious", path("in/link"));
  fs::create_symlink("../out/new", path("in/dangling"));
  fs::create_directory_symlink("../out", path("in/folder"));
  fs::create_symlink("/dev/null", path("in/device"));
  for (const char* name : {"in/link", "in/dangling", "in/folder/new", "in/../out/precious", "out/new", "in/device"}) {
    EXPECT_NE(OutputFault(path(name), in).find("outside the folder"), std::string::npos) << name;
    EXPECT_NE(write_in(name, "after").find("outside the folder"), std::string::npos) << name;
  }
  EXPECT_EQ(text("out/precious"), "before");
  EXPECT_FALSE(fs::exists(path("out/new")));
  fs::create_symlink(folder_ / "in" / "below" / "target", path("in/absolute"));
  for (const char* name : {"in/plain", "in/absolute", "in/below/../below/b"}) {
    EXPECT_EQ(OutputFault(path(name), in), "") << name;
    EXPECT_EQ(write_in(name, "written"), "") << name;
  }
  EXPECT_EQ(text("in/below/target"), "written");
  EXPECT_TRUE(S_ISLNK(mode("in/absolute")));
  ASSERT_EQ(::mkfifo(path("in/fifo").c_str(), 0600), 0);
  EXPECT_NE(write_in("in/fifo", "nobody reads"), "");
}

// promise: pipeline.output.refused, security.outputs
TEST_F(OutputFile, AReadOnlyFileIsKept) {
  put("a", "before", 0444);
  EXPECT_NE(OutputFault(path("a")).find("read-only"), std::string::npos);
  EXPECT_NE(write("a", "after"), "");
  EXPECT_EQ(text("a"), "before");
}

// promise: pipeline.output.fifo
TEST_F(OutputFile, AFifoIsWrittenIntoAndStaysOne) {
  ASSERT_EQ(::mkfifo(path("fifo").c_str(), 0600), 0);
  EXPECT_EQ(OutputFault(path("fifo")), "");
  EXPECT_NE(write("fifo", "nobody reads"), "");
  const int reader = ::open(path("fifo").c_str(), O_RDONLY | O_NONBLOCK);
  EXPECT_EQ(write("fifo", "text"), "");
  std::array<char, 8> bytes{};
  EXPECT_EQ(::read(reader, bytes.data(), bytes.size()), 4);
  EXPECT_EQ(std::string(bytes.data()), "text");
  ::close(reader);
  EXPECT_TRUE(S_ISFIFO(mode("fifo")));
}

// promise: pipeline.output.fifo
TEST_F(OutputFile, ADeviceIsWrittenIntoAndStaysOne) {
  if (::mknod(path("null").c_str(), S_IFCHR | 0600, makedev(1, 3)) != 0)
    GTEST_SKIP() << "only the superuser makes device nodes";
  EXPECT_EQ(write("null", "text"), "");
  EXPECT_TRUE(S_ISCHR(mode("null")));
  ASSERT_EQ(::mknod(path("block").c_str(), S_IFBLK | 0600, makedev(7, 200)), 0);
  EXPECT_NE(OutputFault(path("block")), "");
  EXPECT_NE(write("block", "text"), "");
  EXPECT_TRUE(S_ISBLK(mode("block")));
}

// promise: pipeline.output.refused
TEST_F(OutputFile, UnwritableFileIsReportedBeforeWriting) {
  EXPECT_EQ(OutputFault(path("fine")), "");
  EXPECT_EQ(OutputFault(path(std::string(250, 'n') + ".exr")), "");
  EXPECT_EQ(write(std::string(250, 'n') + ".ex", "text"), "");
  EXPECT_NE(OutputFault(path(std::string(256, 'n'))).find("longer than 255"), std::string::npos);
  EXPECT_NE(OutputFault(path("absent/a")), "");
  EXPECT_NE(OutputFault(folder_.string()), "");
  EXPECT_NE(OutputFault("/proc/a"), "");
  EXPECT_NE(OutputFault(""), "");
  EXPECT_EQ(count(), 1u) << "the check leaves nothing behind";
}

// Two processes, on one machine or two, write into one folder.
// promise: pipeline.output.killed
TEST_F(OutputFile, NobodyRemovesTheFileOfAnother) {
  put(".alabaster-1-0.tmp", "of a run that was killed");
  char host[HOST_NAME_MAX + 1] = {};
  ASSERT_EQ(::gethostname(host, HOST_NAME_MAX), 0);
  const std::string own = ".alabaster-" + std::string(host) + "-" + std::to_string(::getpid()) + "-";
  const std::array<uint8_t, 4> bytes{'t', 'e', 'x', 't'};
  const auto meanwhile = [&](const ByteSink& sink) {
    size_t named = 0;
    for (const auto& entry : fs::directory_iterator(folder_))
      named += entry.path().filename().string().starts_with(own);
    EXPECT_EQ(named, 1u);
    const pid_t other = ::fork();
    if (other == 0) ::_exit(write("b", "other").empty() ? 0 : 1);
    int status = -1;
    EXPECT_EQ(::waitpid(other, &status, 0), other);
    EXPECT_EQ(status, 0);
    return sink(bytes);
  };
  EXPECT_EQ(StreamOutputFile(path("a"), meanwhile), "");
  EXPECT_EQ(text("a"), "text");
  EXPECT_EQ(text("b"), "other");
  EXPECT_TRUE(fs::exists(path(".alabaster-1-0.tmp")));
  EXPECT_EQ(count(), 3u);
}

TEST_F(OutputFile, NothingIsLeftOfAFailedWrite) {
  put("a", "before");
  EXPECT_NE(StreamOutputFile(path("a"), [](const ByteSink&) { return false; }), "");
  EXPECT_THROW(StreamOutputFile(path("a"), [](const ByteSink&) -> bool { throw std::bad_alloc(); }), std::bad_alloc);
  EXPECT_EQ(text("a"), "before");
  EXPECT_EQ(count(), 1u);
}

// promise: pipeline.output.share
TEST_F(OutputFile, WhatAShareDoesNotPermitIsLeftOut) {
  for (const int refused : {EPERM, EINVAL, ENOTSUP, ENOSYS}) {
    const Answers answers({.file_sync = refused, .folder_sync = refused, .mode = refused});
    EXPECT_EQ(write("new", "one"), "") << refused;
    put("old", "before", 0600);
    EXPECT_EQ(write("old", "after"), "") << refused;
    EXPECT_EQ(text("old"), "after");
    EXPECT_EQ(mode("old"), mode_t(S_IFREG | 0600)) << "no wider than before";
  }
  EXPECT_EQ(count(), 2u);
}

// promise: pipeline.output.share
TEST_F(OutputFile, ErrorsOfADiskAreErrors) {
  for (const int error : {EIO, ENOSPC, EDQUOT, ESTALE}) {
    put("a", "before");
    {
      const Answers answers({.file_sync = error});
      EXPECT_EQ(write("a", "after"), std::generic_category().message(error));
      EXPECT_EQ(text("a"), "before");
    }
    const Answers answers({.folder_sync = error});
    EXPECT_EQ(write("a", "after"), std::generic_category().message(error));
  }
  EXPECT_EQ(count(), 1u);
}

TEST_F(OutputFile, ThreadsReplaceOneFileWhole) {
  const std::string a(100000, 'a'), b(100000, 'b');
  std::thread first([&] {
    for (int i = 0; i < 20; ++i) EXPECT_EQ(write("x", a), "");
  });
  for (int i = 0; i < 20; ++i) EXPECT_EQ(write("x", b), "");
  first.join();
  EXPECT_TRUE(text("x") == a || text("x") == b);
  EXPECT_EQ(count(), 1u);
}

}  // namespace
}  // namespace alabaster::hd::support

// These take the place of the C library's in this program.
extern "C" int fsync(int file) {
  struct stat now = {};
  const bool folder = fstat(file, &now) == 0 && S_ISDIR(now.st_mode);
  const auto& errors = alabaster::hd::support::g_errors;
  if (const int error = folder ? errors.folder_sync : errors.file_sync; error != 0) return errno = error, -1;
  return int(syscall(SYS_fsync, file));
}

extern "C" int fchmod(int file, mode_t mode) noexcept {
  if (const int error = alabaster::hd::support::g_errors.mode; error != 0) return errno = error, -1;
  return int(syscall(SYS_fchmod, file, mode));
}
