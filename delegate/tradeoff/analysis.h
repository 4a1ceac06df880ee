// From the pictures of a study to its numbers.
#pragma once

#include <functional>

#include "delegate/tradeoff/measurement.h"
#include "delegate/tradeoff/state.h"

namespace alabaster::tradeoff {

/// A configuration at a number of samples. What is not known is a NaN.
struct Row {
  std::string configuration, group;
  uint64_t samples = 0;  // per pixel
  int replicas = 0;
  double cpu_seconds = 0, wall_seconds = 0;  // mean of the replicas
  Estimate squared_noise;                    // of one replica
  Estimate squared_bias, level_bias;         // of the configuration: the same in all its rows
  double total = 0;                          // sqrt(bias^2 + noise^2); a bias^2 below zero counts as zero
  double display_rmse = 0, flip = 0;         // against the mean of the reference, mean over replicas
  double reported_error = 0;                 // what the renders estimate of themselves, root of the mean square
  bool pareto = false;                       // no other row costs less CPU time and errs less
};

struct ReferenceSummary {
  uint64_t samples = 0;  // of each replica
  int replicas = 0;
  double cpu_seconds = 0;             // of all of them
  double noise = 0;                   // relative RMSE of their mean, which the estimates of bias have taken away
  double display_rmse = 0, flip = 0;  // between the means of its two halves: display measures below are noise
};

struct StudyResult {
  ReferenceSummary reference;
  std::vector<Row> rows;  // in the order of the list, by rising samples
};

/// A linear picture as it is displayed; none: failed.
using DisplayFunction = std::function<std::optional<Image>(const Image&)>;

/// Rows have two replicas at least. None, and *problem says why, if the reference does not have two yet, is black, or a
/// picture cannot be read.
std::optional<StudyResult> analyse(const StudyStore& store, const ConfigurationList& list,
                                   const DisplayFunction& display, std::string* problem);

/// One line for each configuration: the base is what the others are compared with.
struct ConfigurationSummary {
  const Row* best = nullptr;  // of most samples
  double cost_ratio = 0;      // CPU seconds to equal noise, relative to the base: noise^2 x CPU of both
  uint64_t compared_at = 0;   // samples at which the ratio was taken: the most that both have
};
std::vector<ConfigurationSummary> summarize(const StudyResult& result);

}  // namespace alabaster::tradeoff
