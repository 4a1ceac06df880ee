// Allocations that fail at any place of syncing and rendering a scene: the run ends with an error or as if nothing had
// happened, and the next one is whole. Loading is left out: the destructor of nlohmann::json allocates, and ends the
// program where it cannot.
#include <random>

#include "delegate/host/frame_recorder.h"
#include "testenv/support/failing_memory.h"
#include "testenv/support/stage.h"
#include "testenv/unit/delegate/description/scene_fixture.h"

namespace alabaster::hd {
namespace {

using host::RecordStatus;

class FailingAllocations : public description::SceneFiles {
 protected:
  struct Outcome {
    bool done = false;
    bool failed = false;  // memory did
    int errors = 0;
    std::string error;  // the last
    std::vector<float> pixels;
  };

  void SetUp() override {
    SceneFiles::SetUp();
    scene_file_ = write("scene.json", R"({"gltf": [{"file": "patch.gltf"}],
      "materials": [{"match": "skin", "set": {"scatterDistance": [0.1, 0.1, 0.1]}}],
      "meshes": [{"match": "patch", "refineLevel": 2}],
      "lights": [{"name": "sky", "type": "domeLight"},
                 {"name": "key", "type": "rectLight", "position": [0, 0, 3], "target": [0, 0, 0]}],
      "camera": {"transform": {"translate": [0, 0, 5]}}, "settings": {"samples": 1, "threads": 2, "resolution": [8, 8]}})");
  }

  /// As a host does: makes a delegate, records a frame, and destroys the delegate.
  static void record(host::RetainedSceneDelegate* scene, const Path& settings, const DiagnosticSink& sink,
                     Outcome* outcome) {
    DelegateOptions options;
    options.diagnostics = sink;
    RenderDelegate* const delegate = CreateAlabasterRenderDelegate(kAbiVersion, &options);
    if (!delegate) return;
    {
      host::RenderIndex index(delegate);
      try {
        scene->Populate(&index);
        host::RecordOptions record;
        record.diagnostics = sink;
        record.picture = [outcome](const host::ProductImage& image) {
          const auto& color = image.aovs.at("color").floats;
          outcome->pixels.assign(color.begin(), color.end());
        };
        outcome->done = host::RecordFrame(&index, scene, settings, record).status == RecordStatus::done;
      } catch (const std::bad_alloc&) {  // of calls that may throw it: Populate, and what the host allocates itself
        ++outcome->errors;
      }
      scene->Depopulate();
    }
    DestroyAlabasterRenderDelegate(delegate);
  }

  /// Records while memory fails: `fail` makes an object that has it fail for as long as it lives.
  template <class Fail>
  Outcome run(const Fail& fail) const {
    Outcome outcome;
    std::mutex mutex;
    const DiagnosticSink sink = [&](const Diagnostic& d) {
      const std::lock_guard lock(mutex);
      if (d.severity != Severity::error) return;
      ++outcome.errors;
      outcome.error = d.where + ": " + d.text;
    };
    host::RetainedSceneDelegate scene;
    const description::SceneFile file = description::LoadScene(scene_file_, &scene, sink);
    EXPECT_TRUE(file.ok);
    const auto failing = fail();
    record(&scene, file.settings, sink, &outcome);
    outcome.failed = failing.failed();
    return outcome;
  }
  Outcome run_whole() const {
    struct Nothing {
      bool failed() const { return false; }
    };
    return run([] { return Nothing(); });
  }

  /// An error may be mended by a later step of the same recording. A report needs memory itself: where several
  /// allocations fail, it may be lost, but not the status.
  static void expect_honest(const Outcome& outcome, const Outcome& whole, bool is_told, size_t allowed) {
    if (outcome.done)
      EXPECT_EQ(outcome.pixels, whole.pixels) << "after " << allowed << " allocations: " << outcome.error;
    else
      EXPECT_TRUE(outcome.failed) << "after " << allowed << " allocations";
    EXPECT_TRUE(!is_told || outcome.done || outcome.errors > 0)
        << (outcome.done ? "done" : "not done") << " with " << outcome.errors << " errors after " << allowed
        << " allocations: " << outcome.error;
  }

