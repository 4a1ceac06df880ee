#include "core/subsurface/mesh_interior.h"

#include <gtest/gtest.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <chrono>
#include <cstdlib>
#include <future>

#include "testenv/support/scene_builder.h"

namespace alabaster {
namespace {

// Many tasks of one arena ask for the same parts, each built by parallel loops. A builder that took up another of these
// tasks while it waits for its own loop would wait for itself for ever.
TEST(MeshInterior, TasksThatAskForTheSamePartDoNotWaitForThemselves) {
  const Mesh mesh = testing::sphere_mesh(1, 128, false);
  const auto object = build_object_scene(make_trace_device({}), mesh, {});
  std::promise<void> done;
  std::thread worker([&] {
    tbb::task_arena arena(4);
    arena.execute([&] {
      for (int round = 0; round < 20; ++round) {
        const MeshInterior interior;
        tbb::parallel_for(0, 64, [&](int) {
          EXPECT_TRUE(interior.shells(mesh, *object).triangle_flags.empty());
          EXPECT_TRUE(interior.distances(mesh));
        });
      }
    });
    done.set_value();
  });
  if (done.get_future().wait_for(std::chrono::seconds(120)) != std::future_status::ready) {
    ADD_FAILURE() << "a task waits for a part that it builds itself";
    std::_Exit(EXIT_FAILURE);  // the thread can never be joined
  }
  worker.join();
}

TEST(MeshInterior, PartsAreBuiltOnce) {
  const Mesh mesh = testing::sphere_mesh(1, 8, false);
  const auto object = build_object_scene(make_trace_device({}), mesh, {});
  const MeshInterior interior;
  EXPECT_EQ(&interior.shells(mesh, *object), &interior.shells(mesh, *object));
  EXPECT_EQ(interior.distances(mesh), interior.distances(mesh));
}

}  // namespace
}  // namespace alabaster
