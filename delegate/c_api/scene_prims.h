// A host's structs as the retained scene's descriptions. Each throws a Failure, with all lent arrays given back.
// Internal to this room.
#pragma once

#include "delegate/c_api/values.h"

namespace alabaster::hd::c_api {

host::MeshDescription read_mesh(const AlabasterMesh* mesh);
/// Adds the primvar and its motion to `mesh`.
void read_primvar(const AlabasterPrimvar& primvar, ValueReader& reader, host::MeshDescription* mesh);
host::InstancerDescription read_instancer(const AlabasterInstancer* instancer);
/// Nodes lie below the material's path.
MaterialNetwork read_material(const Path& id, const AlabasterMaterial* material);
host::LightDescription read_light(const AlabasterLight* light);
host::CameraDescription read_camera(const AlabasterCamera* camera);
RenderSettingsDescription read_render_settings(const AlabasterRenderSettings* settings);

}  // namespace alabaster::hd::c_api
