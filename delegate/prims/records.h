// What prims post to the renderer: immutable values, keyed by prim path. Other prims appear as paths only.
#pragma once

#include <variant>

#include "core/camera/camera.h"
#include "core/scene/scene.h"
#include "delegate/api/scene_types.h"

namespace alabaster::hd::sync {

struct MeshRecord {
  std::shared_ptr<const MeshPrototype> prototype;  // null: nothing to draw
  Matrix4d transform;
  bool visible = true;
  int32_t prim_id = 0;
  std::vector<Path> materials{Path()};  // by slot: the prim's, then those of its subsets; empty path: default
  Path instancer;
  Array<int32_t> instance_indices;
  std::string subsurface_set;  // empty: each object scatters for itself
  bool operator==(const MeshRecord&) const = default;
};

struct InstancerRecord {
  Matrix4d transform;
  std::shared_ptr<const std::vector<Matrix4d>> points;  // M * S * R * T of each; null: identity for any index
  Path parent;
  Array<int32_t> indices_in_parent;
  bool operator==(const InstancerRecord&) const = default;
};

struct MaterialRecord {
  std::shared_ptr<const DisneyMaterial> material;
  bool operator==(const MaterialRecord&) const = default;
};

struct LightRecord {
  alabaster::LightDescription light;
  bool operator==(const LightRecord&) const = default;
};

struct CameraRecord {
  CameraParameters camera;
  bool operator==(const CameraRecord&) const = default;
};

struct SettingsRecord {
  RenderSettingsDescription settings;
  bool operator==(const SettingsRecord&) const = default;
};

using Record = std::variant<std::monostate, MeshRecord, InstancerRecord, MaterialRecord, LightRecord, CameraRecord,
                            SettingsRecord>;
using Records = std::map<Path, Record>;

/// False for cameras and settings: a render compares those when it starts.
inline bool is_drawn(const Record& record) {
  return !std::holds_alternative<CameraRecord>(record) && !std::holds_alternative<SettingsRecord>(record);
}

}  // namespace alabaster::hd::sync
