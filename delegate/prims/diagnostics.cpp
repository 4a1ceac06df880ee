#include "delegate/prims/diagnostics.h"

#include <algorithm>

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

void report_exception(const alabaster::DiagnosticSink& sink, std::string_view where, const char* what,
                      const char* outcome) noexcept {
  try {
    alabaster::report(sink, alabaster::Severity::error, "delegate.exception", std::string(where),
                      std::string("failed: ") + what + outcome);
  } catch (...) {
    // Memory has run out altogether.
  }
}

void KnownFaults::report(const alabaster::DiagnosticSink& sink, std::vector<alabaster::Diagnostic> found) {
  const auto is_in = [](const auto& first, const auto& last, const alabaster::Diagnostic& d) {
    return std::any_of(first, last, [&](const alabaster::Diagnostic& other) {
      return other.code == d.code && other.where == d.where && (other.text == d.text || d.code.ends_with(".memory"));
    });
  };
  for (auto it = found.begin(); it != found.end(); ++it)
    if (sink && !is_in(known_.begin(), known_.end(), *it) && !is_in(found.begin(), it, *it)) sink(*it);
  known_ = std::move(found);
}

void FileFaults::add(const Path& prim, const alabaster::Diagnostic& fault) {
  const std::lock_guard lock(mutex_);
  prims_[{fault.where, fault.code, fault.text, fault.severity}].insert(prim);
}

void FileFaults::report(const alabaster::DiagnosticSink& sink) {
  constexpr size_t kMostNames = 5;
  std::map<Fault, std::set<Path>> found;
  {
    const std::lock_guard lock(mutex_);
    found.swap(prims_);
  }
  for (const auto& [fault, prims] : found) {
    const auto& [where, code, text, severity] = fault;
    std::string names;
    size_t count = 0;
    for (const Path& prim : prims)
      if (++count <= kMostNames) names += (names.empty() ? "" : ", ") + prim.str();
    if (count > kMostNames) names += " and " + std::to_string(count - kMostNames) + " others";
    alabaster::report(sink, severity, code.c_str(), where, text + "; named by " + names);
  }
}

}  // namespace alabaster::hd::prims
