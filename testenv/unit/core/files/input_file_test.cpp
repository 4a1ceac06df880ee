// Which files are opened, and that no change of a name leads elsewhere.
#include "core/files/input_file.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <linux/filter.h>
#include <linux/seccomp.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>
#include <filesystem>
#include <fstream>
#include <thread>

#include "core/files/real_path.h"

namespace alabaster {
namespace {

namespace fs = std::filesystem;
using Fault = InputFile::Fault;

class InputFiles : public ::testing::Test {
 protected:
  void SetUp() override {
    const std::string name = ::testing::UnitTest::GetInstance()->current_test_info()->name();
    top_ = fs::temp_directory_path() / ("alabaster_" + name + std::to_string(::getpid()));
    fs::create_directories(top_ / "in" / "below");
    fs::create_directories(top_ / "in2");
    fs::create_directories(top_ / "out");
    put("in/a", "inside"), put("in/below/b", "below"), put("in2/c", "beside"), put("out/secret", "secret");
    in_ = allowed_folder(path("in"));
  }
  void TearDown() override { fs::remove_all(top_); }

  std::string path(const std::string& name) const { return (top_ / name).string(); }
  void put(const std::string& name, const std::string& text) const { std::ofstream(path(name)) << text; }
  void link(const std::string& to, const std::string& name) const { fs::create_symlink(to, path(name)); }
  /// The text of a file that must lie in `in`; else the fault.
  std::string text(const std::string& name) const { return text_of(path(name)); }
  std::string text_of(const std::string& whole) const {
    constexpr const char* kFaults[] = {"none", "missing", "foreign", "not regular", "outside", "unreadable"};
    const InputFile file(whole, in_);
    std::string contents;
    if (file) return file.read(&contents) ? contents : "cannot be read";
    EXPECT_FALSE(file.reason().empty());
    return kFaults[static_cast<int>(file.fault())];
  }
  /// Every name that the folder has, whatever opens them.
  void check_names() const {
    EXPECT_EQ(text("in/a"), "inside");
    EXPECT_EQ(text("in/below/../below/b"), "below");
    EXPECT_EQ(text("in/absolute"), "inside");
    EXPECT_EQ(text("in/relative"), "below");
    EXPECT_EQ(text("in/through/b"), "below");
    EXPECT_EQ(text("in/through_out/c"), "outside");
    EXPECT_EQ(text("in/out"), "outside");
    EXPECT_EQ(text("in/twice"), "outside");
    EXPECT_EQ(text("in/nowhere"), "outside");
    EXPECT_EQ(text("in/nothing"), "missing");
    EXPECT_EQ(text("in/round"), "unreadable");
    EXPECT_EQ(text("in/../out/secret"), "outside");
    EXPECT_EQ(text("in2/c"), "outside");
    EXPECT_EQ(text("in/absent"), "missing");
    EXPECT_EQ(text("in/a/b"), "missing");
    EXPECT_EQ(text("in"), "not regular");
    EXPECT_EQ(text_of(""), "missing");
    EXPECT_EQ(text_of(path("in/a") + std::string("\0x", 2)), "missing");
    EXPECT_EQ(text_of("/proc/self/cwd/" + fs::relative(path("out/secret")).string()), "outside");
  }
  void make_links() const {
    link(path("in/a"), "in/absolute");
    link("below/b", "in/relative");
    link(path("in/below"), "in/through");
    link("../in2", "in/through_out");
    link("../out/secret", "in/out");
    link("out", "in/twice");
    link("../out/absent", "in/nowhere");
    link("below/absent", "in/nothing");
    link("round", "in/round");
  }

