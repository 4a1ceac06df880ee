// Embree's device, its errors and its memory. Internal to this room.
#pragma once

#if __has_include(<embree4/rtcore.h>)  // CMakeLists.txt prefers it, too
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

#include <atomic>
#include <cstring>
#include <memory>
#include <new>
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
  /// True if Embree refused anything that this thread asked of it since the last call, which the call forgets. That has
  /// been reported. Where memory ran out it throws MemoryRefused, by the budget, or std::bad_alloc. It reports nothing
  /// then; `what` names the part in the text. Embree keeps one error per thread; work that the thread takes up while it
  /// waits for a build asks for its own.
  bool take_error(const char* what) const {
    const RTCError error = rtcGetDeviceError(device_);
    if (error != RTC_ERROR_OUT_OF_MEMORY) return error != RTC_ERROR_NONE;
    if (!is_by_limit()) throw std::bad_alloc();
    throw MemoryRefused(memory_->refusal(MemoryUse::tracing, refused_bytes_, what), refused_bytes_);
  }
  void forget_error() const { rtcGetDeviceError(device_); }

 private:
  /// The memory that this thread's last build lacked was refused by the budget.
  static bool& is_by_limit() {
    static thread_local bool by_limit = false;
    return by_limit;
  }

  // Called from within Embree, which no exception may cross, on the thread that asked Embree for something.
  static void on_error(void* self, RTCError code, const char* text) noexcept {
    // A build that its caller stopped is not a fault.
    if (code == RTC_ERROR_CANCELLED) return;
    if (code == RTC_ERROR_OUT_OF_MEMORY) {
      is_by_limit() = text && std::strstr(text, "memory monitor");
      return;  // take_error() throws
    }
    try {
      auto& device = *static_cast<TraceDevice*>(self);
      report(device.sink_, Severity::error, "trace.embree", "Embree",
             std::string(text ? text : "unknown error") + " (code " + std::to_string(static_cast<int>(code)) + ")");
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
    device.refused_bytes_ = size;
    return false;
  }

  DiagnosticSink sink_;
  std::shared_ptr<MemoryBudget> memory_;  // null: not counted
  std::atomic<size_t> refused_bytes_{0};  // of the last refusal by the budget
  RTCDevice device_;
};

}  // namespace alabaster
