#include "delegate/gltf/gltf_animation.h"

#include <algorithm>
#include <cmath>

namespace alabaster::hd::gltf {
namespace {

void normalize(std::vector<double>* v) {
  double length2 = 0;
  for (const double x : *v) length2 += x * x;
  for (double& x : *v) x = length2 > 0 ? x / std::sqrt(length2) : 0;
}

// Appendix C.4; nearly equal quaternions are interpolated linearly.
std::vector<double> slerp(std::vector<double> a, std::vector<double> b, double u) {
  normalize(&a);
  normalize(&b);
  double cosine = 0;
  for (size_t i = 0; i < 4; ++i) cosine += a[i] * b[i];
  const double sign = cosine < 0 ? -1 : 1, angle = std::acos(std::min(std::abs(cosine), 1.0)), sine = std::sin(angle);
  const double wa = sine > 1e-6 ? std::sin((1 - u) * angle) / sine : 1 - u;
  const double wb = (sine > 1e-6 ? std::sin(u * angle) / sine : u) * sign;
  for (size_t i = 0; i < 4; ++i) a[i] = wa * a[i] + wb * b[i];
  normalize(&a);
  return a;
}

// Appendix C.5: cubic Hermite splines, whose tangents are per second.
std::vector<double> spline(const AnimationCurve& curve, size_t key, double u, double step) {
  const size_t n = curve.components;
  const float *left = &curve.values[3 * key * n], *right = left + 3 * n;
  const double u2 = u * u, u3 = u2 * u;
  std::vector<double> value(n);
  for (size_t i = 0; i < n; ++i)
    value[i] = (2 * u3 - 3 * u2 + 1) * double(left[n + i]) + step * (u3 - 2 * u2 + u) * double(left[2 * n + i]) +
               (3 * u2 - 2 * u3) * double(right[n + i]) + step * (u3 - u2) * double(right[i]);
  if (curve.rotation) normalize(&value);
  return value;
}

}  // namespace

std::vector<double> sample(const AnimationCurve& curve, double time) {
  const bool cubic = curve.interpolation == "CUBICSPLINE";
  const auto value_at = [&](size_t key) {
    const float* first = &curve.values[(cubic ? 3 * key + 1 : key) * curve.components];
    return std::vector<double>(first, first + curve.components);
  };
  const auto next = std::upper_bound(curve.times.begin(), curve.times.end(), time,
                                     [](double t, float key) { return t < double(key); });
  if (next == curve.times.begin()) return value_at(0);
  const auto key = size_t(next - curve.times.begin()) - 1;
  if (next == curve.times.end() || curve.interpolation == "STEP") return value_at(key);
  const double step = double(curve.times[key + 1]) - double(curve.times[key]);
  const double u = (time - double(curve.times[key])) / step;
  if (cubic) return spline(curve, key, u, step);
  std::vector<double> a = value_at(key);
  const std::vector<double> b = value_at(key + 1);
  if (curve.rotation) return slerp(std::move(a), b, u);
  for (size_t i = 0; i < a.size(); ++i) a[i] += u * (b[i] - a[i]);
  return a;
}

NodeAnimation::NodeAnimation(const Document& document) {
  if (document.animation < 0) return;
  const tinygltf::Animation& animation = document.model.animations[0];
  const auto values_of = [&](int accessor) -> const std::vector<float>& {
    const auto [found, is_new] = values_.try_emplace(accessor);
    if (is_new) found->second = read_floats(document.accessors[size_t(accessor)]);
    return found->second;
  };
  for (const tinygltf::AnimationChannel& channel : animation.channels) {
    const tinygltf::AnimationSampler& sampler = animation.samplers[size_t(channel.sampler)];
    AnimationCurve curve{sampler.interpolation, values_of(sampler.input), values_of(sampler.output)};
    curve.rotation = channel.target_path == "rotation";
    curve.components = curve.values.size() / (curve.times.size() * (curve.interpolation == "CUBICSPLINE" ? 3 : 1));
    channels_.push_back({size_t(channel.target_node), channel.target_path, std::move(curve)});
  }
}

void NodeAnimation::apply(double seconds, tinygltf::Model* model) const {
  for (const Channel& channel : channels_) {
    tinygltf::Node& node = model->nodes[channel.node];
    std::vector<double>& moved = channel.path == "translation" ? node.translation
                                 : channel.path == "scale"     ? node.scale
                                 : channel.path == "rotation"  ? node.rotation
                                                               : node.weights;
    moved = sample(channel.curve, seconds);
  }
}

}  // namespace alabaster::hd::gltf
