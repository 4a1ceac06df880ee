// Contract 1.6, 4.5 rules 5, 6 and 8: how a host's loop ends, and what it sees then.
#include <gtest/gtest.h>

#include <chrono>
#include <thread>

#include "testenv/conformance/scenes.h"

namespace conformance {
namespace {

// hd_render and scripts: Execute until IsConverged, without a wait.
TEST(Convergence, ATightLoopEnds) {
  Host host;
  add_noisy_scene(host);
  host.buffer();
  host.sync();
  const auto end = std::chrono::steady_clock::now() + std::chrono::minutes(1);
  do {
    host.pass->Execute(host.state);
  } while (!host.pass->IsConverged() && std::chrono::steady_clock::now() < end);
  EXPECT_TRUE(host.pass->IsConverged());
  EXPECT_EQ(host.pass->GetState(), PassState::converged);
}

// usdrecord: Execute, sleep, ask.
TEST(Convergence, APolledLoopEnds) {
  Host host;
  add_noisy_scene(host);
  host.buffer();
  host.sync();
  for (int i = 0; i < 6000; ++i) {
    host.pass->Execute(host.state);
    if (host.pass->IsConverged()) break;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  EXPECT_TRUE(host.pass->IsConverged());
}

// A host that resolves between Execute and IsConverged shows the final picture (OpenUSD#1154). The complaint is a race,
// so several frames are drawn.
TEST(Convergence, TheLastPictureIsSeenBeforeItIsReported) {
  Host host(16, 16, {{"samples", 2}});
  add_noisy_scene(host);
  RenderBuffer& color = host.buffer();
  for (int frame = 0; frame < repetitions(40, 10); ++frame) {
    host.delegate->SetRenderSetting("seed", frame);
    host.sync();
    const auto end = std::chrono::steady_clock::now() + std::chrono::minutes(1);
    Picture seen;
    do {
      host.pass->Execute(host.state);
      seen = read(color);
    } while (!host.pass->IsConverged() && std::chrono::steady_clock::now() < end);
    ASSERT_TRUE(seen == read(color)) << "frame " << frame;
  }
}

TEST(Convergence, BuffersAndPassAgree) {
  Host host;
  add_noisy_scene(host);
  host.buffer(), host.buffer("depth");
  host.sync();
  for (int i = 0; i < 20000; ++i) {
    host.pass->Execute(host.state);
    const bool converged = host.pass->IsConverged();
    ASSERT_EQ(host.buffer().IsConverged(), converged);
    ASSERT_EQ(host.buffer("depth").IsConverged(), converged);
    if (converged) break;
    std::this_thread::sleep_for(std::chrono::microseconds(200));
  }
  host.camera(dirty::kTransform).transform = moved(0.25, 0, 2);
  host.sync();
  host.pass->Execute(host.state);
  EXPECT_EQ(host.buffer().IsConverged(), host.pass->IsConverged());
}

// A host's loop must end (OpenUSD#971, arnold#4, rpr#224), and say why.
// promise: embedding.errors
TEST(Convergence, AFailureConverges) {
  Host host;
  add_halves(host);
  host.buffer();
  host.state.camera = "/nowhere";
  host.sync();
  EXPECT_TRUE(host.converge());
  EXPECT_EQ(host.pass->GetState(), PassState::failed);
  EXPECT_NE(host.text_stat("error"), "");
  EXPECT_FALSE(host.take_diagnostics().empty());
}

// One failure is not the last word (arnold#853: one fault aborts every later render).
TEST(Convergence, AfterAFailureTheNextFrameIsDrawn) {
  Host host;
  add_halves(host);
  const Picture whole = host.render();
  host.state.camera = "/nowhere";
  host.sync();
  EXPECT_TRUE(host.converge());
  host.state.camera = "/camera";
  EXPECT_TRUE(host.render() == whole);
  EXPECT_EQ(host.pass->GetState(), PassState::converged);
}

TEST(Convergence, NothingToDrawConverges) {
  Host host;
  add_halves(host);
  host.sync();
  EXPECT_TRUE(host.converge()) << "no buffer is bound";
  RenderBuffer& color = host.buffer();
  host.state.aovBindings[0].aovName = "no such AOV";
  host.sync();
  EXPECT_TRUE(host.converge()) << "an AOV that is not supported";
  host.state.aovBindings[0] = {"color", &color, {}};
  color.Allocate({{0, 0, 1}, Format::float32vec4});
  EXPECT_TRUE(host.converge()) << "a buffer without pixels";
}

TEST(Convergence, AStoppedRenderHasNotConverged) {
  Host host(16, 16, {{"samples", 1 << 20}});
  add_noisy_scene(host);
  host.buffer();
  host.sync();
  host.take_up();
  host.delegate->Stop();
  EXPECT_FALSE(host.pass->IsConverged());
  EXPECT_FALSE(host.buffer().IsConverged());
  EXPECT_EQ(host.pass->GetState(), PassState::stopped);
  host.pass->Execute(host.state);
  EXPECT_FALSE(host.pass->IsConverged());
}

// usdview sends one unchanged setting with each paint, and the render never converges (OpenUSD#2870).
TEST(DelegateSettings, AnEqualValueRestartsNothing) {
  Host host;
  add_noisy_scene(host);
  const Picture picture = host.render();
  const uint32_t version = host.delegate->GetRenderSettingsVersion();
  const uint64_t generation = host.buffer().GetGeneration();
  for (int i = 0; i < 1000; ++i) {
    host.delegate->SetRenderSetting("samples", 4);
    host.delegate->SetRenderSetting("filter", "box");
    host.pass->Execute(host.state);
    ASSERT_TRUE(host.pass->IsConverged()) << "after " << i;
  }
  EXPECT_EQ(host.delegate->GetRenderSettingsVersion(), version);
  EXPECT_TRUE(read(host.buffer()) == picture);
  EXPECT_EQ(host.buffer().GetGeneration(), generation);
}

TEST(DelegateSettings, AnotherValueRestarts) {
  Host host;
  add_noisy_scene(host);
  const Picture before = host.render();
  const uint32_t version = host.delegate->GetRenderSettingsVersion();
  host.delegate->SetRenderSetting("maxDepth", 0);
  EXPECT_NE(host.delegate->GetRenderSettingsVersion(), version);
  host.pass->Execute(host.state);
  EXPECT_FALSE(host.pass->IsConverged());
  EXPECT_FALSE(host.render() == before);
}

// Hosts send keys that no renderer knows: houdini:interactive, stageMetersPerUnit, ...
TEST(DelegateSettings, UnknownKeysAreKeptAndIgnored) {
  Host host;
  add_noisy_scene(host);
  const Picture before = host.render();
  host.delegate->SetRenderSetting("houdini:interactive", "normal");
  EXPECT_EQ(host.delegate->GetRenderSetting("houdini:interactive").text_or(""), "normal");
  EXPECT_TRUE(host.render() == before);
}

// usdview shows bool, int, uint, float and string settings, and drops others with a warning.
TEST(DelegateSettings, DescriptorsHaveValuesThatHostsCanShow) {
  const Host host;
  for (const RenderSettingDescriptor& d : host.delegate->GetRenderSettingDescriptors()) {
    const Value& value = d.defaultValue;
    EXPECT_TRUE(value.get<bool>() || value.get<int32_t>() || value.get<int64_t>() || value.get<uint32_t>() ||
                value.get<float>() || value.get<std::string>())
        << d.name;
    EXPECT_FALSE(d.name.empty() || d.documentation.empty()) << d.name;
    EXPECT_EQ(host.delegate->GetRenderSetting(d.key).empty(), false) << d.name;
  }
}

TEST(Execute, NothingThatStaysTheSameRestarts) {
  Host host;
  add_noisy_scene(host);
  const Picture picture = host.render();
  const uint64_t generation = host.buffer().GetGeneration();
  for (int i = 0; i < 20; ++i) {
    for (const char* path : {"/camera", "/quad", "/matte", "/cube"}) host.mark(path, dirty::kAll);
    host.sync();
    host.take_up();
    ASSERT_TRUE(host.pass->IsConverged());
  }
  EXPECT_TRUE(read(host.buffer()) == picture);
  EXPECT_EQ(host.buffer().GetGeneration(), generation);
}

}  // namespace
}  // namespace conformance
