// Effects of fields beyond their own row: prototypes, categories, surfaces, samples and faults.
#include "testenv/unit/delegate/host/fields_fixture.h"

namespace alabaster::hd::host {
namespace {

TEST(SceneFields, CategoriesAreOfInstances) {
  using Categories = std::vector<std::vector<Token>>;
  DrawnScene s;
  const auto now = [&] { return s.scene.GetInstancers().at("/many").categories; };
  s.set("/many", Token("instancer"),
        {{"categories:a", Array<int32_t>{2, 0}},
         {"categories:b", Array<int32_t>{2, 2}},
         {"primvars:hydra:instanceTranslations", Array<Vec3f>{Vec3f(0), Vec3f(1), Vec3f(2)}}});
  EXPECT_EQ(now(), (Categories{{"a"}, {}, {"a", "b"}}));
  EXPECT_EQ(s.edit("/many", {{"categories:a", Array<int32_t>{1}}}), dirty::kCategories);
  EXPECT_EQ(now(), (Categories{{}, {"a"}, {"b"}}));
  EXPECT_EQ(s.edit("/many", {{"categories:a", {}}, {"categories:b", {}}}), dirty::kCategories);
  for (const auto& of_one : now()) EXPECT_TRUE(of_one.empty());
  const SetResult beyond = EditPrim(&s.scene, "/many", {{"categories:a", Array<int32_t>{16777215}}});
  EXPECT_NE(beyond.fault.find("has no instance 16777215; there are 3"), std::string::npos) << beyond.fault;
}

TEST(SceneFields, TypesAreThoseOfTheTables) {
  const auto type = [](const char* kind, const char* name) { return TypeOfField(Token(kind), name); };
  const auto array_of = [](int32_t element) { return FieldType{element, true}; };
  const auto one = [](int32_t of) { return FieldType{of, false}; };
  EXPECT_EQ(type("mesh", "holeIndices"), array_of(ALABASTER_INT));
  EXPECT_EQ(type("mesh", "creaseWeights"), array_of(ALABASTER_FLOAT));
  EXPECT_EQ(type("mesh", "categories"), array_of(ALABASTER_TOKEN));
  EXPECT_EQ(type("mesh", "cullStyle"), one(ALABASTER_TOKEN));
  EXPECT_EQ(type("mesh", "primvars:uv:indices"), array_of(ALABASTER_INT));
  EXPECT_EQ(type("mesh", "subsets:/m/0:faces"), array_of(ALABASTER_INT));
  for (const char* any : {"primvars:uv", "primvars:indices", "primvars:uv:Faces", "leafCounts", ""})
    EXPECT_EQ(type("mesh", any), FieldType()) << any;
  EXPECT_EQ(type("instancer", "primvars:hydra:instanceRotations"), array_of(ALABASTER_QUATERNION));
  EXPECT_EQ(type("material", "image.type"), one(ALABASTER_TOKEN));
  EXPECT_EQ(type("material", "surface.baseColor"), FieldType());
  EXPECT_EQ(type("rectLight", "width"), one(ALABASTER_FLOAT));
  EXPECT_EQ(type("rectLight", "color"), one(ALABASTER_FLOAT3));
  EXPECT_EQ(type("domeLight", "texture:file"), one(ALABASTER_STRING));
  EXPECT_EQ(type("camera", "clipPlanes"), array_of(ALABASTER_FLOAT4));
  EXPECT_EQ(type("renderSettings", "width"), one(ALABASTER_INT));
  EXPECT_EQ(type("renderSettings", "crop"), array_of(ALABASTER_INT));
  EXPECT_EQ(type("renderSettings", "samples"), one(ALABASTER_UINT));
  EXPECT_EQ(type("", "width"), FieldType());  // lights and render settings differ
  EXPECT_EQ(type("", "transform"), one(ALABASTER_MATRIX));
  EXPECT_EQ(type("cloud", "transform"), FieldType());
}

TEST(SceneFields, InstancersKnowTheirPrimvars) {
  RetainedSceneDelegate scene;
  for (const char* name : {"primvars:hydra:instanceTranslation", "primvars:hydra:instanceTranslations:indices",
                           "primvars:tint:indices", "primvars:tint:samples"}) {
    const SetResult result = SetPrim(&scene, "/many", Token("instancer"), {{name, Array<Vec3f>{Vec3f(0)}}});
    EXPECT_NE(result.fault.find("has no field"), std::string::npos) << name;
  }
  const SetResult near =
      SetPrim(&scene, "/many", Token("instancer"), {{"primvars:hydra:instanceTranslation", Array<Vec3f>{Vec3f(0)}}});
  EXPECT_NE(near.fault.find("did you mean 'primvars:hydra:instanceTranslations'?"), std::string::npos) << near.fault;
}

TEST(SceneFields, PointsHaveNoIndices) {
  RetainedSceneDelegate scene;
  const Array<Vec3f> points{Vec3f(0), Vec3f(1), Vec3f(2)};
  const auto fault = [&](const char* field, const Value& value) {
    return SetPrim(&scene, "/mesh", Token("mesh"), {{"primvars:points", points}, {field, value}}).fault;
  };
  EXPECT_NE(fault("primvars:points:indices", Array<int32_t>{2, 1, 0}).find("faceVertexIndices"), std::string::npos);
  EXPECT_NE(fault("primvars:points:interpolation", Token("uniform")).find("must be vertex"), std::string::npos);
  EXPECT_EQ(fault("primvars:points:indices", Array<int32_t>{}), "");
  EXPECT_EQ(fault("primvars:points:interpolation", Token("vertex")), "");
}

// As UsdLux names them.
TEST(SceneFields, ParametersOfLightsMayHaveTheNamespaceOfInputs) {
  RetainedSceneDelegate scene;
  const Fields fields{
      {"inputs:intensity", 2.0f}, {"inputs:shaping:cone:angle", 30.0f}, {"inputs:texture:file", "a.exr"}};
  ASSERT_EQ(SetPrim(&scene, "/light", Token("rectLight"), fields).fault, "");
  const auto held = scene.GetLights().at("/light").parameters;
  EXPECT_EQ(held.at("intensity"), Value(2.0f));
  EXPECT_EQ(held.at("shaping:cone:angle"), Value(30.0f));
  EXPECT_EQ(held.at("texture:file").text_or(""), "a.exr");
  ASSERT_EQ(EditPrim(&scene, "/light", {{"inputs:intensity", Value()}}).fault, "");
  EXPECT_FALSE(scene.GetLights().at("/light").parameters.contains("intensity"));
  EXPECT_EQ(TypeOfField("rectLight", "inputs:color"), (FieldType{ALABASTER_FLOAT3, false}));
  EXPECT_NE(EditPrim(&scene, "/light", {{"inputs:intensty", 1.0f}}).fault.find("'inputs:intensty'"), std::string::npos);
  EXPECT_NE(EditPrim(&scene, "/light", {{"inputs:intensity", "much"}}).fault, "");
  const Fields material{{"surface.type", Token("AlabasterDisney")}, {"surface.inputs:baseColor", Vec3f(1)}};
  EXPECT_EQ(SetPrim(&scene, "/m", Token("material"), material).fault,
            "node 'surface' has no input 'inputs:baseColor'; did you mean 'baseColor'?");
}

// A part before or behind the name, or none where one is due.
TEST(SceneFields, AMisspeltFieldNamesTheNearestWithAllItsParts) {
  DrawnScene s;
  s.set("/m", Token("material"), {{"wax.type", Token("AlabasterDisney")}});
  s.set("/mesh", Token("mesh"), {{"primvars:points", Array<Vec3f>{Vec3f(0)}}, {"primvars:st", Array<Vec2f>{Vec2f(0)}}});
  s.set("/light", Token("rectLight"), {});
  s.set("/many", Token("instancer"), {});
  s.set("/settings", Token("renderSettings"), {{"products:0:file", "a.exr"}});
  const struct {
    const char *prim, *field, *right;
  } cases[] = {{"/m", "baseColor", "wax.baseColor"},
               {"/m", "basecolour", "wax.baseColor"},
               {"/m", "inputs:roughness", "wax.roughness"},
               {"/m", "wax.inputs:roughnes", "roughness"},
               {"/m", "wx.roughness", "wax"},
               {"/mesh", "points", "primvars:points"},
               {"/mesh", "primvars:st:indicies", "primvars:st:indices"},
               {"/mesh", "subsets:a:face", "subsets:a:faces"},
               {"/mesh", "refineLevel:value", "refineLevel"},
               {"/light", "inputs:intensty", "intensity"},
               {"/light", "shaping:ies", "shaping:ies:file"},
               {"/light", "ies:file", "shaping:ies:file"},
               {"/many", "protoypes:/quad", "prototypes:/quad"},
               {"/settings", "products:0:fil", "products:0:file"},
               {"/settings", "settings.samples", "samples"}};
  for (const auto& [prim, field, right] : cases) {
    const std::string fault = EditPrim(&s.scene, prim, {{field, 1.0f}}).fault;
    EXPECT_NE(fault.find("did you mean"), std::string::npos) << field << ": " << fault;
    EXPECT_NE(fault.find("'" + std::string(right) + "'?"), std::string::npos) << field << ": " << fault;
  }
}

TEST(SceneFields, AnEmptyWordIsTheDefault) {
  DrawnScene s;
  s.set("/mesh", Token("mesh"),
        {{"scheme", ""}, {"interpolateBoundary", ""}, {"cullStyle", ""}, {"material", ""}, {"subsets:a:material", ""}});
  EXPECT_EQ(s.scene.GetMeshes().at("/mesh").topology.scheme, Token("none"));
}

TEST(SceneFields, ATextureIsNoSurface) {
  RetainedSceneDelegate scene;
  const auto surface = [&] { return scene.GetMaterials().at("/a").terminals.at("surface").upstreamNode; };
  const Fields texture_first = {{"tex.type", "AlabasterTexture"}, {"wax.type", "AlabasterDisney"}};
  EXPECT_EQ(SetPrim(&scene, "/a", Token("material"), texture_first).fault, "");
  EXPECT_EQ(surface(), Path("/a/wax"));
  EXPECT_EQ(EditPrim(&scene, "/a", {{"surface", {}}}).fault, "");
  EXPECT_EQ(EditPrim(&scene, "/a", {{"wax.roughness", 0.5f}}).fault, "");
  EXPECT_FALSE(scene.GetMaterials().at("/a").terminals.contains("surface")) << "an edit chooses none";
  const SetResult constant = EditPrim(&scene, "/a", {{"wax.normal", "tex.rgb"}});
  EXPECT_NE(constant.fault.find("'wax.normal' must be connected"), std::string::npos) << constant.fault;
  EXPECT_EQ(EditPrim(&scene, "/a", {{"wax.normal", Path("tex.rgb")}}).fault, "");
}

TEST(SceneFields, TheSurfaceIsTheFirstNodeUnlessItIsNamed) {
  RetainedSceneDelegate scene;
  const auto surface = [&] { return scene.GetMaterials().at("/a").terminals.at("surface").upstreamNode; };
  EXPECT_EQ(
      SetPrim(&scene, "/a", Token("material"), {{"b.type", "AlabasterDisney"}, {"a.type", "AlabasterDisney"}}).fault,
      "");
  EXPECT_EQ(surface(), Path("/a/b"));
  EXPECT_EQ(EditPrim(&scene, "/a", {{"a.roughness", 0.5f}}).fault, "");
  EXPECT_EQ(surface(), Path("/a/b")) << "an edit does not choose another";
  EXPECT_EQ(EditPrim(&scene, "/a", {{"surface", "a"}}).fault, "");
  EXPECT_EQ(surface(), Path("/a/a"));
}

}  // namespace
}  // namespace alabaster::hd::host
