// The buffer as a state machine: Map held across Allocate, Execute, resize, destruction.
#include <gtest/gtest.h>

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

}  // namespace
}  // namespace alabaster::hd
