#include "delegate/sync/diagnostics.h"

#include <algorithm>
#include <numeric>

namespace alabaster::hd::sync {
namespace {

// Levenshtein distance.
size_t edit_distance(const std::string& a, const std::string& b) {
  std::vector<size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), size_t(0));
  for (size_t i = 1; i <= a.size(); ++i) {
    size_t diagonal = row[0];
    row[0] = i;
    for (size_t j = 1; j <= b.size(); ++j) {
      const size_t substituted = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
      diagonal = row[j];
      row[j] = std::min({row[j] + 1, row[j - 1] + 1, substituted});
    }
  }
  return row.back();
}

}  // namespace

alabaster::DiagnosticSink core_sink(const hd::DiagnosticSink& host) {
  if (!host) return {};
  return [host](const alabaster::Diagnostic& d) {
    try {
      host({static_cast<hd::Severity>(d.severity), d.code, d.where, d.text});
    } catch (...) {
      // A sink that fails has nobody left to be told.
    }
  };
}

void report_exception(const alabaster::DiagnosticSink& sink, std::string_view where, const char* what) noexcept {
  try {
    alabaster::report(sink, alabaster::Severity::error, "delegate.exception", std::string(where),
                      std::string("failed: ") + what + "; what was there before is kept");
  } catch (...) {
    // Memory has run out altogether.
  }
}

std::string nearest_name(const std::string& name, const std::vector<std::string>& known) {
  std::string nearest;
  size_t fewest = name.size() / 2 + 1;
  for (const std::string& candidate : known) {
    const size_t edits = edit_distance(name, candidate);
    if (edits >= fewest) continue;
    fewest = edits;
    nearest = candidate;
  }
  return nearest;
}

}  // namespace alabaster::hd::sync
