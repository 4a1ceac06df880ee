// The pictures of a frame, planned before anything is rendered. Internal to the frame recorder.
#pragma once

#include <set>

#include "delegate/host/frame_recorder.h"
#include "delegate/host/planned_product.h"

namespace alabaster::hd::host {

/// One picture, for the products that share it.
struct FrameRequest {
  RenderSettingsDescription description;  // the products' camera and size are its own; each product's `denoise` is set
  bool motion_blur = true, depth_of_field = true;
  std::set<std::string> aovs;  // those that the products and RecordOptions name; color if there is no product
  std::vector<PlannedProduct> files = {};
};

}  // namespace alabaster::hd::host
