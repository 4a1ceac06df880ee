// Snapshots that share parts with the one before them.
#include "core/scene/snapshot_compiler.h"

#include <gtest/gtest.h>

#include "core/subsurface/body.h"
#include "testenv/support/medium_bodies.h"
#include "testenv/support/memory_texture.h"
#include "testenv/support/scene_builder.h"

namespace alabaster {
namespace {

using testing::SceneBuilder;

// Two unions, a lone body, an emissive sphere, a quad and a dome with an image; it holds all in a large box.
class Edited : public ::testing::Test {
 protected:
  Edited() {
    const auto sphere = b_.prototype(testing::sphere_mesh(1, 12, true));
    const auto wax = b_.material(this->wax(0.8f));
    b_.add(b_.prototype(testing::sphere_mesh(50, 4, false)), b_.material({}));
    b_.add(sphere, wax)
        .add(sphere, wax, testing::moved(0.5))
        .add(sphere, wax, testing::moved(9))
        .add(sphere, wax, testing::moved(9.25));
    b_.add(sphere, wax, testing::moved(5));
    for (size_t i = 1; i < 5; ++i) b_.description.instances[i].subsurface_set = i < 3 ? "a" : "b";
    DisneyParameters glow;
    glow.emission = Rgb(2.0f);
    b_.add(sphere, b_.material(glow), testing::moved(-5));
    LightParameters dome, quad;
    dome.type = LightType::dome;
    dome.texture = std::make_shared<testing::MemoryTexture>(
        8, std::vector<Rgb>{Rgb(0.1f), Rgb(0.1f), Rgb(0.1f), Rgb(9.0f), Rgb(0.1f), Rgb(0.1f), Rgb(0.1f), Rgb(0.1f)});
    quad.light_to_world[3][2] = 6;
    b_.add(dome).add(quad);
    compile();
  }
  static DisneyParameters wax(float green) {
    DisneyParameters p;
    p.base_color = {0.8f, green, 0.6f};
    p.scatter_distance = Rgb(0.05f);
    return p;
  }

  void compile() {
    before_ = now_;
    now_ = compiler_.compile(b_.description, ++number_);
    ASSERT_TRUE(now_);
  }
  // The picture must not depend on the snapshots before.
  void expect_as_fresh() {
    const auto fresh = b_.snapshot();
    RenderRequest request;
    request.camera = testing::look_at({2, 3, 14}, {2, 0, 0}, 60);
    request.width = request.height = 24;
    request.data_window = {0, 0, 24, 24};
    request.settings.samples = 4;
    request.settings.subsurface = SubsurfaceMode::walk;
    request.aovs = aov_bit(Aov::color);
    request.scene = now_;
    const auto film = testing::render(request);
    request.scene = fresh;
    const auto expected = testing::render(request);
    EXPECT_EQ(film->resolve_float(Aov::color), expected->resolve_float(Aov::color));
  }
  static std::shared_ptr<const LightImage> dome_image(const SceneSnapshot& s) {
    return image_of(s.lights.lights().front());
  }
  static bool same_unions(const SceneSnapshot& a, const SceneSnapshot& b) {
    return a.instances[1].body->scene == b.instances[1].body->scene &&
           a.instances[3].body->scene == b.instances[3].body->scene;
  }

  SceneBuilder b_;
  std::shared_ptr<TraceDevice> device_ = make_trace_device({});
  SnapshotCompiler compiler_{device_, {}};
  uint64_t number_ = 0;
  std::shared_ptr<const SceneSnapshot> before_, now_;
};

TEST_F(Edited, MovedLightKeepsTheTopLevelAndTheDomesImage) {
  b_.description.lights[1].light_to_world[3][0] = 3;
  compile();
  EXPECT_EQ(now_->top, before_->top);
  EXPECT_EQ(dome_image(*now_), dome_image(*before_));
  EXPECT_TRUE(same_unions(*now_, *before_));
  expect_as_fresh();
}

TEST_F(Edited, EditedConstantRecompilesTheMaterialAlone) {
  const auto other = b_.material(wax(0.3f));
  for (size_t i = 1; i < 6; ++i) b_.description.instances[i].materials = {other};
  const LitSurface* const lit = now_->instances[5].body->lit->get();
  ASSERT_TRUE(lit) << "a body between a glowing sphere and a quad is lit unevenly";
  compile();
  EXPECT_EQ(now_->top, before_->top);
  EXPECT_TRUE(same_unions(*now_, *before_));
  EXPECT_EQ(now_->instances[5].body->lit->get(), lit);
  EXPECT_EQ(now_->instances[5].material(0).constants.base_color.g, 0.3f);
  expect_as_fresh();
}

TEST_F(Edited, MovedObjectMovesItsBody) {
  b_.description.instances[2].object_to_world = testing::moved(0.7);
  compile();
  EXPECT_NE(now_->top, before_->top);
  EXPECT_NE(now_->instances[1].body->scene, before_->instances[1].body->scene);
  EXPECT_EQ(now_->instances[3].body->scene, before_->instances[3].body->scene);
  EXPECT_EQ(dome_image(*now_), dome_image(*before_));
  expect_as_fresh();
}

TEST_F(Edited, EditedLightsCompileAsAFreshScene) {
  b_.description.lights[0].color = Rgb(0.5f, 1, 1);  // another density
  compile();
  EXPECT_NE(dome_image(*now_), dome_image(*before_));
  expect_as_fresh();
  b_.description.instances[6].object_to_world = testing::moved(-6);  // the sphere that glows
  compile();
  expect_as_fresh();
  b_.description.instances.erase(b_.description.instances.begin() + 5);
  compile();
  expect_as_fresh();
  b_.description.lights.pop_back();
  compile();
  expect_as_fresh();
}

TEST_F(Edited, LightsOfOneImageShareItsDensityAtAnyBrightness) {
  LightParameters panel;
  panel.texture = b_.description.lights[0].texture;
  panel.light_to_world[3][2] = 6;
  b_.add(panel);
  panel.intensity = 3;
  panel.light_to_world[3][0] = 2;
  b_.add(panel);
  panel.color = Rgb(0.5f, 1, 1);
  panel.light_to_world[3][0] = 4;
  b_.add(panel);
  b_.description.lights[0].exposure = 1;
  compile();
  EXPECT_EQ(dome_image(*now_), dome_image(*before_)) << "a brighter dome";
  const auto& lights = now_->lights.lights();
  EXPECT_EQ(image_of(lights[3]), image_of(lights[2])) << "panels of one snapshot";
  EXPECT_NE(image_of(lights[4]), image_of(lights[2])) << "another tint has another density";
  EXPECT_NE(image_of(lights[2]), image_of(lights[0])) << "a panel is no dome";
  expect_as_fresh();
}

// The copy of a textured emissive mesh must not point into the snapshot that it was made for.
TEST_F(Edited, AGlowingMeshOutlivesTheSnapshotThatItWasMadeFor) {
  auto textured = std::make_shared<DisneyMaterial>();
  textured->constants.emission = Rgb(3.0f);
  textured->constants.opacity = 0.5f;
  b_.description.instances[6].materials = {textured};
  compile();
  for (int i = 0; i < 3; ++i) {
    b_.description.lights[1].light_to_world[3][0] = i;
    compile();
  }
  before_ = nullptr;
  expect_as_fresh();
}

}  // namespace
}  // namespace alabaster
