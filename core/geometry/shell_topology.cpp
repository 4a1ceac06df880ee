#include "core/geometry/shell_topology.h"

#include <algorithm>
#include <bit>
#include <span>
#include <utility>

#include "core/geometry/grouped_items.h"

namespace alabaster {
namespace {

// Sets of triangles, each triangle with its winding relative to the first of its set (union-find with parity).
class Surfaces {
 public:
  explicit Surfaces(size_t count) : parent_(count), turned_(count, 0) {
    for (size_t i = 0; i < count; ++i) parent_[i] = static_cast<uint32_t>(i);
  }

  uint32_t root(uint32_t t) {
    uint32_t top = t;
    uint8_t turned = 0;
    for (; parent_[top] != top; top = parent_[top]) turned ^= turned_[top];
    // All of the way now points to the top.
    while (parent_[t] != top && t != top) {
      const uint32_t next = parent_[t];
      const uint8_t step = turned_[t];
      parent_[t] = top;
      turned_[t] = turned;
      turned ^= step;
      t = next;
    }
    return top;
  }
  bool is_turned(uint32_t t) { return root(t) != t && turned_[t]; }

  /// False: a and b are already one surface, and `turned` contradicts it, as on a Moebius strip.
  bool join(uint32_t a, uint32_t b, bool turned) {
    const uint32_t ra = root(a), rb = root(b);
    const bool apart = (is_turned(a) != is_turned(b)) != turned;
    if (ra == rb) return !apart;
    parent_[std::max(ra, rb)] = std::min(ra, rb);
    turned_[std::max(ra, rb)] = apart;
    return true;
  }

 private:
  std::vector<uint32_t> parent_;
  std::vector<uint8_t> turned_;  // against the parent
};

// An edge of a triangle from or to the point that groups it.
struct Edge {
  uint32_t other;  // point
  uint32_t triangle;
  bool ascending;  // as this triangle runs along it
  bool operator<(const Edge& o) const { return other != o.other ? other < o.other : triangle < o.triangle; }
};

// A triangle among those with the same lowest corner.
struct Fellow {
  std::array<uint32_t, 2> others;  // its other corners, ascending
  uint32_t triangle;
  bool operator<(const Fellow& o) const { return others != o.others ? others < o.others : triangle < o.triangle; }
};

class TopologyFinder {
 public:
  TopologyFinder(std::vector<WeldedCorners> corners, size_t points, const CancelToken& cancel)
      : cancel_(cancel), points_(points), surfaces_(corners.size()) {
    corners_ = std::move(corners);
    kind_.assign(corners_.size(), kSingle);
  }

  std::shared_ptr<const ShellTopology> find() {
    find_degenerate();
    cancel_.check();
    merge_coincident();
    find_doubled();
    for_each_edge([this](std::span<const Edge> edge) { join_at_edge(edge); });
    number_shells();
    out_.has_walls = !walls_.empty();
    out_.turned.resize(corners_.size());
    for (uint32_t t = 0; t < corners_.size(); ++t) {
      cancel_.check();
      out_.turned[t] = surfaces_.is_turned(t);
    }
    return std::make_shared<const ShellTopology>(std::move(out_));
  }

 private:
  using Kind = ShellTopology::Kind;
  static constexpr Kind kSingle = Kind::kSingle, kCopy = Kind::kCopy, kBackToBack = Kind::kBackToBack,
                        kDegenerate = Kind::kDegenerate;
  static constexpr uint32_t kNone = ShellTopology::kNone;
  static constexpr size_t kProbes = 8;

  void find_degenerate() {
    for (size_t t = 0; t < corners_.size(); ++t) {
      const WeldedCorners& c = corners_[t];
      if (c[0] == c[1] || c[1] == c[2] || c[2] == c[0]) kind_[t] = kDegenerate;
    }
  }

