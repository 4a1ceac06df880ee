// How a camera's window takes the shape of an image: Hydra's conformed window.
#pragma once

#include <array>

#include "delegate/api/scene_types.h"

namespace alabaster::hd::support {

/// The names that files have for WindowPolicy, in its order.
inline constexpr std::array<const char*, 5> kWindowPolicyNames = {"matchVertically", "matchHorizontally", "fit", "crop",
                                                                  "dontConform"};

/// Width and height of what a camera sees: apertures, or the tangents that they make with a focal length.
struct CameraWindow {
  double width = 0, height = 0;
};

/// The window about the same centre with the image's aspect ratio, width over height (pixels that are not square
/// included). Both must be positive.
CameraWindow conform_window(CameraWindow window, double image_aspect, WindowPolicy policy);

}  // namespace alabaster::hd::support
