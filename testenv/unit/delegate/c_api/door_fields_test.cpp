// Prims by named fields, through the C interface: refused fields change nothing, and the fields of each kind have an
// effect.
#include "testenv/support/build_paths.h"
#include "testenv/unit/delegate/c_api/door_fixture.h"

namespace alabaster::c_api_testing {
namespace {

constexpr int32_t kInts[] = {0, 1, 2, 3};
constexpr float kZeros[16] = {};
constexpr uint8_t kOff = 0;

class DoorFields : public Door {
 protected:
  DoorFields() {
    EXPECT_EQ(set(scene_, "/many", "instancer"), ALABASTER_OK);
    EXPECT_EQ(set(scene_, "/wax", "material", {{"surface.type", word("AlabasterDisney")}}), ALABASTER_OK);
    EXPECT_EQ(set_settings(), ALABASTER_OK);
  }
  /// All prims, and the picture.
  std::pair<std::string, std::vector<float>> state() {
    std::string prims;
    const auto add = [](void* user, const char* name, const AlabasterValue* value) {
      *static_cast<std::string*>(user) += std::string(name) + " " + static_cast<const char*>(value->data) + "\n";
    };
    EXPECT_EQ(api().get_prims(scene_, add, &prims), ALABASTER_OK);
    return {prims, render()};
  }
  bool is_in_the_middle() { return centre(render())[3] > 0.5f; }
};

/// A field that is refused, and what last_error says.
struct Refused {
  const char* path;
  AlabasterParameter field;
  const char* says;
};

constexpr float kHalf = 0.5f, kNine = 9;
constexpr int32_t kMinus = -1;
const AlabasterValue kIntArray = array(ALABASTER_INT, kInts, 4), kFloatArray = array(ALABASTER_FLOAT, kZeros, 4);
const AlabasterSample kNumbers[] = {{0, number(kHalf)}, {1, number(kHalf)}};

const Refused kRefusedOfShapes[] = {
    {"/quad",
     {"faceVertexCounts", kFloatArray},
     "'faceVertexCounts' must be an array of int, and is an array of float"},
    {"/quad", {"creaseWeights", kIntArray}, "'creaseWeights' must be an array of float"},
    {"/quad", {"transform", number(kHalf)}, "'transform' must be a matrix"},
    {"/quad", {"transform:samples", samples(kNumbers)}, "'transform:samples' must be samples: matrices at times"},
    {"/camera", {"fStop:samples", number(kHalf)}, "'fStop:samples' must be samples: numbers at times"},
    {"/quad", {"material", number(kHalf)}, "'material' must be a path"},
    {"/quad", {"categories", word("a")}, "'categories' must be an array of texts"},
    {"/quad", {"primvars:points:interpolation", word("corner")}, "must be one of constant, uniform"},
    {"/quad",
     {"primvars:points:role", word("colour")},
     "'primvars:points:role' must be one of none, color, lin_rec709, vector"},
    {"/quad", {"primvars:points:indices", kFloatArray}, "must be an array of int"},
    {"/quad", {"primvars:points:samples", kFloatArray}, "must be samples: values at times"},
    {"/quad", {"primvars:st:indices", kIntArray}, "'primvars:st' has no value"},
    {"/quad", {"subsets:a:faces", kFloatArray}, "must be an array of int"},
    {"/quad", {"subsets:a:face", kIntArray}, "has no field 'subsets:a:face'"},
    {"/many", {"protoypes:/quad", kIntArray}, "an instancer has no field 'protoypes:/quad'"},
    {"/many", {"prototypes:/quad", kFloatArray}, "must be an array of int"},
    {"/many", {"categories:a", array(ALABASTER_INT, &kMinus, 1)}, "has no instance -1"},
    {"/many", {"primvars:hydra:instanceScales:samples", samples(kNumbers)}, "has samples, but no value"},
};
const Refused kRefusedOfLooks[] = {
    {"/wax", {"surface.baseColour", scalar(ALABASTER_FLOAT3, kZeros)}, "did you mean 'baseColor'?"},
    {"/wax", {"other.roughness", number(kHalf)}, "node 'other' has no type: set 'other.type'"},
    {"/wax", {"surface", word("other")}, "surface names /wax/other, which is no node of the material"},
    {"/wax", {"roughness", number(kHalf)}, "a material has no field 'roughness'"},
    {"/camera", {"clipPlanes", kFloatArray}, "'clipPlanes' must be an array of float4, and is an array of float"},
    {"/settings", {"width", whole(kMinus)}, "'width' must be a whole number from 1 to 1048576, and is -1"},
    {"/settings", {"windowPolicy", whole(1)}, "'windowPolicy' must be one of matchVertically, matchHorizontally"},
    {"/settings", {"crop", array(ALABASTER_INT, kInts, 3)}, "'crop' must be an array of the ints minX, minY"},
    {"/settings", {"products:0:fle", word("a.exr")}, "products:0:fle"},
    {"/settings", {"products:5000:file", word("a.exr")}, "there are at most 4096 products"},
    {"/settings",
     {"products:0:dataType", word("int")},
     "'products:0:dataType' must be one of half, float, uint8, uint16"},
    {"/settings", {"products:0:vars:a:dataType", word("uint8")}, "must be one of half, float, int"},
};

TEST_F(DoorFields, RefusedEditChangesNothing) {
  const auto before = state();
  std::vector<Refused> all(std::begin(kRefusedOfShapes), std::end(kRefusedOfShapes));
  all.insert(all.end(), std::begin(kRefusedOfLooks), std::end(kRefusedOfLooks));
  for (const auto& [path, field, text] : all) {
    SCOPED_TRACE(field.name);
    EXPECT_EQ(edit(scene_, path, {field}), ALABASTER_INVALID_ARGUMENT);
    EXPECT_TRUE(says(text)) << api().last_error();
    EXPECT_TRUE(says(path)) << api().last_error();
  }
  EXPECT_EQ(state(), before);
}

// Curves of hosts overshoot: the renderer warns, and uses the nearest value.
TEST_F(DoorFields, ParametersOutOfRangeAreWarnings) {
  const auto before = state();
  ASSERT_EQ(edit(scene_, "/dome", {{"intensity", number(-1)}}), ALABASTER_OK);
  EXPECT_EQ(centre(render())[0], 0);
  EXPECT_EQ(heard_, std::vector<std::string>{"parameter.range"});
  ASSERT_EQ(edit(scene_, "/dome", {{"intensity", {}}}), ALABASTER_OK);
  EXPECT_EQ(state(), before);
}

TEST_F(DoorFields, AnUnknownKindIsNamed) {
  const auto before = state();
  for (const auto& [kind, text] : {std::pair("mash", "there is no kind of prim 'mash'; did you mean 'mesh'?"),
                                   {"domelight", "did you mean 'domeLight'?"},
                                   {"", "there is no kind of prim ''"},
                                   {"renderBuffer", "there is no kind of prim 'renderBuffer'"}}) {
    EXPECT_EQ(set(scene_, "/quad", kind), ALABASTER_INVALID_ARGUMENT);
    EXPECT_TRUE(says(text)) << api().last_error();
  }
  EXPECT_EQ(set(scene_, "/quad", "domeLight", {{"radius", number(1)}, {"height", word("a")}}),
            ALABASTER_INVALID_ARGUMENT);
  EXPECT_EQ(state(), before) << "the mesh stays where its replacement is refused";
}

TEST_F(DoorFields, AnEditIsAllOrNone) {
  const auto before = state();
  const int32_t nine = 9;
  const AlabasterParameter hidden = {"visible", flag(kOff)}, wrong = {"refineLevel", whole(nine)};
  EXPECT_EQ(edit(scene_, "/quad", {hidden, wrong}), ALABASTER_INVALID_ARGUMENT);
  EXPECT_EQ(edit(scene_, "/quad", {wrong, hidden}), ALABASTER_INVALID_ARGUMENT);
  EXPECT_EQ(state(), before);
  EXPECT_EQ(edit(scene_, "/quad", {hidden, {"refineLevel", whole(1)}}), ALABASTER_OK);
  EXPECT_FALSE(is_in_the_middle());
  EXPECT_EQ(edit(scene_, "/quad", {}), ALABASTER_OK) << "nothing";
  EXPECT_FALSE(is_in_the_middle());
}

TEST_F(DoorFields, APrimvarIsTakenAway) {
  const auto before = state();
  const float red[] = {1, 0, 0};
  const char* const outputs[] = {"tint.rgb"};
  ASSERT_EQ(edit(scene_, "/wax",
                 {{"tint.type", word("AlabasterPrimvar")}, {"surface.baseColor", array(ALABASTER_PATH, outputs, 1)}}),
            ALABASTER_OK)
      << api().last_error();
  const auto plain = state();
  ASSERT_EQ(edit(scene_, "/quad",
                 {{"primvars:displayColor", array(ALABASTER_FLOAT3, red, 1)},
                  {"primvars:displayColor:interpolation", word("constant")}}),
            ALABASTER_OK);
  const auto tinted = centre(render());
  EXPECT_GT(tinted[0], 2 * tinted[1]);
  ASSERT_EQ(edit(scene_, "/quad", {{"primvars:displayColor", {}}}), ALABASTER_OK) << api().last_error();
  EXPECT_EQ(state(), plain);
  ASSERT_EQ(edit(scene_, "/wax", {{"surface.baseColor", {}}}), ALABASTER_OK) << "takes the connection away";
  EXPECT_EQ(state(), before);
  ASSERT_EQ(edit(scene_, "/quad", {{"primvars:points", {}}}), ALABASTER_OK);
  EXPECT_FALSE(is_in_the_middle());
}

TEST_F(DoorFields, ANodeIsTakenAwayByItsType) {
  ASSERT_EQ(edit(scene_, "/wax", {{"other.type", word("AlabasterDisney")}}), ALABASTER_OK);
  EXPECT_EQ(edit(scene_, "/wax", {{"surface.type", {}}}), ALABASTER_INVALID_ARGUMENT);
  EXPECT_TRUE(says("surface names /wax/surface, which is no node")) << api().last_error();
  EXPECT_EQ(edit(scene_, "/wax", {{"surface.type", {}}, {"surface", word("other")}}), ALABASTER_OK);
  EXPECT_EQ(edit(scene_, "/wax", {{"surface.roughness", number(0.5f)}}), ALABASTER_INVALID_ARGUMENT);
  EXPECT_TRUE(says("node 'surface' has no type")) << api().last_error();
}

// An edit of a prim that a file made checks the fields that the file set, too.
TEST_F(DoorFields, PrimsOfFilesCanBeEdited) {
  const std::string file = alabaster::testing::source_file("testenv/scenes/sample/sample.json");
  ASSERT_EQ(api().scene_load(scene_, file.c_str(), nullptr, nullptr), ALABASTER_OK) << api().last_error();
  std::vector<std::string> prims;
  const auto add = [](void* user, const char* name, const AlabasterValue*) {
    static_cast<std::vector<std::string>*>(user)->push_back(name);
  };
  ASSERT_EQ(api().get_prims(scene_, add, &prims), ALABASTER_OK);
  EXPECT_GT(prims.size(), 6u);
  for (const std::string& prim : prims) EXPECT_EQ(edit(scene_, prim.c_str(), {}), ALABASTER_OK) << api().last_error();
}

TEST_F(DoorFields, ACropAndASizeAreThoseOfTheFrame) {
  AlabasterFrame frame = {};
  frame.size = sizeof frame;
  frame.settings = "/settings";
  int32_t width = 0, height = 0;
  const int32_t crop[] = {2, 3, 9, 5};
  ASSERT_EQ(edit(scene_, "/settings", {{"width", whole(40)}, {"height", whole(30)}}), ALABASTER_OK);
  ASSERT_EQ(api().frame_size(delegate_, &frame, &width, &height), ALABASTER_OK) << api().last_error();
  EXPECT_EQ(std::pair(width, height), std::pair(40, 30));
  ASSERT_EQ(edit(scene_, "/settings", {{"crop", array(ALABASTER_INT, crop, 4)}}), ALABASTER_OK);
  ASSERT_EQ(api().frame_size(delegate_, &frame, &width, &height), ALABASTER_OK) << api().last_error();
  EXPECT_EQ(std::pair(width, height), std::pair(7, 2));
  ASSERT_EQ(edit(scene_, "/settings", {{"crop", {}}, {"width", {}}, {"height", {}}}), ALABASTER_OK);
  ASSERT_EQ(api().frame_size(delegate_, &frame, &width, &height), ALABASTER_OK) << api().last_error();
  EXPECT_EQ(std::pair(width, height), std::pair(1280, 720));
}

}  // namespace
}  // namespace alabaster::c_api_testing
