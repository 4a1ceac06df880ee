// Scenes loaded from descriptions, compared with values worked out by hand.
#include <algorithm>
#include <cmath>

#include "delegate/api/render_delegate.h"
#include "testenv/support/build_paths.h"
#include "testenv/unit/delegate/description/scene_fixture.h"

namespace alabaster::hd::description {
namespace {

class LoadSceneTest : public SceneFiles {
 protected:
  const RenderSettingsDescription& settings(const SceneFile& file) const {
    return scene.GetAllRenderSettings().at(file.settings);
  }
  const MaterialNode& surface(const std::string& material_name) const {
    for (const auto& [path, network] : scene.GetMaterials())
      if (path.str().ends_with(material_name)) return network.nodes.at(network.terminals.at("surface").upstreamNode);
    throw std::runtime_error("no material " + material_name);
  }
  const host::MeshDescription& only_mesh() const { return scene.GetMeshes().begin()->second; }
  float light_number(const Path& path, const char* name) const {
    return static_cast<float>(scene.GetLights().at(path).parameters.at(name).number_or(-1));
  }
};

void expect_near(const Vec3d& a, const Vec3d& b, double tolerance) {
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(a[i], b[i], tolerance) << "component " << i;
}

TEST_F(LoadSceneTest, BareModelIsFramedAndLit) {
  const SceneFile file = load("patch.gltf");
  ASSERT_TRUE(file.ok) << errors();
  EXPECT_EQ(file.notes,
            (std::vector<std::string>{"no camera: framed the scene",
                                      "no light: added a studio, lights and a backdrop (studio=off: a soft dome)"}));
  // Every corner is inside the film, and the two widest apart span most of its width or height.
  const host::CameraDescription& camera = scene.GetCameras().at(settings(file).camera);
  const Matrix4d to_camera = camera.transform.inverse();
  const double tan_y = 0.024 / 2 / 0.050, tan_x = tan_y * 1280 / 720;
  double widest = 0;
  for (const Vec3d& corner : {Vec3d(-1, -1, 0), Vec3d(1, -1, 0), Vec3d(1, 1, 0), Vec3d(-1, 1, 0)}) {
    const Vec3d p = corner * to_camera;
    ASSERT_LT(p.z, 0);
    const double used = std::max(std::abs(p.x / -p.z) / tan_x, std::abs(p.y / -p.z) / tan_y);
    EXPECT_LE(used, 1);
    widest = std::max(widest, used);
  }
  EXPECT_NEAR(widest, 0.86, 1e-6);  // the margin
}

TEST_F(LoadSceneTest, ModelsOwnCameraAndLightAreKept) {
  const SceneFile file = load("lit.gltf");
  ASSERT_TRUE(file.ok) << errors();
  EXPECT_TRUE(file.notes.empty());
  ASSERT_EQ(scene.GetCameras().size(), 1u);
  EXPECT_EQ(settings(file).camera, scene.GetCameras().begin()->first);
  EXPECT_EQ(scene.GetLights().size(), 1u);
}

TEST_F(LoadSceneTest, MaterialsAreSetReplacedAndMade) {
  write_image("image.png");
  const SceneFile file = describe(R"({"gltf": [{"file": "patch.gltf"}],
    "materials": [{"match": "sk*", "set": {"roughness": 0.25, "baseColor": [0.5, 0.25, 0.125]}},
                  {"name": "wax", "set": {"scatterDistance": [0.01, 0.02, 0.03]}},
                  {"match": "wax", "set": {"baseColor": {"file": "image.png", "colorSpace": "raw", "wrap": "clamp"}}}],
    "meshes": [{"match": "patch", "material": "wax", "visible": false}]})");
  ASSERT_TRUE(file.ok) << errors();
  EXPECT_EQ(surface("_skin").parameters.at("roughness"), Value(0.25f));
  EXPECT_EQ(surface("_skin").parameters.at("baseColor"), Value(Vec3f(0.5f, 0.25f, 0.125f)));
  EXPECT_TRUE(surface("_skin").parameters.count("metallic")) << "set keeps what the model said";
  const MaterialNetwork& wax = scene.GetMaterials().at("/materials/wax");
  const MaterialNode& wax_surface = surface("/wax");
  EXPECT_EQ(wax_surface.parameters.at("scatterDistance"), Value(Vec3f(0.01f, 0.02f, 0.03f)));
  const MaterialNode& texture = wax.nodes.at(wax_surface.inputConnections.at("baseColor")[0].upstreamNode);
  EXPECT_EQ(texture.nodeTypeId, Token("AlabasterTexture"));
  EXPECT_EQ(texture.parameters.at("file").get<AssetPath>()->resolved, (folder_ / "image.png").string());
  EXPECT_EQ(texture.parameters.at("sourceColorSpace").text_or(""), "raw");
  EXPECT_EQ(texture.parameters.at("wrapT").text_or(""), "clamp");
  EXPECT_EQ(only_mesh().material, Path("/materials/wax"));
  EXPECT_FALSE(only_mesh().visible);

