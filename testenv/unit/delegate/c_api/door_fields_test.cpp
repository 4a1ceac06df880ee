// Prims by named fields, through the C interface: refused fields change nothing, and the fields of each kind have an
// effect.
#include <OpenImageIO/imageio.h>
#include <unistd.h>

#include <filesystem>

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
    {"/settings", {"subsurface", word("auto")}, "'auto' of setting 'subsurface' has been removed; use 'walk'"},
    {"/settings",
     {"inversion", word("vanDeHulst")},
     "'vanDeHulst' of setting 'inversion' has been removed; use 'exact'"},
    {"/settings", {"walkWeights", word("throughput")}, "'walkWeights' has been removed; leave it out"},
    {"/settings", {"rouletteDepth", whole(kInts[3])}, "'rouletteDepth' has been removed; leave it out"},
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

TEST_F(DoorFields, CategoriesLinkLights) {
  const char* const near[] = {"near"};
  const float lit = centre(render())[0];
  EXPECT_GT(lit, 0);
  ASSERT_EQ(edit(scene_, "/dome", {{"lightLink", word("near")}}), ALABASTER_OK);
  EXPECT_EQ(centre(render())[0], 0);
  ASSERT_EQ(edit(scene_, "/quad", {{"categories", array(ALABASTER_TOKEN, near, 1)}}), ALABASTER_OK);
  EXPECT_EQ(centre(render())[0], lit);

  // By instance: the second one, in the middle, has the category.
  const float places[] = {-9, 0, 0, 0, 0, 0};
  ASSERT_EQ(set(scene_, "/many", "instancer",
                {{"primvars:hydra:instanceTranslations", array(ALABASTER_FLOAT3, places, 2)},
                 {"prototypes:/quad", array(ALABASTER_INT, kInts, 2)}}),
            ALABASTER_OK);
  ASSERT_EQ(set_quad({}, "/many"), ALABASTER_OK);
  EXPECT_EQ(centre(render())[0], 0);
  ASSERT_EQ(edit(scene_, "/many", {{"categories:near", array(ALABASTER_INT, &kInts[0], 1)}}), ALABASTER_OK);
  EXPECT_EQ(centre(render())[0], 0);
  ASSERT_EQ(edit(scene_, "/many", {{"categories:near", array(ALABASTER_INT, &kInts[1], 1)}}), ALABASTER_OK);
  EXPECT_EQ(centre(render())[0], lit);
  ASSERT_EQ(edit(scene_, "/many", {{"categories:near", {}}}), ALABASTER_OK);
  EXPECT_EQ(centre(render())[0], 0);
}

TEST_F(DoorFields, ClipPlanesCut) {
  // Each keeps what its first three numbers point to: a half, and a quarter of the quad.
  const float planes[] = {1, 0, 0, 0, 0, 1, 0, 0};
  const auto covered = [&] {
    const std::vector<float> pixels = render();
    float alpha = 0;
    for (size_t i = 3; i < pixels.size(); i += 4) alpha += pixels[i];
    return alpha;
  };
  const float whole_quad = covered();
  ASSERT_EQ(edit(scene_, "/camera", {{"clipPlanes", array(ALABASTER_FLOAT4, planes, 1)}}), ALABASTER_OK);
  EXPECT_NEAR(covered(), whole_quad / 2, 0.1f * whole_quad);
  ASSERT_EQ(edit(scene_, "/camera", {{"clipPlanes", array(ALABASTER_FLOAT4, planes, 2)}}), ALABASTER_OK);
  EXPECT_NEAR(covered(), whole_quad / 4, 0.1f * whole_quad);
  ASSERT_EQ(edit(scene_, "/camera", {{"clipPlanes", {}}}), ALABASTER_OK);
  EXPECT_EQ(covered(), whole_quad);
  const auto place = at(0, 6);
  Fields free = camera(place);
  free.push_back({"clipPlanes", array(ALABASTER_FLOAT4, planes, 2)});
  frame_.free_camera = free.data(), frame_.free_camera_count = free.size();
  EXPECT_NEAR(covered(), whole_quad / 4, 0.1f * whole_quad) << "of a free camera";
}

