// Words that fields of meshes take, each list in the order of core's enumeration (core/geometry/cage.h).
#pragma once

#include <array>

namespace alabaster::hd::support {

inline constexpr std::array kSubdivisionSchemes{"none", "catmullClark", "loop", "bilinear"};
inline constexpr std::array kOrientations{"rightHanded", "leftHanded"};  // of Cage::left_handed
inline constexpr std::array kBoundaryRules{"none", "edgeOnly", "edgeAndCorner"};
inline constexpr std::array kFaceVaryingRules{"all",         "none",         "boundaries",
                                              "cornersOnly", "cornersPlus1", "cornersPlus2"};
inline constexpr std::array kCreaseMethods{"uniform", "chaikin"};
inline constexpr std::array kTriangleSubdivisions{"catmullClark", "smooth"};

// Of curves, the default first.
inline constexpr std::array kCurveTypes{"cubic", "linear"};
inline constexpr std::array kCurveBases{"bezier", "bspline", "catmullRom"};
inline constexpr std::array kCurveWraps{"nonperiodic", "periodic", "pinned"};

}  // namespace alabaster::hd::support