  ASSERT_TRUE(describe(R"({"gltf": [{"file": "patch.gltf"}],
    "materials": [{"match": "skin", "replace": {"roughness": 1}}]})")
                  .ok)
      << errors();
  EXPECT_EQ(surface("_skin").parameters.size(), 1u) << "replace forgets what the model said";
}

TEST_F(LoadSceneTest, MaterialsCanHaveReliefBesideTheirParameters) {
  write_image("heights.hdr");
  ASSERT_TRUE(describe(R"({"gltf": [{"file": "patch.gltf"}], "materials": [
    {"match": "skin", "bump": {"file": "heights.hdr", "scale": 0.5, "channel": "g", "wrap": "clamp"}},
    {"name": "wax", "set": {"roughness": 0.25},
     "displacement": {"file": "heights.hdr", "scale": 0.125, "midlevel": 0.5}},
    {"name": "bent", "displacement": {"file": "heights.hdr", "space": "tangent"}}]})")
                  .ok)
      << errors();
  const auto input = [](const MaterialNode& node, const char* name) { return node.inputConnections.at(name).at(0); };
  const auto network = [this](const std::string& name) {
    for (const auto& [path, found] : scene.GetMaterials())
      if (path.str().ends_with(name)) return found;
    return MaterialNetwork();
  };
  const MaterialNetwork skin = network("skin"), wax = network("wax"), bent = network("bent");
  EXPECT_EQ(input(surface("_skin"), "bump").upstreamOutput, Token("g"));
  const MaterialNode& bump = skin.nodes.at(input(surface("_skin"), "bump").upstreamNode);
  EXPECT_EQ(bump.parameters.at("scale"), Value(Vec4f(0.5f)));
  EXPECT_EQ(bump.parameters.at("wrapS").text_or(""), "clamp");
  EXPECT_TRUE(surface("_skin").parameters.count("metallic")) << "keeps what the model said";
  const MaterialNode& by_height = wax.nodes.at(wax.terminals.at("displacement").upstreamNode);
  EXPECT_EQ(by_height.nodeTypeId, Token("AlabasterDisplacement"));
  EXPECT_EQ(by_height.parameters.at("scale"), Value(0.125f));
  EXPECT_EQ(by_height.parameters.at("midlevel"), Value(0.5f));
  EXPECT_EQ(input(by_height, "displacement").upstreamOutput, Token("r"));
  const MaterialNode& by_vector = bent.nodes.at(bent.terminals.at("displacement").upstreamNode);
  EXPECT_EQ(by_vector.parameters.at("space").text_or(""), "tangent");
  EXPECT_EQ(input(by_vector, "displacement").upstreamOutput, Token("rgb"));

  EXPECT_FALSE(describe(R"({"gltf": [{"file": "patch.gltf"}], "materials": [{"match": "skin",
    "displacement": {"file": "heights.hdr", "space": "object", "channel": "g"}}]})")
                   .ok);
  EXPECT_NE(errors().find("A vector takes all three channels"), std::string::npos) << errors();
}

