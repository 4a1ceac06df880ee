// What reaches an input of a node: a constant times textures, the one pattern that AlabasterDisney has.
// Internal to this room.
#pragma once

#include <optional>

#include "delegate/api/scene_types.h"

namespace alabaster::hd::looks {

struct Factor {
  Path id;            // the node in the network that is read
  MaterialNode node;  // AlabasterTexture or AlabasterPrimvar
  std::string output;
  bool operator==(const Factor&) const = default;
};

struct Signal {
  Vec4f constant{1};  // of a number: four times
  std::vector<Factor> factors;

  Vec3f rgb() const { return {constant.x, constant.y, constant.z}; }
  bool is_textured() const { return !factors.empty(); }
  bool is_used() const { return is_textured() || constant.x > 0 || constant.y > 0 || constant.z > 0; }
  bool operator==(const Signal&) const = default;
};

Signal signal_of(float number);
Signal signal_of(const Vec3f& color);
/// None: too many textures.
std::optional<Signal> product(Signal a, const Signal& b);
/// scale * signal + bias; none where no scale and bias of one texture give it.
std::optional<Signal> affine(Signal signal, const Vec4f& scale, const Vec4f& bias);
/// The same, and all of it in the scale and the bias of one texture.
std::optional<Signal> folded(Signal signal, const Vec4f& scale = Vec4f(1), const Vec4f& bias = Vec4f(0));
/// a (1 - share) + b share; none as above.
std::optional<Signal> mixture(const Signal& a, const Signal& b, const Vec4f& share);
/// Channel 0 to 3 as a number.
Signal channel_of(Signal signal, int channel);

}  // namespace alabaster::hd::looks
