#include "delegate/rendering/framing.h"

#include <gtest/gtest.h>

#include <functional>
#include <limits>

namespace alabaster::hd::rendering {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInf = std::numeric_limits<float>::infinity();

Framing framing(Vec2f low, Vec2f high, Rect2i data, float pixel_aspect = 1) {
  Framing f;
  f.displayMin = low;
  f.displayMax = high;
  f.dataWindow = data;
  f.pixelAspectRatio = pixel_aspect;
  return f;
}

TEST(Framing, WindowPoliciesConformTheFilmAsHydraDoes) {
  struct Case {
    WindowPolicy policy;
    float width, height;  // image, pixels
    float horizontal, vertical;
  };
  CameraParameters camera;
  camera.horizontal_aperture = 36;
  camera.vertical_aperture = 24;
  for (const Case& c :
       {Case{WindowPolicy::matchVertically, 100, 100, 24, 24}, Case{WindowPolicy::matchHorizontally, 100, 100, 36, 36},
        Case{WindowPolicy::fit, 100, 100, 36, 36}, Case{WindowPolicy::crop, 100, 100, 24, 24},
        Case{WindowPolicy::dontConform, 100, 100, 36, 24}, Case{WindowPolicy::matchVertically, 300, 100, 72, 24},
        Case{WindowPolicy::matchHorizontally, 300, 100, 36, 12}, Case{WindowPolicy::fit, 300, 100, 72, 24},
        Case{WindowPolicy::crop, 300, 100, 36, 12}, Case{WindowPolicy::dontConform, 300, 100, 36, 24}}) {
    const Framing f = framing({0, 0}, {c.width, c.height}, {0, 0, 10, 10});
    const FramedCamera framed = frame_camera(camera, f, c.policy);
    EXPECT_FLOAT_EQ(framed.camera.horizontal_aperture, c.horizontal) << static_cast<int>(c.policy) << " " << c.width;
    EXPECT_FLOAT_EQ(framed.camera.vertical_aperture, c.vertical) << static_cast<int>(c.policy) << " " << c.width;
  }
}

TEST(Framing, PixelsThatAreTwiceAsWideSeeTwiceAsMuch) {
  CameraParameters camera;
  const Framing f = framing({0, 0}, {10, 10}, {0, 0, 10, 10}, 2);
  const FramedCamera framed = frame_camera(camera, f, WindowPolicy::matchVertically);
  EXPECT_FLOAT_EQ(framed.camera.horizontal_aperture, 2 * framed.camera.vertical_aperture);
}

TEST(Framing, TheDataWindowCountsFromTheDisplayWindowsCorner) {
  const FramedCamera framed =
      frame_camera({}, framing({-5, 3}, {11, 13}, {-6, 4, 7, 20}), WindowPolicy::matchVertically);
  EXPECT_EQ(framed.width, 16);
  EXPECT_EQ(framed.height, 10);
  EXPECT_EQ(framed.buffer_x, -5);
  EXPECT_EQ(framed.buffer_y, 3);
  EXPECT_EQ(framed.data_window, (PixelRect{-1, 1, 12, 17}));
}

// A ray through buffer position b must look where the fractional window says: u = (b - low) / (high - low) of the film.
TEST(Framing, FractionalEdgesMoveNoPixel) {
  CameraParameters camera;
  camera.focal_length = 1;
  camera.horizontal_aperture = 2;
  camera.vertical_aperture = 1.5f;
  camera.horizontal_aperture_offset = 0.125f;
  camera.vertical_aperture_offset = -0.25f;
  const Vec2f low(0.25f, -1.5f), high(9.75f, 8.25f);
  const FramedCamera framed = frame_camera(camera, framing(low, high, {0, -1, 9, 8}), WindowPolicy::dontConform);
  EXPECT_EQ(framed.width, 10);
  EXPECT_EQ(framed.height, 11);
  const Camera seen(framed.camera, framed.width, framed.height, alabaster::Vec3d(0, 0, 0));
  for (const Vec2f& b : {Vec2f(0.5f, -0.5f), Vec2f(4.5f, 3.5f), Vec2f(8.5f, 7.5f)}) {
    const alabaster::Vec2f film(b.x - static_cast<float>(framed.buffer_x), b.y - static_cast<float>(framed.buffer_y));
    const alabaster::Vec3f d = seen.generate_ray(film, {}).dir;
    const Vec2f u = (b - low) / (high - low);
    EXPECT_NEAR(d.x / -d.z, (u.x - 0.5f) * 2 + 0.125f, 1e-5) << b.x;
    EXPECT_NEAR(d.y / -d.z, (0.5f - u.y) * 1.5f - 0.25f, 1e-5) << b.y;
  }
}

TEST(Framing, FaultsAreNamed) {
  const auto fault = [](const std::function<void(Framing&)>& change) {
    Framing f = framing({0, 0}, {8, 6}, {0, 0, 8, 6});
    change(f);
    return framing_fault(f);
  };
  const auto names = [](const std::string& text, const char* expected) {
    return text.find(expected) != std::string::npos ? ::testing::AssertionSuccess()
                                                    : ::testing::AssertionFailure() << "'" << text << "'";
  };
  for (const float aspect : {kNan, kInf, 0.0f, -1.0f})
    EXPECT_TRUE(names(fault([&](Framing& f) { f.pixelAspectRatio = aspect; }), "pixel aspect ratio")) << aspect;
  for (const float edge : {kNan, kInf, -kInf}) {
    EXPECT_TRUE(names(fault([&](Framing& f) { f.displayMin.x = edge; }), "not finite"));
    EXPECT_TRUE(names(fault([&](Framing& f) { f.displayMax.y = edge; }), "not finite"));
  }
  EXPECT_TRUE(
      names(fault([](Framing& f) { f.displayMax.x = -8; }), "display window, (0, 0) to (-8, 6), is inside out"));
  EXPECT_TRUE(names(fault([](Framing& f) { f.displayMin.y = 7; }), "display window, (0, 7) to (8, 6), is inside out"));
  EXPECT_TRUE(names(fault([](Framing& f) { f.dataWindow.minX = 9; }), "data window, (9, 0) to (8, 6), is inside out"));
  EXPECT_TRUE(names(fault([](Framing& f) { f.dataWindow.maxY = -1; }), "data window"));
  EXPECT_TRUE(names(fault([](Framing& f) { f.displayMax.x = 3e6f; }), "2^20"));
  EXPECT_TRUE(names(fault([](Framing& f) { f.dataWindow.maxX = 1 << 21; }), "2^20"));
}

TEST(Framing, EmptyWindowsAreNoFault) {
  EXPECT_EQ(framing_fault({}), "") << "a host that has set nothing yet";
  EXPECT_EQ(framing_fault(framing({0, 0}, {8, 6}, {3, 3, 3, 6})), "");
  EXPECT_EQ(framing_fault(framing({2, 0}, {2, 6}, {0, 0, 8, 6})), "");
}

}  // namespace
}  // namespace alabaster::hd::rendering
