// Contract 1.5, and 4.5 rule 10: windows of a frame, and bytes that depend on nothing but scene, settings and samples.
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdio>
#include <cstring>
#include <filesystem>

#include "testenv/conformance/scenes.h"

namespace conformance {
namespace {

constexpr int kSize = 24;
const Dictionary kWideFilter = {{"samples", 4}, {"filter", "blackmanHarris"}};

const uint8_t* pixel(const Picture& picture, int x, int y_down) {
  const int y = picture.height - 1 - y_down;
  return &picture.bytes[(size_t(y) * size_t(picture.width) + size_t(x)) * FormatSize(picture.format)];
}

// Pixels of `window` (y-down) of `whole` that differ from those of `part`, whose upper left corner is (x, y) there.
int differences(const Picture& whole, const Picture& part, const Rect2i& window, int x, int y) {
  int count = 0;
  for (int j = window.minY; j < window.maxY; ++j)
    for (int i = window.minX; i < window.maxX; ++i)
      count += std::memcmp(pixel(whole, i, j), pixel(part, i - x, j - y), FormatSize(whole.format)) != 0;
  return count;
}

class Windows : public testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(Of, Windows, testing::Values("color", "primId", "normal"),
                         [](const auto& info) { return std::string(info.param); });

// A crop in a buffer of the frame's size (arnold#2706, #2635, #2561, #2563, #2408).
TEST_P(Windows, ACropIsAPartOfTheFrame) {
  Host host(kSize, kSize, kWideFilter);
  add_noisy_scene(host);
  const Picture whole = host.render(GetParam());
  for (const Rect2i& crop : {Rect2i{5, 3, 12, 9}, Rect2i{0, 0, 1, 1}, Rect2i{23, 0, 24, 24}, Rect2i{0, 11, 24, 13}}) {
    host.state.framing.dataWindow = crop;
    EXPECT_EQ(differences(whole, host.render(GetParam()), crop, 0, 0), 0) << crop.minX << " " << crop.minY;
  }
}

// The same in a buffer of the crop's own size.
TEST_P(Windows, ABufferMayHaveTheCropsSize) {
  Host host(kSize, kSize, kWideFilter), part(7, 6, kWideFilter);
  add_noisy_scene(host), add_noisy_scene(part);
  part.state.framing = {{-5, -3}, {kSize - 5, kSize - 3}, {0, 0, 7, 6}, 1};
  EXPECT_EQ(differences(host.render(GetParam()), part.render(GetParam()), {5, 3, 12, 9}, 5, 3), 0);
}

TEST_P(Windows, OverscanLeavesTheFrameAsItIs) {
  Host host(kSize, kSize, kWideFilter), wide(kSize + 9, kSize + 7, kWideFilter);
  add_noisy_scene(host), add_noisy_scene(wide);
  wide.state.framing = {{4, 3}, {kSize + 4, kSize + 3}, {0, 0, kSize + 9, kSize + 7}, 1};
  const Picture whole = host.render(GetParam()), more = wide.render(GetParam());
  EXPECT_EQ(differences(whole, more, {0, 0, kSize, kSize}, -4, -3), 0);
}

TEST(Windows, OutsideTheDataWindowIsTheClearValue) {
  Host host(kSize, kSize);
  add_halves(host);
  host.buffer();
  host.state.framing.dataWindow = {4, 4, 20, 20};
  host.state.aovBindings[0].clearValue = Vec4f(7, 7, 7, 7);
  const Picture picture = host.render();
  EXPECT_EQ(picture.number(1, 1, 0), 7);
  EXPECT_TRUE(near({picture.number(5, 12, 0), picture.number(5, 12, 1), picture.number(5, 12, 2)}, kRed));
}

TEST(Windows, UndrawableWindowsFailWithAReason) {
  Host host;
  add_halves(host);
  const Picture whole = host.render();
  const Framing good = host.state.framing;
  host.state.framing.pixelAspectRatio = -1;
  EXPECT_TRUE(host.converge());
  host.state.framing.displayMax = {-4, 16};
  EXPECT_TRUE(host.converge());
  EXPECT_EQ(host.pass->GetState(), PassState::failed);
  host.state.framing = good;
  EXPECT_TRUE(host.render() == whole);
}

// A wide display window shows more on both sides and the same in the middle (window policy matchVertically).
TEST(Windows, TheWindowPolicyConformsTheCamera) {
  Host host(32, 16);
  add_halves(host);
  const Picture picture = host.render();
  EXPECT_EQ(picture.number(2, 8, 3), 0);
  EXPECT_TRUE(near({picture.number(9, 8, 0), picture.number(9, 8, 1), picture.number(9, 8, 2)}, kRed));
  EXPECT_TRUE(near({picture.number(22, 8, 0), picture.number(22, 8, 1), picture.number(22, 8, 2)}, kGreen));
}

TEST(Bytes, ManyThreadsGiveTheBytesOfOne) {
  Host host(kSize, kSize, {{"threads", 1}});
  add_noisy_scene(host);
  const std::vector<const char*> aovs = {"color", "normal", "cameraDepth", "primId"};
  for (const char* aov : aovs) host.buffer(aov);
  host.render();
  std::vector<Picture> one;
  for (const char* aov : aovs) one.push_back(read(host.buffer(aov)));
  for (int threads : {2, 3, 8}) {
    host.delegate->SetRenderSetting("seed", 1);
    host.delegate->SetRenderSetting("threads", threads);
    host.render();
    host.delegate->SetRenderSetting("seed", 0);
    host.render();
    for (size_t i = 0; i < aovs.size(); ++i)
      EXPECT_TRUE(read(host.buffer(aovs[i])) == one[i]) << threads << " threads, " << aovs[i];
  }
}

TEST(Bytes, AnotherDelegateGivesTheSameBytes) {
  Host host(kSize, kSize), other(kSize, kSize);
  add_noisy_scene(host), add_noisy_scene(other);
  const Picture picture = host.render();
  EXPECT_TRUE(other.render() == picture);
  other.delegate->SetRenderSetting("seed", 1);
  EXPECT_FALSE(other.render() == picture) << "the scene has no noise: the tests of bytes would show nothing";
}

// The order of prims, and the threads that sync them, do not count.
TEST(Bytes, DoNotDependOnTheOrderOfSync) {
  Host host(kSize, kSize), other(kSize, kSize);
  add_noisy_scene(host);
  other.light("/quad", "rectLight") = host.light("/quad", "rectLight");
  other.mesh("/floor") = host.mesh("/floor");
  other.mesh("/cube") = host.mesh("/cube");
  other.light("/dome", "domeLight") = host.light("/dome", "domeLight");
  other.material("/matte") = host.material("/matte");
  other.set_prim_id("/cube", host.prim_id("/cube")), other.set_prim_id("/floor", host.prim_id("/floor"));
  other.sync_threads = 1, host.sync_threads = 4;
  EXPECT_TRUE(host.render() == other.render());
  EXPECT_TRUE(host.render("primId") == other.render("primId"));
}

TEST(Bytes, DoNotDependOnEditsBefore) {
  Host host(kSize, kSize);
  add_noisy_scene(host);
  const Picture picture = host.render();
  host.material("/matte", dirty::kResource) = matte({0.1f, 0.2f, 0.3f});
  host.mesh("/cube", dirty::kTransform).transform = moved(0.25, 0.25);
  host.mesh("/floor", dirty::kVisibility).visible = false;
  host.light("/quad", "rectLight", dirty::kTransform).transform = moved(-1, -1, 2);
  EXPECT_FALSE(host.render() == picture);
  host.delegate->Stop();
  host.delegate->Restart();
  host.material("/matte", dirty::kResource) = matte({0.75f, 0.5f, 0.25f});
  host.mesh("/cube", dirty::kTransform).transform = Matrix4d();
  host.mesh("/floor", dirty::kVisibility).visible = true;
  host.light("/quad", "rectLight", dirty::kTransform).transform = moved(1, 1, 2);
  EXPECT_TRUE(host.render() == picture);
}

TEST(Bytes, MoreSamplesContinueToThoseOfOneRender) {
  Host host(kSize, kSize, {{"samples", 2}}), whole(kSize, kSize, {{"samples", 9}});
  add_noisy_scene(host), add_noisy_scene(whole);
  host.render();
  for (int samples : {3, 9}) {
    host.delegate->SetRenderSetting("samples", samples);
    host.render();
  }
  EXPECT_TRUE(host.render() == whole.render());
}

TEST(CameraPrim, CameraMovePullsTheCameraAlone) {  // arnold#1854, #1855, #869, #870; gaffer#4687
  Host host;
  add_noisy_scene(host);
  const Picture before = host.render();
  const double scene = host.stat("sceneNumber");
  host.scene.take_pulls();
  host.camera(dirty::kTransform).transform = moved(0.5, 0, 2);
  EXPECT_FALSE(host.render() == before);
  EXPECT_EQ(host.scene.take_pulls(), std::vector<std::string>{"transform /camera"});
  EXPECT_EQ(host.stat("sceneNumber"), scene) << "nothing of the scene is built again";
  host.camera(dirty::kTransform).transform = moved(0, 0, 2);
  EXPECT_TRUE(host.render() == before);
}

// A checkpoint's folder, which goes with the test.
class Resume : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::temp_directory_path() / ("conformance_" + std::to_string(getpid()));
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }
  std::string file(const char* name) const { return folder_ / name; }
  static std::string command(Host& host, const char* name, const Dictionary& arguments) {
    const CommandResult result = host.delegate->InvokeCommand(name, arguments);
    return result.ok() ? std::string() : result.fault.empty() ? "no reason" : result.fault;
  }
  std::filesystem::path folder_;
};

