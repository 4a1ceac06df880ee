#include <algorithm>

#include "delegate/prims/prims.h"

namespace alabaster::hd::sync {
namespace {

struct InstancePrimvars {
  Array<Vec3f> translations, scales;
  Array<Quatf> rotations;
  Array<Matrix4d> transforms;
};

template <class T>
Array<T> pull_array(SceneDelegate& scene, const Path& id, const char* name, const alabaster::DiagnosticSink& sink) {
  Array<int32_t> unused;
  const Value value = scene.GetPrimvar(id, name, &unused);
  if (const auto* array = value.get<Array<T>>()) return *array;
  if constexpr (std::is_same_v<T, Quatf>)  // real part first
    if (const auto* array = value.get<Array<Vec4f>>()) {
      std::vector<Quatf> quaternions;
      for (const Vec4f& q : *array) quaternions.emplace_back(q.x, q.y, q.z, q.w);
      return quaternions;
    }
  if (!value.empty())
    alabaster::report(sink, alabaster::Severity::warning, "instancer.primvar.type", id.str(),
                      std::string(name) + " has an unexpected type; it is left out");
  return {};
}

// In double: a unit quaternion rounded to float is not quite a rotation.
Matrix4d rotation_matrix(const Quatf& rotation) {
  Imath::Quatd q(static_cast<double>(rotation.r), Vec3d(rotation.v));
  const double norm = q.length();
  if (!(norm > 0)) return {};
  q /= norm;
  return q.toMatrix44();  // Imath's is for row vectors
}

// p * M * S * R * T
Matrix4d point_matrix(const InstancePrimvars& primvars, size_t i) {
  Matrix4d m;
  if (i < primvars.transforms.size()) m = primvars.transforms[i];
  if (i < primvars.scales.size()) {
    Matrix4d s;
    s.setScale(Vec3d(primvars.scales[i]));
    m = m * s;
  }
  if (i < primvars.rotations.size()) m = m * rotation_matrix(primvars.rotations[i]);
  if (i < primvars.translations.size()) {
    Matrix4d t;
    t.setTranslation(Vec3d(primvars.translations[i]));
    m = m * t;
  }
  return m;
}

std::shared_ptr<const std::vector<Matrix4d>> pull_points(SceneDelegate& scene, const Path& id,
                                                         const alabaster::DiagnosticSink& sink) {
  const InstancePrimvars primvars{pull_array<Vec3f>(scene, id, "hydra:instanceTranslations", sink),
                                  pull_array<Vec3f>(scene, id, "hydra:instanceScales", sink),
                                  pull_array<Quatf>(scene, id, "hydra:instanceRotations", sink),
                                  pull_array<Matrix4d>(scene, id, "hydra:instanceTransforms", sink)};
  const size_t sizes[] = {primvars.translations.size(), primvars.scales.size(), primvars.rotations.size(),
                          primvars.transforms.size()};
  const size_t count = *std::max_element(std::begin(sizes), std::end(sizes));
  if (count == 0) return nullptr;
  if (std::any_of(std::begin(sizes), std::end(sizes), [&](size_t n) { return n != 0 && n != count; }))
    alabaster::report(sink, alabaster::Severity::warning, "instancer.primvar.size", id.str(),
                      "instance primvars differ in length; what is missing counts as identity");
  auto points = std::make_shared<std::vector<Matrix4d>>();
  points->reserve(count);
  for (size_t i = 0; i < count; ++i) points->push_back(point_matrix(primvars, i));
  return points;
}

}  // namespace

void InstancerPrim::Sync(SceneDelegate* scene, RenderParam* render_param, DirtyBits* bits) {
  SceneParam& param = SceneParam::of(render_param);
  const bool synced = guarded(param.sink(), GetId().str(), [&] {
    if (*bits & dirty::kTransform) record_.transform = scene->GetInstancerTransform(GetId());
    if (*bits & dirty::kPrimvar) {
      auto points = pull_points(*scene, GetId(), param.sink());
      const bool same = points && record_.points ? *points == *record_.points : points == record_.points;
      if (!same) record_.points = std::move(points);
    }
    if (*bits & dirty::kInstancer) record_.parent = scene->GetInstancerId(GetId());
    if (*bits & (dirty::kInstancer | dirty::kInstanceIndex))
      record_.indices_in_parent =
          record_.parent.empty() ? Array<int32_t>() : scene->GetInstanceIndices(record_.parent, GetId());
    param.post(GetId(), record_);
  });
  if (synced) *bits = dirty::kClean;
}

void InstancerPrim::Finalize(RenderParam* param) {
  SceneParam::of(param).remove(GetId());
}

}  // namespace alabaster::hd::sync
