// CommitResources when memory runs out in it.
#include <gtest/gtest.h>

#include "testenv/support/failing_memory.h"
#include "testenv/support/stage.h"

namespace alabaster::hd {
namespace {

// Synced once, outside of the index: no later Sync brings back an edit that a commit loses.
struct MovingMesh {
  Stage stage{{{"samples", 1}, {"threads", 1}}};
  host::RetainedSceneDelegate scene;
  Rprim* prim = nullptr;

  MovingMesh() {
    stage.add_basic_scene();
    stage.index->SyncAll();
    prim = stage.delegate->CreateRprim("mesh", "/moving");
  }
  ~MovingMesh() {
    prim->Finalize(stage.delegate->GetRenderParam());
    stage.delegate->DestroyRprim(prim);
  }
  void move_to(double x) {
    host::MeshDescription mesh = Stage::quad();
    mesh.transform[3][0] = x;
    scene.SetMesh("/moving", mesh);
    DirtyBits bits = dirty::kAll;
    prim->Sync(&scene, stage.delegate->GetRenderParam(), &bits);
    ASSERT_EQ(bits, dirty::kClean);
  }
};

// `Memory` fails in the host's thread, or in the builder's.
template <class Memory, class... Refusals>
void fail_at_every_allocation(size_t at_least, Refusals... refusals) {
  MovingMesh moving;
  Stage& stage = moving.stage;
  size_t allowed = 0;
  for (bool failed = true; failed; ++allowed) {
    ASSERT_NO_FATAL_FAILURE(moving.move_to(static_cast<double>(allowed) + 0.25));
    const double before = stage.stat("sceneNumber");
    {
      const Memory memory(refusals..., allowed);
      stage.delegate->CommitResources();
      if constexpr (sizeof...(Refusals) > 0) stage.wait_for_scene();  // it fails there
      failed = memory.failed();
    }
    stage.delegate->CommitResources();
    ASSERT_EQ(stage.text_stat("error"), "") << "after " << allowed << " allocations";
    ASSERT_GT(stage.stat("sceneNumber"), before) << "after " << allowed << " allocations";
    const std::string expected = std::to_string(allowed) + ".25, 0, 0, 1";
    const std::string dump = stage.delegate->InvokeCommand("dumpScene", {}).value.text_or("");
    ASSERT_NE(dump.find(expected), std::string::npos) << "after " << allowed << " allocations: " << dump;
    ASSERT_EQ(stage.text_stat("scene.faults"), "") << "after " << allowed << " allocations";
    const double now = stage.stat("sceneNumber");
    stage.delegate->CommitResources();
    ASSERT_EQ(stage.stat("sceneNumber"), now) << "nothing is left to be done";
  }
  EXPECT_GT(allowed, at_least) << "a commit allocates that often";
}

TEST(DelegateState, ACommitThatMemoryDoesNotSufficeForIsMadeGoodByTheNext) {
  fail_at_every_allocation<testing::FailingMemory>(2);
}

TEST(DelegateState, ABuildThatMemoryDoesNotSufficeForIsMadeGoodByTheNextCommit) {
  fail_at_every_allocation<testing::FailingMemoryElsewhere>(20, 1);
}

// Between the two commits a pass must neither draw the old scene as if it were the new one nor wait without end.
TEST(DelegateState, APassFailsWhileTheSceneCouldNotBeCompiled) {
  MovingMesh moving;
  Stage& stage = moving.stage;
  RenderBuffer* buffer = stage.add_buffer("/b", 4, 4, Format::float32vec4);
  stage.index->SyncAll();
  const auto pass = stage.delegate->CreateRenderPass();
  const RenderPassState state = Stage::state_for(4, 4, "color", buffer);
  ASSERT_TRUE(Stage::finish(*pass, state));
  bool seen = false;
  std::string last;
  for (size_t allowed = 0; !seen && allowed < 1000; ++allowed) {
    ASSERT_NO_FATAL_FAILURE(moving.move_to(static_cast<double>(allowed) + 0.25));
    {
      const testing::FailingMemoryElsewhere memory(1, allowed);
      stage.delegate->CommitResources();
      stage.wait_for_scene();
    }
    seen = !stage.text_stat("error").empty();
    if (!seen) stage.delegate->CommitResources();
  }
  ASSERT_TRUE(seen);
  for (const Diagnostic& d : stage.take_diagnostics()) last = d.text;
  EXPECT_TRUE(last.ends_with("the scene is not drawn, and the next commit builds it again")) << last;
  pass->Execute(state);
  EXPECT_TRUE(pass->IsConverged());
  EXPECT_EQ(pass->GetState(), PassState::failed);
  stage.delegate->CommitResources();
  EXPECT_TRUE(Stage::finish(*pass, state));
  EXPECT_EQ(pass->GetState(), PassState::converged);
}

}  // namespace
}  // namespace alabaster::hd
