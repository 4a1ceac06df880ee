// A study's numbers as files: CSV and JSON for programs, Markdown and a plot for people.
#pragma once

#include <filesystem>

#include "delegate/tradeoff/analysis.h"

namespace alabaster::tradeoff {

/// What the numbers were measured with.
struct ReportContext {
  std::string command;  // that makes the report again
  StudyIdentity identity;
  int scene_width = 0, scene_height = 0;  // what the scene itself asks
  double spent_seconds = 0;
  bool complete = true;  // false: interrupted
};

/// The texts of tradeoff.csv, .json and .md. CSV and JSON hold the same values to the same digits.
std::string csv_text(const StudyResult& result);
std::string json_text(const StudyResult& result, const ConfigurationList& list, const ReportContext& context);
std::string markdown_text(const StudyResult& result, const ConfigurationList& list, const ReportContext& context);

/// Writes tradeoff.csv, .json, .md, .svg and .png into `folder`, each under a temporary name and renamed. The files
/// written; what could not be written is in `problems`.
std::vector<std::string> write_report(const StudyResult& result, const ConfigurationList& list,
                                      const ReportContext& context, const std::filesystem::path& folder,
                                      std::vector<std::string>* problems);

/// "Intel(R) Xeon(R) ..., 2 cores", as the system tells.
std::string machine_name();

}  // namespace alabaster::tradeoff
