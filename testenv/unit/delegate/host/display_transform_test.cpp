#include "delegate/host/display_transform.h"

#include <OpenImageIO/imageio.h>

#include "testenv/unit/delegate/host/product_fixture.h"

namespace alabaster::hd::host {
namespace {

class DisplayTransformFile : public ProductFile {
 protected:
  // The frame's colours as they are shown.
  std::vector<float> shown(const ProductImage& image, const DisplayTransform& display) {
    std::vector<float> rgba(4 * size_t(kCount), 0.25f);
    for (int i = 0; i < kCount; ++i)
      for (int c = 0; c < 3; ++c) rgba[size_t(4 * i + c)] = float_of(image, "color", i, c);
    display.Apply(rgba);
    return rgba;
  }
};

// It must return the values that a file holds: a 16-bit PNG stores them without dither.
// promise: embedding.viewport.resolve_to
TEST_F(DisplayTransformFile, AnswersWhatAPngHolds) {
  ProductImage image = frame();
  image.aovs["color"] =
      floats(3, [](int i, int c) { return i == 3 ? -0.2f : 0.004f * float(i * i) + 0.11f * float(c); });
  RenderProduct p = product("a.png");
  p.dataType = Token("uint16");
  const auto display = DisplayTransform::Create(p, colors_, sink_);
  ASSERT_TRUE(display) << text();
  for (const float exposure : {0.5f, -1.0f}) {
    p.exposure = exposure;
    ASSERT_TRUE(write(p, image)) << text();
    ASSERT_TRUE(display->SetExposure(exposure));
    const std::vector<float> rgba = shown(image, *display);

    const auto file = OIIO::ImageInput::open(p.file);
    ASSERT_TRUE(file);
    std::vector<float> stored(3 * size_t(kCount));
    ASSERT_TRUE(file->read_image(0, 0, 0, 3, OIIO::TypeFloat, stored.data()));
    for (size_t i = 0; i < stored.size(); ++i)
      EXPECT_NEAR(rgba[i / 3 * 4 + i % 3], stored[i], 0.5001f / 65535) << exposure << ", " << i;
    for (size_t i = 3; i < rgba.size(); i += 4) EXPECT_EQ(rgba[i], 0.25f) << "alpha stays";
  }
}

TEST_F(DisplayTransformFile, StaysWithinTheDisplay) {
  const auto display = DisplayTransform::Create({}, colors_, sink_);
  ASSERT_TRUE(display) << text();
  std::vector<float> rgba = {NAN, INFINITY, -INFINITY, 1, 1e30f, -5, 0, 1};
  display->Apply(rgba);
  for (const float v : rgba) EXPECT_TRUE(v >= 0 && v <= 1) << v;
}

TEST_F(DisplayTransformFile, ReportsAnUnknownViewAndAnImpossibleExposure) {
  RenderProduct p = product("a.png");
  p.view = "Nothing of the kind";
  EXPECT_FALSE(DisplayTransform::Create(p, colors_, sink_));
  EXPECT_NE(text().find("Nothing of the kind"), std::string::npos) << text();
  p.view = {}, p.exposure = NAN;
  EXPECT_FALSE(DisplayTransform::Create(p, colors_, sink_));
  EXPECT_NE(text().find("exposure"), std::string::npos) << text();
  const auto display = DisplayTransform::Create({}, colors_, sink_);
  EXPECT_FALSE(display->SetExposure(1e9f));
}

}  // namespace
}  // namespace alabaster::hd::host
