// Writes a study's numbers: CSV and JSON for programs, Markdown and a plot for people.
#pragma once

#include <filesystem>

#include "delegate/tradeoff/analysis.h"

namespace alabaster::tradeoff {

/// The circumstances of the measurement.
struct ReportContext {
  std::string command;         // that repeats the report
  std::string render_command;  // "alabaster render SCENE -o frame.exr", with what the study was given beside the scene
  StudyIdentity identity;
  int scene_width = 0, scene_height = 0;  // the scene's own
  double spent_seconds = 0;
  bool complete = true;  // false: interrupted
};

/// The texts of tradeoff.csv, .json and .md. CSV and JSON hold the same values to the same digits.
std::string csv_text(const StudyResult& result);
std::string json_text(const StudyResult& result, const ConfigurationList& list, const ReportContext& context);
std::string markdown_text(const StudyResult& result, const ConfigurationList& list, const ReportContext& context);

/// Writes tradeoff.csv, .json, .md, .svg and .png, and the pictures of tiles as pictures.png, into `folder`, each under
/// a temporary name and renamed. Returns the files written; `problems` names those that could not be written.
std::vector<std::string> write_report(const StudyResult& result, const ConfigurationList& list,
                                      const ReportContext& context, const std::filesystem::path& folder,
                                      std::vector<std::string>* problems);

/// The machine as the system describes it: "Intel(R) Xeon(R) ..., 2 cores".
std::string machine_name();

}  // namespace alabaster::tradeoff