TEST_F(LoadSceneTest, ScatterDistanceCanBeATexture) {
  write_image("image.png");
  const SceneFile file = describe(R"({"gltf": [{"file": "patch.gltf"}], "materials": [
    {"match": "skin", "set": {"scatterDistance": {"file": "image.png", "scale": [0.25, 0.5, 1]}}},
    {"name": "wax", "set": {"scatterDistance": {"file": "image.png", "colorSpace": "sRGB"}}},
    {"name": "plain", "set": {"scatterDistance": {"file": "image.png"}}},
    {"match": "plain", "set": {"scatterDistance": [1, 2, 3]}}]})");
  ASSERT_TRUE(file.ok) << errors();
  EXPECT_EQ(surface("_skin").parameters.at("scatterDistance"), Value(Vec3f(0.25f, 0.5f, 1)));
  EXPECT_FALSE(surface("/wax").parameters.count("scatterDistance")) << "a constant of 1";
  EXPECT_EQ(surface("/plain").parameters.at("scatterDistance"), Value(Vec3f(1, 2, 3)));
  EXPECT_FALSE(surface("/plain").inputConnections.count("scatterDistance")) << "a constant takes the texture off";
  const MaterialNode& texture = scene.GetMaterials()
                                    .at("/materials/wax")
                                    .nodes.at(surface("/wax").inputConnections.at("scatterDistance")[0].upstreamNode);
  EXPECT_EQ(texture.parameters.at("sourceColorSpace").text_or(""), "sRGB");

  EXPECT_FALSE(describe(R"({"gltf": [{"file": "patch.gltf"}], "materials": [{"match": "skin", "set":
    {"scatterDistance": {"file": "none.exr"}}}]})")
                   .ok);
  EXPECT_NE(errors().find("/materials/0/set/scatterDistance/file"), std::string::npos) << errors();
  EXPECT_NE(errors().find("none.exr"), std::string::npos) << errors();
}

TEST_F(LoadSceneTest, SubdivisionOfAMesh) {
  const SceneFile file = describe(R"({"gltf": [{"file": "patch.gltf"}],
    "meshes": [{"match": "patch", "scheme": "loop", "refineLevel": 3, "interpolateBoundary": "edgeOnly",
      "creases": [{"points": [0, 1, 2], "sharpness": 2.5}, {"points": [2, 0]}],
      "corners": [{"point": 3, "sharpness": 4}], "faceVaryingLinearInterpolation": "all"}]})");
  ASSERT_TRUE(file.ok) << errors();
  const host::MeshDescription& mesh = only_mesh();
  EXPECT_EQ(mesh.topology.scheme, Token("loop"));
  EXPECT_EQ(mesh.displayStyle.refineLevel, 3);
  EXPECT_EQ(mesh.subdivTags.creaseIndices, (Array<int32_t>{0, 1, 2, 2, 0}));
  EXPECT_EQ(mesh.subdivTags.creaseLengths, (Array<int32_t>{3, 2}));
  EXPECT_EQ(mesh.subdivTags.creaseWeights, (Array<float>{2.5f, 10.0f}));
  EXPECT_EQ(mesh.subdivTags.cornerIndices, (Array<int32_t>{3}));
  EXPECT_EQ(mesh.subdivTags.cornerWeights, (Array<float>{4.0f}));
  EXPECT_EQ(mesh.subdivTags.interpolateBoundary, Token("edgeOnly"));
  EXPECT_EQ(mesh.subdivTags.faceVaryingLinearInterpolation, Token("all"));
}

// Two triangles without common vertices, as exporters write sharp edges, and one without area.
TEST_F(LoadSceneTest, ASchemeWeldsTheVerticesOfGltf) {
  const float points[27] = {-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, -1, 0, 1, 1, 0, -1, 1, 0, 1, 1, 0, 1, 1, 0, -1, 1, 0};
  std::ofstream(folder_ / "split.bin", std::ios::binary).write(reinterpret_cast<const char*>(points), sizeof points);
  write("split.gltf",
        R"({"asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}], "nodes": [{"name": "split", "mesh": 0}],
    "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
    "accessors": [{"bufferView": 0, "componentType": 5126, "count": 9, "type": "VEC3", "min": [-1, -1, 0], "max": [1, 1, 0]}],
    "bufferViews": [{"buffer": 0, "byteLength": 108}], "buffers": [{"byteLength": 108, "uri": "split.bin"}]})");
  ASSERT_TRUE(describe(R"({"gltf": [{"file": "split.gltf"}], "meshes": [
    {"match": "split", "corners": [{"point": 5}]}, {"match": "split", "scheme": "loop", "refineLevel": 1}]})")
                  .ok)
      << errors();
  EXPECT_EQ(only_mesh().topology.faceVertexIndices, (Array<int32_t>{0, 1, 2, 0, 2, 3}));
  EXPECT_EQ(only_mesh().topology.scheme, Token("loop"));
  EXPECT_EQ(only_mesh().primvars.at("points").value.count(), 4u);
  EXPECT_EQ(only_mesh().subdivTags.cornerIndices, (Array<int32_t>{3}));
  ASSERT_EQ(diagnostics.size(), 1u);
  EXPECT_NE(diagnostics[0].text.find("1 triangles"), std::string::npos) << diagnostics[0].text;
}

