// Reporting at the contract's edge: the host's sink as core's, and the net that no exception slips through.
#pragma once

#include <exception>
#include <string>
#include <string_view>
#include <vector>

#include "core/diagnostics/report.h"
#include "delegate/api/types.h"

namespace alabaster::hd::sync {

/// Core's sink over the host's; what the host's throws is swallowed. Empty for an empty sink.
alabaster::DiagnosticSink core_sink(const hd::DiagnosticSink& host);

/// Reports what an entry point caught; gives up quietly where not even a report can be made.
void report_exception(const alabaster::DiagnosticSink& sink, std::string_view where, const char* what) noexcept;

/// Runs a boundary entry point. An exception becomes a report and false.
template <class F>
bool guarded(const alabaster::DiagnosticSink& sink, std::string_view where, F&& body) noexcept {
  try {
    body();
    return true;
  } catch (const std::exception& e) {
    report_exception(sink, where, e.what());
  } catch (...) {
    report_exception(sink, where, "unknown reason");
  }
  return false;
}

}  // namespace alabaster::hd::sync
