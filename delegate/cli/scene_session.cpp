#include "delegate/cli/scene_session.h"

#include <algorithm>
#include <filesystem>
#include <map>

#include "delegate/cli/exit_codes.h"
#include "delegate/host/scene_fields.h"

namespace alabaster::cli {
namespace {

// The files of a set of images, with a number of four digits, if the path names one by "<UDIM>"; else itself.
void add_files(const std::string& image, std::set<std::string>* inputs) {
  inputs->insert(image);
  const std::filesystem::path path(image);
  const std::string name = path.filename().string(), mark = "<UDIM>";
  const size_t at = name.find(mark);
  if (at == std::string::npos) return;
  std::error_code error;
  const std::filesystem::path folder = path.has_parent_path() ? path.parent_path() : ".";
  for (std::filesystem::directory_iterator it(folder, error), end; !error && it != end; it.increment(error)) {
    const std::string file = it->path().filename().string();
    const bool is_named_so = file.size() == name.size() - mark.size() + 4 && file.starts_with(name.substr(0, at)) &&
                             file.ends_with(name.substr(at + mark.size()));
    if (is_named_so && std::all_of(&file[at], &file[at] + 4, [](char c) { return c >= '0' && c <= '9'; }))
      inputs->insert(it->path().string());
  }
}

}  // namespace

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

void SceneSession::pose(double frame, const hd::DiagnosticSink& sink) {
  // An error after which the pose is there all the same is a fault that is kept, by keep_going.
  const auto note = [&](const hd::Diagnostic& told) {
    if (told.severity == hd::Severity::error && !file.models.empty())
      file.models[0].faults.push_back(told.where + ": " + told.text);
    sink(told);
  };
  require(exit_code(source_.PoseFrame(frame, note)));
}

void SceneSession::choose_colors(const std::string& asked, const hd::DiagnosticSink& sink, int code) {
  colors_.ocio = asked.empty() ? file.color_config : asked;
  colors_.within = asked.empty() ? file.color_config_within : std::string();
  if (hd::host::DescribeColors(colors_, sink).empty()) throw Exit{code};
}

// Their images would be decoded for nothing.
void SceneSession::remove_unused_materials() {
  std::set<hd::Path> used, all;
  for (const auto& [path, prim] : scene.GetPrims())
    for (const auto& [name, value] : hd::host::GetFields(path, prim))
      if (const auto* named = value.get<hd::Path>()) used.insert(*named);
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

std::vector<std::string> SceneSession::faults() const {
  std::vector<std::string> all;
  for (const auto& model : file.models) all.insert(all.end(), model.faults.begin(), model.faults.end());
  return all;
}

int SceneSession::fault_code() const {
  delegate_->InvokeCommand("waitForScene", {});
  const hd::Dictionary stats = delegate_->GetRenderStats();
  if (!stats.contains("scene.faults")) return kDone;
  return stats.at("scene.outOfMemory").number_or(0) != 0 ? kRender : kInput;
}

bool is_added(const hd::host::RetainedSceneDelegate& scene, const hd::Path& path) {
  return path == hd::Path("/studio/backdrop") || path == hd::Path("/lights/default_dome") ||
         scene.GetName(path).starts_with("studio_");
}

hd::description::WorldBox objects_box(hd::host::RetainedSceneDelegate& scene) {
  hd::description::WorldBox all;
  const auto boxes = hd::description::MeshBoxes(scene);
  for (const auto& [path, mesh] : scene.GetMeshes())
    for (int i = 0; i < 3 && mesh.visible && !is_added(scene, path); ++i) {
      all.min[i] = std::min(all.min[i], boxes.at(path).min[i]);
      all.max[i] = std::max(all.max[i], boxes.at(path).max[i]);
    }
  return all;
}

std::set<std::string> scene_files(const SceneSession& session, const std::string& scene) {
  std::set<std::string> inputs{scene};
  const auto add_images = [&](const std::map<hd::Token, hd::Value>& parameters) {
    for (const auto& [name, value] : parameters)
      if (const auto* image = value.get<hd::AssetPath>()) add_files(image->resolved, &inputs);
  };
  for (const auto& model : session.file.models) inputs.insert(model.files.begin(), model.files.end());
  for (const auto& [path, light] : session.scene.GetLights()) add_images(light.parameters);
  for (const auto& [path, network] : session.scene.GetMaterials())
    for (const auto& [node_path, node] : network.nodes) add_images(node.parameters);
  inputs.erase("");
  return inputs;
}

std::string input_overwritten(const std::vector<std::string>& outputs, const SceneSession& session,
                              const std::string& scene) {
  std::set<std::string> inputs = scene_files(session, scene);
  inputs.insert(session.colors().ocio);
  for (const std::string& output : outputs)
    for (const std::string& input : inputs) {
      std::error_code error;
      const bool regular = std::filesystem::is_regular_file(output, error);
      if (regular && std::filesystem::equivalent(output, input, error))
        return "'" + output + "' is an input of this scene: choose another name for the output.";
    }
  return "";
}

}  // namespace alabaster::cli
