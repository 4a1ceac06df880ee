// The faults that a glTF reader finds in one file, in the order found.
#pragma once

#include <string>

#include "delegate/api/types.h"

namespace alabaster::hd::gltf {

/// Puts the file before every element. After a hundred messages of a severity it only counts further ones, and finish()
/// tells how many. One thread.
class Report {
 public:
  Report(std::string file, DiagnosticSink sink) : file_(std::move(file)), sink_(std::move(sink)) {}

  /// `element` is a place in the document ("accessors[3].count"), empty for the file itself; `text` names the fault and
  /// the remedy.
  void error(const std::string& code, const std::string& element, const std::string& text) {
    send(Severity::error, code, element, text);
  }
  void warning(const std::string& code, const std::string& element, const std::string& text) {
    send(Severity::warning, code, element, text);
  }
  void info(const std::string& code, const std::string& element, const std::string& text) {
    send(Severity::info, code, element, text);
  }
  void send(Severity severity, const std::string& code, const std::string& element, const std::string& text);
  void finish();
  bool failed() const { return counts_[int(Severity::error)] > 0; }

 private:
  std::string file_;
  DiagnosticSink sink_;
  size_t counts_[3] = {0, 0, 0};
};

/// "parent.name", or "name" below the document's root.
inline std::string element_name(const std::string& parent, const std::string& name) {
  return parent.empty() ? name : parent + "." + name;
}
inline std::string element_name(const std::string& array, size_t index) {
  return array + "[" + std::to_string(index) + "]";
}

}  // namespace alabaster::hd::gltf
