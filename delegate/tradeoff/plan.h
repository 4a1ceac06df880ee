// Chooses the next render, so that a budget of time is best used.
//
// First, one sample of everything measures the costs. Then every configuration gets the two lowest rungs of samples,
// and the reference its share. Higher rungs follow from low to high while they fit, first into a fair share each, then
// into the time that is left. A configuration that begins to have an effect at more samples, such as adaptive sampling,
// has no rungs below these. On each rung the first replicas of all configurations come before the second ones, so
// that a machine that slows down does not favour one configuration. The rest of the time goes to the reference. The
// same measurements always give the same next step, so an interrupted study resumes where it stopped.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace alabaster::tradeoff {

inline constexpr int kReplicas = 2;           // of a configuration, on every rung
inline constexpr int kReferenceReplicas = 8;  // at most kMostReferenceReplicas where time is left
inline constexpr int kMostReferenceReplicas = 64;
inline constexpr double kReferenceShare = 0.4;      // of the budget
inline constexpr uint64_t kHighestSamples = 65536;  // of one render

/// 1, 4, 16, 32, 64, ...: close enough from where pictures are of use.
constexpr uint64_t rung_samples(int rung) {
  return rung < 3 ? uint64_t(1) << (2 * rung) : uint64_t(16) << (rung - 2);
}

/// One render. `configuration` is an index into the measured ones, or kReference.
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
  double total_seconds = 0;   // with all overheads
};

struct StudyState {
  int configurations = 0;
  double budget = 0;               // seconds, all runs together
  double spent = 0;                // seconds
  uint64_t reference_samples = 0;  // of each of the reference's replicas; 0: not chosen yet
  std::span<const FinishedJob> finished;
  /// The samples at which each configuration begins to differ from the base: it has no rungs below. Empty: all at 1.
  std::span<const uint64_t> first_samples = {};
};

/// Expected seconds of `job`, from the longest render of its configuration so far; 0 if there is none.
double expected_seconds(const StudyState& state, const Job& job);

/// The number of samples, a power of two, at which kReferenceReplicas replicas fit into the reference's share.
uint64_t choose_reference_samples(const StudyState& state);

/// None when nothing useful fits into the time left. At least two replicas of the reference are always rendered,
/// because without them no other render is of use.
std::optional<Job> next_job(const StudyState& state);

/// All further jobs of next_job, if each took its expected time.
struct Forecast {
  std::vector<Job> jobs;
  double seconds = 0;
};
Forecast forecast(const StudyState& state);

/// The seed of a job. The reference never shares random numbers with a configuration, nor one replica with another.
/// Configurations share theirs, so that noise does not hide their differences.
uint32_t seed_of(const Job& job);

}  // namespace alabaster::tradeoff
