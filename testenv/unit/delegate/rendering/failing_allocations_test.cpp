// Allocations that fail at any place of syncing and rendering a scene: the run ends with an error or as if nothing had
// happened, and the next one is whole. Loading is left out: the destructor of nlohmann::json allocates, and ends the
// program where it cannot.
#include <optional>
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
    std::optional<host::RenderIndex> index;
    try {
      index.emplace(delegate);
      scene->Populate(&*index);
      host::RecordOptions record;
      record.diagnostics = sink;
      record.picture = [outcome](const host::ProductImage& image) {
        const auto& color = image.aovs.at("color").floats;
        outcome->pixels.assign(color.begin(), color.end());
      };
      outcome->done = host::RecordFrame(&*index, scene, settings, record).status == RecordStatus::done;
    } catch (const std::bad_alloc&) {  // of what may throw it: the index, Populate, and what the host allocates itself
      ++outcome->errors;
    }
    scene->Depopulate();
    index.reset();
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

// promise: pipeline.memory.runs_out
TEST_F(FailingAllocations, FailuresOnOtherThreadsAreReportedAndRecovered) {
  run_trials({.allowed_below = 400, .least_failures = 50}, [](size_t i, size_t allowed, bool* is_told) {
    *is_told = i % 2 == 0;
    return testing::FailingMemoryElsewhere(*is_told ? 1 : 50, allowed);
  });
}

/// Sets the mesh /other. The builder's thread is refused the allocation that follows the first `allowed` ones. Returns
/// false if the build made no further allocation.
bool fails_in_the_build(Stage* stage, const host::MeshDescription& other, size_t allowed) {
  const testing::FailingMemoryElsewhere failing(1, allowed);
  stage->scene.SetMesh("/other", other);
  stage->index->SyncAll();
  stage->wait_for_scene();
  return failing.failed();
}

// promise: pipeline.memory.runs_out
TEST_F(FailingAllocations, WhereMemoryRunsOutInTheBuildTheNextCommitBuildsTheWholeScene) {
  Stage stage({{"samples", 1}, {"threads", 1}});
  stage.add_basic_scene();
  host::MeshDescription other = Stage::quad();
  int refused = 0;
  for (size_t allowed = 0; allowed < 400; ++allowed) {
    other.transform[3][0] = 0.001 * double(allowed);
    if (!fails_in_the_build(&stage, other, allowed)) break;
    const bool is_there = !stage.delegate->InvokeCommand("requirements", {}).value.text_or("").empty();
    EXPECT_EQ(is_there, stage.text_stat("scene.faults").empty()) << "after " << allowed << " allocations";
    refused += !is_there;
    stage.index->SyncAll();
    stage.delegate->CommitResources();
    EXPECT_EQ(stage.text_stat("scene.faults"), "") << "after " << allowed << " allocations: the next commit is whole";
  }
  EXPECT_GE(refused, 20);
}

// Memory may run out where the memory limit refuses nothing.
// promise: pipeline.memory.refusal
TEST_F(FailingAllocations, AMeshThatIsNotBuiltForWantOfMemoryIsReportedWithARemedy) {
  Stage stage({{"samples", 1}, {"threads", 1}});
  stage.add_basic_scene();
  host::MeshDescription other = Stage::quad();
  int reported = 0;
  for (size_t allowed = 0; allowed < 400; ++allowed) {
    other.primvars["points"].value = Array<Vec3f>{{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, float(allowed) / 1000}};
    if (!fails_in_the_build(&stage, other, allowed)) break;
    for (const Diagnostic& d : stage.take_diagnostics()) {
      if (d.where != "/other") continue;
      EXPECT_EQ(d.code, "scene.memory") << "after " << allowed << " allocations: " << d.text;
      reported += d.text.find("lower refineLevel") != d.text.npos;
    }
    stage.index->SyncAll();
    stage.delegate->CommitResources();
    stage.wait_for_scene();
  }
  EXPECT_GE(reported, 5);
}

