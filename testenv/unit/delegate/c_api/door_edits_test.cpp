// Edits of what moves, prims that change their kind, and renders that are only looked at.
#include <chrono>
#include <thread>

#include "testenv/unit/delegate/c_api/door_fixture.h"

namespace alabaster::c_api_testing {
namespace {

class DoorEdits : public Door {
 protected:
  bool is_in_the_middle() { return centre(render())[3] > 0.5f; }
  std::string kind_of(const char* path) {
    struct Asked {
      std::string path, kinds;
    } asked{path, ""};
    const auto visit = [](void* user, const char* name, const AlabasterValue* value) {
      auto& it = *static_cast<Asked*>(user);
      if (it.path == name) it.kinds += static_cast<const char*>(value->data);
    };
    EXPECT_EQ(api().get_prims(scene_, visit, &asked), ALABASTER_OK);
    return asked.kinds;
  }
};

// Each stays at `aside` by two samples, which the new transform takes away.
TEST_F(DoorEdits, ATransformMovesWhatMoves) {
  for (const auto& [name, z] : {std::pair("/quad", 0), {"/camera", 6}}) {
    SCOPED_TRACE(name);
    const auto aside = at(50, z), here = at(0, z);
    const AlabasterSample held[] = {{0, matrix(aside)}, {1, matrix(aside)}};
    ASSERT_EQ(edit(scene_, name, {{"transform:samples", samples(held)}}), ALABASTER_OK) << api().last_error();
    EXPECT_FALSE(is_in_the_middle());
    ASSERT_EQ(edit(scene_, name, {{"transform", matrix(here)}}), ALABASTER_OK);
    EXPECT_TRUE(is_in_the_middle());
    ASSERT_EQ(edit(scene_, name, {{"transform", matrix(here)}, {"transform:samples", samples(held)}}), ALABASTER_OK);
    EXPECT_FALSE(is_in_the_middle()) << "samples that come after it stay";
    ASSERT_EQ(edit(scene_, name, {{"transform:samples", {}}}), ALABASTER_OK);
    EXPECT_TRUE(is_in_the_middle());
  }
}

TEST_F(DoorEdits, PointsTakeTheirSamplesAway) {
  const float corners[] = {-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0}, far[] = {49, -1, 0, 51, -1, 0, 51, 1, 0, 49, 1, 0};
  const AlabasterValue there = array(ALABASTER_FLOAT3, far, 4);
  const AlabasterSample held[] = {{0, there}, {1, there}};
  ASSERT_EQ(edit(scene_, "/quad", {{"primvars:points:samples", samples(held)}}), ALABASTER_OK) << api().last_error();
  EXPECT_FALSE(is_in_the_middle());
  ASSERT_EQ(edit(scene_, "/quad", {{"primvars:points", array(ALABASTER_FLOAT3, corners, 4)}}), ALABASTER_OK);
  EXPECT_TRUE(is_in_the_middle());
}

TEST_F(DoorEdits, ATransformAndValuesMoveInstancesThatMove) {
  const float places[] = {0, 0, 0, 70, 0, 0}, far[] = {90, 0, 0}, middle[] = {0, 0, 0};
  const int32_t indices[] = {0, 1};
  const char* const kPlaces = "hydra:instanceTranslations";
  const AlabasterValue all = array(ALABASTER_FLOAT3, places, 2);
  const auto aside = at(50);
  const AlabasterSample places_held[] = {{0, all}, {1, all}}, held[] = {{0, matrix(aside)}, {1, matrix(aside)}};
  ASSERT_EQ(set(scene_, "/many", "instancer",
                {{"primvars:hydra:instanceTranslations", all},
                 {"primvars:hydra:instanceTranslations:samples", samples(places_held)},
                 {"prototypes:/quad", array(ALABASTER_INT, indices, 2)},
                 {"transform:samples", samples(held)}}),
            ALABASTER_OK)
      << api().last_error();
  ASSERT_EQ(set_quad({}, "/many"), ALABASTER_OK);
  EXPECT_FALSE(is_in_the_middle());
  ASSERT_EQ(edit(scene_, "/many", {{"transform", matrix(at(0))}}), ALABASTER_OK);
  EXPECT_TRUE(is_in_the_middle());

  AlabasterValue one = array(ALABASTER_FLOAT3, far, 1);
  ASSERT_EQ(api().scene_set_instances(scene_, "/many", kPlaces, 0, &one), ALABASTER_OK) << api().last_error();
  EXPECT_FALSE(is_in_the_middle());
  one = array(ALABASTER_FLOAT3, middle, 1);
  ASSERT_EQ(api().scene_set_instances(scene_, "/many", kPlaces, 1, &one), ALABASTER_OK) << api().last_error();
  EXPECT_TRUE(is_in_the_middle());
}

TEST_F(DoorEdits, APrimOfAnotherKindReplacesAMesh) {
  for (const char* kind : {"rectLight", "diskLight", "cylinderLight", "sphereLight", "distantLight", "domeLight",
                           "material", "camera", "renderSettings", "instancer"}) {
    SCOPED_TRACE(kind);
    ASSERT_EQ(set_quad({}), ALABASTER_OK);
    EXPECT_EQ(kind_of("/quad"), "mesh");
    EXPECT_TRUE(is_in_the_middle());
    const auto place = at(0, 99);
    const Fields behind = {{"transform", matrix(place)}};
    ASSERT_EQ(set(scene_, "/quad", kind, std::string(kind).ends_with("Light") ? behind : Fields()), ALABASTER_OK);
    EXPECT_EQ(kind_of("/quad"), kind);
    EXPECT_FALSE(is_in_the_middle());
  }
}

TEST_F(DoorEdits, AMeshReplacesTheLightOfItsPath) {
  EXPECT_GT(centre(render())[0], 0.1f);
  ASSERT_EQ(set(scene_, "/dome", "mesh"), ALABASTER_OK);
  EXPECT_EQ(centre(render())[0], 0);
}

// A host that starts, and then shows what is there from time to time.
TEST_F(DoorEdits, ARenderThatIsOnlyLookedAtBegins) {
  for (int number = 0; number < 3; ++number) {
    set_samples(1 + number);
    EXPECT_EQ(edit(scene_, "/quad", {{"material", path(number == 2 ? "/other" : "/wax")}}), ALABASTER_OK);
    ASSERT_EQ(start(), ALABASTER_OK);
    std::vector<float> pixels(4 * kSide * kSide);
    const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(30);
    do {
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
      ASSERT_EQ(api().buffer_read(color_, pixels.data(), pixels.size() * sizeof(float), 0), ALABASTER_OK);
    } while (centre(pixels)[3] == 0 && std::chrono::steady_clock::now() < end);
    EXPECT_EQ(centre(pixels)[3], 1);
    int32_t state = ALABASTER_IDLE;
    do ASSERT_EQ(api().pass_state(pass_, &state), ALABASTER_OK);
    while (state != ALABASTER_CONVERGED && std::chrono::steady_clock::now() < end);
    EXPECT_EQ(state, ALABASTER_CONVERGED);
  }
}

}  // namespace
}  // namespace alabaster::c_api_testing
