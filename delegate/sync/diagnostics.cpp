#include "delegate/sync/diagnostics.h"

namespace alabaster::hd::sync {

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

}  // namespace alabaster::hd::sync
