#include "core/integrator/path.h"

#include <gtest/gtest.h>

#include "testenv/support/path_tracer.h"

namespace alabaster {
namespace {

// Sample by sample, not only in the mean: each of them is sorted without a rest, and traced as without layers. Returns
// the sums.
LightLayers traced_layers(testing::PathTracer* tracer) {
  LightLayers total;
  for (uint32_t i = 0; i < 512; ++i) {
    LightLayers layers;
    const Rgb color = tracer->trace(i, &layers).color, sum = layers.sum();
    EXPECT_EQ(tracer->trace(i).color, color) << i;
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(sum[c], color[c], 16 * 0x1p-24 * double(color[c])) << i;
    total.add(layers, 1);
  }
  return total;
}

DisneyParameters lacquer() {
  DisneyParameters p;
  p.base_color = {0.8f, 0.6f, 0.3f};
  p.clearcoat = p.sheen = 1;
  p.scatter_distance = {0.3f, 0.1f, 0};
  p.subsurface_weight = 0.7f;
  p.subsurface_color = {0.9f, 0.4f, 0.5f};
  p.emission = Rgb(0.1f);
  return p;
}

TEST(Layers, LayersOfEverySampleAddUpToItsColor) {
  testing::SceneBuilder b;
  b.add(b.prototype(testing::sphere_mesh(1, 24, true)), b.material(lacquer())).add(testing::constant_dome(1, true));
  testing::PathTracer tracer(b.snapshot(), {0, 1, 3});
  const LightLayers total = traced_layers(&tracer);
  for (const Rgb& layer :
       {total.diffuse(), total.specular(), total.single(), total.multiple(), total[LightLayers::kSeen]})
    EXPECT_GT(layer.r, 0);
}

TEST(Layers, LayersOfATransmissiveSurfaceAddUpToItsColor) {
  testing::SceneBuilder b;
  DisneyParameters glass = lacquer();
  glass.spec_trans = 0.5f;
  b.add(b.prototype(testing::sphere_mesh(1, 24, true)), b.material(glass)).add(testing::constant_dome(1, true));
  testing::PathTracer tracer(b.snapshot(), {0, 1, 3});
  const LightLayers total = traced_layers(&tracer);
  for (const Rgb& layer : {total.specular(), total.single(), total.multiple(), total[LightLayers::kSeen]})
    EXPECT_GT(layer.r, 0);
}

// A body of mist before a body of wax: light that crosses the mist is unscattered, although the wax scattered it.
TEST(Layers, OnlyTheFirstBodyCounts) {
  testing::SceneBuilder b;
  DisneyParameters mist = testing::matt(Rgb(0.8f)), wax = testing::matt(Rgb(0.8f));
  mist.scatter_distance = Rgb(1e3f);
  wax.scatter_distance = Rgb(0.1f);
  b.add(b.prototype(testing::sphere_mesh(1, 24, true)), b.material(mist));
  b.add(b.prototype(testing::sphere_mesh(20, 24, true)), b.material(wax),
        Matrix4d().setTranslation(Imath::V3d(0, 0, -25)));
  b.add(testing::constant_dome(1, true));
  testing::PathTracer tracer(b.snapshot(), {0, 0, 3});
  const LightLayers total = traced_layers(&tracer);
  EXPECT_GT(total.unscattered().g, 50 * (total.single().g + total.multiple().g));
  EXPECT_GT(tracer.counters.walks, 2 * tracer.counters.camera_rays) << "paths met the wax";
}

}  // namespace
}  // namespace alabaster
