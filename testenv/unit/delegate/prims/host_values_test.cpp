// Values as hosts have them: memory that is edited in place, numbers of any type, primvars of any interpolation.
#include <gtest/gtest.h>

#include <functional>
#include <limits>

#include "testenv/support/stage.h"

namespace alabaster::hd {
namespace {

using Change = std::function<void(host::MeshDescription&)>;

// A picture of the basic scene's camera, 8 x 8 pixels of half a unit, top row first.
class HostValues : public ::testing::Test {
 protected:
  static constexpr int kWidth = 8, kHeight = 8;

  HostValues() {
    stage.add_basic_scene();
    stage.scene.Remove("/quad");
    pass = stage.delegate->CreateRenderPass();
  }
  ~HostValues() override { pass.reset(); }

  // Faces 0 at x < 0 and 1 at x > 0, which fill the picture.
  static host::MeshDescription two_faces() {
    host::MeshDescription mesh;
    mesh.topology.faceVertexCounts = {4, 4};
    mesh.topology.faceVertexIndices = {0, 1, 4, 3, 1, 2, 5, 4};
    mesh.primvars["points"].value = Array<Vec3f>{{-2, -2, 0}, {0, -2, 0}, {2, -2, 0}, {-2, 2, 0}, {0, 2, 0}, {2, 2, 0}};
    return mesh;
  }

  std::vector<float> picture(const char* aov, int components) {
    const Format formats[] = {Format::float32, Format::float32vec2, Format::float32vec3, Format::float32vec4};
    const Path path = Path(std::string("/buffer_") + std::to_string(components));
    RenderBuffer* buffer = static_cast<RenderBuffer*>(stage.index->GetBprim(path));
    if (!buffer) buffer = stage.add_buffer(path.str().c_str(), kWidth, kHeight, formats[components - 1]);
    stage.index->SyncAll();
    EXPECT_TRUE(Stage::finish(*pass, Stage::state_for(kWidth, kHeight, aov, buffer)));
    return Stage::pixels<float>(buffer);
  }
  // The value at the middle of the left or the right face.
  static std::vector<float> at(const std::vector<float>& picture, bool right, size_t components) {
    const size_t pixel = 4 * kWidth + (right ? 6 : 2);
    return {picture.begin() + std::ptrdiff_t(pixel * components),
            picture.begin() + std::ptrdiff_t((pixel + 1) * components)};
  }

