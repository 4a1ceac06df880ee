// Accessors of all kinds and the primvars made from them; instances; which scene and materials are used.
#include <set>

#include "testenv/support/stage.h"
#include "testenv/unit/delegate/gltf/gltf_builder.h"

namespace alabaster::hd::gltf::testing {
namespace {

TEST(GltfGeometry, EverySetOfTextureCoordinatesIsAPrimvar) {
  GltfBuilder b;
  b.triangle();
  b.attribute<float>("TEXCOORD_0", {0, 0, 1, 0, 0, 1}, "VEC2");
  b.attribute<uint16_t>("TEXCOORD_1", {0, 65535, 65535, 0, 0, 0}, "VEC2", true);
  b.attribute<uint8_t>("TEXCOORD_2", {255, 0, 0, 0, 255, 0, 0, 0, 51, 255, 0, 0}, "VEC2", true);
  b.json["accessors"].back()["count"] = 3;  // two bytes of four
  b.json["bufferViews"].back()["byteStride"] = 4;
  const Loaded loaded = b.load();
  EXPECT_EQ(loaded.count(Severity::warning), 1u) << loaded.said();  // POSITION has no bounds
  const host::MeshDescription& mesh = only_mesh(loaded);
  expect_near(primvar<Array<Vec2f>>(mesh, "st")[2], Vec2f(0, 0));
  expect_near(primvar<Array<Vec2f>>(mesh, "st1")[0], Vec2f(0, 0));  // v up
  expect_near(primvar<Array<Vec2f>>(mesh, "st1")[1], Vec2f(1, 1));
  expect_near(primvar<Array<Vec2f>>(mesh, "st2")[2], Vec2f(0.2f, 0));
  EXPECT_EQ(mesh.primvars.count("st3"), 0u);
  b.primitive()["attributes"].erase("TEXCOORD_1");
  EXPECT_EQ(only_mesh(b.load()).primvars.count("st2"), 1u) << "a gap";
}

TEST(GltfGeometry, ColorsAreLinearPrimvarsAndTheirAlphaIsOpacity) {
  GltfBuilder b;
  b.triangle();
  b.attribute<float>("COLOR_0", {1, 0, 0, 1, 0, 0.5f, 0, 0.25f, 0, 0, 1, 0}, "VEC4");
  const Loaded with_alpha = b.load();
  expect_near(primvar<Array<Vec3f>>(only_mesh(with_alpha), "displayColor")[1], Vec3f(0, 0.5f, 0));
  EXPECT_EQ(primvar<Array<float>>(only_mesh(with_alpha), "displayOpacity"), (Array<float>{1, 0.25f, 0}));

  b.attribute<uint16_t>("COLOR_0", {65535, 13107, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0}, "VEC3", true);
  b.json["accessors"].back()["count"] = 3;
  b.json["bufferViews"].back()["byteStride"] = 8;
  const Loaded without = b.load();
  expect_near(primvar<Array<Vec3f>>(only_mesh(without), "displayColor")[0], Vec3f(1, 0.2f, 0));
  EXPECT_EQ(only_mesh(without).primvars.count("displayOpacity"), 0u);

  b.attribute<uint8_t>("COLOR_0", {255, 51, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0}, "VEC4");
  const Loaded plain = b.load();  // glTF allows only normalized integers here
  EXPECT_TRUE(plain.says(Severity::warning, "COLOR_0 integers must be normalized")) << plain.said();
  expect_near(primvar<Array<Vec3f>>(only_mesh(plain), "displayColor")[0], Vec3f(1, 0.2f, 0));
}

TEST(GltfGeometry, TangentsNeedNormalsAndNeitherIsMadeUp) {
  GltfBuilder b;
  b.triangle();
  b.attribute<float>("TANGENT", {1, 0, 0, -1, 1, 0, 0, -1, 1, 0, 0, -1}, "VEC4");
  const Loaded flat = b.load();  // glTF, section 3.7.2.1: flat normals, and tangents are ignored
  EXPECT_EQ(only_mesh(flat).primvars.count("normals") + only_mesh(flat).primvars.count("tangents"), 0u);
  EXPECT_EQ(only_mesh(flat).topology.scheme, Token("none"));
  b.attribute<float>("NORMAL", {0, 0, 1, 0, 0, 1, 0, 0, 1}, "VEC3");
  const Loaded smooth = b.load();
  EXPECT_EQ(primvar<Array<Vec4f>>(only_mesh(smooth), "tangents")[2], Vec4f(1, 0, 0, -1));
}

TEST(GltfGeometry, QuantizedAndSparsePositions) {
  GltfBuilder b;
  b.json["extensionsUsed"] = b.json["extensionsRequired"] = {"KHR_mesh_quantization"};
  b.attribute<int16_t>("POSITION", {0, 0, 0, 0, 32767, -32767, 0, 0, 0, 16384, -32768, 0}, "VEC3", true);
  b.json["accessors"].back()["count"] = 3;
  b.json["bufferViews"].back()["byteStride"] = 8;
  const Loaded quantized = b.load();
  const auto& points = primvar<Array<Vec3f>>(only_mesh(quantized), "points");
  expect_near(points[1], Vec3f(1, -1, 0));
  expect_near(points[2], Vec3f(0, 16384 / 32767.0f, -1));  // -32768 counts as -1

  b.primitive()["attributes"]["POSITION"] = b.add_sparse(3, {1, 2}, {1, 2, 3, 4, 5, 6}, "VEC3");
  const Loaded sparse = b.load();
  EXPECT_EQ(primvar<Array<Vec3f>>(only_mesh(sparse), "points"), (Array<Vec3f>{{0, 0, 0}, {1, 2, 3}, {4, 5, 6}}));
}

// A quad as a fan of two triangles, whose colours differ along the diagonal.
TEST(GltfGeometry, CagesKeepEveryPrimvarOnTheirCorners) {
  GltfBuilder b;
  b.attribute<float>("POSITION", {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0}, "VEC3");
  b.attribute<float>("TEXCOORD_0", {0, 0, 1, 0, 1, 1, 0, 1}, "VEC2");
  b.attribute<float>("TEXCOORD_1", {0, 0, 1, 0, 1, 0, 0, 0}, "VEC2");
  b.attribute<float>("COLOR_0", {1, 0, 0, 1, 0, 0, 0, 1, 0, 0, 1, 0}, "VEC3");
  b.primitive()["indices"] = b.add<uint16_t>({0, 1, 2, 0, 2, 3}, "SCALAR");
  b.primitive()["extensions"]["FB_ngon_encoding"] = Json::object();
  b.json["extensionsUsed"] = {"FB_ngon_encoding"};
  const Loaded loaded = b.load();
  const host::MeshDescription& mesh = only_mesh(loaded);
  EXPECT_EQ(mesh.topology.faceVertexCounts, (Array<int32_t>{4}));
  for (const char* name : {"st", "st1", "displayColor"}) {
    ASSERT_EQ(mesh.primvars.count(name), 1u) << name;
    EXPECT_EQ(mesh.primvars.at(name).interpolation, Interpolation::faceVarying);
    EXPECT_EQ(mesh.primvars.at(name).indices.size(), 4u);
  }
  const auto& corners = mesh.primvars.at("displayColor").indices;
  EXPECT_EQ(primvar<Array<Vec3f>>(mesh, "displayColor")[size_t(corners[2])], Vec3f(0, 1, 0));
}

// Translation, a quarter turn around z and scale of two instances, below a node that is moved.
TEST(GltfInstancing, InstancesArePlacedBelowTheirNodes) {
  GltfBuilder b;
  b.triangle();
  const float h = std::sqrt(0.5f);
  b.node()["translation"] = {10, 0, 0};
  b.node()["extensions"]["EXT_mesh_gpu_instancing"]["attributes"] = {
      {"TRANSLATION", b.add<float>({0, 0, 0, 0, 0, 5}, "VEC3")},
      {"ROTATION", b.add<float>({0, 0, 0, 1, 0, 0, h, h}, "VEC4")},
      {"SCALE", b.add<float>({1, 1, 1, 2, 2, 2}, "VEC3")},
      {"_ID", b.add<uint16_t>({7, 0, 8, 0}, "SCALAR")}};
  b.json["accessors"].back()["count"] = 2;
  b.json["extensionsUsed"] = b.json["extensionsRequired"] = {"EXT_mesh_gpu_instancing"};
  b.json["nodes"].push_back({{"mesh", 0}, {"translation", {0, 0, -1}}});
  b.json["scenes"][0]["nodes"] = {0, 1};
  const Loaded loaded = b.load();
  ASSERT_EQ(loaded.scene->GetInstancers().size(), 1u) << loaded.said();
  const auto& instancer = loaded.scene->GetInstancers().begin()->second;
  const auto* transforms = instancer.primvars.at("hydra:instanceTransforms").get<Array<Matrix4d>>();
  ASSERT_TRUE(transforms && transforms->size() == 3);
  expect_near(transformed({1, 0, 0}, (*transforms)[0]), Vec3d(11, 0, 0));
  expect_near(transformed({1, 0, 0}, (*transforms)[1]), Vec3d(10, 2, 5));
  expect_near(transformed({1, 0, 0}, (*transforms)[2]), Vec3d(1, 0, -1));
  EXPECT_EQ(instancer.indices.begin()->second, (Array<int32_t>{0, 1, 2}));
}

TEST(GltfInstancing, AttributesThatDoNotAgreeAreRefused) {
  const auto fails = [](const std::string& name, const std::vector<float>& values, const char* type) {
    GltfBuilder b;
    b.triangle();
    Json& attributes = b.node()["extensions"]["EXT_mesh_gpu_instancing"]["attributes"];
    attributes["SCALE"] = b.add<float>({1, 1, 1, 1, 1, 1}, "VEC3");
    attributes[name] = b.add(values, type);
    const Loaded loaded = b.load();
    return !loaded.summary.ok && loaded.says(Severity::error, "nodes[0].extensions.EXT_mesh_gpu_instancing");
  };
  EXPECT_TRUE(fails("TRANSLATION", {0, 0, 0}, "VEC3"));
  EXPECT_TRUE(fails("TRANSLATION", {0, 0, 0, 0}, "VEC2"));
  EXPECT_TRUE(fails("ROTATION", {0, 0, 0, 0, 0, 0}, "VEC3"));
  EXPECT_TRUE(fails("TRANSLATION", {0, 0, 0, 0, 0, NAN}, "VEC3"));
}

// Nodes 0 and 1 stand in scenes of their own; 2 in none.
// Exporters give all primitives of a mesh one array of vertices.
TEST(GltfGeometry, PrimitivesHaveOnlyThePointsThatTheirTrianglesUse) {
  GltfBuilder b;
  constexpr size_t kVertices = 3000;
  std::vector<float> points, colors;
  for (size_t v = 0; v < kVertices; ++v) {
    points.insert(points.end(), {float(v), float(v % 7), 0});
    colors.insert(colors.end(), {float(v) / float(kVertices), 0, 0});
  }
  b.attribute<float>("POSITION", points, "VEC3");
  b.attribute<float>("COLOR_0", colors, "VEC3");
  const size_t moved = b.add_sparse(kVertices, {12, 2000, 2001}, {9, 9, 9, 0, 0, 2, 0, 0, 1}, "VEC3");
  b.primitive()["targets"] = {{{"POSITION", moved}}};
  b.node()["weights"] = {1};
  b.primitive()["indices"] = b.add<uint16_t>({2001, 17, 2000, 2001, 17, 16}, "SCALAR");
  const Loaded loaded = b.load();
  const host::MeshDescription& mesh = only_mesh(loaded);
  EXPECT_EQ(mesh.topology.faceVertexIndices, (Array<int32_t>{3, 1, 2, 3, 1, 0})) << loaded.said();
  EXPECT_EQ(primvar<Array<Vec3f>>(mesh, "points"), (Array<Vec3f>{{16, 2, 0}, {17, 3, 0}, {2000, 5, 2}, {2001, 6, 1}}));
  EXPECT_EQ(primvar<Array<Vec3f>>(mesh, "displayColor")[3], Vec3f(2001.0f / float(kVertices), 0, 0));
  EXPECT_LT(loaded.summary.memory_bytes, size_t(1000)) << "of geometry that is used";
}

// Two triangles of a square, each a primitive with points of its own.
GltfBuilder two_primitives() {
  GltfBuilder b;
  b.json["materials"] = {{{"name", "a"}}, {{"name", "b"}}};
  b.attribute<float>("POSITION", {0, 0, 0, 1, 0, 0, 1, 1, 0}, "VEC3");
  b.primitive()["material"] = 0;
  Json second = {{"material", 1}};
  second["attributes"]["POSITION"] = b.add<float>({0, 0, 0, 1, 1, 0, 0, 1, 0}, "VEC3");
  b.json["meshes"][0]["primitives"].push_back(second);
  return b;
}

// glTF splits a mesh by materials, whose surface is one: a body that walks meet is closed in all its primitives.
TEST(GltfGeometry, PrimitivesAreSubsetsOfOneMesh) {
  const Loaded loaded = two_primitives().load();
  const host::MeshDescription& mesh = only_mesh(loaded);
  EXPECT_EQ(loaded.scene->GetMeshes().begin()->first, Path("/gltf/made/nodes/0/mesh_0")) << loaded.said();
  EXPECT_EQ(mesh.topology.faceVertexIndices, (Array<int32_t>{0, 1, 2, 3, 4, 5}));
  EXPECT_EQ(primvar<Array<Vec3f>>(mesh, "points")[4], Vec3f(1, 1, 0));
  ASSERT_EQ(mesh.topology.geomSubsets.size(), 2u);
  EXPECT_EQ(mesh.topology.geomSubsets[1].id, Path("/gltf/made/nodes/0/1"));
  EXPECT_EQ(mesh.topology.geomSubsets[1].materialId, Path("/gltf/made/materials/1_b"));
  EXPECT_EQ(mesh.topology.geomSubsets[1].indices, (Array<int32_t>{1}));
}

// Seen from behind, a part of the mesh is there if its material is double-sided.
TEST(GltfGeometry, PrimitivesOfDifferentSidesAreOneMesh) {
  for (const bool first : {false, true})
    for (const bool second : {false, true}) {
      GltfBuilder b = two_primitives();
      b.json["materials"][0]["doubleSided"] = first, b.json["materials"][1]["doubleSided"] = second;
      b.node()["rotation"] = {0, 1, 0, 0};
      const Loaded loaded = b.load();
      EXPECT_EQ(only_mesh(loaded).doubleSided, first && second);
      Stage stage{{{"samples", int64_t(1)}, {"filter", std::string("box")}}};
      stage.add_basic_scene();
      stage.scene.Remove("/quad");
      for (const auto& [path, mesh] : loaded.scene->GetMeshes()) stage.scene.SetMesh(path, mesh);
      for (const auto& [path, material] : loaded.scene->GetMaterials()) stage.scene.SetMaterial(path, material);
      RenderBuffer* const buffer = stage.add_buffer("/buffer", 8, 8, Format::float32);
      const std::unique_ptr<RenderPass> pass = stage.delegate->CreateRenderPass();
      stage.index->SyncAll();
      ASSERT_TRUE(Stage::finish(*pass, Stage::state_for(8, 8, "elementId", buffer)));
      const std::vector<float> faces = Stage::pixels<float>(buffer);  // of half a unit, from (-2, 2) on
      EXPECT_EQ(faces[3 * 8 + 2], first ? 0 : -1) << first << second;
      EXPECT_EQ(faces[2 * 8 + 3], second ? 1 : -1) << first << second;
    }
}

// A primitive without an attribute looks as it would alone.
TEST(GltfGeometry, PrimitivesOfDifferentAttributesAreOneMesh) {
  for (const auto& [first, has_material] : {std::pair(true, true), {true, false}, {false, true}, {false, false}}) {
    GltfBuilder b = two_primitives();
    Json& primitives = b.json["meshes"][0]["primitives"];
    primitives[first == has_material ? 0 : 1].erase("material");  // of the one with attributes, or of the other
    Json& attributes = primitives[first ? 0 : 1]["attributes"];
    attributes["NORMAL"] = b.add<float>({0, 1, 0, 0, 1, 0, 0, 1, 0}, "VEC3");
    attributes["TANGENT"] = b.add<float>({1, 0, 0, 1, 1, 0, 0, 1, 1, 0, 0, 1}, "VEC4");
    attributes["TEXCOORD_0"] = b.add<float>({0.5f, 0.25f, 0.5f, 0.25f, 0.5f, 0.25f}, "VEC2");
    attributes["COLOR_0"] = b.add<float>({0.5f, 0, 0, 0.5f, 0.5f, 0, 0, 0.5f, 0.5f, 0, 0, 0.5f}, "VEC4");
    const Loaded loaded = b.load();
    const host::MeshDescription& mesh = only_mesh(loaded);
    for (const size_t vertex : {0u, 2u, 3u, 5u}) {
      const bool has = (vertex < 3) == first;
      EXPECT_EQ(primvar<Array<Vec3f>>(mesh, "normals")[vertex], has ? Vec3f(0, 1, 0) : Vec3f(0, 0, 1)) << vertex;
      EXPECT_EQ(primvar<Array<Vec2f>>(mesh, "st")[vertex], has ? Vec2f(0.5f, 0.75f) : Vec2f(0)) << vertex;
      const Vec3f own(has_material ? 1 : 0.8f);  // as the glTF material's factor, or the default material
      EXPECT_EQ(primvar<Array<Vec3f>>(mesh, "displayColor")[vertex], has ? Vec3f(0.5f, 0, 0) : own) << vertex;
      EXPECT_EQ(primvar<Array<float>>(mesh, "displayOpacity")[vertex], has ? 0.5f : 1.0f) << vertex;
    }
    EXPECT_EQ(mesh.primvars.count("tangents"), 0u);
    EXPECT_EQ(mesh.topology.faceVertexIndices, (Array<int32_t>{0, 1, 2, 3, 4, 5}));
  }
}

// Bodies that are closed alone, such as a liquid in its glass, are no parts of one surface, and neither are parts that
// meet in points alone.
TEST(GltfGeometry, PrimitivesWithoutACommonEdgeStayMeshes) {
  const std::vector<float> tetrahedron = {0, 0, 0, 0, 1, 0, 1, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1,
                                          0, 0, 0, 0, 0, 1, 0, 1, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1};
  const std::vector<float> corner = {0, 0, 0, -1, 0, 0, 0, -1, 0};
  for (const bool closed : {true, false}) {
    GltfBuilder b = two_primitives();
    Json& primitives = b.json["meshes"][0]["primitives"];
    if (closed) primitives[0]["attributes"]["POSITION"] = b.add<float>(tetrahedron, "VEC3");
    primitives[1]["attributes"]["POSITION"] = b.add<float>(closed ? tetrahedron : corner, "VEC3");
    const Loaded loaded = b.load();
    EXPECT_EQ(loaded.scene->GetMeshes().size(), 2u) << loaded.said();
  }
}

TEST(GltfGeometry, PrimitivesWithoutAMaterialDoNotGetAnothers) {
  GltfBuilder b = two_primitives();
  b.json["meshes"][0]["primitives"][1].erase("material");
  EXPECT_EQ(only_mesh(b.load()).material, Path());
}

TEST(GltfGeometry, PrimitivesThatAMeshCannotHoldTogetherStayMeshes) {
  GltfBuilder cages = two_primitives(), modes = two_primitives();
  cages.json["extensionsUsed"] = {"FB_ngon_encoding"};
  cages.primitive()["extensions"]["FB_ngon_encoding"] = Json::object();
  modes.primitive()["mode"] = 1;
  const Loaded loaded = cages.load();
  ASSERT_EQ(loaded.scene->GetMeshes().size(), 2u) << loaded.said();
  EXPECT_EQ(loaded.scene->GetMeshes().begin()->first, Path("/gltf/made/nodes/0/0"));
  EXPECT_EQ(loaded.scene->GetMeshes().begin()->second.topology.geomSubsets.size(), 0u);
  EXPECT_EQ(modes.load().scene->GetMeshes().begin()->first, Path("/gltf/made/nodes/0/1")) << "beside lines";
}

// A cage is welded where its primitives meet, or the refined surface would have a crack there.
TEST(GltfGeometry, CagesOfSeveralPrimitivesAreWelded) {
  GltfBuilder b = two_primitives();
  b.json["extensionsUsed"] = {"FB_ngon_encoding"};
  for (Json& primitive : b.json["meshes"][0]["primitives"])
    primitive["extensions"]["FB_ngon_encoding"] = Json::object();
  const Loaded loaded = b.load();
  const host::MeshDescription& mesh = only_mesh(loaded);
  EXPECT_EQ(mesh.topology.faceVertexCounts, (Array<int32_t>{3, 3})) << "no polygon lies in two primitives";
  EXPECT_EQ(mesh.topology.faceVertexIndices, (Array<int32_t>{0, 1, 2, 0, 2, 3}));
  EXPECT_EQ(primvar<Array<Vec3f>>(mesh, "points").size(), 4u);
  ASSERT_EQ(mesh.topology.geomSubsets.size(), 2u);
  EXPECT_EQ(mesh.topology.geomSubsets[1].indices, (Array<int32_t>{1}));
}

// Meshes that differ in materials alone, and accessors that differ in their number alone: one geometry, decoded once.
TEST(GltfGeometry, MeshesOfEqualAccessorsShareTheirArrays) {
  GltfBuilder b;
  b.triangle();
  b.json["materials"] = {Json::object(), Json::object(), {{"doubleSided", true}}};
  b.json["accessors"].push_back(b.json["accessors"][b.primitive()["attributes"]["POSITION"].get<size_t>()]);
  const size_t copy = b.json["accessors"].size() - 1;
  const size_t other = b.add<float>({0, 0, 0, 2, 0, 0, 0, 2, 0}, "VEC3");
  const Json first = b.json["meshes"][0];
  const auto mesh = [&](size_t material, size_t positions) {
    Json made = first;
    made["primitives"][0]["material"] = material;
    if (positions) made["primitives"][0]["attributes"]["POSITION"] = positions;
    return made;
  };
  b.json["meshes"] = {mesh(0, 0), mesh(1, 0), mesh(1, copy), mesh(2, 0), mesh(0, other)};
  for (size_t m = 1; m < 5; ++m) {
    b.json["nodes"].push_back({{"mesh", m}});
    b.json["scenes"][0]["nodes"].push_back(m);
  }
  const Loaded loaded = b.load();
  ASSERT_EQ(loaded.scene->GetMeshes().size(), 5u) << loaded.said();
  std::vector<const host::MeshDescription*> meshes;
  for (const auto& [path, description] : loaded.scene->GetMeshes()) meshes.push_back(&description);
  const auto points = [&](size_t i) { return primvar<Array<Vec3f>>(*meshes[i], "points"); };
  for (const size_t shared : {1u, 2u}) {
    EXPECT_EQ(points(shared).data(), points(0).data()) << shared;
    EXPECT_EQ(meshes[shared]->topology.faceVertexIndices.data(), meshes[0]->topology.faceVertexIndices.data());
    EXPECT_NE(meshes[shared]->material, meshes[0]->material);
  }
  EXPECT_TRUE(meshes[3]->doubleSided);
  EXPECT_FALSE(meshes[0]->doubleSided);
  EXPECT_EQ(points(4)[1], Vec3f(2, 0, 0));
  EXPECT_EQ(points(0)[1], Vec3f(1, 0, 0));
  // The limit of memory counts what is decoded.
  GltfBuilder alone;
  alone.triangle();
  EXPECT_EQ(loaded.summary.memory_bytes, alone.load().summary.memory_bytes * 3);
}

/// Adds meshes that equal the first, and a node for each.
void repeat_mesh(GltfBuilder* b, size_t times) {
  for (size_t i = 0; i < times; ++i) {
    b->json["scenes"][0]["nodes"].push_back(b->json["nodes"].size());
    b->json["nodes"].push_back({{"mesh", b->json["meshes"].size()}});
    b->json["meshes"].push_back(Json(b->json["meshes"][0]));
  }
}

// A fault is reported for each mesh that has it, and costs no memory.
TEST(GltfGeometry, MeshesOfEqualAccessorsAndFaultsShareTheirArrays) {
  GltfBuilder b;
  b.attribute<float>("POSITION", {0, 0, 0, 1, 0, 0, 0, 1, 0, 5, 5, 5, 5, 5, 5, 5, 5, 5}, "VEC3");
  b.primitive()["extensions"]["FB_ngon_encoding"] = Json::object();
  b.json["extensionsUsed"] = {"FB_ngon_encoding"};
  b.json["meshes"][0]["primitives"].push_back(Json(b.primitive()));
  b.json["meshes"][0]["primitives"][1]["mode"] = 1;
  repeat_mesh(&b, 2);
  const Loaded loaded = b.load();
  ASSERT_EQ(loaded.scene->GetMeshes().size(), 3u) << loaded.said();
  const auto& meshes = loaded.scene->GetMeshes();
  for (const auto& [path, mesh] : meshes)
    EXPECT_EQ(primvar<Array<Vec3f>>(mesh, "points").data(),
              primvar<Array<Vec3f>>(meshes.begin()->second, "points").data())
        << path.str();
  for (const std::string mesh : {"meshes[0]", "meshes[1]", "meshes[2]"}) {
    EXPECT_TRUE(loaded.says(Severity::warning, mesh + ".primitives[0] 1 faces have no area")) << loaded.said();
    EXPECT_TRUE(loaded.says(Severity::warning, mesh + ".primitives[1].mode points and lines")) << loaded.said();
  }
}

// The limit of memory counts each shape of a mesh that is decoded.
TEST(GltfGeometry, ShapesOfOtherMorphWeightsCountByThemselves) {
  GltfBuilder b;
  b.triangle();
  b.primitive()["targets"] = {{{"POSITION", b.add<float>({1, 0, 0, 1, 0, 0, 1, 0, 0}, "VEC3")}}};
  b.json["meshes"][0]["weights"] = {0.25};
  repeat_mesh(&b, 2);
  const size_t one = b.load().summary.memory_bytes;
  for (size_t m = 0; m < 3; ++m) b.json["meshes"][m]["weights"][0] = 0.5 * double(m);
  const Loaded of_meshes = b.load();
  EXPECT_EQ(of_meshes.summary.memory_bytes, 3 * one) << of_meshes.said();
  std::set<float> places;
  for (const auto& [path, mesh] : of_meshes.scene->GetMeshes())
    places.insert(primvar<Array<Vec3f>>(mesh, "points")[0].x);
  EXPECT_EQ(places, (std::set<float>{0, 0.5f, 1}));
  GltfBuilder animated;
  animated.triangle();
  animated.primitive()["targets"] = {{{"POSITION", animated.add<float>({1, 0, 0, 1, 0, 0, 1, 0, 0}, "VEC3")}}};
  for (size_t n = 0; n < 3; ++n) {
    if (n > 0) animated.json["nodes"].push_back({{"mesh", 0}});
    animated.json["scenes"][0]["nodes"][n] = n;
    animated.animate(n, "weights", {0}, {float(n + 1)}, "SCALAR");
  }
  EXPECT_EQ(animated.load().summary.memory_bytes, one) << "it stands still";
  const Loaded posed = animated.load_at(0);
  EXPECT_EQ(posed.scene->GetMeshes().size(), 3u) << posed.said();
  EXPECT_GE(posed.summary.memory_bytes, 3 * one) << posed.said();
}

// A cube of assimp: normals that differ along its edges, below a marker that makes it a control mesh.
TEST(GltfGeometry, CagesWhoseNormalsHaveHardEdgesAreReported) {
  const auto said = [](bool hard, int level) {
    GltfBuilder b;
    // Two triangles that meet at a right angle, with vertices of their own.
    b.attribute<float>("POSITION", {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 1, 1, 0, 0}, "VEC3");
    const float s = std::sqrt(0.5f);
    const std::vector<float> edges{0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 1, 0, 0, 1, 0, 0, 1, 0};
    const std::vector<float> smooth{0, s, s, 0, s, s, 0, s, s, 0, s, s, 0, s, s, 0, s, s};
    b.attribute<float>("NORMAL", hard ? edges : smooth, "VEC3");
    b.primitive()["extensions"]["FB_ngon_encoding"] = Json::object();
    b.json["extensionsUsed"] = {"FB_ngon_encoding"};
    GltfOptions options;
    options.refine_level = level;
    return b.load(options).said();
  };
  EXPECT_NE(said(true, 2).find("the hard edges that its normals have at 2 of 4 points"), std::string::npos)
      << said(true, 2);
  EXPECT_NE(said(true, 2).find("\"scheme\": \"none\""), std::string::npos);
  EXPECT_EQ(said(false, 2).find("hard edges"), std::string::npos);
  EXPECT_EQ(said(true, 0).find("hard edges"), std::string::npos) << "it is not refined";
}

// The report says that the nearest legal value is used.
TEST(GltfLights, ColorsOutOfRangeAreTheNearestLegalOnes) {
  GltfBuilder b;
  b.triangle();
  b.json["extensionsUsed"] = {"KHR_lights_punctual"};
  b.json["extensions"]["KHR_lights_punctual"]["lights"] = {{{"type", "point"}, {"color", {2, -1, 0.5}}}};
  b.node()["extensions"]["KHR_lights_punctual"]["light"] = 0;
  const Loaded loaded = b.load();
  EXPECT_TRUE(loaded.says(Severity::warning, "lights[0].color[0] 2.0 is out of range")) << loaded.said();
  ASSERT_EQ(loaded.scene->GetLights().size(), 1u);
  EXPECT_EQ(loaded.scene->GetLights().begin()->second.parameters.at("color"), Value(Vec3f(1, 0, 0.5f)));
}

TEST(GltfScenes, AreChosenByNameAndIndex) {
  GltfBuilder b;
  b.triangle();
  for (const double x : {1.0, 2.0}) b.json["nodes"].push_back({{"mesh", 0}, {"translation", {x, 0, 0}}});
  b.json["scenes"] = {{{"nodes", {0}}}, {{"nodes", {1}}, {"name", "other"}}};
  const auto x_of = [&](const std::string& scene) {
    GltfOptions options;
    options.scene = scene;
    const Loaded loaded = b.load(options);
    EXPECT_TRUE(loaded.summary.ok) << loaded.said();
    EXPECT_EQ(loaded.summary.scenes, (std::vector<std::string>{"", "other"}));
    return world_points(only_mesh(loaded))[0].x;
  };
  EXPECT_EQ(x_of(""), 0);
  EXPECT_EQ(x_of("1"), 1);
  EXPECT_EQ(x_of("other"), 1);
  b.json["scene"] = 1;
  EXPECT_EQ(x_of(""), 1);
  EXPECT_EQ(x_of("0"), 0);
  b.json.erase("scene");
  EXPECT_EQ(x_of(""), 0);  // a file without a default scene: its first
  GltfOptions options;
  for (const char* wrong : {"2", "Other", "-1", "1.5"}) {
    options.scene = wrong;
    const Loaded loaded = b.load(options);
    EXPECT_FALSE(loaded.summary.ok);
    EXPECT_TRUE(loaded.says(Severity::error, "gltf.choice")) << loaded.said();
    EXPECT_TRUE(loaded.says(Severity::error, "choose from 0, 1 'other'")) << loaded.said();
  }
  b.json.erase("scenes");
  EXPECT_EQ(b.load().scene->GetInstancers().begin()->second.indices.begin()->second.size(), 3u);  // every root
}

TEST(GltfVariants, DecideWhichMaterialAPrimitiveUses) {
  GltfBuilder b;
  b.triangle();
  b.json["materials"] = {{{"name", "own"}}, {{"name", "red"}}, {{"name", "blue"}}};
  b.json["extensionsUsed"] = {"KHR_materials_variants"};
  b.json["extensions"]["KHR_materials_variants"]["variants"] = {
      {{"name", "Red"}}, {{"name", "Sea"}}, {{"name", "Sky"}}, {{"name", "Bare"}}};
  b.primitive()["material"] = 0;
  b.primitive()["extensions"]["KHR_materials_variants"]["mappings"] = {{{"material", 1}, {"variants", {0}}},
                                                                       {{"material", 2}, {"variants", {1, 2}}}};
  const auto material = [&](const std::string& variant) {
    GltfOptions options;
    options.variant = variant;
    return only_mesh(b.load(options)).material.str();
  };
  EXPECT_EQ(material(""), "/gltf/made/materials/0_own");
  EXPECT_EQ(material("Red"), "/gltf/made/materials/1_red");
  EXPECT_EQ(material("Sky"), "/gltf/made/materials/2_blue");
  EXPECT_EQ(material("1"), "/gltf/made/materials/2_blue");
  EXPECT_EQ(material("Bare"), "/gltf/made/materials/0_own");
  EXPECT_EQ(b.load().summary.variants.size(), 4u);
  GltfOptions options;
  options.variant = "Green";
  EXPECT_TRUE(b.load(options).says(Severity::error, "has no variant 'Green'; choose from 0 'Red', 1 'Sea'"));
}

}  // namespace
}  // namespace alabaster::hd::gltf::testing
