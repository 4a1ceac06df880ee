#include "core/denoise/denoiser.h"

#include <gtest/gtest.h>

#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "core/denoise/denoise_film.h"
#include "core/denoise/oidn_search.h"
#include "testenv/support/build_paths.h"
#include "testenv/support/oidn.h"

namespace alabaster {
namespace {

namespace fs = std::filesystem;
using testing::Environment;
using testing::FakeOidn;

std::string problem_of_loading() {
  std::string problem;
  EXPECT_EQ(Denoiser::load(&problem), nullptr);
  return problem;
}

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

// Every value is different, so that a wrong row or channel shows.
DenoiserFrame small_frame() {
  DenoiserFrame frame{3, 2, std::vector<float>(18), std::vector<float>(18), std::vector<float>(18)};
  for (size_t i = 0; i < 18; ++i) {
    frame.color[i] = static_cast<float>(i);
    frame.albedo[i] = 1 / (2 + static_cast<float>(i));
    frame.normal[i] = -0.01f * static_cast<float>(i);
  }
  return frame;
}

TEST(Denoiser, IsLoadedFromTheFileOrTheFolderThatIsNamed) {
  const FakeOidn fake;
  std::string problem;
  const auto denoiser = Denoiser::load(&problem);
  ASSERT_NE(denoiser, nullptr) << problem;
  EXPECT_EQ(denoiser->name(), "Open Image Denoise 2.99.1");
  EXPECT_EQ(denoiser->file(), testing::kFakeOidn);

  const fs::path folder = fs::temp_directory_path() / ("alabaster_oidn_" + std::to_string(getpid()));
  for (const char* place : {".", "lib", "oidn/lib", "pyoidn/oidn/lib"}) {
    fs::create_directories(folder / place);
    fs::copy_file(testing::kFakeOidn, folder / place / "libOpenImageDenoise.so.2");
    const Environment named("ALABASTER_OIDN", folder.string());
    EXPECT_NE(Denoiser::load(&problem), nullptr) << place << ": " << problem;
    fs::remove_all(folder);
  }
}

TEST(Denoiser, SaysHowToGetALibraryThatIsMissing) {
  const Environment named("ALABASTER_OIDN", "/nonexistent/oidn");
  const std::string problem = problem_of_loading();
  EXPECT_TRUE(contains(problem, "ALABASTER_OIDN=/nonexistent/oidn")) << problem;
  EXPECT_TRUE(contains(problem, "pip install")) << problem;
}

TEST(Denoiser, LooksWhereTheSystemAndPythonKeepLibraries) {
  const fs::path home = fs::temp_directory_path() / ("alabaster_home_" + std::to_string(getpid()));
  const fs::path library = home / ".local/lib/python3.99/site-packages/pyoidn/oidn/lib/libOpenImageDenoise.so.2";
  fs::create_directories(library.parent_path());
  fs::copy_file(testing::kFakeOidn, library);
  const Environment at_home("HOME", home.string());
  const auto files = find_oidn("");
  EXPECT_NE(std::find(files.begin(), files.end(), "libOpenImageDenoise.so.2"), files.end());
  EXPECT_NE(std::find(files.begin(), files.end(), library.string()), files.end());
  fs::remove_all(home);
}

TEST(Denoiser, AFifoIsNotOpened) {
  const fs::path fifo = fs::temp_directory_path() / ("alabaster_fifo_" + std::to_string(::getpid()));
  ASSERT_EQ(::mkfifo(fifo.c_str(), 0600), 0);
  EXPECT_TRUE(find_oidn(fifo.string()).empty());
  fs::remove(fifo);
}

TEST(Denoiser, RefusesWhatIsNoLibraryOrAnotherOne) {
  const Environment text("ALABASTER_OIDN", testing::source_file("README.md"));
  EXPECT_TRUE(contains(problem_of_loading(), "invalid ELF header"));
  const Environment another("ALABASTER_OIDN", testing::kPlainLibrary);
  EXPECT_TRUE(contains(problem_of_loading(), "has no function oidnNewDevice")) << problem_of_loading();
}

TEST(Denoiser, RefusesAnOldVersionAndAProcessorWithoutDevice) {
  {
    const FakeOidn fake("version 1");
    EXPECT_TRUE(contains(problem_of_loading(), "is version 1.4.3, and version 2 is needed")) << problem_of_loading();
  }
  const FakeOidn fake("no device");
  EXPECT_TRUE(contains(problem_of_loading(), "this processor is not supported")) << problem_of_loading();
}

TEST(Denoiser, PassesThePictureAndItsDenoisedGuides) {
  const FakeOidn fake;
  std::string problem;
  const auto denoiser = Denoiser::load(&problem);
  ASSERT_NE(denoiser, nullptr) << problem;
  const Environment threads("FAKE_OIDN_THREADS", "3");
  const DenoiserFrame before = small_frame();
  DenoiserFrame frame = before;
  ASSERT_EQ(denoiser->denoise(&frame, {3, {}}, &problem), DenoiseStatus::done) << problem;
  for (size_t i = 0; i < 18; ++i)
    EXPECT_EQ(frame.color[i], before.color[i] + 0.5f * before.albedo[i] + 0.5f * before.normal[i]);
  EXPECT_EQ(denoiser->denoise(&frame, {2, {}}, &problem), DenoiseStatus::failed);
  EXPECT_EQ(problem, "wrong threads");
}

TEST(Denoiser, ReportsProgressAndCanBeCancelled) {
  const FakeOidn fake;
  std::string problem;
  const auto denoiser = Denoiser::load(&problem);
  ASSERT_NE(denoiser, nullptr) << problem;
  std::vector<double> fractions;
  DenoiserFrame frame = small_frame();
  const auto note = [&](double fraction) { return fractions.push_back(fraction), true; };
  ASSERT_EQ(denoiser->denoise(&frame, {0, note}, &problem), DenoiseStatus::done);
  EXPECT_EQ(fractions.front(), 0);
  EXPECT_EQ(fractions.back(), 1);
  EXPECT_TRUE(std::is_sorted(fractions.begin(), fractions.end()));
  EXPECT_EQ(fractions.size(), 15u) << "five of each filter";
  for (const double end : {0.0, 0.5, 0.9}) {
    frame = small_frame();
    EXPECT_EQ(denoiser->denoise(&frame, {0, [&](double fraction) { return fraction < end; }}, &problem),
              DenoiseStatus::cancelled);
  }
}

std::unique_ptr<Film> small_film(float alpha) {
  auto film = std::make_unique<Film>(PixelRect{5, 7, 5 + 40, 7 + 3}, with_guides(aov_bit(Aov::denoised)));
  for (int t = 0; t < film->tile_count(); ++t) {
    FilmTile tile = film->load_tile(t);
    const PixelRect r = film->tile_rect(t);
    size_t pixel = 0;
    for (int y = r.y0; y < r.y1; ++y)
      for (int x = r.x0; x < r.x1; ++x) {
        FilmSample s;
        s.color = {static_cast<float>(x), static_cast<float>(y), 1};
        s.alpha = alpha;
        s.albedo = {0.5f, 0.25f, 3};
        s.normal = {0, 1, 0};
        tile.add(pixel++, s);
      }
    film->store_tile(t, tile);
  }
  return film;
}

TEST(DenoiseFilm, IsBlackWhereNothingIsSeen) {
  const FakeOidn fake;
  std::string problem;
  const auto denoiser = Denoiser::load(&problem);
  const auto film = small_film(0);
  ASSERT_EQ(denoise_film(*denoiser, {}, film.get(), &problem), DenoiseStatus::done) << problem;
  for (const float v : film->resolve_float(Aov::denoised)) EXPECT_EQ(v, 0);
}

// ---- the real library -----------------------------------------------------------------------------------------------

// A step between grey fields under noise from a small generator.
DenoiserFrame noisy_step(size_t width, size_t height) {
  DenoiserFrame frame{width, height, {}, {}, {}};
  uint32_t state = 1;
  for (size_t i = 0; i < width * height; ++i) {
    const float level = i % width < width / 2 ? 0.2f : 0.8f;
    for (int c = 0; c < 3; ++c) {
      state = state * 1664525u + 1013904223u;
      frame.color.push_back(level * (static_cast<float>(state >> 8) * 0x1p-23f));
      frame.albedo.push_back(level);
      frame.normal.push_back(c == 2 ? 1.0f : 0.0f);
    }
  }
  return frame;
}

double squared_error(const DenoiserFrame& frame) {
  double sum = 0;
  for (size_t i = 0; i < frame.color.size(); ++i) {
    const double level = i / 3 % frame.width < frame.width / 2 ? 0.2 : 0.8;
    sum += (frame.color[i] - level) * (frame.color[i] - level) / static_cast<double>(frame.color.size());
  }
  return sum;
}

// Open Image Denoise itself. Debian has no package of it, so a machine that cannot reach PyPI has none, and the tests
// with the fake library above must do there; run_tests.sh installs it wherever it can.
class RealDenoiser : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!denoiser_) GTEST_SKIP() << "Open Image Denoise is not installed: " << problem_;
  }
  std::string problem_;
  const std::shared_ptr<const Denoiser> denoiser_ = Denoiser::load(&problem_);
};

