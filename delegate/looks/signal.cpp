#include "delegate/looks/signal.h"

#include <algorithm>

#include "delegate/support/lookup.h"

namespace alabaster::hd::looks {
namespace {

constexpr size_t kMostFactors = 8;  // networks may multiply without end

bool is_grey(const Vec4f& v) {
  return v.x == v.y && v.y == v.z;
}

// scale * value + bias of a parameter, which is `otherwise` where it is not given.
void change(MaterialNode* node, const char* name, float otherwise, const Vec4f& scale, const Vec4f& bias) {
  std::array<double, 4> n{};
  const size_t count = support::value_in(node->parameters, name).components(&n);
  Vec4f value(count == 0 ? otherwise : float(n[0]));
  for (size_t i = 1; i < count; ++i) value[int(i)] = float(n[i]);
  node->parameters[name] = value * scale + bias;
}

}  // namespace

Signal signal_of(float number) {
  return {Vec4f(number), {}};
}

Signal signal_of(const Vec3f& color) {
  return {Vec4f(color.x, color.y, color.z, 1), {}};
}

std::optional<Signal> product(Signal a, const Signal& b) {
  a.constant *= b.constant;
  a.factors.insert(a.factors.end(), b.factors.begin(), b.factors.end());
  return a.factors.size() <= kMostFactors ? std::optional(std::move(a)) : std::nullopt;
}

std::optional<Signal> affine(Signal signal, const Vec4f& scale, const Vec4f& bias) {
  if (bias == Vec4f(0) || signal.factors.empty()) {
    signal.constant = signal.constant * scale + bias;
    return signal;
  }
  return folded(std::move(signal), scale, bias);
}

std::optional<Signal> folded(Signal signal, const Vec4f& scale, const Vec4f& bias) {
  if (signal.factors.empty()) return std::nullopt;
  const Vec4f whole = signal.constant * scale;
  Factor& texture = signal.factors.front();
  if (signal.factors.size() != 1 || (texture.output != "rgb" && !(is_grey(whole) && is_grey(bias))))
    return std::nullopt;
  // A number's channel may be the image's alpha.
  const bool is_number = texture.output != "rgb";
  const Vec4f s = is_number ? Vec4f(whole.x) : whole, b = is_number ? Vec4f(bias.x) : bias;
  change(&texture.node, "scale", 1, s, Vec4f(0));
  change(&texture.node, "bias", 0, s, b);
  if (texture.node.parameters.contains("fallback")) change(&texture.node, "fallback", 0, s, b);
  signal.constant = Vec4f(1);
  return signal;
}

std::optional<Signal> mixture(const Signal& a, const Signal& b, const Vec4f& share) {
  const Vec4f rest = Vec4f(1) - share;
  if (share == Vec4f(0)) return a;
  if (share == Vec4f(1)) return b;
  if (a.factors == b.factors) return Signal{a.constant * rest + b.constant * share, a.factors};
  if (!b.is_textured()) return affine(a, rest, b.constant * share);
  if (!a.is_textured()) return affine(b, share, a.constant * rest);
  return std::nullopt;
}

Signal channel_of(Signal signal, int channel) {
  signal.constant = Vec4f(signal.constant[channel]);
  for (Factor& factor : signal.factors)
    if (factor.output == "rgb") factor.output = "rgba"[channel];
  return signal;
}

}  // namespace alabaster::hd::looks
