#include "delegate/description/places.h"

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

Matrix4d transform_at(const TimeSamples<Matrix4d>& samples, double time) {
  return interpolate(alabaster::TimeSamples<Matrix4d>{samples.times, samples.values}, time);
}

Matrix4d transform_of(LoadState& load, const std::string& pointer, const nlohmann::json& value) {
  const auto transform = to_transform(value);
  if (!transform)
    load.fail(pointer,
              "The transform cannot be inverted or is not affine: the last column must be 0, 0, 0, 1, and no scale may "
              "be 0.");
  return *transform;
}

}  // namespace

TimeSamples<Matrix4d> to_motion(LoadState& load, const std::string& pointer, const nlohmann::json& motion) {
  TimeSamples<Matrix4d> samples;
  for (size_t i = 0; i < motion.size(); ++i) {
    const std::string place = pointer + "/" + std::to_string(i);
    const double time = motion[i]["time"];
    if (!samples.times.empty() && !(time > samples.times.back()))
      load.fail(place + "/time", "Times must increase from one sample to the next.");
    samples.times.push_back(time);
    samples.values.push_back(transform_of(load, place + "/transform", motion[i]["transform"]));
  }
  return samples;
}

Matrix4d aimed_at(LoadState& load, const std::string& pointer, const Vec3d& eye, const Vec3d& target,
                  const nlohmann::json* up) {
  const auto aimed = look_at(eye, target, up ? to_vec3d(*up) : up_vector(load.result->info.up), !up);
  if (!aimed)
    load.fail(pointer,
              "It has no direction: its place and its target coincide, or up lies along the line between them.");
  return *aimed;
}

Placement placement_of(LoadState& load, const std::string& pointer, const nlohmann::json& entry) {
  std::string given;
  for (const char* key : kPlacements) {
    if (!entry.contains(key)) continue;
    if (!given.empty()) load.fail(pointer, "Give either a " + given + " or a " + key + ", not both.");
    given = key;
  }
  Placement placement;
  if (given.empty()) return placement;
  const nlohmann::json& place = entry[given];
  const std::string at = pointer + "/" + given;
  if (given == "transform") {
    placement.transform = transform_of(load, at, place);
  } else if (given == "motion") {
    placement.motion = to_motion(load, at, place);
    placement.transform = transform_at(placement.motion, 0);
  } else {
    const Vec3d eye = to_vec3d(place["eye"]), target = to_vec3d(place["target"]);
    placement.transform = aimed_at(load, at, eye, target, place.contains("up") ? &place["up"] : nullptr);
    placement.target_distance = (target - eye).length();
  }
  return placement;
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
