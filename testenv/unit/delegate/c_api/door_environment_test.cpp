// Hosts with another floating-point environment or locale get the same pixels, and find their own settings as they
// were.
#include <tbb/parallel_for.h>
#include <unistd.h>

#include <cfenv>
#include <clocale>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <locale>
#include <thread>

#if defined(__SSE2__)
#include <xmmintrin.h>
#endif

#include "testenv/support/build_paths.h"
#include "testenv/unit/delegate/c_api/door_fixture.h"

namespace alabaster::c_api_testing {
namespace {

namespace fs = std::filesystem;

constexpr int kWidth = 24, kHeight = 16;

constexpr const char* kConfig = R"(ocio_profile_version: 2
luma: [0.2126, 0.7152, 0.0722]
roles: {default: lin, scene_linear: lin}
displays:
  screen:
    - !<View> {name: graded, colorspace: screen}
colorspaces:
  - !<ColorSpace>
    name: lin
  - !<ColorSpace>
    name: screen
    from_scene_reference: !<GroupTransform>
      children:
        - !<MatrixTransform> {matrix: [0.9, 0.05, 0.05, 0, 0.1, 0.8, 0.1, 0, 0.02, 0.08, 0.9, 0, 0, 0, 0, 1]}
        - !<CDLTransform> {slope: [1.1, 1.05, 0.95], offset: [0.01, -0.015, 2.5e-3], power: [1.1, 0.9, 1], sat: 0.85}
        - !<ExponentWithLinearTransform> {gamma: 2.4, offset: 0.055, direction: inverse}
)";

/// Whatever a host gets.
struct Answers {
  std::vector<float> color, normal;
  std::vector<uint8_t> shown;  // by kConfig
  std::vector<uint8_t> usual;  // by the built-in configuration
  std::string texts;           // of commands
  bool written = false;
  bool operator==(const Answers&) const = default;
};

class DoorEnvironment : public ::testing::Test {
 protected:
  DoorEnvironment() : folder_(fs::temp_directory_path() / ("door_environment_" + std::to_string(getpid()))) {
    fs::create_directories(folder_);
    std::ofstream(folder_ / "show.ocio") << kConfig;
  }
  ~DoorEnvironment() override { fs::remove_all(folder_); }

  static void require(AlabasterStatus status, const char* what) {
    EXPECT_EQ(status, ALABASTER_OK) << what << ": " << api().last_error();
  }
  std::vector<uint8_t> shown(AlabasterBuffer* buffer, const char* config) const {
    std::vector<uint8_t> pixels(4 * kWidth * kHeight);
    AlabasterDisplayOptions options = {};
    options.size = sizeof options;
    options.color_config = config;
    AlabasterDisplay* display = nullptr;
    require(api().display_create(&options, &display), "display_create");
    if (!display) return {};
    AlabasterMemory memory = {};
    memory.size = sizeof memory;
    memory.pixels = pixels.data(), memory.row_bytes = 4 * kWidth;
    memory.width = kWidth, memory.height = kHeight, memory.format = ALABASTER_UNORM8_4, memory.display = display;
    require(api().buffer_show(buffer, &memory), "buffer_show");
    api().display_destroy(display);
    return pixels;
  }
  static std::vector<float> read(AlabasterBuffer* buffer, size_t components) {
    std::vector<float> pixels(components * kWidth * kHeight);
    require(api().buffer_read(buffer, pixels.data(), pixels.size() * sizeof(float), 0), "buffer_read");
    return pixels;
  }
  static void add_text(void* user, const char*, const AlabasterValue* value) {
    *static_cast<std::string*>(user) += static_cast<const char*>(value->data);
  }
  std::string texts(AlabasterDelegate* delegate) const {
    std::string all;
    const int32_t x = kWidth / 2, y = kHeight / 2, sample = 1;
    const AlabasterParameter pixel[] = {{"x", whole(x)}, {"y", whole(y)}, {"sample", whole(sample)}};
    require(api().command(delegate, "tracePixel", pixel, 3, &add_text, &all), "tracePixel");
    require(api().command(delegate, "dumpScene", nullptr, 0, &add_text, &all), "dumpScene");
    return all;
  }

