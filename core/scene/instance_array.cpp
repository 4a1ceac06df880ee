#include "core/scene/instance_array.h"

#include <tbb/parallel_for.h>
#include <tbb/parallel_invoke.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <set>
#include <utility>

#include "core/scene/scene.h"
#include "core/scene/world_placement.h"

namespace alabaster {
namespace {

constexpr uint32_t kMost = InstanceCells::kMost;
constexpr size_t kBlock = ArrayBlock::kSize;
// Cells grow as instances leave their places: after so many, new ones are chosen.
constexpr size_t kMovedShare = 8;

enum class State { missing, hidden, faulty, drawn };

State state_of(const std::optional<Matrix4d>& place, const Bounds& object) {
  if (!place) return State::missing;
  if (is_valid_affine(*place) && is_within_reach(world_bounds(object, *place))) return State::drawn;
  return is_within_reach(*place) ? State::hidden : State::faulty;
}

size_t blocks_of(size_t count) {
  return (count + kBlock - 1) / kBlock;
}

// The middles of an array's instances in world space, by number.
struct Centers {
  explicit Centers(size_t count) : at(count, Vec3d(0, 0, 0)), drawn(count) {}
  std::vector<Vec3d> at;
  std::vector<uint8_t> drawn;  // false: it has none
};

// The numbers of an array in the order of its cells: halves of halves along the longest axis, until kMost are left.
// Those that are not drawn come last.
class CellChoice {
 public:
  CellChoice(const Centers& centers, const CancelToken& cancel) : cancel_(cancel), centers_(centers.at) {
    order_.resize(centers_.size());
    std::iota(order_.begin(), order_.end(), 0u);
    const auto end =
        std::stable_partition(order_.begin(), order_.end(), [&](uint32_t i) { return centers.drawn[i] != 0; });
    halve(0, static_cast<size_t>(end - order_.begin()));
  }
  /// While it is made: orders, centres and what is drawn.
  static size_t memory_bytes(size_t count) { return count * (2 * sizeof(uint32_t) + sizeof(Vec3d) + 1); }
  size_t count() const { return (order_.size() + kMost - 1) / kMost; }
  std::vector<uint32_t> numbers(size_t cell) const {
    const auto begin = order_.begin() + std::ptrdiff_t(cell * kMost);
    std::vector<uint32_t> numbers(begin, begin + std::ptrdiff_t(std::min<size_t>(kMost, order_.size() - cell * kMost)));
    std::sort(numbers.begin(), numbers.end());
    return numbers;
  }

 private:
  void halve(size_t begin, size_t end) {
    cancel_.check();
    const size_t cells = (end - begin + kMost - 1) / kMost;
    if (cells < 2) return;
    BoundsDouble bounds;
    for (size_t i = begin; i < end; ++i) bounds.extend(centers_[order_[i]]);
    const Vec3d extent = bounds.extent();
    const int axis = extent.x >= extent.y && extent.x >= extent.z ? 0 : extent.y >= extent.z ? 1 : 2;
    const size_t middle = begin + cells / 2 * kMost;
    const auto at = [&](size_t i) { return order_.begin() + std::ptrdiff_t(i); };
    std::nth_element(at(begin), at(middle), at(end), [&](uint32_t a, uint32_t b) {
      return std::pair(centers_[a][axis], a) < std::pair(centers_[b][axis], b);
    });
    tbb::parallel_invoke([&] { halve(begin, middle); }, [&] { halve(middle, end); });
  }

  const CancelToken& cancel_;
  const std::vector<Vec3d>& centers_;  // by number
  std::vector<uint32_t> order_;
};

class Planner {
 public:
  Planner(const InstanceArrayDescription& description, const CancelToken& cancel)
      : places_(*description.places),
        mesh_(description.look.prototype->mesh),
        middle_(middle_half(mesh_)),
        cancel_(cancel) {
    plan_.places = description.places;
    plan_.prototype = description.look.prototype;
    plan_.scatters = !scattering_slots(description.look).empty();
  }

