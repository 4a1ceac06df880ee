#include "delegate/gltf/gltf_scene.h"

#include <exception>
#include <functional>
#include <utility>

#include "core/math/float_environment.h"
#include "delegate/gltf/gltf_animation.h"
#include "delegate/gltf/gltf_translation.h"
#include "delegate/support/lookup.h"

namespace alabaster::hd::gltf {
namespace {

using host::SourceFault;

// Reports what is thrown, too.
SourceFault run_guarded(Report& report, const std::function<bool()>& work) {
  const FloatEnvironment environment;
  SourceFault fault = SourceFault::input;
  try {
    if (work()) fault = SourceFault::none;
  } catch (const MemoryRefused& e) {
    report.error("memory", "", e.what());
    fault = SourceFault::out_of_memory;
  } catch (const std::bad_alloc&) {
    report.error("memory", "", "not enough memory; split the file");
    fault = SourceFault::out_of_memory;
  } catch (const std::exception& e) {
    report.error("internal", "", std::string("reading failed (") + e.what() + "); export the file again");
  }
  report.finish();
  return fault;
}

class GltfSource : public host::SceneSource {
 public:
  SourceFault Open(const std::string& file, const host::SourceOptions& options, const DiagnosticSink& sink) override {
    Report report(file, sink);
    const SourceFault fault = run_guarded(report, [&] {
      document_.facts.files.push_back(file);
      if (!read_document(file, options, report, &document_)) return false;
      document_.facts.root = root_of(document_);
      document_.facts.varies = document_.animation >= 0;
      animation_ = NodeAnimation(document_);
      refine_level_ = options.refine_level;
      return true;
    });
    return document_.is_choice_wrong ? SourceFault::choice : fault;
  }

  const host::SceneFacts& Facts() const override { return document_.facts; }

  SourceFault Pose(std::optional<double> time, const DiagnosticSink& sink, host::SceneEdits* edits) override {
    Report report(document_.file, sink);
    return run_guarded(report, [&] {
      if (translator_ && !document_.facts.varies) return true;
      animation_.apply(time.value_or(0), &document_.model);
      if (!translator_) add_what_stands_still(edits, report);
      host::SceneEdits moving;
      translator_->add_moving_prims(&moving, report);
      for (const Path& path : std::exchange(posed_, support::keys_of(moving.prims)))
        if (!moving.prims.contains(path)) edits->removed.push_back(path);
      edits->prims.merge(moving.prims);
      edits->names.merge(moving.names);
      if (is_first_) warn_if_empty(*edits, report), close_what_stands_still();
      return !report.failed();
    });
  }

 private:
  void add_what_stands_still(host::SceneEdits* edits, Report& report) {
    translator_.emplace(document_, refine_level_);
    translator_->add_still_prims(edits, report);
    if (!document_.image_light) return;
    const std::string name = "image_" + prim_name(document_.image_light->index, document_.image_light->name);
    edits->set(root_of(document_).append("lights").append(name), translate_image_light(&document_, report));
  }

  static void warn_if_empty(const host::SceneEdits& edits, Report& report) {
    if (host::PrimsOf<host::MeshDescription>(edits.prims).empty())
      report.warning("scene.empty", "", "the scene has nothing to draw");
  }

  // Poses read the nodes, and the accessors of what deforms.
  void close_what_stands_still() {
    is_first_ = false;
    document_.images.clear();
    if (!document_.facts.varies) document_.model = {};
    if (translator_->deforms()) return;
    document_.accessors.clear();
    document_.decoded.clear();
    document_.buffers.clear();
  }

  int refine_level_ = 0;
  Document document_;
  NodeAnimation animation_;
  std::optional<SceneTranslator> translator_;  // none: before the first pose
  bool is_first_ = true;
  std::vector<Path> posed_;  // what moves, in the last pose
};

}  // namespace

std::unique_ptr<host::SceneSource> MakeGltfSource() {
  return std::make_unique<GltfSource>();
}

}  // namespace alabaster::hd::gltf
