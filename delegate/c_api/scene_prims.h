// A host's structs as the retained scene's descriptions. Each throws a Failure where the struct is at fault; the reader
// gives the lent arrays back. Internal to this room.
#pragma once

#include "delegate/c_api/values.h"

namespace alabaster::hd::c_api {

host::MeshDescription read_mesh(const AlabasterMesh* mesh, ValueReader& reader);
/// Adds the primvar and its motion to `mesh`.
void read_primvar(const AlabasterPrimvar& primvar, ValueReader& reader, host::MeshDescription* mesh);
host::InstancerDescription read_instancer(const AlabasterInstancer* instancer, ValueReader& reader);
/// Nodes lie below the material's path.
MaterialNetwork read_material(const Path& id, const AlabasterMaterial* material, ValueReader& reader);
host::LightDescription read_light(const AlabasterLight* light, ValueReader& reader);
host::CameraDescription read_camera(const AlabasterCamera* camera, ValueReader& reader);
/// Throws where a setting, or its value, has been removed.
void refuse_retired(const Dictionary& settings);
RenderSettingsDescription read_render_settings(const AlabasterRenderSettings* settings, ValueReader& reader);

}  // namespace alabaster::hd::c_api
