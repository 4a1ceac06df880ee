#include "delegate/view/picture_frame.h"

#include <algorithm>
#include <cmath>

namespace alabaster::view {

PictureFrame PictureFrame::fit(hd::Vec2f corner, hd::Vec2f room, double aspect, float density) {
  constexpr float kLeast = 16;  // units
  hd::Vec2f size = hd::Vec2f(std::max(room.x, kLeast), std::max(room.y, kLeast)) * density;
  const auto shape = float(aspect);
  if (size.x > size.y * shape)
    size.x = size.y * shape;
  else
    size.y = size.x / shape;
  size = {std::max(1.0f, std::floor(size.x)), std::max(1.0f, std::floor(size.y))};
  PictureFrame frame;
  frame.density_ = density;
  for (int i = 0; i < 2; ++i) {
    const float low = std::floor(corner[i] * density + (room[i] * density - size[i]) / 2);
    frame.low_[i] = low / density;
    frame.high_[i] = (low + size[i]) / density;
  }
  return frame;
}

hd::Vec2d PictureFrame::place(const hd::Vec2f& cursor) const {
  return {double(cursor.x - low_.x) / double(high_.x - low_.x), double(cursor.y - low_.y) / double(high_.y - low_.y)};
}

hd::Vec2f PictureFrame::cursor(const hd::Vec2d& place) const {
  return low_ + hd::Vec2f(float(place.x), float(place.y)) * (high_ - low_);
}

hd::Vec2i PictureFrame::pixels(int reduction) const {
  const hd::Vec2f size = (high_ - low_) * density_;
  return {std::max(1, int(std::lround(size.x)) / reduction), std::max(1, int(std::lround(size.y)) / reduction)};
}

}  // namespace alabaster::view
