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
    {"lights", "make their images smaller"},
    {"textures", "make the image smaller"},
    {"frames", "choose a smaller size or fewer AOVs, or render it in parts with a data window (crop)"},
};

// Rounded up.
std::string mebibytes(size_t bytes) {
  return std::to_string((bytes >> 20) + (bytes % (size_t(1) << 20) != 0)) + " MiB";
}

}  // namespace

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
  std::string holders;
  for (size_t i = 0; i < used_.size(); ++i)
    if (const size_t held = used_[i]; held > 0)
      holders += (holders.empty() ? " by " : ", ") + std::string(kUses[i].name) + " " + mebibytes(held);
  return what + " needs " + mebibytes(bytes) + " more, but of the memory limit of " + mebibytes(limit_) + " " +
         mebibytes(total_) + " are in use" + holders + ": raise memoryLimit, or " +
         kUses[static_cast<size_t>(use)].remedy;
}

void MemoryReservation::resize(size_t bytes, const std::string& what) {
  if (!try_resize(bytes)) throw MemoryRefused(budget_->refusal(use_, bytes - bytes_, what));
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

}  // namespace alabaster
