#include "core/light/light_choice.h"

namespace alabaster {
namespace {

constexpr double kUniformShare = 0.1;
constexpr uint32_t kSteps = uint32_t(1) << 24;

}  // namespace

LightChoice::LightChoice(const std::vector<Light>& lights, const Vec3f& p) : lights_(lights), p_(p) {
  if (lights_.size() == 1) return;
  for (size_t i = 0; i < lights_.size(); ++i) {
    const double weight = importance(i);
    if (i < kKept) kept_[i] = weight;
    total_ += weight;
    shining_ += weight > 0 ? 1 : 0;
  }
}

double LightChoice::importance(size_t i) const {
  return std::visit([&](const auto& light) { return light.importance(p_); }, lights_[i]);
}

// To the next light: its range follows the one before.
void LightChoice::advance() {
  const size_t i = next_++;
  begin_ = end_;
  if (lights_.size() == 1) {
    end_ = kSteps;
    return;
  }
  const double weight = i < kKept ? kept_[i] : importance(i);
  if (!(weight > 0)) return;
  running_ += weight;
  ++shone_;
  const double until = (1 - kUniformShare) * (running_ / total_) +
                       kUniformShare * (static_cast<double>(shone_) / static_cast<double>(shining_));
  end_ = shone_ == shining_ ? kSteps : std::min(kSteps, static_cast<uint32_t>(until * kSteps + 0.5));
}

float LightChoice::probability(size_t i) {
  while (next_ <= i) advance();
  return static_cast<float>(end_ - begin_) / static_cast<float>(kSteps);
}

std::optional<LightChoice::Chosen> LightChoice::choose(float u) {
  const auto step = static_cast<uint32_t>(std::clamp(u, 0.0f, kOneMinusEpsilon) * static_cast<float>(kSteps));
  while (next_ < lights_.size()) {
    advance();
    if (step < end_) return Chosen{next_ - 1, static_cast<float>(end_ - begin_) / static_cast<float>(kSteps)};
  }
  return std::nullopt;
}

}  // namespace alabaster
