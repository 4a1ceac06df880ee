// The C interface beyond what the hosts of testenv/install do: wrong calls, struct sizes, lent memory, edits,
// cancelling.
#include <gtest/gtest.h>

#include <atomic>
#include <cstring>
#include <filesystem>
#include <map>
#include <string>
#include <thread>
#include <vector>

#include "testenv/unit/delegate/c_api/door_fixture.h"

namespace alabaster::c_api_testing {
namespace {

TEST(DoorVersion, NeitherZeroNorALaterVersionIsPromised) {
  EXPECT_EQ(alabaster_api(0), nullptr);
  EXPECT_EQ(alabaster_api(ALABASTER_API_VERSION + 1), nullptr);
  ASSERT_NE(alabaster_api(1), nullptr);
  EXPECT_EQ(alabaster_api(1)->size, sizeof(AlabasterApi));
}

TEST(DoorVersion, TheTableHasEveryFunction) {
  const auto* bytes = reinterpret_cast<const char*>(alabaster_api(1));
  for (size_t at = offsetof(AlabasterApi, versions); at < sizeof(AlabasterApi); at += sizeof(void*)) {
    const void* member = nullptr;
    std::memcpy(&member, bytes + at, sizeof member);
    EXPECT_NE(member, nullptr) << "member at " << at;
  }
}

TEST(DoorFieldTypes, AreThoseOfTheRows) {
  const AlabasterApi& api = *alabaster_api(1);
  int32_t type = -1, is_array = -1;
  EXPECT_EQ(api.field_type("mesh", "holeIndices", &type, &is_array), ALABASTER_OK);
  EXPECT_EQ(std::pair(type, is_array), std::pair(int32_t(ALABASTER_INT), 1));
  EXPECT_EQ(api.field_type(nullptr, "transform", &type, &is_array), ALABASTER_OK);
  EXPECT_EQ(std::pair(type, is_array), std::pair(int32_t(ALABASTER_MATRIX), 0));
  EXPECT_EQ(api.field_type("mesh", "none", &type, &is_array), ALABASTER_OK);
  EXPECT_EQ(std::pair(type, is_array), std::pair(int32_t(ALABASTER_NONE), 0));
  EXPECT_EQ(api.field_type("mesh", nullptr, &type, &is_array), ALABASTER_INVALID_ARGUMENT);
  EXPECT_EQ(api.field_type("mesh", "scheme", &type, nullptr), ALABASTER_INVALID_ARGUMENT);
}

TEST(DoorMedia, ColorsHaveAnAlbedo) {
  const AlabasterApi& api = *alabaster_api(1);
  double share = -1;
  EXPECT_EQ(api.absorbed_share(0.5, 0, &share), ALABASTER_OK);
  EXPECT_NEAR(share, 0.0886639, 1e-6);  // Chandrasekhar's half-space
  EXPECT_EQ(api.absorbed_share(0.5, 0, nullptr), ALABASTER_INVALID_ARGUMENT);
}

// The camera stands to the right; the quad is a proxy below a root.
TEST_F(Door, AFrameSelectsWhatIsDrawnAndFromWhere) {
  const std::vector<float> plain = render();
  EXPECT_GT(centre(plain)[3], 0);
  const auto aside = at(20, 6);
  const Fields aimed_past = camera(aside);
  frame_.free_camera = aimed_past.data(), frame_.free_camera_count = aimed_past.size();
  EXPECT_EQ(centre(render())[3], 0) << "looks past the quad";
  const AlabasterParameter misspelt = {"focalLenght", number(1)};
  frame_.free_camera = &misspelt, frame_.free_camera_count = 1;
  EXPECT_EQ(start(), ALABASTER_INVALID_ARGUMENT);
  EXPECT_TRUE(says("did you mean 'focalLength'?")) << api().last_error();
  frame_.free_camera = nullptr, frame_.free_camera_count = 0;
  const char *const tags[] = {"proxy"}, *const quad[] = {"/quad"};
  frame_.render_tags = array(ALABASTER_TOKEN, tags, 1);
  EXPECT_EQ(centre(render())[3], 0);
  frame_.render_tags = array(ALABASTER_TOKEN, tags, 0);
  EXPECT_EQ(render(), plain) << "an empty list: all";
  frame_.render_tags = {};
  frame_.excluded = array(ALABASTER_TOKEN, quad, 1);
  EXPECT_EQ(centre(render())[3], 0);
  frame_.excluded = {};
  frame_.roots = array(ALABASTER_TOKEN, quad, 1);
  EXPECT_EQ(render(), plain);
  const int32_t one = 1;
  frame_.roots = array(ALABASTER_INT, &one, 1);
  EXPECT_EQ(start(), ALABASTER_INVALID_ARGUMENT);
  EXPECT_NE(std::string(api().last_error()).find("roots has the wrong type"), std::string::npos);
}

TEST_F(Door, WrongCallsSayWhatIsWrong) {
  EXPECT_EQ(set(nullptr, "/a", "mesh"), ALABASTER_INVALID_ARGUMENT);
  EXPECT_TRUE(says("scene is null"));
  EXPECT_EQ(set(scene_, nullptr, "mesh"), ALABASTER_INVALID_ARGUMENT);
  EXPECT_TRUE(says("path is null"));
  EXPECT_EQ(set(scene_, "", "mesh"), ALABASTER_INVALID_ARGUMENT);
  EXPECT_TRUE(says("path is empty"));
  EXPECT_EQ(set(scene_, "/a", nullptr), ALABASTER_INVALID_ARGUMENT);
  EXPECT_TRUE(says("kind is null"));
  const AlabasterFrame unsized = {};
  EXPECT_EQ(api().pass_start(pass_, &unsized), ALABASTER_INVALID_ARGUMENT);
  EXPECT_TRUE(says("`size` is not set"));
  EXPECT_EQ(api().remove(scene_, "/missing"), ALABASTER_NOT_FOUND);
  EXPECT_TRUE(says("/missing"));
  EXPECT_EQ(edit(scene_, "/missing", {{"intensity", number(0.5f)}}), ALABASTER_NOT_FOUND);
  EXPECT_TRUE(says("/missing"));
  EXPECT_EQ(set_quad(array(77, &kSide, 1)), ALABASTER_INVALID_ARGUMENT);
  AlabasterPixels pixels = {};
  pixels.size = sizeof pixels;
  EXPECT_EQ(api().pixels_unmap(&pixels), ALABASTER_INVALID_ARGUMENT);
  std::vector<float> little(3);
  render();
  EXPECT_EQ(api().buffer_read(color_, little.data(), sizeof(float) * little.size(), 0), ALABASTER_INVALID_ARGUMENT);
  EXPECT_TRUE(says("4096 bytes"));
}

TEST_F(Door, EmptyNamesAreRefused) {
  for (const char* none : {static_cast<const char*>(nullptr), ""}) {
    EXPECT_EQ(set(scene_, "/l", "rectLight", {{none, number(1)}}), ALABASTER_INVALID_ARGUMENT);
    EXPECT_STREQ(api().last_error(), "a parameter has no name");
    EXPECT_EQ(edit(scene_, "/dome", {{none, number(1)}}), ALABASTER_INVALID_ARGUMENT);
    EXPECT_STREQ(api().last_error(), "a parameter has no name");
  }
  for (const char* nameless :
       {"primvars:", "primvars", "subsets:", "subsets:a", "subsets::faces", "primvars::indices"}) {
    EXPECT_EQ(edit(scene_, "/quad", {{nameless, array(ALABASTER_INT, &kSide, 1)}}), ALABASTER_INVALID_ARGUMENT)
        << nameless;
    EXPECT_TRUE(says("has no field")) << api().last_error();
  }
  for (const char* nameless : {"prototypes:", "categories:"})
    EXPECT_EQ(set(scene_, "/i", "instancer", {{nameless, array(ALABASTER_INT, &kSide, 1)}}), ALABASTER_INVALID_ARGUMENT)
        << nameless;
  for (const char* nameless : {".type", "a.", "a", "."})
    EXPECT_EQ(set(scene_, "/m", "material", {{nameless, word("AlabasterDisney")}}), ALABASTER_INVALID_ARGUMENT)
        << nameless;
  for (const char* nameless : {"products:", "products:0", "products:0:", "products:a:file", "products:0:vars:"})
    EXPECT_EQ(set(scene_, "/s", "renderSettings", {{nameless, word("a.exr")}}), ALABASTER_INVALID_ARGUMENT) << nameless;
  AlabasterValue value = number(1);
  for (const int32_t wrong : {-1, 3}) {
    value.is_array = wrong;
    EXPECT_EQ(edit(scene_, "/dome", {{"intensity", value}}), ALABASTER_INVALID_ARGUMENT);
    EXPECT_TRUE(says("is_array")) << api().last_error();
  }
}

TEST_F(Door, AHostThatKnowsLessOfAStructIsServed) {
  AlabasterProgress progress = {};
  progress.size = offsetof(AlabasterProgress, seconds);  // an older header ended here
  progress.seconds = -7;
  render();
  ASSERT_EQ(api().progress(delegate_, &progress), ALABASTER_OK);
  EXPECT_EQ(progress.fraction, 1);
  EXPECT_EQ(progress.seconds, -7);
}

// promise: embedding.arrays.c
TEST_F(Door, LentArraysAreGivenBackOnce) {
  int released = 0;
  std::vector<float> points = {-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0};
  AlabasterValue lent = array(ALABASTER_FLOAT3, points.data(), 4);
  lent.release = &count_release, lent.owner = &released;
  ASSERT_EQ(set_quad(lent), ALABASTER_OK);
  EXPECT_EQ(released, 0);
  ASSERT_EQ(set_quad({}), ALABASTER_OK);
  render();  // the snapshot that used them is replaced
  EXPECT_EQ(released, 1);

  lent.data = reinterpret_cast<const char*>(points.data()) + 1;  // a fault: the call fails, the array comes back
  EXPECT_EQ(set_quad(lent), ALABASTER_INVALID_ARGUMENT);
  EXPECT_EQ(released, 2);
}

TEST_F(Door, ValuesLentWithAFrameComeBackFromCallsThatFail) {
  int released = 0;
  const char* const tags[] = {"render"};
  frame_.size = sizeof frame_;
  frame_.render_tags = array(ALABASTER_TOKEN, tags, 1);
  frame_.render_tags.release = &count_release, frame_.render_tags.owner = &released;
  AlabasterBinding wrong = {};
  frame_.bindings = &wrong, frame_.binding_count = 1;
  EXPECT_EQ(api().pass_start(pass_, &frame_), ALABASTER_INVALID_ARGUMENT) << "no buffer";
  EXPECT_EQ(released, 1);
  int32_t width = 0, height = 0;
  EXPECT_EQ(api().frame_size(delegate_, &frame_, &width, &height), ALABASTER_OK);
  EXPECT_EQ(released, 2);
}

// Memory that the host writes into: it counts as edited each time it is lent, and is read by a start alone.
// promise: embedding.arrays.c
TEST_F(Door, EditedArraysAreReadAtEachStart) {
  int released = 0;
  std::vector<double> points = {-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0};
  AlabasterValue lent = array(ALABASTER_DOUBLE3, points.data(), 4);
  lent.is_array = ALABASTER_EDITED_ARRAY, lent.release = &count_release, lent.owner = &released;
  ASSERT_EQ(set_quad(lent), ALABASTER_OK);
  const auto there = render();
  EXPECT_EQ(centre(there)[3], 1);
  for (double& x : points) x += 50;
  EXPECT_EQ(render(), there) << "not lent again";
  ASSERT_EQ(set_quad(lent), ALABASTER_OK);
  EXPECT_EQ(released, 1);
  ASSERT_EQ(start(), ALABASTER_OK);
  for (double& x : points) x = 0;  // while it is built
  EXPECT_EQ(centre(render())[3], 0);
  ASSERT_EQ(set_quad({}), ALABASTER_OK);
  EXPECT_EQ(released, 2) << "no snapshot holds it";
}

TEST_F(Door, PicksAndSnapshots) {
  struct Heard {
    std::string path;
    int32_t face = -2, instances = -1;
    int count = 0;
  } heard;
  const auto visit = [](void* user, const AlabasterPick* pick) {
    auto& to = *static_cast<Heard*>(user);
    to = {pick->path, pick->face, int32_t(pick->instance_count), to.count + 1};
  };
  const AlabasterRect all = {0, 0, kSide, kSide};
  render();
  EXPECT_EQ(api().pick(pass_, &all, visit, &heard), ALABASTER_INVALID_ARGUMENT) << "primId is not bound";
  AlabasterBuffer *ids = nullptr, *faces = nullptr;
  ASSERT_EQ(api().buffer_create(delegate_, kSide, kSide, ALABASTER_INT32, &ids), ALABASTER_OK);
  ASSERT_EQ(api().buffer_create(delegate_, kSide, kSide, ALABASTER_INT32, &faces), ALABASTER_OK);
  const AlabasterBinding bindings[] = {{"color", color_}, {"primId", ids}, {"elementId", faces}};
  AlabasterFrame frame = {};
  frame.size = sizeof frame;
  frame.bindings = bindings, frame.binding_count = 3;
  frame.camera = "/camera";
  frame.width = frame.height = kSide;
  ASSERT_EQ(api().pass_start(pass_, &frame), ALABASTER_OK);
  ASSERT_EQ(api().pass_wait(pass_, -1, nullptr), ALABASTER_OK);
  ASSERT_EQ(api().pick(pass_, &all, visit, &heard), ALABASTER_OK) << api().last_error();
  EXPECT_EQ(heard.count, 1);
  EXPECT_EQ(heard.path, "/quad");
  EXPECT_EQ(heard.face, 0);
  EXPECT_EQ(heard.instances, 0);
  EXPECT_EQ(api().pick(pass_, nullptr, visit, &heard), ALABASTER_INVALID_ARGUMENT);

  const std::string file =
      std::filesystem::temp_directory_path() / ("door_snapshot_" + std::to_string(getpid()) + ".png");
  EXPECT_EQ(api().snapshot(pass_, file.c_str()), ALABASTER_OK) << api().last_error();
  EXPECT_TRUE(std::filesystem::remove(file));
  EXPECT_EQ(api().snapshot(pass_, "/nowhere/a.png"), ALABASTER_OUTPUT_FAILED);
  api().buffer_destroy(ids);
  api().buffer_destroy(faces);
}

TEST_F(Door, EditsShow) {
  const std::vector<float> lit = render();
  EXPECT_EQ(centre(lit)[3], 1);
  EXPECT_EQ(render(), lit);

  const float green[] = {0.1f, 0.8f, 0.1f}, red[] = {0.8f, 0.1f, 0.1f};
  ASSERT_EQ(set(scene_, "/wax", "material",
                {{"surface.type", word("AlabasterDisney")}, {"surface.baseColor", scalar(ALABASTER_FLOAT3, green)}}),
            ALABASTER_OK)
      << api().last_error();
  const auto tinted = centre(render());
  EXPECT_GT(tinted[1], 2 * tinted[0]);
  ASSERT_EQ(edit(scene_, "/wax", {{"surface.baseColor", scalar(ALABASTER_FLOAT3, red)}}), ALABASTER_OK);
  EXPECT_GT(centre(render())[0], 2 * centre(render())[1]);

  ASSERT_EQ(edit(scene_, "/quad", {{"visible", flag(0)}}), ALABASTER_OK);
  EXPECT_EQ(centre(render())[3], 0);
  ASSERT_EQ(edit(scene_, "/quad", {{"visible", flag(1)}}), ALABASTER_OK);
  EXPECT_EQ(centre(render())[3], 1);
  ASSERT_EQ(edit(scene_, "/quad", {{"transform", matrix(at(50))}}), ALABASTER_OK);
  EXPECT_EQ(centre(render())[3], 0);
  EXPECT_EQ(heard_, std::vector<std::string>{"mesh.material"});  // of the first picture: there was no /wax
}

TEST_F(Door, StopsFromAnotherThread) {
  set_samples(1 << 20);
  ASSERT_EQ(start(), ALABASTER_OK);
  std::thread other([&] { EXPECT_EQ(api().stop(delegate_), ALABASTER_OK); });
  int32_t over = 0, state = 0;
  EXPECT_EQ(api().pass_wait(pass_, -1, &over), ALABASTER_OK) << api().last_error();
  other.join();
  EXPECT_EQ(over, 1);
  EXPECT_EQ(api().pass_state(pass_, &state), ALABASTER_OK);
  EXPECT_EQ(state, ALABASTER_STOPPED);
}

TEST_F(Door, RecordCancelsAndReportsWhatItCannotWrite) {
  ASSERT_EQ(set_settings(), ALABASTER_OK);
  const std::string file =
      (std::filesystem::temp_directory_path() / ("door_record_" + std::to_string(getpid()) + ".exr")).string();
  const char* files[] = {file.c_str()};
  AlabasterRecordOptions options = {};
  options.size = sizeof options;
  options.files = files, options.file_count = 1;
  const auto count = [](void* user, const char*, const AlabasterValue*) { ++*static_cast<int*>(user); };
  int written = 0;
  EXPECT_EQ(api().record(delegate_, &options, count, &written), ALABASTER_OK) << api().last_error();
  EXPECT_EQ(written, 1);

  set_samples(1 << 20);
  options.progress = [](void*, const AlabasterProgress*) -> int32_t { return 0; };
  EXPECT_EQ(api().record(delegate_, &options, count, &written), ALABASTER_INTERRUPTED);
  std::filesystem::remove(file);

  files[0] = "/nowhere/at/all.exr";
  EXPECT_EQ(api().record(delegate_, &options, nullptr, nullptr), ALABASTER_OUTPUT_FAILED);
  EXPECT_NE(std::string(api().last_error()).find("/nowhere/at/all.exr"), std::string::npos);
}

TEST_F(Door, PixelsOutliveEverything) {
  const std::vector<float> seen = render();
  AlabasterPixels pixels = {};
  pixels.size = sizeof pixels;
  ASSERT_EQ(api().buffer_map(color_, &pixels), ALABASTER_OK);
  api().pass_destroy(std::exchange(pass_, nullptr));
  api().buffer_destroy(std::exchange(color_, nullptr));
  api().delegate_destroy(std::exchange(delegate_, nullptr));
  api().scene_destroy(std::exchange(scene_, nullptr));
  EXPECT_EQ(std::memcmp(pixels.data, seen.data(), seen.size() * sizeof(float)), 0);
  EXPECT_EQ(api().pixels_unmap(&pixels), ALABASTER_OK);
}

TEST_F(Door, ADisplayShowsPixelsInTheCallersMemory) {
  const std::vector<float> pixels = render();
  AlabasterDisplayOptions options = {};
  options.size = sizeof options;
  options.color_config = "built-in", options.view = "Nothing of the kind";
  AlabasterDisplay* display = nullptr;
  EXPECT_EQ(api().display_create(&options, &display), ALABASTER_INVALID_ARGUMENT);
  EXPECT_NE(std::string(api().last_error()).find("Nothing of the kind"), std::string::npos) << api().last_error();
  options.view = nullptr;
  ASSERT_EQ(api().display_create(&options, &display), ALABASTER_OK) << api().last_error();

  AlabasterMemory memory = {};
  memory.size = sizeof memory;
  memory.row_bytes = 4 * kSide, memory.format = ALABASTER_UNORM8_4, memory.display = display;
  EXPECT_EQ(api().buffer_show(color_, &memory), ALABASTER_NOT_FOUND) << "it has no size";
  EXPECT_EQ(memory.width, kSide);
  EXPECT_EQ(api().buffer_show(color_, &memory), ALABASTER_INVALID_ARGUMENT) << "it is null";
  std::vector<uint8_t> shown(4 * kSide * kSide), darker = shown;
  memory.pixels = shown.data();
  ASSERT_EQ(api().buffer_show(color_, &memory), ALABASTER_OK) << api().last_error();
  ASSERT_EQ(api().display_set_exposure(display, -2), ALABASTER_OK);
  memory.pixels = darker.data(), memory.shown = 0;
  ASSERT_EQ(api().buffer_show(color_, &memory), ALABASTER_OK) << api().last_error();
  const size_t middle = 4 * (kSide / 2 * kSide + kSide / 2);
  EXPECT_GT(pixels[middle], 0);
  EXPECT_GT(darker[middle], 0);
  EXPECT_GT(shown[middle], darker[middle]);
  EXPECT_EQ(api().display_set_exposure(display, 1e9), ALABASTER_INVALID_ARGUMENT);
  api().display_destroy(display);
}

// promise: embedding.threads.c
TEST_F(Door, ThreadsTakeTurns) {
  std::atomic<bool> over{false};
  std::thread editor([&] {
    for (int i = 0; !over; ++i) {
      EXPECT_EQ(edit(scene_, "/quad", {{"transform", matrix(at(i % 3))}}), ALABASTER_OK);
      EXPECT_EQ(set(scene_, "/lamp", "sphereLight", {{"transform", matrix(at(i % 3))}}), ALABASTER_OK);
      EXPECT_EQ(api().remove(scene_, "/lamp"), ALABASTER_OK);
    }
  });
  std::thread watcher([&] {
    std::vector<float> pixels(4 * kSide * kSide);
    while (!over) {
      api().buffer_read(color_, pixels.data(), pixels.size() * sizeof(float), 1);
      AlabasterProgress progress = {};
      progress.size = sizeof progress;
      EXPECT_EQ(api().progress(delegate_, &progress), ALABASTER_OK);
    }
  });
  for (int i = 0; i < 50; ++i) {
    set_samples(1 + i % 2);
    EXPECT_EQ(start(), ALABASTER_OK);
    EXPECT_EQ(api().pass_wait(pass_, 0.01, nullptr), ALABASTER_OK);
    AlabasterBuffer* other = nullptr;
    EXPECT_EQ(api().buffer_create(delegate_, 8, 8, ALABASTER_FLOAT32, &other), ALABASTER_OK);
    api().buffer_destroy(other);
  }
  over = true;
  editor.join();
  watcher.join();
}

TEST_F(Door, SettingsAndPrimsAreListed) {
  std::map<std::string, std::string> prims;
  const auto keep = [](void* user, const char* name, const AlabasterValue* value) {
    (*static_cast<std::map<std::string, std::string>*>(user))[name] = static_cast<const char*>(value->data);
  };
  ASSERT_EQ(api().get_prims(scene_, keep, &prims), ALABASTER_OK);
  EXPECT_EQ(prims,
            (std::map<std::string, std::string>{{"/camera", "camera"}, {"/dome", "domeLight"}, {"/quad", "mesh"}}));
  bool found = false;
  const auto look = [](void* user, const AlabasterSetting* setting) {
    if (std::string(setting->key) == "samples")
      *static_cast<bool*>(user) = setting->default_value.type != ALABASTER_NONE && *setting->documentation != 0;
  };
  ASSERT_EQ(api().get_settings(delegate_, look, &found), ALABASTER_OK);
  EXPECT_TRUE(found);
  int32_t samples = 0;
  const auto read = [](void* user, const char*, const AlabasterValue* value) {
    std::memcpy(user, value->data, sizeof(int32_t));
  };
  ASSERT_EQ(api().get_setting(delegate_, "samples", read, &samples), ALABASTER_OK);
  EXPECT_EQ(samples, 4);
}

}  // namespace
}  // namespace alabaster::c_api_testing