// The primitives of a glTF mesh are its subsets. A path of a primitive names its faces, all other patterns the mesh.
TEST_F(LoadSceneTest, PartsOfAMeshHaveMaterialsAndAreHidden) {
  std::string text = patch_gltf(false, false);
  const auto replace = [&](const std::string& old, const std::string& now) {
    text.replace(text.find(old), old.size(), now);
  };
  replace(R"("indices": 1, "material": 0})",
          R"("indices": 1, "material": 0}, {"attributes": {"POSITION": 0}, "indices": 2, "material": 1})");
  replace(R"("count": 6, "type": "SCALAR"})",
          R"("count": 3, "type": "SCALAR"},
             {"bufferView": 1, "byteOffset": 6, "componentType": 5123, "count": 3, "type": "SCALAR"})");
  replace(R"([{"name": "skin"}])", R"([{"name": "skin"}, {"name": "lips"}, {"name": "wax"}])");
  write("two.gltf", text);
  const Path skin("/gltf/two/materials/0_skin"), wax("/gltf/two/materials/2_wax");
  const auto change = [&](const std::string& match, const std::string& fields) {
    scene.Remove("/lights/key");
    EXPECT_TRUE(describe(R"({"gltf": [{"file": "two.gltf"}], "settings": {"studio": "off"}, "meshes": [{"match": ")" +
                         match + "\", " + fields + R"(}], "lights": [{"name": "key", "type": "sphereLight",
                         "lightLink": ["/gltf/two/nodes/0_patch/1"]}]})")
                    .ok)
        << errors();
    return only_mesh();
  };
  const host::MeshDescription part =
      change("/gltf/two/nodes/0_patch/1", R"("material": "wax", "visible": false, "holdout": true)");
  ASSERT_EQ(part.topology.geomSubsets.size(), 2u);
  EXPECT_EQ(part.topology.geomSubsets[0].materialId, skin);
  EXPECT_EQ(part.topology.geomSubsets[1].materialId, wax);
  EXPECT_EQ(part.topology.invisibleFaces, (Array<int32_t>{1}));
  EXPECT_TRUE(part.visible);
  EXPECT_EQ(part.categories, std::vector<Token>{Token("lightLink of /lights/key")}) << "of the mesh";
  EXPECT_TRUE(std::any_of(diagnostics.begin(), diagnostics.end(), [](const Diagnostic& d) {
    return d.where.ends_with("/lights/0/lightLink/0") && d.text.starts_with("Applies to all of mesh '");
  }));
  EXPECT_TRUE(part.primvars.contains("holdout"));
  EXPECT_TRUE(std::any_of(diagnostics.begin(), diagnostics.end(), [](const Diagnostic& d) {
    return d.where.ends_with("/meshes/0/holdout") && d.text.starts_with("Applies to all of mesh '");
  }));
  const host::MeshDescription whole = change("patch", R"("material": "wax", "visible": false)");
  for (const GeomSubset& subset : whole.topology.geomSubsets) EXPECT_EQ(subset.materialId, wax);
  EXPECT_EQ(whole.material, wax);
  EXPECT_FALSE(whole.visible);
  EXPECT_TRUE(whole.topology.invisibleFaces.empty());
  const auto then = [](const char* first, const std::string& match, const char* second) {
    return std::string(R"("visible": )") + first + R"(}, {"match": ")" + match + R"(", "visible": )" + second;
  };
  const host::MeshDescription shown = change("patch", then("false", "/gltf/two/nodes/0_patch/1", "true"));
  EXPECT_TRUE(shown.visible) << "a part of it is";
  EXPECT_EQ(shown.topology.invisibleFaces, (Array<int32_t>{0}));
  const host::MeshDescription again = change("/gltf/two/nodes/0_patch/1", then("false", "patch", "true"));
  EXPECT_TRUE(again.visible);
  EXPECT_TRUE(again.topology.invisibleFaces.empty());
}

