// Scenes that files cannot hold, and files that cannot be written: each is refused by name, and nothing is written.
#include <limits>

#include "testenv/unit/delegate/description/write_scene_fixture.h"

namespace alabaster::hd::description {
namespace {

using Mesh = host::MeshDescription;

class RefusedScene : public WriteSceneTest {
 protected:
  RefusedScene() { stage_.add_basic_scene(); }

  /// Changes the quad for one write.
  template <class Edit>
  std::string fault_of_mesh(const Edit& edit) {
    host::MeshDescription mesh = Stage::quad();
    edit(mesh);
    stage_.scene.SetMesh("/quad", mesh);
    const std::string fault = write();
    EXPECT_TRUE(is_empty()) << fault;
    return fault;
  }
};

#define EXPECT_SAYS(fault, text) EXPECT_NE((fault).find(text), std::string::npos) << (fault)

TEST_F(RefusedScene, NamesMeshesThatGltfCannotHold) {
  const std::pair<const char*, void (*)(Mesh&)> cases[] = {
      {"/quad is left-handed", [](Mesh& m) { m.topology.orientation = "leftHanded"; }},
      {"/quad has faces that are not drawn", [](Mesh& m) { m.topology.invisibleFaces = {0}; }},
      {"/quad has subsets",
       [](Mesh& m) {
         m.topology.geomSubsets = {{"/s", "/m", {0}}};
       }},
      {"/quad hides sides", [](Mesh& m) { m.cullStyle = CullStyle::back; }},
      {"/quad deforms",
       [](Mesh& m) {
         m.primvarSamples["points"] = {{0, 1}, {Value(), Value()}};
       }},
      {"/quad moves, and stands elsewhere",
       [](Mesh& m) {
         m.transformSamples = {{1, 2}, {Matrix4d(2.0), Matrix4d()}};
       }},
      {"/quad has too few points",
       [](Mesh& m) {
         m.primvars["points"].interpolation = Interpolation::constant;
         m.topology.faceVertexIndices = {0, 1, 1000, 3};
       }},
      {"/quad has too few points",
       [](Mesh& m) {
         m.topology.faceVertexIndices = {0, 1, -3, 3};
       }},
      {"/quad has colours or opacities beyond 0 to 1",
       [](Mesh& m) {
         m.material = {};
         m.primvars["displayColor"] = {
             Interpolation::vertex, "", Array<Vec3f>(std::vector<Vec3f>(4, Vec3f(0, 2, 0))), {}};
       }},
      {"/quad moves at times that do not rise",
       [](Mesh& m) {
         m.transformSamples = {{0, 0}, {m.transform, m.transform}};
       }},
      {"/quad has a primvar holdout that is no bool",
       [](Mesh& m) {
         m.primvars["holdout"] = {Interpolation::constant, "", Token("yes"), {}};
       }},
      {"/quad has a primvar st of another type",
       [](Mesh& m) {
         m.primvars["st"].value = Array<Vec3f>{{0, 0, 0}};
       }},
      {"/quad has too few indices",
       [](Mesh& m) {
         m.primvars["st"] = {Interpolation::vertex, "", Array<Vec2f>{{0, 0}}, {0}};
       }},
      {"/quad has indexed points",
       [](Mesh& m) {
         m.primvars["points"].indices = {0, 1, 2, 3};
       }},
      {"/quad has no primvar points", [](Mesh& m) { m.primvars.clear(); }},
      {"/quad has too few points",
       [](Mesh& m) {
         m.topology.faceVertexIndices = {0, 1, 2, -3};
       }},
  };
  for (const auto& [text, edit] : cases) EXPECT_SAYS(fault_of_mesh(edit), text);
}

TEST_F(RefusedScene, NamesCagesThatGltfCannotHold) {
  const std::pair<const char*, void (*)(Mesh&)> cases[] = {
      {"/quad is a cage of refineLevel 0 with normals",
       [](Mesh& m) {
         m.topology.scheme = "catmullClark";
         m.primvars["normals"].value = Array<Vec3f>(std::vector<Vec3f>(4, Vec3f(0, 0, 1)));
       }},
      {"/quad is a cage with st not by corner",
       [](Mesh& m) {
         m.topology.scheme = "catmullClark";
         m.primvars["st"].value = Array<Vec2f>(std::vector<Vec2f>(4, Vec2f(0, 0)));
       }},
      {"/quad has scheme loop and faces", [](Mesh& m) { m.topology.scheme = "loop"; }},
      {"/quad has more points of creases",
       [](Mesh& m) {
         m.topology.scheme = "catmullClark";
         m.subdivTags.creaseIndices = {0, 1, 2}, m.subdivTags.creaseLengths = {2}, m.subdivTags.creaseWeights = {1};
       }},
      {"/quad has creases or corners at points that it lacks",
       [](Mesh& m) {
         m.topology.scheme = "catmullClark";
         m.subdivTags.creaseIndices = {0, 9}, m.subdivTags.creaseLengths = {2}, m.subdivTags.creaseWeights = {1};
       }},
      {"/quad has other seams of displayColor",
       [](Mesh& m) {
         m.topology.scheme = "catmullClark";
         m.topology.faceVertexCounts = {3, 3}, m.topology.faceVertexIndices = {0, 1, 2, 2, 3, 0};
         m.material = {};
         m.primvars["displayColor"] = {
             Interpolation::faceVarying, "", Array<Vec3f>{{0, 0, 1}, {0, 0, 1}}, {0, 0, 0, 1, 1, 1}};
       }},
      {"/quad has a sharpness for each edge",
       [](Mesh& m) {
         m.topology.scheme = "catmullClark";
         m.subdivTags.creaseIndices = {0, 1, 2}, m.subdivTags.creaseLengths = {3}, m.subdivTags.creaseWeights = {1, 2};
       }},
  };
  for (const auto& [text, edit] : cases) EXPECT_SAYS(fault_of_mesh(edit), text);
}

TEST_F(RefusedScene, NamesInstancersThatMoveAndLinksToInstances) {
  host::MeshDescription quad = Stage::quad();
  quad.instancer = "/many";
  stage_.scene.SetMesh("/quad", quad);
  host::InstancerDescription many;
  many.primvars["hydra:instanceTranslations"] = Array<Vec3f>{{0, 0, 0}, {1, 0, 0}};
  many.indices["/quad"] = {0, 1};
  many.categories = {{"a"}, {}};
  stage_.scene.SetInstancer("/many", many);
  stage_.scene.SetLight("/key", {.type = "sphereLight", .transform = {}, .parameters = {{"shadowLink", Token("a")}}});
  EXPECT_SAYS(write(), "/key is linked to single instances of /many");
  many.categories = {};
  many.transformSamples = {{0, 1}, {Matrix4d(), Matrix4d()}};
  stage_.scene.SetInstancer("/many", many);
  EXPECT_SAYS(write(), "/many moves");
  EXPECT_TRUE(is_empty());
  many.transformSamples = {};
  many.primvars = {{"hydra:instanceTransforms", Array<Matrix4d>{Matrix4d()}}};
  many.indices["/quad"] = std::vector<int32_t>(500000, 0);
  stage_.scene.SetInstancer("/many", many);
  EXPECT_SAYS(write(), "/quad and other meshes have more than 400000 instances");
}

TEST_F(RefusedScene, NamesValuesThatDescriptionsMustNotHave) {
  stage_.scene.SetLight("/dome", {.type = "domeLight", .transform = {}, .parameters = {{"intensity", -2.0f}}});
  EXPECT_SAYS(write(), "/lights/0/intensity of _dome: -2.0");
  stage_.scene.SetLight("/dome", {.type = "domeLight", .transform = {}, .parameters = {}});
  host::MeshDescription quad = Stage::quad();
  quad.primvars["points"].value = Array<Vec3f>(std::vector<Vec3f>(4, Vec3f(std::numeric_limits<float>::infinity())));
  stage_.scene.SetMesh("/quad", quad);
  EXPECT_SAYS(write(), "/quad has points that are not finite");
  stage_.scene.SetMesh("/quad", Stage::quad());
  settings_["maxDepth"] = int64_t(-1);
  EXPECT_SAYS(write(), "/settings/maxDepth");
  EXPECT_TRUE(is_empty());
}

TEST_F(RefusedScene, NamesCamerasAndWindows) {
  state_.camera = "/gone";
  EXPECT_SAYS(write(), "/gone is no camera of the scene");
  state_.camera = {};
  EXPECT_SAYS(write(), "the pass has no camera");
  RenderSettingsDescription render;
  render.camera = "/first";
  stage_.scene.SetRenderSettings("/a", render);
  render.camera = "/second";
  stage_.scene.SetRenderSettings("/b", render);
  EXPECT_SAYS(write(), "/first is no camera of the scene");
  settings_["renderSettingsPrimPath"] = Path("/b");
  EXPECT_SAYS(write(), "/second is no camera of the scene");
  state_.camera = "/camera";
  const host::CameraDescription camera = stage_.scene.GetCameras().at("/camera");
  host::CameraDescription backwards = camera;
  backwards.parameters["shutterOpen"] = 0.25f;
  stage_.scene.SetCamera("/camera", backwards);
  EXPECT_SAYS(write(), "the camera's shutter closes before it opens");
  stage_.scene.SetCamera("/camera", camera);
  state_.framing.displayMin = {0.5f, 0};
  EXPECT_SAYS(write(), "the display window ends within pixels");
  state_.framing = {};
  EXPECT_SAYS(write(), "the pass has no pixels");
  EXPECT_TRUE(is_empty());
}

TEST_F(RefusedScene, NamesFilesThatCannotBeWritten) {
  const auto write_to = [&](const std::string& name) { return WriteScene(name, stage_.scene, state_, settings_); };
  EXPECT_SAYS(write_to(file("copy.txt")), "copy.txt must end in .json");
  EXPECT_SAYS(write_to(file(".json")), "needs a name before .json");
  EXPECT_SAYS(write_to(file("a\\b.json")), "has a backslash");
  EXPECT_SAYS(write_to(file("\xff.json")), "must be UTF-8");
  EXPECT_SAYS(write_to(file("gone/copy.json")), "there is no folder");
  EXPECT_SAYS(write_to("/proc/copy.json"), "/proc/copy.bin: the folder '/proc' cannot be written to");
  EXPECT_TRUE(is_empty());
  std::filesystem::create_directory(folder_ / "copy.gltf");
  EXPECT_SAYS(write(), "copy.gltf: a folder has this name");
  EXPECT_FALSE(std::filesystem::exists(folder_ / "copy.bin")) << "all are checked before one is written";
}

TEST_F(RefusedScene, DoesNotReplaceFilesThatTheSceneNames) {
  stage_.scene.SetLight("/dome",
                        {.type = "domeLight", .transform = {}, .parameters = {{"texture:file", file("copy.bin")}}});
  EXPECT_SAYS(write(), "/dome names the file " + file("copy.bin") + ", which would be replaced");
  const auto name_image = [&](const std::string& image) {
    stage_.scene.SetLight("/dome", {.type = "domeLight", .transform = {}, .parameters = {{"texture:file", image}}});
  };
  name_image(file("copy.exr"));
  EXPECT_SAYS(write(), "/dome names the file " + file("copy.exr") + ", which would be replaced") << "by the product";
  std::filesystem::create_directory_symlink(folder_, folder_ / "link");
  name_image(file("link/copy.bin"));
  EXPECT_SAYS(write(), "/dome names the file " + file("copy.bin") + ", which would be replaced");
  name_image(file("\xff.hdr"));
  EXPECT_SAYS(write(), "/dome names a file that is not UTF-8");
}

TEST_F(RefusedScene, ReplacesWrittenScenesAndNoOtherGltf) {
  ASSERT_EQ(write(), "");
  EXPECT_EQ(write(), "") << "a written scene";
  std::ofstream(file("copy.gltf")) << R"({"asset": {"version": "2.0"}})";
  EXPECT_SAYS(write(), "copy.gltf: this glTF document is no written scene");
  EXPECT_EQ(document("copy.gltf").size(), 1u);
}

}  // namespace
}  // namespace alabaster::hd::description
