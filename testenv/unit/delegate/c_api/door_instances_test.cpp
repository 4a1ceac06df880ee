// Edits of single instances through the C interface.
#include "testenv/unit/delegate/c_api/door_fixture.h"

namespace alabaster::c_api_testing {
namespace {

// Two quads, of which the first is moved to where the camera looks.
TEST_F(Door, OneInstanceIsEditedByItself) {
  const float places[] = {-9, 0, 0, 9, 0, 0}, middle[] = {0, 0, 0};
  const int32_t indices[] = {0, 1};
  const char* const kPlaces = "hydra:instanceTranslations";
  const AlabasterValue one = array(ALABASTER_FLOAT3, middle, 1);
  ASSERT_EQ(set(scene_, "/many", "instancer",
                {{"primvars:hydra:instanceTranslations", array(ALABASTER_FLOAT3, places, 2)},
                 {"prototypes:/quad", array(ALABASTER_INT, indices, 2)}}),
            ALABASTER_OK)
      << api().last_error();
  ASSERT_EQ(set_quad({}, "/many"), ALABASTER_OK);
  EXPECT_EQ(centre(render())[3], 0);
  ASSERT_EQ(api().scene_set_instances(scene_, "/many", kPlaces, 0, &one), ALABASTER_OK) << api().last_error();
  EXPECT_EQ(centre(render())[3], 1);

  EXPECT_EQ(api().scene_set_instances(scene_, "/missing", kPlaces, 0, &one), ALABASTER_NOT_FOUND);
  EXPECT_EQ(api().scene_set_instances(scene_, "/quad", kPlaces, 0, &one), ALABASTER_NOT_FOUND) << "no instancer";
  EXPECT_EQ(api().scene_set_instances(scene_, "/many", "hydra:instanceScales", 0, &one), ALABASTER_NOT_FOUND);
  EXPECT_EQ(api().scene_set_instances(scene_, "/many", kPlaces, 2, &one), ALABASTER_INVALID_ARGUMENT);
  EXPECT_EQ(api().scene_set_instances(scene_, "/many", kPlaces, ~size_t(0), &one), ALABASTER_INVALID_ARGUMENT);
  const AlabasterValue wrong = array(ALABASTER_FLOAT, middle, 1);
  EXPECT_EQ(api().scene_set_instances(scene_, "/many", kPlaces, 0, &wrong), ALABASTER_INVALID_ARGUMENT);
  const AlabasterValue none = {}, alone = scalar(ALABASTER_FLOAT3, middle);
  EXPECT_EQ(api().scene_set_instances(scene_, "/many", kPlaces, 0, &none), ALABASTER_INVALID_ARGUMENT);
  EXPECT_EQ(api().scene_set_instances(scene_, "/many", kPlaces, 0, &alone), ALABASTER_INVALID_ARGUMENT);
  const AlabasterSample moving[] = {{0, one}, {1, one}};
  const AlabasterValue sampled = samples(moving);
  EXPECT_EQ(api().scene_set_instances(scene_, "/many", kPlaces, 0, &sampled), ALABASTER_INVALID_ARGUMENT);
  for (const auto& [path, name, values] :
       {std::tuple<const char*, const char*, const AlabasterValue*>{nullptr, kPlaces, &one},
        {"/many", nullptr, &one},
        {"/many", kPlaces, nullptr}}) {
    EXPECT_EQ(api().scene_set_instances(scene_, path, name, 0, values), ALABASTER_INVALID_ARGUMENT);
    EXPECT_TRUE(says("is null")) << api().last_error();
  }
  EXPECT_EQ(centre(render())[3], 1) << "none of them has changed anything";

  const float far[] = {70, 0, 0};
  const AlabasterValue away = array(ALABASTER_FLOAT3, far, 1);
  const AlabasterParameter and_another[] = {{kPlaces, away}, {"hydra:instanceZ", one}};  // the later by name
  EXPECT_EQ(api().scene_edit_instances(scene_, "/many", 0, and_another, 2), ALABASTER_NOT_FOUND);
  EXPECT_EQ(api().scene_edit_instances(scene_, "/many", 2, and_another, 1), ALABASTER_INVALID_ARGUMENT);
  EXPECT_EQ(api().scene_edit_instances(scene_, "/many", 0, nullptr, 1), ALABASTER_INVALID_ARGUMENT);
  EXPECT_EQ(centre(render())[3], 1) << "all or none";
  EXPECT_EQ(api().scene_edit_instances(scene_, "/many", 0, and_another, 1), ALABASTER_OK) << api().last_error();
  EXPECT_EQ(centre(render())[3], 0);
}

}  // namespace
}  // namespace alabaster::c_api_testing
