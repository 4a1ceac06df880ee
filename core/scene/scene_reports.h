// Reports of what a picture cannot show as the scene means it. They name the prims.
#pragma once

#include <string>

#include "core/scene/bodies.h"

namespace alabaster {

struct ReportedScene {
  const SceneDescription& description;
  const DrawnInstances& drawn;
  const SceneSnapshot& snapshot;
  const DiagnosticSink& sink;
  const CancelToken& cancel;
};

/// "; 4 of its edges have one face, one from (0, 0, 0) to (1, 0, 0): close it there, ...": each kind with its remedy.
std::string describe_open_edges(const OpenEdges& edges);
/// "; 2 other meshes of its subsurfaceSet are not closed either, ..."; empty if there are none.
std::string describe_open_fellows(size_t others);

/// Warns of bodies that are not closed, once for a union, of closed shells that are thinner than the rounding of
/// positions, in which no walk can begin, and of lights and meshes that emit within a body: walks meet none behind
/// diffuse walls, and by chance behind clear ones; and of sets of several media or with clear members. Throws
/// BuildCancelled.
void report_bodies(const ReportedScene& scene);

/// Warns where all lights are without size, and something refracts.
void report_lights_without_size(const ReportedScene& scene);

}  // namespace alabaster
