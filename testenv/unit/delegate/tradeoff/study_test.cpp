// Studies of a renderer that is a random number generator: storage, resumption, reports.
#include "delegate/tradeoff/study.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <random>
#include <set>
#include <sstream>

#include "delegate/tradeoff/report.h"

namespace alabaster::tradeoff {
namespace {

namespace fs = std::filesystem;

Configuration configuration(const std::string& name, const std::string& group, double bias, double noise = 0.5) {
  Configuration c;
  c.name = name;
  c.group = group;
  c.settings["bias"] = bias;
  c.settings["noise"] = noise;
  return c;
}

class Study : public ::testing::Test {
 protected:
  void SetUp() override {
    const auto* info = ::testing::UnitTest::GetInstance()->current_test_info();
    folder_ =
        fs::temp_directory_path() / ("alabaster_study_" + std::string(info->name()) + "_" + std::to_string(getpid()));
    list_.reference = configuration("the reference", "the reference", 0);
    list_.measured = {configuration("walk", "base", 0), configuration("lambert", "subsurface", -0.3)};
    list_.skipped = {"refineLevel-1: no mesh of the scene is subdivided"};
  }
  void TearDown() override { fs::remove_all(folder_); }

  StudyStore open(const std::string& name, bool restart = false) {
    StudyStore store;
    EXPECT_EQ(store.open(folder_ / name, restart), "");
    if (store.empty()) store.identity = {"scene.glb", "0123", 16, 12, "1.0"};
    return store;
  }

  static RenderedFrame frame(const Configuration& c, uint64_t samples, uint32_t seed) {
    std::mt19937 random(seed);
    std::normal_distribution<double> normal;
    RenderedFrame frame{{16, 12, std::vector<float>(3 * 16 * 12)}, {}, {}};
    for (float& v : frame.image.rgb)
      v = static_cast<float>(1 + c.settings.at("bias").number_or(0) +
                             c.settings.at("noise").number_or(0) / std::sqrt(double(samples)) * normal(random));
    frame.cost = {0.02 * double(samples), 0.01 * double(samples), 0.01 * double(samples) + 0.001, -1};
    return frame;
  }

  /// Renders until the budget is spent or there are `most` pictures.
  StudyOutcome run(StudyStore* store, size_t most = 1000000, double budget = 20,
                   std::vector<StudyProgress>* told = nullptr) {
    rendered_ = 0;
    StudyHooks hooks;
    hooks.render = [this](const Configuration& c, uint64_t samples, uint32_t seed) {
      ++rendered_;
      return std::optional(frame(c, samples, seed));
    };
    hooks.cancelled = [this, most] { return rendered_ >= most; };
    hooks.progress = [told](const StudyProgress& progress) {
      if (told) told->push_back(progress);
    };
    hooks.note = [](const std::string&) {};
    hooks.stored = [] {};
    return run_study(list_, budget, store, hooks, &problem_);
  }

  std::optional<StudyResult> results(const StudyStore& store) {
    const DisplayFunction display = [](const Image& image) { return std::optional(image); };
    return analyse(store, list_, display, &problem_);
  }

