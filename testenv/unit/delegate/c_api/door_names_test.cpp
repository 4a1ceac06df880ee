// Wrong names, paths and sizes through the C interface: each is refused with a sentence that names the right one.
#include "testenv/unit/delegate/c_api/door_fixture.h"

namespace alabaster::c_api_testing {
namespace {

class DoorNames : public Door {
 protected:
  static void ignore(void*, const char*, const AlabasterValue*) {}
  AlabasterStatus get(const char* key) { return api().get_setting(delegate_, key, &ignore, nullptr); }
  AlabasterStatus start(int32_t width, int32_t height, const AlabasterRect& window = {}) {
    const AlabasterBinding binding = {"color", color_};
    AlabasterFrame frame{};
    frame.size = sizeof frame;
    frame.bindings = &binding, frame.binding_count = 1;
    frame.camera = "/camera";
    frame.width = width, frame.height = height, frame.window = window;
    return api().pass_start(pass_, &frame);
  }
};

TEST_F(DoorNames, AnUnknownSettingIsAsWrongToGetAsToSet) {
  const int32_t one = 1;
  const AlabasterValue value = whole(one);
  EXPECT_EQ(api().set_setting(delegate_, "sampels", &value), ALABASTER_INVALID_ARGUMENT);
  const std::string said = api().last_error();
  EXPECT_EQ(get("sampels"), ALABASTER_INVALID_ARGUMENT);
  EXPECT_EQ(api().last_error(), said);
  EXPECT_TRUE(says("did you mean 'samples'?")) << said;
  for (const char* known : {"samples", "ocio", "renderSettingsPrimPath", "denoise"})
    EXPECT_EQ(get(known), ALABASTER_OK) << api().last_error();
  EXPECT_EQ(get(nullptr), ALABASTER_INVALID_ARGUMENT);
}

TEST_F(DoorNames, AnUnknownPathGetsTheNearest) {
  const float one = 1;
  EXPECT_EQ(api().remove(scene_, "/qaud"), ALABASTER_NOT_FOUND);
  EXPECT_STREQ(api().last_error(), "there is no prim /qaud; did you mean '/quad'?");
  EXPECT_EQ(edit(scene_, "/doem", {{"intensity", number(one)}}), ALABASTER_NOT_FOUND);
  EXPECT_STREQ(api().last_error(), "there is no prim /doem; did you mean '/dome'?");
  EXPECT_EQ(api().remove(scene_, "/far/away"), ALABASTER_NOT_FOUND);
  EXPECT_STREQ(api().last_error(), "there is no prim /far/away");
  EXPECT_EQ(set_settings(), ALABASTER_OK);
  frame_.settings = "/setings";
  EXPECT_EQ(Door::start(), ALABASTER_NOT_FOUND);
  EXPECT_STREQ(api().last_error(), "there are no render settings /setings; did you mean '/settings'?");
  EXPECT_EQ(api().remove(scene_, "/quad"), ALABASTER_OK);
  EXPECT_EQ(api().remove(scene_, "/quad"), ALABASTER_NOT_FOUND);
}

TEST_F(DoorNames, AnUnknownInstancerOrPrimvarGetsTheNearest) {
  const float places[] = {0, 0, 0};
  const AlabasterValue value = array(ALABASTER_FLOAT3, places, 1);
  ASSERT_EQ(set(scene_, "/many", "instancer", {{"primvars:hydra:instanceTranslations", value}}), ALABASTER_OK);
  EXPECT_EQ(api().scene_set_instances(scene_, "/mnay", "hydra:instanceTranslations", 0, &value), ALABASTER_NOT_FOUND);
  EXPECT_STREQ(api().last_error(), "there is no instancer /mnay; did you mean '/many'?");
  EXPECT_EQ(api().scene_set_instances(scene_, "/many", "hydra:instanceTranslation", 0, &value), ALABASTER_NOT_FOUND);
  EXPECT_TRUE(says("did you mean 'hydra:instanceTranslations'?")) << api().last_error();
}

// promise: embedding.viewport.sizes
TEST_F(DoorNames, ABufferOfAnotherSizeThanTheFrameIsRefused) {
  EXPECT_EQ(start(kSide, 8), ALABASTER_INVALID_ARGUMENT);
  EXPECT_TRUE(says("the buffer of AOV 'color' has 16 x 16 pixels, but the frame has 16 x 8: ")) << api().last_error();
  EXPECT_EQ(start(32, 32), ALABASTER_INVALID_ARGUMENT);
  EXPECT_EQ(start(32, 32, {4, 4, 4 + kSide, 4 + kSide}), ALABASTER_OK) << "it is as large as the window";
  ASSERT_EQ(api().buffer_resize(color_, 32, 24, ALABASTER_FLOAT32_4), ALABASTER_OK);
  EXPECT_EQ(start(kSide, kSide), ALABASTER_INVALID_ARGUMENT) << "the size that the buffer gets by this start";
  EXPECT_EQ(start(32, 24), ALABASTER_OK);
}

TEST_F(DoorNames, AColourHasThreeNumbers) {
  const float four[] = {1, 1, 1, 1};
  const AlabasterValue three = scalar(ALABASTER_FLOAT3, four), too_many = scalar(ALABASTER_FLOAT4, four);
  EXPECT_EQ(edit(scene_, "/dome", {{"color", three}}), ALABASTER_OK);
  EXPECT_EQ(edit(scene_, "/dome", {{"color", too_many}}), ALABASTER_INVALID_ARGUMENT);
  EXPECT_TRUE(says("'color' must be a colour: three numbers")) << api().last_error();
  EXPECT_EQ(
      set(scene_, "/wax", "material", {{"surface.type", word("AlabasterDisney")}, {"surface.baseColor", too_many}}),
      ALABASTER_INVALID_ARGUMENT);
}

}  // namespace
}  // namespace alabaster::c_api_testing
