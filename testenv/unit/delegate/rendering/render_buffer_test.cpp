// The buffer as a state machine: Map held across Allocate, Execute, resize, destruction.
#include <gtest/gtest.h>

#include <cmath>

#include "testenv/support/stage.h"

namespace alabaster::hd {
namespace {

TEST(RenderBuffer, AllocateTakesEffectAtOnceWhileNothingIsDrawn) {
  Stage stage;
  RenderBuffer* buffer = stage.add_buffer("/b", 4, 2, Format::float32vec4);
  EXPECT_EQ(buffer->Map(), nullptr) << "not synced: nothing is allocated";
  EXPECT_FALSE(buffer->IsMapped());
  EXPECT_TRUE(buffer->Allocate({.dimensions = {4, 2, 1}, .format = Format::float32vec4}));
  EXPECT_EQ(buffer->GetWidth(), 4);
  EXPECT_EQ(buffer->GetHeight(), 2);
  EXPECT_NE(buffer->Map(), nullptr);
  buffer->Unmap();
  EXPECT_TRUE(buffer->Allocate({.dimensions = {8, 8, 1}, .format = Format::unorm8vec4}));
  EXPECT_EQ(buffer->GetWidth(), 8);
  EXPECT_EQ(buffer->GetFormat(), Format::unorm8vec4);
}

TEST(RenderBuffer, ImpossibleDescriptionsAreRefusedAndChangeNothing) {
  Stage stage;
  RenderBuffer* buffer = stage.add_buffer("/b", 4, 2, Format::float32);
  ASSERT_TRUE(buffer->Allocate({.dimensions = {4, 2, 1}, .format = Format::float32}));
  EXPECT_FALSE(buffer->Allocate({.dimensions = {4, 2, 2}, .format = Format::float32}));
  EXPECT_FALSE(buffer->Allocate({.dimensions = {-4, 2, 1}, .format = Format::float32}));
  EXPECT_FALSE(buffer->Allocate({.dimensions = {4, 2, 1}, .format = Format::invalid}));
  EXPECT_FALSE(buffer->Allocate({.dimensions = {1 << 30, 1 << 30, 1}, .format = Format::float32}));
  EXPECT_EQ(buffer->GetWidth(), 4);
  EXPECT_EQ(stage.count("buffer.allocate"), 4u);
}

struct Rendered {
  Stage stage;
  RenderBuffer* buffer;
  std::unique_ptr<RenderPass> pass;
  RenderPassState state;