  fs::path folder_;
  ConfigurationList list_;
  std::string problem_;
  size_t rendered_ = 0;
};

TEST_F(Study, NoiseAndBiasAreSeparated) {
  StudyStore store = open("a");
  ASSERT_EQ(run(&store), StudyOutcome::finished);
  const auto result = results(store);
  ASSERT_TRUE(result) << problem_;
  ASSERT_GE(result->rows.size(), 6u);
  for (const Row& row : result->rows) {
    EXPECT_NEAR(row.squared_noise.value, 0.25 / double(row.samples), 0.05 / double(row.samples));
    if (row.configuration == "walk") {
      EXPECT_LE(std::abs(row.squared_bias.value), 4 * row.squared_bias.standard_error);
    } else {
      EXPECT_NEAR(row.squared_bias.value, 0.09, 5 * row.squared_bias.standard_error);
      EXPECT_NEAR(row.level_bias.value, -0.3, 5 * row.level_bias.standard_error);
    }
    EXPECT_NEAR(row.cpu_seconds, 0.02 * double(row.samples), 1e-9);
  }
  EXPECT_TRUE(result->rows.front().pareto);
}

TEST_F(Study, AnInterruptedStudyGivesTheSameNumbers) {
  StudyStore whole = open("whole");
  ASSERT_EQ(run(&whole), StudyOutcome::finished);
  const std::string expected = csv_text(*results(whole));
  for (int part = 0;; ++part) {
    StudyStore store = open("parts");
    const StudyOutcome outcome = run(&store, 5);
    if (outcome == StudyOutcome::finished) break;
    ASSERT_EQ(outcome, StudyOutcome::cancelled);
    ASSERT_LT(part, 100);
  }
  EXPECT_EQ(csv_text(*results(open("parts"))), expected);
}

TEST_F(Study, DamagedPicturesAreRenderedAgain) {
  StudyStore first = open("a");
  ASSERT_EQ(run(&first), StudyOutcome::finished);
  const std::string expected = csv_text(*results(first));
  const StoredRender& some = first.renders()[3];
  std::fstream file(folder_ / "a" / some.file, std::ios::in | std::ios::out | std::ios::binary);
  file.seekp(100);
  file.put('x');
  file.close();
  // The rest of the budget is not enough for it.
  const auto dearest = std::max_element(
      first.renders().begin(), first.renders().end(),
      [](const StoredRender& x, const StoredRender& y) { return x.cost.total_seconds < y.cost.total_seconds; });
  ASSERT_GT(dearest->cost.total_seconds, 20 - first.spent);
  fs::remove(folder_ / "a" / dearest->file);
  StudyStore again = open("a");
  EXPECT_EQ(again.notes().size(), 2u);
  ASSERT_EQ(run(&again, 2), StudyOutcome::cancelled);
  EXPECT_EQ(csv_text(*results(again)), expected);
}

TEST_F(Study, ChangedSettingsAreMeasuredAnew) {
  StudyStore first = open("a");
  ASSERT_EQ(run(&first), StudyOutcome::finished);
  list_.measured[1].settings["bias"] = 0.5;
  EXPECT_FALSE(find_configuration(list_, first.renders().back()) == 1);
  const auto result = results(first);
  ASSERT_TRUE(result);
  for (const Row& row : result->rows) EXPECT_EQ(row.configuration, "walk");
}

TEST_F(Study, StateKeepsVersionsAndOlderStateHasNone) {
  StudyStore first = open("a");
  first.identity.versions = "1.2";
  ASSERT_EQ(run(&first, 3), StudyOutcome::cancelled);
  EXPECT_EQ(open("a").identity, first.identity);
  std::ifstream in(folder_ / "a" / "state.json");
  auto state = nlohmann::json::parse(in);
  state.erase("versions");
  std::ofstream(folder_ / "a" / "state.json") << state;
  EXPECT_EQ(open("a").identity.versions, "");
}

TEST_F(Study, NothingIsLeftOfWhatCannotBeListedOrIsBegunAnew) {
  StudyStore store = open("a");
  ASSERT_EQ(run(&store, 2), StudyOutcome::cancelled);
  fs::remove(folder_ / "a" / "state.json");
  fs::create_directories(folder_ / "a" / "state.json" / "x");  // cannot be replaced by a file
  const size_t before = store.renders().size();
  const double spent = store.spent;
  EXPECT_EQ(run(&store, 1), StudyOutcome::output_failed);
  EXPECT_EQ(store.renders().size(), before);
  EXPECT_DOUBLE_EQ(store.spent, spent);
  const auto files = [&] { return std::distance(fs::directory_iterator(folder_ / "a"), {}); };
  EXPECT_EQ(files(), 3);  // two pictures and the invalid list
  StudyStore stuck;
  EXPECT_NE(stuck.open(folder_ / "a", true).find("-o"), std::string::npos);
  fs::remove_all(folder_ / "a" / "state.json");
  EXPECT_EQ(stuck.open(folder_ / "a", true), "");
  EXPECT_EQ(files(), 0);
}

TEST_F(Study, AStateWithImpossibleSamplesIsRefused) {
  StudyStore first = open("a");
  ASSERT_EQ(run(&first, 2), StudyOutcome::cancelled);
  const fs::path file = folder_ / "a" / "state.json";
  const auto state = nlohmann::json::parse(std::ifstream(file));
  for (const uint64_t samples : {uint64_t(0), uint64_t(1) << 63}) {
    for (const bool reference : {false, true}) {
      auto damaged = state;
      (reference ? damaged["referenceSamples"] : damaged["renders"][0]["samples"]) = samples;
      if (reference && samples == 0) continue;  // none is chosen yet
      std::ofstream(file) << damaged;
      StudyStore store;
      EXPECT_NE(store.open(folder_ / "a", false).find("--restart"), std::string::npos) << samples << reference;
    }
  }
}

TEST_F(Study, ForeignStateIsRefused) {
  fs::create_directories(folder_ / "a");
  std::ofstream(folder_ / "a" / "state.json") << R"({"format": 1, "scene": 7})";
  StudyStore store;
  EXPECT_NE(store.open(folder_ / "a", false).find("--restart"), std::string::npos);
  StudyStore fresh;
  EXPECT_EQ(fresh.open(folder_ / "a", true), "");
  EXPECT_TRUE(fresh.empty());
  StudyStore outside;
  EXPECT_NE(outside.open("/proc/nowhere", false).find("-o"), std::string::npos);
}

TEST_F(Study, TheLeastBudgetIsNeededAndSuffices) {
  StudyStore store = open("a");
  ASSERT_EQ(run(&store, 1000000, 1e-3), StudyOutcome::finished);
  const auto none = results(store);
  ASSERT_TRUE(none) << problem_;
  EXPECT_TRUE(none->rows.empty());
  const double least = least_budget(list_, store);
  ASSERT_EQ(run(&store, 1000000, 0.8 * least), StudyOutcome::finished);
  const auto measured = [&] {
    const auto result = results(store);
    std::set<std::string> names;
    for (const Row& row : result->rows) names.insert(row.configuration);
    return names.size();
  };
  EXPECT_LT(measured(), 2u);
  ASSERT_EQ(run(&store, 1000000, 1.001 * least), StudyOutcome::finished);
  EXPECT_EQ(measured(), 2u);
}

TEST_F(Study, ForecastIsReportedOnceTheCostIsKnown) {
  StudyStore store = open("a");
  std::vector<StudyProgress> told;
  ASSERT_EQ(run(&store, 1000000, 1e-3, &told), StudyOutcome::finished);  // ends while costs are being measured
  std::set<std::string> seen;
  for (const StudyProgress& progress : told)
    EXPECT_EQ(progress.total == 0, seen.insert(progress.configuration).second) << progress.configuration;
  EXPECT_GT(told.size(), seen.size());
}

TEST_F(Study, WithoutAReferenceThereIsNoReport) {
  StudyStore store = open("a");
  ASSERT_EQ(run(&store, 4), StudyOutcome::cancelled);
  EXPECT_FALSE(results(store));
  EXPECT_NE(problem_.find("--budget"), std::string::npos);
}

std::vector<std::string> cells(const std::string& line) {
  std::vector<std::string> cells;
  std::istringstream stream(line);
  for (std::string cell; std::getline(stream, cell, ',');) cells.push_back(cell);
  return cells;
}

TEST_F(Study, CsvJsonAndMarkdownAgree) {
  StudyStore store = open("a");
  ASSERT_EQ(run(&store), StudyOutcome::finished);
  const auto result = results(store);
  ASSERT_TRUE(result);
  list_.measured.push_back(configuration("late", "late", 0));  // was never reached
  const ReportContext context{"alabaster tradeoff scene.glb",
                              "alabaster render scene.glb -o frame.exr",
                              store.identity,
                              32,
                              24,
                              store.spent,
                              true};
  const auto json = nlohmann::ordered_json::parse(json_text(*result, list_, context));
  std::istringstream csv(csv_text(*result));
  std::string line;
  std::getline(csv, line);
  const std::vector<std::string> names = cells(line);
  EXPECT_EQ(names.size(), json["rows"][0].size());
  for (const auto& row : json["rows"]) {
    ASSERT_TRUE(std::getline(csv, line));
    const std::vector<std::string> values = cells(line);
    ASSERT_EQ(values.size(), names.size());
    for (size_t i = 0; i < names.size(); ++i) {
      const auto& value = row.at(names[i]);
      EXPECT_EQ(values[i], value.is_null() ? "" : value.is_string() ? value.get<std::string>() : value.dump());
    }
  }
  EXPECT_FALSE(std::getline(csv, line));
  EXPECT_EQ(json["rows"][0]["noise2"].get<double>(), result->rows[0].squared_noise.value);
  const std::string text = markdown_text(*result, list_, context);
  const ConfigurationSummary other = summarize(*result).back();
  EXPECT_GT(other.compared_at, 0u);
  char cost[64];
  std::snprintf(cost, sizeof cost, "| lambert | %.2f (%.2f to %.2f) | %llu |", other.cost_ratio.value,
                other.cost_ratio.low, other.cost_ratio.high, static_cast<unsigned long long>(other.compared_at));
  EXPECT_NE(text.find(cost), std::string::npos) << text;
  EXPECT_NE(text.find("Largest bias: **lambert**"), std::string::npos) << text;
  EXPECT_NE(text.find("refineLevel-1: no mesh"), std::string::npos);
  EXPECT_NE(text.find("late: no time"), std::string::npos);
}

// A configuration that changes nothing shares a line; one whose bias is certain is not recommended for long.
TEST_F(Study, IneffectiveSettingsAreFoldedAndTheBestRecommended) {
  list_.measured.push_back(configuration("same", "same", 0));
  list_.measured[1].flags = "--subsurface lambert";
  StudyStore store = open("a");
  ASSERT_EQ(run(&store), StudyOutcome::finished);
  const auto result = results(store);
  ASSERT_TRUE(result) << problem_;
  const ReportContext context{"a", "alabaster render s.glb -o frame.exr", store.identity, 32, 24, store.spent, true};
  const std::string text = markdown_text(*result, list_, context);
  EXPECT_NE(text.find("No measurable effect: same ("), std::string::npos) << text;
  EXPECT_EQ(text.find("| same |"), text.find("| same |", text.find("## All measurements"))) << "in no other table";
  EXPECT_NE(text.find("| walk | 1 | "), std::string::npos);
  EXPECT_NE(text.find(" | below "), std::string::npos) << "the walk's bias may be 0";
  for (const Row& row : result->rows) {
    EXPECT_EQ(row.pareto, row.configuration == "walk") << row.configuration << row.samples;
    if (row.configuration == "walk") {
      EXPECT_NEAR(row.total.value, std::sqrt(row.squared_noise.value), 1e-12);
    }
  }
  const size_t advice = text.find("## What to choose");
  ASSERT_NE(advice, std::string::npos);
  for (const char* budget : {"- a minute: ", "- ten minutes: ", "- an hour: "}) EXPECT_GT(text.find(budget), advice);
  EXPECT_EQ(text.find("lambert", advice), std::string::npos) << "its bias is 30 %";
  ASSERT_EQ(result->tiles.size(), 3u) << "the reference, the base and lambert";
  EXPECT_EQ(result->tiles[1].pixels.pixels(), result->tiles[0].pixels.pixels());
}

// Where another configuration beats the base, one that is like the base may be unbeaten by chance.
TEST_F(Study, IneffectiveSettingsAreNotOnTheFront) {
  list_.measured[1] = configuration("alike", "alike", 0, 0.46);
  list_.measured.push_back(configuration("better", "better", 0, 0.42));
  StudyStore store = open("a");
  ASSERT_EQ(run(&store), StudyOutcome::finished);
  const auto result = results(store);
  ASSERT_TRUE(result) << problem_;
  const auto summaries = summarize(*result);
  ASSERT_EQ(summaries.size(), 3u);
  ASSERT_FALSE(summaries[1].has_effect);
  ASSERT_TRUE(summaries[2].has_effect);
  std::set<std::string> front;
  for (const Row& row : result->rows)
    if (row.pareto) front.insert(row.configuration);
  EXPECT_EQ(front, std::set<std::string>{"better"});
}

TEST_F(Study, NamesAreTakenLiterallyInReports) {
  StudyStore store = open("a");
  store.identity.scene = "a*_b_*<img src=x>|`c`\n# d\xff.glb";
  ASSERT_EQ(run(&store), StudyOutcome::finished);
  const auto result = results(store);
  ASSERT_TRUE(result);
  const ReportContext context{
      "alabaster tradeoff 'x``y'\nz", "alabaster render x", store.identity, 32, 24, store.spent, true};
  EXPECT_TRUE(nlohmann::ordered_json::parse(json_text(*result, list_, context)).is_object());
  const std::string text = markdown_text(*result, list_, context);
  EXPECT_TRUE(
      text.starts_with("# Speed against accuracy: a\\*\\_b\\_\\*\\<img src\\=x\\>\\|\\`c\\` \\# d\xff.glb\n\n"
                       "``` alabaster tradeoff 'x``y' z ```, "))
      << text;
}

TEST(AffordableSize, KeepsProportionsAndNeverEnlarges) {
  EXPECT_EQ(affordable_size({640, 480}, 1e-9, 10, 600), hd::Vec2i(640, 480));
  const hd::Vec2i small = affordable_size({640, 480}, 1e-4, 10, 600);
  EXPECT_LT(small.x, 640);
  EXPECT_NEAR(double(small.x) / small.y, 640.0 / 480, 0.03);
  EXPECT_GE(small.x * small.y, 63 * 63);
}

}  // namespace
}  // namespace alabaster::tradeoff