TEST_F(RealDenoiser, RemovesNoiseWithTheSameBytesForAnyThreads) {
  const DenoiserFrame noisy = noisy_step(96, 64);
  std::vector<float> first;
  for (const uint32_t threads : {1u, 2u, 3u}) {
    DenoiserFrame frame = noisy;
    ASSERT_EQ(denoiser_->denoise(&frame, {threads, {}}, &problem_), DenoiseStatus::done) << problem_;
    EXPECT_LT(squared_error(frame), squared_error(noisy) / 100);
    if (first.empty()) first = frame.color;
    EXPECT_EQ(frame.color, first) << threads << " threads";
  }
}

TEST_F(RealDenoiser, StaysFiniteAtTheExtremes) {
  const std::pair<size_t, size_t> sizes[] = {{1, 1}, {1, 50}, {50, 1}, {17, 3}};
  for (const auto& [width, height] : sizes)
    for (const float factor : {0.0f, 1e-30f, 1.0f, 1e6f, 1e30f}) {
      DenoiserFrame frame = noisy_step(width, height);
      for (float& v : frame.color) v *= factor;
      frame.color[0] *= 1e6f;
      ASSERT_EQ(denoiser_->denoise(&frame, {}, &problem_), DenoiseStatus::done) << problem_;
      for (const float v : frame.color)
        ASSERT_TRUE(std::isfinite(v) && v >= 0) << width << "x" << height << " " << factor;
    }
}

TEST_F(RealDenoiser, CanBeCancelled) {
  DenoiserFrame frame = noisy_step(96, 64);
  EXPECT_EQ(denoiser_->denoise(&frame, {0, [](double fraction) { return fraction < 0.5; }}, &problem_),
            DenoiseStatus::cancelled);
}

}  // namespace
}  // namespace alabaster
