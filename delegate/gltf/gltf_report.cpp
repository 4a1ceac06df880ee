#include "delegate/gltf/gltf_report.h"

namespace alabaster::hd::gltf {
namespace {
constexpr size_t kMostMessages = 100;
}

void Report::send(Severity severity, const std::string& code, const std::string& element, const std::string& text) {
  const size_t count = ++counts_[int(severity)];
  if (!sink_ || count > kMostMessages + 1) return;
  if (count == kMostMessages + 1) {
    sink_({severity, "gltf.more", file_, "further messages of this severity are left out"});
    return;
  }
  sink_({severity, "gltf." + code, element.empty() ? file_ : file_ + ": " + element, text});
}

}  // namespace alabaster::hd::gltf