TEST_F(LoadSceneTest, TransformsComposeAsWritten) {
  // (1,-1,0) scaled by 2 -> (2,-2,0); 90 degrees about z -> (2,2,0); moved -> (12,2,0).
  ASSERT_TRUE(describe(R"({"gltf": [{"file": "patch.gltf",
    "transform": {"translate": [10, 0, 0], "rotate": [0, 0, 90], "scale": [2, 2, 2]}}]})")
                  .ok);
  expect_near(Vec3d(1, -1, 0) * only_mesh().transform, Vec3d(12, 2, 0), 1e-12);
  // x before y: (0,1,0) about x by 90 -> (0,0,1); about y by 90 -> (1,0,0).
  ASSERT_TRUE(describe(R"({"gltf": [{"file": "patch.gltf", "transform": {"rotate": [90, 90, 0]}}]})").ok);
  expect_near(Vec3d(0, 1, 0) * only_mesh().transform, Vec3d(1, 0, 0), 1e-12);
  ASSERT_TRUE(describe(R"({"gltf": [{"file": "patch.gltf", "transform": [1,0,0,0, 0,1,0,0, 0,0,1,0, 3,4,5,1]}]})").ok);
  expect_near(Vec3d(0) * only_mesh().transform, Vec3d(3, 4, 5), 1e-12);
}

// The motion of the model comes after its nodes' placement, that of a mesh after the model's.
TEST_F(LoadSceneTest, MotionOfModelsMeshesAndCamera) {
  const auto file = describe(R"({
    "gltf": [{"file": "lit.gltf", "motion": [{"time": -1, "transform": {"translate": [1, 0, 0]}},
                                              {"time": 1, "transform": {"translate": [3, 0, 0]}}]}],
    "meshes": [{"match": "*patch*", "motion": [{"time": 0, "transform": {}},
                                               {"time": 1, "transform": {"translate": [0, 5, 0]}}]}],
    "camera": {"motion": [{"time": 0, "transform": {"translate": [0, 0, 9]}},
                          {"time": 2, "transform": {"translate": [0, 4, 9]}}],
               "shutterOpen": -0.5, "shutterClose": 0.5, "apertureBlades": 7}})");
  ASSERT_TRUE(file.ok) << errors();
  const host::MeshDescription& mesh = scene.GetMeshes().begin()->second;
  EXPECT_EQ(mesh.transform.translation(), Vec3d(2, 0, 0)) << "at time 0";
  EXPECT_EQ(mesh.transformSamples.times, (std::vector<double>{-1, 0, 1}));
  const Vec3d expected[] = {{1, 0, 0}, {2, 0, 0}, {3, 5, 0}};
  ASSERT_EQ(mesh.transformSamples.values.size(), 3u);
  for (size_t i = 0; i < 3; ++i) EXPECT_EQ(mesh.transformSamples.values[i].translation(), expected[i]) << i;
  const host::CameraDescription& camera = scene.GetCameras().at("/camera");
  EXPECT_EQ(camera.transform.translation(), Vec3d(0, 0, 9));
  EXPECT_EQ(camera.transformSamples.times, (std::vector<double>{0, 2}));
  EXPECT_EQ(camera.parameters.at("shutterOpen").number_or(0), -0.5);
  EXPECT_EQ(camera.parameters.at("apertureBlades").number_or(0), 7);
}

// What stands beside the axis stays at its distance from it: between samples 3 degrees apart it comes nearer by 4e-4.
TEST_F(LoadSceneTest, WhatTurnsAboutAnotherPointHasSamplesOfItsTurn) {
  ASSERT_TRUE(describe(R"({"gltf": [{"file": "patch.gltf", "transform": {"translate": [1, 0, 0]}}],
    "meshes": [{"match": "*", "motion": [{"time": 0, "transform": {}}, {"time": 1, "transform": {"rotate": [0, 170, 0]}}]}]})")
                  .ok)
      << errors();
  const auto& samples = only_mesh().transformSamples;
  ASSERT_EQ(samples.values.size(), 58u);
  Vec3d last(1, 0, 0);
  for (const Matrix4d& sample : samples.values) {
    const Vec3d p = sample.translation();
    EXPECT_NEAR(p.length(), 1, 1e-12);
    EXPECT_LT((p - last).length(), 0.0524);
    last = p;
  }
}

