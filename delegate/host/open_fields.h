// Fields whose names a scene chooses: primvars, subsets, nodes, parameters, products. Internal to this room.
#pragma once

#include <optional>
#include <span>

#include "delegate/host/field.h"
#include "delegate/host/scene_fields.h"

namespace alabaster::hd::host {

/// "" if the field is set, a fault, or nullopt if its name is none of these.
using Put = std::optional<std::string>;

Put put_open(MeshDescription* mesh, const std::string& name, const Value& value);
Put put_open(InstancerDescription* instancer, const std::string& name, const Value& value);
Put put_open(LightDescription* light, const std::string& name, const Value& value);
Put put_open(CameraDescription* camera, const std::string& name, const Value& value);
Put put_open(RenderSettingsDescription* settings, const std::string& name, const Value& value);
/// The node of that name: below the material, or, where the name begins with a slash, of that path.
Path node_path(const Path& material, const std::string& name);
Put put_open(MaterialNetwork* network, const Path& id, const std::string& name, const Value& value);

// The open fields that make the same prim.
void get_open(const MeshDescription& mesh, Fields* fields);
void get_open(const InstancerDescription& instancer, Fields* fields);
void get_open(const LightDescription& light, Fields* fields);
void get_open(const CameraDescription& camera, Fields* fields);
void get_open(const RenderSettingsDescription& settings, Fields* fields);
void get_open(const MaterialNetwork& network, const Path& id, Fields* fields);

/// A parameter that is in no table of core's: a text, or numbers.
struct OtherParameter {
  const char* name;
  bool (*fits)(const Value&);
  const char* must;              // what a value must be, for messages
  const char* schema = nullptr;  // its entry in schemas/*.json; null: it is in none
};
std::span<const OtherParameter> other_light_parameters();
std::span<const OtherParameter> other_camera_parameters();

// Checks of a prim whose fields are all set. Each returns a fault, or "".
std::string finish(MeshDescription* mesh);
std::string finish(InstancerDescription* instancer);
std::string finish(const MaterialNetwork& network);
std::string finish(const RenderSettingsDescription& settings);

/// The names that parameters of a kind have, for messages.
std::vector<std::string> camera_names();
std::vector<std::string> setting_names();

/// Sets the field of that name; nullopt if the table has none.
Put put_row(std::span<const Field> table, void* object, std::string_view name, const Value& value);
void get_rows(std::span<const Field> table, const void* object, const std::string& prefix, Fields* fields);
extern const std::span<const Field> kProductFields;

}  // namespace alabaster::hd::host
