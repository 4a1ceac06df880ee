// Edits of single instances through the C door.
#include "testenv/unit/delegate/c_api/door_fixture.h"

namespace alabaster::door_testing {
namespace {

// Two quads, of which the first is moved to where the camera looks.
TEST_F(Door, OneInstanceIsEditedByItself) {
  const float places[] = {-9, 0, 0, 9, 0, 0}, middle[] = {0, 0, 0};
  const int32_t indices[] = {0, 1};
  const AlabasterPrototype quads = {"/quad", array(ALABASTER_INT, indices, 2)};
  const auto primvar = [](const char* name, AlabasterValue values) {
    return AlabasterPrimvar{name, nullptr, ALABASTER_INSTANCE, values, {}, {}};
  };
  const char* const kPlaces = "hydra:instanceTranslations";
  const AlabasterPrimvar all = primvar(kPlaces, array(ALABASTER_FLOAT3, places, 2));
  const AlabasterPrimvar one = primvar(kPlaces, array(ALABASTER_FLOAT3, middle, 1));
  AlabasterInstancer many = {};
  many.size = sizeof many;
  many.primvars = &all, many.primvar_count = 1;
  many.prototypes = &quads, many.prototype_count = 1;
  ASSERT_EQ(api().set_instancer(scene_, "/many", &many), ALABASTER_OK) << api().last_error();
  ASSERT_EQ(set_quad({}, "/many"), ALABASTER_OK);
  EXPECT_EQ(centre(render())[3], 0);
  ASSERT_EQ(api().set_instance_values(scene_, "/many", &one, 0), ALABASTER_OK) << api().last_error();
  EXPECT_EQ(centre(render())[3], 1);

  EXPECT_EQ(api().set_instance_values(scene_, "/nobody", &one, 0), ALABASTER_NOT_FOUND);
  const AlabasterPrimvar none = primvar("hydra:instanceScales", array(ALABASTER_FLOAT3, middle, 1));
  EXPECT_EQ(api().set_instance_values(scene_, "/many", &none, 0), ALABASTER_NOT_FOUND);
  EXPECT_EQ(api().set_instance_values(scene_, "/many", &one, 2), ALABASTER_INVALID_ARGUMENT);
  const AlabasterPrimvar wrong = primvar(kPlaces, array(ALABASTER_FLOAT, middle, 1));
  EXPECT_EQ(api().set_instance_values(scene_, "/many", &wrong, 0), ALABASTER_INVALID_ARGUMENT);
  EXPECT_EQ(api().set_instance_values(scene_, "/many", nullptr, 0), ALABASTER_INVALID_ARGUMENT);
}

}  // namespace
}  // namespace alabaster::door_testing
