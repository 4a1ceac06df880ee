// Embree's device, its errors and its memory. Internal to this room.
#pragma once

#if __has_include(<embree4/rtcore.h>)  // CMakeLists.txt prefers it, too
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

#include <memory>
#include <mutex>
#include <string>
#include <utility>

#include "core/diagnostics/report.h"
#include "core/memory/memory_budget.h"

namespace alabaster {

class TraceDevice {
 public:
  TraceDevice(DiagnosticSink sink, std::shared_ptr<MemoryBudget> memory)
      : sink_(std::move(sink)), memory_(std::move(memory)), device_(rtcNewDevice(nullptr)) {
    if (device_) {
      rtcSetDeviceErrorFunction(device_, &TraceDevice::on_error, this);
      if (memory_) rtcSetDeviceMemoryMonitorFunction(device_, &TraceDevice::on_memory, this);
    } else {
      report(sink_, Severity::error, "trace.device", "Embree",
             "the ray tracing device could not be made (code " +
                 std::to_string(static_cast<int>(rtcGetDeviceError(nullptr))) +
                 "); this processor may lack SSE4.2, or memory ran out");
    }
  }
  ~TraceDevice() {
    if (device_) rtcReleaseDevice(device_);
  }
  TraceDevice(const TraceDevice&) = delete;
  TraceDevice& operator=(const TraceDevice&) = delete;

  RTCDevice get() const { return device_; }
  const std::shared_ptr<MemoryBudget>& memory() const { return memory_; }
  /// True if Embree refused anything that this thread asked of it since the last call, which the call forgets. The
  /// refusal itself has been reported. Embree keeps one error per thread; work that the thread takes up while it waits
  /// for a build asks for its own.
  bool take_error() const { return rtcGetDeviceError(device_) != RTC_ERROR_NONE; }

 private:
  // Called from within Embree, which no exception may cross.
  static void on_error(void* self, RTCError code, const char* text) noexcept {
    // A build that its caller stopped is not a fault.
    if (code == RTC_ERROR_CANCELLED) return;
    try {
      auto& device = *static_cast<TraceDevice*>(self);
      std::string reason = code == RTC_ERROR_OUT_OF_MEMORY ? device.take_refusal() : std::string();
      if (reason.empty())
        reason = std::string(text ? text : "unknown error") + " (code " + std::to_string(static_cast<int>(code)) + ")";
      report(device.sink_, Severity::error, code == RTC_ERROR_OUT_OF_MEMORY ? "trace.memory" : "trace.embree", "Embree",
             std::move(reason));
    } catch (...) {
      // Memory has run out altogether; the build still ends in null.
    }
  }

  // Asked before Embree takes memory, or, with `post`, told after it did; then it counts, and false only ends the
  // build.
  static bool on_memory(void* self, ssize_t bytes, bool post) noexcept {
    auto& device = *static_cast<TraceDevice*>(self);
    MemoryBudget& memory = *device.memory_;
    const auto size = static_cast<size_t>(bytes < 0 ? -bytes : bytes);
    if (bytes <= 0) return memory.give_back(MemoryUse::tracing, size), true;
    if (memory.take(MemoryUse::tracing, size)) return true;
    if (post) memory.add(MemoryUse::tracing, size);
    try {
      const std::scoped_lock lock(device.mutex_);
      if (device.refusal_.empty())
        device.refusal_ = memory.refusal(MemoryUse::tracing, size, "a hierarchy of triangles");
    } catch (...) {
      // The build ends with Embree's own text.
    }
    return false;
  }
  std::string take_refusal() {
    const std::scoped_lock lock(mutex_);
    return std::exchange(refusal_, {});
  }

  DiagnosticSink sink_;
  std::shared_ptr<MemoryBudget> memory_;  // null: not counted
  std::mutex mutex_;
  std::string refusal_;  // why the budget refused, not reported yet
  RTCDevice device_;
};

}  // namespace alabaster
