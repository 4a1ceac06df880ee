#include "testenv/fuzz/small_render.h"

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>

namespace alabaster::fuzz {
namespace {

constexpr double kMemoryLimitMib = 512;

struct Folder {
  std::string path = (std::filesystem::temp_directory_path() / "alabaster_fuzz_XXXXXX").string();
  Folder() {
    if (!mkdtemp(path.data())) broken("no temporary folder could be made");
  }
  ~Folder() {
    std::error_code ignored;
    std::filesystem::remove_all(path, ignored);
  }
};

struct DestroyDelegate {
  void operator()(hd::RenderDelegate* delegate) const { DestroyAlabasterRenderDelegate(delegate); }
};

/// Hears all reports. Each must have a text.
class Reports {
 public:
  hd::DiagnosticSink sink() {
    return [this](const hd::Diagnostic& d) {
      if (d.text.empty()) broken("a report without text: " + d.code);
      const std::lock_guard lock(mutex_);
      errors_ += d.severity == hd::Severity::error;
      last_ = d.where + ": " + d.text;
    };
  }
  int errors() const { return errors_; }
  const std::string& last() const { return last_; }

 private:
  std::mutex mutex_;
  int errors_ = 0;
  std::string last_;
};

void check_pixels(const hd::host::ProductImage& image) {
  for (const auto& [name, pixels] : image.aovs)
    for (const float value : pixels.floats)
      if (!std::isfinite(value)) broken("a pixel of '" + name + "' is not finite");
}

}  // namespace

const std::string& scratch_folder() {
  static const Folder folder;
  return folder.path;
}

std::string scratch_file(const std::string& name, Bytes bytes) {
  const std::string file = scratch_folder() + "/" + name;
  std::ofstream stream(file, std::ios::binary | std::ios::trunc);
  stream.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  if (!stream.flush()) broken("'" + file + "' could not be written");
  return file;
}

void broken(const std::string& promise) {
  std::fprintf(stderr, "broken promise: %s\n", promise.c_str());
  std::abort();
}

hd::host::RecordResult render_small(hd::host::RetainedSceneDelegate* scene, const SmallRender& render) {
  Reports reports;
  hd::DelegateOptions with;
  with.diagnostics = reports.sink();
  with.settings = {{"memoryLimit", kMemoryLimitMib}};
  const std::unique_ptr<hd::RenderDelegate, DestroyDelegate> delegate(
      CreateAlabasterRenderDelegate(hd::kAbiVersion, &with));
  if (!delegate) broken("no delegate: " + reports.last());
  hd::host::RenderIndex index(delegate.get());
  hd::RenderSettingsDescription settings = scene->GetAllRenderSettings().at(render.settings);
  settings.width = settings.height = 4;
  settings.crop.reset();
  settings.products.clear();
  settings.settings = {{"samples", 1}, {"threads", 1}, {"maxDepth", 3}, {"memoryLimit", kMemoryLimitMib}};
  scene->SetRenderSettings(render.settings, settings);
  scene->Populate(&index);
  hd::host::RecordOptions options = render.options;
  options.diagnostics = reports.sink();
  options.picture = check_pixels;
  const hd::host::RecordResult result = hd::host::RecordFrame(&index, scene, render.settings, options);
  using hd::host::RecordStatus;
  if (result.status == RecordStatus::done && reports.errors() > 0) broken("done after an error: " + reports.last());
  if (result.status != RecordStatus::done && reports.errors() == 0) broken("a failure without an error");
  if (render.counts_are_ours && result.stats.contains("nonfiniteSamples") &&
      result.stats.at("nonfiniteSamples").number_or(0) > 0) {
    std::string causes;
    for (const auto& [key, value] : result.stats)
      if (key.starts_with("nonfiniteSamples") && value.number_or(0) > 0) causes += " " + key;
    broken("a sample was not finite:" + causes);
  }
  scene->Depopulate();
  return result;
}

void add_stage(hd::host::RetainedSceneDelegate* scene) {
  scene->SetLight("/dome", {"domeLight", {}, {{"intensity", 1.0f}}});
  hd::CameraDescription camera;
  camera.transform.setTranslation(hd::Vec3d(0, 0, 6));
  camera.parameters = {{"focalLength", 0.05f}, {"horizontalAperture", 0.036f}, {"verticalAperture", 0.036f}};
  scene->SetCamera("/camera", camera);
  hd::RenderSettingsDescription settings;
  settings.camera = "/camera";
  scene->SetRenderSettings("/settings", settings);
}

void add_cube(hd::host::RetainedSceneDelegate* scene, const hd::Path& material) {
  hd::host::MeshDescription mesh;
  std::vector<hd::Vec3f> points;
  std::vector<hd::Vec2f> st;
  for (int i = 0; i < 8; ++i) {
    const auto side = [i](int bit) { return (i >> bit & 1) != 0 ? 1.0f : -1.0f; };
    points.emplace_back(side(2), side(1), side(0));
    st.emplace_back(side(2), side(1));
  }
  mesh.topology.faceVertexCounts = {4, 4, 4, 4, 4, 4};
  mesh.topology.faceVertexIndices = {0, 1, 3, 2, 4, 6, 7, 5, 0, 4, 5, 1, 2, 3, 7, 6, 0, 2, 6, 4, 1, 5, 7, 3};
  mesh.primvars["points"].value = hd::Array<hd::Vec3f>(points);
  mesh.primvars["st"].value = hd::Array<hd::Vec2f>(st);
  mesh.material = material;
  scene->SetMesh("/cube", mesh);
}

void load_and_render(const std::string& file, const hd::description::LoadOptions& options) {
  Reports reports;
  hd::host::RetainedSceneDelegate scene;
  const hd::description::SceneFile loaded = hd::description::LoadScene(file, &scene, reports.sink(), options);
  if (loaded.ok && reports.errors() > 0) broken("loaded after an error: " + reports.last());
  if (!loaded.ok && reports.errors() == 0) broken("not loaded, without an error");
  if (loaded.ok) render_small(&scene, {.settings = loaded.settings, .options = {}});
}

}  // namespace alabaster::fuzz
