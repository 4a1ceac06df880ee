// The plan on a machine that takes exactly as long as expected.
#include "delegate/tradeoff/plan.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>

namespace alabaster::tradeoff {
namespace {

/// Runs a whole study of `configurations` whose samples cost `seconds` (the reference: twice that).
std::vector<FinishedJob> simulate(int configurations, double seconds, double budget) {
  std::vector<FinishedJob> finished;
  StudyState state;
  state.configurations = configurations;
  state.budget = budget;
  while (true) {
    state.finished = finished;
    const auto job = next_job(state);
    if (!job) return finished;
    if (job->configuration == kReference && !finished.empty()) state.reference_samples = job->samples;
    const double each = job->configuration == kReference ? 2 * seconds : seconds;
    finished.push_back({*job, each * double(job->samples), each * double(job->samples) + 0.01});
    state.spent += finished.back().total_seconds;
  }
}

double total(const std::vector<FinishedJob>& jobs) {
  double sum = 0;
  for (const FinishedJob& job : jobs) sum += job.total_seconds;
  return sum;
}

std::map<std::pair<int, uint64_t>, int> replicas(const std::vector<FinishedJob>& jobs) {
  std::map<std::pair<int, uint64_t>, int> count;
  for (const FinishedJob& job : jobs) ++count[{job.job.configuration, job.job.samples}];
  return count;
}

TEST(Plan, KeepsTheBudgetAndUsesIt) {
  for (const double budget : {30.0, 120.0, 600.0}) {
    const double spent = total(simulate(12, 0.05, budget));
    EXPECT_LE(spent, budget);
    EXPECT_GE(spent, 0.75 * budget) << "of " << budget;
  }
}

TEST(Plan, TheReferenceGetsItsShare) {
  const auto jobs = simulate(12, 0.05, 600);
  double reference = 0;
  for (const FinishedJob& job : jobs)
    if (job.job.configuration == kReference) reference += job.total_seconds;
  EXPECT_GE(reference, 0.5 * kReferenceShare * 600);
  uint64_t samples = 0;
  for (const auto& [key, count] : replicas(jobs))
    if (key.first == kReference) samples = std::max(samples, key.second);
  EXPECT_GE(replicas(jobs).at({kReference, samples}), kReferenceReplicas - 1);
}

TEST(Plan, AllConfigurationsGetTwoRungsBeforeAnyGetsThree) {
  std::set<std::pair<int, uint64_t>> seen;
  for (const FinishedJob& finished : simulate(8, 0.02, 60)) {
    const Job& job = finished.job;
    if (job.configuration != kReference && job.samples > 4)
      for (int c = 0; c < 8; ++c) {
        EXPECT_TRUE(seen.count({c, 1}));
        EXPECT_TRUE(seen.count({c, 4}));
      }
    seen.insert({job.configuration, job.samples});
  }
  EXPECT_TRUE(seen.count({0, 64}));
}

TEST(Plan, ReplicasOfARungTakeTurns) {
  std::map<uint64_t, std::vector<int>> order;  // replicas in the order of rendering
  for (const FinishedJob& finished : simulate(8, 0.02, 60))
    if (finished.job.configuration != kReference) order[finished.job.samples].push_back(finished.job.replica);
  for (const uint64_t samples : {1u, 4u, 16u}) {
    EXPECT_EQ(order[samples].size(), 16u);
    EXPECT_TRUE(std::is_sorted(order[samples].begin(), order[samples].end())) << samples;
  }
}

TEST(Plan, NothingIsBegunThatCannotBeCompleted) {
  for (const double budget : {7.0, 15.0, 31.0, 77.0, 200.0}) {
    for (const auto& [key, count] : replicas(simulate(8, 0.02, budget))) {
      if (key.first == kReference) continue;
      EXPECT_EQ(count, kReplicas) << budget << ": " << key.first << ", " << key.second;
    }
  }
}

TEST(Plan, RemainingTimeGoesToStragglersBeforeTheReference) {
  // The reference has used its share. One of three configurations takes a little more than its fair share for the third
  // rung.
  std::vector<FinishedJob> finished;
  const auto add = [&](int c, uint64_t samples, int replica, double each) {
    finished.push_back({{c, samples, replica}, each * double(samples), each * double(samples)});
  };
  for (int replica = 0; replica < 2; ++replica)
    for (const uint64_t samples : {1u, 4u, 16u})
      for (int c = 0; c < 3; ++c)
        if (c < 2 || samples < 16) add(c, samples, replica, c < 2 ? 0.1 : 1);
  add(kReference, 1, 0, 0.625);
  for (int replica = 0; replica < kReferenceReplicas; ++replica) add(kReference, 8, replica, 0.625);
  StudyState state;
  state.configurations = 3;
  state.budget = 100;
  state.spent = 50;
  state.reference_samples = 8;
  for (const uint64_t samples : {32u, 64u, 128u})
    for (const int c : {0, 1})
      for (const int replica : {0, 1}) add(c, samples, replica, 0.1);
  state.finished = finished;
  ASSERT_GT(2 * expected_seconds(state, {2, 16, 0}), 60.0 / 3);
  EXPECT_EQ(next_job(state), (Job{2, 16, 0}));
}

// Adaptive sampling begins at 32 samples: below these its pictures are the base's.
TEST(Plan, AConfigurationBeginsWhereItHasAnEffect) {
  std::vector<FinishedJob> finished;
  const std::vector<uint64_t> first{1, 32, 1};
  StudyState state;
  state.configurations = 3;
  state.budget = 60;
  state.first_samples = first;
  while (true) {
    state.finished = finished;
    const auto job = next_job(state);
    if (!job) break;
    if (job->configuration == kReference && !finished.empty()) state.reference_samples = job->samples;
    finished.push_back({*job, 0.02 * double(job->samples), 0.02 * double(job->samples) + 0.01});
    state.spent += finished.back().total_seconds;
  }
  const auto count = replicas(finished);
  EXPECT_EQ(count.at({1, 1}), 1) << "its cost";
  EXPECT_FALSE(count.contains({1, 4}) || count.contains({1, 16}));
  EXPECT_EQ(count.at({1, 32}), 2);
  EXPECT_EQ(count.at({0, 32}), 2);
  EXPECT_EQ(count.at({1, 64}), 2);
}

TEST(Plan, ForecastIsWhatHappens) {
  const auto jobs = simulate(6, 0.05, 100);
  StudyState state;
  state.configurations = 6;
  state.budget = 100;
  const std::span<const FinishedJob> calibrated(jobs.data(), 7);
  state.finished = calibrated;
  state.spent = total({calibrated.begin(), calibrated.end()});
  const Forecast ahead = forecast(state);
  EXPECT_EQ(ahead.jobs.size(), jobs.size() - 7);
  EXPECT_NEAR(ahead.seconds, total(jobs) - state.spent, 1e-6);
}

TEST(Plan, TooSmallABudgetStillGivesAReference) {
  const auto count = replicas(simulate(5, 10, 1));
  EXPECT_EQ(count.at({kReference, 1}), 2);
}

TEST(Plan, ALostReplicaIsRenderedAgain) {
  auto jobs = simulate(3, 0.05, 60);
  const auto lost = std::find_if(jobs.begin(), jobs.end(), [](const FinishedJob& f) { return f.job == Job{1, 4, 0}; });
  ASSERT_NE(lost, jobs.end());
  jobs.erase(lost);
  StudyState state;
  state.configurations = 3;
  state.budget = 120;
  state.spent = total(jobs);
  state.finished = jobs;
  EXPECT_EQ(next_job(state), (Job{1, 4, 0}));
}

TEST(Plan, SeedsAreSharedByConfigurationsAloneAndNeverTwiceTheSame) {
  EXPECT_EQ(seed_of({0, 4, 1}), seed_of({7, 4, 1}));
  std::set<uint32_t> seeds;
  for (const int c : {kReference, 0})
    for (uint64_t samples = 1; samples <= kHighestSamples; samples *= 2)
      for (int r = 0; r < kMostReferenceReplicas; ++r) EXPECT_TRUE(seeds.insert(seed_of({c, samples, r})).second);
}

}  // namespace
}  // namespace alabaster::tradeoff
