// Fields without a row in scene_fields.cpp: parameters of core's tables, and what a scene names. Internal to this room.
#pragma once

#include <optional>
#include <span>

#include "core/camera/camera.h"
#include "core/light/light_parameters.h"
#include "core/material/disney_material.h"
#include "core/material/node_inputs.h"
#include "core/scene/mesh_options.h"
#include "core/session/render_settings.h"
#include "delegate/host/field.h"
#include "delegate/host/scene_fields.h"
#include "delegate/support/parameters.h"

namespace alabaster::hd::host {

/// Result of setting a field: "" if it is set, else a fault; nullopt if the prim has no field of that name.
using FieldResult = std::optional<std::string>;

/// The fields of a mesh's subsets, "subsets:...", found by their paths: a mesh may have many.
class SubsetFields {
 public:
  explicit SubsetFields(std::vector<GeomSubset>* subsets) : subsets_(*subsets) {}
  FieldResult set(const std::string& name, const Value& value);
  /// Takes away those that were removed.
  void finish();

 private:
  std::vector<GeomSubset>& subsets_;
  std::map<Path, size_t> places_;
  size_t known_ = 0;  // so many of them have places
  bool removes_ = false;
};
/// All but the fields of subsets.
FieldResult set_open_field(PrimDescription* prim, const Path& id, const std::string& name, const Value& value);
/// The open fields from which set_open_field() makes the same prim.
void append_open_fields(const PrimDescription& prim, const Path& id, Fields* fields);
/// Checks a prim whose fields are all set. Returns a fault, or "".
std::string finish(const PrimDescription& prim);
/// The name of a node in fields of the material: without its path where it lies below the material.
std::string node_name(const Path& material, const Path& node);
/// The node of that name: below the material, or, where the name begins with a slash, of that path.
Path node_path(const Path& material, const std::string& name);
/// A parameter that is in no table of core: a text, such as the name of a file, or numbers.
struct OtherParameter {
  const char* name;
  FieldType type;              // a text may be of any type of texts
  const char* must;            // what a value must be, for messages; null: as its type and range say
  const char* text = nullptr;  // a sentence or two; null: it is no parameter for people
  const char* fallback = "";   // of a text
  uint32_t of = 0;             // as of Parameter
  const char* unit = "none";
  double low = -kUnbounded;               // of numbers
  std::array<const char*, 2> words = {};  // null: it is any text
};
FieldRow row_of(const OtherParameter& parameter);
FieldRow row_of_field(const Field& field);
/// The row without what only one table's rows have.
FieldRow plain_row(const char* name, const char* unit, const char* text, double low, double high,
                   std::span<const char* const> words);
template <class T, class... Words>
FieldType type_of(const Parameter<T, Words...>& parameter) {
  const auto of_member = []<class M>(M T::*) -> FieldType {
    if (std::is_same_v<M, Rgb>) return {ALABASTER_FLOAT3, false};
    if (std::is_same_v<M, uint32_t>) return {ALABASTER_UINT, false};
    return kFieldType<M>;
  };
  return std::visit(of_member, parameter.member);
}
/// A row of core's tables.
template <class T, class... Words>
FieldRow row_of(const Parameter<T, Words...>& parameter, const T& defaults) {
  FieldRow row =
      plain_row(parameter.name, parameter.unit, parameter.text, parameter.minimum, parameter.maximum, parameter.words);
  row.is_color = parameter.is_color();
  row.type = type_of(parameter);
  row.fallback = support::get_parameter(parameter, defaults);
  return row;
}
/// The name of a light's parameter without the namespace "inputs:", which it has in UsdLux.
std::string without_inputs_namespace(const std::string& name);
extern const std::span<const OtherParameter> kOtherOfTextures, kOtherOfDisplacements, kOtherOfMeshes, kOtherOfLights,
    kOtherOfCameras;

/// Calls visit(rows, defaults, others) with core's table of the parameters of a schema.
template <class Visit>
void visit_table(std::string_view schema, const Visit& visit) {
  const std::span<const OtherParameter> none;
  if (schema == "disney_material") visit(material_parameters(), DisneyParameters(), none);
  if (schema == "texture_node") visit(texture_inputs(), TextureInputs(), kOtherOfTextures);
  if (schema == "displacement_node") visit(displacement_inputs(), DisplacementInputs(), kOtherOfDisplacements);
  if (schema == "mesh") visit(mesh_parameters(), MeshOptions(), kOtherOfMeshes);
  if (schema == "lights") visit(light_parameters(), alabaster::LightParameters(), kOtherOfLights);
  if (schema == "camera") visit(camera_parameters(), CameraParameters(), kOtherOfCameras);
  if (schema == "render_settings") visit(setting_parameters(), RenderSettings(), none);
}

/// One kind of prim. Open fields have parts of their names in capitals: "primvars:NAME:indices". They have no
/// functions.
struct Kind {
  const char* name;  // "light": all types of lights
  std::span<const Field> fields, open;
  const char* parameters;  // the schema of core's table of its parameters
  DirtyBits others;        // what an edit of members without a row marks
  bool (RenderIndex::*insert)(const Token& type, SceneDelegate* scene, const Path& id);  // null: an instancer
  PrimDescription defaults = {};
};
/// All that have fields.
std::span<const Kind> kinds();
const Kind& kind_of(const PrimDescription& prim);  // that of its type, if it is a mesh
/// The bits that an edit marks. Both are of one kind.
DirtyBits difference(const PrimDescription& a, const PrimDescription& b);
/// The open fields of a kind.
std::span<const Field> open_rows(const PrimDescription& prim);
/// A part of the name is in capitals.
bool is_pattern(std::string_view name);

/// As CheckField, of the parameters of a schema; nullopt if it has none of that name.
FieldResult check_parameter(std::string_view schema, const std::string& name, const Value& value);
/// The names of the parameters of a schema, for messages.
std::vector<std::string> parameter_names(std::string_view schema);

/// Sets the field of that name; nullopt if the table has none.
FieldResult set_row(std::span<const Field> table, void* object, std::string_view name, const Value& value);
void append_rows(std::span<const Field> table, const void* object, const std::string& prefix, Fields* fields);
extern const std::span<const Field> kProductFields;

}  // namespace alabaster::hd::host
