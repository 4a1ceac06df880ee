// The commands of checkpoints, and what they refuse.
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <chrono>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <span>
#include <sstream>

#include "core/digest/digest.h"
#include "core/integrator/path_integrator.h"
#include "testenv/support/stage.h"

namespace alabaster::hd {
namespace {

class Checkpoints : public ::testing::Test {
 protected:
  void SetUp() override {
    const auto* info = ::testing::UnitTest::GetInstance()->current_test_info();
    folder_ = std::filesystem::temp_directory_path() /
              ("alabaster_" + std::string(info->name()) + "_" + std::to_string(getpid()));
    std::filesystem::create_directories(folder_);
    file_ = folder_ / "render.checkpoint";
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  struct Frame {
    Stage stage;
    RenderBuffer* buffer;
    std::unique_ptr<RenderPass> pass;
    RenderPassState state;

    explicit Frame(const Dictionary& settings = {{"samples", 3}}) : stage(settings) {
      stage.add_basic_scene();
      stage.scene.SetLight("/lamp", {.type = "rectLight", .transform = {}, .parameters = {{"intensity", 2.0f}}});
      buffer = stage.add_buffer("/b", 20, 10, Format::float32vec4);
      pass = stage.delegate->CreateRenderPass();
      state = Stage::state_for(20, 10, "color", buffer);
    }
    std::string command(const char* name, const Dictionary& arguments) const {
      const CommandResult result = stage.delegate->InvokeCommand(name, arguments);
      return result.ok() ? std::string() : result.fault.empty() ? "no reason" : result.fault;
    }
    // Why the render cannot go on from the file; empty if it does.
    std::string refusal(const std::string& file) {
      stage.index->SyncAll();
      if (const std::string fault = command("resumeCheckpoint", {{"file", file}}); !fault.empty()) return fault;
      if (!Stage::finish(*pass, state)) return "it never ends";
      return stage.text_stat("error");
    }
    std::vector<float> picture() {
      stage.index->SyncAll();
      EXPECT_TRUE(Stage::finish(*pass, state));
      return Stage::pixels<float>(buffer);
    }
  };
  // A checkpoint of the frame at its end.
  std::string written(Frame& frame) const {
    frame.picture();
    EXPECT_EQ(frame.command("writeCheckpoint", {{"file", file_}, {"note", "of mine"}}), "");
    return file_;
  }
  std::string written() const {
    Frame frame;
    return written(frame);
  }
  std::string bytes() const {
    std::ostringstream text;
    text << std::ifstream(file_, std::ios::binary).rdbuf();
    return text.str();
  }
  void replace(const std::string& all) const { std::ofstream(file_, std::ios::binary | std::ios::trunc) << all; }

  std::filesystem::path folder_;
  std::string file_;
};

TEST_F(Checkpoints, PixelsAreMeasuredOnRequest) {
  Frame frame({{"samples", 8}});
  const Dictionary request{{"file", written(frame)}, {"measure", true}};
  const Value described = frame.stage.delegate->InvokeCommand("describeCheckpoint", request).value;
  const auto d = described.get_or(std::shared_ptr<const Dictionary>());
  ASSERT_TRUE(d);
  EXPECT_EQ(d->at("meanSamples").number_or(0), 8);
  EXPECT_GT(frame.stage.stat("error.relativeRmse"), 0);
  EXPECT_EQ(d->at("error.relativeRmse").number_or(-1), frame.stage.stat("error.relativeRmse"));
  replace(bytes().substr(0, bytes().size() - 8));
  EXPECT_NE(frame.command("describeCheckpoint", request), "") << "damage is told";
}

// promise: farm.checkpoint.other_render
TEST_F(Checkpoints, AnotherRenderIsRefusedByName) {
  const std::string file = written();
  const std::string prefix = "the render cannot go on from checkpoint '" + file + "': it is of another render: ";
  const auto refusal = [&](const auto& change, const Dictionary& settings = {{"samples", 3}}) {
    Frame frame(settings);
    change(frame);
    const std::string text = frame.refusal(file);
    EXPECT_EQ(frame.stage.count("pass.failed"), 1u) << text;
    EXPECT_TRUE(text.starts_with(prefix)) << text;
    return text.substr(std::min(prefix.size(), text.size()));
  };
  const auto nothing = [](Frame&) {};
  EXPECT_EQ(refusal(nothing, {{"samples", 3}, {"maxDepth", 5}}), "setting maxDepth was 8 and is 5");
  EXPECT_EQ(refusal(nothing, {{"samples", 3}, {"seed", 7}, {"filter", "box"}}),
            "setting filter was blackmanHarris and is box; setting seed was 0 and is 7");
  EXPECT_EQ(refusal([](Frame& f) {
              auto quad = Stage::quad();
              quad.primvars["points"].value = Array<Vec3f>{{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0.25f}};
              f.stage.scene.SetMesh("/quad", quad);
            }),
            "mesh /quad has changed");
  EXPECT_EQ(refusal([](Frame& f) { f.stage.scene.SetMesh("/other", Stage::quad()); }), "mesh /other is new");
  EXPECT_EQ(refusal([](Frame& f) { f.stage.scene.Remove("/lamp"); }), "light /lamp is gone");
  EXPECT_EQ(
      refusal([](Frame& f) {
        f.stage.scene.SetLight("/lamp", {.type = "rectLight", .transform = {}, .parameters = {{"intensity", 3.0f}}});
      }),
      "light /lamp has changed");
  EXPECT_EQ(refusal([](Frame& f) {
              host::CameraDescription camera = f.stage.scene.GetCameras().at("/camera");
              camera.transform[3][2] = 5;
              f.stage.scene.SetCamera("/camera", camera);
            }),
            "the camera has changed");
  EXPECT_EQ(refusal([](Frame& f) { f.state.aovBindings[0].aovName = "normal"; }), "the AOVs were color and are normal");
  EXPECT_EQ(refusal([](Frame& f) {
              f.state.framing.dataWindow = {2, 0, 20, 10};
            }),
            "the data window was 0,0,20,10 and is 2,0,20,10");
}

// promise: artists.values_unread
TEST_F(Checkpoints, ValuesByInstanceThatNothingReadsAreNoOtherRender) {
  const auto place = [](Frame& frame, const char* primvar, float value) {
    host::MeshDescription quad = Stage::quad();
    quad.instancer = "/row";
    host::InstancerDescription row;
    row.primvars["hydra:instanceTranslations"] = Array<Vec3f>{{0, 0, 0}};
    row.primvars[primvar] = Array<Vec3f>{Vec3f(value)};
    row.indices["/quad"] = {0};
    frame.stage.scene.SetInstancer("/row", row);
    frame.stage.scene.SetMesh("/quad", quad);
  };
  for (const char* primvar : {"age", "displayColor"}) {
    Frame first;
    place(first, primvar, 0.25f);
    const std::string file = written(first);
    Frame next;
    place(next, primvar, 0.5f);
    const std::string refusal = next.refusal(file);
    EXPECT_EQ(refusal.empty(), primvar == std::string("age")) << refusal;
  }
}

TEST_F(Checkpoints, MoreSamplesThanAreAskedForAreRefused) {
  const std::string file = written();
  Frame fewer({{"samples", 2}});
  EXPECT_NE(fewer.refusal(file).find("it has 3 samples per pixel, more than the 2 that are asked for"),
            std::string::npos);
  EXPECT_TRUE(fewer.pass->GetState() == PassState::failed);
  EXPECT_EQ(fewer.command("resumeCheckpoint", {}), "");
  EXPECT_TRUE(Stage::finish(*fewer.pass, fewer.state)) << "without the checkpoint it is a render as any";
  EXPECT_EQ(fewer.stage.stat("numCompletedSamples"), 2);
}

TEST_F(Checkpoints, AnotherVersionIsRefused) {
  std::string all = (written(), bytes());
  const std::string format = "Alabaster checkpoint 9";
  ASSERT_TRUE(all.starts_with(format));
  all[format.size() - 1] = '1';
  replace(all);
  EXPECT_EQ(Frame().refusal(file_), "it is a checkpoint of another version of Alabaster, in another format");
}

// promise: farm.checkpoint.damage
TEST_F(Checkpoints, DamagedFilesAreRefused) {
  const std::string all = (written(), bytes());
  Frame frame;
  const auto fault = [&] { return frame.command("resumeCheckpoint", {{"file", file_}}); };
  EXPECT_EQ(fault(), "");
  for (size_t size = 0; size < all.size(); size += size < 2000 ? 7 : 997) {
    replace(all.substr(0, size));
    const std::string said = fault();
    EXPECT_TRUE(said.find("it ends too early") != std::string::npos || said == "it is not a checkpoint" ||
                said.find("another format") != std::string::npos)
        << size << ": " << said;
  }
  for (size_t at = 0; at < all.size(); at += at < 2000 ? 3 : 499) {
    std::string bad = all;
    bad[at] = static_cast<char>(bad[at] ^ (1 << at % 8));
    replace(bad);
    EXPECT_NE(fault(), "") << at;
  }
  replace(all + "x");
  EXPECT_EQ(fault(), "it is damaged: there is more after its end");
  replace("");
  EXPECT_EQ(fault(), "it is not a checkpoint");
  std::filesystem::remove(file_);
  EXPECT_EQ(fault(), "there is no such file");
  EXPECT_NE(frame.command("resumeCheckpoint", {{"file", folder_.string()}}), "");
}

// By arithmetic, before any of its pixels is read. The same of parts that are shown and of pixels that are measured.
// promise: pipeline.memory.frames
TEST_F(Checkpoints, AFrameThatTheMemoryLimitDoesNotHoldIsRefused) {
  Frame large({{"samples", 1}});
  large.buffer = large.stage.add_buffer("/large", 200, 100, Format::float32vec4);
  large.state = Stage::state_for(200, 100, "color", large.buffer);
  written(large);
  const Frame small({{"samples", 1}, {"memoryLimit", 1}});
  const std::pair<const char*, Dictionary> commands[] = {{"resumeCheckpoint", {{"file", file_}}},
                                                         {"showCheckpoints", {{"files", Array<std::string>{file_}}}},
                                                         {"describeCheckpoint", {{"file", file_}, {"measure", true}}}};
  for (const auto& [command, arguments] : commands) {
    const std::string fault = small.command(command, arguments);
    EXPECT_NE(fault.find("a checkpoint of 200 x 100 pixels needs 3 MiB more"), std::string::npos) << fault;
    EXPECT_NE(fault.find("raise memoryLimit"), std::string::npos) << fault;
    EXPECT_EQ(small.stage.delegate->InvokeCommand(command, arguments).status, CommandStatus::out_of_memory);
  }
  small.stage.delegate->SetRenderSetting("memoryLimit", 64);
  EXPECT_EQ(small.command("resumeCheckpoint", {{"file", file_}}), "");
}

// As the file's first block, with the right checksum.
std::string with_header(const std::string& all, const std::string& header) {
  constexpr size_t kMagic = 23, kHead = 16;
  uint64_t old = 0, size = header.size(), sum = checksum(std::as_bytes(std::span(header)), 0);
  std::memcpy(&old, all.data() + kMagic, sizeof old);
  std::string head(kHead, ' ');
  std::memcpy(head.data(), &size, sizeof size);
  std::memcpy(head.data() + sizeof size, &sum, sizeof sum);
  return all.substr(0, kMagic) + head + header + all.substr(kMagic + kHead + old);
}

std::string header_of(const std::string& all) {
  uint64_t size = 0;
  std::memcpy(&size, all.data() + 23, sizeof size);
  return all.substr(23 + 16, size);
}

// A header is what a render writes, and nothing deeper or longer: parsed as any JSON, such files took gigabytes.
// promise: security.checkpoint
TEST_F(Checkpoints, AHeaderThatDescribesNoRenderIsRefusedEarly) {
  const std::string all = (written(), bytes()), header = header_of(all), open = header.substr(0, header.size() - 1);
  const auto times = [](const std::string& text, size_t count) {
    std::string many;
    for (size_t i = 0; i < count; ++i) many += text;
    return many;
  };
  std::string digests, unknown;
  for (int i = 0; i < 2000; ++i) {
    digests += "\"" + std::to_string(i) + "\":\"" + std::string(31, '0') + "\",";
    unknown += "\"" + std::to_string(i) + "\":\"\",";
  }
  const Frame frame;
  const std::string bad[] = {times("[", 20'000'000),
                             "[" + times("{},", 7'000'000) + "{}]",
                             times("{\"a\":", 4'000'000),
                             open + ",\"more\":" + times("[", 20'000'000),
                             open + ",\"more\":1}",
                             open + ",\"samples\":[0,1,2]}",
                             open + ",\"samples\":[[0],1]}",
                             open + ",\"note\":\"" + std::string(100'000, 'x') + "\"}",
                             open + ",\"scene\":{" + digests + "\"\":\"\"}}",
                             open + ",\"settings\":{" + unknown + "\"\":\"\"}}",
                             "null",
                             ""};
  for (const std::string& text : bad) {
    replace(with_header(all, text));
    const auto begin = std::chrono::steady_clock::now();
    EXPECT_EQ(frame.command("describeCheckpoint", {{"file", file_}}),
              "it is damaged: its header does not describe a render")
        << text.substr(0, 60);
    EXPECT_LT(std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count(), 5);
  }
  replace(with_header(all, header));
  EXPECT_EQ(frame.command("resumeCheckpoint", {{"file", file_}}), "");
}

// promise: pipeline.memory.frames, security.checkpoint
TEST_F(Checkpoints, TheMemoryLimitHoldsTheHeader) {
  const std::string all = (written(), bytes()), header = header_of(all), scene = "\"scene\":{";
  std::string many;
  for (int i = 0; i < 100'000; ++i) many += "\"mesh /" + std::to_string(i) + "\":\"" + std::string(32, '0') + "\",";
  std::string large = header;
  large.insert(large.find(scene) + scene.size(), many);
  replace(with_header(all, large));
  const auto fault = [&](int mib) {
    return Frame({{"samples", 1}, {"memoryLimit", mib}}).command("describeCheckpoint", {{"file", file_}});
  };
  EXPECT_NE(fault(16).find("the header of a checkpoint needs"), std::string::npos) << fault(16);
  EXPECT_EQ(fault(256), "");
}

// A FIFO or a device may have no end.
// promise: security.no_wait
TEST_F(Checkpoints, OnlyRegularFilesAreRead) {
  ASSERT_EQ(::mkfifo(file_.c_str(), 0600), 0);
  const Frame frame;
  const std::pair<const char*, Dictionary> commands[] = {{"resumeCheckpoint", {{"file", file_}}},
                                                         {"showCheckpoints", {{"files", Array<std::string>{file_}}}},
                                                         {"describeCheckpoint", {{"file", file_}}},
                                                         {"resumeCheckpoint", {{"file", std::string("/dev/zero")}}}};
  for (const auto& [command, arguments] : commands)
    EXPECT_NE(frame.command(command, arguments).find("not a regular file"), std::string::npos) << command;
}

TEST_F(Checkpoints, ALongNoteIsNotWritten) {
  Frame frame;
  frame.picture();
  const std::string note((64 << 10) + 1, 'x');
  EXPECT_NE(frame.command("writeCheckpoint", {{"file", file_}, {"note", note}}).find("note"), std::string::npos);
  EXPECT_EQ(frame.command("writeCheckpoint", {{"file", file_}, {"note", note.substr(1)}}), "");
  EXPECT_EQ(frame.command("describeCheckpoint", {{"file", file_}}), "");
}

// promise: farm.parts.refused
TEST_F(Checkpoints, APartOfAFrameThatDecidesIsRefused) {
  for (const auto& [name, value] : Dictionary{{"targetError", 0.1f}, {"adaptive", true}, {"timeLimit", 5.0f}}) {
    Frame frame({{"firstSample", 2}, {"samples", 40}, {name, value}});
    EXPECT_NE(frame.refusal("").find("firstSample cannot be given with " + name), std::string::npos);
  }
  EXPECT_NE(Frame({{"firstSample", 8}, {"samples", 8}}).refusal("").find("must be below samples"), std::string::npos);
}

// A file with another text in its header, which has the same length, and a right checksum, as somebody can make it.
std::string with_header(std::string file, const std::string& from, const std::string& to) {
  constexpr size_t kMagic = 23, kHead = 2 * sizeof(uint64_t);
  const size_t at = file.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  if (at == std::string::npos) return file;
  file.replace(at, from.size(), to);
  uint64_t size = 0;
  std::memcpy(&size, file.data() + kMagic, sizeof size);
  const uint64_t sum = checksum(std::as_bytes(std::span(file).subspan(kMagic + kHead, size)), 0);
  std::memcpy(file.data() + kMagic + sizeof size, &sum, sizeof sum);
  return file;
}

TEST_F(Checkpoints, SamplesOfAnotherKindAreRefused) {
  written();
  const std::string now = std::to_string(kSamplingVersion), other(now.size(), '2');  // of the same length
  ASSERT_NE(now, other);
  replace(with_header(bytes(), "\"sampling\":\"" + now + "\"", "\"sampling\":\"" + other + "\""));
  EXPECT_NE(Frame().refusal(file_).find("the version of sampling was " + other + " and is " + now), std::string::npos);
}

// The header says adaptive, and the film lacks the rays from which samples are allocated.
TEST_F(Checkpoints, AFilmOfOtherSettingsThanTheHeaderSaysIsRefused) {
  const Dictionary settings{{"samples", 40}, {"targetError", 0.001f}};
  Dictionary short_time = settings, adaptive = settings;
  short_time["timeLimit"] = 1e-5f;  // it ends before anything is decided
  adaptive["adaptive"] = true;
  Frame frame(short_time);
  written(frame);
  ASSERT_LT(frame.stage.stat("numCompletedSamples"), 16);
  replace(with_header(bytes(), "\"adaptive\":\"false\"", "\"adaptive\":\"true\" "));
  const std::string said = Frame(adaptive).refusal(file_);
  EXPECT_NE(said.find("it does not hold what its header says"), std::string::npos) << said;
}

TEST_F(Checkpoints, APartWithoutSamplesIsRefused) {
  written();
  replace(with_header(bytes(), "\"samples\":[0,3]", "\"samples\":[3,3]"));
  Frame frame;
  EXPECT_NE(frame.command("describeCheckpoint", {{"file", file_}}).find("does not say which samples"),
            std::string::npos);
  EXPECT_NE(frame.command("showCheckpoints", {{"files", Array<std::string>{file_}}}).find("does not say which samples"),
            std::string::npos);
}

// A scene that is built for another pass takes nothing from the frame that was drawn last.
TEST_F(Checkpoints, AnotherPassThatBeginsLeavesTheLastFrame) {
  Frame frame;
  frame.picture();
  const std::unique_ptr<RenderPass> other = frame.stage.delegate->CreateRenderPass();
  RenderBuffer* const buffer = frame.stage.add_buffer("/other", 20, 10, Format::float32vec4);
  frame.stage.index->SyncAll();
  RenderPassState state = Stage::state_for(20, 10, "color", buffer);
  state.renderTags = {"proxy"};
  other->Execute(state);
  frame.stage.delegate->InvokeCommand("waitForScene", {});
  EXPECT_EQ(frame.command("writeCheckpoint", {{"file", file_}}), "");
}

}  // namespace
}  // namespace alabaster::hd
