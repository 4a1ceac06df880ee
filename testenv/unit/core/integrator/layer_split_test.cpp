#include "core/integrator/layer_split.h"

#include <gtest/gtest.h>

#include "testenv/support/path_tracer.h"

namespace alabaster {
namespace {

Rgb sum_of(const LightLayers& l) {
  return l.diffuse + l.specular + l.unscattered + l.single + l.multiple + l.emission;
}

TEST(LayerSplit, SharesAreOfEachChannelAndOfNothingNothing) {
  EXPECT_EQ(share_of({1, 3, 0}, {4, 3, 0}), Rgb(0.25f, 1, 0));
}

TEST(LayerSplit, APathWithoutAVertexIsAllEmission) {
  const LightLayers layers = LayerSplit().finish({1, 2, 3});
  EXPECT_EQ(layers.emission, Rgb(1, 2, 3));
  EXPECT_EQ(sum_of(layers), Rgb(1, 2, 3));
}

// promise: pipeline.aov.diffuse
TEST(LayerSplit, LocalLightGoesByTheShareOfItsDirection) {
  LayerSplit split;
  split.scattered = true;
  split.emission = Rgb(1.0f);
  split.add_local({4, 4, 4}, {0.25f, 0.5f, 1});  // direct light
  split.gathered = Rgb(5.0f);
  split.specular_share = {0, 1, 0.5f};  // of the path's next direction
  split.went_on = true;
  const LightLayers layers = split.finish(Rgb(13.0f));
  EXPECT_EQ(layers.emission, Rgb(1.0f));
  EXPECT_EQ(layers.specular, Rgb(1, 2 + 8, 4 + 4));
  EXPECT_EQ(layers.diffuse, Rgb(3 + 8, 2, 4));
  EXPECT_EQ(sum_of(layers), Rgb(13.0f));
}

TEST(LayerSplit, LightFromBelowGoesByTheScatteringEventsOfEachWalk) {
  LayerSplit split;
  split.scattered = true;
  split.add_local(Rgb(2.0f), Rgb(0.5f));
  const std::pair<uint32_t, float> walks[] = {{0, 1.0f}, {1, 2.0f}, {2, 4.0f}, {7, 8.0f}, {1, 16.0f}};
  for (const auto& [events, light] : walks) split.add_below(Rgb(light), {events, Rgb(0.0f)});
  const LightLayers layers = split.finish(Rgb(33.0f));
  EXPECT_EQ(layers.unscattered, Rgb(1.0f));
  EXPECT_EQ(layers.single, Rgb(18.0f));
  EXPECT_EQ(layers.multiple, Rgb(12.0f));
  EXPECT_EQ(sum_of(layers), Rgb(33.0f));
}

// promise: pipeline.aov.subsurface_parts
TEST(LayerSplit, TwinsCountAsMultipleScattering) {
  LayerSplit split;
  split.scattered = true;
  split.add_below(Rgb(-1.0f), {0, Rgb(-4.0f)});
  const LightLayers layers = split.finish(Rgb(-1.0f));
  EXPECT_EQ(layers.unscattered, Rgb(3.0f));
  EXPECT_EQ(layers.multiple, Rgb(-4.0f));
}

// Sample by sample, not only in the mean: each of them is sorted without a rest, and traced as without layers. Returns
// the sums.
LightLayers traced_layers(testing::PathTracer* tracer) {
  LightLayers total;
  for (uint32_t i = 0; i < 512; ++i) {
    LightLayers layers;
    const Rgb color = tracer->trace(i, &layers).color, sum = sum_of(layers);
    EXPECT_EQ(tracer->trace(i).color, color) << i;
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(sum[c], color[c], 16 * 0x1p-24 * double(color[c])) << i;
    total.diffuse += layers.diffuse;
    total.specular += layers.specular;
    total.unscattered += layers.unscattered;
    total.single += layers.single;
    total.multiple += layers.multiple;
    total.emission += layers.emission;
  }
  return total;
}

DisneyParameters lacquer() {
  DisneyParameters p;
  p.base_color = {0.8f, 0.6f, 0.3f};
  p.clearcoat = p.sheen = 1;
  p.scatter_distance = {0.3f, 0.1f, 0};
  p.emission = Rgb(0.1f);
  return p;
}

TEST(LayerSplit, LayersOfEverySampleAddUpToItsColor) {
  testing::SceneBuilder b;
  b.add(b.prototype(testing::sphere_mesh(1, 24, true)), b.material(lacquer())).add(testing::constant_dome(1, true));
  testing::PathTracer tracer(b.snapshot(), {0, 1, 3});
  const LightLayers total = traced_layers(&tracer);
  for (const Rgb& layer : {total.diffuse, total.specular, total.single, total.multiple, total.emission})
    EXPECT_GT(layer.r, 0);
}

TEST(LayerSplit, LayersOfATransmissiveSurfaceAddUpToItsColor) {
  testing::SceneBuilder b;
  DisneyParameters glass = lacquer();
  glass.spec_trans = 0.5f;
  b.add(b.prototype(testing::sphere_mesh(1, 24, true)), b.material(glass)).add(testing::constant_dome(1, true));
  testing::PathTracer tracer(b.snapshot(), {0, 1, 3});
  const LightLayers total = traced_layers(&tracer);
  for (const Rgb& layer : {total.specular, total.single, total.multiple, total.emission}) EXPECT_GT(layer.r, 0);
}

// A body of mist before a body of wax: light that crosses the mist is unscattered, although the wax scattered it.
TEST(LayerSplit, OnlyTheFirstBodyCounts) {
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
  EXPECT_GT(total.unscattered.g, 50 * (total.single.g + total.multiple.g));
  EXPECT_GT(tracer.counters.walks, 2 * tracer.counters.camera_rays) << "paths met the wax";
}

}  // namespace
}  // namespace alabaster
