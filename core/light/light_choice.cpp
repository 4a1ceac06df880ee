#include "core/light/light_choice.h"

namespace alabaster {
namespace {

constexpr double kUniformShare = 0.1;
}  // namespace

LightChoice::LightChoice(const std::vector<Light>& lights, const std::vector<LobeScales>& scales, const Vec3f& p)
    : lights_(lights), scales_(scales), p_(p) {
  if (lights_.size() == 1) return;
  for (size_t i = 0; i < lights_.size(); ++i) {
    const double weight = importance(i);
    if (i < kKept) kept_[i] = weight;
    total_ += weight;
    shining_ += weight > 0 ? 1 : 0;
  }
}

double LightChoice::importance(size_t i) const {
  if (is_constant_dome(lights_[i])) return 0;
  const double weight = std::visit([&](const auto& light) { return light.importance(p_); }, lights_[i]);
  return scales_.empty() ? weight : weight * scales_[i].mean();
}

// Each light's range follows the one before.
void LightChoice::advance() {
  Cursor& c = cursor_;
  const size_t i = c.next++;
  c.begin = c.end;
  if (lights_.size() == 1) {
    c.end = kChoiceSteps;
    return;
  }
  const double weight = i < kKept ? kept_[i] : importance(i);
  if (!(weight > 0)) return;
  c.running += weight;
  ++c.shining;
  const double until = (1 - kUniformShare) * (c.running / total_) +
                       kUniformShare * (static_cast<double>(c.shining) / static_cast<double>(shining_));
  c.end =
      c.shining == shining_ ? kChoiceSteps : std::min(kChoiceSteps, static_cast<uint32_t>(until * kChoiceSteps + 0.5));
}

float LightChoice::probability_of_current() const {
  return static_cast<float>(cursor_.end - cursor_.begin) / static_cast<float>(kChoiceSteps);
}

float LightChoice::probability(size_t i) {
  if (i + 1 < cursor_.next) cursor_ = {};
  while (cursor_.next <= i) advance();
  return probability_of_current();
}

std::optional<LightChoice::Chosen> LightChoice::choose(float u) {
  const auto step = static_cast<uint32_t>(std::clamp(u, 0.0f, kOneMinusEpsilon) * static_cast<float>(kChoiceSteps));
  while (cursor_.next < lights_.size()) {
    advance();
    if (step < cursor_.end) return Chosen{cursor_.next - 1, probability_of_current()};
  }
  return std::nullopt;
}

}  // namespace alabaster
