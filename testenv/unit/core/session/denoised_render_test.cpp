// A render's AOV `denoised`, with the fake library: color + half of albedo + half of normal.
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <thread>

#include "core/session/render_session.h"
#include "testenv/support/oidn.h"
#include "testenv/support/scene_builder.h"

namespace alabaster {
namespace {

using testing::FakeOidn;

RenderRequest denoised_request(uint32_t samples) {
  RenderRequest request = testing::mixed_request(samples);
  request.aovs = aov_bit(Aov::denoised);
  std::string problem;
  request.denoiser = Denoiser::load(&problem);
  EXPECT_NE(request.denoiser, nullptr) << problem;
  return request;
}

std::vector<float> expected(const Film& film) {
  std::vector<float> rgba = film.resolve_float(Aov::color);
  const auto albedo = film.resolve_float(Aov::albedo), normal = film.resolve_float(Aov::normal);
  double sum = 0, lit = 0;  // the denoiser gets a picture whose geometric mean is from 1 to 2
  for (size_t i = 0; i < rgba.size(); ++i)
    if (i % 4 < 3 && rgba[i] > 0) sum += std::log2(double(rgba[i])), ++lit;
  const auto share = float(0.5 * std::exp2(std::floor(sum / lit)));
  for (size_t i = 0; i < albedo.size(); ++i)
    if (float& v = rgba[i / 3 * 4 + i % 3]; rgba[i / 3 * 4 + 3] > 0)
      v = v + share * std::clamp(albedo[i], 0.0f, 1.0f) + share * normal[i];
  return rgba;
}

// promise: pipeline.aov.denoised, trade_off.bias.denoise
TEST(DenoisedRender, IsReadyWhenTheRenderHasFinished) {
  const FakeOidn fake;
  const RenderRequest request = denoised_request(2);
  RenderProgress progress;
  const auto film = testing::render(request, &progress);
  EXPECT_EQ(progress.state, SessionState::finished);
  EXPECT_EQ(progress.denoised, 1);
  EXPECT_EQ(progress.denoiser, "Open Image Denoise 2.99.1");
  EXPECT_EQ(progress.denoise_error, "");
  const auto denoised = film->resolve_float(Aov::denoised);
  EXPECT_NE(denoised, film->resolve_float(Aov::color));
  EXPECT_EQ(denoised, expected(*film));
  EXPECT_EQ(film->resolve_float(Aov::color), testing::render(testing::mixed_request(2))->resolve_float(Aov::color));
}

TEST(DenoisedRender, IsMadeOfAStoppedOneOnDemand) {
  RenderSession session;
  {
    const FakeOidn fake("slow");
    session.start(denoised_request(2));
    while (session.progress().denoised < 0) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    session.stop();
  }
  EXPECT_EQ(session.progress().state, SessionState::stopped);
  const auto film = session.film();
  EXPECT_EQ(film->resolve_float(Aov::denoised), film->resolve_float(Aov::color));
  const FakeOidn fake;
  const Film another({0, 0, 1, 1}, 0);
  session.denoise_stopped(&another);
  EXPECT_EQ(film->resolve_float(Aov::denoised), film->resolve_float(Aov::color)) << "another film was asked for";
  session.denoise_stopped(film.get());
  EXPECT_EQ(film->resolve_float(Aov::denoised), expected(*film));
  EXPECT_EQ(session.progress().denoiser, "Open Image Denoise 2.99.1");
}

}  // namespace
}  // namespace alabaster
