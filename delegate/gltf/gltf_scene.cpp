#include "delegate/gltf/gltf_scene.h"

#include <algorithm>
#include <exception>
#include <functional>
#include <utility>

#include "core/math/float_environment.h"
#include "delegate/gltf/gltf_animation.h"
#include "delegate/gltf/gltf_translation.h"
#include "delegate/support/lookup.h"

namespace alabaster::hd::gltf {
namespace {

// Reports what is thrown, too.
GltfFault run_guarded(Report& report, const std::function<bool()>& work) {
  const FloatEnvironment environment;
  GltfFault fault = GltfFault::document;
  try {
    if (work()) fault = GltfFault::none;
  } catch (const MemoryRefused& e) {
    report.error("memory", "", e.what());
    fault = GltfFault::out_of_memory;
  } catch (const std::bad_alloc&) {
    report.error("memory", "", "not enough memory; split the file or lower max_file_bytes");
    fault = GltfFault::out_of_memory;
  } catch (const std::exception& e) {
    report.error("internal", "", std::string("reading failed (") + e.what() + "); export the file again");
  }
  report.finish();
  return fault;
}

template <class T>
std::vector<Path> paths_of(const host::Prims& prims) {
  return support::keys_of(host::PrimsOf<T>(prims));
}

constexpr int kShutterSamples = 5;

// Gives `prims`, which move or deform, their samples over the shutter of `options`.
class MotionSampler {
 public:
  MotionSampler(const GltfOptions& options, host::Prims* prims) : options_(options), prims_(*prims) {}

  // `pose_at` makes the same prims as they are that many seconds after the frame's own time. A prim that is not there
  // at all times, or not placed alike, gets no samples (reported).
  void run(const std::function<host::Prims(double)>& pose_at, Report& report) {
    for (int i = 0; i < kShutterSamples; ++i) {
      const double open = options_.shutter_open, length = options_.shutter_close - open;
      const double seconds = open + length * i / (kShutterSamples - 1);
      frames_.push_back(seconds * options_.frames_per_second);
      poses_.push_back(pose_at(seconds));
    }
    for (auto& [id, prim] : prims_) {
      if (auto* mesh = std::get_if<host::MeshDescription>(&prim)) {
        sample_transform(id, mesh, report);
        for (const char* name : {"points", "normals"}) sample_primvar(id, name, mesh);
      }
      if (auto* camera = std::get_if<host::CameraDescription>(&prim)) sample_transform(id, camera, report);
      if (auto* instancer = std::get_if<host::InstancerDescription>(&prim)) sample_instances(id, instancer, report);
    }
  }

 private:
  template <class T>
  void sample_transform(const Path& id, T* prim, Report& report) const {
    TimeSamples<Matrix4d> samples{frames_, {}};
    for (const host::Prims& pose : poses_) {
      const T* found = host::FindPrim<T>(pose, id);
      if (!found || !is_placed_alike(*found, *prim)) return warn(id, report);
      samples.values.push_back(found->transform);
    }
    if (changes(samples)) prim->transformSamples = std::move(samples);
  }

  void sample_primvar(const Path& id, const char* name, host::MeshDescription* mesh) const {
    if (!mesh->primvars.contains(name)) return;
    TimeSamples<Value> samples{frames_, {}};
    for (const host::Prims& pose : poses_) {
      const auto* found = host::FindPrim<host::MeshDescription>(pose, id);
      if (!found || !is_placed_alike(*found, *mesh) || !(found->topology == mesh->topology)) return;
      samples.values.push_back(found->primvars.at(name).value);
    }
    if (changes(samples)) mesh->primvarSamples[name] = std::move(samples);
  }

  // A mesh may be placed by several nodes, each of which moves by itself.
  void sample_instances(const Path& id, host::InstancerDescription* instancer, Report& report) const {
    const Token name = "hydra:instanceTransforms";
    TimeSamples<Value> samples{frames_, {}};
    for (const host::Prims& pose : poses_) {
      const auto* found = host::FindPrim<host::InstancerDescription>(pose, id);
      if (!found) return warn(id, report);
      samples.values.push_back(found->primvars.at(name));
    }
    if (changes(samples)) instancer->primvarSamples[name] = std::move(samples);
  }

  // Nodes whose morph weights are equal at one time share a mesh there, which an instancer places.
  static bool is_placed_alike(const host::MeshDescription& a, const host::MeshDescription& b) {
    return a.instancer == b.instancer;
  }
  static bool is_placed_alike(const host::CameraDescription&, const host::CameraDescription&) { return true; }

  static void warn(const Path& id, Report& report) {
    report.warning("motion", id.str(),
                   "is not there, or not by itself, at all times of the shutter; it is drawn without motion blur");
  }

