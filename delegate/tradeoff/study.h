// Runs a study: plan, render, keep, until the budget is spent.
#pragma once

#include <functional>

#include "delegate/tradeoff/scene_renderer.h"
#include "delegate/tradeoff/state.h"

namespace alabaster::tradeoff {

struct StudyProgress {
  std::string configuration;
  Job job;            // that begins now
  size_t number = 0;  // of it, from 1
  /// Jobs and time as expected now; 0 while the job itself is there to tell what its configuration costs.
  size_t total = 0;
  double seconds_left = 0;
};

struct StudyHooks {
  /// None: failed (reported) or cancelled.
  std::function<std::optional<RenderedFrame>(const Configuration&, uint64_t samples, uint32_t seed)> render;
  std::function<bool()> cancelled;
  std::function<void(const StudyProgress&)> progress;
  std::function<void(const std::string&)> note;
  std::function<void()> stored;  // a picture more is safe
};

enum class StudyOutcome { finished, cancelled, render_failed, output_failed };

/// Renders what `store` does not hold yet. `budget`: seconds of all runs together. `problem`: why output failed.
StudyOutcome run_study(const ConfigurationList& list, double budget, StudyStore* store, const StudyHooks& hooks,
                       std::string* problem);

/// A budget in seconds, everything spent so far included, that should give each configuration its two replicas of one
/// sample, and with them a row in the report. Of what has not been rendered at all the cost is taken to be the base's.
double least_budget(const ConfigurationList& list, const StudyStore& store);

/// The measured configuration of that name and fingerprint, kReference, or none if the list has no such.
std::optional<int> find_configuration(const ConfigurationList& list, const StoredRender& render);

/// A frame of the proportions of width x height, not larger, so small that four rungs of each configuration fit into
/// the budget beside the reference. `seconds`: of one sample of one pixel of the base.
hd::Vec2i affordable_size(hd::Vec2i size, double seconds, size_t configurations, double budget);

}  // namespace alabaster::tradeoff
