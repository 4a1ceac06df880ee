// Parameters of a scene's materials and lights, as panels show and change them, and a record of what was changed.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "delegate/host/scene_fields.h"
#include "delegate/view/parameter_rows.h"

namespace alabaster::view {

using Changes = std::map<hd::Path, std::map<std::string, hd::Value>>;  // by prim and parameter

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
  /// Takes the changes of a parameter back.
  [[nodiscard]] std::string reset(const hd::Path& prim, const std::string& parameter);
  bool is_changed(const hd::Path& prim, const std::string& parameter) const { return change(prim, parameter); }

  const Changes& changed_materials() const { return changed_materials_; }
  const Changes& changed_lights() const { return changed_lights_; }

 private:
  struct Prim {
    std::string light_type;   // empty: a material
    std::string node;         // the prefix of its fields: of a material the surface's name and a dot
    hd::host::Fields loaded;  // as the scene had it at first
  };
  const Prim* find(const hd::Path& prim) const;
  const hd::Value* change(const hd::Path& prim, const std::string& parameter) const;

  hd::host::RetainedSceneDelegate* scene_;
  std::vector<hd::Path> materials_, lights_;
  std::map<hd::Path, Prim> prims_;
  Changes changed_materials_, changed_lights_;
};

}  // namespace alabaster::view