  /// All calls of a host, from the first one on.
  Answers run() const {
    Answers answers;
    AlabasterScene* scene = nullptr;
    AlabasterDelegate* delegate = nullptr;
    AlabasterPass* pass = nullptr;
    AlabasterBuffer *color = nullptr, *normal = nullptr;
    const std::string file = testing::source_file("testenv/scenes/sample/sample.json");
    const int32_t samples = 3;
    const AlabasterParameter settings[] = {{"samples", whole(samples)}};
    const AlabasterDelegateOptions options = {sizeof options, nullptr, nullptr, settings, 1};
    require(api().scene_create(nullptr, nullptr, &scene), "scene_create");
    require(api().scene_load(scene, file.c_str(), nullptr, nullptr), "scene_load");
    require(api().delegate_create(&options, scene, &delegate), "delegate_create");
    if (delegate) {
      require(api().pass_create(delegate, &pass), "pass_create");
      require(api().buffer_create(delegate, kWidth, kHeight, ALABASTER_FLOAT32_4, &color), "buffer_create");
      require(api().buffer_create(delegate, kWidth, kHeight, ALABASTER_FLOAT32_3, &normal), "buffer_create");
      const AlabasterBinding bindings[] = {{"color", color}, {"normal", normal}};
      AlabasterFrame frame = {};
      frame.size = sizeof frame;
      frame.bindings = bindings, frame.binding_count = 2;
      frame.width = kWidth, frame.height = kHeight;
      require(api().pass_start(pass, &frame), "pass_start");
      require(api().pass_wait(pass, -1, nullptr), "pass_wait");
      answers.color = read(color, 4), answers.normal = read(normal, 3);
      answers.shown = shown(color, (folder_ / "show.ocio").c_str());
      answers.usual = shown(color, "built-in");
      answers.texts = texts(delegate);
      answers.written = api().snapshot(pass, (folder_ / "a.exr").c_str()) == ALABASTER_OK;
    }
    api().pass_destroy(pass);
    api().buffer_destroy(color);
    api().buffer_destroy(normal);
    api().delegate_destroy(delegate);
    api().scene_destroy(scene);
    return answers;
  }
  /// The same by a host's thread that has called `set` first, and has used TBB since then.
  Answers run_after(
      const std::function<void()>& set, const std::function<void()>& check = [] {}) const {
    Answers answers;
    std::thread host([&] {
      set();
      std::vector<double> work(1000);
      tbb::parallel_for(size_t(0), work.size(), [&](size_t i) { work[i] = double(i) + 1; });
      answers = run();
      check();
    });
    host.join();
    return answers;
  }
  void expect_same(const Answers& answers, const char* what) {
    if (!plain_.written) plain_ = run_after([] {});
    ASSERT_TRUE(plain_.written);
    EXPECT_EQ(answers.color == plain_.color, true) << what;
    EXPECT_EQ(answers.normal == plain_.normal, true) << what;
    EXPECT_EQ(answers.shown == plain_.shown, true) << what;
    EXPECT_EQ(answers.usual == plain_.usual, true) << what;
    EXPECT_EQ(answers.texts, plain_.texts) << what;
    EXPECT_TRUE(answers.written) << what;
  }

  const fs::path folder_;
  Answers plain_;
};

// promise: embedding.environment
TEST_F(DoorEnvironment, RoundingChangesNothing) {
  for (const int mode : {FE_UPWARD, FE_DOWNWARD, FE_TOWARDZERO})
    expect_same(run_after([&] { std::fesetround(mode); }, [&] { EXPECT_EQ(std::fegetround(), mode); }), "rounding");
}

#if defined(__GLIBC__)
TEST_F(DoorEnvironment, TrapsEndNothing) {
  constexpr int kTraps = FE_DIVBYZERO | FE_INVALID | FE_OVERFLOW;
  expect_same(run_after([&] { feenableexcept(kTraps); }, [&] { EXPECT_EQ(fegetexcept(), kTraps); }), "traps");
}
#endif

#if defined(__SSE2__)
TEST_F(DoorEnvironment, FlushingToZeroChangesNothing) {
  constexpr unsigned kFlush = 0x8040;  // FTZ and DAZ
  const auto set = [] { _mm_setcsr(_mm_getcsr() | kFlush); };
  expect_same(run_after(set, [&] { EXPECT_EQ(_mm_getcsr() & kFlush, kFlush); }), "FTZ and DAZ");
}
#endif

/// "1.234,5", without a locale of the system.
struct Comma : std::numpunct<char> {
  char do_decimal_point() const override { return ','; }
  char do_thousands_sep() const override { return '.'; }
  std::string do_grouping() const override { return "\3"; }
};

TEST_F(DoorEnvironment, TheLocaleOfStreamsChangesNothing) {
  const std::locale before = std::locale::global(std::locale(std::locale::classic(), new Comma));
  const Answers answers = run_after([] {});
  const char point = std::use_facet<std::numpunct<char>>(std::locale()).decimal_point();
  std::locale::global(before);
  EXPECT_EQ(point, ',') << "is still the host's";
  expect_same(answers, "std::locale::global");
}

/// A German locale of C; without the system's own, one that localedef makes.
bool set_german(const fs::path& folder) {
  if (std::setlocale(LC_ALL, "de_DE.UTF-8")) return true;
  const std::string made = (folder / "de_DE.UTF-8").string();
  if (std::system(("localedef -i de_DE -f UTF-8 " + made + " >/dev/null 2>&1").c_str()) != 0) return false;
  setenv("LOCPATH", folder.c_str(), 1);
  return std::setlocale(LC_ALL, "de_DE.UTF-8") != nullptr;
}

// promise: embedding.environment
TEST_F(DoorEnvironment, TheLocaleOfCChangesNothing) {
  if (!set_german(folder_)) GTEST_SKIP() << "no German locale, and no localedef that makes one";
  const Answers answers = run_after([] {});
  const std::string point = std::localeconv()->decimal_point;
  std::setlocale(LC_ALL, "C");
  unsetenv("LOCPATH");
  EXPECT_EQ(point, ",") << "is still the host's";
  expect_same(answers, "setlocale");
}

}  // namespace
}  // namespace alabaster::c_api_testing
