#include "delegate/gltf/gltf_motion.h"

#include <algorithm>

namespace alabaster::hd::gltf {
namespace {

class MotionSampler {
 public:
  MotionSampler(const GltfOptions& options, GltfPrims* prims) : options_(options), prims_(*prims) {}

  void run(const std::function<GltfPrims(double)>& pose_at, Report& report) {
    for (int i = 0; i < kShutterSamples; ++i) {
      const double open = options_.shutter_open, length = options_.shutter_close - open;
      const double seconds = open + length * i / (kShutterSamples - 1);
      frames_.push_back(seconds * options_.frames_per_second);
      poses_.push_back(pose_at(seconds));
    }
    for (auto& [id, mesh] : prims_.meshes) {
      sample_transform(id, &GltfPrims::meshes, &mesh, report);
      for (const char* name : {"points", "normals"}) sample_primvar(id, name, &mesh);
    }
    for (auto& [id, camera] : prims_.cameras) sample_transform(id, &GltfPrims::cameras, &camera, report);
    for (auto& [id, instancer] : prims_.instancers) sample_instances(id, &instancer, report);
  }

 private:
  template <class T>
  void sample_transform(const Path& id, std::map<Path, T> GltfPrims::*all, T* prim, Report& report) const {
    TimeSamples<Matrix4d> samples{frames_, {}};
    for (const GltfPrims& pose : poses_) {
      const auto found = (pose.*all).find(id);
      if (found == (pose.*all).end() || !is_placed_alike(found->second, *prim)) return warn(id, report);
      samples.values.push_back(found->second.transform);
    }
    if (changes(samples)) prim->transformSamples = std::move(samples);
  }

  void sample_primvar(const Path& id, const char* name, host::MeshDescription* mesh) const {
    if (!mesh->primvars.contains(name)) return;
    TimeSamples<Value> samples{frames_, {}};
    for (const GltfPrims& pose : poses_) {
      const auto found = pose.meshes.find(id);
      if (found == pose.meshes.end() || !is_placed_alike(found->second, *mesh)) return;
      if (!(found->second.topology == mesh->topology)) return;
      samples.values.push_back(found->second.primvars.at(name).value);
    }
    if (changes(samples)) mesh->primvarSamples[name] = std::move(samples);
  }

  // A mesh may be placed by several nodes, each of which moves by itself.
  void sample_instances(const Path& id, host::InstancerDescription* instancer, Report& report) const {
    const Token name = "hydra:instanceTransforms";
    TimeSamples<Value> samples{frames_, {}};
    for (const GltfPrims& pose : poses_) {
      const auto found = pose.instancers.find(id);
      if (found == pose.instancers.end()) return warn(id, report);
      samples.values.push_back(found->second.primvars.at(name));
    }
    if (changes(samples)) instancer->primvarSamples[name] = std::move(samples);
  }

  // Nodes whose morph weights are equal at one time share a mesh there, which an instancer places.
  static bool is_placed_alike(const host::MeshDescription& a, const host::MeshDescription& b) {
    return a.instancer == b.instancer;
  }
  static bool is_placed_alike(const host::CameraDescription&, const host::CameraDescription&) { return true; }

  static void warn(const Path& id, Report& report) {
    report.warning("motion", id.str(),
                   "is not there, or not by itself, at all times of the shutter; it is drawn without motion blur");
  }

  template <class T>
  static bool changes(const TimeSamples<T>& samples) {
    return std::any_of(samples.values.begin(), samples.values.end(),
                       [&](const T& value) { return !(value == samples.values.front()); });
  }

  const GltfOptions& options_;
  GltfPrims& prims_;
  std::vector<double> frames_;
  std::vector<GltfPrims> poses_;
};

}  // namespace

void sample_motion(const GltfOptions& options, const std::function<GltfPrims(double)>& pose_at, GltfPrims* prims,
                   Report& report) {
  MotionSampler(options, prims).run(pose_at, report);
}

}  // namespace alabaster::hd::gltf
