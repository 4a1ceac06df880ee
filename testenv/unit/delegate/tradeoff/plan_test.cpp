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
