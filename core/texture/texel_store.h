// Memory for texels, within a budget.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <span>

#include "core/diagnostics/report.h"
#include "core/memory/memory_budget.h"

namespace alabaster {

/// Half of the budget is lent to images that stay in memory. Those that come when it is spent are written to an unnamed
/// file in the folder for temporary files ($TMPDIR), and the other half is a cache of their tiles: as long as all
/// images together fit the budget, each tile is read once at most. A lookup gives the same whatever the cache holds.
///
/// Any thread. Images keep the store alive.
class TexelStore {
 public:
  static constexpr size_t kTileBytes = 16384;

  /// `sink` hears, once, of tiles that could not be read back; they are black.
  /// `memory` (may be null) counts what the store lends and its cache: both take less where the limit leaves less.
  explicit TexelStore(DiagnosticSink sink = {}, std::shared_ptr<MemoryBudget> memory = nullptr)
      : sink_(std::move(sink)), memory_(std::move(memory)) {}
  ~TexelStore();
  TexelStore(const TexelStore&) = delete;
  TexelStore& operator=(const TexelStore&) = delete;

  /// Bytes, for images that come later. The cache keeps the size that it has when the first tiles come.
  void set_budget(size_t bytes) { budget_ = bytes; }

  /// True: `bytes` are lent, to be given back by release().
  bool reserve(size_t bytes);
  void release(size_t bytes) {
    lent_ -= bytes;
    if (memory_) memory_->give_back(MemoryUse::textures, bytes);
  }
  /// The memory that counts what is taken to read and convert images; may be null.
  const std::shared_ptr<MemoryBudget>& memory() const { return memory_; }

  /// Makes place in the file for tiles and returns the number of the first.
  uint64_t allocate(uint64_t count) { return tiles_.fetch_add(count); }
  /// Writes whole tiles, `first` and those that follow. False if that fails, with errno as the reason.
  bool write(uint64_t first, std::span<const std::byte> tiles);
  /// The tiles will not be read any more.
  void discard(uint64_t first, uint64_t count);

  /// Copies elements `first` to `first` + `count` - 1 of a tile. `slot`: where the store notes the tile's place, 0 to
  /// begin with, one per tile. Locks only where the tile is not in the cache.
  template <class Element>
  void read(uint64_t tile, std::atomic<uint32_t>* slot, size_t first, Element* out, int count) {
    const uint32_t place = slot->load(std::memory_order_acquire);
    if (place != 0 && copy(place - 1, tile, first, out, count)) return;
    alignas(8) std::byte buffer[kTileBytes];
    fetch(tile, slot, buffer);
    const auto* const elements = reinterpret_cast<const Element*>(buffer);
    for (int i = 0; i < count; ++i) out[i] = elements[first + static_cast<size_t>(i)];
  }

  /// Tiles read from the file so far.
  uint64_t fetched() const { return fetched_; }
  /// A tile could not be read back.
  bool failed() const { return failed_; }

 private:
  /// A slot may be filled with another tile while it is read. Its version, odd meanwhile, tells: a sequence lock (Boehm
  /// 2012, "Can Seqlocks Get Along With Programming Language Memory Models?").
  struct Slot {
    std::atomic<uint64_t> version{0};
    std::atomic<uint64_t> tile{UINT64_MAX};
    std::atomic<bool> used{false};  // since the clock's hand passed
  };

  template <class Element>
  bool copy(uint32_t place, uint64_t tile, size_t first, Element* out, int count) {
    Slot& slot = slots_[place];
    const uint64_t version = slot.version.load(std::memory_order_acquire);
    if (version % 2 != 0 || slot.tile.load(std::memory_order_acquire) != tile) return false;
    const auto* const from = reinterpret_cast<const Element*>(&cache_[place * kTileBytes]) + first;
    for (int i = 0; i < count; ++i) out[i] = __atomic_load_n(from + i, __ATOMIC_ACQUIRE);
    if (slot.version.load(std::memory_order_relaxed) != version) return false;
    if (!slot.used.load(std::memory_order_relaxed)) slot.used.store(true, std::memory_order_relaxed);
    return true;
  }
  void fetch(uint64_t tile, std::atomic<uint32_t>* slot, std::byte* buffer);
  void read_file(uint64_t tile, std::byte* buffer);
  void fill(uint32_t place, uint64_t tile, const std::byte* buffer);
  uint32_t victim();
  bool open_file();

  std::atomic<size_t> budget_{size_t(4096) << 20}, lent_{0};
  std::atomic<uint64_t> fetched_{0};
  std::atomic<uint64_t> tiles_{0};  // in the file
  std::atomic<bool> failed_{false};
  DiagnosticSink sink_;
  std::shared_ptr<MemoryBudget> memory_;
  std::mutex mutex_;  // guards all that follows; its owner changes the slots
  int file_ = -1;
  uint32_t size_ = 0, hand_ = 0;
  std::unique_ptr<Slot[]> slots_;
  std::unique_ptr<std::byte[]> cache_;
  MemoryReservation cache_memory_;
};

}  // namespace alabaster
