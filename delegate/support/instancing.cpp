#include "delegate/support/instancing.h"

#include <algorithm>
#include <cstring>
#include <limits>
#include <span>

#include "delegate/support/float_values.h"

namespace alabaster::hd::support {
namespace {

constexpr size_t kMaxInstances = size_t(1) << 27;  // of one prim: beyond it, memory for placements alone exceeds 16 GB
constexpr size_t kMostNested = 100;

// The value of an instance primvar.
using PullPrimvar = std::function<Value(const char* name)>;

template <class T>
Array<T> pull_array(const PullPrimvar& pull, const Path& id, const char* name, const InstancingReport& report) {
  const Value value = FloatValues(pull(name));
  if (const auto* array = value.get<Array<T>>()) return *array;
  if constexpr (std::is_same_v<T, Quatf>)  // real part first
    if (const auto* array = value.get<Array<Vec4f>>()) {
      std::vector<Quatf> quaternions;
      for (const Vec4f& q : *array) quaternions.emplace_back(q.x, q.y, q.z, q.w);
      return quaternions;
    }
  if (!value.empty() && report)
    report("instancer.primvar.type", id, std::string(name) + " has an unexpected type; it is left out");
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

constexpr const char* kPrimvars[] = {"hydra:instanceTranslations", "hydra:instanceScales", "hydra:instanceRotations",
                                     "hydra:instanceTransforms"};

InstancePoints make_points(const PullPrimvar& pull, const Path& instancer, const InstancingReport& report) {
  InstanceArrays arrays{pull_array<Vec3f>(pull, instancer, kPrimvars[0], report),
                        pull_array<Vec3f>(pull, instancer, kPrimvars[1], report),
                        pull_array<Quatf>(pull, instancer, kPrimvars[2], report),
                        pull_array<Matrix4d>(pull, instancer, kPrimvars[3], report)};
  const size_t sizes[] = {arrays.translations.size(), arrays.scales.size(), arrays.rotations.size(),
                          arrays.transforms.size()};
  const size_t count = arrays.size();
  if (count == 0) return nullptr;
  if (report && std::any_of(std::begin(sizes), std::end(sizes), [&](size_t n) { return n != 0 && n != count; }))
    report("instancer.primvar.size", instancer,
           "instance primvars differ in length; beyond the end of a shorter one the identity is used");
  return std::make_shared<const InstanceArrays>(std::move(arrays));
}

// All points from the lowest to the highest that is named are compared, unless that is many more.
bool are_points_alike(const PlacementSource& a, const PlacementSource& b, std::span<const int32_t> named) {
  if (a.points == b.points) return true;
  const auto [lowest, highest] = std::minmax_element(named.begin(), named.end());
  if (named.size() == 1 && !a.has_point(*lowest)) return !b.has_point(*lowest);
  if (!a.has_point(*lowest) || !a.has_point(*highest) || !b.has_point(*highest)) return false;
  const auto begin = static_cast<size_t>(*lowest), end = static_cast<size_t>(*highest) + 1;
  if (end - begin <= 4 * named.size()) return a.points->are_alike(*b.points, begin, end);
  return std::all_of(named.begin(), named.end(), [&](int32_t index) {
    return a.points->are_alike(*b.points, static_cast<size_t>(index), static_cast<size_t>(index) + 1);
  });
}

}  // namespace

size_t InstanceArrays::size() const {
  return std::max({translations.size(), scales.size(), rotations.size(), transforms.size()});
}

bool InstanceArrays::are_alike(const InstanceArrays& other, size_t begin, size_t end) const {
  const auto same = [&](const auto& a, const auto& b) {
    const size_t last = std::min(end, a.size());
    if (last != std::min(end, b.size())) return false;
    return last <= begin || a.data() == b.data() ||
           std::memcmp(a.data() + begin, b.data() + begin, (last - begin) * sizeof *a.data()) == 0;
  };
  return same(translations, other.translations) && same(scales, other.scales) && same(rotations, other.rotations) &&
         same(transforms, other.transforms);
}

// p * M * S * R * T
Matrix4d InstanceArrays::operator[](size_t i) const {
  Matrix4d m;
  if (i < transforms.size()) m = transforms[i];
  if (i < scales.size()) {
    Matrix4d s;
    s.setScale(Vec3d(scales[i]));
    m = m * s;
  }
  if (i < rotations.size()) m = m * rotation_matrix(rotations[i]);
  if (i < translations.size()) {
    Matrix4d t;
    t.setTranslation(Vec3d(translations[i]));
    m = m * t;
  }
  return m;
}

InstancePoints pull_instance_points(SceneDelegate& scene, const Path& instancer, const InstancingReport& report) {
  const auto pull = [&](const char* name) {
    Array<int32_t> unused;
    return scene.GetPrimvar(instancer, name, &unused);
  };
  return make_points(pull, instancer, report);
}

TimeSamples<InstancePoints> pull_moving_points(SceneDelegate& scene, const Path& instancer,
                                               const InstancePoints& points, const InstancingReport& report) {
  std::map<std::string, TimeSamples<Value>> sampled;
  TimeSamples<InstancePoints> moving;
  const auto fail = [&](const char* text) {
    if (report)
      report("motion.instances", instancer, std::string(text) + "; the instances are drawn without motion blur");
    return TimeSamples<InstancePoints>();
  };
  for (const char* name : kPrimvars) {
    TimeSamples<Value> samples = scene.SamplePrimvar(instancer, name);
    if (samples.values.size() < 2) continue;
    if (samples.values.size() != samples.times.size() || (!sampled.empty() && samples.times != moving.times))
      return fail("the samples of instance primvars differ in their times");
    moving.times = samples.times;
    sampled[name] = std::move(samples);
  }
  for (size_t k = 0; k < moving.times.size(); ++k) {
    const auto pull = [&](const char* name) -> Value {
      Array<int32_t> unused;
      const auto found = sampled.find(name);
      return found == sampled.end() ? scene.GetPrimvar(instancer, name, &unused) : found->second.values[k];
    };
    moving.values.push_back(make_points(pull, instancer, {}));
    const InstancePoints& now = moving.values.back();
    if (!points || !now || now->size() != points->size())
      return fail("the samples of instance primvars differ in their length");
  }
  return moving;
}

InstancerRecord pull_instancer(SceneDelegate& scene, const Path& instancer, const InstancingReport& report) {
  InstancerRecord record;
  record.transform = scene.GetInstancerTransform(instancer);
  record.points = pull_instance_points(scene, instancer, report);
  record.parent = scene.GetInstancerId(instancer);
  if (!record.parent.empty()) record.indices_in_parent = scene.GetInstanceIndices(record.parent, instancer);
  return record;
}

void Placements::warn(const char* code, const Path& where, const std::string& text) const {
  if (report_) report_(code, where, text);
}

namespace {

std::vector<Placement> placed(const PlacementSource& all) {
  std::vector<Placement> placements;
  placements.reserve(all.size());
  for (size_t i = 0; i < all.size(); ++i) placements.push_back(all[i]);
  return placements;
}

}  // namespace

// An instancer stands once where it has no parent. Its own transform comes before that.
std::shared_ptr<const std::vector<Placement>> Placements::bases(const Path& instancer, const InstancerRecord& record) {
  if (const auto known = bases_.find(instancer); known != bases_.end()) return known->second;
  struct Held {
    std::shared_ptr<const void> memory;
    std::vector<Placement> places;
  };
  const auto held = std::make_shared<Held>();
  if (record.parent.empty()) {
    held->places.emplace_back();
  } else if (visiting_.size() == kMostNested) {
    warn("instancer.depth", instancer,
         "instancers are nested deeper than 100; the prims that they place are not drawn");
  } else if (visiting_.insert(instancer).second) {
    const std::shared_ptr<void> leaves(nullptr, [&](void*) { visiting_.erase(instancer); });
    const PlacementSource all = source(instancer, record.parent, record.indices_in_parent);
    if (hold_) held->memory = hold_(all.size(), instancer);
    held->places = placed(all);
  } else {
    warn("instancer.cycle", instancer, "instancers contain each other; the prims that they place are not drawn");
  }
  for (Placement& base : held->places) base.matrix = record.transform * base.matrix;
  const std::shared_ptr<const std::vector<Placement>> bases(held, &held->places);
  return bases_.emplace(instancer, bases).first->second;
}

// point * instancer * outer, for each outer placement and, fastest, each index.
PlacementSource Placements::source(const Path& prototype, const Path& instancer, const Array<int32_t>& indices) {
  const InstancerRecord* record = find_(instancer);
  if (!record) {
    warn("instancer.missing", prototype, "instancer " + instancer.str() + " does not exist; the prim is not drawn");
    return {};
  }
  PlacementSource source{record->points, indices, bases(instancer, *record)};
  if (!indices.empty() && source.bases->size() > kMaxInstances / indices.size()) throw TooManyInstances(prototype);
  const size_t points = record->points ? record->points->size() : std::numeric_limits<size_t>::max();
  const bool dropped = std::any_of(indices.begin(), indices.end(), [points](int32_t index) {
    return index < 0 || static_cast<size_t>(index) >= points;
  });
  if (dropped && !source.bases->empty())
    warn("instancer.index", prototype,
         "some instance indices name no point of " + instancer.str() + "; those instances are left out");
  return source;
}

std::vector<Placement> Placements::place(const Path& prototype, const Path& instancer, const Array<int32_t>& indices) {
  const PlacementSource all = source(prototype, instancer, indices);
  const std::shared_ptr<const void> memory = hold_ ? hold_(all.size(), prototype) : nullptr;
  return placed(all);
}

bool PlacementSource::has_point(int32_t index) const {
  return index >= 0 && (!points || static_cast<size_t>(index) < points->size());
}

Placement PlacementSource::operator[](size_t i) const {
  const Placement& base = (*bases)[i / indices.size()];
  const int32_t index = indices[i % indices.size()];
  if (!has_point(index)) return {base.matrix, false};
  return {points ? (*points)[static_cast<size_t>(index)] * base.matrix : base.matrix, base.used};
}

bool PlacementSource::stand_alike(const PlacementSource& other, size_t begin, size_t end) const {
  if (bases->size() != other.bases->size() || !points != !other.points) return false;
  if (bases->size() > 1 && indices.size() != other.indices.size()) return false;
  for (size_t base = begin / indices.size(); begin < end; ++base) {
    const size_t first = begin % indices.size(), count = std::min(end - begin, indices.size() - first);
    const Placement &own = (*bases)[base], &theirs = (*other.bases)[base];
    if (own.matrix != theirs.matrix || own.used != theirs.used) return false;
    const std::span<const int32_t> named(indices.data() + first, count);
    const int32_t* const others = other.indices.data() + first;
    if (named.data() != others && std::memcmp(named.data(), others, named.size_bytes()) != 0) return false;
    if (!are_points_alike(*this, other, named)) return false;
    begin += count;
  }
  return true;
}

}  // namespace alabaster::hd::support
