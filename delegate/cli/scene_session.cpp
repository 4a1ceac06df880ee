#include "delegate/cli/scene_session.h"

#include <set>

#include "delegate/cli/exit_codes.h"

namespace alabaster::cli {

SceneSession::~SceneSession() {
  if (index_) scene.Depopulate();
  index_.reset();
  delegate_.reset();
}

void SceneSession::load(const std::string& name, const hd::description::LoadOptions& options,
                        const hd::DiagnosticSink& sink) {
  options_ = options;
  file = source_.Load(name, &scene, sink, options);
  if (!is_posed_) source_ = {};
  require(exit_code(file.cause));
}

void SceneSession::pose(double time, const hd::DiagnosticSink& sink) {
  require(exit_code(source_.Pose(time, sink)));
}

void SceneSession::choose_colors(const std::string& asked, const hd::DiagnosticSink& sink, int code) {
  colors_.ocio = asked.empty() ? file.color_config : asked;
  colors_.within = asked.empty() ? file.color_config_within : std::string();
  if (hd::host::DescribeColors(colors_, sink).empty()) throw Exit{code};
}

// Their images would be decoded for nothing.
void SceneSession::remove_unused_materials() {
  std::set<hd::Path> used, all;
  for (const auto& [path, mesh] : scene.GetMeshes()) {
    used.insert(mesh.material);
    for (const hd::GeomSubset& subset : mesh.topology.geomSubsets) used.insert(subset.materialId);
  }
  for (const auto& [path, network] : scene.GetMaterials()) all.insert(path);
  for (const hd::Path& path : all)
    if (!used.contains(path)) scene.Remove(path);
}

void SceneSession::start(const hd::DiagnosticSink& sink) {
  remove_unused_materials();
  hd::DelegateOptions options;
  options.diagnostics = sink;
  if (!colors_.ocio.empty()) options.settings["ocio"] = hd::AssetPath{colors_.ocio, colors_.ocio, {}, colors_.within};
  delegate_.reset(CreateAlabasterRenderDelegate(hd::kAbiVersion, &options));
  if (!delegate_) throw Exit{kRender};
  index_ = std::make_unique<hd::host::RenderIndex>(delegate_.get());
  scene.Populate(index_.get());
}

void SceneSession::require_whole() const {
  delegate_->InvokeCommand("waitForScene", {});
  const hd::Dictionary stats = delegate_->GetRenderStats();
  if (stats.contains("scene.faults")) throw Exit{stats.at("scene.outOfMemory").number_or(0) != 0 ? kRender : kInput};
}

}  // namespace alabaster::cli
