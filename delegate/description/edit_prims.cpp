// The edits that a description makes of prims, one after the other.
#include "delegate/description/load_state.h"
#include "delegate/support/json_values.h"

namespace alabaster::hd::description {
namespace {

/// A list of a description. Its entries edit the prims of a kind that they match, or make one.
struct EditedList {
  const char *name, *kind;
  void (*read)(LoadState&, PrimEdit*);
};
constexpr EditedList kEdited[] = {
    {"materials", "material", read_material}, {"meshes", "mesh", read_mesh}, {"lights", "light", read_light}};

}  // namespace

Value field_value(const nlohmann::json& value) {
  return value.is_number() ? Value(value.get<float>()) : support::value_of(value);
}

void edit_prims(LoadState& load) {
  for (const EditedList& list : kEdited) {
    std::map<Path, host::Fields> waiting;  // a mesh of many parts is edited once, and not for each of them
    load.for_each_entry(list.name, [&](const std::string& pointer, const nlohmann::json& entry) {
      const bool is_new = entry.contains("name");
      if (is_new && entry.contains("match"))
        load.fail(pointer, "Either match existing " + std::string(list.name) + " or name a new one, not both.");
      if (is_new && load.document.is_of_option(pointer)) {  // the dome of the options, in the place of all others
        remove_lights(load.scene, true);
        load.names.erase(list.kind);
      }
      if (is_new && load.posing) return;
      const std::vector<Path> paths =
          is_new ? std::vector{new_path(load, list.kind, Path("/" + std::string(list.name)), pointer, entry["name"])}
                 : find_prims(load, list.kind, entry["match"], pointer + "/match");
      for (const Path& path : paths) {
        PrimEdit edit{pointer, entry, path, is_new};
        list.read(load, &edit);
        host::Fields& fields = waiting[path];
        fields.insert(fields.end(), edit.fields.begin(), edit.fields.end());
        if (!edit.may_wait) load.edit(pointer, path, edit.kind, std::exchange(fields, {}));
        if (is_new) add_name(load, list.kind, path);
      }
    });
    for (const auto& [path, fields] : waiting)
      if (!fields.empty()) load.edit("", path, {}, fields);
  }
  apply_links(load);
}

}  // namespace alabaster::hd::description
