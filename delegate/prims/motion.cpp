#include "delegate/prims/motion.h"

#include <algorithm>
#include <cmath>

namespace alabaster::hd::prims {

std::string times_fault(const std::vector<double>& times, size_t values) {
  if (times.size() != values) return std::to_string(times.size()) + " times for " + std::to_string(values) + " values";
  for (size_t i = 0; i < times.size(); ++i) {
    if (!std::isfinite(times[i])) return "a time is not finite";
    if (i > 0 && !(times[i] > times[i - 1])) return "times must increase";
  }
  return {};
}

alabaster::TimeSamples<Matrix4d> checked_motion(const hd::TimeSamples<Matrix4d>& samples, const Path& where,
                                                const alabaster::DiagnosticSink& sink) {
  if (samples.values.size() < 2 && samples.times.size() < 2) return {};
  std::string fault = times_fault(samples.times, samples.values.size());
  if (fault.empty() && !std::all_of(samples.values.begin(), samples.values.end(), is_valid_affine))
    fault = "a transform is not finite, not affine or not invertible";
  if (fault.empty()) return {samples.times, samples.values};
  alabaster::report(sink, alabaster::Severity::warning, "motion.transform", where.str(),
                    "the samples of the transform cannot be used: " + fault + "; it is drawn without motion blur");
  return {};
}

}  // namespace alabaster::hd::prims
