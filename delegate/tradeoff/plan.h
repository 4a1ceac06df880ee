// What to render next, so that a budget of time tells the most.
//
// First one sample of everything tells what things cost. Then every configuration gets the two lowest rungs of samples;
// then the reference gets its share; then the rungs above, from low to high, for as long as they fit (into a fair share
// each at first, into what is left then); on a rung the first replicas of all come before the second ones, so that a
// machine that grows slower meanwhile does not favour one configuration; what is left goes to the reference. The same
// measurements always give the same next step, so an interrupted study goes on as it was.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace alabaster::tradeoff {

inline constexpr int kReplicas = 2;           // of a configuration, on every rung
inline constexpr int kReferenceReplicas = 8;  // aimed at; more where time is left
inline constexpr int kMostReferenceReplicas = 64;
inline constexpr double kReferenceShare = 0.4;      // of the budget
inline constexpr uint64_t kHighestSamples = 65536;  // of one render

/// 1, 4, 16, 64, ...
constexpr uint64_t rung_samples(int rung) {
  return uint64_t(1) << (2 * rung);
}

/// One render. `configuration` counts the measured ones; kReference is the reference.
inline constexpr int kReference = -1;
struct Job {
  int configuration = 0;
  uint64_t samples = 1;  // per pixel
  int replica = 0;
  bool operator==(const Job&) const = default;
};

struct FinishedJob {
  Job job;
  double render_seconds = 0;  // wall time of rendering alone
  double total_seconds = 0;   // with everything about it
};

struct StudyState {
  int configurations = 0;
  double budget = 0;               // seconds, all runs together
  double spent = 0;                // seconds
  uint64_t reference_samples = 0;  // of each of the reference's replicas; 0: not chosen yet
  std::span<const FinishedJob> finished;
};

/// Seconds that `job` should take; by the longest render of its configuration so far, 0 if there is none.
double expected_seconds(const StudyState& state, const Job& job);

/// So many that kReferenceReplicas of them fit into the reference's share; a power of two.
uint64_t choose_reference_samples(const StudyState& state);

/// None when nothing worth having fits into what is left. Two replicas of the reference at least are rendered, for
/// without them nothing else is worth anything.
std::optional<Job> next_job(const StudyState& state);

/// Everything that next_job would still ask for, if each took what is expected of it.
struct Forecast {
  std::vector<Job> jobs;
  double seconds = 0;
};
Forecast forecast(const StudyState& state);

/// Random numbers of a job: those of the reference are never those of a configuration, those of two replicas never the
/// same. Configurations share theirs: what they differ in is then not drowned in noise.
uint32_t seed_of(const Job& job);

}  // namespace alabaster::tradeoff
