#include "core/session/light_landings.h"

#include <algorithm>
#include <cmath>
#include <exception>
#include <tuple>

namespace alabaster {

namespace {

// The first sample of a frame has no light paths: it is what a viewport shows while its camera moves.
constexpr uint32_t kFirstSample = 1;
// Samples whose light paths are spread evenly together.
constexpr uint32_t kSpread = 64;
constexpr uint32_t kChunk = 512;  // light paths that a thread traces at a time
// Passes take up to 16 samples, and two of them overlap.
constexpr size_t kMostBuilds = 34;

constexpr int kReach = 2;  // pixels; no filter is wider

// Chooses one of the pixels along an axis whose filters have the position in their support, by their densities there.
// `weight`: the sum of those, next to 1.
int choose_pixel(PixelFilter filter, float position, float u, float* weight) {
  const int first = static_cast<int>(std::floor(position)) - kReach;
  std::array<float, size_t{2} * kReach + 1> densities;
  float sum = 0;
  for (size_t i = 0; i < densities.size(); ++i) {
    densities[i] = pixel_filter_density(filter, position - (static_cast<float>(first + static_cast<int>(i)) + 0.5f));
    sum += densities[i];
  }
  *weight = sum;
  float rest = u * sum;
  size_t chosen = kReach;
  for (size_t i = 0; i < densities.size(); ++i) {
    if (densities[i] > 0) chosen = i;
    if (rest < densities[i]) break;
    rest -= densities[i];
  }
  return first + static_cast<int>(chosen);
}

// The mean of red, green and blue over some pixels of a frame.
float measure_level(const LightLandingsRequest& request, RenderCounters* counters) {
  constexpr int kSide = 16;
  PathContext context{request.scene, request.camera, request.settings, *counters};
  context.camera_interiors = request.camera_interiors;
  const PathIntegrator trace = select_path_integrator(request.scene.features, request.settings, false);
  double sum = 0;
  for (int j = 0; j < kSide; ++j) {
    request.settings.walk.cancel.check();
    for (int i = 0; i < kSide; ++i) {
      const Vec2f film((static_cast<float>(i) + 0.5f) / kSide * static_cast<float>(request.width),
                       (static_cast<float>(j) + 0.5f) / kSide * static_cast<float>(request.height));
      const PixelSampler sampler(hash32(static_cast<uint32_t>(j * kSide + i)), 0);
      const Rgb color = trace(context, request.camera.generate_ray(film, {0.5f, 0.5f}), sampler).color;
      if (is_finite(color)) sum += (double(color.r) + double(color.g) + double(color.b)) / 3;
    }
  }
  return static_cast<float>(sum / (kSide * kSide));
}

std::vector<LandedSample::Entry> joined(const std::vector<std::vector<LandedSample::Entry>>& chunks) {
  std::vector<LandedSample::Entry> all;
  for (const auto& chunk : chunks) all.insert(all.end(), chunk.begin(), chunk.end());
  return all;
}

}  // namespace

LandedSample::LandedSample(const PixelRect& window, std::vector<Entry> entries)
    : y0_(window.y0), rows_(static_cast<size_t>(window.height()) + 1) {
  std::stable_sort(entries.begin(), entries.end(),
                   [](const Entry& a, const Entry& b) { return std::tie(a.y, a.x) < std::tie(b.y, b.x); });
  for (const Entry& entry : entries) {
    if (!entries_.empty() && entries_.back().x == entry.x && entries_.back().y == entry.y) {
      entries_.back().light.color += entry.light.color;
      entries_.back().light.specular += entry.light.specular;
    } else {
      entries_.push_back(entry);
      ++rows_[static_cast<size_t>(entry.y - y0_) + 1];
    }
  }
  for (size_t i = 1; i < rows_.size(); ++i) rows_[i] += rows_[i - 1];
}

const LandedLight* LandedSample::find(int x, int y) const {
  const auto row = static_cast<size_t>(y - y0_);
  if (y < y0_ || row + 1 >= rows_.size()) return nullptr;
  const auto begin = entries_.begin() + rows_[row], end = entries_.begin() + rows_[row + 1];
  const auto found = std::lower_bound(begin, end, x, [](const Entry& entry, int at) { return entry.x < at; });
  return found != end && found->x == x ? &found->light : nullptr;
}

const LandedSample& LandedCache::of_sample(uint32_t sample, RenderCounters* counters) {
  Slot& slot = slots_[sample % slots_.size()];
  if (slot.sample != sample || !slot.landed) {
    const uint64_t rays_before = counters->rays();
    slot = {sample, landings_->of_sample(sample, counters)};
    rays_ += counters->rays() - rays_before;
  }
  return *slot.landed;
}

// The light paths of one sample of the frame, while they are traced and after.
struct LightLandings::Build {
  Build(uint32_t of, uint32_t chunk_count) : sample(of), count(chunk_count), chunks(chunk_count), left(chunk_count) {}
  const uint32_t sample, count;
  std::atomic<uint32_t> next{0};  // chunk to be traced
  std::vector<std::vector<LandedSample::Entry>> chunks;
  // Guarded by the lock:
  std::mutex lock;
  std::condition_variable done;
  uint32_t left;  // chunks that are not done
  std::exception_ptr failure;
  std::shared_ptr<const LandedSample> landed;
};

void LightLandings::make_plan() {
  if (is_planned_.load(std::memory_order_acquire)) return;
  const std::lock_guard lock(plan_lock_);
  if (is_planned_) return;
  const std::vector<uint32_t> casters = find_casters(request_.scene, request_.settings);
  if (casters.empty()) return is_planned_.store(true, std::memory_order_release);
  RenderCounters counters;  // nobody counts a pilot
  PathContext context{request_.scene, request_.camera, request_.settings, counters};
  context.camera_interiors = request_.camera_interiors;
  const Vec2f size(static_cast<float>(request_.width), static_cast<float>(request_.height));
  plan_ = plan_light_paths(context, casters, size, measure_level(request_, &counters));
  const PixelRect& window = request_.window;
  plan_.film_begin = Vec2f(static_cast<float>(window.x0 - kReach), static_cast<float>(window.y0 - kReach));
  plan_.film_end = Vec2f(static_cast<float>(window.x1 + kReach), static_cast<float>(window.y1 + kReach));
  is_planned_.store(true, std::memory_order_release);
}

const LightPathPlan* LightLandings::plan(uint32_t sample) {
  if (sample < kFirstSample) return nullptr;
  make_plan();
  return plan_.empty() ? nullptr : &plan_;
}

void LightLandings::trace_chunk(uint32_t sample, uint32_t chunk, RenderCounters* counters,
                                std::vector<LandedSample::Entry>* out) const {
  PathContext context{request_.scene, request_.camera, request_.settings, *counters};
  context.camera_interiors = request_.camera_interiors;
  context.light_paths = &plan_;
  const LightPathTracer trace = select_light_path_tracer(request_.scene.features, request_.settings);
  const uint32_t seed = hash_combine(pixel_seed(0, 0, request_.frame, request_.seed), sample / kSpread);
  const PixelRect& window = request_.window;
  std::vector<LightLanding> landings;
  for (uint32_t i = chunk * kChunk; i < std::min(plan_.paths, (chunk + 1) * kChunk); ++i) {
    landings.clear();
    const PixelSampler sampler(seed, sample % kSpread * plan_.paths + i);
    trace(context, sampler, &landings);
    const auto u = sampler.draw(Dimension::film_lens, 1);
    for (const LightLanding& landing : landings) {
      Vec2f weight;
      const int x = choose_pixel(request_.filter, landing.film.x, u[0], &weight.x);
      const int y = choose_pixel(request_.filter, landing.film.y, u[1], &weight.y);
      if (x < window.x0 || x >= window.x1 || y < window.y0 || y >= window.y1) continue;
      const float both = weight.x * weight.y;
      out->push_back({x, y, {landing.color * both, landing.specular * both}});
    }
  }
}

std::shared_ptr<LightLandings::Build> LightLandings::build_of(uint32_t sample) {
  const std::lock_guard lock(builds_lock_);
  for (const auto& build : builds_)
    if (build->sample == sample) return build;
  if (builds_.size() >= kMostBuilds) builds_.erase(builds_.begin());
  builds_.push_back(std::make_shared<Build>(sample, (plan_.paths + kChunk - 1) / kChunk));
  return builds_.back();
}

std::shared_ptr<const LandedSample> LightLandings::of_sample(uint32_t sample, RenderCounters* counters) {
  const std::shared_ptr<Build> build = build_of(sample);
  for (uint32_t chunk; (chunk = build->next.fetch_add(1)) < build->count;) {
    // Trace it. A failure ends the wait of all who need the sample.
    std::exception_ptr failure;
    try {
      request_.settings.walk.cancel.check();
      trace_chunk(sample, chunk, counters, &build->chunks[chunk]);
    } catch (...) {
      failure = std::current_exception();
    }
    const std::lock_guard lock(build->lock);
    if (failure) build->failure = failure;
    if (--build->left > 0) continue;

    // The last puts all together.
    try {
      if (!build->failure) build->landed = std::make_shared<LandedSample>(request_.window, joined(build->chunks));
    } catch (...) {
      build->failure = std::current_exception();
    }
    build->chunks.clear();
    build->done.notify_all();
  }
  std::unique_lock lock(build->lock);
  build->done.wait(lock, [&] { return build->left == 0; });
  if (build->failure) std::rethrow_exception(build->failure);
  return build->landed;
}

}  // namespace alabaster
