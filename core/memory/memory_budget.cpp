#include "core/memory/memory_budget.h"

namespace alabaster {
namespace {

struct UseText {
  const char *name, *remedy;
};
constexpr UseText kUses[] = {
    {"scene data", "split the file"},
    {"meshes", "lower refineLevel, or raise refineEdgeLength"},
    {"tracing", "lower refineLevel, or raise refineEdgeLength"},
    {"subsurface", "lower refineLevel of the meshes that scatter"},
    {"lights", "make their images smaller, or lower refineLevel of meshes that emit"},
    {"textures", "make the image smaller"},
    {"frames", "choose a smaller size or fewer AOVs, or render it in parts with a data window (crop)"},
};

// Sizes in MiB. Those that are needed or in use are rounded up and a limit down, so that the numbers of a refusal
// exceed the limit as their sizes do.
struct SizeText {
  int digits = 0;  // after the decimal point; kBytes: bytes
  static constexpr int kBytes = 3;

  // In units of the last digit.
  size_t units(size_t bytes, bool rounds_up) const {
    if (digits == kBytes) return bytes;
    constexpr size_t kRest = (size_t(1) << 20) - 1;
    const size_t part = (bytes & kRest) * scale();
    return (bytes >> 20) * scale() + (part >> 20) + (rounds_up && (part & kRest) != 0);
  }
  std::string up(size_t bytes) const { return text(units(bytes, true)); }
  std::string down(size_t bytes) const { return text(units(bytes, false)); }

 private:
  size_t scale() const { return digits == 2 ? 100 : digits == 1 ? 10 : 1; }
  std::string text(size_t units) const {
    if (digits == kBytes) return std::to_string(units) + " bytes";
    const std::string rest = std::to_string(units % scale());
    return std::to_string(units / scale()) +
           (digits == 0 ? "" : "." + std::string(static_cast<size_t>(digits) - rest.size(), '0') + rest) + " MiB";
  }
};

// The fewest digits with which a size below the limit also reads as smaller.
SizeText size_text(size_t in_use, size_t limit) {
  SizeText text;
  while (in_use < limit && text.digits < SizeText::kBytes && text.units(in_use, true) >= text.units(limit, false))
    ++text.digits;
  return text;
}

}  // namespace

MemoryRefused refusal_of(const std::bad_alloc& e, const std::string& prim) {
  const auto* const refused = dynamic_cast<const MemoryRefused*>(&e);
  if (!refused)
    return MemoryRefused("not enough memory (lower refineLevel, make images smaller, or free memory of other programs)",
                         0, prim);
  return refused->prim().empty() ? MemoryRefused(refused->what(), refused->bytes(), prim) : *refused;
}

size_t MemoryBudget::left() const {
  const size_t limit = limit_, total = total_;
  return limit > total ? limit - total : 0;
}

bool MemoryBudget::take(MemoryUse use, size_t bytes) {
  size_t total = total_;
  do {
    const size_t limit = limit_;
    if (total > limit || bytes > limit - total) return false;
  } while (!total_.compare_exchange_weak(total, total + bytes));
  used_[static_cast<size_t>(use)] += bytes;
  return true;
}

void MemoryBudget::add(MemoryUse use, size_t bytes) {
  total_ += bytes;
  used_[static_cast<size_t>(use)] += bytes;
}

void MemoryBudget::give_back(MemoryUse use, size_t bytes) {
  used_[static_cast<size_t>(use)] -= bytes;
  total_ -= bytes;
}

std::string MemoryBudget::refusal(MemoryUse use, size_t bytes, const std::string& what) const {
  const size_t limit = limit_, total = total_;
  const SizeText text = size_text(total, limit);
  std::string holders;
  for (size_t i = 0; i < used_.size(); ++i)
    if (const size_t held = used_[i]; held > 0)
      holders += (holders.empty() ? " by " : ", ") + std::string(kUses[i].name) + " " + text.up(held);
  return what + " needs " + text.up(bytes) + " more, but of the memory limit of " + text.down(limit) + " " +
         text.up(total) + " are in use" + holders + ": raise memoryLimit, or " + kUses[static_cast<size_t>(use)].remedy;
}

void MemoryReservation::resize(size_t bytes, const std::string& what) {
  if (!try_resize(bytes)) throw MemoryRefused(budget_->refusal(use_, bytes - bytes_, what), bytes - bytes_);
}

bool MemoryReservation::try_resize(size_t bytes) {
  if (bytes > bytes_ && budget_ && !budget_->take(use_, bytes - bytes_)) return false;
  if (bytes < bytes_) shrink(bytes);
  bytes_ = bytes;
  return true;
}

void MemoryReservation::shrink(size_t bytes) noexcept {
  if (bytes >= bytes_) return;
  if (budget_) budget_->give_back(use_, bytes_ - bytes);
  bytes_ = bytes;
}

std::shared_ptr<const MemoryReservation> BufferReservations::hold(const void* data, size_t bytes,
                                                                  const std::string& what) {
  const std::lock_guard lock(mutex_);
  if (known_.size() >= next_cleaning_) {
    std::erase_if(known_, [](const auto& entry) { return entry.second.expired(); });
    next_cleaning_ = 2 * known_.size() + 64;
  }
  std::weak_ptr<const MemoryReservation>& known = known_[{data, bytes}];
  if (auto held = known.lock()) return held;
  auto held = std::make_shared<const MemoryReservation>(budget_, use_, bytes, what);
  known = held;
  return held;
}

}  // namespace alabaster
