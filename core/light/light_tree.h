// Which of very many lights to sample at a point, and which of them a ray can meet, in logarithmic time: a binary tree
// over the lights (Conty Estevez, Kulla 2018, "Importance Sampling of Many Lights with Adaptive Tree Splitting",
// without splitting).
//
// A node stands for its lights as one light in their middle: power cos / (d^2 + r^2), d the distance to the middle and
// r half the diagonal of their box. The cosine is that of the least angle to a normal that the cone of their normals,
// and the angle under which the box is seen, allow. A single light is weighed by its own importance (light.h). Infinite
// lights are one half of the tree.
//
// The way down takes four levels at a time: the sixteen nodes there are weighed against each other. Larger nodes are
// not asked, for one estimate says little of a node that is large beside its distance. Under 1000 lights that halves
// the variance for a 1.6 times longer choice.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/light/light_choice.h"
#include "core/math/ray.h"

namespace alabaster {

/// Immutable. Probabilities are whole multiples of 2^-24, as those of LightChoice: each of n lights owns 0.1 / n of the
/// random numbers beforehand (one at least), and importances divide the rest. Constant domes are no part of the tree.
class LightTree {
 public:
  /// An empty tree, of no light.
  LightTree() = default;
  /// Less than 2^24 lights. The calls below get the same ones. Empty if all are constant domes. `scales`: beside the
  /// lights; empty: all are 1.
  explicit LightTree(const std::vector<Light>& lights, const std::vector<LobeScales>& scales = {});

  bool empty() const { return nodes_.empty(); }
  /// Never empty.
  std::optional<LightChoice::Chosen> choose(const std::vector<Light>& lights, const Vec3f& p, float u) const;
  /// `light`: not a constant dome.
  float probability(const std::vector<Light>& lights, const Vec3f& p, size_t light) const;
  /// An estimate of the irradiance that all lights of the tree give at p together.
  double importance(const std::vector<Light>& lights, const Vec3f& p) const;
  /// visit(light) for every finite light whose bounds the ray meets, and perhaps for others.
  template <class Visit>
  void intersect(const Ray& ray, const Visit& visit) const;

  size_t memory_bytes() const;

 private:
  struct Node {
    LightExtent extent;                                          // of its lights together
    double scale = 1;                                            // of one light's importance
    double cos_normals = -1, sin_normals = 0, cos_emission = 0;  // of its angles
    uint32_t lights = 0;                                         // how many
    uint32_t next = 0;  // of an inner node: its second child, the first one follows it; of the others: the light
    bool is_light() const { return lights == 1; }
  };
  struct Leaf;
  /// Random numbers in steps of 2^-24.
  struct Steps {
    uint32_t begin = 0, end = uint32_t(1) << 24;
  };

  uint32_t build(std::span<Leaf> leaves);
  /// The largest cosine of an angle to a normal of the node's lights: 1 where nothing is known, 0 where all is dark.
  static double facing(const Node& node, const Vec3d& to_middle, double radius);
  double importance(const std::vector<Light>& lights, const Vec3f& p, uint32_t node) const;
  /// The nodes four levels below a node, and the lights above them: up to sixteen that hold its lights, each once.
  struct Cut;
  Cut cut_below(const std::vector<Light>& lights, const Vec3f& p, uint32_t node) const;
  /// Divides a node's steps among its cut; the node there of which is_it(node, end of its steps), and its steps.
  template <class IsIt>
  uint32_t descend(const Cut& cut, const IsIt& is_it, Steps* steps) const;
  static bool meets(const Ray& ray, const LightExtent& extent);

  std::vector<Node> nodes_;  // the root first
  std::vector<uint32_t> node_of_light_;
  uint32_t reserved_ = 1;  // steps that each light has beforehand
};

template <class Visit>
void LightTree::intersect(const Ray& ray, const Visit& visit) const {
  constexpr size_t kDepth = 64;  // halves of less than 2^24 lights, twice
  uint32_t waiting[kDepth];
  size_t count = 0;
  for (uint32_t node = 0;;) {
    const Node& n = nodes_[node];
    if (meets(ray, n.extent)) {
      if (!n.is_light()) {
        waiting[count++] = n.next;
        ++node;
        continue;
      }
      visit(n.next);
    }
    if (count == 0) return;
    node = waiting[--count];
  }
}

}  // namespace alabaster
