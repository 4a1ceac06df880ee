// Loading the library that brings OpenImageIO: where threads are short, and in forked processes.
#include <dlfcn.h>
#include <gtest/gtest.h>
#include <pthread.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <thread>

#include "core/images/image_file.h"

namespace {

constexpr int kUnlimited = -1;
std::atomic<int> threads_left{kUnlimited};

}  // namespace

// In the place of the system's: after `threads_left` threads there are no more.
extern "C" int pthread_create(pthread_t* thread, const pthread_attr_t* attributes, void* (*start)(void*),
                              void* argument) noexcept {
  static const auto create = reinterpret_cast<decltype(&pthread_create)>(dlsym(RTLD_NEXT, "pthread_create"));
  if (threads_left == 0) return EAGAIN;
  if (threads_left > 0) --threads_left;
  return create(thread, attributes, start, argument);
}

namespace alabaster {
namespace {

constexpr int kRefused = 7;

/// Exits with kRefused if the library is not loaded, for want of threads.
[[noreturn]] void load_with(int threads) {
  threads_left = threads;
  std::string fault;
  const bool is_loaded = image_functions(&fault) != nullptr;
  threads_left = kUnlimited;
  if (is_loaded || fault.find("no more threads") == std::string::npos) std::_Exit(1);
  std::_Exit(image_functions(&fault) ? kRefused : 2);  // once there are threads, it is loaded
}

TEST(ImageLibrary, IsRefusedWhereThreadsAreShort) {
#if defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "the sanitizer has its own pthread_create";
#else
  testing::FLAGS_gtest_death_test_style = "threadsafe";
  for (const int threads : {0, 1, 3, 4}) EXPECT_EXIT(load_with(threads), testing::ExitedWithCode(kRefused), "");
#endif
}

/// The exit code of a forked child that runs `body`; -1 if it does not end within 20 seconds.
int exit_code_of(const std::function<int()>& body) {
  const pid_t child = fork();
  if (child == 0) std::exit(body());  // and not _Exit: destructors of libraries run
  int status = 0;
  for (int look = 0; look < 2000; ++look) {
    if (waitpid(child, &status, WNOHANG) == child) return WIFEXITED(status) ? WEXITSTATUS(status) : 1000 + status;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  kill(child, SIGKILL);
  waitpid(child, nullptr, 0);
  return -1;
}

class BlackRows final : public RowSource {
 public:
  size_t row_bytes() const override { return kRowBytes; }
  void encode(int begin, int end, uint8_t* out) const override { std::memset(out, 0, size_t(end - begin) * kRowBytes); }
  static constexpr int kSide = 64;

 private:
  static constexpr size_t kRowBytes = kSide * 2;
};

/// The reason why a picture is not encoded, or "".
std::string fault_of_encoding(FileKind kind) {
  std::string fault;
  const ImageFunctions* images = image_functions(&fault);
  if (!images) return fault;
  ImageDescription picture;
  picture.kind = kind;
  picture.width = picture.height = BlackRows::kSide;
  picture.channels = {{"Y", kind == FileKind::exr ? ChannelStore::half : ChannelStore::uint16}};
  picture.display = {0, 0, BlackRows::kSide, BlackRows::kSide};
  std::vector<unsigned char> file;
  return images->encode(picture, BlackRows(), file);
}

TEST(ImageLibrary, AChildThatIsForkedAfterItWasLoadedExits) {
  std::string fault;
  ASSERT_NE(image_functions(&fault), nullptr) << fault;
  EXPECT_EQ(exit_code_of([] { return 7; }), 7);
}

// The child lacks OpenEXR's threads and would wait for them.
TEST(ImageLibrary, AnExrIsRefusedInAChildOfAProcessThatUsedOne) {
  ASSERT_EQ(fault_of_encoding(FileKind::exr), "");
  // A child of a process whose library starts threads at the fork may wait without end (delegate/manual/embedding.md).
  std::this_thread::sleep_for(std::chrono::seconds(2));
  const auto encode = [](FileKind kind) {
    const std::string fault = fault_of_encoding(kind);
    return fault.empty() ? 0 : fault.find("was forked") != std::string::npos ? 7 : 1;
  };
  EXPECT_EQ(exit_code_of([&] { return encode(FileKind::exr); }), 7);
  EXPECT_EQ(encode(FileKind::exr), 0) << "the parent goes on";
}

}  // namespace
}  // namespace alabaster