  ArrayPlan choose_cells(const std::shared_ptr<MemoryBudget>& memory) {
    const MemoryReservation reserved(memory, MemoryUse::scene, CellChoice::memory_bytes(places_.size()),
                                     "an array of " + std::to_string(places_.size()) + " instances");
    std::set<size_t> all;
    for (size_t block = 0; block < blocks_of(places_.size()); ++block) all.insert(block);
    Centers centers(places_.size());
    measure(all, &centers);
    const CellChoice choice(centers, cancel_);
    std::vector<uint32_t> slots(places_.size());
    plan_.cells.resize(choice.count());
    tbb::parallel_for(size_t(0), choice.count(), [&](size_t cell) {
      auto chosen = std::make_shared<const ArrayCell>(ArrayCell{choice.numbers(cell)});
      for (size_t i = 0; i < chosen->numbers.size(); ++i)
        slots[chosen->numbers[i]] = static_cast<uint32_t>(cell * kMost + i);
      plan_.cells[cell] = std::move(chosen);
    });
    plan_.slots = std::make_shared<const std::vector<uint32_t>>(std::move(slots));
    return std::move(plan_);
  }

  // Empty: so many have moved that new cells are worth their cost.
  std::optional<ArrayPlan> continue_from(const ArrayPlan& last) {
    const size_t before = last.places->size(), now = places_.size();
    if (last.prototype != plan_.prototype || last.scatters != plan_.scatters) return std::nullopt;
    const std::vector<uint32_t> moved = find_moved(*last.places);
    plan_.moved = last.moved + moved.size() + (std::max(before, now) - std::min(before, now));
    if (plan_.moved > now / kMovedShare) return std::nullopt;
    plan_.slots = last.slots;
    plan_.cells = last.cells;
    plan_.blocks = last.blocks;
    std::set<size_t> blocks;
    for (const uint32_t number : moved) {
      auto& cell = plan_.cells[(*last.slots)[number] / kMost];
      if (cell == last.cells[(*last.slots)[number] / kMost]) cell = std::make_shared<const ArrayCell>(*cell);
      blocks.insert(number / kBlock);
    }
    if (now != before) resize(last);
    for (size_t block = std::min(before, now) / kBlock; now != before && block < blocks_of(now); ++block)
      blocks.insert(block);
    measure(blocks, nullptr);
    return std::move(plan_);
  }

 private:
  // The last numbers leave their cells; new ones fill up the last cell, and then others.
  void resize(const ArrayPlan& last) {
    const auto before = static_cast<uint32_t>(last.places->size()), now = static_cast<uint32_t>(places_.size());
    std::map<uint32_t, std::vector<uint32_t>> lists;
    const auto list = [&](uint32_t cell) -> std::vector<uint32_t>& {
      const auto [found, is_new] = lists.try_emplace(cell);
      if (is_new && cell < last.cells.size()) found->second = last.cells[cell]->numbers;
      return found->second;
    };
    for (uint32_t number = now; number < before; ++number) std::erase(list((*last.slots)[number] / kMost), number);
    auto end = static_cast<uint32_t>(last.cells.size() - 1);
    for (uint32_t number = before; number < now; ++number) {
      if (list(end).size() == kMost) ++end;
      list(end).push_back(number);
    }
    plan_.cells.resize(std::max<size_t>(last.cells.size(), end + 1));
    std::vector<uint32_t> slots(*last.slots);
    slots.resize(now);
    for (auto& [cell, numbers] : lists) {
      uint32_t slot = cell * kMost;
      for (const uint32_t number : numbers) slots[number] = slot++;
      plan_.cells[cell] = std::make_shared<const ArrayCell>(ArrayCell{std::move(numbers)});
    }
    plan_.slots = std::make_shared<const std::vector<uint32_t>>(std::move(slots));
  }