TEST_F(Resume, GivesTheBytesOfARenderWithoutInterruption) {
  const Dictionary settings = {{"samples", 24}};
  Host plain(kSize, kSize, settings), second(kSize, kSize, settings);
  add_noisy_scene(plain), add_noisy_scene(second);
  {
    Host first(kSize, kSize, settings);
    add_noisy_scene(first);
    first.buffer();
    first.sync();
    first.take_up();
    for (int i = 0; i < 20000 && first.stat("numCompletedSamples") < 2; ++i) first.pass->Execute(first.state);
    EXPECT_EQ(command(first, "writeCheckpoint", {{"file", file("a")}}), "");
  }
  second.sync();
  EXPECT_EQ(command(second, "resumeCheckpoint", {{"file", file("a")}}), "");
  EXPECT_TRUE(second.render() == plain.render());
}

TEST_F(Resume, PartsAddUpToTheWhole) {
  Host whole(kSize, kSize, {{"samples", 8}});
  add_noisy_scene(whole);
  for (const auto& [name, first, last] : {std::tuple("b", 0, 3), std::tuple("c", 3, 8)}) {
    Host part(kSize, kSize, {{"samples", last}, {"firstSample", first}});
    add_noisy_scene(part);
    part.render();
    EXPECT_EQ(command(part, "writeCheckpoint", {{"file", file(name)}}), "");
  }
  const Picture all = whole.render();
  Host sum(kSize, kSize, {{"samples", 8}});
  sum.buffer();
  sum.sync();
  EXPECT_EQ(command(sum, "showCheckpoints", {{"files", Array<std::string>{file("b"), file("c")}}}), "");
  EXPECT_TRUE(sum.render() == all);
}

TEST_F(Resume, AnotherSceneIsRefused) {
  Host first(kSize, kSize), second(kSize, kSize);
  add_noisy_scene(first), add_noisy_scene(second);
  first.render();
  EXPECT_EQ(command(first, "writeCheckpoint", {{"file", file("d")}}), "");
  second.mesh("/cube").transform = moved(0.125, 0);
  second.buffer();
  second.sync();
  command(second, "resumeCheckpoint", {{"file", file("d")}});
  EXPECT_TRUE(second.converge());
  EXPECT_EQ(second.pass->GetState(), PassState::failed);
  EXPECT_NE(second.text_stat("error"), "");
}

}  // namespace
}  // namespace conformance
