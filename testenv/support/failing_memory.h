// Memory that runs out at a chosen moment, and what is asked of it: linking failing_memory.cpp replaces the program's
// operator new.
#pragma once

#include <cstddef>

namespace alabaster::testing {

/// While it lives, operator new grants this thread `allowed` allocations and throws std::bad_alloc for the next
/// `refusals`, or for all further ones. Other threads, and what is allocated aligned or by malloc, go untouched.
class FailingMemory {
 public:
  explicit FailingMemory(size_t allowed, size_t refusals = ~size_t(0));
  ~FailingMemory();
  FailingMemory(const FailingMemory&) = delete;
  FailingMemory& operator=(const FailingMemory&) = delete;
  /// True once an allocation was refused.
  bool failed() const;
};

/// The same for all other threads together.
class FailingMemoryElsewhere {
 public:
  explicit FailingMemoryElsewhere(int refusals, size_t allowed = 0);
  ~FailingMemoryElsewhere();
  FailingMemoryElsewhere(const FailingMemoryElsewhere&) = delete;
  FailingMemoryElsewhere& operator=(const FailingMemoryElsewhere&) = delete;
  /// True once an allocation was refused.
  bool failed() const;

 private:
  int refusals_;
};

/// The largest block that any thread asks of operator new, from its construction on. One at a time.
class LargestAllocation {
 public:
  LargestAllocation();
  size_t bytes() const;
};

/// While it lives, counts the memory that operator new has given out since and that is not deleted. One at a time.
class PeakMemory {
 public:
  PeakMemory();
  ~PeakMemory();
  PeakMemory(const PeakMemory&) = delete;
  PeakMemory& operator=(const PeakMemory&) = delete;
  /// The most so far.
  size_t bytes() const;
};

}  // namespace alabaster::testing
