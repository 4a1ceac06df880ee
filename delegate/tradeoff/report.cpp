#include "delegate/tradeoff/report.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <thread>

#include "delegate/support/output_file.h"
#include "delegate/tradeoff/plot.h"

namespace alabaster::tradeoff {
namespace {

using nlohmann::ordered_json;

/// An unknown number is null in JSON and empty in CSV.
ordered_json number(double value) {
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
          {"cpuSeconds", number(row.cpu_seconds)},
          {"denoiseCpuSeconds", number(row.denoise_cpu_seconds)},
          {"wallSeconds", number(row.wall_seconds)},
          {"noise2", number(row.squared_noise.value)},
          {"noise2Low", number(row.squared_noise.low)},
          {"noise2High", number(row.squared_noise.high)},
          {"bias2", number(row.squared_bias.value)},
          {"bias2Low", number(row.squared_bias.low)},
          {"bias2High", number(row.squared_bias.high)},
          {"bias2Z", number(z_of(row.squared_bias))},
          {"levelBias", number(row.level_bias.value)},
          {"levelBiasLow", number(row.level_bias.low)},
          {"levelBiasHigh", number(row.level_bias.high)},
          {"levelBiasZ", number(z_of(row.level_bias))},
          {"total", number(row.total)},
          {"displayRmse", number(row.display_rmse)},
          {"flip", number(row.flip)},
          {"reportedError", number(row.reported_error)},
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

std::string size_text(int width, int height) {
  return std::to_string(width) + "x" + std::to_string(height);
}

// A name is the user's text: as UTF-8, since JSON and plots hold nothing else.
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

std::string summary_table(const std::vector<ConfigurationSummary>& summaries) {
  std::string text =
      "| configuration | cost at equal noise | at | CPU s per sample | bias | 95 % interval | mean level | z | FLIP | "
      "at |\n"
      "|--|--|--|--|--|--|--|--|--|--|\n";
  for (const ConfigurationSummary& summary : summaries) {
    const Row& row = *summary.best;
    text += "| " + row.configuration + " | " + format("%.2f", summary.cost_ratio) + " | " +
            (summary.compared_at > 0 ? std::to_string(summary.compared_at) : "-") + " | " +
            format("%.3g", row.cpu_seconds / double(row.samples)) + " | " + percent(root(row.squared_bias.value)) +
            " | " + percent(root(row.squared_bias.low)) + " to " + percent(root(row.squared_bias.high)) + " | " +
            (row.level_bias.value > 0 ? "+" : "") + percent(row.level_bias.value) + " | " +
            format("%.1f", z_of(row.level_bias)) + " | " + format("%.4f", row.flip) + " | " +
            std::to_string(row.samples) + " |\n";
  }
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
            percent(root(row->squared_bias.value)) + " | " + percent(row->total) + " | " +
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
            percent(root(row.squared_bias.value)) + " | " + percent(root(row.squared_bias.low)) + " to " +
            percent(root(row.squared_bias.high)) + " | " + (row.level_bias.value > 0 ? "+" : "") +
            percent(row.level_bias.value) + " | " + percent(row.total) + " | " + percent(rendered->total) + " | " +
            format("%.4f", row.flip) + " | " + (row.pareto ? "*" : "") + " |\n";
  }
  if (rows.empty()) return "";
  return "\n## Denoised\nNoise is what differs between replicas, and bias what their mean has too much or too little, "
         "at "
         "this number of samples: more samples reduce both. Neighbouring pixels share noise, so the intervals follow "
         "from the scatter over blocks of 32 x 32 pixels. The front is that of the denoised rows.\n\n"
         "| configuration | samples | CPU s | of it denoising | noise | bias | 95 % interval | mean level | error | "
         "error as rendered | FLIP | front |\n|--|--|--|--|--|--|--|--|--|--|--|--|\n" +
         rows;
}

/// Names the configuration with the largest certain bias and the one that costs most at equal noise.
std::string worst_text(const std::vector<ConfigurationSummary>& summaries) {
  const ConfigurationSummary *biased = nullptr, *dear = nullptr;
  for (const ConfigurationSummary& summary : summaries) {
    const Row& row = *summary.best;
    if (row.squared_bias.low > 0 && (!biased || row.squared_bias.value > biased->best->squared_bias.value))
      biased = &summary;
    if (summary.cost_ratio > 1 && (!dear || summary.cost_ratio > dear->cost_ratio)) dear = &summary;
  }
  std::string text = biased ? "Largest bias: **" + biased->best->configuration + "**, " +
                                  percent(root(biased->best->squared_bias.value)) + ".\n"
                            : "No configuration has a bias that the measurement can distinguish from zero.\n";
  if (dear)
    text += "Most expensive at equal noise: **" + dear->best->configuration + "**, " +
            format("%.2f", dear->cost_ratio) + " times the cost of the base.\n";
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

std::string left_out_text(const StudyResult& result, const ConfigurationList& list) {
  std::string lines;
  for (const std::string& line : list.skipped) lines += "- " + line + "\n";
  for (const Configuration& configuration : list.measured)
    if (std::none_of(result.rows.begin(), result.rows.end(),
                     [&](const Row& row) { return row.configuration == configuration.name; }))
      lines += "- " + configuration.name + ": no time for two replicas\n";
  return lines.empty() ? "" : "\n## Skipped\n" + lines;
}

Plot plot_of(const StudyResult& result, const ReportContext& context) {
  Plot plot;
  plot.title = as_utf8(std::filesystem::path(context.identity.scene).filename()) + ", " +
               size_text(context.identity.width, context.identity.height);
  plot.error_label = "relative RMSE (noise and bias)";
  for (const Row& row : result.rows) {
    if (row.denoised && row.configuration != result.rows.front().configuration + " " + kDenoised) continue;
    if (plot.lines.empty() || plot.lines.back().name != row.configuration)
      plot.lines.push_back({row.configuration, row.group, {}});
    const auto error = [&](double squared_bias) {
      return std::sqrt(std::max(0.0, squared_bias) + row.squared_noise.value);
    };
    plot.lines.back().points.push_back(
        {row.cpu_seconds, row.total, error(row.squared_bias.low), error(row.squared_bias.high)});
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
                      {"spentSeconds", number(context.spent_seconds)},
                      {"reference",
                       {{"settings", list.reference.fingerprint()},
                        {"samples", reference.samples},
                        {"replicas", reference.replicas},
                        {"cpuSeconds", number(reference.cpu_seconds)},
                        {"noise", number(reference.noise)},
                        {"displayRmseOfHalves", number(reference.display_rmse)},
                        {"flipOfHalves", number(reference.flip)}}},
                      {"configurations", ordered_json::array()},
                      {"skipped", list.skipped},
                      {"rows", ordered_json::array()}};
  for (const Configuration& configuration : list.measured)
    report["configurations"].push_back(
        {{"name", configuration.name}, {"group", configuration.group}, {"settings", configuration.fingerprint()}});
  for (const Row& row : result.rows) report["rows"].push_back(columns_of(row));
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
  text += as_code(context.command) + ", " + size_text(identity.width, identity.height);
  if (identity.width != context.scene_width || identity.height != context.scene_height)
    text += " (the scene asks for " + size_text(context.scene_width, context.scene_height) +
            "; mode `auto` depends on the size of pixels)";
  text += ", " + machine_name() + ", " + format("%.1f", context.spent_seconds / 60) + " minutes of rendering" +
          (context.complete ? "" : ", INTERRUPTED: results so far") + ".\n\n";
  text += reference_text(result.reference);
  text +=
      "\n## Each configuration\nEach differs from the base, `walk`, in one setting. Cost at equal noise: noise^2 x CPU "
      "seconds relative to the base, at the highest sample count that both have. Bias: the relative RMSE that remains "
      "with any number of samples; an interval that begins at 0 means that none was found. All configurations share "
      "their random numbers, so their rows are correlated; the reference has its own. No interval accounts for rare "
      "bright samples that have not occurred yet.\n\n" +
      summary_table(summaries) + "\n" + worst_text(summaries);
  text +=
      "\n## The front\nNo other configuration both costs less and errs less. Error: the root of bias^2 + noise^2. Own "
      "estimate: the noise that the renders report, relative to their own levels instead of the reference's.\n\n" +
      row_table(front) + "\n## All measurements\n" + row_table(all) + denoised_text(result);
  return text + left_out_text(result, list);
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
  return written;
}

}  // namespace alabaster::tradeoff