/// A pass over a scene with bodies, one of them a set, a mesh that emits, and a dome with an image.
struct ManyParts {
  ManyParts() {
    stage.add_basic_scene();
    buffer = stage.add_buffer("/color", 8, 8, Format::float32vec4);
    state = Stage::state_for(8, 8, "color", buffer);
    stage.set_surface("/wax", {{"scatterDistance", Vec3f(9, 9, 9)}});
    stage.set_surface("/glow", {{"emission", Vec3f(2, 1, 1)}});
    const auto add = [&](const char* path, double x, const char* material, const char* set) {
      host::MeshDescription mesh = Stage::cube(2);
      mesh.transform[3][0] = x;
      mesh.material = material;
      if (*set) mesh.primvars["subsurfaceSet"] = {Interpolation::constant, {}, std::string(set), {}};
      stage.scene.SetMesh(path, mesh);
    };
    add("/alone", -3, "/wax", "");
    add("/left", 0, "/wax", "set");
    add("/right", 1, "/wax", "set");
    add("/lamp", 4, "/glow", "");
    add_grains();
    const std::string pixels =
        "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 2 +X 1\n" + std::string("\x80\x80\xff\x80\x40\x80\x80\x80");
    const AssetPath image{"sky.hdr", "sky.hdr",
                          std::make_shared<const std::vector<uint8_t>>(pixels.begin(), pixels.end())};
    stage.scene.SetLight("/sky", {.type = "domeLight", .transform = {}, .parameters = {{"texture:file", image}}});
    stage.index->SyncAll();
    pass = stage.delegate->CreateRenderPass();
  }
  // Points make an array of bodies.
  void add_grains() {
    host::InstancerDescription instancer;
    std::vector<Vec3f> places;
    std::vector<int32_t> indices;
    for (int i = 0; i < 8192; ++i) places.emplace_back(0, -6, -0.01f * float(i)), indices.push_back(i);
    instancer.primvars = {{"hydra:instanceTranslations", Array<Vec3f>(places)}};
    instancer.indices["/grains"] = indices;
    host::MeshDescription mesh = Stage::cube(1);
    mesh.material = "/wax";
    mesh.instancer = "/points";
    stage.scene.SetInstancer("/points", instancer);
    stage.scene.SetMesh("/grains", mesh);
  }
  /// Moves a body and the mesh that emits. True if memory failed meanwhile.
  bool fails_to_move(double shift, int refusals, size_t allowed) {
    host::MeshDescription moved = Stage::cube(2);
    moved.transform[3][0] = shift - 3;
    moved.material = "/wax";
    host::MeshDescription lamp = moved;
    lamp.transform[3][0] += 7;
    lamp.material = "/glow";
    const testing::FailingMemoryElsewhere failing(refusals, allowed);
    stage.scene.SetMesh("/alone", moved);
    stage.scene.SetMesh("/lamp", lamp);
    stage.index->SyncAll();
    stage.wait_for_scene();
    return failing.failed();
  }
  bool draw() { return Stage::finish(*pass, state) && pass->GetState() == PassState::converged; }
  std::vector<float> picture() const { return Stage::pixels<float>(buffer); }

  Stage stage{{{"samples", 1}, {"threads", 1}}};
  RenderBuffer* buffer = nullptr;
  RenderPassState state;
  std::unique_ptr<RenderPass> pass;
};

// Bodies, lights and the top level are built after the meshes.
// promise: pipeline.memory.runs_out, pipeline.memory.refusal
TEST_F(FailingAllocations, WhereMemoryRunsOutForAPartThePictureStays) {
  ManyParts parts;
  Stage& stage = parts.stage;
  ASSERT_TRUE(parts.draw());
  int failures = 0, stayed = 0;
  std::mt19937 random(1);
  for (size_t allowed = 0; allowed < 2000; allowed += 1 + random() % 8) {
    const std::vector<float> before = parts.picture();
    if (!parts.fails_to_move(-0.001 - 0.0001 * double(allowed), 1 + failures % 2, allowed)) break;
    ++failures;
    if (!stage.text_stat("error").empty()) {
      ++stayed;
      EXPECT_FALSE(parts.draw());
      EXPECT_EQ(parts.pass->GetState(), PassState::failed) << "after " << allowed << " allocations";
      EXPECT_EQ(parts.picture(), before) << "after " << allowed << " allocations";
    } else {
      EXPECT_TRUE(parts.draw()) << "after " << allowed << " allocations";
      EXPECT_EQ(stage.text_stat("scene.faults"), "") << "after " << allowed << " allocations";
    }
    for (const Diagnostic& d : stage.take_diagnostics()) EXPECT_TRUE(d.code != "" && d.text != "") << d.where;
    stage.index->SyncAll();
    stage.delegate->CommitResources();
    EXPECT_EQ(stage.text_stat("scene.faults"), "") << "after " << allowed << " allocations: the next commit is whole";
    EXPECT_TRUE(parts.draw());
  }
  EXPECT_GE(failures, 40);
  EXPECT_GE(stayed, 30);
}

}  // namespace
}  // namespace alabaster::hd
