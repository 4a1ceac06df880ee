// Contract 0.5, 1.1 to 1.3, 4.5 rules 1 to 4: prims, and what they pull.
#include <gtest/gtest.h>

#include <set>

#include "testenv/conformance/scenes.h"

namespace conformance {
namespace {

// Pulling clean data is "at best incorrect, at worst a crash" (hd/rprim.h).
TEST(Sync, PullsNothingThatIsClean) {
  Host host;
  add_halves(host);
  host.render();
  const std::vector<std::pair<DirtyBits, std::set<std::string>>> allowed = {
      {dirty::kTransform, {"transform /left"}},
      {dirty::kMaterialId, {"material /left"}},
      {dirty::kVisibility, {}},
      {dirty::kDoubleSided, {}},
      {dirty::kPoints, {"primvar points /left", "primvars /left"}},
      {dirty::kDisplayStyle, {"style /left"}},
      {dirty::kSubdivTags, {"tags /left"}},
      {dirty::kTopology, {"topology /left"}},
      {dirty::kPrimId, {}}};
  for (const auto& [bits, names] : allowed) {
    host.scene.take_pulls();
    host.mark("/left", bits);
    host.sync();
    for (const std::string& pull : host.scene.take_pulls()) EXPECT_TRUE(names.contains(pull)) << bits << ": " << pull;
  }
  EXPECT_TRUE(near(host.render().color(-0.5, 0), kRed));
}

TEST(Sync, LeavesNoBitsDirty) {
  Host host;
  add_noisy_scene(host);
  host.instancer("/instancer");
  host.buffer();
  host.sync();
  for (const char* path : {"/cube", "/floor", "/matte", "/dome", "/quad", "/camera", "/aov/color", "/instancer"})
    EXPECT_EQ(host.dirty_bits(path), dirty::kClean) << path;
}

// Rprims are synced in parallel; 200 of them, with as many materials.
TEST(Sync, ParallelSyncGivesTheBytesOfOneThread) {
  const auto fill = [](Host& host) {
    for (int i = 0; i < 200; ++i) {
      const std::string number = std::to_string(1000 + i);
      host.material("/m" + number) = glow(Vec3f(float(i) / 256, 0.5f, 0));
      const double x = -1 + 0.1 * (i % 20), y = -1 + 0.2 * (i / 20);
      Mesh& mesh = host.mesh("/mesh" + number) = rectangle(x, y, x + 0.1, y + 0.2);
      mesh.material = "/m" + number;
    }
  };
  Host host(20, 10), other(20, 10);
  host.sync_threads = 8, other.sync_threads = 1;
  fill(host), fill(other);
  const Picture picture = host.render();
  EXPECT_TRUE(picture == other.render());
  EXPECT_TRUE(host.render("primId") == other.render("primId"));
}

// Houdini's Sync waits for every TBB worker while the renderer occupies them (RndrRenderer.cc). A render that is paused
// ends never: a Sync that waits for it does not return.
TEST(Sync, WaitsForNoRender) {
  Host host(16, 16, {{"samples", 1 << 20}});
  add_halves(host);
  host.buffer();
  host.sync();
  host.take_up();
  host.delegate->Pause();
  for (int i = 0; i < 10; ++i) {
    host.mesh("/left", dirty::kTransform).transform = moved(0, 0.1 * i);
    host.material("/red") = glow(kBlue);
    host.mesh("/new" + std::to_string(i)) = cube(0.1);
    host.sync();
  }
  EXPECT_TRUE(host.delegate->IsPaused()) << "an edit ends a pause only through Execute";
  host.delegate->SetRenderSetting("samples", 4);
  EXPECT_TRUE(near(host.render().color(-0.5, 0.95), kBlue));
}

TEST(Prims, UnknownTypesOfPrimsAreNull) {
  const Host host;
  EXPECT_EQ(host.delegate->CreateRprim("no such type", "/a"), nullptr);
  EXPECT_EQ(host.delegate->CreateSprim("no such type", "/a"), nullptr);
  EXPECT_EQ(host.delegate->CreateBprim("no such type", "/a"), nullptr);
  EXPECT_EQ(host.delegate->CreateFallbackSprim("no such type"), nullptr);
  EXPECT_EQ(host.delegate->CreateFallbackBprim("no such type"), nullptr);
}

TEST(Prims, FallbacksAreNeverSyncedAndHarmNothing) {
  Host host;
  add_halves(host);
  const Picture picture = host.render();
  std::vector<Sprim*> sprims;
  std::vector<Bprim*> bprims;
  for (const Token& type : host.delegate->GetSupportedSprimTypes()) {
    sprims.push_back(host.delegate->CreateFallbackSprim(type));
    ASSERT_NE(sprims.back(), nullptr) << type.str();
    EXPECT_TRUE(sprims.back()->GetId().empty());
  }
  for (const Token& type : host.delegate->GetSupportedBprimTypes()) {
    bprims.push_back(host.delegate->CreateFallbackBprim(type));
    ASSERT_NE(bprims.back(), nullptr) << type.str();
  }
  EXPECT_TRUE(host.render() == picture);
  for (Sprim* prim : sprims) prim->Finalize(host.delegate->GetRenderParam()), host.delegate->DestroySprim(prim);
  for (Bprim* prim : bprims) prim->Finalize(host.delegate->GetRenderParam()), host.delegate->DestroyBprim(prim);
  EXPECT_TRUE(host.render() == picture);
}

TEST(Prims, MayDieBeforeTheirFirstSync) {
  Host host;
  add_halves(host);
  host.mesh("/a"), host.material("/b"), host.instancer("/c"), host.light("/d", "rectLight");
  for (const char* path : {"/a", "/b", "/c", "/d"}) host.remove(path);
  EXPECT_TRUE(near(host.render().color(-0.5, 0), kRed));
}

// One pass may end while its render goes on, and the delegate may have several.
TEST(Passes, MayComeAndGo) {
  Host host(16, 16, {{"samples", 1 << 20}});
  add_halves(host);
  host.buffer();
  host.sync();
  for (int i = 0; i < 10; ++i) {
    host.take_up();
    host.pass.reset();
    host.pass = host.delegate->CreateRenderPass();
  }
  host.delegate->SetRenderSetting("samples", 2);
  EXPECT_TRUE(near(host.render().color(0.5, 0), kGreen));
}

TEST(Passes, AnswerBeforeTheFirstExecute) {
  const Host host;
  EXPECT_FALSE(host.pass->IsConverged());
  EXPECT_EQ(host.pass->GetState(), PassState::idle);
  host.pass->WaitForConvergence(0);
}

TEST(Delegates, DelegateOfAnotherVersionIsNotMade) {
  DelegateOptions options;
  EXPECT_EQ(library().create(kAbiVersion + 1, &options), nullptr);
}

}  // namespace
}  // namespace conformance
