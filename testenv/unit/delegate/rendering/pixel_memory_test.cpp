#include "delegate/rendering/pixel_memory.h"

#include <gtest/gtest.h>

#include "testenv/support/stage.h"

namespace alabaster::hd {
namespace {

// A buffer with the colours of the basic scene, and memory that shows it.
struct Shown {
  Stage stage{{{"samples", 1}, {"seed", 3}}};
  RenderBuffer* buffer;
  std::unique_ptr<RenderPass> pass;
  RenderPassState state;
  PixelMemory memory;

  explicit Shown(int size) {
    stage.add_basic_scene();
    buffer = stage.add_buffer("/b", size, size, Format::float32vec4);
    stage.index->SyncAll();
    pass = stage.delegate->CreateRenderPass();
    state = Stage::state_for(size, size, "color", buffer);
    memory.size = {size, size};
    memory.format = Format::float32vec4;
  }
  bool finish() { return Stage::finish(*pass, state); }
  template <class T>
  bool show(std::vector<T>* pixels, size_t row) {
    memory.pixels = pixels->data(), memory.rowBytes = row * sizeof(T);
    return buffer->ResolveTo(&memory);
  }
};

TEST(PixelMemory, RowsGoWhereTheCallerWantsThem) {
  Shown s(40);
  ASSERT_TRUE(s.finish());
  constexpr size_t kRow = 170;  // ten floats more than a row has
  std::vector<float> down(40 * kRow, -7.0f), up = down;
  ASSERT_TRUE(s.show(&down, kRow));
  s.memory.yDown = false, s.memory.shown = 0;
  ASSERT_TRUE(s.show(&up, kRow));
  s.buffer->Resolve();
  const auto* mapped = static_cast<const float*>(s.buffer->Map());
  for (size_t y = 0; y < 40; ++y)
    for (size_t x = 0; x < kRow; ++x) {
      EXPECT_EQ(up[y * kRow + x], x < 160 ? mapped[y * 160 + x] : -7.0f);
      EXPECT_EQ(down[y * kRow + x], up[(39 - y) * kRow + x]);
    }
  s.buffer->Unmap();
}

struct Doubled : PixelTransform {
  void Apply(std::span<float> rgba) const override {
    for (size_t i = 0; i < rgba.size(); ++i) rgba[i] *= i % 4 == 3 ? 1.0f : 2.0f;
  }
};

TEST(PixelMemory, ATransformAndAnotherFormatAreTheCallers) {
  Shown s(40);
  ASSERT_TRUE(s.finish());
  std::vector<float> values(40 * 160);
  ASSERT_TRUE(s.show(&values, 160));
  const Doubled doubled;
  s.memory.transform = &doubled, s.memory.format = Format::unorm8vec4, s.memory.shown = 0;
  std::vector<uint8_t> bytes(40 * 160);
  ASSERT_TRUE(s.show(&bytes, 160));
  for (size_t i = 0; i < values.size(); ++i) {
    const float wanted = i % 4 == 3 ? values[i] : 2 * values[i];
    EXPECT_NEAR(bytes[i], 255 * std::min(wanted, 1.0f), 0.5001f) << i;
  }
}

// promise: embedding.viewport.resolve_to
TEST(PixelMemory, NothingIsWrittenThatIsShownAlready) {
  Shown s(40);
  ASSERT_TRUE(s.finish());
  std::vector<float> pixels(40 * 160);
  ASSERT_TRUE(s.show(&pixels, 160));
  std::vector<float> marked(40 * 160, -7.0f);
  ASSERT_TRUE(s.show(&marked, 160));
  EXPECT_EQ(marked, std::vector<float>(40 * 160, -7.0f));
  s.stage.delegate->SetRenderSetting("seed", 4);
  ASSERT_TRUE(s.finish());
  ASSERT_TRUE(s.show(&marked, 160));
  std::vector<float> whole(40 * 160);
  s.memory.shown = 0;
  ASSERT_TRUE(s.show(&whole, 160));
  EXPECT_EQ(marked, whole);
  EXPECT_NE(whole, pixels);
}

TEST(PixelMemory, ChangedSizeIsReportedAndNothingWritten) {
  Shown s(40);
  std::vector<float> pixels(50 * 200, -7.0f);
  s.memory.size = {50, 50};
  EXPECT_FALSE(s.show(&pixels, 200)) << "before the first frame";
  EXPECT_EQ(s.memory.size, Vec2i(40, 40));
  ASSERT_TRUE(s.finish());
  ASSERT_TRUE(s.show(&pixels, 200));
  const uint64_t shown = s.memory.shown;
  EXPECT_NE(shown, 0u);
  ASSERT_TRUE(s.buffer->Allocate({.dimensions = {24, 24, 1}, .format = Format::float32vec4}));
  EXPECT_TRUE(s.show(&pixels, 200)) << "takes effect at the next Execute";
  s.state = Stage::state_for(24, 24, "color", s.buffer);
  ASSERT_TRUE(s.finish());
  std::fill(pixels.begin(), pixels.end(), -7.0f);
  EXPECT_FALSE(s.show(&pixels, 200));
  EXPECT_EQ(s.memory.size, Vec2i(24, 24));
  EXPECT_EQ(pixels, std::vector<float>(50 * 200, -7.0f));
  EXPECT_TRUE(s.show(&pixels, 200));
}

TEST(PixelMemory, UnwritablePixelsAreReported) {
  Shown s(40);
  ASSERT_TRUE(s.finish());
  std::vector<float> pixels(40 * 160);
  EXPECT_FALSE(s.show(&pixels, 159));
  s.memory.pixels = nullptr, s.memory.rowBytes = 160 * 4;
  EXPECT_FALSE(s.buffer->ResolveTo(&s.memory));
  s.memory.format = Format::invalid;
  EXPECT_FALSE(s.show(&pixels, 160));
  EXPECT_EQ(s.stage.count("buffer.memory"), 3u);
}

}  // namespace

namespace rendering {
namespace {}  // namespace
}  // namespace rendering
}  // namespace alabaster::hd
