// Runs a study: plans, renders and stores until the budget is spent.
#pragma once

#include <functional>

#include "delegate/tradeoff/scene_renderer.h"
#include "delegate/tradeoff/state.h"

namespace alabaster::tradeoff {

struct StudyProgress {
  std::string configuration;
  Job job;            // about to begin
  size_t number = 0;  // of it, from 1
  /// Jobs and time as expected now; 0 while the job measures the cost of its configuration.
  size_t total = 0;
  double seconds_left = 0;
};

struct StudyHooks {
  /// None if the render was cancelled, or if it failed and this was reported.
  std::function<std::optional<RenderedFrame>(const Configuration&, uint64_t samples, uint32_t seed)> render;
  std::function<bool()> cancelled;
  std::function<void(const StudyProgress&)> progress;
  std::function<void(const std::string&)> note;
  std::function<void()> stored;  // one more picture is safe
};

enum class StudyOutcome { finished, cancelled, render_failed, output_failed };

/// Renders the pictures that `store` lacks. `budget` is in seconds, of all runs together. `problem` says why output
/// failed.
StudyOutcome run_study(const ConfigurationList& list, double budget, StudyStore* store, const StudyHooks& hooks,
                       std::string* problem);

/// A budget in seconds, including the time spent so far, that should give each configuration two replicas of one sample
/// and thus a row in the report. A configuration that has not been rendered is assumed to cost as much as the base.
double least_budget(const ConfigurationList& list, const StudyStore& store);

/// The index of the configuration that `render` shows, by name and fingerprint; kReference for the reference; none if
/// the list does not have it.
std::optional<int> find_configuration(const ConfigurationList& list, const StoredRender& render);

/// A frame with the proportions of `size`, no larger, and small enough for five rungs of each configuration to fit into
/// the budget beside the reference. `seconds` is the cost of one sample of one pixel of the base.
hd::Vec2i affordable_size(const hd::Vec2i& size, double seconds, size_t configurations, double budget);

}  // namespace alabaster::tradeoff
