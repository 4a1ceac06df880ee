// Animations (glTF 2.0, section 3.11).
#pragma once

#include <map>
#include <span>

#include "delegate/gltf/gltf_document.h"

namespace alabaster::hd::gltf {

/// The keys of a sampler: at each time a value of `components` numbers, or with CUBICSPLINE an in-tangent, a value and
/// an out-tangent.
struct AnimationCurve {
  std::string interpolation;     // STEP, LINEAR or CUBICSPLINE
  std::span<const float> times;  // increasing, at least one
  std::span<const float> values;
  size_t components = 1;
  bool rotation = false;  // unit quaternions (x, y, z, w): LINEAR goes along the shorter arc
};

/// The value at `time`; before the first key the first, after the last key the last.
std::vector<double> sample(const AnimationCurve& curve, double time);

/// The animation of a document, with the keys of its channels.
class NodeAnimation {
 public:
  NodeAnimation() = default;
  NodeAnimation(NodeAnimation&&) = default;
  NodeAnimation& operator=(NodeAnimation&&) = default;
  /// Reads the keys of the document's animation, if it has one that is used.
  explicit NodeAnimation(const Document& document);

  /// Sets the transforms and morph weights of the nodes that the animation moves, as they are at `seconds`.
  void apply(double seconds, tinygltf::Model* model) const;

 private:
  struct Channel {
    size_t node = 0;
    std::string path;      // translation, rotation, scale or weights
    AnimationCurve curve;  // over `values_`
  };
  std::vector<Channel> channels_;
  std::map<int, std::vector<float>> values_;  // by accessor: channels share their times
};

}  // namespace alabaster::hd::gltf
