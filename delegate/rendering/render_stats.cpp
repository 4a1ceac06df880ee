#include <cmath>

#include "core/diagnostics/plain_format.h"
#include "delegate/rendering/camera_matrices.h"
#include "delegate/rendering/render_delegate_impl.h"
#include "delegate/rendering/render_pass.h"
#include "delegate/support/process_usage.h"

namespace alabaster::hd::rendering {
namespace {

// Names of PassState and of RenderEnd.
constexpr const char* kStates[] = {"idle", "preparing", "rendering", "paused", "stopped", "converged", "failed"};
constexpr const char* kEnds[] = {"", "samples", "targetError", "timeLimit"};
static_assert(std::size(kStates) == size_t(PassState::failed) + 1 &&
              std::size(kEnds) == size_t(RenderEnd::time_limit) + 1);

Value count(uint64_t n) {
  return static_cast<int64_t>(n);
}

void add_counters(const RenderCounters& c, Dictionary* stats) {
  Dictionary& s = *stats;
  for (const CounterRow& row : kCounters)
    if (*row.name) s[row.name] = count(c.*row.member);
  for (size_t i = 0; i < c.nonfinite_causes.size(); ++i)
    s[std::string("nonfiniteSamples.") + kNonfiniteCauses[i]] = count(c.nonfinite_causes[i]);
  s["walk.lostEnergy"] = c.walk_lost_energy;
  s["walk.maxWeight"] = c.max_walk_weight;
}

// A render that missed its target error, or may have, tells the error that it reached and the cost of the target.
std::string missed_target_text(const RenderProgress& p, double samples, double more) {
  const std::string end =
      (p.ended_by == RenderEnd::samples      ? "The limit of samples per pixel ended the render"
       : p.ended_by == RenderEnd::time_limit ? "The time limit ended the render"
                                             : "The render ended by the errors of groups of pixels") +
      plain_format(" after %.0f samples per pixel. ", samples);
  if (!p.noise.known || p.noise.low == 0)
    return end + plain_format("Whether it reached its target error of %.3g is not known", p.target_error);
  if (!p.noise.is_bounded())
    return end + plain_format("Whether it reached its target error of %.3g is not known: its error is at least %.3g",
                              p.target_error, p.noise.low);
  const std::string doubt =
      p.noise.relative_rmse <= p.target_error ? plain_format(" and may be up to %.3g", p.noise.high) : "";
  return end + plain_format(
                   "Its error is %.3g%s, and its target was %.3g, which would take about %.3g samples per pixel "
                   "and %.3g seconds (%.3g CPU seconds)",
                   p.noise.relative_rmse, doubt.c_str(), p.target_error, std::ceil(samples * more),
                   p.wall_seconds * more, p.cpu_seconds * more);
}

// The cause of a render's end; where its target error is missed, also the cost of reaching it.
void add_end(const RenderProgress& p, double samples, Dictionary* stats) {
  // Groups of pixels end each other: the frame may end a fifth above the target. Where its interval ends above that,
  // it may have missed.
  constexpr double kSlack = 1.2;
  Dictionary& s = *stats;
  if (p.ended_by == RenderEnd::none || p.state != SessionState::finished) return;
  s["endedBy"] = std::string(kEnds[static_cast<size_t>(p.ended_by)]);
  if (!(p.target_error > 0)) return;
  const double allowed = p.target_error * (p.ended_by == RenderEnd::target_error ? kSlack : 1.0);
  const bool missed =
      !(p.noise.relative_rmse <= allowed) || !(p.noise.high <= kSlack * p.target_error) || !p.noise.is_bounded();
  s["target.error"] = p.target_error;
  s["target.missed"] = missed;
  if (!missed) return;
  const double doubtful = std::max(p.noise.with_doubt(), p.noise.high / kSlack);
  const double reached = p.noise.relative_rmse > p.target_error ? p.noise.relative_rmse : doubtful;
  const double more = std::max(1.0, std::pow(reached / p.target_error, 2));
  s["target.message"] = missed_target_text(p, samples, more);
  if (!p.noise.known) return;
  s["target.samples"] = std::ceil(samples * more);
  s["target.seconds"] = p.wall_seconds * more;
  s["target.cpuSeconds"] = p.cpu_seconds * more;
}

void add_camera(const PassControl& pass, Dictionary* stats) {
  const auto camera = pass.camera();
  if (!camera) return;
  const CameraMatrices matrices = camera_matrices(*camera);
  (*stats)["camera.worldToCamera"] = matrices.world_to_camera;
  (*stats)["camera.worldToNDC"] = matrices.world_to_ndc;
}

void add_progress(const PassControl& pass, Dictionary* stats) {
  Dictionary& s = *stats;
  const RenderProgress p = pass.progress();
  const uint64_t pixels = std::max(p.pixels, uint64_t(1));
  PassState state = pass.state();
  // GetState changes at Execute alone. Readers of statistics need not execute: the last sample is the end.
  if (state == PassState::rendering && p.state == SessionState::finished) state = PassState::converged;
  s["state"] = std::string(kStates[static_cast<size_t>(state)]);
  const double fraction = pass.is_converged() ? 1.0 : p.fraction;
  s["fractionDone"] = fraction;
  s["percentDone"] = 100.0 * fraction;
  s["totalClockTime"] = p.wall_seconds;
  s["cpuSeconds"] = p.cpu_seconds;
  s["renderProgressAnnotation"] = std::to_string(p.passes_done) + " passes";
  if (p.denoised >= 0) {
    const auto percent = static_cast<int>(100 * p.denoised);
    s["renderProgressAnnotation"] = "denoising " + std::to_string(percent) + " %";
    s["denoise.fraction"] = p.denoised;
    s["denoise.seconds"] = p.denoise_seconds;
    s["denoise.cpuSeconds"] = p.denoise_cpu_seconds;
  }
  if (!p.denoise_error.empty()) s["denoise.error"] = p.denoise_error;
  if (!p.denoiser.empty()) s["denoiser"] = p.denoiser;
  s["passesDone"] = count(p.passes_done);
  s["covered"] = p.covered;
  if (p.pixels_without_sample > 0) s["pixelsWithoutSample"] = count(p.pixels_without_sample);
  s["samplesTotal"] = count(p.samples_total / pixels);
  s["numCompletedSamples"] = count(p.samples_done / pixels);
  if (p.noise.known) {
    s["error.relativeRmse"] = p.noise.relative_rmse;
    s["error.low"] = p.noise.low;
    s["error.high"] = p.noise.high;
    s["error.samples"] = static_cast<double>(p.noise_samples) / static_cast<double>(pixels);
    s["error.isKnown"] = p.noise.is_bounded();
    if (p.groups_over_frame > 0) s["error.groupsOverFrame"] = p.groups_over_frame;
  }
  add_end(p, static_cast<double>(p.samples_done) / static_cast<double>(pixels), stats);
  s["filmMemory"] = count(pass.film_memory());
  add_counters(p.counters, stats);
  if (const auto suspect = p.failed_sample ? p.failed_sample : p.counters.first_nonfinite)
    s["suspectSample"] =
        std::to_string(suspect->x) + "," + std::to_string(suspect->y) + "," + std::to_string(suspect->sample);
  if (const std::string error = pass.error(); !error.empty()) s["error"] = error;
  if (pass.is_refused()) s["refused"] = true;
}

void add_scene_faults(const DelegateState& delegate, Dictionary* stats) {
  constexpr size_t kMostLines = 100;
  bool input = true;
  const std::vector<std::string> faults = delegate.scene_faults(&input);
  if (faults.empty()) return;
  std::string lines;
  for (size_t i = 0; i < std::min(faults.size(), kMostLines); ++i) lines += (i ? "\n" : "") + faults[i];
  (*stats)["scene.faults"] = lines;
  (*stats)["scene.faultCount"] = count(faults.size());
  (*stats)["scene.outOfMemory"] = !input;
}

}  // namespace

Dictionary pass_stats(const PassControl& pass) {
  Dictionary stats;
  add_progress(pass, &stats);
  add_camera(pass, &stats);
  stats.erase("filmMemory");
  return stats;
}

// With several passes, the statistics are those of the pass that was created last. Those of the last one that is gone
// are kept until there is another.
Dictionary RenderDelegateImpl::GetRenderStats() const {
  Dictionary stats;
  prims::guarded(delegate_->param->sink(), "GetRenderStats", [&] {
    stats["rendererName"] = std::string("Alabaster");
    stats["state"] = std::string("idle");
    stats["peakMemory"] = count(support::peak_memory_bytes());
    stats["memoryLimit"] = count(delegate_->param->memory()->limit());
    stats["memoryInUse"] = count(delegate_->param->memory()->in_use());
    const auto snapshot = delegate_->snapshot();
    if (const std::string error = delegate_->commit_error(snapshot.get()); !error.empty()) stats["error"] = error;
    stats["sceneNumber"] = count(snapshot ? snapshot->number : 0);
    stats["totalMemory"] = count(snapshot ? snapshot->memory_bytes : 0);
    add_scene_faults(*delegate_, &stats);
    const auto refine = delegate_->param->build_clock.seconds(prims::BuildPhase::refine);
    const auto bvh = delegate_->param->build_clock.seconds(prims::BuildPhase::bvh);
    stats["sync.refineSeconds"] = refine.cpu;
    stats["sync.refineWallSeconds"] = refine.wall;
    stats["sync.bvhSeconds"] = bvh.cpu;
    stats["sync.bvhWallSeconds"] = bvh.wall;
    stats["sync.commitSeconds"] = delegate_->commit_seconds();
    const auto passes = delegate_->passes();
    if (!passes.empty()) {
      add_camera(*passes.back(), &stats);
      return add_progress(*passes.back(), &stats);
    }
    for (const auto& [key, value] : delegate_->stats_of_last_pass()) stats[key] = value;
  });
  return stats;
}

}  // namespace alabaster::hd::rendering