  struct Trials {
    size_t allowed_below;  // allocations before the first that is refused
    int least_failures;    // of 150 recordings: with fewer, it is over before they begin to matter
  };
  /// `fail` makes the object that has memory fail, and says if a single allocation does.
  template <class Fail>
  void run_trials(const Trials& s, const Fail& fail) const {
    const Outcome whole = run_whole();
    ASSERT_TRUE(whole.done);
    std::mt19937 random(1);
    int failed = 0;
    for (size_t i = 0; i < 150; ++i) {
      const size_t allowed = random() % s.allowed_below;
      bool is_told = false;
      const Outcome outcome = run([&] { return fail(i, allowed, &is_told); });
      expect_honest(outcome, whole, is_told, allowed);
      failed += outcome.failed;
    }
    EXPECT_GE(failed, s.least_failures);
    EXPECT_EQ(run_whole().pixels, whole.pixels);
  }

  std::string scene_file_;
};

// promise: pipeline.memory.runs_out
TEST_F(FailingAllocations, FailuresOnTheHostsThreadAreReportedAndRecovered) {
  run_trials({.allowed_below = 1500, .least_failures = 100}, [](size_t i, size_t allowed, bool* is_told) {
    *is_told = i % 2 == 0;
    return testing::FailingMemory(allowed, *is_told ? 1 : 50);
  });
}

// Embree allocates in the destructor of a scene whose build has failed: a third refusal in a row may lie there and end
// the process.
// promise: pipeline.memory.runs_out
TEST_F(FailingAllocations, FailuresOnOtherThreadsAreReportedAndRecovered) {
  run_trials({.allowed_below = 400, .least_failures = 50}, [](size_t i, size_t allowed, bool* is_told) {
    *is_told = i % 2 == 0;
    return testing::FailingMemoryElsewhere(static_cast<int>(1 + i % 2), allowed);
  });
}

// One refusal in the builder concerns one mesh or the scene as a whole. Where it concerns a mesh, the others are drawn.
// promise: pipeline.memory.runs_out
TEST_F(FailingAllocations, AMeshForWhichMemoryRunsOutIsLeftOutOfTheScene) {
  Stage stage({{"samples", 1}, {"threads", 1}});
  stage.add_basic_scene();
  host::MeshDescription other = Stage::quad();
  int without_a_mesh = 0;
  for (size_t allowed = 0; allowed < 400; ++allowed) {
    other.transform[3][0] = 0.001 * double(allowed);
    bool failed = false;
    {
      const testing::FailingMemoryElsewhere failing(1, allowed);
      stage.scene.SetMesh("/other", other);
      stage.index->SyncAll();
      stage.wait_for_scene();
      failed = failing.failed();
    }
    if (!failed) break;
    const std::string faults = stage.text_stat("scene.faults");
    const bool lacks_quad = faults.find("/quad: ") != faults.npos, lacks_other = faults.find("/other: ") != faults.npos;
    if (lacks_quad || lacks_other) {
      ++without_a_mesh;
      EXPECT_FALSE(lacks_quad && lacks_other) << "after " << allowed << " allocations: " << faults;
      EXPECT_NE(stage.delegate->InvokeCommand("requirements", {}).value.text_or(""), "") << "there is no scene";
    }
    stage.index->SyncAll();
    stage.delegate->CommitResources();
    EXPECT_EQ(stage.text_stat("scene.faults"), "") << "after " << allowed << " allocations: the next commit is whole";
  }
  EXPECT_GE(without_a_mesh, 2);
  EXPECT_GE(stage.count("instance.memory"), 1u) << "while the mesh is placed";
  EXPECT_GE(stage.count("mesh.memory"), 1u) << "while it is translated";
}

TEST_F(FailingAllocations, SettingsAreSetAllOrNone) {
  Stage stage;
  const Dictionary settings = {
      {"host:name", std::string("a text that is longer than any small string")}, {"maxDepth", 3}, {"samples", 7}};
  int refused = 0;
  for (size_t allowed = 0;; ++allowed) {
    const uint32_t version = stage.delegate->GetRenderSettingsVersion();
    bool is_set = false, failed = false;
    {
      const testing::FailingMemory failing(allowed, 1);
      is_set = stage.delegate->SetRenderSettings(settings);
      failed = failing.failed();
    }
    for (const auto& [name, value] : settings)
      EXPECT_EQ(stage.delegate->GetRenderSetting(Token(name)).number_or(-1) == value.number_or(-1) &&
                    stage.delegate->GetRenderSetting(Token(name)).text_or("") == value.text_or(""),
                is_set)
          << name << " after " << allowed << " allocations";
    EXPECT_EQ(stage.delegate->GetRenderSettingsVersion(), version + (is_set ? 3 : 0));
    if (!failed) break;
    refused += !is_set;
    for (const auto& [name, value] : settings) stage.delegate->SetRenderSetting(Token(name), {});
  }
  EXPECT_GE(refused, 5);
}

}  // namespace
}  // namespace alabaster::hd