TEST_F(LoadSceneTest, TheSameModelTwice) {
  ASSERT_TRUE(describe(R"({"gltf": [{"file": "patch.gltf"},
    {"file": "patch.gltf", "transform": {"translate": [5, 0, 0]}}], "settings": {"studio": "off"}})")
                  .ok);
  EXPECT_EQ(scene.GetMeshes().size(), 2u);
}

TEST_F(LoadSceneTest, LightsInUsdLuxTerms) {
  const SceneFile file = describe(R"({"lights": [
    {"name": "key", "type": "rectLight", "position": [0, 4, 0], "target": [0, 0, 0], "width": 2, "intensity": 8,
     "exposure": 1.5, "color": [1, 0.5, 0.25], "normalize": true},
    {"name": "bulb", "type": "sphereLight", "treatAsPoint": true, "transform": {"translate": [1, 2, 3]}},
    {"name": "sun", "type": "distantLight", "angle": 0},
    {"match": "ke?", "intensity": 9}]})");
  ASSERT_TRUE(file.ok) << errors();
  const host::LightDescription& key = scene.GetLights().at("/lights/key");
  EXPECT_EQ(key.type, Token("rectLight"));
  expect_near(Vec3d(0, 0, -1) * key.transform, Vec3d(0, 3, 0), 1e-12);  // one unit along its -z: downwards
  EXPECT_EQ(light_number("/lights/key", "intensity"), 9);
  EXPECT_EQ(light_number("/lights/key", "exposure"), 1.5f);
  EXPECT_EQ(key.parameters.at("color"), Value(Vec3f(1, 0.5f, 0.25f)));
  EXPECT_EQ(key.parameters.at("normalize"), Value(true));
  EXPECT_EQ(light_number("/lights/bulb", "radius"), 0);
  expect_near(scene.GetLights().at("/lights/bulb").transform.translation(), Vec3d(1, 2, 3), 0);
}