  void merge_coincident() {
    const auto each = [&](const auto& add) {
      for (uint32_t t = 0; t < corners_.size(); ++t) {
        cancel_.check();
        WeldedCorners key = corners_[t];
        std::sort(key.begin(), key.end());
        if (kind_[t] == kSingle) add(key[0], Fellow{{key[1], key[2]}, t});
      }
    };
    const GroupedItems<Fellow> triangles(points_, each, cancel_);
    for (size_t point = 0; point < triangles.size(); ++point) {
      cancel_.check();
      for_each_run(
          triangles[point], [](const Fellow& a, const Fellow& b) { return a.others == b.others; },
          [&](std::span<const Fellow> coincident) {
            if (coincident.size() > 1) merge(coincident);
          });
    }
  }

  void merge(std::span<const Fellow> group) {
    const auto is_even = [&](size_t i) { return even_permutation(corners_[group[i].triangle]); };
    const size_t count = group.size();
    size_t even = 0;
    for (size_t i = 0; i < count; ++i) even += is_even(i) ? 1 : 0;
    if (2 * even == count) {
      for (size_t i = 0; i < count; ++i) kind_[group[i].triangle] = kBackToBack;
      for (size_t i = 1; i < count; ++i)
        backs_.push_back({group[0].triangle, group[i].triangle, is_even(i) != is_even(0)});
      return;
    }
    const bool majority = 2 * even > count;
    uint32_t kept = kNone;
    for (size_t i = 0; i < count; ++i)
      if (kept == kNone && is_even(i) == majority) kept = group[i].triangle;
    for (size_t i = 0; i < count; ++i) {
      if (group[i].triangle == kept) continue;
      kind_[group[i].triangle] = kCopy;
      surfaces_.join(kept, group[i].triangle, is_even(i) != majority);
    }
  }

  static bool even_permutation(const WeldedCorners& c) {
    return (c[0] < c[1] && c[1] < c[2]) || (c[1] < c[2] && c[2] < c[0]) || (c[2] < c[0] && c[0] < c[1]);
  }

  // A surface all of whose triangles are back to back is a body if one of each closes it, and a sheet otherwise.
  void find_doubled() {
    if (backs_.empty()) return;
    std::vector<bool> is_first(corners_.size(), false);
    for (const Back& back : backs_) is_first[back.first] = true;
    Surfaces doubled(corners_.size());
    std::vector<bool> open(corners_.size(), false);
    std::vector<uint32_t> torn;
    for_each_edge([&](std::span<const Edge> edge) {
      std::vector<const Edge*> firsts;
      for (const Edge& one : edge)
        if (is_first[one.triangle]) firsts.push_back(&one);
      bool closes = firsts.size() % 2 == 0;
      for (const Edge& one : edge) closes = closes && kind_[one.triangle] == kBackToBack;
      if (closes && firsts.size() == 2)
        closes = doubled.join(firsts[0]->triangle, firsts[1]->triangle, firsts[0]->ascending == firsts[1]->ascending);
      if (!closes)
        for (const Edge* first : firsts) torn.push_back(first->triangle);
    });
    for (const uint32_t t : torn) open[doubled.root(t)] = true;
    for (const Back& back : backs_) {
      if (open[doubled.root(back.first)]) continue;
      kind_[back.first] = kSingle, kind_[back.copy] = kCopy;
      surfaces_.join(back.first, back.copy, back.turned);
    }
  }

  /// Calls visit(edges) with the edges between each two points.
  template <class Visit>
  void for_each_edge(const Visit& visit) {
    const auto each = [&](const auto& add) {
      for (uint32_t t = 0; t < corners_.size(); ++t) {
        cancel_.check();
        if (kind_[t] == kCopy || kind_[t] == kDegenerate) continue;
        for (size_t i = 0; i < 3; ++i) {
          const uint32_t a = corners_[t][i], b = corners_[t][(i + 1) % 3];
          add(std::min(a, b), Edge{std::max(a, b), t, a < b});
        }
      }
    };
    const GroupedItems<Edge> edges(points_, each, cancel_);
    for (size_t point = 0; point < edges.size(); ++point) {
      cancel_.check();
      for_each_run(
          edges[point], [](const Edge& a, const Edge& b) { return a.other == b.other; }, visit);
    }
  }

