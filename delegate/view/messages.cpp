#include "delegate/view/messages.h"

namespace alabaster::view {

constexpr size_t kMost = 200;

void Messages::add(const hd::Diagnostic& d) {
  const std::lock_guard lock(mutex_);
  if (d.severity != hd::Severity::info) ++alarms_;
  if (!entries_.empty()) {
    Entry& last = entries_.back();
    if (last.diagnostic.code == d.code && last.diagnostic.where == d.where && last.diagnostic.text == d.text) {
      ++last.count;
      return;
    }
  }
  entries_.push_back({d, 1});
  if (entries_.size() > kMost) entries_.erase(entries_.begin());
}

std::vector<Messages::Entry> Messages::all() const {
  const std::lock_guard lock(mutex_);
  return entries_;
}

uint64_t Messages::alarms() const {
  const std::lock_guard lock(mutex_);
  return alarms_;
}

void Messages::clear() {
  const std::lock_guard lock(mutex_);
  entries_.clear();
}

}  // namespace alabaster::view
