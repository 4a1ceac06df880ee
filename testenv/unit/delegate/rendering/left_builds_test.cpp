// Builds of large meshes that were cancelled and end by themselves: nothing of them is seen, and their memory comes
// back.
#include <gtest/gtest.h>

#include <chrono>
#include <thread>

#include "testenv/support/stage.h"

namespace alabaster::hd {
namespace {

using std::chrono::milliseconds;

/// A sheet of 90,000 quads, refined once: enough for a thread of its own.
host::MeshDescription large_mesh() {
  constexpr int kSide = 300;
  std::vector<Vec3f> points;
  std::vector<int32_t> indices;
  for (int y = 0; y <= kSide; ++y)
    for (int x = 0; x <= kSide; ++x) points.emplace_back(float(x) / kSide, float(y) / kSide, float(x * y % 7) / kSide);
  for (int y = 0; y < kSide; ++y)
    for (int x = 0; x < kSide; ++x) {
      const int32_t corner = y * (kSide + 1) + x;
      indices.insert(indices.end(), {corner, corner + 1, corner + kSide + 2, corner + kSide + 1});
    }
  host::MeshDescription mesh = Stage::quad();
  mesh.topology.scheme = "catmullClark";
  mesh.topology.faceVertexCounts = std::vector<int32_t>(indices.size() / 4, 4);
  mesh.topology.faceVertexIndices = std::move(indices);
  mesh.primvars["points"].value = Array<Vec3f>(std::move(points));
  mesh.displayStyle.refineLevel = 1;
  return mesh;
}

class LeftBuilds : public testing::Test {
 protected:
  struct Host {
    explicit Host(int mib) : stage({{"memoryLimit", mib}}) {
      stage.add_basic_scene();
      sync();
      wait();
    }
    void sync() {
      stage.index->SyncAll();
      stage.delegate->CommitResources();
    }
    void wait() { stage.delegate->InvokeCommand("waitForScene", {}); }
    double in_use() const { return stage.stat("memoryInUse"); }
    std::string errors() {
      std::string all;
      for (const Diagnostic& d : stage.take_diagnostics())
        if (d.severity == Severity::error) all += d.where + ": " + d.text + "\n";
      return all;
    }
    /// Adds the mesh and changes its mind after a while.
    void add_for(milliseconds time) {
      stage.scene.SetMesh("/large", large_mesh());
      sync();
      std::this_thread::sleep_for(time);
      stage.scene.Remove("/large");
      sync();
      wait();
    }
    void add() {
      stage.scene.SetMesh("/large", large_mesh());
      sync();
      wait();
    }
    /// Builds that end by themselves take a while.
    void wait_until_in_use_is(double bytes) const {
      for (int i = 0; i < 2000 && in_use() != bytes; ++i) std::this_thread::sleep_for(milliseconds(5));
    }
    Stage stage;
  };
};

TEST_F(LeftBuilds, AbandonedBuildsLeaveNothing) {
  Host host(4096);
  const double before = host.in_use();
  host.add();
  const double whole = host.in_use();
  EXPECT_GT(whole, before + 30e6);
  for (int i = 0; i < 12; ++i) host.add_for(milliseconds(1 + 23 * i));
  host.wait_until_in_use_is(before);
  EXPECT_EQ(host.in_use(), before);
  host.add();
  EXPECT_NEAR(host.in_use(), whole, 1e5) << "Embree's own blocks differ";
  EXPECT_EQ(host.errors(), "");
}

TEST_F(LeftBuilds, MemoryOfAbandonedBuildsIsWaitedFor) {
  int mib = 0;  // that one build needs
  for (mib = 64; mib < 4096; mib += mib / 8) {
    Host host(mib);
    host.add();
    if (host.errors().empty()) break;
  }
  Host host(mib + 8);  // Sync takes the arrays of the next mesh meanwhile
  for (int i = 0; i < 6; ++i) {
    host.add_for(milliseconds(40 + 30 * i));
    host.add();
    EXPECT_EQ(host.errors(), "");
    EXPECT_EQ(host.stage.stat("scene.faultCount"), -1);
    host.stage.scene.Remove("/large");
    host.sync();
    host.wait();
  }
}

TEST_F(LeftBuilds, AbandonedBuildsEndWithTheDelegate) {
  for (int i = 0; i < 6; ++i) {
    Host host(4096);
    host.add_for(milliseconds(10 + 30 * i));
  }
}

}  // namespace
}  // namespace alabaster::hd
