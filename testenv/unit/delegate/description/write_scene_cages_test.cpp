// Cages of subdivision surfaces and textures, written and read again.
#include "testenv/support/build_paths.h"
#include "testenv/support/cages.h"
#include "testenv/unit/delegate/description/write_scene_fixture.h"

namespace alabaster::hd::description {
namespace {

using nlohmann::json;

host::MeshDescription described(const alabaster::Cage& cage, const char* scheme) {
  host::MeshDescription mesh;
  mesh.topology.scheme = scheme;
  mesh.topology.faceVertexCounts = cage.face_vertex_counts;
  mesh.topology.faceVertexIndices = cage.face_vertex_indices;
  std::vector<Vec3f> points;
  for (const auto& p : cage.points) points.emplace_back(p.x, p.y, p.z);
  mesh.primvars["points"].value = Array<Vec3f>(std::move(points));
  mesh.transform = Matrix4d(0.6, 0.2, 0.1, 0, -0.2, 0.6, 0, 0, 0, 0.1, 0.6, 0, 0, 0, 0, 1);
  mesh.displayStyle.refineLevel = 3;
  return mesh;
}

class WrittenCage : public WriteSceneTest {
 protected:
  WrittenCage() {
    stage_.add_basic_scene();
    stage_.scene.SetLight("/sun", {.type = "distantLight", .transform = {}, .parameters = {{"intensity", 0.5f}}});
  }
  host::RetainedSceneDelegate& scene() { return stage_.scene; }

  std::string copy_image(const std::string& name) const {
    std::filesystem::copy_file(testing::source_file("testenv/scenes/lights/screen.png"), folder_ / name);
    return file(name);
  }
  void set_textured(const char* input, const AssetPath& image, std::map<Token, Value> texture = {}) {
    MaterialNetwork network;
    texture.emplace("file", image);
    network.nodes["/t"] = {"AlabasterTexture", std::move(texture), {}};
    network.nodes["/s"] = {"AlabasterDisney", {{"roughness", 0.4f}}, {{input, {{"/t", "rgb"}}}}};
    network.terminals["surface"] = {"/s", "surface"};
    scene().SetMaterial("/m", network);
  }
};

TEST_F(WrittenCage, IsTheSameSurface) {
  host::MeshDescription cube = described(test::cube_cage(), "catmullClark");
  cube.subdivTags.creaseIndices = {0, 1, 3, 4, 5};
  cube.subdivTags.creaseLengths = {3, 2};
  cube.subdivTags.creaseWeights = {2.5f, 10};
  cube.subdivTags.cornerIndices = {7};
  cube.subdivTags.cornerWeights = {1.5f};
  scene().SetMesh("/quad", cube);
  expect_same_picture();
  host::MeshDescription open = described(test::grid_cage(2), "catmullClark");
  open.subdivTags.interpolateBoundary = "edgeOnly";
  open.displayStyle.refineLevel = 2;
  scene().SetMesh("/quad", open);
  expect_same_picture();
  scene().SetMesh("/quad", described(test::octahedron_cage(), "loop"));
  expect_same_picture();
  scene().SetMesh("/quad", described(test::pentagon_prism_cage(), "bilinear"));
  expect_same_picture();
  cube.displayStyle.refineLevel = 0;
  scene().SetMesh("/quad", cube);
  expect_same_picture();
}

TEST_F(WrittenCage, KeepsItsPointsAndTheirNumbers) {
  host::MeshDescription cube = described(test::cube_cage(), "catmullClark");
  std::vector<Vec3f> points{{9, 9, 9}};  // no face uses it
  const auto& own = *cube.primvars["points"].value.get<Array<Vec3f>>();
  points.insert(points.end(), own.begin(), own.end());
  std::vector<int32_t> indices;
  for (const int32_t i : cube.topology.faceVertexIndices) indices.push_back(i + 1);
  cube.primvars["points"].value = Array<Vec3f>(points);
  cube.topology.faceVertexIndices = indices;
  scene().SetMesh("/quad", cube);
  ASSERT_EQ(write(), "");
  host::RetainedSceneDelegate read;
  ASSERT_TRUE(LoadScene(file(), &read, {}).ok);
  const host::MeshDescription& mesh = read.GetMeshes().begin()->second;
  EXPECT_EQ(mesh.primvars.at("points").value, cube.primvars["points"].value);
  EXPECT_EQ(mesh.topology, cube.topology);
}

TEST_F(WrittenCage, KeepsItsSeams) {
  host::MeshDescription cube = described(test::cube_cage(), "catmullClark");
  std::vector<Vec2f> st;
  std::vector<int32_t> indices;
  for (int32_t i = 0; i < 24; ++i) {  // each face has the whole image
    st.emplace_back(float(i % 4 == 1 || i % 4 == 2), float(i % 4 >= 2));
    indices.push_back(i);
  }
  cube.primvars["map"] = {Interpolation::faceVarying, "textureCoordinate", Array<Vec2f>(st), indices};
  cube.material = "/m";
  scene().SetMesh("/quad", cube);
  set_textured("baseColor", {"", copy_image("a.png"), nullptr}, {{"st", Token("map")}, {"filter", Token("linear")}});
  const std::string fault = write();
  EXPECT_EQ(fault.find("/quad has other seams of map"), 0u) << fault;  // some corners of two faces meet in one value
  for (size_t i = 0; i < st.size(); ++i) st[i] += Vec2f(float(i / 4), 0);
  cube.primvars["map"].value = Array<Vec2f>(st);
  scene().SetMesh("/quad", cube);
  expect_same_picture();
  EXPECT_EQ(document()["materials"][0]["replace"]["baseColor"]["file"], "a.png") << "relative, as it lies beside";
  EXPECT_EQ(document()["materials"][0]["replace"]["baseColor"]["st"], "st") << "the name of glTF's first set";
}

TEST_F(WrittenCage, ImagesInMemoryBecomeFiles) {
  host::MeshDescription quad = Stage::quad();
  quad.primvars["st"] = {
      Interpolation::vertex, "textureCoordinate", Array<Vec2f>{{0, 0}, {1, 0}, {1, 1}, {0, 0.75f}}, {}};
  quad.primvars["normals"] = {Interpolation::uniform, "normal", Array<Vec3f>{{0, 0, 1}}, {}};
  quad.primvars["tangents"] = {Interpolation::constant, "vector", Array<Vec4f>{{0, 1, 0, -1}}, {}};
  quad.material = "/m";
  scene().SetMesh("/quad", quad);
  std::ifstream image(copy_image("a.png"), std::ios::binary);
  const auto bytes = std::make_shared<const std::vector<uint8_t>>(std::istreambuf_iterator<char>(image),
                                                                  std::istreambuf_iterator<char>());
  std::filesystem::remove(folder_ / "a.png");
  for (const char* input : {"normal", "coatNormal", "baseColor"}) {
    std::map<Token, Value> scaled;
    if (input != std::string("baseColor"))
      scaled = {{"scale", Vec4f(1, 1, 2, 1)}, {"bias", Vec4f(-0.5f, -0.5f, -1, 0)}, {"sourceColorSpace", Token("raw")}};
    set_textured(input, {"a", "", bytes}, scaled);
    MaterialNetwork network = scene().GetMaterials().at("/m");
    network.nodes["/s"].parameters["coat"] = 0.5f;
    scene().SetMaterial("/m", network);
    expect_same_picture();
    EXPECT_TRUE(std::filesystem::exists(folder_ / "copy_image1.png")) << input;
  }
}

}  // namespace
}  // namespace alabaster::hd::description
