// The points of instancers and the places where nested instancers put a prototype. Drawing and automatic framing share
// them, so that the frame encloses the instances that are drawn.
#pragma once

#include <functional>
#include <set>
#include <stdexcept>

#include "delegate/api/scene_delegate.h"

namespace alabaster::hd::support {

/// Receives each warning: its code, the prim and the text. Empty: warnings are dropped.
using InstancingReport = std::function<void(const char* code, const Path& where, const std::string& text)>;

/// An instancer's points, in the host's own arrays. Point i is M_i S_i R_i T_i for row vectors; an array that is
/// shorter than the longest counts as identity beyond its end, and so does a rotation of length zero.
struct InstanceArrays {
  Array<Vec3f> translations, scales;
  Array<Quatf> rotations;  // normalised where they are used
  Array<Matrix4d> transforms;

  size_t size() const;
  Matrix4d operator[](size_t i) const;
  /// True if points [begin, end) are the same bytes in another.
  bool are_alike(const InstanceArrays& other, size_t begin, size_t end) const;
};
/// Null stands for identity at any index.
using InstancePoints = std::shared_ptr<const InstanceArrays>;

/// The values that an instancer has pulled.
struct InstancerRecord {
  Matrix4d transform;
  TimeSamples<Matrix4d> motion;               // of the transform; empty: stands still
  TimeSamples<InstancePoints> moving_points;  // as many at each time as `points`; empty: they stand still
  InstancePoints points;
  Path parent;                                                        // empty: none
  Array<int32_t> indices_in_parent;                                   // this instancer's points in its parent
  std::shared_ptr<const std::vector<std::vector<Token>>> categories;  // by point; null: none
  bool operator==(const InstancerRecord&) const = default;
};

/// Pulls hydra:instanceTransforms M, ...Scales S, ...Rotations R and ...Translations T, without a copy.
InstancePoints pull_instance_points(SceneDelegate& scene, const Path& instancer, const InstancingReport& report);

/// The same at the times of the samples, which those of several primvars must share. Empty: no point moves, or the
/// samples are faulty (reported).
TimeSamples<InstancePoints> pull_moving_points(SceneDelegate& scene, const Path& instancer,
                                               const InstancePoints& points, const InstancingReport& report);

/// Pulls everything about one instancer but for its motion.
InstancerRecord pull_instancer(SceneDelegate& scene, const Path& instancer, const InstancingReport& report);

/// One instance: prototype point * matrix = world point.
struct Placement {
  Matrix4d matrix;
  bool used = true;  // false where an index names no point of its instancer
};

/// The instances of a prototype as its instancer has them: number i is point indices[i % n] at bases[i / n].
struct PlacementSource {
  InstancePoints points;
  Array<int32_t> indices;
  std::shared_ptr<const std::vector<Placement>> bases;  // of the instancer itself; null: none

  size_t size() const { return bases ? bases->size() * indices.size() : 0; }
  bool has_point(int32_t index) const;
  Placement operator[](size_t i) const;
  /// True if those in [begin, end), which both have, are the same in another. For one of them the answer is exact; for
  /// more, false may also mean not known.
  bool stand_alike(const PlacementSource& other, size_t begin, size_t end) const;
};

/// Called before so many placements of a prim are made: they are counted as long as the answer lives. It may throw.
using HoldPlacements = std::function<std::shared_ptr<const void>(size_t count, const Path& prototype)>;

/// One prim stands in more than 2^27 places.
struct TooManyInstances : std::runtime_error {
  explicit TooManyInstances(const Path& prototype)
      : std::runtime_error("more than 2^27 instances of " + prototype.str() +
                           "; place fewer, or render parts of the scene") {}
};

/// Places prototypes. Remembers where instancers themselves stand, since many prototypes share them.
class Placements {
 public:
  /// `find` answers with an instancer's record, or null; records must outlive this object. `hold` (may be empty) counts
  /// the places that are remembered, and the others while they are made.
  Placements(std::function<const InstancerRecord*(const Path&)> find, InstancingReport report, HoldPlacements hold = {})
      : find_(std::move(find)), report_(std::move(report)), hold_(std::move(hold)) {}

  /// The instances of `prototype`, which `instancer` places at `indices`: the innermost index runs fastest. Empty and
  /// reported if the instancer does not exist, or if instancers contain each other or a hundred others. Throws what
  /// `hold` does, and TooManyInstances.
  std::vector<Placement> place(const Path& prototype, const Path& instancer, const Array<int32_t>& indices);
  /// The same, not yet placed.
  PlacementSource source(const Path& prototype, const Path& instancer, const Array<int32_t>& indices);

 private:
  std::shared_ptr<const std::vector<Placement>> bases(const Path& instancer, const InstancerRecord& record);
  void warn(const char* code, const Path& where, const std::string& text) const;

  std::function<const InstancerRecord*(const Path&)> find_;
  InstancingReport report_;
  HoldPlacements hold_;
  std::map<Path, std::shared_ptr<const std::vector<Placement>>> bases_;  // where each instancer stands
  std::set<Path> visiting_;
};

}  // namespace alabaster::hd::support
