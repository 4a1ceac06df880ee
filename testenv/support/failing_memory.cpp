#include "testenv/support/failing_memory.h"

#include <dlfcn.h>
#include <malloc.h>

#include <atomic>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <new>

namespace {

constexpr size_t kUnlimited = ~size_t(0);
thread_local size_t allowed_allocations = kUnlimited, refusals_left = 0;
thread_local bool refused = false;
std::atomic<int> refusals_elsewhere{0};
std::atomic<int64_t> granted_elsewhere{0};
thread_local bool is_elsewhere = true;
std::atomic<size_t> largest{0};
std::atomic<bool> counts_live{false};
std::atomic<int64_t> live{0}, most_live{0};

// Relaxed, so that allocations order nothing for the thread sanitizer.
void note(size_t size) {
  constexpr auto kRelaxed = std::memory_order_relaxed;
  for (size_t seen = largest.load(kRelaxed); size > seen && !largest.compare_exchange_weak(seen, size, kRelaxed);) {
  }
}

void count_live(void* memory, int64_t sign) {
  constexpr auto kRelaxed = std::memory_order_relaxed;
  if (!counts_live.load(kRelaxed)) return;
  const int64_t bytes = sign * static_cast<int64_t>(malloc_usable_size(memory));
  const int64_t now = live.fetch_add(bytes, kRelaxed) + bytes;
  for (int64_t seen = most_live.load(kRelaxed); now > seen && !most_live.compare_exchange_weak(seen, now, kRelaxed);) {
  }
}

/// Embree and TBB do not survive a refusal of their own small allocations. Where Embree cannot note a thread's
/// allocator (FastAllocator::threadLocal2), it frees it and the thread keeps it.
bool is_refusable(void* caller) {
  Dl_info info;
  return !dladdr(caller, &info) || !info.dli_fname ||
         (!std::strstr(info.dli_fname, "libembree") && !std::strstr(info.dli_fname, "libtbb"));
}

bool refuses() {
  if (is_elsewhere && refusals_elsewhere > 0 && granted_elsewhere-- <= 0 && refusals_elsewhere-- > 0) return true;
  if (allowed_allocations == kUnlimited) return false;
  if (allowed_allocations > 0) {
    --allowed_allocations;
    return false;
  }
  if (refusals_left == 0) return false;
  if (refusals_left != kUnlimited) --refusals_left;
  return refused = true;
}

void* give_out(size_t size, void* caller) {
  note(size);
  const bool is_failing = refusals_elsewhere > 0 || allowed_allocations != kUnlimited;
  void* const memory = is_failing && is_refusable(caller) && refuses() ? nullptr : std::malloc(size ? size : 1);
  if (!memory) throw std::bad_alloc();
  count_live(memory, 1);
  return memory;
}

void give_back(void* memory) {
  count_live(memory, -1);
  std::free(memory);
}

}  // namespace

namespace alabaster::testing {

FailingMemory::FailingMemory(size_t allowed, size_t refusals) {
  refusals_left = refusals;
  allowed_allocations = allowed;
  refused = false;
}
FailingMemory::~FailingMemory() {
  allowed_allocations = kUnlimited;
}
bool FailingMemory::failed() const {
  return refused;
}

FailingMemoryElsewhere::FailingMemoryElsewhere(int refusals, size_t allowed) : refusals_(refusals) {
  is_elsewhere = false;
  granted_elsewhere = static_cast<int64_t>(allowed);
  refusals_elsewhere = refusals;
}
FailingMemoryElsewhere::~FailingMemoryElsewhere() {
  refusals_elsewhere = 0;
  is_elsewhere = true;
}
bool FailingMemoryElsewhere::failed() const {
  return refusals_elsewhere < refusals_;
}

LargestAllocation::LargestAllocation() {
  largest = 0;
}
size_t LargestAllocation::bytes() const {
  return largest;
}

PeakMemory::PeakMemory() {
  live = most_live = 0;
  counts_live = true;
}
PeakMemory::~PeakMemory() {
  counts_live = false;
}
size_t PeakMemory::bytes() const {
  return static_cast<size_t>(most_live);
}

}  // namespace alabaster::testing

void* operator new(size_t size) {
  return give_out(size, __builtin_return_address(0));
}
// Under the address sanitizer, the forms that are not replaced are the sanitizer's, and their memory is not
// std::free's.
void* operator new(size_t size, const std::nothrow_t&) noexcept {
  try {
    return give_out(size, __builtin_return_address(0));
  } catch (const std::bad_alloc&) {
    return nullptr;
  }
}
void* operator new[](size_t size) {
  return give_out(size, __builtin_return_address(0));
}
void* operator new[](size_t size, const std::nothrow_t& tag) noexcept {
  return operator new(size, tag);
}
void operator delete(void* memory) noexcept {
  give_back(memory);
}
void operator delete[](void* memory) noexcept {
  give_back(memory);
}
void operator delete[](void* memory, size_t) noexcept {
  give_back(memory);
}
void operator delete(void* memory, size_t) noexcept {
  give_back(memory);
}