  void join_at_edge(std::span<const Edge> edge) {
    const size_t count = edge.size();
    std::array<const Edge*, 2> pair{};
    size_t single = 0;
    const Edge* back_to_back = nullptr;
    for (size_t i = 0; i < count; ++i) {
      if (kind_[edge[i].triangle] == kBackToBack) {
        if (back_to_back) surfaces_.join(back_to_back->triangle, edge[i].triangle, false);
        back_to_back = &edge[i];
      } else if (single++ < 2) {
        pair[single - 1] = &edge[i];
      }
    }
    if (single % 2 == 1)
      for (size_t i = 0; i < count; ++i) torn_.push_back(edge[i].triangle);
    if (single == 2 && !surfaces_.join(pair[0]->triangle, pair[1]->triangle, pair[0]->ascending == pair[1]->ascending))
      torn_.push_back(pair[0]->triangle);
    if (single > 0 && back_to_back) walls_.push_back(back_to_back->triangle);
  }

  void number_shells() {
    out_.shell.assign(corners_.size(), kNone);
    for (uint32_t t = 0; t < corners_.size(); ++t) {
      cancel_.check();
      if (kind_[t] == kDegenerate) continue;
      const uint32_t root = surfaces_.root(t);
      if (out_.shell[root] == kNone) {
        out_.shell[root] = static_cast<uint32_t>(out_.shells.size());
        out_.shells.emplace_back();
      }
      out_.shell[t] = out_.shell[root];
      ShellTopology::Shell& shell = out_.shells[out_.shell[t]];
      if (std::has_single_bit(++shell.count) && shell.some.size() < kProbes) shell.some.push_back(t);
    }
    out_.open.assign(out_.shells.size(), false);
    out_.inner.assign(out_.shells.size(), false);
    for (uint32_t t = 0; t < corners_.size(); ++t)
      if (kind_[t] == kBackToBack) out_.open[out_.shell[t]] = true;
    for (uint32_t t : torn_) out_.open[out_.shell[t]] = true;
    for (uint32_t t : walls_) out_.inner[out_.shell[t]] = true;
  }

  const CancelToken cancel_;
  const size_t points_;
  ShellTopology out_;
  std::vector<WeldedCorners>& corners_ = out_.corners;
  std::vector<Kind>& kind_ = out_.kind;
  Surfaces surfaces_;
  struct Back {
    uint32_t first, copy;  // coincident triangles, of a group in which half wind either way
    bool turned;           // they wind against each other
  };
  std::vector<Back> backs_;
  std::vector<uint32_t> torn_, walls_;  // a triangle of each surface that has an open edge; that continues in another
};

}  // namespace

size_t ShellTopology::memory_bytes() const {
  return corners.capacity() * sizeof(corners[0]) + kind.capacity() * sizeof(Kind) + turned.capacity() / 8 +
         shell.capacity() * sizeof(uint32_t);
}

std::shared_ptr<const ShellTopology> find_shell_topology(std::vector<WeldedCorners> corners, size_t points,
                                                         const CancelToken& cancel) {
  return TopologyFinder(std::move(corners), points, cancel).find();
}

std::shared_ptr<const ShellTopology> ShellTopologyCache::get(std::vector<WeldedCorners> corners, size_t points,
                                                             const CancelToken& cancel) {
  {
    const std::lock_guard lock(mutex_);
    if (last_ && last_->corners == corners) return last_;
  }
  auto found = find_shell_topology(std::move(corners), points, cancel);
  hold(found);
  return found;
}

// Where memory is short the next mesh finds its own.
void ShellTopologyCache::hold(std::shared_ptr<const ShellTopology> topology) {
  const std::lock_guard lock(mutex_);
  last_ = nullptr;
  memory_ = {};
  try {
    memory_ = MemoryReservation(budget_, MemoryUse::subsurface, topology->memory_bytes(), "shells");
    last_ = std::move(topology);
  } catch (const MemoryRefused&) {
  }
}

void ShellTopologyCache::forget() {
  const std::lock_guard lock(mutex_);
  last_ = nullptr;
  memory_ = {};
}

}  // namespace alabaster