  Stage stage{{{"samples", int64_t(1)}, {"filter", std::string("box")}}};
  std::unique_ptr<RenderPass> pass;
};

// promise: embedding.arrays.cpp
TEST_F(HostValues, ArraysEditedInPlaceAreSeenByTheirVersion) {
  auto points =
      std::make_shared<std::vector<Vec3f>>(std::vector<Vec3f>{{-2, -2, 0}, {2, -2, 0}, {2, 2, 0}, {-2, 2, 0}});
  const auto with_version = [&](uint64_t version) {
    host::MeshDescription mesh = Stage::quad();
    mesh.primvars["points"].value = Array<Vec3f>(points, points->data(), points->size(), version);
    return mesh;
  };
  stage.scene.SetMesh("/m", with_version(1));
  const auto covered = picture("elementId", 1);
  EXPECT_EQ(at(covered, true, 1)[0], 0);
  for (Vec3f& p : *points) p.x += 100;
  stage.scene.SetMesh("/m", with_version(1));
  EXPECT_EQ(picture("elementId", 1), covered) << "nothing says that it was edited";
  stage.scene.SetMesh("/m", with_version(2));
  EXPECT_EQ(picture("elementId", 1), std::vector<float>(kWidth * kHeight, -1.0f));
  for (Vec3f& p : *points) p.x -= 100;
  stage.scene.SetMesh("/m", with_version(3));
  EXPECT_EQ(picture("elementId", 1), covered);
}

// A host that is asked (instead of the retained scene) need only mark what it edited.
TEST_F(HostValues, ADirtyPrimReadsEditedMemoryAgain) {
  auto points =
      std::make_shared<std::vector<Vec3f>>(std::vector<Vec3f>{{-2, -2, 0}, {2, -2, 0}, {2, 2, 0}, {-2, 2, 0}});
  host::MeshDescription mesh = Stage::quad();
  mesh.primvars["points"].value = Array<Vec3f>(points, points->data(), points->size(), 1);
  stage.scene.SetMesh("/m", mesh);
  EXPECT_EQ(at(picture("elementId", 1), true, 1)[0], 0);
  for (Vec3f& p : *points) p.x += 100;
  stage.index->GetChangeTracker().MarkDirty("/m", dirty::kPoints);
  EXPECT_EQ(at(picture("elementId", 1), true, 1)[0], -1);
}

TEST_F(HostValues, EditedMemoryIsReadInSyncAlone) {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  auto points =
      std::make_shared<std::vector<Vec3f>>(std::vector<Vec3f>{{-2, -2, 0}, {2, -2, 0}, {2, 2, 0}, {-2, 2, 0}});
  auto corners = std::make_shared<std::vector<int32_t>>(std::vector<int32_t>{0, 1, 2, 3});
  auto colors = std::make_shared<std::vector<Vec3d>>(4, Vec3d(1, 0, 0));
  std::vector<std::weak_ptr<const void>> owners = {points, corners, colors};
  host::MeshDescription mesh = Stage::quad();
  mesh.topology.faceVertexIndices = Array<int32_t>(corners, corners->data(), corners->size(), 1);
  mesh.primvars["points"].value = Array<Vec3f>(points, points->data(), points->size(), 1);
  mesh.primvars["displayColor"].value = Array<Vec3d>(colors, colors->data(), colors->size(), 1);
  stage.scene.SetMesh("/m", mesh);
  stage.delegate->Stop();  // nothing is built
  stage.index->SyncAll();
  std::fill(points->begin(), points->end(), Vec3f(kNan));
  std::fill(corners->begin(), corners->end(), -1);
  std::fill(colors->begin(), colors->end(), Vec3d(0));
  points.reset(), corners.reset(), colors.reset();
  mesh = {};
  stage.scene.Depopulate();  // the scene held them; the prims go, too
  for (const auto& owner : owners) EXPECT_FALSE(owner.expired()) << "the description is still there";
  stage.scene.Populate(stage.index.get());
  stage.delegate->Restart();
  EXPECT_EQ(stage.count("delegate.exception"), 0u);
  stage.scene.Remove("/m");
  for (const auto& owner : owners) EXPECT_TRUE(owner.expired()) << "given back with the description";
}

// promise: embedding.arrays.cpp
TEST_F(HostValues, TheBuilderReadsCopiesOfEditedMemory) {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  auto points =
      std::make_shared<std::vector<Vec3f>>(std::vector<Vec3f>{{-2, -2, 0}, {2, -2, 0}, {2, 2, 0}, {-2, 2, 0}});
  host::MeshDescription mesh = Stage::quad();
  mesh.primvars["points"].value = Array<Vec3f>(points, points->data(), points->size(), 1);
  stage.scene.SetMesh("/m", mesh);
  const auto expected = picture("elementId", 1);
  mesh.primvars["points"].value = Array<Vec3f>(points, points->data(), points->size(), 2);
  stage.scene.SetMesh("/m", mesh);
  stage.delegate->Stop();  // what is synced now is built after Restart
  stage.index->SyncAll();
  std::fill(points->begin(), points->end(), Vec3f(kNan));
  stage.delegate->Restart();
  EXPECT_EQ(picture("elementId", 1), expected);
  mesh.displayStyle.refineLevel = 1, mesh.topology.scheme = "bilinear";
  stage.scene.SetMesh("/m", mesh);
  EXPECT_EQ(picture("elementId", 1), expected) << "another build of the same points";
}

template <class To, class From>
Array<To> as(const Array<From>& from) {
  std::vector<To> to;
  for (const From& value : from) to.push_back(To(value));
  return to;
}

TEST_F(HostValues, NumbersOfAnyTypeAreTheirFloats) {
  const Array<Vec3f> points = {{-2, -2, 0}, {2, -2, 0}, {2, 2, 0}, {-2, 2, 0}};
  const Array<Vec3f> colors = {{0, 1, 0.5f}, {1, 0.25f, 0}, {0.5f, 0, 1}, {1, 1, 1}};
  const Array<Vec2f> st = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  const auto show = [&](const Value& p, const Value& c, const Value& t, const Value& opacity) {
    host::MeshDescription mesh = Stage::quad();
    mesh.primvars["points"].value = p;
    mesh.primvars["displayColor"] = {Interpolation::vertex, "color", c, {}};
    mesh.primvars["st"] = {Interpolation::vertex, "textureCoordinate", t, {}};
    mesh.primvars["displayOpacity"] = {Interpolation::constant, {}, opacity, {}};
    stage.scene.SetMesh("/m", mesh);
    std::vector<float> all = picture("color", 4);
    for (const char* aov : {"primvars:displayColor", "primvars:st", "primvars:displayOpacity"}) {
      const auto more = picture(aov, 3);
      all.insert(all.end(), more.begin(), more.end());
    }
    return all;
  };
  const auto expected = show(points, colors, st, Array<float>{1});
  EXPECT_EQ(at(expected, true, 4)[3], 1);
  EXPECT_EQ(show(as<Vec3d>(points), as<Vec3d>(colors), as<Vec2d>(st), Array<double>{1}), expected);
  EXPECT_EQ(show(as<Vec3h>(points), as<Vec3h>(colors), as<Vec2h>(st), Array<Half>{Half(1.0f)}), expected);
  EXPECT_EQ(show(as<Vec3i>(points), colors, as<Vec2i>(st), Array<int32_t>{1}), expected);
  EXPECT_EQ(show(points, colors, st, Array<bool>{true}), expected);
  EXPECT_EQ(show(points, colors, st, Array<int64_t>{1}), expected);
  EXPECT_EQ(show(points, colors, st, Array<uint32_t>{1}), expected);
  EXPECT_EQ(show(points, colors, st, 1.0f), expected) << "one number for the mesh needs no array";
  EXPECT_EQ(show(points, colors, st, true), expected);
  EXPECT_EQ(stage.count("mesh.primvar.type"), 0u);
  EXPECT_NE(show(points, colors, st, Array<Half>{Half(0.5f)}), expected);
}

TEST_F(HostValues, InstancersTakeHalvesAndDoubles) {
  const auto show = [&](const Value& translations, const Value& rotations) {
    host::MeshDescription mesh = Stage::quad();
    mesh.instancer = "/i";
    host::InstancerDescription instancer;
    instancer.primvars["hydra:instanceTranslations"] = translations;
    instancer.primvars["hydra:instanceRotations"] = rotations;
    instancer.indices["/m"] = {0};
    stage.scene.SetInstancer("/i", instancer);
    stage.scene.SetMesh("/m", mesh);
    return picture("elementId", 1);
  };
  const Quatf turned(0, 0, 0, 1);
  const auto expected = show(Array<Vec3f>{{1, 0, 0}}, Array<Quatf>{turned});
  EXPECT_EQ(at(expected, true, 1)[0], 0);
  EXPECT_EQ(at(expected, false, 1)[0], -1);
  const Quath half_turned(Half(0.0f), Imath::Vec3<Half>(Half(0.0f), Half(0.0f), Half(1.0f)));
  EXPECT_EQ(show(Array<Vec3d>{{1, 0, 0}}, Array<Quath>{half_turned}), expected);
  EXPECT_EQ(show(Array<Vec3h>{Vec3h(Vec3f(1, 0, 0))}, Array<Vec4d>{{0, 0, 0, 1}}), expected);
  EXPECT_EQ(stage.count("instancer.primvar.type"), 0u);
}

TEST_F(HostValues, BooleansHalvesAndDoublesAreParameters) {
  const auto network = [](const Value& thin, const Value& roughness, const Value& color) {
    MaterialNetwork network;
    network.nodes["n"] = {"AlabasterDisney", {{"thin", thin}, {"roughness", roughness}, {"baseColor", color}}, {}};
    network.terminals["surface"] = {"n", "out"};
    return network;
  };
  host::MeshDescription mesh = Stage::quad();
  mesh.material = "/material";
  stage.scene.SetMesh("/m", mesh);
  stage.scene.SetMaterial("/material", network(true, 0.25f, Vec3f(1, 0.5f, 0)));
  const std::string expected = stage.dump();
  stage.scene.SetMaterial("/material", network(int32_t(1), Half(0.25f), Vec3h(Vec3f(1, 0.5f, 0))));
  EXPECT_EQ(stage.dump(), expected);
  stage.scene.SetMaterial("/material", network(1.0, 0.25, Vec4d(1, 0.5, 0, 1)));
  EXPECT_EQ(stage.dump(), expected);
  EXPECT_EQ(stage.count("parameter.type"), 0u);
}

// The value of displayColor at the middle of each face, by interpolation.
TEST_F(HostValues, PrimvarsOfAllInterpolations) {
  const Vec3f red(1, 0, 0), green(0, 1, 0), blue(0, 0, 1);
  const Array<Vec3f> at_points = {red, red, green, red, red, green};
  std::vector<Vec3f> at_corners(4, red);
  at_corners.insert(at_corners.end(), 4, blue);
  struct Case {
    Interpolation interpolation;
    Array<Vec3f> values;
    Array<int32_t> indices;
    Vec3f left, right;
  };
  const Vec3f half = (red + green) / 2;
  const std::vector<Case> cases = {
      {Interpolation::constant, {green}, {}, green, green},
      {Interpolation::constant, {red, green}, {1}, green, green},
      {Interpolation::uniform, {red, green}, {}, red, green},
      {Interpolation::uniform, {blue, red, green}, {2, 0}, green, blue},
      {Interpolation::varying, at_points, {}, red, half},
      {Interpolation::varying, {red, green}, {0, 0, 1, 0, 0, 1}, red, half},
      {Interpolation::vertex, at_points, {}, red, half},
      {Interpolation::vertex, {red, green}, {0, 0, 1, 0, 0, 1}, red, half},
      {Interpolation::faceVarying, at_corners, {}, red, blue},
      {Interpolation::faceVarying, {red, blue}, {0, 0, 0, 0, 1, 1, 1, 1}, red, blue},
  };
  for (const int level : {0, 1, 3})
    for (const char* scheme : {"catmullClark", "bilinear"})
      for (const Case& c : cases) {
        const auto where = testing::Message() << scheme << " " << level << " interpolation " << int(c.interpolation)
                                              << " indexed " << !c.indices.empty();
        host::MeshDescription mesh = two_faces();
        mesh.topology.scheme = scheme;
        mesh.displayStyle.refineLevel = level;
        mesh.primvars["displayColor"] = {c.interpolation, "color", c.values, c.indices};
        stage.scene.SetMesh("/m", mesh);
        const auto shown = picture("primvars:displayColor", 3);
        for (const bool right : {false, true}) {
          const auto value = at(shown, right, 3);
          const Vec3f expected = right ? c.right : c.left;
          // Half a pixel off the middle; the vertex rule bends what is linear in the cage.
          const bool is_flat = c.interpolation != Interpolation::varying && c.interpolation != Interpolation::vertex;
          const float allowed = is_flat ? 1e-5f : 0.3f;
          for (size_t i = 0; i < 3; ++i) EXPECT_NEAR(value[i], expected[int(i)], allowed) << where << " " << right;
        }
      }
  EXPECT_EQ(stage.take_diagnostics().size(), 0u);
}

// Against the x of what each pixel shows: 0 on the left face, x / 2 on the right one.
TEST_F(HostValues, VaryingIsLinearOnARefinedSurface) {
  const auto largest_difference = [&](Interpolation interpolation) {
    host::MeshDescription mesh = two_faces();
    mesh.topology.scheme = "catmullClark";
    mesh.displayStyle.refineLevel = 4;
    mesh.primvars["heat"] = {interpolation, {}, Array<float>{0, 0, 1, 0, 0, 1}, {}};
    stage.scene.SetMesh("/m", mesh);
    const auto heat = picture("primvars:heat", 3), place = picture("Peye", 3);
    float largest = 0;
    for (size_t i = 0; i < heat.size(); i += 3)
      largest = std::max(largest, std::abs(heat[i] - std::max(0.0f, place[i] / 2)));
    return largest;
  };
  EXPECT_LT(largest_difference(Interpolation::varying), 1e-5f);
  EXPECT_GT(largest_difference(Interpolation::vertex), 0.02f)
      << "the surface's rule smooths the edge between the faces";
}

TEST_F(HostValues, UniformAndConstantNormalsTangentsAndUvs) {
  for (const Interpolation interpolation : {Interpolation::constant, Interpolation::uniform}) {
    host::MeshDescription mesh = two_faces();
    const bool uniform = interpolation == Interpolation::uniform;
    const Vec3f tilted = Vec3f(0.6f, 0, 0.8f);
    mesh.primvars["normals"] = {
        interpolation, "normal", uniform ? Array<Vec3f>{{0, 0, 1}, tilted} : Array<Vec3f>{tilted}, {}};
    mesh.primvars["st"] = {interpolation,
                           "textureCoordinate",
                           uniform ? Array<Vec2f>{{0.25f, 0}, {0.75f, 1}} : Array<Vec2f>{{0.75f, 1}},
                           {}};
    mesh.primvars["tangents"] = {
        interpolation,
        {},
        uniform ? Array<Vec4f>(std::vector<Vec4f>(2, {1, 0, 0, 1})) : Array<Vec4f>{{1, 0, 0, 1}},
        {}};
    stage.scene.SetMesh("/m", mesh);
    const auto normals = picture("normal", 3), st = picture("primvars:st", 3);
    EXPECT_NEAR(at(normals, true, 3)[0], 0.6f, 1e-3f) << uniform;
    EXPECT_NEAR(at(normals, false, 3)[0], uniform ? 0 : 0.6f, 1e-3f) << uniform;
    EXPECT_EQ(at(st, true, 3), (std::vector<float>{0.75f, 1, 0})) << uniform;
    EXPECT_EQ(at(st, false, 3)[0], uniform ? 0.25f : 0.75f) << uniform;
    EXPECT_EQ(picture("primvars:tangents", 3)[0], 1) << uniform;
  }
  EXPECT_EQ(stage.take_diagnostics().size(), 0u);
}

TEST_F(HostValues, WrongSizesAreReportedAndLeftOut) {
  host::MeshDescription mesh = two_faces();
  const auto plain = [&] {
    stage.scene.SetMesh("/m", two_faces());
    return picture("color", 4);
  }();
  const std::pair<Interpolation, size_t> wrong[] = {{Interpolation::constant, 2},
                                                    {Interpolation::uniform, 3},
                                                    {Interpolation::varying, 5},
                                                    {Interpolation::vertex, 7},
                                                    {Interpolation::faceVarying, 6}};
  for (const auto& [interpolation, count] : wrong) {
    mesh.primvars["displayColor"] = {interpolation, "color", Array<Vec3f>(std::vector<Vec3f>(count, {1, 0, 0})), {}};
    stage.scene.SetMesh("/m", mesh);
    EXPECT_EQ(picture("color", 4), plain) << int(interpolation);
    EXPECT_EQ(stage.count("mesh.primvar.size"), 1u) << int(interpolation);
    stage.take_diagnostics();
  }
  mesh.primvars["displayColor"] = {Interpolation::instance, "color", Array<Vec3f>{{1, 0, 0}}, {}};
  stage.scene.SetMesh("/m", mesh);
  EXPECT_EQ(picture("color", 4), plain);
  EXPECT_EQ(stage.count("mesh.primvar.interpolation"), 1u);
}

TEST_F(HostValues, DisplayColorAndOpacityAreTheLookOfAMeshWithoutMaterial) {
  const auto shown = [&](const Change& change) {
    host::MeshDescription mesh = two_faces();
    if (change) change(mesh);
    stage.scene.SetMesh("/m", mesh);
    return at(picture("color", 4), true, 4);
  };
  const auto grey = shown({});
  EXPECT_EQ(grey[0], grey[2]);
  const auto blue = shown([](auto& m) {
    m.primvars["displayColor"] = {Interpolation::constant, "color", Vec3f(0, 0, 1), {}};
  });
  EXPECT_LT(blue[0], 0.5f * blue[2]);
  EXPECT_EQ(blue[3], 1);
  const auto clear = shown([](auto& m) { m.primvars["displayOpacity"] = {Interpolation::constant, {}, 0.0f, {}}; });
  EXPECT_EQ(clear[3], 0) << "nothing is there";
  const auto bound = shown([](auto& m) {
    m.primvars["displayColor"] = {Interpolation::constant, "color", Vec3f(0, 0, 1), {}};
    m.material = "/grey";
  });
  EXPECT_EQ(bound, blue) << "a material that does not exist";
  MaterialNetwork network;
  network.nodes["n"] = {"AlabasterDisney", {}, {}};
  network.terminals["surface"] = {"n", "out"};
  stage.scene.SetMaterial("/grey", network);
  EXPECT_EQ(at(picture("color", 4), true, 4), grey) << "a material that asks for no primvar";
}

TEST_F(HostValues, InvisibleFacesLeaveTheirNeighboursAsTheyAre) {
  for (const int level : {0, 3}) {
    host::MeshDescription mesh = two_faces();
    mesh.topology.scheme = "catmullClark";
    mesh.displayStyle.refineLevel = level;
    Array<Vec3f> points = {{-2, -2, 0}, {0, -2, 1}, {2, -2, 0}, {-2, 2, 0}, {0, 2, 1}, {2, 2, 0}};
    mesh.primvars["points"].value = points;
    stage.scene.SetMesh("/m", mesh);
    const auto whole = picture("Peye", 3);
    mesh.topology.invisibleFaces = {0};
    stage.scene.SetMesh("/m", mesh);
    const auto half = picture("Peye", 3), elements = picture("elementId", 1);
    EXPECT_EQ(at(elements, false, 1)[0], -1) << level;
    EXPECT_EQ(at(elements, true, 1)[0], 1) << "the cage's number, level " << level;
    EXPECT_EQ(at(half, true, 3), at(whole, true, 3)) << level;
    mesh.topology.invisibleFaces = {};
    mesh.topology.holeIndices = {0};
    stage.scene.SetMesh("/m", mesh);
    EXPECT_EQ(at(picture("elementId", 1), false, 1)[0], -1) << level;
    mesh.topology.holeIndices = {};
    mesh.topology.invisibleFaces = {7, -1};
    stage.scene.SetMesh("/m", mesh);
    EXPECT_EQ(picture("Peye", 3), whole) << level;
    EXPECT_EQ(stage.count("mesh.invisible.index"), 1u);
    stage.take_diagnostics();
  }
  host::MeshDescription mesh = two_faces();
  mesh.topology.invisiblePoints = {0, 1, 2, 3};
  stage.scene.SetMesh("/m", mesh);
  EXPECT_EQ(at(picture("elementId", 1), true, 1)[0], 1) << "points of meshes are not drawn";
}

TEST_F(HostValues, CullStylesHideSidesFromTheCamera) {
  struct Case {
    CullStyle style;
    bool double_sided, front, back;  // is seen from there
  };
  const std::vector<Case> cases = {
      {CullStyle::dontCare, true, true, true},
      {CullStyle::dontCare, false, true, false},
      {CullStyle::nothing, false, true, true},
      {CullStyle::back, true, true, false},
      {CullStyle::back, false, true, false},
      {CullStyle::front, true, false, true},
      {CullStyle::front, false, false, true},
      {CullStyle::backUnlessDoubleSided, true, true, true},
      {CullStyle::backUnlessDoubleSided, false, true, false},
      {CullStyle::frontUnlessDoubleSided, true, true, true},
      {CullStyle::frontUnlessDoubleSided, false, false, true},
  };
  for (const Case& c : cases)
    for (const bool front : {true, false}) {
      host::MeshDescription mesh = two_faces();
      mesh.cullStyle = c.style;
      mesh.doubleSided = c.double_sided;
      if (!front) mesh.topology.orientation = "leftHanded";
      stage.scene.SetMesh("/m", mesh);
      EXPECT_EQ(at(picture("elementId", 1), true, 1)[0], (front ? c.front : c.back) ? 1 : -1)
          << int(c.style) << c.double_sided << front;
    }
}

// The parts of a mesh, seen from behind.
TEST_F(HostValues, SidesOfAMaterialComeBeforeTheMeshs) {
  const auto set_material = [&](const char* path, const char* sides) {
    MaterialNetwork network;
    MaterialNode& node = network.nodes[Path(path).append("surface")];
    node.nodeTypeId = "AlabasterDisney";
    if (*sides) node.parameters["sides"] = Token(sides);
    network.terminals["surface"] = {Path(path).append("surface"), "out"};
    stage.scene.SetMaterial(path, network);
  };
  host::MeshDescription mesh = two_faces();
  mesh.topology.orientation = "leftHanded";
  mesh.material = "/left";
  mesh.topology.geomSubsets = {{"/m/part", "/right", {1}}};
  const auto is_there = [](bool mesh_says, const std::string& sides) {
    return sides == "both" || (sides != "front" && mesh_says);
  };
  for (const bool double_sided : {true, false})
    for (const char* left : {"", "mesh", "front", "both"})
      for (const char* right : {"front", "both", "mesh"}) {
        mesh.doubleSided = double_sided;
        set_material("/left", left), set_material("/right", right);
        stage.scene.SetMesh("/m", mesh);
        const std::vector<float> faces = picture("elementId", 1);
        EXPECT_EQ(at(faces, false, 1)[0], is_there(double_sided, left) ? 0 : -1) << double_sided << left << right;
        EXPECT_EQ(at(faces, true, 1)[0], is_there(double_sided, right) ? 1 : -1) << double_sided << left << right;
      }
  EXPECT_EQ(stage.take_diagnostics().size(), 0u);
}

// Light does not fall through a wall that the camera looks through.
TEST_F(HostValues, CulledFrontsStillShade) {
  const auto floor = [&](CullStyle style) {
    host::MeshDescription wall = two_faces();
    wall.transform[3][2] = 1;
    wall.cullStyle = style;
    stage.scene.SetMesh("/m", two_faces());
    stage.scene.SetMesh("/wall", wall);
    return at(picture("color", 4), true, 4)[0];
  };
  const float shaded = floor(CullStyle::front);
  stage.scene.SetMesh("/wall", [] {
    host::MeshDescription away = two_faces();
    away.visible = false;
    return away;
  }());
  EXPECT_LT(shaded, 0.9f * at(picture("color", 4), true, 4)[0]);
}

}  // namespace
}  // namespace alabaster::hd