// The quad stands in the middle when the shutter opens and is gone when it closes.
TEST_F(DoorFields, TheShutterSeesMotion) {
  const auto here = at(0), away = at(4);
  const AlabasterSample moving[] = {{0, matrix(here)}, {1, matrix(away)}};
  ASSERT_EQ(edit(scene_, "/quad", {{"transform:samples", samples(moving)}}), ALABASTER_OK);
  const auto middle = [&](float open, float close) {
    EXPECT_EQ(edit(scene_, "/camera", {{"shutterOpen", number(open)}, {"shutterClose", number(close)}}), ALABASTER_OK);
    return centre(render())[3];
  };
  EXPECT_EQ(middle(0, 0.01f), 1);
  EXPECT_EQ(middle(0.9f, 1), 0);
  set_samples(64);
  const float blurred = middle(0, 1);
  EXPECT_GT(blurred, 0.1f);
  EXPECT_LT(blurred, 0.9f);
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

/// Records into a folder of its own.
class DoorProducts : public DoorFields {
 protected:
  DoorProducts() { std::filesystem::create_directories(folder_); }
  ~DoorProducts() override { std::filesystem::remove_all(folder_); }
  std::string file(const char* name) const { return (folder_ / name).string(); }
  /// The coverage in the middle of a file, its last channel.
  static float coverage(const std::string& file) {
    const auto image = OIIO::ImageInput::open(file);
    if (!image) return -1;
    const auto& spec = image->spec();
    std::vector<float> pixels(size_t(spec.width) * size_t(spec.height) * size_t(spec.nchannels));
    EXPECT_TRUE(image->read_image(0, 0, 0, spec.nchannels, OIIO::TypeDesc::FLOAT, pixels.data()));
    return pixels[size_t((spec.height / 2 * spec.width + spec.width / 2 + 1) * spec.nchannels - 1)];
  }
  /// The files that were written.
  std::vector<std::string> record() {
    std::vector<std::string> written;
    const auto add = [](void* user, const char*, const AlabasterValue* value) {
      static_cast<std::vector<std::string>*>(user)->push_back(static_cast<const char*>(value->data));
    };
    EXPECT_EQ(api().record(delegate_, nullptr, add, &written), ALABASTER_OK) << api().last_error();
    return written;
  }

  const std::filesystem::path folder_ =
      std::filesystem::temp_directory_path() / ("door_products_" + std::to_string(getpid()));
};

TEST_F(DoorProducts, AreWrittenWithTheirLayers) {
  const std::string first = file("a.exr"), second = file("b.png");
  ASSERT_EQ(edit(scene_, "/settings",
                 {{"products:0:file", word(first.c_str())},
                  {"products:0:vars:color", word("color")},
                  {"products:0:vars:far", word("depth")},
                  {"products:0:vars:far:dataType", word("float")},
                  {"products:1:file", word(second.c_str())},
                  {"products:1:width", whole(8)},
                  {"products:1:height", whole(4)}}),
            ALABASTER_OK)
      << api().last_error();
  EXPECT_EQ(record(), (std::vector<std::string>{first, second}));
  const auto layers = OIIO::ImageInput::open(first), other = OIIO::ImageInput::open(second);
  ASSERT_TRUE(layers && other);
  const auto& names = layers->spec().channelnames;
  EXPECT_NE(std::find(names.begin(), names.end(), "far.Z"), names.end());
  EXPECT_EQ(std::pair(layers->spec().width, other->spec().width), std::pair(kSide, 8));
  EXPECT_EQ(other->spec().height, 4);
}

TEST_F(DoorProducts, PurposesSelectMeshes) {
  const std::string picture = file("a.exr");
  ASSERT_EQ(edit(scene_, "/quad", {{"renderTag", word("proxy")}}), ALABASTER_OK);
  ASSERT_EQ(edit(scene_, "/settings", {{"products:0:file", word(picture.c_str())}}), ALABASTER_OK);
  record();
  EXPECT_EQ(coverage(picture), 0);
  const char* const purposes[] = {"default", "proxy"};
  ASSERT_EQ(edit(scene_, "/settings", {{"includedPurposes", array(ALABASTER_TOKEN, purposes, 2)}}), ALABASTER_OK);
  record();
  EXPECT_EQ(coverage(picture), 1);
}

}  // namespace
}  // namespace alabaster::c_api_testing
