#include <OpenImageIO/imageio.h>

#include "testenv/unit/delegate/host/product_fixture.h"

namespace alabaster::hd::host {
namespace {

using ApplyDisplayFile = ProductFile;

// ApplyDisplay must return the values that a file holds: a 16-bit PNG stores them without dither.
TEST_F(ApplyDisplayFile, AnswersWhatAPngHolds) {
  ProductImage image = frame();
  image.aovs["color"] =
      floats(3, [](int i, int c) { return i == 3 ? -0.2f : 0.004f * float(i * i) + 0.11f * float(c); });
  RenderProduct p = product("a.png");
  p.dataType = Token("uint16");
  p.exposure = 0.5f;
  ASSERT_TRUE(write(p, image)) << text();
  std::vector<float> shown;
  for (int i = 0; i < kCount; ++i)
    for (int c = 0; c < 3; ++c) shown.push_back(float_of(image, "color", i, c));
  ASSERT_TRUE(ApplyDisplay(p, colors_, shown, sink_)) << text();

  const auto file = OIIO::ImageInput::open(p.file);
  ASSERT_TRUE(file);
  std::vector<float> stored(3 * size_t(kCount));
  ASSERT_TRUE(file->read_image(0, 0, 0, 3, OIIO::TypeFloat, stored.data()));
  for (size_t i = 0; i < stored.size(); ++i) EXPECT_NEAR(shown[i], stored[i], 0.5001f / 65535) << i;
}

TEST_F(ApplyDisplayFile, StaysWithinTheDisplay) {
  std::vector<float> rgb = {NAN, INFINITY, -INFINITY, 1e30f, -5, 0};
  ASSERT_TRUE(ApplyDisplay({}, colors_, rgb, sink_)) << text();
  for (const float v : rgb) EXPECT_TRUE(v >= 0 && v <= 1) << v;
}

TEST_F(ApplyDisplayFile, ReportsAnUnknownView) {
  RenderProduct p = product("a.png");
  p.view = "Nothing of the kind";
  std::vector<float> rgb = {0.5f, 0.5f, 0.5f};
  EXPECT_FALSE(ApplyDisplay(p, colors_, rgb, sink_));
  EXPECT_NE(text().find("Nothing of the kind"), std::string::npos) << text();
  EXPECT_EQ(rgb, std::vector<float>(3, 0.5f));
}

}  // namespace
}  // namespace alabaster::hd::host
