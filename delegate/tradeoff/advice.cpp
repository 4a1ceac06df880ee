#include "delegate/tradeoff/advice.h"

#include <algorithm>
#include <cmath>

#include "delegate/tradeoff/pareto.h"

namespace alabaster::tradeoff {
namespace {

constexpr double kBudgets[] = {60, 600, 3600};  // seconds

struct Candidate {
  Estimate squared_error;
  double samples = 0;
  const Row* row = nullptr;
};

/// Two digits, as the prediction has no more.
uint64_t rounded(double samples) {
  const double digits = std::pow(10.0, std::max(0.0, std::floor(std::log10(std::max(1.0, samples))) - 1));
  return static_cast<uint64_t>(std::clamp(std::floor(samples / digits) * digits, 1.0, double(kMostSamples)));
}

const Configuration* configuration_of(const Row& row, const ConfigurationList& list) {
  for (const Configuration& configuration : list.measured)
    if (row.configuration == configuration.name ||
        (row.denoised && row.configuration == configuration.name + " " + kDenoised))
      return &configuration;
  return nullptr;
}

/// Without samples if the budget does not suffice.
Candidate candidate_of(const Row& row, double cpu_seconds, double timing_error, const Configuration& configuration) {
  const double affordable = double(row.samples) * cpu_seconds / row.cpu_seconds;
  if (row.denoised) {
    if (affordable < double(row.samples)) return {};
    const Estimate squared = squared_error_at({0, 1, row.squared_noise, row.squared_bias}, 1);
    return {squared, double(row.samples), &row};
  }
  if (affordable < double(configuration.first_samples())) return {};
  const double samples = std::min(affordable, double(kMostSamples));
  CurvePoint point{0, row.cpu_seconds, row.squared_noise, row.squared_bias};
  const double error = std::hypot(row.squared_noise.standard_error,
                                  row.squared_noise.value * timing_error / std::sqrt(double(row.replicas)));
  // The base is not biased but for the walk's shortcuts. A bias of others that may be 0 may be at its end, too.
  if (row.group == "base") point.squared_bias = {};
  point.squared_noise.low = row.squared_noise.value - 2 * error;
  point.squared_noise.high = row.squared_noise.value + 2 * error;
  Estimate squared = squared_error_at(point, row.cpu_seconds * samples / double(row.samples));
  if (!is_certain(point.squared_bias)) squared.high += std::max(0.0, point.squared_bias.high);
  return {squared, samples, &row};
}

}  // namespace

std::vector<Advice> advise(const StudyResult& result, const ConfigurationList& list, const WantedFrame& frame) {
  std::vector<Advice> all;
  for (const double seconds : kBudgets) {
    const double cpu = seconds * frame.threads / frame.pixels;  // of a frame of the study's size
    Candidate best;
    for (const Row& row : result.rows) {
      // The row of most samples tells most about a configuration.
      const bool is_last = &row == &result.rows.back() || (&row + 1)->configuration != row.configuration;
      const Configuration* configuration = configuration_of(row, list);
      if (!configuration || (!row.denoised && !is_last) || !(row.cpu_seconds > 0)) continue;
      const Candidate candidate = candidate_of(row, cpu, result.timing_error, *configuration);
      if (candidate.samples == 0) continue;
      if (!best.row || candidate.squared_error.high < best.squared_error.low) best = candidate;
    }
    if (!best.row) continue;
    const Estimate& e = best.squared_error;
    std::string command = frame.command_of_all;
    if (const std::string& flags = configuration_of(*best.row, list)->flags; !flags.empty()) command += " " + flags;
    command += " --spp " + std::to_string(rounded(best.samples));
    if (best.row->denoised) command += " --denoise";
    all.push_back({seconds, {std::sqrt(e.value), std::sqrt(e.low), std::sqrt(e.high), 0}, command});
  }
  return all;
}

}  // namespace alabaster::tradeoff
