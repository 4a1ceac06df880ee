// Disks that are full, files and folders that vanish, folders of somebody else: the picture is not lost.
#include <OpenImageIO/imageio.h>
#include <grp.h>
#include <sched.h>
#include <sys/mount.h>
#include <sys/stat.h>

#include "testenv/support/build_paths.h"
#include "testenv/unit/delegate/cli/run_program.h"
#include "testenv/unit/delegate/description/scene_fixture.h"

namespace alabaster::cli {
namespace {

namespace fs = std::filesystem;

#define EXPECT_HAS(text, part) EXPECT_NE((text).find(part), std::string::npos) << "said: " << (text)

constexpr int kNoNamespace = 98;  // the child's exit code

void write_text(const char* file, const std::string& text) {
  std::ofstream(file) << text;
}

class DiskTest : public hd::description::SceneFiles {
 protected:
  void SetUp() override {
    SceneFiles::SetUp();
    temporary_ = folder_ / "temporary";
    fs::create_directory(temporary_);
  }
  Outcome run(const std::vector<std::string>& arguments, const std::function<void()>& prepare = {}) const {
    return run_program(folder_, arguments, [&] {
      setenv("TMPDIR", temporary_.c_str(), 1);
      if (prepare) prepare();
    });
  }
  /// Renders to the end; calls `meanwhile` when the render has begun.
  Outcome render(const std::vector<std::string>& arguments, const std::function<void()>& meanwhile) const {
    std::vector<std::string> all{"render", "patch.gltf", "--size", "64x48", "--spp", "400"};
    all.insert(all.end(), arguments.begin(), arguments.end());
    Program program(folder_, all, [&] { setenv("TMPDIR", temporary_.c_str(), 1); });
    EXPECT_TRUE(wait_for_begin(program)) << program.err();
    meanwhile();
    const int code = program.wait();
    return {code, program.out(), program.err()};
  }
  static bool wait_for_begin(const Program& program) {
    const std::string begun = "rendering 64x48";
    for (int i = 0; i < 3000 && program.err().find(begun) == std::string::npos; ++i)
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    return program.err().find(begun) != std::string::npos;
  }
  /// The file that a message says the picture was kept as.
  static std::string kept(const std::string& message) {
    const std::string before = "the picture was kept as ", after = ": move it";
    const size_t begin = message.find(before), end = message.find(after);
    if (begin == std::string::npos || end == std::string::npos) return {};
    return message.substr(begin + before.size(), end - begin - before.size());
  }
  static void expect_picture(const std::string& file, int width, int height) {
    const auto image = OIIO::ImageInput::open(file);
    ASSERT_TRUE(image) << file << ": " << OIIO::geterror();
    EXPECT_EQ(image->spec().width, width);
    EXPECT_EQ(image->spec().height, height);
    std::vector<float> pixels(size_t(width) * size_t(height) * size_t(image->spec().nchannels));
    EXPECT_TRUE(image->read_image(0, 0, 0, -1, OIIO::TypeDesc::FLOAT, pixels.data())) << image->geterror();
  }
  bool temporary_is_empty() const { return fs::is_empty(temporary_); }

