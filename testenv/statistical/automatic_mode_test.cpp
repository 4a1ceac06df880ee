// Mode `auto` renders the same picture as the walk: compares means over many seeds, block by block.
#include <gtest/gtest.h>

#include "core/subsurface/lambert_limit.h"
#include "testenv/support/mesh_bodies.h"
#include "testenv/support/scene_builder.h"
#include "testenv/support/z_test.h"

namespace alabaster {
namespace {

constexpr int kSize = 16, kBlock = 4, kBlocks = (kSize / kBlock) * (kSize / kBlock), kSeeds = 12;

struct Blocks {
  testing::RunningStatistics values[kBlocks][3];
  RenderCounters counters;
};

Blocks render_blocks(RenderRequest request, SubsurfaceMode mode, uint32_t first_seed) {
  Blocks out;
  request.width = request.height = kSize;
  request.data_window = {0, 0, kSize, kSize};
  request.settings.samples = 16;
  request.settings.filter = PixelFilter::box;
  request.settings.subsurface = mode;
  for (uint32_t seed = 0; seed < kSeeds; ++seed) {
    request.settings.seed = first_seed + seed;
    RenderProgress progress;
    const auto color = testing::render(request, &progress)->resolve_float(Aov::color);
    out.counters.add(progress.counters);
    for (int block = 0; block < kBlocks; ++block)
      for (int c = 0; c < 3; ++c) {
        double sum = 0;
        for (int i = 0; i < kBlock * kBlock; ++i) {
          const int x = block % (kSize / kBlock) * kBlock + i % kBlock;
          const int y = block / (kSize / kBlock) * kBlock + i / kBlock;
          sum += color[static_cast<size_t>(4 * (y * kSize + x) + c)];
        }
        out.values[block][c].add(sum / (kBlock * kBlock));
      }
  }
  return out;
}

// Two-sided, with Sidak's correction. The variance of few seeds is pooled over the blocks of a channel.
int blocks_that_differ(const Blocks& a, const Blocks& b, double tolerance) {
  int different = 0;
  double variance[3] = {0, 0, 0}, brightest = 0;
  for (int i = 0; i < 3 * kBlocks; ++i) {
    variance[i % 3] += (a.values[i / 3][i % 3].variance() + b.values[i / 3][i % 3].variance()) / (kBlocks * kSeeds);
    brightest = std::max(brightest, a.values[i / 3][i % 3].mean());
  }
  // z of a family of 48 at 1 %, noise uneven between blocks by up to a factor of two.
  for (int i = 0; i < 3 * kBlocks; ++i) {
    const double bound = 3.8 * std::sqrt(2 * variance[i % 3]) + tolerance * brightest;
    different += !(std::abs(a.values[i / 3][i % 3].mean() - b.values[i / 3][i % 3].mean()) <= bound);
  }
  return different;
}

// A plate of `mean_free_paths` of the farthest reaching channel, seen from above with pixels 0.1 wide, lit from below
// and a little from above.
RenderRequest plate(testing::SceneBuilder* b, float distance, float mean_free_paths) {
  DisneyParameters p;
  p.base_color = {0.9f, 0.6f, 0.45f};
  p.scatter_distance = Rgb(1, 0.35f, 0.2f) * distance;
  p.roughness = 0;
  p.ior = 1;
  p.specular = 0;
  const float half = 0.5f * mean_free_paths * distance * 1.035f;
  b->add(b->prototype(testing::box_mesh({2, half, 2})), b->material(p));
  LightDescription below;
  below.width = below.height = 3;
  below.intensity = 4;
  below.light_to_world = Matrix4d(1, 0, 0, 0, 0, 0, 1, 0, 0, -1, 0, 0, 0, -2, 0, 1);  // emits +y
  b->add(below).add(testing::constant_dome(0.3f, false));
  RenderRequest request;
  request.scene = b->snapshot();
  request.camera = testing::look_at({0, 4, 0}, {0, 0, 0}, 22.6);
  return request;
}

TEST(AutomaticMode, DrawsTheWalksPictureOfPlates) {
  // Thick, in between, thin, and thin enough to shine through.
  for (const float thickness : {400.0f, 60.0f, 20.0f, 3.0f}) {
    testing::SceneBuilder b;
    const RenderRequest request = plate(&b, 2e-4f, thickness);
    const Blocks walk = render_blocks(request, SubsurfaceMode::walk, 100);
    const Blocks automatic = render_blocks(request, SubsurfaceMode::automatic, 200);
    EXPECT_EQ(blocks_that_differ(walk, automatic, kLambertTolerance), 0) << thickness << " mean free paths";
    if (thickness == 400) {
      EXPECT_GT(automatic.counters.lambert_exits, 10 * automatic.counters.walks);
    }
    if (thickness == 3) {
      EXPECT_GT(automatic.counters.walks, 10 * automatic.counters.lambert_exits);
    }
    // The test can fail: it distinguishes Lambert everywhere from the walk where light comes through.
    const Blocks lambert = render_blocks(request, SubsurfaceMode::lambert, 300);
    if (thickness <= 20) {
      EXPECT_GT(blocks_that_differ(walk, lambert, kLambertTolerance), kBlocks / 2);
    }
  }
}

}  // namespace
}  // namespace alabaster
