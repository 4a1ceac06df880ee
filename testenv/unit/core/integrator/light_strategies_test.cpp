// Whatever finds a light, the light is the same: lights that are sampled at each vertex and met by rays of lobes show
// what lights show that rays of lobes alone meet, at surfaces of every kind, before the camera and in a mirror.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <vector>

#include "testenv/support/furnace.h"

namespace alabaster {
namespace {

using testing::matt;
using testing::moved_by;
using testing::PathTracer;
using testing::RunningStatistics;
using testing::SceneBuilder;

enum class Found { by_lobes, mesh, rectangle };

struct Lamp {
  double height, x;  // of the middle of a square of side 2 that shines down
};

/// A mesh that moves is found by rays of lobes alone.
void add_lamp(SceneBuilder* b, const Lamp& lamp, Found found) {
  const Matrix4d place = moved_by(lamp.x, lamp.height, 0);
  if (found == Found::rectangle) {
    LightParameters light;
    light.width = light.height = 2;
    light.intensity = 1;
    light.light_to_world = Matrix4d().setAxisAngle(Vec3d(1, 0, 0), -M_PI / 2) * place;
    b->add(light);
    return;
  }
  DisneyParameters glowing = matt(Rgb(0.0f));
  glowing.emission = Rgb(1.0f);
  testing::add(b, b->prototype(testing::plane_mesh(2)), glowing, place);
  if (found == Found::by_lobes)
    b->description.instances.back().poses = {place, moved_by(lamp.x, lamp.height + 1e-4, 0)};
}

struct Receiver {
  const char* name;
  std::function<void(SceneBuilder*)> add;
  Lamp lamp;
};

DisneyParameters wax(float distance) {
  DisneyParameters p = matt(Rgb(0.8f));
  p.scatter_distance = Rgb(distance);
  return p;
}

std::vector<Receiver> receivers() {
  const auto plane = [](const DisneyParameters& p) {
    return [p](SceneBuilder* b) { testing::add(b, b->prototype(testing::plane_mesh(40)), p); };
  };
  const auto ball = [](const DisneyParameters& p, int rings) {
    return [p, rings](SceneBuilder* b) { testing::add(b, b->prototype(testing::sphere_mesh(0.5f, rings, true)), p); };
  };
  DisneyParameters gloss;
  gloss.base_color = Rgb(0.5f);
  gloss.roughness = 0.3f;
  DisneyParameters coated = wax(0.1f);
  coated.coat = 1;
  coated.coat_roughness = 0.3f;
  DisneyParameters cloudy = wax(0.1f);
  cloudy.spec_trans = 0.5f;
  cloudy.roughness = 0.5f;
  cloudy.ior = 1.3f;
  const Lamp near{1, 0}, oblique{2.5, 4};
  return {{"matt", plane(matt(Rgb(0.8f))), near}, {"matt, oblique", plane(matt(Rgb(0.8f))), oblique},
          {"gloss", plane(gloss), near},          {"gloss, oblique", plane(gloss), oblique},
          {"wax", plane(wax(0.1f)), near},        {"wax, oblique", plane(wax(0.1f)), oblique},
          {"coated wax", ball(coated, 24), near}, {"cloudy ball", ball(cloudy, 24), near}};
}

/// Where the direct view has its camera.
const Vec3d kEye(-1.5, 1, 2.5);

/// A mirror where the direct view has its camera. A camera at the point that is returned sees in it what that one sees.
Vec3d add_mirror(SceneBuilder* b) {
  const Vec3d beside(-3, 1.5, 5), normal = (-kEye.normalized() + (beside - kEye).normalized()).normalized();
  DisneyParameters mirror;
  mirror.base_color = Rgb(1.0f);
  mirror.metallic = 1;
  mirror.roughness = 0;
  const Vec3d up(0, 1, 0);
  const Matrix4d turn = Matrix4d().setAxisAngle(up.cross(normal), std::acos(up.dot(normal)));
  testing::add(b, b->prototype(testing::plane_mesh(0.1f)), mirror, turn * moved_by(kEye.x, kEye.y, kEye.z));
  return beside;
}

struct View {
  bool mirror, other_lights;
};

/// The light that comes from the middle of the receiver.
RunningStatistics seen(const Receiver& receiver, Found found, const View& view) {
  SceneBuilder b;
  receiver.add(&b);
  add_lamp(&b, receiver.lamp, found);
  // So many that one of all lights is chosen.
  for (int i = 0; i < (view.other_lights ? 8 : 0); ++i) {
    LightParameters other;
    other.intensity = 0.02f;
    other.light_to_world = moved_by(i, 3, 30);
    b.add(other);
  }
  const Vec3d eye = view.mirror ? add_mirror(&b) : kEye;
  PathTracer tracer(b.snapshot(), eye, view.mirror ? kEye : Vec3d(0, 0, 0));
  tracer.settings.max_depth = view.mirror ? 2 : 1;
  return testing::look(&tracer, 128, [](const FilmSample& s) { return double(s.color.g); });
}

TEST(LightStrategies, SampledLightsShowWhatRaysOfLobesMeet) {
  for (const Receiver& receiver : receivers())
    for (const View& view : {View{false, false}, View{true, true}}) {
      const RunningStatistics met = seen(receiver, Found::by_lobes, {false, view.other_lights});
      EXPECT_GT(met.mean(), 0.005) << receiver.name;
      for (const Found found : {Found::mesh, Found::rectangle}) {
        const auto result = z_test(seen(receiver, found, view), met, {.slack = 1e-3 * met.mean()});
        EXPECT_TRUE(plausible(result)) << receiver.name << (found == Found::mesh ? ", a mesh" : ", a rectangle")
                                       << (view.mirror ? ", in a mirror" : "");
      }
    }
}

}  // namespace
}  // namespace alabaster
