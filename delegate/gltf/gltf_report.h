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
  void send(Severity severity, const std::string& code, const std::string& element, const std::string& text) {
    const size_t count = ++counts_[int(severity)];
    if (!sink_ || count > kMostMessages) return;
    sink_({severity, "gltf." + code, element.empty() ? file_ : file_ + ": " + element, text});
  }
  void finish() {
    for (const Severity severity : {Severity::info, Severity::warning, Severity::error})
      if (const size_t count = counts_[int(severity)]; sink_ && count > kMostMessages)
        sink_({severity, "gltf.more", file_,
               "there are " + std::to_string(count - kMostMessages) + " more messages of this kind"});
  }
  bool failed() const { return counts_[int(Severity::error)] > 0; }
  size_t count() const { return counts_[0] + counts_[1] + counts_[2]; }

 private:
  static constexpr size_t kMostMessages = 100;
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
