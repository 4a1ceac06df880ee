#include "delegate/gltf/gltf_report.h"

namespace alabaster::hd::gltf {
namespace {
constexpr size_t kMostMessages = 100;
}

void Report::send(Severity severity, const std::string& code, const std::string& element, const std::string& text) {
  const size_t count = ++counts_[int(severity)];
  if (!sink_ || count > kMostMessages) return;
  sink_({severity, "gltf." + code, element.empty() ? file_ : file_ + ": " + element, text});
}

void Report::finish() {
  for (const Severity severity : {Severity::info, Severity::warning, Severity::error})
    if (const size_t count = counts_[int(severity)]; sink_ && count > kMostMessages)
      sink_({severity, "gltf.more", file_,
             "there are " + std::to_string(count - kMostMessages) + " more messages of this kind"});
}

}  // namespace alabaster::hd::gltf
