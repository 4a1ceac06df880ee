// A row for each field of each kind: the member that it sets, the bits that its edit marks, and that its default comes
// back.
#include "delegate/host/scene_fields.h"

#include <gtest/gtest.h>

#include <functional>
#include <set>

#include "testenv/unit/delegate/host/fields_fixture.h"
#include "testenv/unit/delegate/host/row_values.h"

namespace alabaster::hd::host {
namespace {

template <class T>
struct Row {
  std::string name;
  Value value;
  DirtyBits marks;
  std::function<bool(const T&)> is_set;
};

/// Each row by itself: scene_set, scene_edit, the same again, and back to the default.
template <class T>
void check(const Token& kind, const Fields& plain, const std::vector<Row<T>>& rows) {
  const Path path = "/prim";
  DrawnScene s;
  const auto now = [&]() -> const T& { return std::get<T>(s.scene.GetPrims().at(path)); };
  for (const Row<T>& row : rows) {
    SCOPED_TRACE(kind.str() + ": " + row.name);
    s.set(path, kind, plain);
    const T before = now();
    EXPECT_FALSE(row.is_set(before)) << "the value differs from the default";
    EXPECT_EQ(s.edit(path, {{row.name, row.value}}), row.marks);
    EXPECT_TRUE(row.is_set(now()));
    const T edited = now();
    EXPECT_EQ(s.edit(path, {{row.name, row.value}}), dirty::kClean) << "the same value again";
    EXPECT_EQ(s.edit(path, {{row.name, {}}}), row.marks);
    EXPECT_TRUE(now() == before);
    Fields fields = plain;
    fields.emplace_back(row.name, row.value);
    s.set(path, kind, fields);
    EXPECT_TRUE(now() == edited) << "set at once is as set and edited";
  }
}

using Names = std::set<std::string>;
template <class T>
Names names_of(const std::vector<Row<T>>& rows, const std::string& prefix = "") {
  Names names;
  for (const Row<T>& row : rows)
    if (row.name.starts_with(prefix)) names.insert(row.name.substr(prefix.size()));
  return names;
}
Names rows_of_table(const std::string& kind) {
  Names names;
  for (const FieldRow& row : FieldRows(kind)) names.insert(row.name);
  EXPECT_GT(names.size(), 1u) << kind;
  return names;
}
void expect_all(const Names& wanted, const Names& tested) {
  for (const std::string& name : wanted) EXPECT_TRUE(tested.contains(name)) << "no row for " << name;
}

template <class T, class Outer, class Member>
auto is(T Outer::*outer, Member T::*member, Member value) {
  return [=](const Outer& prim) { return prim.*outer.*member == value; };
}
template <class T, class Member>
auto is(Member T::*member, Member value) {
  return [=](const T& prim) { return prim.*member == value; };
}

using Mesh = MeshDescription;

std::vector<Row<Mesh>> rows_of_faces() {
  const auto topology = [](auto member, auto value) { return is(&Mesh::topology, member, value); };
  const auto tags = [](auto member, auto value) { return is(&Mesh::subdivTags, member, value); };
  return {
      {"scheme", Token("loop"), dirty::kTopology, topology(&MeshTopology::scheme, Token("loop"))},
      {"orientation", Token("leftHanded"), dirty::kTopology, topology(&MeshTopology::orientation, Token("leftHanded"))},
      {"faceVertexCounts", kInts, dirty::kTopology, topology(&MeshTopology::faceVertexCounts, kInts)},
      {"faceVertexIndices", kInts, dirty::kTopology, topology(&MeshTopology::faceVertexIndices, kInts)},
      {"holeIndices", kInts, dirty::kTopology, topology(&MeshTopology::holeIndices, kInts)},
      {"invisibleFaces", kInts, dirty::kTopology, topology(&MeshTopology::invisibleFaces, kInts)},
      {"interpolateBoundary", Token("edgeOnly"), dirty::kSubdivTags,
       tags(&SubdivTags::interpolateBoundary, Token("edgeOnly"))},
      {"faceVaryingLinearInterpolation", Token("all"), dirty::kSubdivTags,
       tags(&SubdivTags::faceVaryingLinearInterpolation, Token("all"))},
      {"creaseMethod", Token("chaikin"), dirty::kSubdivTags, tags(&SubdivTags::creaseMethod, Token("chaikin"))},
      {"triangleSubdivision", Token("smooth"), dirty::kSubdivTags,
       tags(&SubdivTags::triangleSubdivision, Token("smooth"))},
      {"creaseIndices", kInts, dirty::kSubdivTags, tags(&SubdivTags::creaseIndices, kInts)},
      {"creaseLengths", kInts, dirty::kSubdivTags, tags(&SubdivTags::creaseLengths, kInts)},
      {"creaseWeights", kFloats, dirty::kSubdivTags, tags(&SubdivTags::creaseWeights, kFloats)},
      {"cornerIndices", kInts, dirty::kSubdivTags, tags(&SubdivTags::cornerIndices, kInts)},
      {"cornerWeights", kFloats, dirty::kSubdivTags, tags(&SubdivTags::cornerWeights, kFloats)},
      {"refineLevel", 3, dirty::kDisplayStyle, is(&Mesh::displayStyle, &DisplayStyle::refineLevel, 3)},
      {"subsets:a:faces", kInts, dirty::kTopology,
       [](const Mesh& mesh) {
         const auto& subsets = mesh.topology.geomSubsets;
         return subsets.size() == 1 && subsets[0].id == Path("a") && subsets[0].indices == kInts;
       }},
  };
}

std::vector<Row<Mesh>> rows_of_meshes() {
  return {
      {"transform", kMoved, dirty::kTransform, is(&Mesh::transform, kMoved)},
      {"transform:samples", samples(kMoved, Matrix4d()), dirty::kTransform,
       [](const Mesh& mesh) {
         return mesh.transformSamples == TimeSamples<Matrix4d>{{0, 1}, {kMoved, Matrix4d()}};
       }},
      {"visible", false, dirty::kVisibility, is(&Mesh::visible, false)},
      {"doubleSided", false, dirty::kDoubleSided, is(&Mesh::doubleSided, false)},
      {"cullStyle", "frontUnlessDoubleSided", dirty::kCullStyle,
       is(&Mesh::cullStyle, CullStyle::frontUnlessDoubleSided)},
      {"material", Path("/wax"), dirty::kMaterialId, is(&Mesh::material, Path("/wax"))},
      {"instancer", Path("/many"), dirty::kInstancer | dirty::kInstanceIndex, is(&Mesh::instancer, Path("/many"))},
      {"renderTag", "proxy", dirty::kRenderTag, is(&Mesh::renderTag, Token("proxy"))},
      {"categories", words({"a", "b"}), dirty::kCategories, is(&Mesh::categories, std::vector<Token>{"a", "b"})},
      {"primvars:points", Array<Vec3f>{Vec3f(1)}, dirty::kPoints,
       [](const Mesh& mesh) { return mesh.primvars.at("points").value == Value(Array<Vec3f>{Vec3f(1)}); }},
      {"primvars:normals", Array<Vec3f>{Vec3f(1)}, dirty::kNormals | dirty::kPrimvar,
       [](const Mesh& mesh) { return mesh.primvars.contains("normals"); }},
      {"primvars:a:b", 0.5f, dirty::kPrimvar, [](const Mesh& mesh) { return mesh.primvars.contains("a:b"); }},
      {"primvars:st:indices", kInts, dirty::kPrimvar,
       [](const Mesh& mesh) { return mesh.primvars.at("st").indices == kInts; }},
      {"primvars:st:interpolation", "faceVarying", dirty::kPrimvar,
       [](const Mesh& mesh) { return mesh.primvars.at("st").interpolation == Interpolation::faceVarying; }},
      {"primvars:st:role", "textureCoordinate", dirty::kPrimvar,
       [](const Mesh& mesh) { return mesh.primvars.at("st").role == Token("textureCoordinate"); }},
  };
}

TEST(SceneFields, MeshFieldsArriveInTheScene) {
  std::vector<Row<Mesh>> rows = rows_of_faces();
  for (Row<Mesh>& row : rows_of_meshes()) {
    if (row.name == "primvars:points")
      row.is_set = [is_set = row.is_set](const Mesh& mesh) { return mesh.primvars.contains("points") && is_set(mesh); };
    rows.push_back(std::move(row));
  }
  expect_all(rows_of_table("mesh"), names_of(rows));
  check<Mesh>(Token("mesh"), {{"primvars:st", Array<Vec2f>{Vec2f(0)}}}, rows);
  const Value points = Array<Vec3f>{Vec3f(1)};
  check<Mesh>(Token("mesh"), {{"primvars:points", points}},
              {{"primvars:points:samples", samples(points, points), dirty::kPoints,
                [](const Mesh& mesh) { return mesh.primvarSamples.contains("points"); }}});
  check<Mesh>(Token("mesh"), {{"subsets:a:faces", kInts}},
              {{"subsets:a:material", Path("/wax"), dirty::kTopology,
                [](const Mesh& mesh) { return mesh.topology.geomSubsets[0].materialId == Path("/wax"); }}});
}

TEST(SceneFields, OptionsOfMeshesAreConstantPrimvars) {
  DrawnScene drawn;
  drawn.set("/m", "mesh", {{"primvars:points", Array<Vec3f>{Vec3f(1)}}, {"holdout", true}});
  const auto primvars = [&] { return drawn.scene.GetMeshes().at("/m").primvars; };
  EXPECT_EQ(primvars().at("holdout"), (PrimvarValue{Interpolation::constant, {}, true, {}}));
  EXPECT_EQ(drawn.edit("/m", {{"subsurfaceSet", Token("all")}}), dirty::kPrimvar);
  EXPECT_EQ(primvars().at("subsurfaceSet").value, Value(Token("all")));
  EXPECT_EQ(drawn.edit("/m", {{"holdout", Value()}}), dirty::kPrimvar);
  EXPECT_EQ(primvars().count("holdout"), 0u);
  EXPECT_EQ(EditPrim(&drawn.scene, "/m", {{"holdout", Token("yes")}}).fault,
            "'holdout' must be true or false, and is yes");
  EXPECT_EQ(EditPrim(&drawn.scene, "/m", {{"holdot", true}}).fault,
            "a mesh has no field 'holdot'; did you mean 'holdout'?");
}

TEST(SceneFields, InstancerFieldsArriveInTheScene) {
  using T = InstancerDescription;
  const std::vector<Row<T>> rows = {
      {"transform", kMoved, dirty::kTransform, is(&T::transform, kMoved)},
      {"transform:samples", samples(kMoved, Matrix4d()), dirty::kTransform,
       [](const T& it) { return it.transformSamples.times.size() == 2; }},
      {"parent", Path("/outer"), dirty::kInstancer | dirty::kInstanceIndex, is(&T::parent, Path("/outer"))},
      {"primvars:hydra:instanceScales", Array<Vec3f>{Vec3f(1)}, dirty::kPrimvar,
       [](const T& it) { return it.primvars.contains("hydra:instanceScales"); }},
      {"prototypes:/quad", kInts, dirty::kClean,  // its prototypes are marked
       [](const T& it) { return it.indices.contains("/quad") && it.indices.at("/quad") == kInts; }},
  };
  expect_all(rows_of_table("instancer"), names_of(rows));
  check(Token("instancer"), {}, rows);
  check(Token("instancer"), {{"primvars:hydra:instanceScales", Array<Vec3f>{Vec3f(1)}}},
        std::vector<Row<T>>{{"primvars:hydra:instanceScales:samples", samples(kFloats, kFloats), dirty::kPrimvar,
                             [](const T& it) { return it.primvarSamples.contains("hydra:instanceScales"); }}});
}

/// A parameter of lights or cameras, with a value beside the default.
template <class T>
Row<T> parameter(const std::string& name, const Value& value) {
  return {name, value, dirty::kParams | dirty::kResource, [name, value](const T& prim) {
            const auto found = prim.parameters.find(name);
            return found != prim.parameters.end() && found->second == value;
          }};
}

TEST(SceneFields, LightFieldsArriveInTheScene) {
  using T = LightDescription;
  std::vector<Row<T>> rows = {{"transform", kMoved, dirty::kTransform, is(&T::transform, kMoved)},
                              {"visible", false, dirty::kVisibility, is(&T::visible, false)}};
  for (const FieldRow& row : ParameterRows("lights")) rows.push_back(parameter<T>(row.name, good_value(row)));
  for (const char* name : {"lightLink", "shadowLink"}) rows.push_back(parameter<T>(name, Token("a")));
  expect_all(rows_of_table("light"), names_of(rows));
  for (const char* kind : {"rectLight", "domeLight"}) check(Token(kind), {}, rows);
  for (const char* kind : kLightTypes) {
    RetainedSceneDelegate scene;
    EXPECT_EQ(SetPrim(&scene, "/light", Token(kind), {}).fault, "");
    EXPECT_EQ(scene.GetLights().at("/light").type, Token(kind));
  }
}

TEST(SceneFields, CameraFieldsArriveInTheScene) {
  using T = CameraDescription;
  std::vector<Row<T>> rows = {{"transform", kMoved, dirty::kTransform, is(&T::transform, kMoved)},
                              {"transform:samples", samples(kMoved, Matrix4d()), dirty::kTransform,
                               [](const T& it) { return it.transformSamples.times.size() == 2; }}};
  for (const FieldRow& row : ParameterRows("camera")) {
    const Value value = good_value(row);
    rows.push_back(parameter<T>(row.name, value));
    CameraDescription free;
    EXPECT_EQ(ReadCamera({{row.name, value}}, &free), "");
    EXPECT_EQ(free.parameters.at(row.name), value);
  }
  expect_all(rows_of_table("camera"), names_of(rows));
  check(Token("camera"), {}, rows);
}

using Settings = RenderSettingsDescription;

template <class Member>
Row<Settings> product(const char* name, Member RenderProduct::*member, const Value& given, Member value) {
  return {std::string("products:0:") + name, given, dirty::kParams,
          [=](const Settings& it) { return it.products[0].*member == value; }};
}

TEST(SceneFields, RenderSettingsFieldsArriveInTheScene) {
  const std::vector<Row<Settings>> rows = {
      {"camera", Path("/camera"), dirty::kParams, is(&Settings::camera, Path("/camera"))},
      {"width", 64, dirty::kParams, is(&Settings::width, 64)},
      {"height", int64_t(48), dirty::kParams, is(&Settings::height, 48)},
      {"pixelAspectRatio", 2.0, dirty::kParams, is(&Settings::pixelAspectRatio, 2.0f)},
      {"windowPolicy", "dontConform", dirty::kParams, is(&Settings::windowPolicy, WindowPolicy::dontConform)},
      {"crop", Array<int32_t>{1, 2, 3, 4}, dirty::kParams,
       is(&Settings::crop, std::optional<Rect2i>(Rect2i{1, 2, 3, 4}))},
      {"frame", 7.5, dirty::kParams, is(&Settings::frame, 7.5)},
      {"includedPurposes", words({"proxy"}), dirty::kParams,
       is(&Settings::includedPurposes, std::vector<Token>{"proxy"})},
      {"samples", 3, dirty::kParams,
       [](const Settings& it) { return it.settings.contains("samples") && it.settings.at("samples") == Value(3); }},
  };
  expect_all(rows_of_table("renderSettings"), names_of(rows));
  check(Token("renderSettings"), {}, rows);
}

TEST(SceneFields, ProductFieldsArriveInTheScene) {
  using P = RenderProduct;
  const Token word = "a";
  std::vector<Row<Settings>> rows = {
      product<std::string>("file", &P::file, "b.exr", "b.exr"),
      product<Token>("dataType", &P::dataType, "float", "float"),
      product<std::string>("colorSpace", &P::colorSpace, word, "a"),
      product<std::string>("display", &P::display, word, "a"),
      product<std::string>("view", &P::view, word, "a"),
      product<std::string>("look", &P::look, word, "a"),
      product<float>("exposure", &P::exposure, 2, 2),
      product<std::optional<bool>>("denoise", &P::denoise, false, false),
      product<Path>("camera", &P::camera, Path("/other"), "/other"),
      product<int>("width", &P::width, 8, 8),
      product<int>("height", &P::height, 8, 8),
      product<bool>("disableMotionBlur", &P::disableMotionBlur, true, true),
      product<bool>("disableDepthOfField", &P::disableDepthOfField, true, true),
      {"products:0:vars:a", "normal", dirty::kParams,
       [](const Settings& it) {
         const auto& vars = it.products[0].vars;
         return vars.size() == 2 && vars[1] == RenderVar{"a", "normal", "half"};
       }},
  };
  expect_all(rows_of_table("product"), names_of(rows, "products:0:"));
  rows.erase(rows.begin());  // without a file there is no product
  check(Token("renderSettings"), {{"products:0:file", "a.exr"}, {"products:0:vars:b", "depth"}}, rows);
  DrawnScene s;
  const auto products = [&] { return s.scene.GetAllRenderSettings().at("/settings").products; };
  s.set("/settings", Token("renderSettings"),
        {{"products:1:vars:a:dataType", "float"},
         {"products:1:file", "b.exr"},
         {"products:1:vars:a", "depth"},
         {"products:0:file", "a.exr"}});
  ASSERT_EQ(products().size(), 2u);
  EXPECT_EQ(products()[1].file, "b.exr");
  EXPECT_EQ(products()[1].vars, (std::vector<RenderVar>{{"a", "depth", "float"}}));
  EXPECT_EQ(s.edit("/settings", {{"products:0:file", {}}}), dirty::kParams);
  ASSERT_EQ(products().size(), 1u);
  EXPECT_EQ(products()[0].file, "b.exr");
  EXPECT_NE(EditPrim(&s.scene, "/settings", {{"products:1:width", 8}}).fault.find("'products:1' has no file"),
            std::string::npos);
  EXPECT_NE(EditPrim(&s.scene, "/settings", {{"products:0:vars:z:dataType", "half"}}).fault.find("'z' has no AOV"),
            std::string::npos);
}

TEST(SceneFields, MaterialFieldsArriveInTheScene) {
  using T = MaterialNetwork;
  const DirtyBits marks = dirty::kResource | dirty::kParams;
  const auto node = [](const T& it, const char* name) { return it.nodes.at(Path("/prim").append(name)); };
  const std::vector<MaterialConnection> one = {{"/prim/image", "rgb"}}, two = {one[0], {"/prim/other", ""}};
  check(Token("material"),
        {{"wax.type", "AlabasterDisney"}, {"image.type", "AlabasterTexture"}, {"other.type", "AlabasterPrimvar"}},
        std::vector<Row<T>>{
            {"wax.roughness", 0.25f, marks,
             [&](const T& it) { return node(it, "wax").parameters.contains("roughness"); }},
            {"wax.baseColor", Vec3f(1, 0, 0), marks,
             [&](const T& it) { return node(it, "wax").parameters.contains("baseColor"); }},
            {"wax.baseColor", Path("image.rgb"), marks,
             [&](const T& it) {
               const auto& connections = node(it, "wax").inputConnections;
               return connections.contains("baseColor") && connections.at("baseColor") == one;
             }},
            {"wax.baseColor", Array<Path>{"image.rgb", "other"}, marks,
             [&](const T& it) {
               const auto& connections = node(it, "wax").inputConnections;
               return connections.contains("baseColor") && connections.at("baseColor") == two;
             }},
            {"image.file", AssetPath{"a.png", "a.png", nullptr}, marks,
             [&](const T& it) { return node(it, "image").parameters.contains("file"); }},
            {"displacement", "image", marks, [](const T& it) { return it.terminals.contains("displacement"); }},
        });
}

}  // namespace
}  // namespace alabaster::hd::host
