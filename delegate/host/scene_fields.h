// Prims by named fields: one table of fields for each kind says their names, types, ranges and what an edit marks.
#pragma once

#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "delegate/host/retained_scene_delegate.h"

namespace alabaster::hd::host {

/// Names and values, in the order in which they are given. delegate/manual/parameters has a page for each kind.
using Fields = std::vector<std::pair<std::string, Value>>;

/// The paths and kinds of all prims. The kind of a mesh or light is its type.
ALABASTER_API std::vector<std::pair<Path, Token>> ListPrims(const RetainedSceneDelegate& scene);

struct [[nodiscard]] SetResult {
  bool found = true;  // false: there is no prim of that path
  std::string fault;  // "": the fields are set. Else nothing is
};

/// Makes the prim, or replaces what has its path. Fields that are not named have their defaults.
ALABASTER_API SetResult SetPrim(RetainedSceneDelegate* scene, const Path& path, const Token& kind,
                                const Fields& fields);
/// Changes the named fields of a prim.
ALABASTER_API SetResult EditPrim(RetainedSceneDelegate* scene, const Path& path, const Fields& fields);
/// The sentence about a path that no prim has, with the nearest path that one has.
ALABASTER_API std::string NoSuchPrim(const RetainedSceneDelegate& scene, const Path& path);
/// "mesh", "light" and the like: of all types of meshes, or of lights.
ALABASTER_API std::string_view KindOf(const PrimDescription& prim);
/// What SetPrim makes the prim of: its kind, or the type of a mesh or light. Empty: a render buffer, which has no
/// fields.
ALABASTER_API Token TypeOf(const PrimDescription& prim);
/// The fields that SetPrim makes the same prim of. Nodes of a material that do not lie below its path have their own
/// paths as names.
ALABASTER_API Fields GetFields(const Path& path, const PrimDescription& prim);
/// A camera, or settings, that are no prim: changes the named fields. Returns a fault, or "".
[[nodiscard]] ALABASTER_API std::string ReadCamera(const Fields& fields, CameraDescription* camera);
[[nodiscard]] ALABASTER_API std::string ReadSettings(const Fields& fields, RenderSettingsDescription* settings);
/// "" if it is a setting of schemas/render_settings.json and the value fits it; else a sentence.
ALABASTER_API std::string CheckSetting(const std::string& name, const Value& value);

struct FieldType {
  int32_t type = ALABASTER_NONE;
  bool is_array = false;  // of elements of `type`
  bool operator==(const FieldType&) const = default;
};
/// The type of a field's values. Words have type TOKEN. An empty `kind` is all kinds that have the field. NONE: the
/// field takes values of several types, kinds differ, or none has it.
ALABASTER_API FieldType TypeOfField(const Token& kind, const std::string& name);

/// A field or a parameter as people see it: in panels, schemas, pages of the manual and messages.
struct FieldRow {
  std::string name, unit, text;  // unit "none": it has none. A sentence or two
  FieldType type = {};           // words have type TOKEN, colours FLOAT3; NONE: it takes values of several types
  bool is_color = false;         // three numbers, or one for all
  double low = -std::numeric_limits<double>::infinity(), high = std::numeric_limits<double>::infinity();  // of numbers
  std::vector<std::string> words = {};   // that it takes; empty: it is no word
  std::vector<std::string> lights = {};  // the types of lights that have it; empty: all
  Value fallback = {};                   // empty: it has none
  bool in_millimetres = false;           // in descriptions and panels. The contract takes metres then
  std::string texture = {};              // the definition of schemas/textures.json that it may be; empty: it is none

  /// Zero is not among the values, but each number above it.
  bool is_above_zero() const { return low > 0 && low < 1e-20; }
};
/// The parameters of a schema in the order of their table: disney_material, texture_node, displacement_node, mesh,
/// lights, camera or render_settings.
ALABASTER_API std::vector<FieldRow> ParameterRows(const std::string& schema);
/// The fields that a kind of prims, or a "product" of renderSettings, has beside parameters.
ALABASTER_API std::vector<FieldRow> FieldRows(const std::string& kind);
/// The values that the row takes, for messages: "a number from 0 to 1".
ALABASTER_API std::string MustBe(const FieldRow& row);
/// "" if a field of that kind, or a parameter of it, may have the value; else a sentence. Numbers out of range, which
/// SetPrim leaves to the renderer in parameters of prims, are refused.
ALABASTER_API std::string CheckField(const std::string& kind, const std::string& name, const Value& value);

/// The name of a material's surface node in fields, if that is an AlabasterDisney; else empty.
ALABASTER_API std::string DisneySurface(const Path& material, const MaterialNetwork& network);

/// The names of all parameters that a light may have.
ALABASTER_API std::vector<std::string> LightParameterNames();

}  // namespace alabaster::hd::host
