// Render tags and collections of passes that draw one scene.
#include <gtest/gtest.h>

#include <chrono>
#include <set>
#include <thread>

#include "testenv/support/stage.h"

namespace alabaster::hd {
namespace {

constexpr int kSize = 24;

// Small quads side by side in front of the basic scene's camera, one for each tag, by path.
class Tagged : public Stage {
 public:
  Tagged() : Stage({{"samples", int64_t(1)}, {"threads", 2}}) {
    add_basic_scene();
    scene.Remove("/quad");
    add("/set/geometry", "geometry", -1.5);
    add("/set/render", "render", -0.75);
    add("/set/proxy", "proxy", 0);
    add("/guides/guide", "guide", 0.75);
    add("/guides/hidden", "hidden", 1.5);
    index->SyncAll();
  }

  void add(const char* path, const char* tag, double x) {
    host::MeshDescription mesh = quad();
    mesh.transform = Matrix4d().setScale(0.25);
    mesh.transform[3][0] = x;
    mesh.renderTag = tag;
    mesh.displayStyle.refineLevel = 2;
    mesh.topology.scheme = "bilinear";
    scene.SetMesh(path, mesh);
  }

  struct View {
    std::unique_ptr<RenderPass> pass;
    RenderBuffer* buffer = nullptr;
    RenderPassState state;
  };
  View view(const char* buffer) {
    View v{delegate->CreateRenderPass(), add_buffer(buffer, kSize, kSize, Format::int32), {}};
    index->SyncAll();
    v.state = state_for(kSize, kSize, "primId", v.buffer);
    return v;
  }

