// Parameters of a scene's materials and lights, as panels show and change them, and a record of what was changed.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "delegate/host/scene_fields.h"
#include "delegate/view/parameter_rows.h"

namespace alabaster::view {

using Changes = std::map<hd::Path, std::map<std::string, hd::Value>>;  // by prim and parameter

/// All that was changed of a scene in a window, also of prims that it has no longer.
struct EditRecord {
  Changes materials, lights;
  std::map<hd::Path, hd::host::LightDescription> added;  // lights, as they were added
};

/// A value within the row's limits, in the type that the renderer takes: a float, int64_t, bool, Vec3f or string.
hd::Value stored_value(const ParameterRow& row, const hd::Value& shown);

/// One thread. Each set is one edit of the scene; the next sync takes it up. Nothing else edits these prims meanwhile.
class SceneEdits {
 public:
  explicit SceneEdits(hd::host::RetainedSceneDelegate* scene);

  /// Those with a Disney surface, and all lights; in the order of their paths.
  const std::vector<hd::Path>& materials() const { return materials_; }
  const std::vector<hd::Path>& lights() const { return lights_; }
  /// Empty: it is no light.
  std::string light_type(const hd::Path& prim) const;

  /// The value that is in force: the row's default where the prim has none.
  hd::Value value(const hd::Path& prim, const ParameterRow& row) const;
  /// The image that a material's parameter is read from; empty if it is a constant.
  std::string texture(const hd::Path& material, const std::string& parameter) const;
  // These return the fault of an edit that the scene refuses, or "".
  /// A constant. A material's parameter loses its image.
  [[nodiscard]] std::string set(const hd::Path& prim, const ParameterRow& row, const hd::Value& value);
  /// Puts a light somewhere, under the parameter "transform". One that moves stands still there.
  [[nodiscard]] std::string place(const hd::Path& light, const hd::Matrix4d& transform) {
    return apply(light, "transform", transform);
  }
  /// Takes the changes of a parameter back.
  [[nodiscard]] std::string reset(const hd::Path& prim, const std::string& parameter);
  bool is_changed(const hd::Path& prim, const std::string& parameter) const { return change(prim, parameter); }

  hd::Matrix4d transform(const hd::Path& light) const;
  /// Adds a light under a name that no other light has; its path.
  hd::Path add_light(const hd::host::LightDescription& light);
  bool is_added(const hd::Path& light) const { return record_.added.contains(light); }
  /// Removes a light that was added.
  void remove_light(const hd::Path& light);

  const EditRecord& record() const { return record_; }
  /// The record without what waits for a prim that the scene has not.
  EditRecord made() const;
  /// Takes all changes back and makes those of a record, which may be of an earlier state of the scene. What finds no
  /// prim stays in the record and waits for it. The prims of which something could not be changed and did not wait
  /// already, each with what comes of it.
  std::vector<std::pair<hd::Path, std::string>> restore(const EditRecord& wanted);

 private:
  struct Prim {
    std::string light_type;   // empty: a material
    std::string node;         // the prefix of its fields: of a material the surface's name and a dot
    hd::host::Fields loaded;  // as the scene had it at first
  };
  std::string apply(const hd::Path& prim, const std::string& parameter, const hd::Value& value);
  void show_light(const hd::Path& path, const hd::host::LightDescription& light);
  const Prim* find(const hd::Path& prim) const;
  const hd::Value* change(const hd::Path& prim, const std::string& parameter) const;

  hd::host::RetainedSceneDelegate* scene_;
  std::vector<hd::Path> materials_, lights_;
  std::map<hd::Path, Prim> prims_;
  EditRecord record_;
};

}  // namespace alabaster::view
