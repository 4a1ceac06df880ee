#include "core/texture/texel_store.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <string>

#include "core/files/temporary_folder.h"

namespace alabaster {
namespace {

constexpr size_t kLeastTiles = 16;

// A file whose name is gone at once.
int open_unnamed() {
  std::string name = temporary_folder() + "/.alabaster-XXXXXX";
  const int file = mkostemp(name.data(), O_CLOEXEC);
  if (file >= 0) unlink(name.c_str());
  return file;
}

}  // namespace

TexelStore::~TexelStore() {
  if (file_ >= 0) close(file_);
}

bool TexelStore::reserve(size_t bytes) {
  const size_t limit = budget_ / 2;
  size_t lent = lent_;
  do
    if (bytes > limit || lent > limit - bytes) return false;
  while (!lent_.compare_exchange_weak(lent, lent + bytes));
  if (!memory_ || memory_->take(MemoryUse::textures, bytes)) return true;
  lent_ -= bytes;
  return false;
}

// Before the first tile is written, so that a thread that has a tile to read sees the cache.
bool TexelStore::open_file() {
  if (file_ < 0 && (file_ = open_unnamed()) < 0) return false;
  if (slots_) return true;
  size_t bytes = budget_ / 2;
  if (memory_) bytes = std::min(bytes, memory_->left() / 4);
  size_ = static_cast<uint32_t>(std::clamp(bytes / kTileBytes, kLeastTiles, size_t(UINT32_MAX)));
  cache_memory_ = MemoryReservation(memory_, MemoryUse::textures, size_ * (kTileBytes + sizeof(Slot)),
                                    "the cache of texels, of " + std::to_string(size_) + " tiles,");
  // Pages that hold no tile yet take no memory.
  cache_ = std::make_unique_for_overwrite<std::byte[]>(size_ * kTileBytes);
  slots_ = std::make_unique<Slot[]>(size_);
  return true;
}

bool TexelStore::write(uint64_t first, std::span<const std::byte> tiles) {
  {
    const std::scoped_lock lock(mutex_);
    if (!open_file()) return false;
  }
  for (size_t done = 0; done < tiles.size();) {
    const ssize_t n = pwrite(file_, tiles.data() + done, tiles.size() - done, off_t(first * kTileBytes + done));
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return false;
    done += static_cast<size_t>(n);
  }
  return true;
}

// Numbers of tiles are not used again, so that no slot holds an older tile of the same number.
void TexelStore::discard(uint64_t first, uint64_t count) {
  if (file_ < 0) return;
  const int reason = errno;  // of a write that failed, which its caller reports
  static_cast<void>(fallocate(file_, FALLOC_FL_PUNCH_HOLE | FALLOC_FL_KEEP_SIZE, off_t(first * kTileBytes),
                              off_t(count * kTileBytes)));
  errno = reason;
}

void TexelStore::read_file(uint64_t tile, std::byte* buffer) {
  for (size_t done = 0; done < kTileBytes;) {
    const ssize_t n = pread(file_, buffer + done, kTileBytes - done, off_t(tile * kTileBytes + done));
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) {
      std::memset(buffer, 0, kTileBytes);
      if (!failed_.exchange(true))
        report(sink_, Severity::error, "texture.memory", "the temporary file of textures",
               std::string("cannot be read: ") + (n < 0 ? std::strerror(errno) : "it has been cut short") +
                   "; parts of textures are black. Free its disk, or raise textureMemory");
      return;
    }
    done += static_cast<size_t>(n);
  }
}

void TexelStore::fetch(uint64_t tile, std::atomic<uint32_t>* slot, std::byte* buffer) {
  read_file(tile, buffer);
  ++fetched_;
  const std::scoped_lock lock(mutex_);
  const uint32_t place = slot->load(std::memory_order_relaxed);
  if (place != 0 && slots_[place - 1].tile.load(std::memory_order_relaxed) == tile)
    return;  // another thread was faster
  const uint32_t found = victim();
  fill(found, tile, buffer);
  slot->store(found + 1, std::memory_order_release);
}

// Second chance: the first slot from the clock's hand on that was not used since the hand passed it.
uint32_t TexelStore::victim() {
  while (slots_[hand_].used.exchange(false, std::memory_order_relaxed)) hand_ = (hand_ + 1) % size_;
  const uint32_t found = hand_;
  hand_ = (hand_ + 1) % size_;
  return found;
}

void TexelStore::fill(uint32_t place, uint64_t tile, const std::byte* buffer) {
  Slot& slot = slots_[place];
  const uint64_t version = slot.version.load(std::memory_order_relaxed);
  slot.version.store(version + 1, std::memory_order_relaxed);
  auto* const to = reinterpret_cast<uint64_t*>(&cache_[place * kTileBytes]);
  for (size_t i = 0; i < kTileBytes / sizeof(uint64_t); ++i) {
    uint64_t word;
    std::memcpy(&word, buffer + i * sizeof(word), sizeof(word));
    __atomic_store_n(to + i, word, __ATOMIC_RELEASE);
  }
  slot.tile.store(tile, std::memory_order_release);
  slot.version.store(version + 2, std::memory_order_release);
}

}  // namespace alabaster
