#include "delegate/tradeoff/report.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <nlohmann/json.hpp>
#include <thread>

#include "delegate/support/output_file.h"
#include "delegate/support/size_text.h"
#include "delegate/tradeoff/advice.h"
#include "delegate/tradeoff/pareto.h"
#include "delegate/tradeoff/plot.h"
#include "delegate/tradeoff/tiles.h"

namespace alabaster::tradeoff {
namespace {

using nlohmann::ordered_json;

/// An unknown number is null in JSON and empty in CSV.
ordered_json number_or_null(double value) {
  return std::isfinite(value) ? ordered_json(value) : ordered_json(nullptr);
}

double z_of(const Estimate& estimate) {
  return estimate.standard_error > 0 ? estimate.value / estimate.standard_error
                                     : std::numeric_limits<double>::quiet_NaN();
}

/// The columns of CSV and JSON. Squares are relative MSE.
ordered_json columns_of(const Row& row) {
  return {{"configuration", row.configuration},
          {"group", row.group},
          {"samples", row.samples},
          {"replicas", row.replicas},
          {"cpuSeconds", number_or_null(row.cpu_seconds)},
          {"denoiseCpuSeconds", number_or_null(row.denoise_cpu_seconds)},
          {"wallSeconds", number_or_null(row.wall_seconds)},
          {"noise2", number_or_null(row.squared_noise.value)},
          {"noise2Low", number_or_null(row.squared_noise.low)},
          {"noise2High", number_or_null(row.squared_noise.high)},
          {"bias2", number_or_null(row.squared_bias.value)},
          {"bias2Low", number_or_null(row.squared_bias.low)},
          {"bias2High", number_or_null(row.squared_bias.high)},
          {"bias2Z", number_or_null(z_of(row.squared_bias))},
          {"levelBias", number_or_null(row.level_bias.value)},
          {"levelBiasLow", number_or_null(row.level_bias.low)},
          {"levelBiasHigh", number_or_null(row.level_bias.high)},
          {"levelBiasZ", number_or_null(z_of(row.level_bias))},
          {"total", number_or_null(row.total.value)},
          {"totalLow", number_or_null(row.total.low)},
          {"totalHigh", number_or_null(row.total.high)},
          {"displayRmse", number_or_null(row.display_rmse)},
          {"flip", number_or_null(row.flip)},
          {"reportedError", number_or_null(row.reported_error)},
          {"pareto", row.pareto}};
}

std::string format(const char* pattern, double value) {
  if (!std::isfinite(value)) return "-";
  char text[64];
  std::snprintf(text, sizeof text, pattern, value);
  return text;
}

double root(double square) {
  return std::sqrt(std::max(0.0, square));
}

std::string percent(double value) {
  if (!std::isfinite(value)) return "-";
  return format(std::abs(value) < 0.001 ? "%.3f %%" : "%.2f %%", 100 * value);
}

// A name is the user's text: as UTF-8, since JSON and plots hold nothing else.
std::string caption_of(const Tile& tile) {
  if (tile.samples == 0) return tile.name;
  return tile.name + ", " + std::to_string(tile.samples) + (tile.samples == 1 ? " sample" : " samples");
}

std::string as_utf8(const std::string& name) {
  return ordered_json::parse(ordered_json(name).dump(-1, ' ', false, ordered_json::error_handler_t::replace));
}

std::string on_one_line(std::string text) {
  std::replace_if(
      text.begin(), text.end(), [](unsigned char c) { return c < 32 || c == 127; }, ' ');
  return text;
}

/// A name that makes no marks, links or tags of its own in Markdown.
std::string in_markdown(const std::string& name) {
  std::string text;
  for (const char c : on_one_line(name)) {
    if (std::strchr("!\"#$%&'()*+/:;<=>?@[\\]^_`{|}~", c)) text += '\\';
    text += c;
  }
  return text;
}

/// Between more backticks than it holds in a row.
std::string as_code(const std::string& command) {
  const std::string text = on_one_line(command);
  std::string fence = "`";
  while (text.find(fence) != std::string::npos) fence += '`';
  return fence.size() == 1 ? fence + text + fence : fence + " " + text + " " + fence;
}

/// "5.2 % (4.1 to 6.1)"; "below 2.9 %" where it may be 0.
std::string bias_text(const Estimate& squared) {
  if (!(squared.high > 0)) return "none seen";
  if (!is_certain(squared)) return "below " + percent(root(squared.high));
  return percent(root(squared.value)) + " (" + format("%.1f", 100 * root(squared.low)) + " to " +
         format("%.1f", 100 * root(squared.high)) + ")";
}

std::string interval_text(const Estimate& ratio) {
  if (!std::isfinite(ratio.value)) return "-";
  return format("%.2f", ratio.value) + " (" + format("%.2f", ratio.low) + " to " + format("%.2f", ratio.high) + ")";
}

std::string summary_line(const ConfigurationSummary& summary) {
  const Row& row = *summary.best;
  return "| " + row.configuration + " | " + (row.group == "base" ? "1" : interval_text(summary.cost_ratio)) + " | " +
         (summary.compared_at > 0 ? std::to_string(summary.compared_at) : "-") + " | " + bias_text(row.squared_bias) +
         " | " + (row.level_bias.value > 0 ? "+" : "") + percent(row.level_bias.value) + " | " +
         format("%.1f", z_of(row.level_bias)) + " | " + format("%.3g", row.cpu_seconds / double(row.samples)) + " | " +
         format("%.4f", row.flip) + " |\n";
}

/// Configurations without a measurable effect share one line below the table.
std::string summary_table(const std::vector<ConfigurationSummary>& summaries) {
  std::string text =
      "| configuration | cost at equal noise (95 %) | at samples | bias (95 %) | mean level | its z | CPU s per sample "
      "| "
      "FLIP |\n"
      "|--|--|--|--|--|--|--|--|\n";
  std::string folded;
  double least = INFINITY, most = 0, bias = 0;
  for (const ConfigurationSummary& summary : summaries) {
    if (summary.has_effect || summary.best->group == "base") {
      text += summary_line(summary);
      continue;
    }
    folded += (folded.empty() ? "" : ", ") + summary.best->configuration;
    least = std::min(least, summary.cost_ratio.low), most = std::max(most, summary.cost_ratio.high);
    bias = std::max(bias, root(summary.best->squared_bias.high));
  }
  if (!folded.empty())
    text += "\nNo measurable effect: " + folded + " (cost " + format("%.2f", least) + " to " + format("%.2f", most) +
            " of the base's, bias below " + percent(bias) + ").\n";
  return text;
}

std::string row_table(const std::vector<const Row*>& rows) {
  std::string text =
      "| configuration | samples | CPU s | wall s | noise | own estimate | bias | error | display RMSE | FLIP | front "
      "|\n"
      "|--|--|--|--|--|--|--|--|--|--|--|\n";
  for (const Row* row : rows)
    text += "| " + row->configuration + " | " + std::to_string(row->samples) + " | " +
            format("%.3g", row->cpu_seconds) + " | " + format("%.3g", row->wall_seconds) + " | " +
            percent(root(row->squared_noise.value)) + " | " + percent(row->reported_error) + " | " +
            bias_text(row->squared_bias) + " | " + percent(row->total.value) + " | " +
            format("%.4f", row->display_rmse) + " | " + format("%.4f", row->flip) + " | " + (row->pareto ? "*" : "") +
            " |\n";
  return text;
}

std::string denoised_text(const StudyResult& result) {
  std::string rows;
  for (const Row& row : result.rows) {
    if (!row.denoised) continue;
    const auto rendered = std::find_if(result.rows.begin(), result.rows.end(), [&](const Row& other) {
      return row.configuration == other.configuration + " " + kDenoised && other.samples == row.samples;
    });
    rows += "| " + row.configuration + " | " + std::to_string(row.samples) + " | " + format("%.3g", row.cpu_seconds) +
            " | " + format("%.3g", row.denoise_cpu_seconds) + " | " + percent(root(row.squared_noise.value)) + " | " +
            bias_text(row.squared_bias) + " | " + (row.level_bias.value > 0 ? "+" : "") +
            percent(row.level_bias.value) + " | " + percent(row.total.value) + " | " + percent(rendered->total.value) +
            " | " + format("%.4f", row.flip) + " | " + (row.pareto ? "*" : "") + " |\n";
  }
  if (rows.empty()) return "";
  return "\n## Denoised\nNoise is what differs between replicas, and bias what their mean has too much or too little, "
         "at "
         "this number of samples: more samples reduce both. Neighbouring pixels share noise, so the intervals follow "
         "from the scatter over blocks of 32 x 32 pixels. The front is that of the denoised rows.\n\n"
         "| configuration | samples | CPU s | of it denoising | noise | bias (95 %) | mean level | error | "
         "error as rendered | FLIP | front |\n|--|--|--|--|--|--|--|--|--|--|--|\n" +
         rows;
}

/// Names the configuration with the largest certain bias and the one that costs most at equal noise.
std::string worst_text(const std::vector<ConfigurationSummary>& summaries) {
  const ConfigurationSummary *biased = nullptr, *dear = nullptr;
  for (const ConfigurationSummary& summary : summaries) {
    const Row& row = *summary.best;
    if (is_certain(row.squared_bias) && (!biased || row.squared_bias.value > biased->best->squared_bias.value))
      biased = &summary;
    if (summary.cost_ratio.low > 1 && (!dear || summary.cost_ratio.value > dear->cost_ratio.value)) dear = &summary;
  }
  std::string text =
      biased ? "Largest bias: **" + biased->best->configuration + "**, " + bias_text(biased->best->squared_bias) + ".\n"
             : "No configuration has a bias that the measurement can distinguish from zero.\n";
  if (dear)
    text += "Most expensive at equal noise: **" + dear->best->configuration + "**, " + interval_text(dear->cost_ratio) +
            " times the cost of the base.\n";
  return text;
}

std::string reference_text(const ReferenceSummary& reference) {
  return "Reference: mode `reference`, " + std::to_string(reference.replicas) + " replicas of " +
         std::to_string(reference.samples) + " samples, " + format("%.0f", reference.cpu_seconds) +
         " CPU s; the noise of its mean, " + percent(reference.noise) +
         ", is subtracted from every bias. It cannot be subtracted from display RMSE and FLIP, which between the "
         "reference's two halves are " +
         format("%.4f", reference.display_rmse) + " and " + format("%.4f", reference.flip) +
         ": smaller values are noise.\n";
}

std::string base_depth(const ConfigurationList& list) {
  const auto depth = list.measured.front().settings.find("maxDepth");
  return depth == list.measured.front().settings.end() ? "8" : depth->second.to_string();
}

/// The last lines of the report.
std::string advice_text(const StudyResult& result, const ConfigurationList& list, const ReportContext& context) {
  const unsigned threads = std::max(1u, std::thread::hardware_concurrency());
  const double pixels =
      double(context.scene_width) * context.scene_height / (double(context.identity.width) * context.identity.height);
  std::string text;
  for (const Advice& advice : advise(result, list, {pixels, threads, context.render_command}))
    text += "- " +
            std::string(advice.seconds < 61    ? "a minute"
                        : advice.seconds < 601 ? "ten minutes"
                                               : "an hour") +
            ": " + percent(advice.error.value) + " (" + format("%.3g", 100 * advice.error.low) + " to " +
            format("%.3g", 100 * advice.error.high) + "), " + as_code(advice.command) + "\n";
  if (text.empty()) return "";
  return "\n## What to choose\nFor a frame of " + hd::support::size_option(context.scene_width, context.scene_height) +
         " on " + std::to_string(threads) + (threads == 1 ? " thread" : " threads") +
         ", the error that is expected in the time, and its command. The base is left for what errs less beyond both "
         "intervals, even if a bias that may be 0 is at its end:\n\n" +
         text;
}

std::string left_out_text(const StudyResult& result, const ConfigurationList& list) {
  std::string lines;
  for (const std::string& line : list.skipped) lines += "- " + line + "\n";
  for (const Configuration& configuration : list.measured)
    if (std::none_of(result.rows.begin(), result.rows.end(),
                     [&](const Row& row) { return row.configuration == configuration.name; }))
      lines += "- " + configuration.name + ": no time for two replicas\n";
  return lines.empty() ? "" : "\n## Skipped\n" + lines;
}

/// Few curves, which can be told apart: the base, as rendered and denoised, then those that have a point on the front,
/// then those that differ most from the base in cost or error.
std::vector<std::string> plotted(const StudyResult& result) {
  constexpr size_t kMostCurves = 7;
  std::vector<std::string> shown;
  const auto show = [&](const std::string& name) {
    if (shown.size() < kMostCurves && std::find(shown.begin(), shown.end(), name) == shown.end()) shown.push_back(name);
  };
  if (result.rows.empty()) return shown;
  show(result.rows.front().configuration);
  for (const Row& row : result.rows)
    if (row.denoised && row.configuration.starts_with(shown.front() + " ")) show(row.configuration);
  for (const Row& row : result.rows)
    if (row.pareto && !row.denoised) show(row.configuration);
  std::vector<ConfigurationSummary> others = summarize(result);
  std::erase_if(others, [](const ConfigurationSummary& s) { return !s.has_effect; });
  const auto effect = [](const ConfigurationSummary& s) {
    const double cost = s.cost_ratio.value > 0 ? std::abs(std::log(s.cost_ratio.value)) : 0;
    return std::max(cost, 10 * std::sqrt(counted(s.best->squared_bias)));
  };
  std::stable_sort(others.begin(), others.end(), [&](const auto& a, const auto& b) { return effect(a) > effect(b); });
  for (const ConfigurationSummary& summary : others) show(summary.best->configuration);
  return shown;
}

Plot plot_of(const StudyResult& result, const ReportContext& context) {
  Plot plot;
  plot.title = as_utf8(std::filesystem::path(context.identity.scene).filename()) + ", " +
               hd::support::size_option(context.identity.width, context.identity.height);
  plot.error_label = "relative RMSE (noise and bias)";
  const std::vector<std::string> shown = plotted(result);
  for (const Row& row : result.rows) {
    if (std::find(shown.begin(), shown.end(), row.configuration) == shown.end()) continue;
    if (plot.lines.empty() || plot.lines.back().name != row.configuration)
      plot.lines.push_back({row.configuration, row.configuration, {}});
    plot.lines.back().points.push_back(
        {row.cpu_seconds, row.total.value, row.total.low, row.total.high, row.pareto && !row.denoised});
  }
  return plot;
}

}  // namespace

std::string machine_name() {
  std::ifstream file("/proc/cpuinfo");
  std::string line, model = "unknown processor";
  while (std::getline(file, line))
    if (line.starts_with("model name") && line.find(": ") != std::string::npos) {
      model = line.substr(line.find(": ") + 2);
      break;
    }
  return model + ", " + std::to_string(std::thread::hardware_concurrency()) + " threads";
}

std::string csv_text(const StudyResult& result) {
  std::string text;
  for (const Row& row : result.rows) {
    const ordered_json columns = columns_of(row);
    std::string names, values;
    for (const auto& [name, value] : columns.items()) {
      const char* separator = names.empty() ? "" : ",";
      names += separator + name;
      values += separator + (value.is_null() ? "" : value.is_string() ? value.get<std::string>() : value.dump());
    }
    if (text.empty()) text = names + "\n";
    text += values + "\n";
  }
  return text;
}

std::string json_text(const StudyResult& result, const ConfigurationList& list, const ReportContext& context) {
  const ReferenceSummary& reference = result.reference;
  ordered_json report{{"command", context.command},
                      {"scene", context.identity.scene},
                      {"sceneHash", context.identity.scene_hash},
                      {"resolution", {context.identity.width, context.identity.height}},
                      {"sceneResolution", {context.scene_width, context.scene_height}},
                      {"machine", machine_name()},
                      {"versions", AlabasterVersions()},
                      {"complete", context.complete},
                      {"spentSeconds", number_or_null(context.spent_seconds)},
                      {"reference",
                       {{"settings", list.reference.fingerprint()},
                        {"samples", reference.samples},
                        {"replicas", reference.replicas},
                        {"cpuSeconds", number_or_null(reference.cpu_seconds)},
                        {"noise", number_or_null(reference.noise)},
                        {"displayRmseOfHalves", number_or_null(reference.display_rmse)},
                        {"flipOfHalves", number_or_null(reference.flip)}}},
                      {"configurations", ordered_json::array()},
                      {"skipped", list.skipped},
                      {"rows", ordered_json::array()}};
  for (const Configuration& configuration : list.measured)
    report["configurations"].push_back(
        {{"name", configuration.name}, {"group", configuration.group}, {"settings", configuration.fingerprint()}});
  for (const Row& row : result.rows) report["rows"].push_back(columns_of(row));
  for (const ConfigurationSummary& summary : summarize(result))
    report["summaries"].push_back({{"configuration", summary.best->configuration},
                                   {"cost", number_or_null(summary.cost_ratio.value)},
                                   {"costLow", number_or_null(summary.cost_ratio.low)},
                                   {"costHigh", number_or_null(summary.cost_ratio.high)},
                                   {"comparedAt", summary.compared_at},
                                   {"hasEffect", summary.has_effect}});
  return report.dump(2, ' ', false, ordered_json::error_handler_t::replace) + "\n";
}

std::string markdown_text(const StudyResult& result, const ConfigurationList& list, const ReportContext& context) {
  const std::vector<ConfigurationSummary> summaries = summarize(result);
  std::vector<const Row*> all, front;
  for (const Row& row : result.rows)
    if (!row.denoised) all.push_back(&row);
  std::copy_if(all.begin(), all.end(), std::back_inserter(front), [](const Row* row) { return row->pareto; });
  std::sort(front.begin(), front.end(), [](const Row* a, const Row* b) { return a->cpu_seconds < b->cpu_seconds; });
  const StudyIdentity& identity = context.identity;
  const std::string scene = std::filesystem::path(identity.scene).filename();
  std::string text = "# Speed against accuracy: " + in_markdown(scene) + "\n\n";
  text += as_code(context.command) + ", " + hd::support::size_option(identity.width, identity.height);
  if (identity.width != context.scene_width || identity.height != context.scene_height)
    text += " (the scene asks for " + hd::support::size_option(context.scene_width, context.scene_height) + ")";
  text += ", " + machine_name() + ", " + format("%.1f", context.spent_seconds / 60) + " minutes of rendering" +
          (context.complete ? "" : ", INTERRUPTED: results so far") + ".\n\n";
  text += reference_text(result.reference);
  text +=
      "\n## Each configuration\nEach differs from the base, `walk` of depth " + base_depth(list) +
      ", in one setting, and presets (`quality=`) in several; their limits of samples and error are left out. Cost at "
      "equal noise: noise^2 x CPU seconds relative to the base, at the highest sample count that both have; a CPU time "
      "is good to " +
      format("%.0f %%", std::ceil(100 * result.timing_error)) +
      ". Bias: the relative RMSE that remains with any number of samples; *below x* where it may be 0, and then it "
      "counts as 0. All configurations share their random numbers, so their rows are correlated; the reference has its "
      "own. No interval accounts for rare bright samples that have not occurred yet.\n\n" +
      summary_table(summaries) + "\n" + worst_text(summaries);
  if (!result.tiles.empty()) text += "\n![The same part of each picture](pictures.png)\n";
  text +=
      "\n## The front\n![Error against CPU seconds](tradeoff.svg)\n\nBeyond its interval no other configuration "
      "errs less at its cost, and it errs less than those above it. Error: the root of bias^2 + noise^2. Own estimate: "
      "the noise that the renders report, relative to their own levels instead of the reference's.\n\n" +
      row_table(front) + "\n## All measurements\n" + row_table(all) + denoised_text(result);
  return text + left_out_text(result, list) + advice_text(result, list, context);
}

std::vector<std::string> write_report(const StudyResult& result, const ConfigurationList& list,
                                      const ReportContext& context, const std::filesystem::path& folder,
                                      std::vector<std::string>* problems) {
  std::vector<std::string> written;
  const auto keep = [&](const std::string& file, const std::string& problem) {
    if (problem.empty())
      written.push_back(file);
    else
      problems->push_back(file + ": " + problem);
  };
  const std::pair<const char*, std::string> texts[] = {{"tradeoff.csv", csv_text(result)},
                                                       {"tradeoff.json", json_text(result, list, context)},
                                                       {"tradeoff.md", markdown_text(result, list, context)}};
  for (const auto& [name, text] : texts) {
    const std::string file = (folder / name).string();
    keep(file, hd::support::WriteOutputFile(file, {reinterpret_cast<const uint8_t*>(text.data()), text.size()},
                                            hd::support::Flush::none));
  }
  const Plot plot = plot_of(result, context);
  for (const char* name : {"tradeoff.svg", "tradeoff.png"}) {
    const std::string file = (folder / name).string();
    keep(file, draw_plot(plot, file));
  }
  if (!result.tiles.empty()) {
    const std::string file = (folder / "pictures.png").string();
    std::vector<CaptionedTile> tiles;
    for (const Tile& tile : result.tiles) tiles.push_back({caption_of(tile), {}, &tile.pixels});
    keep(file, draw_tiles(tiles, file));
  }
  return written;
}

}  // namespace alabaster::tradeoff