TEST_F(LoadSceneTest, LightsAreLinkedByTheNamesOfMeshes) {
  const auto linked = [](const std::string& lights) {
    return R"({"gltf": [{"file": "patch.gltf"}, {"file": "lit.gltf"}], "settings": {"studio": "off"},
               "lights": [)" +
           lights + "]}";
  };
  const SceneFile file = describe(linked(R"({"name": "key", "type": "sphereLight", "lightLink": ["/gltf/patch/*"]},
    {"name": "fill", "type": "sphereLight", "shadowLink": ["patch"], "lightLink": []},
    {"match": "key", "lightLink": ["/gltf/lit/*"]})"));
  ASSERT_TRUE(file.ok) << errors();
  const Token key("lightLink of /lights/key"), fill("shadowLink of /lights/fill");
  EXPECT_EQ(scene.GetLights().at("/lights/key").parameters.at("lightLink").text_or(""), key.str());
  EXPECT_EQ(scene.GetLights().at("/lights/fill").parameters.at("lightLink").text_or(""), "lightLink of /lights/fill");
  int lit = 0;
  for (const auto& [path, mesh] : scene.GetMeshes()) {
    const bool is_lit = path.str().starts_with("/gltf/lit/");
    lit += is_lit;
    EXPECT_EQ(mesh.categories, is_lit ? (std::vector<Token>{key, fill}) : std::vector<Token>{fill}) << path.str();
  }
  EXPECT_EQ(lit, 1) << "the later link holds";
  EXPECT_FALSE(describe(linked(R"({"name": "other", "type": "sphereLight", "lightLink": ["patsh"]})")).ok);
  EXPECT_NE(errors().find("/lights/0/lightLink/0"), std::string::npos) << errors();
  EXPECT_NE(errors().find("Did you mean 'patch'?"), std::string::npos) << errors();
}

// A camera that is aimed is focused on its target, unless it has a focus of its own.
TEST_F(LoadSceneTest, AnAimedCameraIsFocusedOnItsTarget) {
  const auto focus = [this](const std::string& more) {
    const SceneFile file = describe(R"({"gltf": [{"file": "lit.gltf"}], "camera": {"fStop": 2)" + more + "}}");
    EXPECT_TRUE(file.ok) << errors();
    const auto& p = scene.GetCameras().at(settings(file).camera).parameters;
    return p.contains("focusDistance") ? p.at("focusDistance").number_or(-1) : 0;
  };
  EXPECT_FLOAT_EQ(float(focus(R"(, "lookAt": {"eye": [0, 3, 4], "target": [0, 0, 0]})")), 5.0f);
  EXPECT_FLOAT_EQ(float(focus(R"(, "use": "front", "lookAt": {"eye": [0, 0, 2], "target": [0, 0, 0]})")), 2.0f);
  EXPECT_FLOAT_EQ(float(focus(R"(, "focusDistance": 7, "lookAt": {"eye": [0, 3, 4], "target": [0, 0, 0]})")), 7.0f);
  EXPECT_EQ(focus(R"(, "focusDistance": 0, "lookAt": {"eye": [0, 3, 4], "target": [0, 0, 0]})"), 0);
  EXPECT_EQ(focus(R"(, "transform": {"translate": [0, 0, 3]})"), 0) << "its target is not known";
}

TEST_F(LoadSceneTest, CameraOfTheModelWithAnotherLens) {
  const SceneFile file = describe(R"({"gltf": [{"file": "lit.gltf"}], "camera": {"use": "front", "fStop": 4}})");
  ASSERT_TRUE(file.ok) << errors();
  const host::CameraDescription& camera = scene.GetCameras().at(settings(file).camera);
  expect_near(camera.transform.translation(), Vec3d(0, 0, 5), 1e-6);
  EXPECT_EQ(camera.parameters.at("fStop"), Value(4.0f));
  EXPECT_TRUE(camera.parameters.count("focalLength")) << "the model's lens";
}

TEST_F(LoadSceneTest, ProductsOfOneSizeShareARender) {
  const SceneFile file =
      describe(R"({"settings": {"resolution": [640, 480], "samples": 7, "frame": 3, "seed": 4294967295,
                 "windowPolicy": "fit", "pixelAspectRatio": 2},
    "products": [{"file": "a.exr", "aovs": ["color", "depth", "primId"], "dataType": "float"},
                 {"file": "b.png", "view": "ACES", "exposure": -1},
                 {"file": "c.png", "resolution": [64, 48], "crop": [1, 2, 3, 4]}]})");
  ASSERT_TRUE(file.ok) << errors();
  const RenderSettingsDescription& first = settings(file);
  EXPECT_EQ(first.width, 640);
  EXPECT_EQ(first.height, 480);
  EXPECT_EQ(first.windowPolicy, WindowPolicy::fit);
  EXPECT_EQ(first.pixelAspectRatio, 2);
  EXPECT_EQ(first.frame, 3);
  EXPECT_EQ(first.settings.at("samples").number_or(0), 7);
  EXPECT_EQ(first.settings.at("seed").number_or(0), 4294967295.0);
  ASSERT_EQ(first.products.size(), 2u);
  EXPECT_EQ(first.products[0].file, (folder_ / "a.exr").string());
  ASSERT_EQ(first.products[0].vars.size(), 3u);
  EXPECT_EQ(first.products[0].vars[0].dataType, Token("float"));
  EXPECT_EQ(first.products[0].vars[2].dataType, Token("int"));
  EXPECT_EQ(first.products[1].view, "ACES");
  EXPECT_EQ(first.products[1].exposure, -1);
  ASSERT_EQ(file.further_settings.size(), 1u);
  const RenderSettingsDescription& second = scene.GetAllRenderSettings().at(file.further_settings[0]);
  EXPECT_EQ(second.width, 64);
  EXPECT_EQ(second.crop, (Rect2i{1, 2, 3, 4}));
}

// promise: pipeline.name.set
TEST_F(LoadSceneTest, OverridesComeLast) {
  write_image("sky.hdr");
  write("base.json", R"({"gltf": [{"file": "lit.gltf"}], "settings": {"samples": 9}})");
  LoadOptions options = with_overrides({"samples=3", "subsurface=lambert", "materials/skin.roughness=0.125",
                                        "materials/skin.baseColor=[0.1,0.2,0.3]", "lights/lamp.intensity=5",
                                        "meshes/patch.visible=false", "camera.fStop=8"});
  options.dome = (folder_ / "sky.hdr").string() + ",0.5";
  const SceneFile file = load("base.json", options);
  ASSERT_TRUE(file.ok) << errors();
  EXPECT_EQ(settings(file).settings.at("samples").number_or(0), 3);
  EXPECT_EQ(settings(file).settings.at("subsurface").text_or(""), "lambert");
  EXPECT_EQ(surface("_skin").parameters.at("roughness"), Value(0.125f));
  EXPECT_EQ(surface("_skin").parameters.at("baseColor"), Value(Vec3f(0.1f, 0.2f, 0.3f)));
  EXPECT_FALSE(only_mesh().visible);
  EXPECT_EQ(scene.GetCameras().at(settings(file).camera).parameters.at("fStop"), Value(8.0f));
  EXPECT_EQ(light_number("/lights/dome", "intensity"), 0.5f);
  EXPECT_EQ(scene.GetLights().at("/lights/dome").parameters.at("texture:file").get<AssetPath>()->resolved,
            (folder_ / "sky.hdr").string());
}

TEST_F(LoadSceneTest, DomeByColour) {
  ASSERT_TRUE(describe(R"({"lights": [{"name": "sky", "type": "domeLight"}]})", with_dome("0.1,0.2,0.3,4")).ok);
  ASSERT_EQ(scene.GetLights().size(), 1u) << "the dome replaces the scene's";
  EXPECT_EQ(scene.GetLights().at("/lights/dome").parameters.at("color"), Value(Vec3f(0.1f, 0.2f, 0.3f)));
  EXPECT_EQ(light_number("/lights/dome", "intensity"), 4);
}

// A triangle instanced by M * S * R * T within an outer instancer: every instance must be in the frame.
TEST_F(LoadSceneTest, FramingFollowsNestedInstances) {
  host::MeshDescription mesh;
  mesh.topology.faceVertexCounts = {3};
  mesh.topology.faceVertexIndices = {0, 1, 2};
  mesh.primvars["points"].value = Array<Vec3f>{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  mesh.instancer = "/inner";
  scene.SetMesh("/mesh", mesh);
  host::InstancerDescription inner, outer;
  inner.parent = "/outer";
  inner.primvars["hydra:instanceScales"] = Array<Vec3f>{{1, 1, 1}, {2, 2, 2}};
  inner.primvars["hydra:instanceTranslations"] = Array<Vec3f>{{0, 0, 0}, {3, 0, 0}};
  inner.indices["/mesh"] = {0, 1};
  outer.transform.setTranslation(Vec3d(0, 0, -7));
  // A quarter turn about y: x goes to -z.
  const float h = std::sqrt(0.5f);
  outer.primvars["hydra:instanceRotations"] = Array<Quatf>{Quatf(1, 0, 0, 0), Quatf(h, 0, h, 0)};
  outer.indices["/inner"] = {0, 1};
  scene.SetInstancer("/inner", inner);
  scene.SetInstancer("/outer", outer);
  const SceneFile file = describe("{}");
  ASSERT_TRUE(file.ok) << errors();
  const Matrix4d to_camera = scene.GetCameras().at(settings(file).camera).transform.inverse();
  const double tan_y = 0.024 / 2 / 0.050, tan_x = tan_y * 1280 / 720;
  double widest = 0;
  // Point (1,0,0) of each instance, by hand: small and large, straight and turned, all moved by -7 in z.
  for (const Vec3d& corner : {Vec3d(1, 0, -7), Vec3d(5, 0, -7), Vec3d(0, 0, -8), Vec3d(0, 0, -12), Vec3d(0, 0, -7),
                              Vec3d(3, 2, -7), Vec3d(0, 2, -10)}) {
    const Vec3d p = corner * to_camera;
    ASSERT_LT(p.z, 0);
    widest = std::max({widest, std::abs(p.x / -p.z) / tan_x, std::abs(p.y / -p.z) / tan_y});
  }
  EXPECT_NEAR(widest, 0.86, 0.02) << "all of it, and not from farther than needed";
}

TEST_F(LoadSceneTest, SchemasAreThoseOfTheFiles) {
  for (const char* name : {"disney_material", "texture_node", "displacement_node", "textures", "mesh", "lights",
                           "camera", "render_settings", "render_description", "quality_presets"}) {
    ASSERT_NE(SchemaText(name), nullptr) << name;
    std::ifstream file(testing::source_file("schemas/") + name + ".json");
    const std::string text((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
    EXPECT_TRUE(SchemaText(name) == text) << name << ": run 'alabaster schema --write .'";
  }
  EXPECT_EQ(SchemaText("nothing"), nullptr);
}

}  // namespace
}  // namespace alabaster::hd::description