  std::vector<uint32_t> find_moved(const InstancePlaces& last) const {
    const size_t count = std::min(places_.size(), last.size());
    std::vector<std::vector<uint32_t>> moved(blocks_of(count));
    tbb::parallel_for(size_t(0), moved.size(), [&](size_t block) {
      cancel_.check();
      const size_t begin = block * kBlock, end = std::min(count, begin + kBlock);
      if (places_.stand_alike(last, begin, end)) return;
      for (size_t i = begin; i < end; ++i)
        if (!places_.stand_alike(last, i, i + 1)) moved[block].push_back(static_cast<uint32_t>(i));
    });
    std::vector<uint32_t> all;
    for (const auto& some : moved) all.insert(all.end(), some.begin(), some.end());
    return all;
  }

  void measure(const std::set<size_t>& blocks, Centers* centers) {
    plan_.blocks.resize(blocks_of(places_.size()));
    const std::vector<size_t> list(blocks.begin(), blocks.end());
    tbb::parallel_for(size_t(0), list.size(),
                      [&](size_t i) { plan_.blocks[list[i]] = measured(list[i] * kBlock, centers); });
  }

  std::shared_ptr<const ArrayBlock> measured(size_t begin, Centers* centers) const {
    cancel_.check();
    auto block = std::make_shared<ArrayBlock>();
    block->size.count = 0;
    for (size_t i = begin; i < std::min(places_.size(), begin + kBlock); ++i) {
      const auto place = places_.at(i);
      const State state = state_of(place, mesh_.bounds);
      block->hidden += state == State::hidden;
      block->faulty += state == State::faulty;
      if (state != State::drawn) continue;
      if (centers) centers->drawn[i] = 1, centers->at[i] = transform_point(Vec3d(mesh_.bounds.center()), *place);
      const bool first = block->size.count++ == 0;
      block->bounds.extend(world_bounds(mesh_.bounds, *place));
      const PlacedSize one = placed_size(middle_, *place);
      block->size.centers.extend(one.centers);
      block->size.size = first ? one.size : std::min(block->size.size, one.size);
      if (!plan_.scatters) continue;
      const float stretch = least_stretch(to_affine(*place));
      block->least_stretch = first ? stretch : std::min(block->least_stretch, stretch);
    }
    return block;
  }

  const InstancePlaces& places_;
  const Mesh& mesh_;
  const MiddleHalf middle_;
  const CancelToken& cancel_;
  ArrayPlan plan_;
};

// The instances of a cell in render space.
class CellPlacer {
 public:
  CellPlacer(const ArrayPlan& plan, const RenderSpace& space, std::shared_ptr<TraceDevice> device)
      : plan_(plan), space_(space), device_(std::move(device)) {}

  /// Null as build_instance_cell().
  std::shared_ptr<const InstanceCell> place(const std::shared_ptr<const ArrayCell>& cell, uint32_t* left_out,
                                            const std::function<bool()>& stopped) const {
    CellInstances instances;
    instances.memory = MemoryReservation(memory_of(*device_), MemoryUse::scene,
                                         cell->numbers.size() * (sizeof(Placement) + 2 * sizeof(uint32_t)),
                                         "an array of " + std::to_string(plan_.places->size()) + " instances");
    instances.numbers = std::shared_ptr<const std::vector<uint32_t>>(cell, &cell->numbers);
    instances.placements.resize(cell->numbers.size());
    instances.hidden.resize(cell->numbers.size(), true);
    for (size_t i = 0; i < cell->numbers.size(); ++i) {
      const auto place = plan_.places->at(cell->numbers[i]);
      if (state_of(place, plan_.prototype->mesh.bounds) != State::drawn) continue;
      const Matrix4d m = moved_to(*place, space_.origin);
      const Affine object_to_world = to_affine(m);
      if (!is_traceable(object_to_world, space_.farthest)) {
        ++*left_out;
        continue;
      }
      instances.placements[i] = {object_to_world, to_affine(m.inverse())};
      instances.hidden[i] = false;
    }
    return build_instance_cell(device_, plan_.prototype->object, std::move(instances), stopped);
  }

