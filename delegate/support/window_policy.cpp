#include "delegate/support/window_policy.h"

namespace alabaster::hd::support {

CameraWindow conform_window(CameraWindow window, double image_aspect, WindowPolicy policy) {
  const bool wider = window.width > window.height * image_aspect;  // than the image
  bool keep_height = true;
  switch (policy) {
    case WindowPolicy::dontConform:
      return window;
    case WindowPolicy::matchVertically:
      break;
    case WindowPolicy::matchHorizontally:
      keep_height = false;
      break;
    case WindowPolicy::fit:  // all of the camera's window is seen
      keep_height = !wider;
      break;
    case WindowPolicy::crop:  // nothing but the camera's window is seen
      keep_height = wider;
      break;
  }
  if (keep_height)
    window.width = window.height * image_aspect;
  else
    window.height = window.width / image_aspect;
  return window;
}

}  // namespace alabaster::hd::support
