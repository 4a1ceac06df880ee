#include "delegate/description/apply_motion.h"

#include <set>

#include "core/math/motion.h"
#include "delegate/description/placement.h"

namespace alabaster::hd::description {
namespace {

// own(t) * inverse(motion(0)) * motion(t), at the times of both and as many between as they turn.
template <class T>
void move(const Path& path, T prim, const TimeSamples<Matrix4d>& motion, host::RetainedSceneDelegate* scene) {
  const TimeSamples<Matrix4d> own =
      prim.transformSamples.values.empty() ? TimeSamples<Matrix4d>{{0}, {prim.transform}} : prim.transformSamples;
  const Matrix4d back = transform_at(motion, 0).inverse();
  std::set<double> times;
  for (const TimeSamples<Matrix4d>& one : {motion, own}) {
    const std::vector<double> turns = times_of_turns({one.times, one.values});
    times.insert(turns.begin(), turns.end());
  }
  prim.transformSamples = {};
  for (const double time : times) {
    prim.transformSamples.times.push_back(time);
    prim.transformSamples.values.push_back(transform_at(own, time) * back * transform_at(motion, time));
  }
  scene->Set(path, std::move(prim));
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

void move_prims(const std::vector<Path>& prims, const TimeSamples<Matrix4d>& motion,
                host::RetainedSceneDelegate* scene) {
  std::set<Path> instancers;
  for (const Path& path : prims) {
    if (const auto* camera = host::FindPrim<host::CameraDescription>(scene->GetPrims(), path))
      move(path, *camera, motion, scene);
    const auto* mesh = host::FindPrim<host::MeshDescription>(scene->GetPrims(), path);
    if (mesh && mesh->instancer.empty()) move(path, *mesh, motion, scene);
    if (mesh && !mesh->instancer.empty()) instancers.insert(mesh->instancer);
  }
  for (const Path& path : instancers) move(path, scene->GetInstancers().at(path), motion, scene);
}

}  // namespace alabaster::hd::description
