// The light of a scene that has none: a sky that is brighter above, a broad key from the upper left of the viewer and a
// rim from behind, so that forms read and thin parts glow.
#pragma once

#include "delegate/host/retained_scene_delegate.h"

namespace alabaster::hd::description {

/// A dome light turned so that its key stands to the upper left of `camera` (camera to world). Its image is made here,
/// in memory, as Radiance RGBE.
host::LightDescription soft_dome(const Matrix4d& camera);

}  // namespace alabaster::hd::description
