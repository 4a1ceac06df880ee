// Turns the pictures of a study into numbers.
#pragma once

#include <functional>

#include "delegate/tradeoff/measurement.h"
#include "delegate/tradeoff/state.h"

namespace alabaster::tradeoff {

/// A configuration at a number of samples. Unknown values are NaN.
struct Row {
  std::string configuration, group;
  bool denoised = false;  // then group is kDenoised, and the bias belongs to this row alone
  uint64_t samples = 0;   // per pixel
  int replicas = 0;
  double cpu_seconds = 0;             // of the replica that took least, with denoising
  double wall_seconds = 0;            // mean of the replicas, with denoising
  double denoise_cpu_seconds = 0;     // of it
  Estimate squared_noise;             // of one replica
  Estimate squared_bias, level_bias;  // of the configuration: the same in all its rows that are not denoised
  Estimate total;                     // sqrt(bias^2 + noise^2); a bias that may be zero counts as zero
  double display_rmse = 0, flip = 0;  // against the reference's mean; mean over replicas
  double reported_error = 0;          // the renders' own estimates, root of the mean square
  bool pareto = false;                // on the front (pareto.h) of those that are denoised, or of those that are not
};
inline constexpr const char* kDenoised = "denoised";

struct ReferenceSummary {
  uint64_t samples = 0;  // of each replica
  int replicas = 0;
  double cpu_seconds = 0;             // of all of them
  double noise = 0;                   // relative RMSE of their mean; the estimates of bias have subtracted it
  double display_rmse = 0, flip = 0;  // between the means of its two halves: smaller display errors are noise
};

/// A part of the picture as displayed, where configurations differ most.
struct Tile {
  std::string name;
  uint64_t samples = 0;  // 0: the reference's mean
  Image pixels;
};

struct StudyResult {
  ReferenceSummary reference;
  double timing_error = 0;  // relative standard deviation of the CPU seconds of one render
  std::vector<Row> rows;    // in the order of the list, by rising samples
  std::vector<Tile> tiles;  // the reference first; at the most samples that all have, or at own ones
};

/// Converts a linear picture to display colours; none if that failed.
using DisplayFunction = std::function<std::optional<Image>(const Image&)>;

/// Each row has at least two replicas. None, with the reason in *problem, if the reference has fewer than two or is
/// black, or a picture cannot be read.
std::optional<StudyResult> analyse(const StudyStore& store, const ConfigurationList& list,
                                   const DisplayFunction& display, std::string* problem);

/// One line for each configuration, as rendered, compared with the base.
struct ConfigurationSummary {
  const Row* best = nullptr;  // of most samples
  Estimate cost_ratio;        // CPU seconds to equal noise, relative to the base: noise^2 x CPU of both
  uint64_t compared_at = 0;   // samples at which the ratio was taken: the most that both rendered
  bool has_effect = true;     // cost or error differ measurably from the base's
};
std::vector<ConfigurationSummary> summarize(const StudyResult& result);

}  // namespace alabaster::tradeoff