  fs::path top_;
  std::string in_;
};

TEST_F(InputFiles, TheRemedyIsThatOfTheFault) {
  struct rlimit before = {};
  ASSERT_EQ(::getrlimit(RLIMIT_NOFILE, &before), 0);
  const struct rlimit none = {0, before.rlim_max};
  ASSERT_EQ(::setrlimit(RLIMIT_NOFILE, &none), 0);
  const std::string reason = InputFile(path("in/a"), "").reason();
  ASSERT_EQ(::setrlimit(RLIMIT_NOFILE, &before), 0);
  EXPECT_EQ(reason, "it cannot be read: Too many open files; close files or raise the limit of open files (ulimit -n)");
  EXPECT_NE(InputFile(path(std::string(300, 'n')), "").reason().find("shorten its name"), std::string::npos);
}

TEST_F(InputFiles, LinksWithinTheFolderAreFollowedAndOthersRefused) {
  make_links();
  check_names();
  // The folder itself is reached through a link.
  link("in", "same");
  EXPECT_EQ(allowed_folder(path("same")), in_);
  EXPECT_EQ(text("same/a"), "inside");
}

TEST_F(InputFiles, AFolderWithoutARealPathAllowsNothing) {
  link("loop", "loop");
  const std::string none = allowed_folder(path("loop") + "/x");
  EXPECT_FALSE(none.empty());
  EXPECT_EQ(InputFile(path("in/a"), none).fault(), Fault::outside);
  EXPECT_FALSE(is_within("", in_));
  EXPECT_FALSE(is_within(in_, ""));
  EXPECT_TRUE(is_within(in_, "/"));
}

// No FIFO or device may make a reader wait.
TEST_F(InputFiles, OnlyRegularFilesAreOpened) {
  ASSERT_EQ(::mkfifo(path("in/fifo").c_str(), 0600), 0);
  link("fifo", "in/to_fifo");
  link("/dev/zero", "in/to_zero");
  for (const char* name : {"in/fifo", "in/to_fifo", "in/to_zero", "in"}) {
    EXPECT_EQ(InputFile(path(name)).fault(), Fault::not_regular) << name;
    EXPECT_NE(text(name), "inside") << name;
  }
  EXPECT_EQ(text("in/to_fifo"), "not regular");
  EXPECT_EQ(text("in/to_zero"), "outside");
  EXPECT_EQ(InputFile("/dev/zero").fault(), Fault::not_regular);
  EXPECT_EQ(InputFile(path("in/absent")).fault(), Fault::missing);
  EXPECT_TRUE(InputFile(path("out/secret")));
}

TEST_F(InputFiles, FileThatPassedTheCheckIsTheOneRead) {
  const InputFile file(path("in/a"), in_);
  ASSERT_TRUE(file);
  fs::remove(path("in/a"));
  link("../out/secret", "in/a");
  std::string contents;
  EXPECT_TRUE(file.read(&contents));
  EXPECT_EQ(contents, "inside");
  char beyond = 0;
  EXPECT_FALSE(file.read(file.size(), &beyond, 1));
}

// Between judging a path and opening it, any part of it may become a link.
TEST_F(InputFiles, ALinkThatTakesAPlaceMeanwhileIsNotFollowed) {
  const std::string file = real_path(path("in/below/b"));
  fs::rename(path("in/below"), path("in/moved"));
  link("../out", "in/below");
  put("out/b", "secret");
  EXPECT_EQ(open_real(file, O_RDONLY), -1);
  EXPECT_EQ(errno, ELOOP);
  const std::string last = real_path(path("in/a"));
  fs::remove(path("in/a"));
  link("../out/secret", "in/a");
  EXPECT_EQ(open_real(last, O_RDONLY), -1);
  EXPECT_EQ(errno, ELOOP);
}

/// Lets openat2 fail in this thread, as kernels before 5.6 do.
bool refuse_openat2() {
  sock_filter program[] = {{BPF_LD | BPF_W | BPF_ABS, 0, 0, 0},
                           {BPF_JMP | BPF_JEQ | BPF_K, 0, 1, SYS_openat2},
                           {BPF_RET | BPF_K, 0, 0, SECCOMP_RET_ERRNO | ENOSYS},
                           {BPF_RET | BPF_K, 0, 0, SECCOMP_RET_ALLOW}};
  const sock_fprog filter{std::size(program), program};
  return ::prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) == 0 && ::prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &filter) == 0;
}

TEST_F(InputFiles, WithoutOpenat2TheOpenFileIsJudged) {
  make_links();
  bool refused = false;
  std::thread([&] {
    refused = refuse_openat2();
    if (!refused) return;
    check_names();
    const std::string file = real_path(path("in/below/b"));
    fs::rename(path("in/below"), path("in/moved"));
    fs::create_symlink("../out", path("in/below"));
    put("out/b", "secret");
    EXPECT_EQ(open_real(file, O_RDONLY), -1);
    EXPECT_EQ(errno, ELOOP);
  }).join();
  if (!refused) GTEST_SKIP() << "no seccomp filters here";
}

}  // namespace
}  // namespace alabaster
