// Collects reports, for tests of what a function says when it fails.
#pragma once

#include <string>
#include <vector>

#include "core/diagnostics/report.h"

namespace alabaster::testing {

struct Reports {
  std::vector<Diagnostic> all;
  DiagnosticSink sink = [this](const Diagnostic& d) { all.push_back(d); };
  std::string text() const {
    std::string joined;
    for (const Diagnostic& d : all) joined += d.where + ": " + d.text + "\n";
    return joined;
  }
};

}  // namespace alabaster::testing
