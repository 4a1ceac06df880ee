#include "delegate/tradeoff/scene_renderer.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "delegate/support/lookup.h"

namespace alabaster::tradeoff {
namespace {

using Clock = std::chrono::steady_clock;

}  // namespace

SceneRenderer::SceneRenderer(Scene scene) : scene_(std::move(scene)) {
  frame_ = scene_.scene->GetAllRenderSettings().at(scene_.settings);
  frame_.products.clear();
  frame_.crop.reset();
  for (const auto& [path, mesh] : scene_.scene->GetMeshes())
    if (mesh.topology.scheme != hd::Token("none") && mesh.displayStyle.refineLevel > 0)
      levels_[path] = mesh.displayStyle.refineLevel;
}

void SceneRenderer::set_size(int width, int height) {
  frame_.width = width;
  frame_.height = height;
}

void SceneRenderer::refine(int coarser) {
  if (coarser == coarser_) return;
  coarser_ = coarser;
  for (const auto& [path, level] : levels_) {
    hd::host::MeshDescription mesh = scene_.scene->GetMeshes().at(path);
    mesh.displayStyle.refineLevel = std::max(0, level - coarser);
    scene_.scene->SetMesh(path, std::move(mesh));
  }
}

std::optional<RenderedFrame> SceneRenderer::render(const Configuration& configuration, uint64_t samples, uint32_t seed,
                                                   bool denoise) {
  const auto started = Clock::now();
  refine(configuration.coarser);
  hd::RenderSettingsDescription frame = frame_;
  frame.settings = configuration.settings;
  frame.settings["samples"] = static_cast<int64_t>(samples);
  frame.settings["seed"] = static_cast<int64_t>(seed);
  scene_.scene->SetRenderSettings(scene_.settings, std::move(frame));
  RenderedFrame rendered;
  hd::host::RecordOptions options;
  options.cancel = scene_.cancel;
  options.diagnostics = scene_.diagnostics;
  if (denoise) options.aovs = {"denoised"};
  options.picture = [&](const hd::host::ProductImage& picture) {
    rendered.image = picture_of(picture, "color");
    rendered.denoised = picture_of(picture, "denoised");
  };
  const hd::host::RecordResult result = hd::host::RecordFrame(scene_.index, scene_.scene, scene_.settings, options);
  if (result.status != hd::host::RecordStatus::done) return std::nullopt;
  if (rendered.image.rgb.empty() || (denoise && rendered.denoised.rgb.empty())) {
    if (scene_.diagnostics)
      scene_.diagnostics({hd::Severity::error, "tradeoff.picture", configuration.name,
                          "the render has no colour or holds values that are not finite; please report the scene"});
    return std::nullopt;
  }
  rendered.cost.cpu_seconds = hd::support::number_in(result.stats, "cpuSeconds", 0);
  rendered.cost.denoise_cpu_seconds = hd::support::number_in(result.stats, "denoise.cpuSeconds", 0);
  rendered.cost.denoise_wall_seconds = hd::support::number_in(result.stats, "denoise.seconds", 0);
  rendered.cost.wall_seconds =
      hd::support::number_in(result.stats, "totalClockTime", 0) - rendered.cost.denoise_wall_seconds;
  rendered.cost.reported_error = hd::support::number_in(result.stats, "error.relativeRmse", -1);
  rendered.cost.total_seconds = std::chrono::duration<double>(Clock::now() - started).count();
  return rendered;
}

}  // namespace alabaster::tradeoff