  Rendered(int size, Format format, const char* aov) : stage({{"samples", 1}}) {
    stage.add_basic_scene();
    buffer = stage.add_buffer("/b", size, size, format);
    stage.index->SyncAll();
    pass = stage.delegate->CreateRenderPass();
    state = Stage::state_for(size, size, aov, buffer);
  }
  bool finish() { return Stage::finish(*pass, state); }
};

TEST(RenderBuffer, AMappingSurvivesAllocateExecuteResolveAndUnmapEndsIt) {
  Rendered r(8, Format::int32, "primId");
  ASSERT_TRUE(r.finish());
  r.buffer->Resolve();
  const auto* mapped = static_cast<const int32_t*>(r.buffer->Map());
  ASSERT_NE(mapped, nullptr);
  const std::vector<int32_t> before(mapped, mapped + 64);
  EXPECT_EQ(before[0], -1) << "background";
  EXPECT_EQ(before[8 * 4 + 4], 0) << "the quad";

  ASSERT_TRUE(r.buffer->Allocate({.dimensions = {16, 16, 1}, .format = Format::int32}));
  EXPECT_EQ(r.buffer->GetWidth(), 8) << "deferred to the next Execute";
  r.state = Stage::state_for(16, 16, "primId", r.buffer);
  ASSERT_TRUE(r.finish());
  r.buffer->Resolve();
  EXPECT_EQ(std::vector<int32_t>(mapped, mapped + 64), before) << "the old mapping is untouched";
  EXPECT_EQ(r.buffer->GetWidth(), 8) << "sizes are those of the mapping";
  r.buffer->Unmap();
  EXPECT_FALSE(r.buffer->IsMapped());
  EXPECT_EQ(r.buffer->GetWidth(), 16);
  const auto* larger = static_cast<const int32_t*>(r.buffer->Map());
  EXPECT_EQ(larger[16 * 8 + 8], 0);
  r.buffer->Unmap();
}

TEST(RenderBuffer, AMappingSurvivesItsBuffer) {
  Rendered r(8, Format::int32, "primId");
  ASSERT_TRUE(r.finish());
  r.buffer->Resolve();
  const auto* mapped = static_cast<const int32_t*>(r.buffer->Map());
  const std::vector<int32_t> before(mapped, mapped + 64);
  r.pass.reset();
  r.stage.scene.Remove("/b");
  EXPECT_EQ(std::vector<int32_t>(mapped, mapped + 64), before);
}

TEST(RenderBuffer, RowsRunBottomUpAndIdsAreExact) {
  Rendered r(8, Format::int32, "primId");
  host::MeshDescription mesh = Stage::quad();
  mesh.primvars["points"].value = Array<Vec3f>{{-2, 0, 0}, {2, 0, 0}, {2, 2, 0}, {-2, 2, 0}};  // the upper half
  r.stage.scene.SetMesh("/quad", mesh);
  r.stage.delegate->SetRenderSetting("filter", "box");
  r.stage.index->SyncAll();
  ASSERT_TRUE(r.finish());
  r.buffer->Resolve();
  const auto* rows = static_cast<const int32_t*>(r.buffer->Map());
  for (int x = 0; x < 8; ++x) {
    EXPECT_EQ(rows[x], -1) << "the first row in memory is the lowest";
    EXPECT_EQ(rows[7 * 8 + x], 0);
  }
  r.buffer->Unmap();
}

TEST(RenderBuffer, GenerationRisesOnlyWithNewPixels) {
  Rendered r(8, Format::float32vec4, "color");
  ASSERT_TRUE(r.finish());
  r.buffer->Resolve();
  const uint64_t generation = r.buffer->GetGeneration();
  EXPECT_GT(generation, 0u);
  r.buffer->Resolve();
  EXPECT_EQ(r.buffer->GetGeneration(), generation);
}

TEST(RenderBuffer, FormatsAgreeWithFloat) {
  Rendered r(8, Format::float32vec4, "color");
  RenderBuffer* half_buffer = r.stage.add_buffer("/half", 8, 8, Format::float16vec4);
  RenderBuffer* byte_buffer = r.stage.add_buffer("/byte", 8, 8, Format::unorm8vec3);
  r.stage.index->SyncAll();
  r.state.aovBindings.push_back({"color", half_buffer, {}});
  r.state.aovBindings.push_back({"color", byte_buffer, {}});
  ASSERT_TRUE(r.finish());
  const auto floats = Stage::pixels<float>(r.buffer);
  const auto halves = Stage::pixels<uint16_t>(half_buffer);
  const auto bytes = Stage::pixels<uint8_t>(byte_buffer);
  ASSERT_EQ(floats.size(), 8u * 8 * 4);
  ASSERT_EQ(halves.size(), floats.size());
  ASSERT_EQ(bytes.size(), 8u * 8 * 3);
  bool lit = false;
  for (size_t i = 0; i < 64; ++i)
    for (size_t c = 0; c < 3; ++c) {
      const float value = floats[i * 4 + c];
      lit = lit || value > 0.1f;
      const uint16_t h = halves[i * 4 + c];  // normal or zero: values are 0 or well above 2^-14
      const float read = h == 0 ? 0.0f : std::ldexp(static_cast<float>((h & 0x3ff) | 0x400), (h >> 10) - 25);
      EXPECT_NEAR(read, value, value * 0.0005f);
      EXPECT_NEAR(static_cast<float>(bytes[i * 3 + c]), std::min(value, 1.0f) * 255.0f, 0.5001f);
    }
  EXPECT_TRUE(lit);
}

TEST(RenderBuffer, OutsideTheDataWindowIsTheClearValueAndInsideEqualsTheFullFrame) {
  Rendered full(16, Format::float32vec4, "color");
  ASSERT_TRUE(full.finish());
  const auto whole = Stage::pixels<float>(full.buffer);
  Rendered cropped(16, Format::float32vec4, "color");
  cropped.state.framing.dataWindow = {5, 3, 12, 9};
  cropped.state.aovBindings[0].clearValue = Vec4f(7, 7, 7, 7);
  ASSERT_TRUE(cropped.finish());
  const auto part = Stage::pixels<float>(cropped.buffer);
  ASSERT_EQ(part.size(), whole.size());
  for (int y = 0; y < 16; ++y)
    for (int x = 0; x < 16; ++x) {
      const bool inside = x >= 5 && x < 12 && y >= 3 && y < 9;
      const auto at = static_cast<size_t>(y * 16 + x) * 4;
      EXPECT_EQ(part[at], inside ? whole[at] : 7.0f) << x << "," << y;
    }
}

// The same crop with a moved display window and a buffer of the crop's size, as in the frame recorder.
TEST(RenderBuffer, AMovedDisplayWindowGivesTheSamePixels) {
  Rendered full(16, Format::int32, "primId");
  ASSERT_TRUE(full.finish());
  const auto whole = Stage::pixels<int32_t>(full.buffer);
  Rendered moved(7, Format::int32, "primId");
  moved.state.framing.displayMin = {-5, -3};
  moved.state.framing.displayMax = {11, 13};
  moved.state.framing.dataWindow = {0, 0, 7, 7};
  ASSERT_TRUE(moved.finish());
  const auto part = Stage::pixels<int32_t>(moved.buffer);
  ASSERT_EQ(part.size(), 49u);
  for (size_t y = 0; y < 7; ++y)
    for (size_t x = 0; x < 7; ++x) EXPECT_EQ(part[y * 7 + x], whole[(y + 3) * 16 + x + 5]);
}

}  // namespace
}  // namespace alabaster::hd
