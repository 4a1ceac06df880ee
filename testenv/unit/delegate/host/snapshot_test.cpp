// The picture of a running pass as a file.
#include "delegate/host/snapshot.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <iterator>

#include "core/images/image_file.h"
#include "testenv/support/stage.h"

namespace alabaster::hd::host {
namespace {

class Snapshot : public ::testing::Test {
 protected:
  Snapshot() : folder(std::filesystem::temp_directory_path() / ("snapshot_test_" + std::to_string(getpid()))) {
    std::filesystem::create_directory(folder);
    stage.add_basic_scene();
    pass = stage.delegate->CreateRenderPass();
  }
  ~Snapshot() override {
    pass.reset();
    std::filesystem::remove_all(folder);
  }
  RenderProduct product(const char* name) const {
    RenderProduct made;
    made.file = folder / name;
    return made;
  }
  bool write(const RenderPassState& state, const RenderProduct& to) {
    return WriteSnapshot(*stage.delegate, *pass, state, to, {}, [this](const Diagnostic& d) { said = d.text; });
  }

  Stage stage{{{"samples", int64_t(2)}}};
  std::unique_ptr<RenderPass> pass;
  std::filesystem::path folder;
  std::string said;
};

TEST_F(Snapshot, WritesWhatTheBuffersShow) {
  for (const Format format : {Format::float32vec4, Format::float16vec4, Format::unorm8vec4}) {
    RenderBuffer* buffer = stage.add_buffer("/color", 8, 8, format);
    RenderPassState state = Stage::state_for(8, 8, "color", buffer);
    state.aovBindings.push_back({"primId", stage.add_buffer("/ids", 8, 8, Format::int32), {}});
    stage.index->SyncAll();
    ASSERT_TRUE(Stage::finish(*pass, state));
    RenderProduct exr = product("a.exr");
    exr.vars = {UsualRenderVar("color"), UsualRenderVar("primId")};
    EXPECT_TRUE(write(state, exr)) << said;
    EXPECT_TRUE(write(state, product("a.png"))) << said;
    EXPECT_GT(std::filesystem::file_size(exr.file), 300u);
    EXPECT_GT(std::filesystem::file_size(folder / "a.png"), 60u);
    std::filesystem::remove(exr.file);
    stage.scene.Remove("/color");
    stage.scene.Remove("/ids");
  }
}

// Also where no Execute has latched convergence.
TEST_F(Snapshot, SnapshotOfAFinishedRenderIsComplete) {
  RenderPassState state = Stage::state_for(8, 8, "color", stage.add_buffer("/color", 8, 8, Format::float32vec4));
  stage.index->SyncAll();
  pass->Execute(state);
  ASSERT_TRUE(pass->WaitForConvergence(20));
  ASSERT_TRUE(write(state, product("a.exr"))) << said;
  const auto is_marked = [&] {
    std::ifstream file(folder / "a.exr", std::ios::binary);
    const std::string bytes(std::istreambuf_iterator<char>(file), {});
    return bytes.find("alabaster/incomplete") != std::string::npos;
  };
  EXPECT_FALSE(is_marked());
  stage.delegate->SetRenderSetting("samples", int64_t(1) << 20);
  pass->Execute(state);
  ASSERT_TRUE(write(state, product("a.exr"))) << said;
  EXPECT_TRUE(is_marked());
}

TEST_F(Snapshot, SaysWhyItWritesNothing) {
  RenderPassState state = Stage::state_for(8, 8, "color", stage.add_buffer("/color", 8, 8, Format::float32vec4));
  stage.index->SyncAll();
  ASSERT_TRUE(Stage::finish(*pass, state));
  RenderProduct depth = product("d.exr");
  depth.vars = {UsualRenderVar("depth")};
  EXPECT_FALSE(write(state, depth));
  EXPECT_NE(said.find("'depth' is not bound"), std::string::npos) << said;
  state.framing.dataWindow = {0, 0, 4, 4};
  EXPECT_FALSE(write(state, product("c.exr")));
  EXPECT_NE(said.find("not as large as the data window"), std::string::npos) << said;
  state.framing.dataWindow = {0, 0, 8, 8};
  EXPECT_FALSE(write(state, product("nowhere/c.exr")));
  EXPECT_TRUE(std::filesystem::is_empty(folder));
}

}  // namespace
}  // namespace alabaster::hd::host
