// The denoised picture in passes and files. The fake library doubles the picture, so halves of an EXR tell it exactly.
#include <OpenImageIO/imageio.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>

#include "delegate/host/frame_recorder.h"
#include "testenv/support/oidn.h"
#include "testenv/support/stage.h"

namespace alabaster::hd::host {
namespace {

using alabaster::testing::Environment;
using alabaster::testing::FakeOidn;

constexpr const char* kDoubles = "color alone";

struct File {
  std::vector<std::string> channels;
  std::vector<float> values;  // of all channels, pixel by pixel

  bool has(const std::string& channel) const {
    return std::find(channels.begin(), channels.end(), channel) != channels.end();
  }
  std::vector<float> channel(const std::string& name) const {
    const auto at = static_cast<size_t>(std::find(channels.begin(), channels.end(), name) - channels.begin());
    std::vector<float> column;
    for (size_t i = at; i < values.size(); i += channels.size()) column.push_back(values[i]);
    return column;
  }
};

File read(const std::string& name) {
  const auto input = OIIO::ImageInput::open(name);
  if (!input) return {};
  const OIIO::ImageSpec& spec = input->spec();
  File file{spec.channelnames, std::vector<float>(spec.image_pixels() * static_cast<size_t>(spec.nchannels))};
  input->read_image(0, 0, 0, spec.nchannels, OIIO::TypeFloat, file.values.data());
  return file;
}

std::vector<float> doubled(std::vector<float> values) {
  for (float& v : values) v *= 2;
  return values;
}

class DenoisedFrame : public ::testing::Test {
 protected:
  void SetUp() override {
    std::string pattern = (std::filesystem::temp_directory_path() / "alabaster_denoise_XXXXXX").string();
    folder_ = mkdtemp(pattern.data());
    stage_.add_basic_scene();
    options_.diagnostics = [this](const Diagnostic& d) { said_ += d.code + ": " + d.text + "\n"; };
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  RecordStatus record(const Dictionary& settings, std::vector<RenderProduct> products) {
    RenderSettingsDescription description;
    description.camera = "/camera";
    description.width = 24;
    description.height = 16;
    description.settings = settings;
    description.settings["samples"] = 2;
    for (RenderProduct& product : products) product.file = folder_ + "/" + product.file;
    description.products = std::move(products);
    stage_.scene.SetRenderSettings("/settings", description);
    result_ = RecordFrame(stage_.index.get(), &stage_.scene, "/settings", options_);
    return result_.status;
  }
  File file(const char* name) const { return read(folder_ + "/" + name); }
  static RenderProduct product(const char* name, std::optional<bool> denoise = {}) {
    RenderProduct product;
    product.file = name;
    product.denoise = denoise;
    return product;
  }

  std::string folder_, said_;
  Stage stage_;
  RecordOptions options_;
  RecordResult result_;
};

TEST_F(DenoisedFrame, StandsBesideColorInAnExrAndInItsPlaceElsewhere) {
  const FakeOidn fake(kDoubles);
  ASSERT_EQ(record({}, {product("plain.exr"), product("plain.png")}), RecordStatus::done) << said_;
  EXPECT_FALSE(result_.stats.contains("denoiser")) << "nobody asked for it";
  for (const bool by_setting : {false, true}) {
    const std::optional<bool> key = by_setting ? std::optional<bool>() : true;
    const Dictionary settings = by_setting ? Dictionary{{"denoise", true}} : Dictionary{};
    ASSERT_EQ(record(settings, {product("both.exr", key), product("shown.png", key)}), RecordStatus::done) << said_;
    EXPECT_EQ(result_.stats.at("denoiser").text_or(""), "Open Image Denoise 2.99.1");
    const File both = file("both.exr"), plain = file("plain.exr");
    EXPECT_FALSE(plain.has("denoised.R"));
    for (const std::string c : {"R", "G", "B"}) {
      EXPECT_EQ(both.channel(c), plain.channel(c)) << "color is untouched";
      EXPECT_EQ(both.channel("denoised." + c), doubled(plain.channel(c)));
    }
    EXPECT_EQ(both.channel("denoised.A"), plain.channel("A"));
    const File shown = file("shown.png"), before = file("plain.png");
    EXPECT_EQ(shown.channels, (std::vector<std::string>{"R", "G", "B", "A"}));
    EXPECT_EQ(shown.channel("A"), before.channel("A"));
    EXPECT_GT(shown.channel("G")[24 * 8 + 12], before.channel("G")[24 * 8 + 12]);
  }
}

TEST_F(DenoisedFrame, AProductCanDoWithoutIt) {
  const FakeOidn fake(kDoubles);
  ASSERT_EQ(record({}, {product("plain.exr")}), RecordStatus::done) << said_;
  ASSERT_EQ(record({{"denoise", true}}, {product("without.exr", false)}), RecordStatus::done) << said_;
  EXPECT_EQ(file("without.exr").channels, file("plain.exr").channels);
  EXPECT_EQ(file("without.exr").values, file("plain.exr").values);
}

// promise: embedding.denoised
TEST_F(DenoisedFrame, WithoutTheLibraryNothingIsRenderedAndTheRemedyIsSaid) {
  const Environment nowhere("ALABASTER_OIDN", "/nonexistent");
  EXPECT_EQ(record({{"denoise", true}}, {product("frame.exr")}), RecordStatus::render_failed);
  EXPECT_TRUE(result_.written.empty());
  std::string told;
  for (const Diagnostic& d : stage_.take_diagnostics()) told += d.code + ": " + d.text + "\n";
  EXPECT_NE(told.find("pass.failed: Open Image Denoise 2 cannot be used: ALABASTER_OIDN=/nonexistent"),
            std::string::npos)
      << told;
  EXPECT_NE(told.find("pip install"), std::string::npos) << told;
  EXPECT_EQ(record({{"denoise", false}}, {product("frame.exr")}), RecordStatus::done) << said_;
}

// promise: embedding.denoised
TEST_F(DenoisedFrame, ADenoiserThatFailsLosesNoPicture) {
  const FakeOidn fake("broken");
  EXPECT_EQ(record({{"denoise", true}}, {product("frame.exr"), product("frame.png")}), RecordStatus::output_failed);
  EXPECT_EQ(result_.written.size(), 2u);
  EXPECT_NE(said_.find("record.denoise: The picture could not be denoised: the network is broken."), std::string::npos)
      << said_;
  EXPECT_EQ(file("frame.exr").channel("denoised.G"), file("frame.exr").channel("G"));
}

TEST_F(DenoisedFrame, TellsItsProgressAndAnInterruptedOneIsDenoisedAsFarAsItCame) {
  const FakeOidn fake("slow");
  std::atomic<bool> cancel{false};
  options_.cancel = &cancel;
  options_.progress = [&](const RecordProgress& p) {
    if (!(p.denoised > 0)) return;
    setenv("FAKE_OIDN", kDoubles, 1);
    cancel = true;
  };
  EXPECT_EQ(record({{"denoise", true}}, {product("frame.exr")}), RecordStatus::interrupted) << said_;
  EXPECT_TRUE(cancel);
  EXPECT_EQ(file("frame.exr").channel("denoised.G"), doubled(file("frame.exr").channel("G")));
  EXPECT_EQ(result_.stats.at("denoiser").text_or(""), "Open Image Denoise 2.99.1");
}

// promise: embedding.denoised
TEST_F(DenoisedFrame, IsWhatAHostSeesThatDrawsColorAloneWithTheSetting) {
  const FakeOidn fake(kDoubles);
  stage_.delegate->SetRenderSetting("samples", 2);
  RenderBuffer* const color = stage_.add_buffer("/color", 8, 8, Format::float32vec4);
  RenderBuffer* const denoised = stage_.add_buffer("/denoised", 8, 8, Format::float32vec4);
  stage_.index->SyncAll();
  const auto pass = stage_.delegate->CreateRenderPass();
  RenderPassState state = Stage::state_for(8, 8, "color", color);
  ASSERT_TRUE(Stage::finish(*pass, state));
  const auto rendered = Stage::pixels<float>(color);
  auto expected = doubled(rendered);
  for (size_t i = 3; i < expected.size(); i += 4) expected[i] = rendered[i];  // alpha

  stage_.delegate->SetRenderSetting("denoise", true);
  pass->Execute(state);
  ASSERT_TRUE(Stage::finish(*pass, state));
  EXPECT_EQ(Stage::pixels<float>(color), expected);

  state.aovBindings.push_back({"denoised", denoised, {}});
  pass->Execute(state);
  ASSERT_TRUE(Stage::finish(*pass, state));
  EXPECT_EQ(Stage::pixels<float>(color), rendered) << "who binds both gets both";
  EXPECT_EQ(Stage::pixels<float>(denoised), expected);
}

}  // namespace
}  // namespace alabaster::hd::host
