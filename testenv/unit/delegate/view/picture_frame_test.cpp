// The picture's place on screens of any density.
#include "delegate/view/picture_frame.h"

#include <gtest/gtest.h>

#include <cmath>

namespace alabaster::view {
namespace {

using hd::Vec2d;
using hd::Vec2f;
using hd::Vec2i;

TEST(PictureFrame, FillsTheRoomInItsMiddle) {
  const PictureFrame wide = PictureFrame::fit({10, 20}, {400, 100}, 2, 1);
  EXPECT_EQ(wide.low(), Vec2f(110, 20));
  EXPECT_EQ(wide.high(), Vec2f(310, 120));
  EXPECT_EQ(wide.pixels(1), Vec2i(200, 100));
  EXPECT_EQ(wide.pixels(2), Vec2i(100, 50));
  const PictureFrame tall = PictureFrame::fit({10, 20}, {100, 400}, 2, 1);
  EXPECT_EQ(tall.low(), Vec2f(10, 195));
  EXPECT_EQ(tall.pixels(4), Vec2i(25, 12));
}

// A screen with twice the pixels in the same window shows twice as many; the cursor is where it was.
TEST(PictureFrame, ADenseScreenHasMorePixelsInTheSamePlace) {
  const PictureFrame plain = PictureFrame::fit({0, 40}, {801, 601}, 1.5, 1);
  const PictureFrame dense = PictureFrame::fit({0, 40}, {801, 601}, 1.5, 2);
  EXPECT_EQ(plain.pixels(1), Vec2i(801, 534));
  EXPECT_EQ(dense.pixels(1), Vec2i(1602, 1068));
  const Vec2d place = dense.place({400.5f, 340.5f});
  EXPECT_NEAR(place.x, plain.place({400.5f, 340.5f}).x, 1e-3);
  EXPECT_NEAR(place.x, 0.5, 1e-3);
  EXPECT_NEAR(place.y, 0.5, 1e-3);
}

// A pixel of the picture is one of the screen, so that nothing is smeared.
TEST(PictureFrame, StandsOnWholePixelsOfAnyDensity) {
  for (const float density : {1.0f, 1.25f, 1.5f, 2.0f, 3.0f})
    for (const float width : {333.0f, 500.4f, 777.7f}) {
      const PictureFrame frame = PictureFrame::fit({3, 37}, {width, 411}, 4.0 / 3, density);
      const Vec2i pixels = frame.pixels(1);
      for (int i = 0; i < 2; ++i) {
        const float low = frame.low()[i] * density, high = frame.high()[i] * density;
        EXPECT_NEAR(low, std::round(low), 1e-3f) << density << " " << width;
        EXPECT_NEAR(high - low, float(pixels[i]), 1e-3f) << density << " " << width;
      }
    }
}

TEST(PictureFrame, TheCursorIsOverThePixelThatItShows) {
  const PictureFrame frame = PictureFrame::fit({7, 31}, {640, 480}, 1.25, 2);
  const Vec2i pixels = frame.pixels(1);
  for (const Vec2i& pixel : {Vec2i(0, 0), Vec2i(17, 250), Vec2i(pixels.x - 1, pixels.y - 1)}) {
    const Vec2d middle((pixel.x + 0.5) / pixels.x, (pixel.y + 0.5) / pixels.y);
    const Vec2d back = frame.place(frame.cursor(middle));
    EXPECT_EQ(int(back.x * pixels.x), pixel.x);
    EXPECT_EQ(int(back.y * pixels.y), pixel.y);
  }
}

TEST(ScreenScale, LettersAreAsLargeAsTheDesktopWants) {
  const ScreenScale plain, x11{2, 1}, wayland{2, 2};
  EXPECT_EQ(plain.pixels(15), 15);
  EXPECT_EQ(x11.pixels(15), 30);
  EXPECT_EQ(x11.units(15), 30) << "units are pixels there";
  EXPECT_EQ(wayland.pixels(15), 30);
  EXPECT_EQ(wayland.units(15), 15);
}

}  // namespace
}  // namespace alabaster::view
