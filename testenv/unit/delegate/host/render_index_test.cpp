#include "delegate/host/render_index.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>

#include "delegate/host/retained_scene_delegate.h"
#include "testenv/unit/delegate/host/fake_delegate.h"

namespace alabaster::hd::host {
namespace {

using Lines = std::vector<std::string>;

struct Scene {
  FakeDelegate delegate;
  RenderIndex index{&delegate};
  RetainedSceneDelegate scene;

  Lines sync() {
    delegate.journal.take();
    index.SyncAll();
    return delegate.journal.take();
  }
  DirtyBits bits(const char* id) { return index.GetChangeTracker().Get(id); }
};

MeshDescription triangle() {
  MeshDescription mesh;
  mesh.topology.faceVertexCounts = {3};
  mesh.topology.faceVertexIndices = {0, 1, 2};
  mesh.primvars["points"].value = Array<Vec3f>{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  return mesh;
}

TEST(RenderIndex, SyncsInTheContractsOrderWhateverTheOrderOfInsertion) {
  Scene s;
  s.scene.SetMesh("/a_mesh", triangle());
  s.scene.SetInstancer("/a_instancer", {});
  s.scene.SetLight("/a_light", {.type = "domeLight", .transform = {}, .parameters = {}});
  s.scene.SetLight("/b_light", {.type = "rectLight", .transform = {}, .parameters = {}});
  s.scene.SetMaterial("/a_material", {});
  s.scene.SetCamera("/z_camera", {});
  s.scene.SetRenderBuffer("/a_buffer", {});
  s.scene.SetRenderSettings("/z_settings", {});
  s.scene.Populate(&s.index);
  EXPECT_EQ(s.sync(), (Lines{"sync /z_settings", "sync /a_buffer", "sync /z_camera", "sync /a_material",
                             "sync /b_light", "sync /a_light", "sync /a_instancer", "sync /a_mesh", "commit"}));
  EXPECT_EQ(s.sync(), Lines{"commit"}) << "nothing is dirty any more";
}

// Each kind at the path of each other.
TEST(RetainedScene, APrimReplacesThatOfAnotherKind) {
  using Set = std::function<void(RetainedSceneDelegate&)>;
  const std::pair<const char*, Set> kinds[] = {
      {"mesh", [](auto& scene) { scene.SetMesh("/a", triangle()); }},
      {"instancer", [](auto& scene) { scene.SetInstancer("/a", {}); }},
      {"material", [](auto& scene) { scene.SetMaterial("/a", {}); }},
      {"light", [](auto& scene) { scene.SetLight("/a", {.type = "rectLight", .transform = {}, .parameters = {}}); }},
      {"camera", [](auto& scene) { scene.SetCamera("/a", {}); }},
      {"buffer", [](auto& scene) { scene.SetRenderBuffer("/a", {}); }},
      {"settings", [](auto& scene) { scene.SetRenderSettings("/a", {}); }},
  };
  for (const auto& [before, set_before] : kinds) {
    for (const auto& [after, set_after] : kinds) {
      if (before == after) continue;
      Scene s;
      s.scene.Populate(&s.index);
      set_before(s.scene);
      s.sync();
      set_after(s.scene);
      const RetainedSceneDelegate& scene = s.scene;
      EXPECT_LE(scene.GetMeshes().size() + scene.GetInstancers().size() + scene.GetMaterials().size() +
                    scene.GetLights().size() + scene.GetCameras().size() + scene.GetAllRenderSettings().size(),
                1u)
          << before << " " << after;
      EXPECT_EQ(s.delegate.journal.take(), (Lines{"finalize /a", "destroy /a"})) << before << " " << after;
      EXPECT_EQ(s.sync(), (Lines{"sync /a", "commit"})) << before << " " << after;
    }
  }
}

TEST(RenderIndex, ASyncLooksAtDirtyPrimsAlone) {
  Scene s;
  s.scene.Populate(&s.index);
  for (int i = 0; i < 300; ++i) s.scene.SetMesh("/mesh" + std::to_string(i), triangle());
  s.sync();
  EXPECT_TRUE(s.index.GetChangeTracker().GetDirty().empty()) << "clean prims are not kept";
  s.index.GetChangeTracker().MarkDirty("/mesh7", dirty::kTransform);
  EXPECT_EQ(s.index.GetChangeTracker().GetDirty().size(), 1u);
  EXPECT_EQ(s.sync(), (Lines{"sync /mesh7 " + std::to_string(dirty::kTransform), "commit"}));
}

TEST(RenderIndex, EveryMeshIsSyncedOnceInParallel) {
  Scene s;
  s.scene.Populate(&s.index);
  for (int i = 0; i < 300; ++i) s.scene.SetMesh("/mesh" + std::to_string(i), triangle());
  Lines lines = s.sync();
  EXPECT_EQ(lines.size(), 301u);
  EXPECT_EQ(lines.back(), "commit");
  std::sort(lines.begin(), lines.end());
  EXPECT_EQ(std::unique(lines.begin(), lines.end()), lines.end());
}

TEST(RenderIndex, InvisibleMeshesKeepTheirBitsQueued) {
  Scene s;
  s.scene.Populate(&s.index);
  MeshDescription mesh = triangle();
  mesh.visible = false;
  s.scene.SetMesh("/m", mesh);
  EXPECT_EQ(s.sync(), (Lines{"sync /m " + std::to_string(dirty::kVisibility), "commit"}));
  EXPECT_EQ(s.bits("/m"), dirty::kAll & ~dirty::kVisibility);
  EXPECT_EQ(s.sync(), Lines{"commit"});
  mesh.visible = true;
  s.scene.SetMesh("/m", mesh);
  EXPECT_EQ(s.sync(), (Lines{"sync /m", "commit"})) << "the queued prim is synced together with the visibility";
  EXPECT_EQ(s.bits("/m"), dirty::kClean);
}

TEST(RenderIndex, PrimsThatStayDirtyAreSyncedAgain) {
  Scene s;
  s.delegate.prims_leave = dirty::kParams;
  s.scene.Populate(&s.index);
  s.scene.SetCamera("/c", {});
  EXPECT_EQ(s.sync(), (Lines{"sync /c", "commit"}));
  EXPECT_EQ(s.sync(), (Lines{"sync /c " + std::to_string(dirty::kParams), "commit"}));
}

TEST(RenderIndex, UnknownTypesAndTakenIdsAreRefused) {
  Scene s;
  EXPECT_FALSE(s.index.InsertRprim("basisCurves", &s.scene, "/c"));
  EXPECT_FALSE(s.index.InsertSprim("cylinderLight", &s.scene, "/l"));
  EXPECT_FALSE(s.index.InsertBprim("openvdbAsset", &s.scene, "/v"));
  EXPECT_FALSE(s.index.Has("/c"));
  EXPECT_TRUE(s.index.InsertRprim("mesh", &s.scene, "/m"));
  EXPECT_FALSE(s.index.InsertSprim("camera", &s.scene, "/m"));
  EXPECT_EQ(s.index.GetSprim("/m"), nullptr);
  EXPECT_EQ(s.index.GetBprim("/m"), nullptr);
}

TEST(RenderIndex, PrimIdsLeadBackToPathsAndAreReused) {
  Scene s;
  s.index.InsertRprim("mesh", &s.scene, "/a");
  s.index.InsertRprim("mesh", &s.scene, "/b");
  EXPECT_EQ(s.index.GetRprimPathFromPrimId(0), Path("/a"));
  EXPECT_EQ(s.index.GetRprimPathFromPrimId(1), Path("/b"));
  EXPECT_TRUE(s.index.GetRprimPathFromPrimId(2).empty());
  EXPECT_TRUE(s.index.GetRprimPathFromPrimId(-1).empty());
  s.index.Remove("/a");
  EXPECT_TRUE(s.index.GetRprimPathFromPrimId(0).empty());
  s.index.InsertRprim("mesh", &s.scene, "/c");
  EXPECT_EQ(s.index.GetRprimPathFromPrimId(0), Path("/c"));
}

TEST(RenderIndex, FinalizesOnceBeforeItDestroys) {
  FakeDelegate delegate;
  RetainedSceneDelegate scene;
  {
    RenderIndex index(&delegate);
    index.InsertRprim("mesh", &scene, "/m");
    index.InsertInstancer(&scene, "/i");
    index.Remove("/m");
    EXPECT_EQ(delegate.journal.take(), (Lines{"finalize /m", "destroy /m"}));
  }
  EXPECT_EQ(delegate.journal.take(), (Lines{"finalize /i", "destroy /i"}));
}

TEST(RetainedSceneDelegate, SettingWhatIsThereMarksNothing) {
  Scene s;
  s.scene.Populate(&s.index);
  const auto set_all = [&] {
    s.scene.SetMesh("/m", triangle());
    s.scene.SetInstancer("/i", {.transform = {},
                                .parent = {},
                                .primvars = {{"hydra:instanceTranslations", Array<Vec3f>{{1, 2, 3}}}},
                                .indices = {{"/m", {0}}}});
    s.scene.SetMaterial("/mat", {});
    s.scene.SetLight("/l", {.type = "domeLight", .transform = {}, .parameters = {{"intensity", 2.0f}}});
    s.scene.SetCamera("/c", {.transform = {}, .parameters = {{"focalLength", 35.0f}}});
    s.scene.SetRenderBuffer("/b", {.dimensions = {4, 4, 1}, .format = Format::float32});
    s.scene.SetRenderSettings("/s", {});
  };
  set_all();
  s.sync();
  const uint64_t version = s.index.GetChangeTracker().GetVersion();
  for (int i = 0; i < 1000; ++i) set_all();
  EXPECT_EQ(s.index.GetChangeTracker().GetVersion(), version);
}

TEST(RetainedSceneDelegate, MarksExactlyWhatChanged) {
  Scene s;
  s.scene.Populate(&s.index);
  s.scene.SetMesh("/m", triangle());
  s.scene.SetInstancer("/i", {.transform = {}, .parent = {}, .primvars = {}, .indices = {{"/m", {0}}}});
  s.sync();
  const auto bits_after = [&](const std::function<void(MeshDescription&)>& edit) {
    MeshDescription mesh = s.scene.GetMeshes().at("/m");
    edit(mesh);
    s.scene.SetMesh("/m", mesh);
    const DirtyBits bits = s.bits("/m");
    s.sync();
    return bits;
  };
  EXPECT_EQ(bits_after([](auto& m) { m.transform[3][0] = 5; }), dirty::kTransform);
  EXPECT_EQ(bits_after([](auto& m) { m.material = "/other"; }), dirty::kMaterialId);
  EXPECT_EQ(bits_after([](auto& m) { m.displayStyle.refineLevel = 2; }), dirty::kDisplayStyle);
  EXPECT_EQ(bits_after([](auto& m) {
              m.primvars["points"].value = Array<Vec3f>{{0, 0, 1}, {1, 0, 0}, {0, 1, 0}};
            }),
            dirty::kPoints);
  EXPECT_EQ(bits_after([](auto& m) {
              m.primvars["st"].value = Array<Vec2f>{{0, 0}, {1, 0}, {0, 1}};
            }),
            dirty::kPrimvar);
  EXPECT_EQ(bits_after([](auto& m) { m.primvars.erase("st"); }), dirty::kPrimvar) << "a removed primvar is a change";
  EXPECT_EQ(bits_after([](auto& m) { m.topology.holeIndices = {0}; }), dirty::kTopology);
  s.scene.SetInstancer("/i", {.transform = {}, .parent = {}, .primvars = {}, .indices = {{"/m", {0, 1}}}});
  EXPECT_EQ(s.bits("/m"), dirty::kInstanceIndex);
  EXPECT_EQ(s.bits("/i"), dirty::kClean);
}

TEST(RetainedSceneDelegate, ALightOfAnotherTypeIsAnotherPrim) {
  Scene s;
  s.scene.Populate(&s.index);
  s.scene.SetLight("/l", {.type = "rectLight", .transform = {}, .parameters = {}});
  const Sprim* before = s.index.GetSprim("/l");
  ASSERT_NE(before, nullptr);
  s.delegate.journal.take();
  s.scene.SetLight("/l", {.type = "domeLight", .transform = {}, .parameters = {}});
  EXPECT_EQ(s.delegate.journal.take(), (Lines{"finalize /l", "destroy /l"}));
  EXPECT_EQ(s.sync(), (Lines{"sync /l", "commit"}));
}

TEST(RetainedSceneDelegate, APrimOfAnotherSceneIsNotRemoved) {
  Scene s;
  RetainedSceneDelegate other;
  s.scene.SetMesh("/a", triangle());
  s.scene.Populate(&s.index);
  other.Populate(&s.index);
  EXPECT_FALSE(other.Remove("/a"));
  EXPECT_TRUE(s.index.Has("/a"));
}

TEST(RetainedSceneDelegate, DepopulateAndRemoveTakePrimsAway) {
  Scene s;
  s.scene.Populate(&s.index);
  s.scene.SetMesh("/m", triangle());
  s.scene.SetCamera("/c", {});
  s.scene.Remove("/m");
  EXPECT_FALSE(s.index.Has("/m"));
  EXPECT_TRUE(s.scene.GetMeshTopology("/m").faceVertexCounts.empty()) << "unknown ids answer with defaults";
  s.scene.Depopulate();
  EXPECT_FALSE(s.index.Has("/c"));
  EXPECT_EQ(s.scene.GetCameras().size(), 1u) << "the description stays";
}

}  // namespace
}  // namespace alabaster::hd::host
