// Fields by name are the members of the C++ types: prims made by members, and the same made by fields.
// doors/any_edits_test.cpp edits every field, and takes it back.
#include "delegate/host/scene_fields.h"

#include <gtest/gtest.h>

#include <set>

#include "testenv/unit/delegate/host/fields_fixture.h"
#include "testenv/unit/delegate/host/row_values.h"

namespace alabaster::hd::host {
namespace {

/// All fields of the table are among them, and together they make the prim.
template <class T>
void expect_members(const Token& kind, const T& prim, const Fields& fields, const std::string& prefix = "") {
  RetainedSceneDelegate scene;
  std::set<std::string> names;
  for (const auto& [name, value] : fields)
    if (name.starts_with(prefix)) names.insert(name.substr(prefix.size()));
  for (const FieldRow& row : FieldRows(prefix.empty() ? std::string(KindOf(prim)) : "product"))
    EXPECT_TRUE(names.contains(row.name)) << "no field " << row.name;
  ASSERT_EQ(SetPrim(&scene, "/it", kind, fields).fault, "");
  EXPECT_TRUE(std::get<T>(scene.GetPrims().at("/it")) == prim) << kind.str();
}

TEST(SceneFields, AreTheMembersOfAMesh) {
  MeshDescription mesh;
  mesh.topology.scheme = "loop", mesh.topology.orientation = "leftHanded";
  mesh.topology.faceVertexCounts = {3, 3}, mesh.topology.faceVertexIndices = {0, 1, 2, 2, 1, 3};
  mesh.topology.holeIndices = {0}, mesh.topology.invisibleFaces = {1};
  mesh.topology.geomSubsets = {GeomSubset{"a", "/wax", kInts}};
  mesh.subdivTags.interpolateBoundary = "edgeOnly", mesh.subdivTags.faceVaryingLinearInterpolation = "all";
  mesh.subdivTags.creaseMethod = "chaikin", mesh.subdivTags.triangleSubdivision = "smooth";
  mesh.subdivTags.creaseIndices = {0, 1}, mesh.subdivTags.creaseLengths = {2};
  mesh.subdivTags.creaseWeights = {3}, mesh.subdivTags.cornerIndices = {1}, mesh.subdivTags.cornerWeights = {4};
  mesh.displayStyle.refineLevel = 3;
  mesh.transform = kMoved, mesh.transformSamples = {{0, 1}, {kMoved, Matrix4d()}};
  mesh.visible = mesh.doubleSided = false;
  mesh.cullStyle = CullStyle::frontUnlessDoubleSided;
  mesh.material = "/wax", mesh.instancer = "/many", mesh.renderTag = "proxy", mesh.categories = {"a", "b"};
  const Value points = Array<Vec3f>(std::vector<Vec3f>(4, Vec3f(1)));
  const Value st = Array<Vec2f>(std::vector<Vec2f>(4, Vec2f(0)));
  mesh.primvars["points"].value = points, mesh.primvarSamples["points"] = {{0, 1}, {points, points}};
  mesh.primvars["st"] = {Interpolation::faceVarying, "textureCoordinate", st, kInts};
  mesh.primvars["holdout"] = {Interpolation::constant, {}, true, {}};
  expect_members(Token("mesh"), mesh,
                 {{"scheme", Token("loop")},
                  {"orientation", Token("leftHanded")},
                  {"faceVertexCounts", Array<int32_t>{3, 3}},
                  {"faceVertexIndices", Array<int32_t>{0, 1, 2, 2, 1, 3}},
                  {"holeIndices", Array<int32_t>{0}},
                  {"invisibleFaces", Array<int32_t>{1}},
                  {"subsets:a:faces", kInts},
                  {"subsets:a:material", Path("/wax")},
                  {"interpolateBoundary", Token("edgeOnly")},
                  {"faceVaryingLinearInterpolation", Token("all")},
                  {"creaseMethod", Token("chaikin")},
                  {"triangleSubdivision", Token("smooth")},
                  {"creaseIndices", Array<int32_t>{0, 1}},
                  {"creaseLengths", Array<int32_t>{2}},
                  {"creaseWeights", Array<float>{3}},
                  {"cornerIndices", Array<int32_t>{1}},
                  {"cornerWeights", Array<float>{4}},
                  {"refineLevel", 3},
                  {"transform", kMoved},
                  {"transform:samples", samples(kMoved, Matrix4d())},
                  {"visible", false},
                  {"doubleSided", false},
                  {"cullStyle", "frontUnlessDoubleSided"},
                  {"material", Path("/wax")},
                  {"instancer", Path("/many")},
                  {"renderTag", "proxy"},
                  {"categories", words({"a", "b"})},
                  {"primvars:points", points},
                  {"primvars:points:samples", samples(points, points)},
                  {"primvars:st", st},
                  {"primvars:st:interpolation", "faceVarying"},
                  {"primvars:st:role", "textureCoordinate"},
                  {"primvars:st:indices", kInts},
                  {"primvars:holdout", true},
                  {"primvars:holdout:interpolation", "constant"}});
}

TEST(SceneFields, AreTheMembersOfInstancersLightsAndCameras) {
  InstancerDescription many;
  const Value scales = Array<Vec3f>{Vec3f(1)};
  many.transform = kMoved, many.transformSamples = {{0, 1}, {kMoved, Matrix4d()}}, many.parent = "/outer";
  many.primvars["hydra:instanceScales"] = scales,
  many.primvarSamples["hydra:instanceScales"] = {{0, 1}, {scales, scales}};
  many.primvars["tint"] = scales, many.primvarRoles["tint"] = "color";
  many.indices["/quad"] = kInts, many.categories = {{"near"}};
  expect_members(Token("instancer"), many,
                 {{"transform", kMoved},
                  {"transform:samples", samples(kMoved, Matrix4d())},
                  {"parent", Path("/outer")},
                  {"primvars:hydra:instanceScales", scales},
                  {"primvars:hydra:instanceScales:samples", samples(scales, scales)},
                  {"primvars:tint", scales},
                  {"primvars:tint:role", "color"},
                  {"prototypes:/quad", kInts},
                  {"categories:near", Array<int32_t>{0}}});
  for (const char* type : kLightTypes) {
    LightDescription light{.type = type, .transform = kMoved, .parameters = {{"lightLink", Token("a")}}};
    light.visible = false, light.transformSamples = {{0, 1}, {kMoved, Matrix4d()}};
    Fields fields{{"transform", kMoved},
                  {"transform:samples", samples(kMoved, Matrix4d())},
                  {"visible", false},
                  {"lightLink", Token("a")}};
    for (const FieldRow& row : ParameterRows("lights"))
      fields.emplace_back(row.name, light.parameters[row.name] = good_value(row));
    expect_members(Token(type), light, fields);
  }
  CameraDescription camera;
  camera.transform = kMoved, camera.transformSamples = {{0, 1}, {kMoved, Matrix4d()}};
  Fields fields{{"transform", kMoved}, {"transform:samples", samples(kMoved, Matrix4d())}};
  for (const FieldRow& row : ParameterRows("camera"))
    fields.emplace_back(row.name, camera.parameters[row.name] = good_value(row));
  for (const char* name : {"focalLength:samples", "fStop:samples", "focusDistance:samples"})
    fields.emplace_back(name, camera.parameters[name] = samples(2.0f, 3.0f));
  expect_members(Token("camera"), camera, fields);
  CameraDescription free;
  EXPECT_EQ(ReadCamera(fields, &free), "");
  EXPECT_TRUE(free == camera);
}

TEST(SceneFields, AreTheMembersOfSettingsAndProducts) {
  RenderSettingsDescription settings;
  settings.camera = "/camera", settings.width = 64, settings.height = 48, settings.pixelAspectRatio = 2;
  settings.windowPolicy = WindowPolicy::dontConform, settings.crop = Rect2i{1, 2, 3, 4}, settings.frame = 7.5;
  settings.includedPurposes = {"proxy"}, settings.settings["samples"] = 3;
  const Fields plain{{"camera", Path("/camera")},
                     {"width", 64},
                     {"height", int64_t(48)},
                     {"pixelAspectRatio", 2.0},
                     {"windowPolicy", "dontConform"},
                     {"crop", Array<int32_t>{1, 2, 3, 4}},
                     {"frame", 7.5},
                     {"includedPurposes", words({"proxy"})},
                     {"samples", 3}};
  expect_members(Token("renderSettings"), settings, plain);
  RenderProduct& product = settings.products.emplace_back();
  product.file = "b.exr", product.dataType = "float", product.compression = "piz", product.tiles = 64,
  product.colorSpace = "s", product.display = "d";
  product.view = "v", product.look = "l", product.exposure = 2, product.denoise = false, product.camera = "/other";
  product.width = 8, product.height = 9, product.disableMotionBlur = product.disableDepthOfField = true;
  product.vars = {{"a", "normal", "float"}};
  Fields fields{
      {"products:0:file", "b.exr"},    {"products:0:dataType", "float"},       {"products:0:compression", "piz"},
      {"products:0:tiles", 64},        {"products:0:colorSpace", Token("s")},  {"products:0:display", Token("d")},
      {"products:0:view", Token("v")}, {"products:0:look", Token("l")},        {"products:0:exposure", 2},
      {"products:0:denoise", false},   {"products:0:camera", Path("/other")},  {"products:0:width", 8},
      {"products:0:height", 9},        {"products:0:disableMotionBlur", true}, {"products:0:disableDepthOfField", true},
      {"products:0:vars:a", "normal"}, {"products:0:vars:a:dataType", "float"}};
  fields.insert(fields.end(), plain.begin(), plain.end());
  expect_members(Token("renderSettings"), settings, fields, "products:0:");
  RetainedSceneDelegate scene;
  ASSERT_EQ(
      SetPrim(&scene, "/it", "renderSettings", {{"products:1:file", "b.exr"}, {"products:0:file", "a.exr"}}).fault, "");
  ASSERT_EQ(EditPrim(&scene, "/it", {{"products:0:file", {}}}).fault, "");
  ASSERT_EQ(scene.GetAllRenderSettings().at("/it").products.size(), 1u);
  EXPECT_EQ(scene.GetAllRenderSettings().at("/it").products[0].file, "b.exr");
  for (const auto& [field, says] :
       {std::pair{"products:1:width", "'products:1' has no file"}, {"products:0:vars:z:dataType", "'z' has no AOV"}}) {
    const std::string fault = EditPrim(&scene, "/it", {{field, field[9] == '1' ? Value(8) : Value("half")}}).fault;
    EXPECT_NE(fault.find(says), std::string::npos) << fault;
  }
}

TEST(SceneFields, AreTheNodesOfAMaterial) {
  MaterialNetwork wax;
  wax.nodes["/it/wax"] = {"AlabasterDisney", {{"roughness", 0.25f}, {"baseColor", Vec3f(1, 0, 0)}}, {}};
  wax.nodes["/it/wax"].inputConnections["baseColor"] = {{"/it/image", "rgb"}, {"/it/other", ""}};
  wax.nodes["/it/image"] = {"AlabasterTexture", {{"file", AssetPath{"a.png", "a.png", nullptr}}}, {}};
  wax.nodes["/it/other"] = {"AlabasterPrimvar", {}, {}};
  wax.terminals["surface"] = {"/it/wax", "surface"}, wax.terminals["displacement"] = {"/it/image", "out"};
  expect_members(Token("material"), wax,
                 {{"wax.type", "AlabasterDisney"},
                  {"wax.roughness", 0.25f},
                  {"wax.baseColor", Vec3f(1, 0, 0)},
                  {"wax.baseColor", Array<Path>{"image.rgb", "other"}},
                  {"image.type", "AlabasterTexture"},
                  {"image.file", AssetPath{"a.png", "a.png", nullptr}},
                  {"other.type", "AlabasterPrimvar"},
                  {"surface", Path("wax.surface")},
                  {"displacement", "image"}});
}

}  // namespace
}  // namespace alabaster::hd::host