  template <class T>
  static bool changes(const TimeSamples<T>& samples) {
    return std::any_of(samples.values.begin(), samples.values.end(),
                       [&](const T& value) { return !(value == samples.values.front()); });
  }

  const GltfOptions& options_;
  host::Prims& prims_;
  std::vector<double> frames_;
  std::vector<host::Prims> poses_;
};

}  // namespace

struct GltfSource::Open {
  GltfOptions options;
  Document document;
  NodeAnimation animation;
  std::optional<SceneTranslator> translator;
  std::vector<Path> posed;  // the prims of the last pose

  bool load(const std::string& file, host::RetainedSceneDelegate* scene, Report& report, GltfSummary* summary) {
    document.summary.files.push_back(file);
    if (!read_document(file, options, report, &document)) return false;
    animation = NodeAnimation(document);
    animation.apply(options.time.value_or(0), &document.model);
    translator.emplace(document, options);
    host::Prims prims = translator->still_prims(report);
    if (document.image_light) {
      const std::string name = "image_" + prim_name(document.image_light->index, document.image_light->name);
      prims[root_of(document, options).append("lights").append(name)] =
          translate_image_light(&document, options.transform, report);
    }
    if (samples_shutter() && translator->deforms())
      hold_more(&document.memory, kShutterSamples * document.summary.memory_bytes, "the geometry over the shutter");
    GltfPrims moving = pose(options.time.value_or(0), report);
    if (report.failed()) return false;
    prims.merge(moving.prims);
    *summary = std::move(document.summary);
    summary->meshes = paths_of<host::MeshDescription>(prims);
    summary->materials = paths_of<MaterialNetwork>(prims);
    summary->cameras = paths_of<host::CameraDescription>(prims);
    summary->lights = paths_of<host::LightDescription>(prims);
    if (summary->meshes.empty()) report.warning("scene.empty", "", "the scene has nothing to draw");
    for (auto& [id, prim] : prims) scene->Set(id, std::move(prim));
    close_what_stands_still();
    return true;
  }

  GltfPrims pose(double time, Report& report) {
    animation.apply(time, &document.model);
    GltfPrims pose{translator->moving_prims(report), {}};
    translator->keep_shapes();
    if (samples_shutter()) {
      Report silent({}, {});
      const auto pose_at = [&](double seconds) {
        animation.apply(time + seconds, &document.model);
        return translator->moving_prims(silent);
      };
      MotionSampler(options, &pose.prims).run(pose_at, report);
    }
    translator->forget_shapes();
    for (const Path& path : std::exchange(posed, support::keys_of(pose.prims)))
      if (!pose.prims.contains(path)) pose.removed.push_back(path);
    return pose;
  }

 private:
  bool samples_shutter() const { return document.animation >= 0 && options.shutter_close > options.shutter_open; }

  // Poses read the nodes, and the accessors of what deforms.
  void close_what_stands_still() {
    document.images.clear();
    if (translator->deforms()) return;
    document.accessors.clear();
    document.decoded.clear();
    document.buffers.clear();
  }
};

GltfSource::GltfSource() = default;
GltfSource::~GltfSource() = default;
GltfSource::GltfSource(GltfSource&&) noexcept = default;
GltfSource& GltfSource::operator=(GltfSource&&) noexcept = default;

GltfSummary GltfSource::Load(const std::string& file, const GltfOptions& options, host::RetainedSceneDelegate* scene,
                             const DiagnosticSink& sink) {
  Report report(file, sink);
  GltfSummary summary;
  summary.fault = run_guarded(report, [&] {
    open_ = std::make_unique<Open>();
    open_->options = options;
    return open_->load(file, scene, report, &summary);
  });
  summary.ok = summary.fault == GltfFault::none;
  if (open_ && open_->document.is_choice_wrong) summary.fault = GltfFault::choice;
  if (!summary.ok || open_->document.animation < 0) open_.reset();
  return summary;
}

std::optional<GltfPrims> GltfSource::Pose(double time, const DiagnosticSink& sink, GltfFault* fault) {
  *fault = GltfFault::none;
  if (!open_) return GltfPrims();
  Report report(open_->document.file, [&sink](const Diagnostic& diagnostic) {
    if (diagnostic.severity == Severity::error && sink) sink(diagnostic);
  });
  std::optional<GltfPrims> prims;
  *fault = run_guarded(report, [&] {
    prims = open_->pose(time, report);
    return !report.failed();
  });
  return *fault == GltfFault::none ? std::move(prims) : std::nullopt;
}

GltfSummary LoadGltf(const std::string& file, const GltfOptions& options, host::RetainedSceneDelegate* scene,
                     const DiagnosticSink& sink) {
  return GltfSource().Load(file, options, scene, sink);
}

}  // namespace alabaster::hd::gltf