  fs::path temporary_;
};

TEST_F(DiskTest, AFolderThatVanishesLosesNoPicture) {
  fs::create_directory(folder_ / "out");
  const Outcome outcome = render({"-o", "out/a.exr", "-o", "b.exr"}, [&] { fs::remove_all(folder_ / "out"); });
  EXPECT_EQ(outcome.code, 5) << outcome.err;
  EXPECT_HAS(outcome.err, "out/a.exr: No such file or directory");
  EXPECT_EQ(fs::path(kept(outcome.err)).filename(), "a.exr") << outcome.err;
  expect_picture(kept(outcome.err), 64, 48);
  expect_picture(folder_ / "b.exr", 64, 48);
}

TEST_F(DiskTest, AnEmptyTmpdirIsAsNone) {
  const int full = open("/dev/full", O_WRONLY | O_CLOEXEC);
  if (full < 0) GTEST_SKIP() << "this system has no /dev/full";
  close(full);
  fs::create_symlink("/dev/full", folder_ / "full.exr");
  const Outcome outcome =
      run({"render", "patch.gltf", "--size", "16x12", "--spp", "1", "-o", "full.exr"}, [] { setenv("TMPDIR", "", 1); });
  EXPECT_EQ(outcome.code, 5) << outcome.err;
  EXPECT_TRUE(kept(outcome.err).starts_with("/tmp/alabaster_")) << outcome.err;
  expect_picture(kept(outcome.err), 16, 12);
  fs::remove_all(fs::path(kept(outcome.err)).parent_path());
}

TEST_F(DiskTest, AColorConfigurationThatVanishesLosesNoPicture) {
  write("ramp.spi1d", "Version 1\nFrom 0 1\nLength 2\nComponents 1\n{\n0\n1\n}\n");
  write("mine.ocio", R"(ocio_profile_version: 1
roles: {default: linear, scene_linear: linear}
displays:
  screen:
    - !<View> {name: graded, colorspace: graded}
colorspaces:
  - !<ColorSpace> {name: linear}
  - !<ColorSpace>
    name: graded
    from_reference: !<FileTransform> {src: ramp.spi1d, interpolation: linear}
)");
  const Outcome outcome = render({"--ocio", "mine.ocio", "-o", "a.png"}, [&] {
    fs::remove(folder_ / "mine.ocio");
    fs::remove(folder_ / "ramp.spi1d");
  });
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  expect_picture(folder_ / "a.png", 64, 48);
  EXPECT_TRUE(temporary_is_empty()) << "its own place took the picture";
}

// Runs in the child: the rest of the program sees a disk of 128 KiB at "disk", and when it has ended, "after" tells
// what the disk holds.
void enter_small_disk(const std::string& old_content) {
  const uid_t user = getuid();
  const gid_t group = getgid();
  if (unshare(CLONE_NEWUSER | CLONE_NEWNS) != 0) _exit(kNoNamespace);
  write_text("/proc/self/setgroups", "deny");
  write_text("/proc/self/uid_map", "0 " + std::to_string(user) + " 1");
  write_text("/proc/self/gid_map", "0 " + std::to_string(group) + " 1");
  if (mount("none", "disk", "tmpfs", 0, "size=128k") != 0) _exit(kNoNamespace);
  write_text("disk/a.exr", old_content);
  const pid_t renderer = fork();
  if (renderer == 0) return;
  int status = 0;
  waitpid(renderer, &status, 0);
  std::ofstream after("after");
  for (const auto& entry : fs::directory_iterator("disk")) {
    std::ifstream file(entry.path());
    after << entry.path().filename().string() << " " << std::string(std::istreambuf_iterator<char>(file), {}) << "\n";
  }
  after.close();
  _exit(WIFEXITED(status) ? WEXITSTATUS(status) : 97);
}

TEST_F(DiskTest, AFullDiskKeepsTheOldFileAndTheNewPicture) {
  fs::create_directory(folder_ / "disk");
  const Outcome outcome = run({"render", "patch.gltf", "--size", "256x256", "--spp", "2", "-o", "disk/a.exr",
                               "--checkpoint", "disk/c.checkpoint"},
                              [] { enter_small_disk("old"); });
  if (outcome.code == kNoNamespace) GTEST_SKIP() << "this system does not let a test mount a small disk of its own";
  EXPECT_EQ(outcome.code, 5) << outcome.err;
  EXPECT_HAS(outcome.err, "disk/a.exr: No space left on device");
  EXPECT_HAS(outcome.err, "checkpoint 'disk/c.checkpoint' could not be written: No space left on device");
  std::ifstream after(folder_ / "after");
  EXPECT_EQ(std::string(std::istreambuf_iterator<char>(after), {}), "a.exr old\n") << "and nothing half written";
  expect_picture(kept(outcome.err), 256, 256);
}

TEST_F(DiskTest, UnsavedPictureIsNotCalledSaved) {
  fs::create_directory(folder_ / "out");
  const Outcome outcome = render({"-o", "out/a.exr"}, [&] {
    fs::remove(folder_ / "out");
    fs::remove(temporary_);
  });
  EXPECT_EQ(outcome.code, 5) << outcome.err;
  EXPECT_HAS(outcome.err, "out/a.exr: No such file or directory; check the folder");
}

TEST_F(DiskTest, AFolderWithoutWritePermissionIsReportedBeforeTheRender) {
  if (geteuid() != 0) GTEST_SKIP() << "only the superuser can run the program as another user";
  fs::create_directory(folder_ / "theirs");
  fs::permissions(folder_ / "theirs", fs::perms(0755));
  fs::permissions(folder_, fs::perms(0755));
  const auto become_nobody = [] {
    constexpr id_t kNobody = 65534;
    if (setgroups(0, nullptr) != 0 || setgid(kNobody) != 0 || setuid(kNobody) != 0 ||
        access(testing::kProgram, X_OK) != 0)
      _exit(kNoNamespace);
  };
  for (const std::vector<std::string>& output :
       {std::vector<std::string>{"-o", "theirs/a.exr"}, {"-o", "/dev/null.exr", "--stats", "theirs/s.json"}}) {
    std::vector<std::string> arguments{"render", "patch.gltf", "--size", "16x12", "--spp", "1"};
    arguments.insert(arguments.end(), output.begin(), output.end());
    const Outcome outcome = run(arguments, become_nobody);
    if (outcome.code == kNoNamespace)
      GTEST_SKIP() << "the folder of the program is closed to other users; build it in one that they can read";
    EXPECT_EQ(outcome.code, 5) << outcome.err;
    EXPECT_HAS(outcome.err, "cannot be written to (Permission denied)");
  }
}

}  // namespace
}  // namespace alabaster::cli
