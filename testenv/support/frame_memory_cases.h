// Frames of each kind that holds memory of its own, for the tests of what is counted for them.
#pragma once

#include <vector>

#include "testenv/support/scene_builder.h"

namespace alabaster::testing {

inline constexpr AovSet kFrameMemoryAovs = aov_bit(Aov::color) | aov_bit(Aov::normal) | aov_bit(Aov::depth);

inline RenderRequest frame_memory_request(const RenderSettings& settings) {
  constexpr int kSide = 128;
  RenderRequest request = mixed_request(settings.samples);
  request.settings = settings;
  request.settings.threads = 2;
  request.settings.max_depth = 1;
  request.settings.subsurface = SubsurfaceMode::lambert;
  request.width = request.height = kSide;
  request.data_window = {0, 0, kSide, kSide};
  request.aovs = kFrameMemoryAovs;
  return request;
}

struct FrameMemoryCase {
  const char* name;
  RenderSettings settings;
};

// A part keeps sums at powers of two, an adaptive frame its rays and rates, a frame with a target error a second film.
inline std::vector<FrameMemoryCase> frame_memory_cases() {
  std::vector<FrameMemoryCase> all(6);
  for (FrameMemoryCase& c : all) c.settings.samples = 8;
  all[0].name = "even";
  all[1].name = "part 1:8", all[1].settings.first_sample = 1;
  all[2].name = "part 3:64", all[2].settings.first_sample = 3, all[2].settings.samples = 64;
  all[3].name = "adaptive", all[3].settings.adaptive = true, all[3].settings.samples = 32;
  all[4].name = "target error", all[4].settings.target_error = 0.1f, all[4].settings.samples = 64;
  all[5].name = "adaptive to an error", all[5].settings = all[4].settings, all[5].settings.adaptive = true;
  return all;
}

}  // namespace alabaster::testing
