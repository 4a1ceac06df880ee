// Pixels on their way from buffers to textures, by a thread of their own.
#include "delegate/view/picture_fetcher.h"

#include <gtest/gtest.h>

#include <chrono>
#include <thread>

namespace alabaster::view {
namespace {

using hd::Format;

/// A buffer of pixels of one value, which may take long to resolve.
class FakeBuffer final : public hd::RenderBuffer {
 public:
  FakeBuffer(int width, int height, float value) : RenderBuffer("/buffer"), size_(width, height), value_(value) {}
  void set(float value) { value_ = value, ++picture_; }
  void resize(int width, int height) { size_ = {width, height}, ++picture_; }

  hd::DirtyBits GetInitialDirtyBitsMask() const override { return hd::dirty::kClean; }
  void Sync(hd::SceneDelegate*, hd::RenderParam*, hd::DirtyBits*) override {}
  void Finalize(hd::RenderParam*) override {}
  bool Allocate(const hd::RenderBufferDescriptor&) override { return true; }
  int GetWidth() const override { return size_.x; }
  int GetHeight() const override { return size_.y; }
  Format GetFormat() const override { return Format::float32; }
  void Resolve() override {}
  const void* Map() override { return nullptr; }
  void Unmap() override {}
  bool IsMapped() const override { return false; }
  bool IsConverged() const override { return converged; }
  uint64_t GetGeneration() const override { return picture_; }
  bool ResolveTo(hd::PixelMemory* memory) override {
    std::this_thread::sleep_for(std::chrono::milliseconds(slowness));
    if (!(memory->size == size_)) {
      memory->size = size_;
      return false;
    }
    if (memory->shown == picture_) return true;
    if (memory->format == Format::float32) ++read_as_numbers;
    const auto count = size_t(size_.x) * size_t(size_.y);
    if (memory->format == Format::float32) std::fill_n(static_cast<float*>(memory->pixels), count, value_);
    if (memory->format == Format::unorm8vec4) {
      std::array<float, 4> pixel{value_, 0, 0, 1};
      if (memory->transform) memory->transform->Apply(pixel);
      for (size_t i = 0; i < 4 * count; ++i)
        static_cast<uint8_t*>(memory->pixels)[i] = uint8_t(std::lround(255 * pixel[i % 4]));
    }
    memory->shown = picture_;
    return true;
  }
  int slowness = 0;  // milliseconds
  bool converged = true;
  int read_as_numbers = 0;

