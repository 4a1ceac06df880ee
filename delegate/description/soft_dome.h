// The default light of a scene without lights: a sky that is brighter above, a broad key from the viewer's upper left
// and a rim from behind, so that shapes are readable and thin parts glow.
#pragma once

#include "delegate/host/retained_scene_delegate.h"

namespace alabaster::hd::description {

/// A dome light, turned so that its key stands to the upper left of `camera` (camera to world). Its image is in memory,
/// as Radiance RGBE.
host::LightDescription soft_dome(const Matrix4d& camera);

}  // namespace alabaster::hd::description
