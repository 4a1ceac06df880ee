#include "core/film/id_counts.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <utility>

namespace alabaster {

void IdCounts::clear() {
  std::fill(first_.begin(), first_.end(), Entry());
  more_.clear();
}

void IdCounts::add(size_t pixel, int32_t id, uint32_t count) {
  Entry* entry = &first_[pixel];
  while (entry->count > 0 && entry->id != id && entry->next > 0) entry = &more_[entry->next - 1];
  if (entry->count > 0 && entry->id != id) {
    const auto next = static_cast<uint32_t>(more_.size() + 1);
    const size_t last = entry == &first_[pixel] ? 0 : static_cast<size_t>(entry - more_.data()) + 1;
    entry = &more_.emplace_back();  // moves the others
    (last == 0 ? first_[pixel] : more_[last - 1]).next = next;
  }
  entry->id = id;
  entry->count += count;
}

void IdCounts::append(const IdCounts& next) {
  for (size_t pixel = 0; pixel < first_.size(); ++pixel)
    next.visit(pixel, [&](int32_t id, uint32_t count) { add(pixel, id, count); });
}

// Entries that are left over stay in the list without samples.
void IdCounts::take(size_t pixel, const IdCounts& from) {
  for (Entry* entry = &first_[pixel];; entry = &more_[entry->next - 1]) {
    entry->count = 0;
    if (entry->next == 0) break;
  }
  from.visit(pixel, [&](int32_t id, uint32_t count) { add(pixel, id, count); });
}

void IdCounts::rank(size_t pixel, size_t count, int pair, const std::vector<uint32_t>& keys,
                    const std::vector<uint32_t>& samples, float* out) const {
  using Ranked = std::pair<uint32_t, uint32_t>;  // key, samples
  std::vector<Ranked> ranked;
  for (size_t i = pixel; i < pixel + count; ++i, out += 4) {
    ranked.clear();
    visit(i, [&](int32_t id, uint32_t hits) {
      if (static_cast<size_t>(id) >= keys.size()) return;
      ranked.emplace_back(keys[static_cast<size_t>(id)], hits);
    });
    std::sort(ranked.begin(), ranked.end());
    size_t kept = 0;  // several ids may have one key
    for (const Ranked& one : ranked)
      if (kept > 0 && ranked[kept - 1].first == one.first)
        ranked[kept - 1].second += one.second;
      else
        ranked[kept++] = one;
    ranked.resize(kept);
    std::stable_sort(ranked.begin(), ranked.end(),
                     [](const Ranked& a, const Ranked& b) { return a.second > b.second; });
    for (size_t r = 0; r < 2; ++r) {
      const size_t rank = 2 * static_cast<size_t>(pair) + r;
      const bool is_there = rank < ranked.size();
      out[2 * r] = is_there ? std::bit_cast<float>(ranked[rank].first) : 0;
      out[2 * r + 1] = is_there ? static_cast<float>(static_cast<double>(ranked[rank].second) / samples[i]) : 0;
    }
  }
}

std::vector<std::byte> IdCounts::write() const {
  std::vector<Stored> all;
  for (size_t pixel = 0; pixel < first_.size(); ++pixel) {
    const auto begin = static_cast<std::ptrdiff_t>(all.size());
    visit(pixel, [&](int32_t id, uint32_t count) { all.push_back({static_cast<uint32_t>(pixel), id, count}); });
    std::sort(all.begin() + begin, all.end(), [](const Stored& a, const Stored& b) { return a.id < b.id; });
  }
  const uint64_t number = all.size();
  std::vector<std::byte> written(sizeof number + all.size() * sizeof(Stored));
  std::memcpy(written.data(), &number, sizeof number);
  if (!all.empty()) std::memcpy(written.data() + sizeof number, all.data(), all.size() * sizeof(Stored));
  return written;
}

bool IdCounts::read(std::span<const std::byte> bytes, const std::vector<uint32_t>& samples) {
  clear();
  uint64_t number = 0;
  if (bytes.size() < sizeof number) return false;
  std::memcpy(&number, bytes.data(), sizeof number);
  bytes = bytes.subspan(sizeof number);
  if (bytes.size() % sizeof(Stored) != 0 || bytes.size() / sizeof(Stored) != number) return false;
  Stored last{0, -1, 0};
  uint64_t of_pixel = 0;  // samples that have ids
  for (size_t at = 0; at < bytes.size(); at += sizeof(Stored)) {
    Stored one;
    std::memcpy(&one, bytes.data() + at, sizeof one);
    if (one.pixel != last.pixel) of_pixel = 0, last.id = -1;
    of_pixel += one.count;
    const bool in_order = one.pixel >= last.pixel && one.id > last.id;
    if (!in_order || one.pixel >= first_.size() || one.count == 0 || of_pixel > samples[one.pixel]) return false;
    add(one.pixel, one.id, one.count);
    last = one;
  }
  return true;
}

size_t IdCounts::most_bytes(const std::vector<uint32_t>& samples) {
  size_t entries = 0;
  for (const uint32_t count : samples) entries += count;
  return sizeof(uint64_t) + entries * sizeof(Stored);
}

}  // namespace alabaster