 private:
  hd::Vec2i size_;
  float value_;
  uint64_t picture_ = 1;
};

// The newest picture of a side, once the fetcher has nothing left to do.
bool fetched(PictureFetcher* fetcher, const PictureRequest& left, const PictureRequest& right, bool of_right,
             Picture* picture) {
  while (fetcher->busy()) std::this_thread::yield();
  fetcher->fetch(left, right);
  while (fetcher->busy()) std::this_thread::yield();
  return fetcher->take(of_right, picture);
}

PictureRequest light(FakeBuffer* buffer) {
  PictureRequest request;
  request.buffer = buffer;
  return request;
}

TEST(PictureFetcher, BringsEachChangeOnce) {
  FakeBuffer buffer(4, 3, 0.2f);
  PictureFetcher fetcher;
  Picture picture;
  ASSERT_TRUE(fetched(&fetcher, light(&buffer), {}, false, &picture));
  EXPECT_EQ(picture.size, hd::Vec2i(4, 3));
  ASSERT_EQ(picture.rgba.size(), 48u);
  EXPECT_EQ(picture.rgba[0], 51);
  EXPECT_EQ(picture.rgba[1], 51) << "one component is gray, not red";
  EXPECT_EQ(picture.rgba[2], 51);
  EXPECT_FALSE(fetched(&fetcher, light(&buffer), {}, false, &picture)) << "nothing is new";
  buffer.set(0.4f);
  ASSERT_TRUE(fetched(&fetcher, light(&buffer), {}, false, &picture));
  EXPECT_EQ(picture.rgba[44], 102);
  buffer.resize(2, 2);
  ASSERT_TRUE(fetched(&fetcher, light(&buffer), {}, false, &picture));
  EXPECT_EQ(picture.rgba.size(), 16u);
}

TEST(PictureFetcher, AnotherBufferOrVersionIsWrittenWhole) {
  FakeBuffer color(2, 2, 0.2f), denoised(2, 2, 0.6f);
  PictureFetcher fetcher;
  Picture left, right;
  ASSERT_TRUE(fetched(&fetcher, light(&color), light(&denoised), false, &left));
  ASSERT_TRUE(fetcher.take(true, &right));
  EXPECT_EQ(left.rgba[0], 51);
  EXPECT_EQ(right.rgba[0], 153);
  ASSERT_TRUE(fetched(&fetcher, light(&denoised), {}, false, &left));
  EXPECT_EQ(left.rgba[0], 153);
  PictureRequest other = light(&denoised);
  other.version = 7;
  EXPECT_TRUE(fetched(&fetcher, other, {}, false, &left)) << "another exposure";
}

TEST(PictureFetcher, NumbersAreSpreadOverTheirRange) {
  FakeBuffer buffer(2, 2, 8);
  PictureFetcher fetcher;
  Picture picture;
  PictureRequest request = light(&buffer);
  request.kind = DataKind::number;
  ASSERT_TRUE(fetched(&fetcher, request, {}, false, &picture));
  EXPECT_EQ(picture.rgba[0], 255) << "of 0 to 8";
  EXPECT_EQ(picture.rgba[1], 255) << "gray";
}

// Many pictures of a window show the same numbers; and numbers that go on changing keep their range for a while.
TEST(PictureFetcher, ARangeIsFoundOnceForEachPictureOfABuffer) {
  FakeBuffer buffer(2, 2, 8);
  PictureFetcher fetcher;
  Picture picture;
  PictureRequest request = light(&buffer);
  request.kind = DataKind::number;
  for (int i = 0; i < 5; ++i) fetched(&fetcher, request, {}, false, &picture);
  EXPECT_EQ(buffer.read_as_numbers, 1);
  buffer.set(16);
  for (int i = 0; i < 5; ++i) fetched(&fetcher, request, {}, false, &picture);
  EXPECT_EQ(buffer.read_as_numbers, 2);
  EXPECT_EQ(picture.rgba[0], 255) << "of 0 to 16";

  buffer.converged = false;
  const auto begun = std::chrono::steady_clock::now();
  for (int i = 0; i < 5; ++i) {
    buffer.set(float(4 - i % 2));
    EXPECT_TRUE(fetched(&fetcher, request, {}, false, &picture)) << "the pixels are new";
  }
  if (std::chrono::steady_clock::now() - begun < std::chrono::milliseconds(400)) {
    EXPECT_EQ(buffer.read_as_numbers, 2);
    EXPECT_EQ(picture.rgba[0], 64) << "4 of 0 to 16";
  }
  buffer.converged = true;
  fetched(&fetcher, request, {}, false, &picture);
  EXPECT_EQ(picture.rgba[0], 255) << "4 of 0 to 4";
  PictureRequest ids = light(&buffer);
  ids.kind = DataKind::id;
  const int before = buffer.read_as_numbers;
  buffer.set(5);
  fetched(&fetcher, ids, {}, false, &picture);
  EXPECT_EQ(buffer.read_as_numbers, before) << "ids need no range";
}

TEST(PictureFetcher, TheCallerNeverWaits) {
  FakeBuffer slow(2, 2, 0.2f);
  slow.slowness = 300;
  PictureFetcher fetcher;
  const auto begun = std::chrono::steady_clock::now();
  Picture picture;
  fetcher.fetch(light(&slow), {});
  fetcher.fetch(light(&slow), {});
  EXPECT_FALSE(fetcher.take(false, &picture));
  EXPECT_LT(std::chrono::steady_clock::now() - begun, std::chrono::milliseconds(200));
}

}  // namespace
}  // namespace alabaster::view
