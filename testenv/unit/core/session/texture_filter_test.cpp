// Pictures with filtered textures.
#include <OpenImageIO/imageio.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <random>

#include "core/session/frame_memory.h"
#include "core/session/render_session.h"
#include "core/session/tile_renderer.h"
#include "testenv/support/material_testing.h"
#include "testenv/support/path_tracer.h"
#include "testenv/support/reports.h"

namespace alabaster {
namespace {

using testing::SceneBuilder;

// Half of its texels are black and half white, in no order.
std::shared_ptr<const Texture> salt_and_pepper() {
  constexpr int kSize = 512;
  std::vector<float> texels(kSize * kSize, 0);
  std::fill_n(texels.begin(), texels.size() / 2, 1.0f);
  std::shuffle(texels.begin(), texels.end(), std::mt19937(5));
  const std::string file =
      (std::filesystem::temp_directory_path() / ("alabaster_salt_" + std::to_string(::getpid()) + ".tif")).string();
  const auto out = OIIO::ImageOutput::create(file);
  EXPECT_TRUE(out->open(file, OIIO::ImageSpec(kSize, kSize, 1, OIIO::TypeUInt8)) &&
              out->write_image(OIIO::TypeFloat, texels.data()) && out->close());
  testing::Reports reports;
  TextureSource source;
  source.path = file;
  source.color_space = "raw";
  auto texture = load_texture(source, *ColorConfig::load("built-in", {}), reports.sink);
  EXPECT_TRUE(texture) << reports.text();
  std::filesystem::remove(file);
  return texture;
}

// A plane whose texels are about a fifth of a pixel wide.
RenderRequest plane_request(const std::shared_ptr<const DisneyMaterial>& material, float filter) {
  SceneBuilder b;
  Mesh mesh = testing::plane_mesh(2);
  mesh.uv_sets.push_back({{}, "st"});
  for (const Vec3f& p : mesh.points) mesh.uv_sets[0].values.emplace_back(0.5f + 0.5f * p.x, 0.5f - 0.5f * p.z);
  b.add(b.prototype(std::move(mesh)), material).add(testing::constant_dome(1, false));
  RenderRequest request;
  request.scene = b.snapshot();
  request.camera = testing::look_at({0, 3, 2}, {0, 0, 0}, 16);
  request.width = request.height = 48;
  request.data_window = {0, 0, 48, 48};
  request.settings.samples = 4;
  request.settings.max_depth = 1;
  request.settings.filter = PixelFilter::box;
  request.settings.texture_filter = filter;
  return request;
}

double variance_over_pixels(const RenderRequest& request, double* mean) {
  const auto pixels = testing::render(request)->resolve_float(Aov::color);
  double sum = 0, squares = 0;
  for (size_t i = 0; i < pixels.size(); i += 4)
    sum += double(pixels[i]), squares += double(pixels[i]) * double(pixels[i]);
  const auto count = static_cast<double>(pixels.size() / 4);
  *mean = sum / count;
  return squares / count - *mean * *mean;
}

std::shared_ptr<DisneyMaterial> textured(const char* parameter, bool is_linear) {
  auto material = std::make_shared<DisneyMaterial>();
  material->constants = testing::matt(Rgb(1.0f));
  testing::connect(parameter, salt_and_pepper(), material.get());
  if (!is_linear) material->textures[0].uses[0].channel = Channel::r;
  material->textures[0].lookup.is_linear = is_linear;
  return material;
}

TEST(TextureFilter, ReducesTheNoiseOfTexelsSmallerThanPixels) {
  const auto material = textured("baseColor", true);
  double plain = 0, filtered = 0;
  const double before = variance_over_pixels(plane_request(material, 0), &plain);
  const double after = variance_over_pixels(plane_request(material, 1), &filtered);
  EXPECT_LT(after, before / 10) << before;
  EXPECT_NEAR(filtered / plain, 1, 0.02);
}

// Images are prepared before the first sample, which the time limit may not leave time for.
TEST(TextureFilter, ImagesArePreparedWithinTheTimeOfTheRender) {
  const RenderRequest request = plane_request(textured("baseColor", true), 1);
  std::atomic<bool> over{true};
  EXPECT_THROW(TileRenderer(request, CancelToken(&over)), BuildCancelled);
  over = false;
  EXPECT_NO_THROW(TileRenderer(request, CancelToken(&over)));
}

TEST(TextureFilter, ATimeLimitThatIsOverEndsTheRenderWhileImagesArePrepared) {
  RenderRequest request = plane_request(textured("baseColor", true), 1);
  request.resumed = std::make_shared<RenderState>();
  request.resumed->film = std::make_shared<Film>(request.data_window, request.aovs, film_extras(request.settings));
  request.resumed->wall_seconds = 10;
  request.settings.time_limit = 1;
  RenderSession session;
  session.start(request);
  ASSERT_TRUE(session.wait(60));
  const RenderProgress progress = session.progress();
  EXPECT_EQ(progress.state, SessionState::finished) << progress.error;
  EXPECT_EQ(progress.ended_by, RenderEnd::time_limit);
  EXPECT_EQ(progress.samples_done, 0u);
  EXPECT_EQ(progress.pixels_without_sample, progress.pixels);
}

// promise: trade_off.bias.texture_filter
TEST(TextureFilter, LeavesOpacityAndNumbersAsTheyAre) {
  for (const char* parameter : {"opacity", "roughness"}) {
    const auto material = textured(parameter, false);
    const auto plain = testing::render(plane_request(material, 0));
    const auto filtered = testing::render(plane_request(material, 1));
    EXPECT_EQ(plain->resolve_float(Aov::color), filtered->resolve_float(Aov::color)) << parameter;
    EXPECT_EQ(plain->resolve_float(Aov::alpha), filtered->resolve_float(Aov::alpha)) << parameter;
  }
}

}  // namespace
}  // namespace alabaster
