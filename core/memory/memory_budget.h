// One limit for the memory of one renderer, and how much of it each use holds. Two renderers in a process have two.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <map>
#include <memory>
#include <mutex>
#include <new>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace alabaster {

/// Named in errors, each with its own remedy.
enum class MemoryUse { scene, meshes, tracing, subsurface, lights, textures, frames };

/// Thrown before memory is taken that would exceed the limit. what(): who asked for how much, how much is in use and by
/// what, and the remedy.
class MemoryRefused : public std::bad_alloc {
 public:
  /// `bytes` that were asked for; 0: not known. `prim`: the path of the prim or image for which; empty: the scene.
  explicit MemoryRefused(std::string text, size_t bytes = 0, std::string prim = {})
      : held_(std::make_shared<const Held>(Held{std::move(text), bytes, std::move(prim)})) {}
  const char* what() const noexcept override { return held_->text.c_str(); }
  size_t bytes() const { return held_->bytes; }
  const std::string& prim() const { return held_->prim; }

 private:
  struct Held {
    std::string text;
    size_t bytes;
    std::string prim;
  };
  std::shared_ptr<const Held> held_;  // copies must not throw
};

/// The same exception, or one that names a remedy.
MemoryRefused refusal_of(const std::bad_alloc& e, const std::string& prim = {});

/// Runs a step that is made for a prim: MemoryRefused names it, also where it is thrown for std::bad_alloc.
template <class Step>
void in_name_of(const std::string& prim, const Step& step) {
  try {
    step();
  } catch (const std::bad_alloc& e) {
    throw refusal_of(e, prim);
  }
}

/// Of steps that several threads make: the others go on where memory is refused for one.
class Refusals {
 public:
  template <class Step>
  void run(const std::string& prim, const Step& step) {
    try {
      in_name_of(prim, step);
    } catch (const MemoryRefused& e) {
      const std::lock_guard lock(mutex_);
      if (!largest_ || e.bytes() > largest_->bytes()) largest_ = e;
    }
  }
  /// Throws the refusal of the most bytes.
  void check() const {
    if (largest_) throw MemoryRefused(*largest_);
  }

 private:
  std::mutex mutex_;
  std::optional<MemoryRefused> largest_;
};

/// Counts bytes; it allocates nothing itself. Any thread.
class MemoryBudget {
 public:
  static constexpr size_t kUnlimited = ~size_t(0);
  explicit MemoryBudget(size_t limit = kUnlimited) : limit_(limit) {}
  MemoryBudget(const MemoryBudget&) = delete;
  MemoryBudget& operator=(const MemoryBudget&) = delete;

  /// Bytes. Reservations that exist stay, even above it.
  void set_limit(size_t limit) { limit_ = limit; }
  size_t limit() const { return limit_; }
  size_t in_use() const { return total_; }
  size_t in_use(MemoryUse use) const { return used_[static_cast<size_t>(use)]; }
  /// Bytes up to the limit.
  size_t left() const;

  /// False, with nothing counted, if it would exceed the limit.
  bool take(MemoryUse use, size_t bytes);
  /// Counts what is held already.
  void add(MemoryUse use, size_t bytes);
  void give_back(MemoryUse use, size_t bytes);

  /// The text of a refusal. `what` asks: "mesh /head, refined to 8000 triangles,".
  std::string refusal(MemoryUse use, size_t bytes, const std::string& what) const;

 private:
  std::atomic<size_t> limit_, total_{0};
  std::array<std::atomic<size_t>, 7> used_{};
};

/// A part of a budget, held as long as it lives: it is kept with what it counts. Without a budget it counts nothing.
/// One thread at a time.
class MemoryReservation {
 public:
  MemoryReservation() = default;
  MemoryReservation(std::shared_ptr<MemoryBudget> budget, MemoryUse use) : budget_(std::move(budget)), use_(use) {}
  /// Throws MemoryRefused.
  MemoryReservation(std::shared_ptr<MemoryBudget> budget, MemoryUse use, size_t bytes, const std::string& what)
      : MemoryReservation(std::move(budget), use) {
    resize(bytes, what);
  }
  MemoryReservation(MemoryReservation&& other) noexcept { swap(other); }
  MemoryReservation& operator=(MemoryReservation&& other) noexcept {
    MemoryReservation(std::move(other)).swap(*this);
    return *this;
  }
  ~MemoryReservation() { shrink(0); }

  size_t bytes() const { return bytes_; }
  /// Throws MemoryRefused where it grows, and then holds what it did.
  void resize(size_t bytes, const std::string& what);
  /// False where resize() would throw.
  bool try_resize(size_t bytes);
  /// To `bytes`, unless it holds less already.
  void shrink(size_t bytes) noexcept;

 private:
  void swap(MemoryReservation& other) noexcept {
    std::swap(budget_, other.budget_);
    std::swap(use_, other.use_);
    std::swap(bytes_, other.bytes_);
  }
  std::shared_ptr<MemoryBudget> budget_;
  MemoryUse use_ = MemoryUse::scene;
  size_t bytes_ = 0;
};

/// Reservations of the buffers of a value, which its copies share. They take no part in comparisons of these values.
struct SharedReservations {
  std::vector<std::shared_ptr<const MemoryReservation>> held;
  bool operator==(const SharedReservations&) const { return true; }
};

/// Reservations of buffers that several values may share: a buffer is counted once. Any thread.
class BufferReservations {
 public:
  BufferReservations(std::shared_ptr<MemoryBudget> budget, MemoryUse use) : budget_(std::move(budget)), use_(use) {}
  /// The caller keeps it as long as it keeps the buffer. Throws MemoryRefused.
  std::shared_ptr<const MemoryReservation> hold(const void* data, size_t bytes, const std::string& what);

 private:
  using Buffer = std::pair<const void*, size_t>;
  const std::shared_ptr<MemoryBudget> budget_;
  const MemoryUse use_;
  std::mutex mutex_;
  std::map<Buffer, std::weak_ptr<const MemoryReservation>> known_;
  size_t next_cleaning_ = 64;  // size of known_ at which expired entries are removed
};

}  // namespace alabaster
