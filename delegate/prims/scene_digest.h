// Digests that tell scenes apart: a checkpoint continues in the same scene only.
#pragma once

#include <map>
#include <string>

#include "delegate/prims/scene_translation.h"

namespace alabaster::hd::prims {

/// Digests of all that is drawn, by kind and name: "mesh /world/head" for all instances of a prim. Contents count, not
/// names of files: an image is its texels. Runs on all threads of the caller's TBB arena, for a second where gigabytes
/// are drawn. Scenes of more than 10,000 names have one digest for each kind.
std::map<std::string, std::string> digest_scene(const Translation& translation);

/// A camera counts with its poses in the scene's shutter.
std::string digest_camera(const CameraParameters& camera);

}  // namespace alabaster::hd::prims
