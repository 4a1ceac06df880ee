// Reporting at the contract's edge: the host's sink as core's, and exceptions as reports.
#pragma once

#include <exception>
#include <map>
#include <mutex>
#include <new>
#include <set>
#include <string>
#include <string_view>
#include <tuple>
#include <vector>

#include "core/diagnostics/report.h"
#include "core/math/float_environment.h"
#include "core/memory/memory_budget.h"
#include "delegate/api/types.h"

namespace alabaster::hd::prims {

/// Core's sink over the host's. Exceptions of the host's sink are dropped. Empty for an empty sink.
alabaster::DiagnosticSink core_sink(const hd::DiagnosticSink& host);

/// `outcome` of an exception that changed nothing.
inline constexpr const char* kEarlierStateIsKept = "; the earlier state is kept";

/// Reports an exception that an entry point caught. `outcome` ends the sentence. Does nothing if memory does not even
/// suffice for a report.
void report_exception(const alabaster::DiagnosticSink& sink, std::string_view where, const char* what,
                      const char* outcome) noexcept;

/// The faults of something that is looked at again and again. Each is reported where it is found first, and again only
/// if it was gone in between. The numbers in a refusal of memory may differ. One thread at a time.
class KnownFaults {
 public:
  void report(const alabaster::DiagnosticSink& sink, std::vector<alabaster::Diagnostic> found);

 private:
  std::vector<alabaster::Diagnostic> known_;
};

/// Faults of files that several prims name: each is reported once, with the prims.
class FileFaults {
 public:
  /// Any thread.
  void add(const Path& prim, const alabaster::Diagnostic& fault);
  /// Reports all since the last call.
  void report(const alabaster::DiagnosticSink& sink);

 private:
  using Fault = std::tuple<std::string, std::string, std::string, alabaster::Severity>;  // file, code, text
  std::mutex mutex_;
  std::map<Fault, std::set<Path>> prims_;
};

/// Runs a boundary entry point, in the default floating-point environment. An exception becomes a report and false.
template <class F>
bool guarded(const alabaster::DiagnosticSink& sink, std::string_view where, F&& body,
             const char* outcome = "") noexcept {
  const FloatEnvironment environment;
  try {
    body();
    return true;
  } catch (const MemoryRefused& e) {
    report_exception(sink, where, e.what(), outcome);
  } catch (const std::bad_alloc&) {
    report_exception(sink, where, "not enough memory", outcome);
  } catch (const std::exception& e) {
    report_exception(sink, where, e.what(), outcome);
  } catch (...) {
    report_exception(sink, where, "unknown reason", outcome);
  }
  return false;
}

}  // namespace alabaster::hd::prims
