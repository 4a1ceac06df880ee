// Reports of the renderer while a window is open, for its panel.
#pragma once

#include <mutex>
#include <vector>

#include "delegate/api/types.h"

namespace alabaster::view {

/// Any thread. Keeps the last two hundred; one that repeats the last is counted.
class Messages {
 public:
  struct Entry {
    hd::Diagnostic diagnostic;
    int count = 1;
  };
  void add(const hd::Diagnostic& diagnostic);
  std::vector<Entry> all() const;
  /// Rises with every message that is a warning or an error.
  uint64_t alarms() const;
  void clear();

 private:
  mutable std::mutex mutex_;
  std::vector<Entry> entries_;
  uint64_t alarms_ = 0;
};

}  // namespace alabaster::view
