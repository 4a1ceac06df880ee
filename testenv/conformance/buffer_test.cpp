// Contract 1.6, 4.5 rules 7 and 8: render buffers.
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <cmath>
#include <cstring>
#include <thread>

#include "testenv/conformance/scenes.h"

namespace conformance {
namespace {

// Maps the picture, lets `change` do its worst, and compares.
void expect_mapping_survives(Host& host, const std::function<void(RenderBuffer&)>& change) {
  RenderBuffer& color = host.buffer();
  const Picture before = read(color);
  const void* pixels = color.Map();
  ASSERT_NE(pixels, nullptr);
  change(color);
  EXPECT_EQ(std::memcmp(pixels, before.bytes.data(), before.bytes.size()), 0);
}

// rpr#121, rpr#361: reallocated under Map.
TEST(Buffers, AMappingSurvivesAllocate) {
  Host host;
  add_halves(host);
  host.render();
  expect_mapping_survives(host, [&](RenderBuffer& color) {
    EXPECT_TRUE(color.Allocate({{64, 48, 1}, Format::float16vec4}));
    EXPECT_TRUE(color.IsMapped());
  });
  host.buffer().Unmap();
  EXPECT_FALSE(host.buffer().IsMapped());
}

// rpr#62, arnold#101, bb#102: a resize while the user interface reads.
TEST(Buffers, AMappingSurvivesAResizeThatIsDrawn) {
  Host host;
  add_halves(host);
  host.render();
  expect_mapping_survives(host, [&](RenderBuffer& color) {
    host.resize(40, 24);
    host.sync();
    EXPECT_TRUE(host.converge());
    color.Resolve();
    EXPECT_TRUE(color.IsMapped());
  });
  host.buffer().Unmap();
  const Picture after = read(host.buffer());
  EXPECT_EQ(after.width, 40);
  EXPECT_TRUE(near(after.color(0.5, 0), kGreen));
}

// OpenUSD#3471: scene-index hosts destroy and recreate buffers under a mapping.
TEST(Buffers, AMappingSurvivesItsBuffer) {
  Host host;
  add_halves(host);
  host.render();
  expect_mapping_survives(host, [&](RenderBuffer&) {
    host.unbind("color");
    host.sync();
    host.pass->Execute(host.state);
    host.render("depth");
  });
}

TEST(Buffers, AMappingSurvivesTheNextPicture) {
  Host host;
  add_halves(host);
  host.render();
  expect_mapping_survives(host, [&](RenderBuffer& color) {
    host.material("/red") = glow(kBlue);
    host.sync();
    EXPECT_TRUE(host.converge());
    color.Resolve();
  });
  host.buffer().Unmap();
  EXPECT_TRUE(near(read(host.buffer()).color(-0.5, 0), kBlue));
}

TEST(Buffers, MappingsNest) {
  Host host;
  add_halves(host);
  host.render();
  RenderBuffer& color = host.buffer();
  EXPECT_EQ(color.Map(), color.Map());
  color.Unmap();
  EXPECT_TRUE(color.IsMapped());
  color.Unmap();
  EXPECT_FALSE(color.IsMapped());
}

// The settings panel of a host reallocates constantly (bb#53).
TEST(Buffers, AnEqualAllocationRestartsNothing) {
  Host host;
  add_noisy_scene(host);
  host.render();
  for (int i = 0; i < 100; ++i) {
    EXPECT_TRUE(host.buffer().Allocate({{16, 16, 1}, Format::float32vec4}));
    host.pass->Execute(host.state);
    ASSERT_TRUE(host.pass->IsConverged()) << i;
  }
}

TEST(Buffers, ImpossibleSizesAreRefusedAndChangeNothing) {
  Host host;
  add_halves(host);
  const Picture picture = host.render();
  for (const Vec3i& size : {Vec3i(-1, 16, 1), Vec3i(16, 16, 2), Vec3i(1 << 30, 1 << 30, 1)})
    EXPECT_FALSE(host.buffer().Allocate({size, Format::float32vec4}));
  EXPECT_FALSE(host.buffer().Allocate({{16, 16, 1}, Format::invalid}));
  EXPECT_TRUE(host.render() == picture);
}

// OpenUSD#1236: the old picture stays until the new one is usable. Every picture on the way is whole, if coarse.
// promise: embedding.viewport.old_picture
TEST(Buffers, TheOldPictureStaysUntilTheNewOneCovers) {
  Host host(24, 24, {{"samples", 16}});
  add_halves(host);
  host.render();
  for (const int size : {40, 16, 32}) {
    host.resize(size, size);
    host.sync();
    // Long enough for a machine that has much else to do.
    const auto end = std::chrono::steady_clock::now() + std::chrono::minutes(1);
    while (std::chrono::steady_clock::now() < end) {
      host.pass->Execute(host.state);
      const Picture seen = read(host.buffer());
      ASSERT_EQ(seen.bytes.size(), size_t(seen.width) * size_t(seen.height) * 16);
      int wrong = 0;
      for (double x : {-0.9, -0.1, 0.1, 0.9})
        for (double y : {-0.9, 0.0, 0.9}) wrong += !near(seen.color(x, y), kRed) && !near(seen.color(x, y), kGreen);
      ASSERT_EQ(wrong, 0) << "of 12 pixels, " << seen.width << " wide";
      if (host.pass->IsConverged()) break;
    }
    const Picture last = read(host.buffer());
    EXPECT_EQ(last.width, size);
    EXPECT_TRUE(near(last.color(-0.1, 0), kRed) && near(last.color(0.1, 0), kGreen));
  }
}

int empty_pixels(const Picture& picture) {
  int count = 0;
  for (int y = 0; y < picture.height; ++y)
    for (int x = 0; x < picture.width; ++x) count += picture.number(x, y, 3) != 1;
  return count;
}

TEST(Buffers, TheFirstPictureAfterARestartIsNotEmpty) {
  Host host(32, 32, {{"samples", 8}});
  add_halves(host);
  host.render();
  for (int move = 1; move <= 3; ++move) {
    host.camera(dirty::kTransform).transform = moved(0.01 * move, 0, 1.9);
    host.sync();
    const auto end = std::chrono::steady_clock::now() + std::chrono::minutes(1);
    while (std::chrono::steady_clock::now() < end) {
      host.pass->Execute(host.state);
      ASSERT_EQ(empty_pixels(read(host.buffer())), 0) << "move " << move;
      if (host.pass->IsConverged()) break;
    }
  }
}

// rpr#62: a size, and then the pixels of another. ResolveTo answers with both.
TEST(Buffers, SizeAndPixelsAreReadAsOne) {
  Host host(8, 8, {{"samples", 1}});
  add_halves(host);
  host.render();
  RenderBuffer& color = host.buffer();
  host.resize(20, 20);
  host.sync();
  std::vector<uint8_t> large(16 * 20 * 20);
  PixelMemory window;
  window.pixels = large.data(), window.rowBytes = 16 * 20, window.format = Format::float32vec4;
  window.size = {20, 20};
  EXPECT_FALSE(color.ResolveTo(&window)) << "allocated, but not drawn yet";
  EXPECT_EQ(window.size, Vec2i(8, 8));
  std::atomic<bool> over = false;
  std::atomic<int> torn = 0, reads = 0;
  std::thread reader([&] {
    std::vector<uint8_t> pixels(16 * 64 * 64);
    while (!over || reads == 0) {
      PixelMemory memory;
      memory.pixels = pixels.data(), memory.rowBytes = 16 * 64, memory.format = Format::float32vec4;
      memory.size = {8, 8};
      const bool shown = color.ResolveTo(&memory);
      if (memory.size.x != memory.size.y || shown != (memory.size == Vec2i(8, 8))) ++torn;
      ++reads;
    }
  });
  for (int i = 0; i < repetitions(100, 20); ++i) {
    host.resize(8 + i % 5, 8 + i % 5);
    host.sync();
    host.pass->Execute(host.state);
    if (i % 10 == 0) host.converge();
  }
  over = true;
  reader.join();
  EXPECT_EQ(torn, 0) << "of " << reads;
}

TEST(Buffers, RowsRunBottomUp) {
  Host host;
  host.material("/red") = glow(kRed);
  host.mesh("/low") = rectangle(-1, -1, 1, 0);
  host.mesh("/low").material = "/red";
  const Picture picture = host.render();
  EXPECT_TRUE(near({picture.number(8, 2, 0), picture.number(8, 2, 1), picture.number(8, 2, 2)}, kRed));
  EXPECT_EQ(picture.number(8, 13, 3), 0);
  std::vector<uint8_t> top_down(picture.bytes.size());
  PixelMemory memory;
  memory.pixels = top_down.data(), memory.rowBytes = 256, memory.size = {16, 16}, memory.format = Format::float32vec4;
  ASSERT_TRUE(host.buffer().ResolveTo(&memory));
  EXPECT_EQ(std::memcmp(top_down.data(), &picture.bytes[15 * 256], 256), 0);
}

TEST(Buffers, TheGenerationRisesOnlyWithNewPixels) {
  Host host;
  add_halves(host);
  host.render();
  const uint64_t generation = host.buffer().GetGeneration();
  EXPECT_GT(generation, 0u);
  for (int i = 0; i < 10; ++i) host.buffer().Resolve();
  EXPECT_EQ(host.buffer().GetGeneration(), generation);
  host.material("/red") = glow(kBlue);
  host.render();
  EXPECT_GT(host.buffer().GetGeneration(), generation);
}

float half_to_float(uint16_t bits) {
  const int exponent = (bits >> 10) & 31, mantissa = bits & 1023;
  const float value = std::ldexp(float(exponent ? mantissa + 1024 : mantissa), (exponent ? exponent : 1) - 25);
  return bits & 0x8000 ? -value : value;
}

// The first component of the pixel in the middle of the left half.
double first_component(const Picture& picture) {
  const size_t at = (size_t(8) * 16 + 4) * FormatSize(picture.format);
  const uint8_t* pixel = picture.bytes.data() + at;
  switch (picture.format) {
    case Format::unorm8:
    case Format::unorm8vec3:
    case Format::unorm8vec4:
      return *pixel / 255.0;
    case Format::float16:
    case Format::float16vec3:
    case Format::float16vec4: {
      uint16_t bits;
      std::memcpy(&bits, pixel, 2);
      return half_to_float(bits);
    }
    default: {
      float value;
      std::memcpy(&value, pixel, 4);
      return value;
    }
  }
}

// OpenUSD#995, arnold#9, rpr#361: colour in 8 bits alone is too poor; any AOV at any format.
TEST(Buffers, ColorIsTheSameInEveryFormat) {
  Host host;
  add_halves(host);
  for (const Format format :
       {Format::unorm8, Format::unorm8vec3, Format::unorm8vec4, Format::float16, Format::float16vec3,
        Format::float16vec4, Format::float32, Format::float32vec2, Format::float32vec3, Format::float32vec4}) {
    host.bind("color", format);
    EXPECT_NEAR(first_component(host.render()), kRed.x, 0.003) << "format " << int(format);
    host.unbind("color");
  }
}

// The task controller of a viewport adds all of these to color without asking.
TEST(Buffers, EveryAovOfAViewportIsThere) {
  Host host;
  add_halves(host);
  for (const char* aov : {"color", "depth", "cameraDepth", "primId", "instanceId", "elementId", "normal"})
    EXPECT_NE(host.delegate->GetDefaultAovDescriptor(aov).format, Format::invalid) << aov;
  EXPECT_EQ(host.delegate->GetDefaultAovDescriptor("no such AOV").format, Format::invalid);
  for (const char* aov : {"depth", "cameraDepth", "primId", "instanceId", "elementId", "normal"}) host.bind(aov);
  host.render();
  const Picture depth = read(host.buffer("cameraDepth")), normal = read(host.buffer("normal"));
  EXPECT_NEAR(depth.number(8, 8), 2, 0.01);
  EXPECT_NEAR(normal.number(8, 8, 2), 1, 1e-3);
  host.unbind("normal");
  EXPECT_TRUE(near(host.render().color(-0.5, 0), kRed)) << "with one buffer less";
}

}  // namespace
}  // namespace conformance
