#include "delegate/tradeoff/study.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace alabaster::tradeoff {
namespace {

class Study {
 public:
  Study(const ConfigurationList& list, double budget, StudyStore* store, const StudyHooks& hooks)
      : list_(list), budget_(budget), store_(store), hooks_(hooks) {
    for (const Configuration& configuration : list.measured) first_samples_.push_back(configuration.first_samples());
    for (const StoredRender& render : store->renders())
      if (const auto index = find_configuration(list, render)) remember(*index, render);
  }

  StudyOutcome run(std::string* problem) {
    bool plan_told = false;
    while (!hooks_.cancelled()) {
      const auto job = next_job(state());
      if (!job) return StudyOutcome::finished;
      choose_reference(*job);
      const Configuration& configuration = configuration_of(job->configuration);
      StudyProgress progress{configuration.name, *job, finished_.size() + 1, 0, 0};
      if (is_measured(job->configuration)) {
        const Forecast ahead = forecast(state());
        if (!plan_told) tell_plan(ahead);
        plan_told = true;
        progress.total = finished_.size() + ahead.jobs.size();
        progress.seconds_left = ahead.seconds;
      }
      hooks_.progress(progress);
      auto frame = hooks_.render(configuration, job->samples, seed_of(*job));
      if (!frame) return hooks_.cancelled() ? StudyOutcome::cancelled : StudyOutcome::render_failed;
      StoredRender render{
          configuration.name, configuration.fingerprint(), job->samples, job->replica, frame->cost, "", ""};
      remember(job->configuration, render);
      *problem = store_->add(std::move(render), frame->image, frame->denoised);
      if (!problem->empty()) return StudyOutcome::output_failed;
      hooks_.stored();
    }
    return StudyOutcome::cancelled;
  }

 private:
  const Configuration& configuration_of(int index) const {
    return index == kReference ? list_.reference : list_.measured[static_cast<size_t>(index)];
  }

  void remember(int index, const StoredRender& render) {
    finished_.push_back({{index, render.samples, render.replica}, render.cost.wall_seconds, render.cost.total_seconds});
  }

  StudyState state() const {
    return {static_cast<int>(list_.measured.size()),
            budget_,
            store_->spent,
            store_->reference_samples,
            finished_,
            first_samples_};
  }

  bool is_measured(int configuration) const {
    return std::any_of(finished_.begin(), finished_.end(),
                       [&](const FinishedJob& f) { return f.job.configuration == configuration; });
  }

  /// Fixes the reference's samples with its first replica: all replicas must have the same number.
  void choose_reference(const Job& job) {
    if (job.configuration == kReference && is_measured(kReference)) store_->reference_samples = job.samples;
  }

  void tell_plan(const Forecast& ahead) const {
    std::vector<uint64_t> highest(list_.measured.size(), 0);
    int replicas = 0;
    uint64_t samples = 0;
    const auto count = [&](const Job& job) {
      if (job.configuration == kReference) {
        replicas = job.samples > samples ? 1 : replicas + 1;
        samples = std::max(samples, job.samples);
      } else {
        uint64_t& top = highest[static_cast<size_t>(job.configuration)];
        top = std::max(top, job.samples);
      }
    };
    for (const FinishedJob& finished : finished_) count(finished.job);
    for (const Job& job : ahead.jobs) count(job);
    char text[160];
    std::snprintf(text, sizeof text, "plan: %zu more renders, %.1f minutes; reference: %d x %llu samples",
                  ahead.jobs.size(), ahead.seconds / 60, replicas, static_cast<unsigned long long>(samples));
    hooks_.note(text);
    for (size_t c = 0; c < highest.size(); ++c)
      hooks_.note("  " + list_.measured[c].name + ": " +
                  (highest[c] < first_samples_[c]
                       ? "no time left"
                       : std::to_string(kReplicas) + " replicas of " + std::to_string(first_samples_[c]) + " to " +
                             std::to_string(highest[c]) + " samples"));
  }

  const ConfigurationList& list_;
  const double budget_;
  StudyStore* store_;
  const StudyHooks& hooks_;
  std::vector<FinishedJob> finished_;
  std::vector<uint64_t> first_samples_;
};

}  // namespace

std::optional<int> find_configuration(const ConfigurationList& list, const StoredRender& render) {
  const auto is = [&](const Configuration& configuration) {
    return configuration.name == render.configuration && configuration.fingerprint() == render.fingerprint;
  };
  if (is(list.reference)) return kReference;
  const auto found = std::find_if(list.measured.begin(), list.measured.end(), is);
  if (found == list.measured.end()) return std::nullopt;
  return static_cast<int>(found - list.measured.begin());
}

double least_budget(const ConfigurationList& list, const StudyStore& store) {
  std::vector<FinishedJob> finished;
  double reference_spent = 0;
  for (const StoredRender& render : store.renders()) {
    const auto index = find_configuration(list, render);
    if (!index) continue;
    finished.push_back({{*index, render.samples, render.replica}, render.cost.wall_seconds, render.cost.total_seconds});
    if (*index == kReference) reference_spent += render.cost.total_seconds;
  }
  const auto count = static_cast<int>(list.measured.size());
  const StudyState state{count, 0, store.spent, store.reference_samples, finished};
  double needed = store.spent;
  for (int c = 0; c < count; ++c) {
    const auto done = std::count_if(finished.begin(), finished.end(), [&](const FinishedJob& f) {
      return f.job.configuration == c && f.job.samples == 1;
    });
    const double known = expected_seconds(state, {c, 1, 0});
    const double each = known > 0 ? known : expected_seconds(state, {0, 1, 0});
    needed += each * std::max(0.0, double(kReplicas) - double(done));
  }
  // The unused part of the reference's share is reserved for it.
  return std::max(needed, (needed - reference_spent) / (1 - kReferenceShare));
}

StudyOutcome run_study(const ConfigurationList& list, double budget, StudyStore* store, const StudyHooks& hooks,
                       std::string* problem) {
  return Study(list, budget, store, hooks).run(problem);
}

hd::Vec2i affordable_size(const hd::Vec2i& size, double seconds, size_t configurations, double budget) {
  constexpr double kSamples = kReplicas * (1 + 4 + 16 + 32 + 64);
  const double pixels = (1 - kReferenceShare) * budget / (kSamples * double(configurations) * std::max(seconds, 1e-12));
  constexpr double kFewest = 64 * 64;  // a smaller picture shows too little
  const double scale = std::sqrt(std::max(pixels, kFewest) / (double(size.x) * double(size.y)));
  if (scale >= 1) return size;
  return {std::max(1, int(std::lround(size.x * scale))), std::max(1, int(std::lround(size.y * scale)))};
}

}  // namespace alabaster::tradeoff
