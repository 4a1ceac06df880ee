// Where the picture stands in a window. Three units meet: those of the window, in which the cursor moves; pixels of the
// framebuffer, of which dense screens have several in a unit; and shares of the picture.
#pragma once

#include "delegate/api/types.h"

namespace alabaster::view {

/// How large the desktop wants things, and how many pixels a unit of the window has. X11 gives windows in pixels, so
/// that density is 1 and content 2 on a screen of 192 dots per inch; Wayland and macOS have 2 and 2 there.
struct ScreenScale {
  float content = 1, density = 1;
  bool operator==(const ScreenScale&) const = default;
  /// Pixels for what has `size` pixels on a plain screen.
  float pixels(float size) const { return size * content; }
  /// The same in units of the window.
  float units(float size) const { return size * content / density; }
};

class PictureFrame {
 public:
  /// A picture of that shape, width over height, as large as the room allows, in its middle, on whole pixels.
  static PictureFrame fit(hd::Vec2f corner, hd::Vec2f room, double aspect, float density);

  hd::Vec2f low() const { return low_; }
  hd::Vec2f high() const { return high_; }
  /// The cursor's place in the picture: 0 to 1 in it, y down.
  hd::Vec2d place(const hd::Vec2f& cursor) const;
  hd::Vec2f cursor(const hd::Vec2d& place) const;
  /// Pixels to render for it. `reduction`: 2 for half as many on a side.
  hd::Vec2i pixels(int reduction) const;

 private:
  hd::Vec2f low_{0, 0}, high_{1, 1};
  float density_ = 1;
};

}  // namespace alabaster::view
