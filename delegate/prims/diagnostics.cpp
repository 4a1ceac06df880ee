#include "delegate/prims/diagnostics.h"

namespace alabaster::hd::prims {

alabaster::DiagnosticSink core_sink(const hd::DiagnosticSink& host) {
  if (!host) return {};
  return [host](const alabaster::Diagnostic& d) {
    try {
      host({static_cast<hd::Severity>(d.severity), d.code, d.where, d.text});
    } catch (...) {
      // Nobody is left to report it to.
    }
  };
}

void report_exception(const alabaster::DiagnosticSink& sink, std::string_view where, const char* what) noexcept {
  try {
    alabaster::report(sink, alabaster::Severity::error, "delegate.exception", std::string(where),
                      std::string("failed: ") + what + "; the earlier state is kept");
  } catch (...) {
    // Memory has run out altogether.
  }
}

}  // namespace alabaster::hd::prims