  /// The names of the meshes in the picture.
  std::set<std::string> drawn(const View& v) {
    EXPECT_TRUE(finish(*v.pass, v.state));
    std::set<std::string> names;
    for (const int32_t id : pixels<int32_t>(v.buffer)) {
      const std::string path = index->GetRprimPathFromPrimId(id).str();
      if (id >= 0) names.insert(path.substr(path.rfind('/') + 1));
    }
    return names;
  }
};

using Names = std::set<std::string>;

// promise: embedding.selection.tags
TEST(Selection, APassDrawsTheTagsThatItLists) {
  Tagged stage;
  Tagged::View view = stage.view("/ids");
  EXPECT_EQ(stage.drawn(view), (Names{"geometry", "render"})) << "the default is the final picture";
  view.state.renderTags = {"geometry", "proxy"};
  EXPECT_EQ(stage.drawn(view), (Names{"geometry", "proxy"}));
  view.state.renderTags = {"guide"};
  EXPECT_EQ(stage.drawn(view), (Names{"guide"}));
  view.state.renderTags = {};
  EXPECT_EQ(stage.drawn(view), (Names{"geometry", "render", "proxy", "guide"}));
  view.state.renderTags = {"hidden"};
  EXPECT_EQ(stage.drawn(view), (Names{"hidden"}));
  view.state.renderTags = {"nobody"};
  EXPECT_EQ(stage.drawn(view), Names());
  EXPECT_TRUE(stage.take_diagnostics().empty());
}

// promise: embedding.selection.collection
TEST(Selection, CollectionsTakeWhatLiesBelowTheirRoots) {
  Tagged stage;
  stage.add("/settee", "geometry", 0.75);
  stage.index->SyncAll();
  Tagged::View view = stage.view("/ids");
  view.state.collection.rootPaths = {"/set/"};
  EXPECT_EQ(stage.drawn(view), (Names{"geometry", "render"})) << "/settee is not below /set";
  view.state.collection = {{"/settee", "/set/render"}, {}};
  EXPECT_EQ(stage.drawn(view), (Names{"settee", "render"}));
  view.state.collection = {{"/"}, {"/set"}};
  EXPECT_EQ(stage.drawn(view), (Names{"settee"}));
  view.state.collection = {{}, {"/set/geometry"}};
  EXPECT_EQ(stage.drawn(view), (Names{"settee", "render"}));
  view.state.collection = {{"/nowhere"}, {}};
  EXPECT_EQ(stage.drawn(view), Names());
  view.state.collection = {};
  view.state.renderTags = {"render"};
  EXPECT_EQ(stage.drawn(view), (Names{"render"}));
}

// No Sync between them, and meshes of equal geometry are refined once.
TEST(Selection, TogglingBuildsNothingAgain) {
  Tagged stage;
  Tagged::View view = stage.view("/ids");
  EXPECT_EQ(stage.drawn(view), (Names{"geometry", "render"}));
  const double without = stage.stat("sync.refineWallSeconds");
  view.state.renderTags = {"proxy"};
  EXPECT_EQ(stage.drawn(view), (Names{"proxy"}));
  const double once = stage.stat("sync.refineWallSeconds");
  EXPECT_EQ(once, without) << "the proxy has the geometry of what was drawn before";
  for (const char* tag : {"geometry", "proxy", "render", "proxy"}) {
    view.state.renderTags = {tag};
    EXPECT_EQ(stage.drawn(view), (Names{tag}));
  }
  EXPECT_EQ(stage.stat("sync.refineWallSeconds"), once);
}

TEST(Selection, PassesOfOneDelegateMayDiffer) {
  Tagged stage;
  Tagged::View a = stage.view("/a"), b = stage.view("/b");
  b.state.renderTags = {"proxy"};
  b.state.collection.rootPaths = {"/set"};
  EXPECT_EQ(stage.drawn(a), (Names{"geometry", "render"}));
  EXPECT_EQ(stage.drawn(b), (Names{"proxy"}));
  const double number = stage.stat("sceneNumber");
  EXPECT_EQ(stage.drawn(a), (Names{"geometry", "render"}));
  EXPECT_EQ(stage.drawn(b), (Names{"proxy"}));
  EXPECT_EQ(stage.stat("sceneNumber"), number) << "no scene is built for passes that go on";
  EXPECT_TRUE(a.pass->IsConverged());

  // An edit reaches both, each in its own scene.
  stage.add("/set/more", "geometry", 1.5);
  stage.add("/set/other", "proxy", 1.5);
  stage.index->SyncAll();
  EXPECT_EQ(stage.drawn(a), (Names{"geometry", "render", "more"}));
  EXPECT_EQ(stage.drawn(b), (Names{"proxy", "other"}));
  stage.scene.Remove("/set/proxy");
  stage.index->SyncAll();
  EXPECT_EQ(stage.drawn(b), (Names{"other"}));
  EXPECT_EQ(stage.drawn(a), (Names{"geometry", "render", "more"}));
  b.pass.reset();
  EXPECT_EQ(stage.drawn(a), (Names{"geometry", "render", "more"}));
}

// A host with two views executes both in each turn, and an edit cancels the build before.
TEST(Selection, PassesThatTakeTurnsBothConverge) {
  Tagged stage;
  Tagged::View a = stage.view("/a"), b = stage.view("/b");
  b.state.renderTags = {"proxy"};
  for (int edit = 0; edit < 5; ++edit) {
    stage.add("/set/more", edit % 2 ? "proxy" : "geometry", 1.5);
    stage.index->SyncAll();
    for (int i = 0; i < 2000 && !(a.pass->IsConverged() && b.pass->IsConverged()); ++i) {
      a.pass->Execute(a.state);
      b.pass->Execute(b.state);
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    EXPECT_EQ(stage.drawn(a).contains("more"), edit % 2 == 0) << edit;
    EXPECT_EQ(stage.drawn(b).contains("more"), edit % 2 == 1) << edit;
    EXPECT_TRUE(a.pass->IsConverged() && b.pass->IsConverged()) << edit;
  }
}

// As C and Python do: each is executed once.
TEST(Selection, ASceneThatIsRefusedLeavesTheOtherPassAlone) {
  Tagged stage;
  Tagged::View a = stage.view("/a"), b = stage.view("/b");
  b.state.renderTags = {"proxy"};
  stage.add("/set/more", "geometry", 1.5);
  stage.index->SyncAll();
  const auto execute = [&](int times, const auto& is_over) {
    for (int i = 0; i < times && !is_over(); ++i) {
      a.pass->Execute(a.state);
      b.pass->Execute(b.state);
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
  };
  execute(2000, [&] { return a.pass->IsConverged() && b.pass->IsConverged(); });
  stage.delegate->SetRenderSetting("memoryLimit", int64_t(stage.stat("memoryInUse") / (1 << 20) + 4));
  host::MeshDescription large = Stage::cube(7);
  large.renderTag = "proxy";
  stage.scene.SetMesh("/set/large", large);
  stage.add("/set/more", "geometry", 0.4);
  stage.index->SyncAll();
  execute(2000, [&] { return a.pass->IsConverged() && b.pass->GetState() == PassState::failed; });
  EXPECT_TRUE(a.pass->IsConverged());
  EXPECT_EQ(b.pass->GetState(), PassState::failed);
  EXPECT_TRUE(stage.drawn(a).contains("more"));
}

TEST(Selection, PassesThatAreExecutedOnceBothEnd) {
  Tagged stage;
  Tagged::View a = stage.view("/a"), b = stage.view("/b");
  b.state.renderTags = {"proxy"};
  for (int i = 0; i < 3; ++i) {
    stage.add("/set/more", "hidden", i);
    stage.index->SyncAll();
    a.pass->Execute(a.state);
    b.pass->Execute(b.state);
    for (const Tagged::View* view : {&a, &b}) {
      EXPECT_TRUE(view->pass->WaitForConvergence(20));
      view->pass->Execute(view->state);
      EXPECT_TRUE(view->pass->IsConverged());
    }
  }
}

}  // namespace
}  // namespace alabaster::hd
