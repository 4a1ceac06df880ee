#include "core/light/light_tree.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/light/light_choice.h"

namespace alabaster {
namespace {

// A light that is nowhere gives nothing (light_parameters.h).
LightExtent extent_of(const Light& light) {
  const LightExtent extent = std::visit([](const auto& l) { return l.extent(); }, light);
  if (!extent.finite || std::isfinite(length(extent.box.lower) + length(extent.box.upper))) return extent;
  return {{Vec3d(0), Vec3d(0)}, 0};
}

int longest_axis(const Vec3d& v) {
  return v.x >= v.y && v.x >= v.z ? 0 : v.y >= v.z ? 1 : 2;
}

// The cone that holds both cones of normals (Conty Estevez, Kulla 2018, algorithm 1).
void unite_normals(const LightExtent& a, const LightExtent& b, LightExtent* both) {
  const LightExtent& wide = a.normals_angle >= b.normals_angle ? a : b;
  const LightExtent& narrow = &wide == &a ? b : a;
  both->axis = wide.axis;
  both->normals_angle = wide.normals_angle;
  both->emission_angle = std::max(a.emission_angle, b.emission_angle);
  const double cosine = dot(wide.axis, narrow.axis), apart = std::atan2(length(cross(wide.axis, narrow.axis)), cosine);
  if (apart + narrow.normals_angle <= wide.normals_angle) return;
  const double angle = 0.5 * (wide.normals_angle + apart + narrow.normals_angle);
  const Vec3d across = narrow.axis - wide.axis * cosine;
  both->normals_angle = kPiDouble;
  if (angle >= kPiDouble || !(length(across) > 0)) return;
  both->normals_angle = angle;
  const double turn = angle - wide.normals_angle;
  both->axis = wide.axis * std::cos(turn) + across * (std::sin(turn) / length(across));
}

struct Angle {
  double cosine, sine;
};
// a - b, or 0 if that is less. Angles up to pi.
Angle minus(const Angle& a, const Angle& b) {
  if (a.cosine >= b.cosine) return {1, 0};
  return {a.cosine * b.cosine + a.sine * b.sine, a.sine * b.cosine - a.cosine * b.sine};
}

}  // namespace

struct LightTree::Leaf {
  LightExtent extent;
  uint32_t light;
  double scale;
};

LightTree::LightTree(const std::vector<Light>& lights, const std::vector<LobeScales>& scales)
    : node_of_light_(lights.size()) {
  std::vector<Leaf> leaves;
  for (uint32_t i = 0; i < lights.size(); ++i) {
    if (is_constant_dome(lights[i])) continue;
    leaves.push_back({extent_of(lights[i]), i, scales.empty() ? 1.0 : scales[i].mean()});
    leaves.back().extent.power *= leaves.back().scale;
  }
  if (leaves.empty()) return;
  nodes_.reserve(2 * leaves.size());
  reserved_ = std::max(1u, kChoiceSteps / 10 / static_cast<uint32_t>(leaves.size()));
  build(leaves);
}

uint32_t LightTree::build(std::span<Leaf> leaves) {
  const auto index = static_cast<uint32_t>(nodes_.size());
  nodes_.emplace_back();
  nodes_[index].lights = static_cast<uint32_t>(leaves.size());
  if (leaves.size() == 1) {
    nodes_[index].extent = leaves[0].extent;
    nodes_[index].scale = leaves[0].scale;
    nodes_[index].next = leaves[0].light;
    node_of_light_[leaves[0].light] = index;
    return index;
  }

  // Part the infinite lights from the finite ones, and these at the median of their middles.
  const auto finite = std::partition(leaves.begin(), leaves.end(), [](const Leaf& l) { return !l.extent.finite; });
  auto middle = finite;
  if (finite == leaves.begin() || finite == leaves.end()) {
    middle = leaves.begin() + static_cast<std::ptrdiff_t>(leaves.size() / 2);
    BoundsDouble middles;
    for (const Leaf& l : leaves) middles.extend(l.extent.box.center());
    const int axis = longest_axis(middles.extent());
    std::nth_element(leaves.begin(), middle, leaves.end(), [axis](const Leaf& a, const Leaf& b) {
      const double x = a.extent.box.center()[axis], y = b.extent.box.center()[axis];
      return x < y || (x == y && a.light < b.light);
    });
  }
  const auto first = static_cast<size_t>(middle - leaves.begin());
  const uint32_t left = build(leaves.first(first)), right = build(leaves.subspan(first));

  // Take both together.
  const LightExtent &a = nodes_[left].extent, &b = nodes_[right].extent;
  LightExtent both{b.box, a.power + b.power, b.finite};  // the second one is finite if any is
  if (a.finite) both.box.extend(a.box);
  // A light that gives nothing has no say.
  const bool left_counts = a.finite && a.power > 0, right_counts = b.power > 0 || !left_counts;
  unite_normals(left_counts ? a : b, right_counts ? b : a, &both);
  Node& node = nodes_[index];
  node.extent = both;
  node.cos_normals = std::cos(both.normals_angle);
  node.sin_normals = std::sin(both.normals_angle);
  node.cos_emission = std::cos(both.emission_angle);
  node.next = right;
  return index;
}

double LightTree::facing(const Node& node, const Vec3d& to_middle, double radius) {
  const double distance = length(to_middle);
  if (node.cos_normals <= -1 || !(distance > radius)) return 1;
  const double cosine = std::clamp(-dot(node.extent.axis, to_middle) / distance, -1.0, 1.0);
  const double seen = radius / distance;
  const Angle off = minus({cosine, std::sqrt(1 - cosine * cosine)}, {node.cos_normals, node.sin_normals});
  const double nearest = minus(off, {std::sqrt(1 - seen * seen), seen}).cosine;
  return nearest >= node.cos_emission ? std::max(nearest, 0.0) : 0;
}

double LightTree::importance(const std::vector<Light>& lights, const Vec3f& p, uint32_t node) const {
  const Node& n = nodes_[node];
  if (n.is_light()) return n.scale * std::visit([&](const auto& light) { return light.importance(p); }, lights[n.next]);
  if (!n.extent.finite) return n.extent.power;
  const Vec3d d = n.extent.box.center() - Vec3d(p), half = n.extent.box.extent() * 0.5;
  const double radius2 = dot(half, half);
  return n.extent.power * facing(n, d, std::sqrt(radius2)) / (dot(d, d) + radius2);
}

struct LightTree::Cut {
  static constexpr int kLevels = 4;
  std::array<uint32_t, size_t(1) << kLevels> nodes;
  std::array<double, size_t(1) << kLevels> importances;
  size_t size = 0;
  double total = 0;  // of the importances; where they add up to no positive number, each is 1
};

LightTree::Cut LightTree::cut_below(const std::vector<Light>& lights, const Vec3f& p, uint32_t node) const {
  Cut cut;
  cut.nodes[cut.size++] = node;
  for (int level = 0; level < Cut::kLevels; ++level) {
    const size_t size = cut.size;
    for (size_t i = 0; i < size; ++i) {
      const uint32_t n = cut.nodes[i];
      if (nodes_[n].is_light()) continue;
      cut.nodes[i] = n + 1;
      cut.nodes[cut.size++] = nodes_[n].next;
    }
  }
  for (size_t i = 0; i < cut.size; ++i) cut.total += cut.importances[i] = importance(lights, p, cut.nodes[i]);
  if (cut.total > 0 && std::isfinite(cut.total)) return cut;
  cut.importances.fill(1);
  cut.total = static_cast<double>(cut.size);
  return cut;
}

double LightTree::importance(const std::vector<Light>& lights, const Vec3f& p) const {
  const Cut cut = cut_below(lights, p, 0);
  double sum = 0;
  for (size_t i = 0; i < cut.size; ++i) sum += importance(lights, p, cut.nodes[i]);
  return sum;
}

template <class IsIt>
uint32_t LightTree::descend(const Cut& cut, const IsIt& is_it, Steps* steps) const {
  uint32_t count = 0;
  for (size_t i = 0; i < cut.size; ++i) count += nodes_[cut.nodes[i]].lights;
  const double free = static_cast<double>(steps->end - steps->begin) - static_cast<double>(reserved_) * count;
  uint32_t begin = steps->begin, reserved = steps->begin;
  double running = 0;
  for (size_t i = 0;; ++i) {
    const uint32_t node = cut.nodes[i];
    running += cut.importances[i];
    reserved += reserved_ * nodes_[node].lights;
    const bool last = i + 1 == cut.size;
    const uint32_t end =
        last ? steps->end : reserved + static_cast<uint32_t>(std::min(1.0, running / cut.total) * free);
    if (last || is_it(node, end)) {
      *steps = {begin, end};
      return node;
    }
    begin = end;
  }
}

std::optional<LightChoice::Chosen> LightTree::choose(const std::vector<Light>& lights, const Vec3f& p, float u) const {
  const auto step = static_cast<uint32_t>(std::clamp(u, 0.0f, kOneMinusEpsilon) * static_cast<float>(kChoiceSteps));
  Steps steps;
  uint32_t node = 0;
  while (!nodes_[node].is_light())
    node = descend(
        cut_below(lights, p, node), [step](uint32_t, uint32_t end) { return step < end; }, &steps);
  return LightChoice::Chosen{nodes_[node].next,
                             static_cast<float>(steps.end - steps.begin) / static_cast<float>(kChoiceSteps)};
}

// A node of n lights is followed by the 2 n - 2 below it.
float LightTree::probability(const std::vector<Light>& lights, const Vec3f& p, size_t light) const {
  const uint32_t goal = node_of_light_[light];
  const auto holds = [&](uint32_t n, uint32_t) { return n <= goal && goal <= n + 2 * (nodes_[n].lights - 1); };
  Steps steps;
  for (uint32_t node = 0; node != goal;) node = descend(cut_below(lights, p, node), holds, &steps);
  return static_cast<float>(steps.end - steps.begin) / static_cast<float>(kChoiceSteps);
}

// A box a little larger than the lights, so that no rounding of the slabs loses one.
bool LightTree::meets(const Ray& ray, const LightExtent& extent) {
  if (!extent.finite) return false;
  double begin = 0, end = static_cast<double>(ray.tmax);
  for (int i = 0; i < 3; ++i) {
    const double low = extent.box.lower[i], high = extent.box.upper[i];
    const double org = static_cast<double>(ray.org[i]), dir = static_cast<double>(ray.dir[i]);
    const double slack = 1e-6 * (std::abs(low) + std::abs(high) + std::abs(org));
    const double near = low - slack - org, far = high + slack - org;
    if (dir == 0) {
      if (near > 0 || far < 0) return false;
      continue;
    }
    begin = std::max(begin, (dir > 0 ? near : far) / dir);
    end = std::min(end, (dir > 0 ? far : near) / dir);
  }
  return begin <= end * (1 + 1e-6);
}

size_t LightTree::memory_bytes() const {
  return nodes_.capacity() * sizeof(Node) + node_of_light_.capacity() * sizeof(uint32_t);
}

}  // namespace alabaster
