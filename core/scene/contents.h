// What stands in bodies that light walks in behind clear walls.
#pragma once

#include <optional>
#include <vector>

#include "core/geometry/box_tree.h"
#include "core/scene/scene.h"
#include "core/subsurface/body.h"

namespace alabaster {

/// True if light walks in it behind a clear wall: its walks end at the walls of what stands in it.
bool is_cloudy(const InstanceDescription& instance);
/// True if light walks below some faces alone: the others are walls of its body.
bool has_opaque_faces(const InstanceDescription& instance);
/// True if all its faces are opaque: a wall within what others of its set light walks in.
bool is_opaque_everywhere(const InstanceDescription& instance);

/// By bounding boxes over the whole shutter, so a needle counts; of what stands still and has not too many faces, those
/// that a proof shows to be apart do not. One that is outside all the same costs time and no light. Built when it is
/// first asked.
class ContentFinder {
 public:
  ContentFinder(const SceneSnapshot& snapshot, const CancelToken& cancel) : snapshot_(snapshot), cancel_(cancel) {}

  struct Contents {
    std::vector<uint32_t> alone;               // instances, increasing
    std::vector<const InstanceArray*> arrays;  // in their order
    std::vector<Bounds> lights;                // the boxes of lights that are no meshes
  };
  /// In the closed body of these instances (increasing), which stand alone.
  Contents find(const std::vector<uint32_t>& members);

 private:
  void build();
  bool are_apart(const Instance& body, const Instance& other);

  const SceneSnapshot& snapshot_;
  const CancelToken cancel_;
  std::optional<BoxTree> boxes_;  // of instances that stand alone, then of arrays, in render space
  std::vector<uint32_t> of_box_;  // their numbers
  size_t faces_seen_ = 0;         // by proofs
};

/// What stands in bodies of an array, in world space: before it is decided which arrays stay such.
class ArrayNeighbours {
 public:
  explicit ArrayNeighbours(const SceneDescription& description) : description_(description) {}
  /// True if the box of another instance or of a light meets that of one of the array. Bodies of the array that overlap
  /// are of one medium.
  bool any_in(const InstanceArrayDescription& array, const CancelToken& cancel);

 private:
  const SceneDescription& description_;
  std::optional<BoxTree> boxes_;
  std::vector<const InstanceArrayDescription*> arrays_;  // by box; null: one instance
};

/// Sets the distances to contents, which are placed in the body's space as it traces them. False: they cannot be
/// bounded, and no sphere steps are taken.
bool bound_contents(const ContentFinder::Contents& contents, const SceneSnapshot& snapshot, const CancelToken& cancel,
                    SubsurfaceBody* body);

}  // namespace alabaster
