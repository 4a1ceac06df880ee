#include "delegate/tradeoff/plan.h"

#include <algorithm>
#include <bit>
#include <map>
#include <set>

namespace alabaster::tradeoff {
namespace {

/// Answers questions about one state.
class Planner {
 public:
  explicit Planner(const StudyState& state) : state_(state) {
    for (const FinishedJob& finished : state.finished) {
      const Job& job = finished.job;
      done_[{job.configuration, job.samples}].insert(job.replica);
      if (job.configuration == kReference)
        reference_spent_ += finished.total_seconds;
      else
        highest_ = std::max(highest_, job.samples);
      Cost& cost = costs_[job.configuration];
      if (job.samples < cost.samples) continue;
      cost = {job.samples, finished.render_seconds, finished.total_seconds - finished.render_seconds};
    }
  }

  double expected(const Job& job) const {
    const auto found = costs_.find(job.configuration);
    if (found == costs_.end()) return 0;
    const Cost& cost = found->second;
    return cost.render * double(job.samples) / double(cost.samples) + cost.around;
  }

  /// The part of the expected time that is not rendering.
  double around(int configuration) const {
    const auto found = costs_.find(configuration);
    return found == costs_.end() ? 0 : found->second.around;
  }

  std::optional<Job> next() const {
    if (auto job = calibration()) return job;
    const double reserved = std::max(0.0, reference_budget() - reference_spent_);
    for (int rung = 0; rung < 2; ++rung)
      if (auto job = on_rung(rung, left() - reserved)) return job;
    if (auto job = reference(reference_budget() - reference_spent_)) return job;
    // A rung that takes more than a fair share of the time would leave none for others' lower rungs. The base may take
    // three times its share, because all others are compared with it, and first rungs twice.
    const double share = (state_.budget - reference_budget()) / std::max(1, state_.configurations);
    for (int rung = 2; rung_samples(rung) <= kHighestSamples; ++rung)
      if (auto job = on_rung(rung, left(), share)) return job;
    for (int rung = 2; rung_samples(rung) <= highest_; ++rung)  // stragglers
      if (auto job = on_rung(rung, left())) return job;
    return reference(left());
  }

 private:
  struct Cost {
    uint64_t samples = 0;
    double render = 0, around = 0;
  };

  double left() const { return state_.budget - state_.spent; }
  double reference_budget() const { return kReferenceShare * state_.budget; }
  int done(int configuration, uint64_t samples) const {
    const auto found = done_.find({configuration, samples});
    return found == done_.end() ? 0 : static_cast<int>(found->second.size());
  }

  uint64_t first_samples(int configuration) const {
    return state_.first_samples.empty() ? 1 : state_.first_samples[static_cast<size_t>(configuration)];
  }

  /// The first missing replica; one may have been lost.
  int missing(int configuration, uint64_t samples) const {
    const auto found = done_.find({configuration, samples});
    int replica = 0;
    while (found != done_.end() && found->second.contains(replica)) ++replica;
    return replica;
  }

  std::optional<Job> calibration() const {
    for (int c = kReference; c < state_.configurations; ++c)
      if (done(c, 1) == 0 && (c <= 0 || left() > 0)) return Job{c, 1, 0};
    return std::nullopt;
  }

  /// The first job still to be done on this rung whose whole rung fits into `seconds`, those with the fewest replicas
  /// first. A rung is not begun above one that was left out.
  std::optional<Job> on_rung(int rung, double seconds, double share = 1e300) const {
    const uint64_t samples = rung_samples(rung);
    for (int replicas = 0; replicas < kReplicas; ++replicas)
      for (int c = 0; c < state_.configurations; ++c) {
        if (samples < first_samples(c) || done(c, samples) != replicas || done(c, 1) == 0) continue;
        const bool is_first = rung == 0 || rung_samples(rung - 1) < first_samples(c);
        if (!is_first && done(c, rung_samples(rung - 1)) < kReplicas) continue;
        const Job job{c, samples, missing(c, samples)};
        const double needed = expected(job);
        if (replicas == 0 && needed * kReplicas > (c == 0 ? 3 : is_first ? 2 : 1) * share) continue;
        if (c > 0 && done(0, samples) <= replicas) continue;  // nothing to compare it with
        const double promised = replicas == 0 ? to_complete(samples) : 0;
        if (needed * (kReplicas - replicas) <= seconds - promised) return job;
      }
    return std::nullopt;
  }

  /// Seconds for the missing replicas of rungs already begun at `samples`: this time is reserved for them.
  double to_complete(uint64_t samples) const {
    double seconds = 0;
    for (int c = 0; c < state_.configurations; ++c) {
      const int replicas = done(c, samples);
      if (replicas > 0 && replicas < kReplicas) seconds += (kReplicas - replicas) * expected({c, samples, 0});
    }
    return seconds;
  }

  std::optional<Job> reference(double seconds) const {
    const uint64_t samples = state_.reference_samples > 0 ? state_.reference_samples : choose_reference_samples(state_);
    const int replicas = done(kReference, samples);
    const Job job{kReference, samples, missing(kReference, samples)};
    if (replicas < 2 || (replicas < kMostReferenceReplicas && expected(job) <= seconds)) return job;
    return std::nullopt;
  }

  const StudyState& state_;
  std::map<std::pair<int, uint64_t>, std::set<int>> done_;  // replicas
  std::map<int, Cost> costs_;
  double reference_spent_ = 0;
  uint64_t highest_ = 0;  // samples
};

}  // namespace

double expected_seconds(const StudyState& state, const Job& job) {
  return Planner(state).expected(job);
}

uint64_t choose_reference_samples(const StudyState& state) {
  const Planner planner(state);
  uint64_t samples = 1;
  const auto fits = [&](uint64_t n) {
    return kReferenceReplicas * planner.expected({kReference, n, 0}) <= kReferenceShare * state.budget;
  };
  while (samples < kHighestSamples && fits(2 * samples)) samples *= 2;
  return samples;
}

std::optional<Job> next_job(const StudyState& state) {
  return Planner(state).next();
}

Forecast forecast(const StudyState& state) {
  Forecast result;
  std::vector<FinishedJob> finished(state.finished.begin(), state.finished.end());
  StudyState ahead = state;
  while (true) {
    ahead.finished = finished;
    const Planner planner(ahead);
    const auto job = planner.next();
    if (!job) return result;
    const double seconds = planner.expected(*job);
    result.jobs.push_back(*job);
    result.seconds += seconds;
    ahead.spent += seconds;
    if (job->configuration == kReference && job->samples > 1 && ahead.reference_samples == 0)
      ahead.reference_samples = job->samples;
    finished.push_back({*job, seconds - planner.around(job->configuration), seconds});
  }
}

uint32_t seed_of(const Job& job) {
  const auto rung = static_cast<uint32_t>(std::bit_width(job.samples));  // at most 17
  const uint32_t own = rung << 20 | static_cast<uint32_t>(job.replica & 0xfffff);
  return job.configuration == kReference ? own | 0x80000000u : own;
}

}  // namespace alabaster::tradeoff
