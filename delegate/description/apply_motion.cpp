#include "delegate/description/apply_motion.h"

#include <set>

#include "core/math/motion.h"
#include "delegate/description/placement.h"

namespace alabaster::hd::description {
namespace {

/// Calls visit(prim) unless an instancer places it.
template <class Visit>
void visit_placed(host::PrimDescription* prim, const Visit& visit) {
  const auto by_itself = [&visit](auto& one) {
    if constexpr (requires { one.instancer; })
      if (!one.instancer.empty()) return;
    if constexpr (requires { one.parent; })
      if (!one.parent.empty()) return;
    visit(one);
  };
  std::visit(by_itself, *prim);
}

}  // namespace

Matrix4d transform_at(const TimeSamples<Matrix4d>& samples, double time) {
  return interpolate(alabaster::TimeSamples<Matrix4d>{samples.times, samples.values}, time);
}

TimeSamples<Matrix4d> to_motion(LoadState& load, const std::string& pointer, const nlohmann::json& motion) {
  TimeSamples<Matrix4d> samples;
  for (size_t i = 0; i < motion.size(); ++i) {
    const std::string place = pointer + "/" + std::to_string(i);
    const double time = motion[i]["time"];
    const auto transform = to_transform(motion[i]["transform"]);
    if (!transform) load.fail(place + "/transform", "The transform cannot be inverted or is not affine.");
    if (!samples.times.empty() && !(time > samples.times.back()))
      load.fail(place + "/time", "Times must increase from one sample to the next.");
    samples.times.push_back(time);
    samples.values.push_back(*transform);
  }
  return samples;
}

void place_prim(const Matrix4d& transform, host::PrimDescription* prim) {
  visit_placed(prim, [&](auto& one) {
    if constexpr (requires { one.transform; }) one.transform = one.transform * transform;
    if constexpr (requires { one.transformSamples; })
      for (Matrix4d& sample : one.transformSamples.values) sample = sample * transform;
  });
}

// own(t) * inverse(motion(0)) * motion(t), at the times of both and as many between as they turn.
void move_prim(const TimeSamples<Matrix4d>& motion, host::PrimDescription* prim) {
  visit_placed(prim, [&](auto& one) {
    if constexpr (requires { one.transformSamples; }) {
      const TimeSamples<Matrix4d> own =
          one.transformSamples.values.empty() ? TimeSamples<Matrix4d>{{0}, {one.transform}} : one.transformSamples;
      const Matrix4d back = transform_at(motion, 0).inverse();
      std::set<double> times;
      for (const TimeSamples<Matrix4d>& joined : {motion, own}) {
        const std::vector<double> turns = times_of_turns({joined.times, joined.values});
        times.insert(turns.begin(), turns.end());
      }
      one.transformSamples = {};
      for (const double time : times) {
        one.transformSamples.times.push_back(time);
        one.transformSamples.values.push_back(transform_at(own, time) * back * transform_at(motion, time));
      }
    }
  });
}

}  // namespace alabaster::hd::description