 private:
  const ArrayPlan& plan_;
  const RenderSpace space_;
  const std::shared_ptr<TraceDevice> device_;
};

}  // namespace

ArrayPlan plan_array(const InstanceArrayDescription& description, const ArrayPlan* last,
                     const std::shared_ptr<MemoryBudget>& memory, const CancelToken& cancel) {
  if (last)
    if (auto continued = Planner(description, cancel).continue_from(*last)) return std::move(*continued);
  return Planner(description, cancel).choose_cells(memory);
}

float ArrayPlan::least_stretch() const {
  float least = std::numeric_limits<float>::infinity();
  for (const auto& block : blocks)
    if (block->size.count > 0) least = std::min(least, block->least_stretch);
  return std::isfinite(least) ? least : 1;
}

std::vector<PlacedSize> sizes_in(const ArrayPlan& plan, size_t block) {
  const Mesh& mesh = plan.prototype->mesh;
  const MiddleHalf middle = middle_half(mesh);
  std::vector<PlacedSize> sizes;
  for (size_t i = block * kBlock; i < std::min(plan.places->size(), (block + 1) * kBlock); ++i) {
    const auto place = plan.places->at(i);
    if (state_of(place, mesh.bounds) == State::drawn) sizes.push_back(placed_size(middle, *place));
  }
  return sizes;
}

std::shared_ptr<const PlacedArray> place_array(ArrayPlan plan, const RenderSpace& space, const PlacedArray* last,
                                               const std::shared_ptr<TraceDevice>& device, const CancelToken& cancel) {
  auto placed = std::make_shared<PlacedArray>();
  placed->plan = std::move(plan);
  placed->space = space;
  placed->traced.slots = placed->plan.slots;
  const auto& cells = placed->plan.cells;
  placed->traced.cells.resize(cells.size());
  placed->left_out.resize(cells.size());
  const bool may_share = last && last->space.origin == space.origin;
  const auto can_share = [&](size_t i) {
    return may_share && i < last->plan.cells.size() && last->plan.cells[i] == cells[i] &&
           (last->space.farthest == space.farthest ||
            (last->left_out[i] == 0 && last->traced.cells[i]->is_traceable_from(space.farthest)));
  };
  const CellPlacer placer(placed->plan, space, device);
  std::atomic<bool> failed{false};  // one refusal is enough
  tbb::parallel_for(size_t(0), cells.size(), [&](size_t i) {
    if (can_share(i)) {
      placed->traced.cells[i] = last->traced.cells[i];
      placed->left_out[i] = last->left_out[i];
      return;
    }
    cancel.check();
    if (failed) return;
    placed->traced.cells[i] =
        placer.place(cells[i], &placed->left_out[i], [&] { return failed || cancel.is_cancelled(); });
    if (!placed->traced.cells[i]) failed = true;
  });
  cancel.check();
  return failed ? nullptr : placed;
}

Bounds PlacedArray::bounds() const {
  BoundsDouble world;
  for (const auto& block : plan.blocks) world.extend(block->bounds);
  if (world.empty()) return {};
  const Vec3d lower = world.lower - space.origin, upper = world.upper - space.origin;
  const Vec3d margin(1e-6 * std::max(length(lower), length(upper)));
  return {Vec3f(lower - margin), Vec3f(upper + margin)};
}

bool report_left_out(const PlacedArray& array, const std::string& name, const DiagnosticSink& sink) {
  const auto tell = [&](Severity severity, size_t count, const char* reason) {
    if (count > 0)
      report(sink, severity, "instance.transform", name,
             std::to_string(count) + " of " + std::to_string(array.size()) + " instances are left out: " + reason);
  };
  size_t hidden = 0, faulty = 0;
  for (const auto& block : array.plan.blocks) hidden += block->hidden, faulty += block->faulty;
  for (const uint32_t count : array.left_out) hidden += count;
  tell(Severity::warning, hidden,
       "their transforms are not affine, or too small, flat or large to be traced; check their scale");
  tell(Severity::error, faulty, "their transforms are not finite, or go beyond 1e17; check their transforms");
  return faulty > 0;
}

size_t PlacedArray::memory_bytes() const {
  size_t bytes = size() * sizeof(uint32_t);
  for (const auto& cell : traced.cells) bytes += cell->memory_bytes();
  return bytes;
}

}  // namespace alabaster
