// Reads what a RenderSettings prim asks for and checks it before anything is rendered. Internal to the frame recorder.
#pragma once

#include <set>

#include "delegate/host/frame_recorder.h"

namespace alabaster::hd::host {

struct FrameRequest {
  RenderSettingsDescription description;  // each product's `denoise` is set
  std::set<std::string> aovs;  // those that the products and RecordOptions name; color if there is no product
};

/// Refuses, with a report, every request that is known to fail: a bad size, crop or camera transform, an AOV that
/// `delegate` lacks, a product that cannot be written. A camera that does not exist is the pass's to refuse. Returns
/// `done` if the frame can be rendered.
RecordStatus CheckFrame(const RetainedSceneDelegate& scene, const Path& settings, const RenderDelegate& delegate,
                        const RecordOptions& options, FrameRequest* request);

}  // namespace alabaster::hd::host
