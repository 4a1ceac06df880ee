// Reads what a RenderSettings prim asks for and checks it before anything is rendered. Internal to the frame recorder.
#pragma once

#include <set>

#include "delegate/host/frame_recorder.h"

namespace alabaster::hd::host {

/// One picture, for the products that share it.
struct FrameRequest {
  RenderSettingsDescription description;  // the products' camera and size are its own; each product's `denoise` is set
  bool motion_blur = true, depth_of_field = true;
  std::set<std::string> aovs;  // those that the products and RecordOptions name; color if there is no product
};

/// Refuses, with a report, every request that is known to fail: a bad size, crop or camera transform, an AOV that
/// `delegate` lacks, a product that cannot be written, a checkpoint of several pictures. A camera that does not exist
/// is the pass's to refuse. Returns `done` if the frame can be rendered: a request for each picture, in the order of
/// the products.
RecordEnd CheckFrame(const RetainedSceneDelegate& scene, const Path& settings, const RenderDelegate& delegate,
                     const RecordOptions& options, std::vector<FrameRequest>* requests);

}  // namespace alabaster::hd::host
