// Edits of what moves, prims that change their kind, and renders that are only looked at.
#include <chrono>
#include <functional>
#include <thread>

#include "testenv/unit/delegate/c_api/door_fixture.h"

namespace alabaster::door_testing {
namespace {

std::array<double, 16> at(double x, double z = 0) {
  return {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, x, 0, z, 1};
}

class DoorEdits : public Door {
 protected:
  bool is_in_the_middle() { return centre(render())[3] > 0.5f; }
  /// A mesh, an instancer or a camera that stays at `matrix` by two samples.
  template <class T>
  void hold(T* prim, const double* matrix) {
    samples_[0] = samples_[1] = {ALABASTER_MATRIX, 0, matrix, 1, nullptr, nullptr};
    prim->motion = {times_, samples_, 2};
    prim->transform = matrix;
  }
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

  const double times_[2] = {0, 1};
  AlabasterValue samples_[2] = {};
};

TEST_F(DoorEdits, ATransformMovesAMeshThatMoves) {
  const int32_t counts[] = {4}, indices[] = {0, 1, 2, 3};
  const float corners[] = {-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0};
  const AlabasterPrimvar points = {"points", nullptr, ALABASTER_VERTEX, array(ALABASTER_FLOAT3, corners, 4), {}, {}};
  AlabasterMesh mesh = {};
  mesh.size = sizeof mesh;
  mesh.face_vertex_counts = array(ALABASTER_INT, counts, 1);
  mesh.face_vertex_indices = array(ALABASTER_INT, indices, 4);
  mesh.primvars = &points, mesh.primvar_count = 1;
  const auto aside = at(50), here = at(0);
  hold(&mesh, aside.data());
  ASSERT_EQ(api().set_mesh(scene_, "/quad", &mesh), ALABASTER_OK) << api().last_error();
  EXPECT_FALSE(is_in_the_middle());
  ASSERT_EQ(api().set_transform(scene_, "/quad", here.data()), ALABASTER_OK);
  EXPECT_TRUE(is_in_the_middle());
}

TEST_F(DoorEdits, ATransformMovesACameraThatMoves) {
  const float focal = 0.05f, aperture = 0.036f;
  const AlabasterParameter lens[] = {
      {"focalLength", number(focal)}, {"horizontalAperture", number(aperture)}, {"verticalAperture", number(aperture)}};
  const auto aside = at(50, 6), here = at(0, 6);
  AlabasterCamera camera = {sizeof camera, nullptr, lens, 3, {}};
  hold(&camera, aside.data());
  ASSERT_EQ(api().set_camera(scene_, "/camera", &camera), ALABASTER_OK);
  EXPECT_FALSE(is_in_the_middle());
  ASSERT_EQ(api().set_transform(scene_, "/camera", here.data()), ALABASTER_OK);
  EXPECT_TRUE(is_in_the_middle());
}

TEST_F(DoorEdits, ATransformAndValuesMoveInstancesThatMove) {
  const float places[] = {0, 0, 0, 70, 0, 0}, far[] = {90, 0, 0}, middle[] = {0, 0, 0};
  const int32_t indices[] = {0, 1};
  const AlabasterPrototype quads = {"/quad", array(ALABASTER_INT, indices, 2)};
  const AlabasterValue all = array(ALABASTER_FLOAT3, places, 2), moving[] = {all, all};
  const AlabasterPrimvar primvar = {"hydra:instanceTranslations", nullptr, ALABASTER_INSTANCE, all, {},
                                    {times_, moving, 2}};
  AlabasterInstancer many = {};
  many.size = sizeof many;
  many.primvars = &primvar, many.primvar_count = 1;
  many.prototypes = &quads, many.prototype_count = 1;
  const auto aside = at(50), here = at(0);
  hold(&many, aside.data());
  ASSERT_EQ(api().set_instancer(scene_, "/many", &many), ALABASTER_OK) << api().last_error();
  ASSERT_EQ(set_quad({}, "/many"), ALABASTER_OK);
  EXPECT_FALSE(is_in_the_middle());
  ASSERT_EQ(api().set_transform(scene_, "/many", here.data()), ALABASTER_OK);
  EXPECT_TRUE(is_in_the_middle());

  AlabasterPrimvar one = {"hydra:instanceTranslations", nullptr, ALABASTER_INSTANCE, {}, {}, {}};
  one.value = array(ALABASTER_FLOAT3, far, 1);
  ASSERT_EQ(api().set_instance_values(scene_, "/many", &one, 0), ALABASTER_OK) << api().last_error();
  EXPECT_FALSE(is_in_the_middle());
  one.value = array(ALABASTER_FLOAT3, middle, 1);
  ASSERT_EQ(api().set_instance_values(scene_, "/many", &one, 1), ALABASTER_OK) << api().last_error();
  EXPECT_TRUE(is_in_the_middle());
  one.motion = {times_, moving, 2};
  EXPECT_EQ(api().set_instance_values(scene_, "/many", &one, 1), ALABASTER_INVALID_ARGUMENT) << "would be lost";
}

TEST_F(DoorEdits, APrimOfAnotherKindReplacesAMesh) {
  const auto behind = at(0, 99);
  const AlabasterLight lamp = {sizeof lamp, "sphereLight", behind.data(), nullptr, 0, 1};
  AlabasterMaterial wax = {};
  wax.size = sizeof wax;
  AlabasterCamera camera = {};
  camera.size = sizeof camera;
  AlabasterRenderSettings settings = {};
  settings.size = sizeof settings;
  AlabasterInstancer many = {};
  many.size = sizeof many;
  const std::pair<const char*, std::function<AlabasterStatus()>> kinds[] = {
      {"sphereLight", [&] { return api().set_light(scene_, "/quad", &lamp); }},
      {"material", [&] { return api().set_material(scene_, "/quad", &wax); }},
      {"camera", [&] { return api().set_camera(scene_, "/quad", &camera); }},
      {"renderSettings", [&] { return api().set_render_settings(scene_, "/quad", &settings); }},
      {"instancer", [&] { return api().set_instancer(scene_, "/quad", &many); }},
  };
  for (const auto& [kind, set] : kinds) {
    ASSERT_EQ(set_quad({}), ALABASTER_OK);
    EXPECT_EQ(kind_of("/quad"), "mesh");
    EXPECT_TRUE(is_in_the_middle()) << kind;
    ASSERT_EQ(set(), ALABASTER_OK) << kind;
    EXPECT_EQ(kind_of("/quad"), kind);
    EXPECT_FALSE(is_in_the_middle()) << kind;
  }
}

TEST_F(DoorEdits, AMeshReplacesTheLightOfItsPath) {
  EXPECT_GT(centre(render())[0], 0.1f);
  AlabasterMesh mesh = {};
  mesh.size = sizeof mesh;
  ASSERT_EQ(api().set_mesh(scene_, "/dome", &mesh), ALABASTER_OK);
  EXPECT_EQ(centre(render())[0], 0);
}

// A host that starts, and then shows what is there from time to time.
TEST_F(DoorEdits, ARenderThatIsOnlyLookedAtBegins) {
  for (int edit = 0; edit < 3; ++edit) {
    set_samples(1 + edit);
    EXPECT_EQ(api().bind_material(scene_, "/quad", edit == 2 ? "/other" : "/wax"), ALABASTER_OK);
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
}  // namespace alabaster::door_testing
