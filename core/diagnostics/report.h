// Reports of what goes wrong, to a sink that the host installs. The library never prints and never exits.
#pragma once

#include <functional>
#include <string>
#include <utility>

namespace alabaster {

enum class Severity { info, warning, error };

struct Diagnostic {
  Severity severity = Severity::info;
  std::string code;   // stable short name: "mesh.points.short"
  std::string where;  // file, prim path or element that a user can look for
  std::string text;   // what is wrong and what to do about it
};

/// Called from any thread, never under a lock of ours. An empty sink discards.
using DiagnosticSink = std::function<void(const Diagnostic&)>;

inline void report(const DiagnosticSink& sink, Severity severity, std::string code, std::string where,
                   std::string text) {
  if (sink) sink({severity, std::move(code), std::move(where), std::move(text)});
}

}  // namespace alabaster
