// Records: the immutable values that prims post to the renderer, keyed by prim path. A record names other prims by
// path.
#pragma once

#include <any>
#include <array>
#include <map>
#include <optional>
#include <string_view>
#include <unordered_map>

#include "core/camera/camera.h"
#include "core/material/texture_lookup.h"
#include "core/scene/scene.h"
#include "delegate/prims/mesh_cage.h"
#include "delegate/support/instancing.h"

namespace alabaster::hd::prims {

/// Things that prims could not read, build or light as they were asked to. They have been reported as errors, and the
/// frame is drawn without them.
using SceneFaults = std::map<Path, std::string>;

/// Counts placements in `budget`. The answer throws MemoryRefused.
support::HoldPlacements hold_placements_in(std::shared_ptr<MemoryBudget> budget);

struct MeshRecord {
  std::shared_ptr<const PulledMesh> source;             // the shape; another object after each edit of it
  std::shared_ptr<const FaceSlots> slots;               // another object after each edit of them
  std::shared_ptr<const OtherPrimvars> other_primvars;  // another object after each edit of them; null: none
  Matrix4d transform;
  alabaster::TimeSamples<Matrix4d> motion;  // of the transform; empty: stands still
  bool visible = true;
  int32_t prim_id = 0;
  std::vector<Path> materials{Path()};  // by slot: the prim's, then those of its subsets; empty path: default
  Path instancer;
  Array<int32_t> instance_indices;
  std::string subsurface_set;               // empty: each object scatters for itself
  std::string light_group;                  // where it emits; empty: none
  std::string crypto_object, crypto_asset;  // the names of its mattes; empty: its own
  MeshOptions options;
  Token render_tag = "geometry";
  std::vector<Token> categories;
  Token display_name;  // empty: none but its path
  bool operator==(const MeshRecord&) const = default;
};

struct InstancerRecord : support::InstancerRecord {
  std::shared_ptr<const OtherPrimvars> primvars;  // by point; another object after each edit of them; null: none
  bool operator==(const InstancerRecord&) const = default;
};

struct MaterialRecord {
  std::shared_ptr<const DisneyMaterial> material;
  std::optional<std::string> fault;  // an image that could not be read
  Token display_name = {};
  bool operator==(const MaterialRecord&) const = default;
};

/// The outputs of a texture node, as connections name them: indexed by Channel.
inline constexpr std::array<std::string_view, 6> kTextureOutputs{"rgb", "r", "g", "b", "a", "direction"};
static_assert(kTextureOutputs.size() == size_t(Channel::direction) + 1);

struct LightRecord {
  alabaster::LightParameters light;         // without poses
  alabaster::TimeSamples<Matrix4d> motion;  // of the transform; empty: stands still
  bool visible = true;                      // else it gives no light
  Token light_link, shadow_link;            // categories; empty: everything
  std::string light_group = {};             // empty: none
  std::optional<std::string> fault = {};
  bool operator==(const LightRecord&) const = default;
};

struct CameraRecord {
  CameraParameters camera;  // without poses; opens and closes are not set
  alabaster::TimeSamples<Matrix4d> motion;
  Shutter shutter() const { return {camera.shutter_open, camera.shutter_close}; }
  bool operator==(const CameraRecord&) const = default;
};

struct SettingsRecord {
  RenderSettingsDescription settings;
  bool operator==(const SettingsRecord&) const = default;
};

using Record = std::any;  // one of the above; nothing: the prim is gone
using Records = std::map<Path, Record>;

/// Null: there is none of that path, or it is of another kind.
template <class T>
const T* find_record(const Records& records, const Path& path) {
  const auto found = records.find(path);
  return found == records.end() ? nullptr : std::any_cast<T>(&found->second);
}

/// Finds the materials of records, which many meshes share: each path is searched for once.
class MaterialLookup {
 public:
  explicit MaterialLookup(const Records& records) : records_(records) {}
  /// Null: there is none of that path, or it is of another kind.
  const MaterialRecord* find(const Path& path) {
    const auto [found, is_new] = known_.try_emplace(path, nullptr);
    if (is_new) found->second = find_record<MaterialRecord>(records_, path);
    return found->second;
  }

 private:
  struct Hash {
    size_t operator()(const Path& path) const { return path.hash(); }
  };
  const Records& records_;
  std::unordered_map<Path, const MaterialRecord*, Hash> known_;
};

/// True for cameras and settings, which no snapshot has: a render compares them when it starts.
inline bool is_camera_or_settings(const Record& record) {
  return record.type() == typeid(CameraRecord) || record.type() == typeid(SettingsRecord);
}

}  // namespace alabaster::hd::prims
