// Reporting at the contract's edge: the host's sink as core's, and the net that no exception slips through.
#pragma once

#include <exception>
#include <string>
#include <vector>

#include "core/diagnostics/report.h"
#include "delegate/api/types.h"

namespace alabaster::hd::sync {

/// Core's sink over the host's; what the host's throws is swallowed. Empty for an empty sink.
alabaster::DiagnosticSink core_sink(const hd::DiagnosticSink& host);

/// Runs a boundary entry point. An exception becomes a report and false.
template <class F>
bool guarded(const alabaster::DiagnosticSink& sink, const std::string& where, F&& body) {
  try {
    body();
    return true;
  } catch (const std::exception& e) {
    alabaster::report(sink, alabaster::Severity::error, "delegate.exception", where,
                      std::string("failed: ") + e.what() + "; what was there before is kept");
  } catch (...) {
    alabaster::report(sink, alabaster::Severity::error, "delegate.exception", where, "failed for an unknown reason");
  }
  return false;
}

}  // namespace alabaster::hd::sync
