// The memory that is counted for a frame against what operator new gives out.
#include "core/session/frame_memory.h"

#include <gtest/gtest.h>

#include "testenv/support/failing_memory.h"
#include "testenv/support/scene_builder.h"

namespace alabaster {
namespace {

constexpr int kSide = 128;
constexpr uint32_t kAovs = aov_bit(Aov::color) | aov_bit(Aov::normal) | aov_bit(Aov::depth);

RenderRequest request_of(const RenderSettings& settings) {
  RenderRequest request = testing::mixed_request(settings.samples);
  request.settings = settings;
  request.settings.threads = 2;
  request.settings.max_depth = 1;
  request.settings.subsurface = SubsurfaceMode::lambert;
  request.width = request.height = kSide;
  request.data_window = {0, 0, kSide, kSide};
  request.aovs = kAovs;
  return request;
}

struct Case {
  const char* name;
  RenderSettings settings;
};

// A part keeps sums at powers of two, an adaptive frame its rays and rates, a frame with a target error a second film.
std::vector<Case> cases() {
  std::vector<Case> all(6);
  for (Case& c : all) c.settings.samples = 8;
  all[0].name = "even";
  all[1].name = "part 1:8", all[1].settings.first_sample = 1;
  all[2].name = "part 3:64", all[2].settings.first_sample = 3, all[2].settings.samples = 64;
  all[3].name = "adaptive", all[3].settings.adaptive = true, all[3].settings.samples = 32;
  all[4].name = "target error", all[4].settings.target_error = 0.1f, all[4].settings.samples = 64;
  all[5].name = "adaptive to an error", all[5].settings = all[4].settings, all[5].settings.adaptive = true;
  return all;
}

// All that operator new gives to the session, at the same time.
TEST(FrameMemory, IsTheMostThatARenderHolds) {
  for (const Case& c : cases()) {
    const RenderRequest request = request_of(c.settings);
    testing::render(request);  // what stays, such as threads and tables, is there now
    size_t most = 0;
    {
      const testing::PeakMemory peak;
      testing::render(request);
      most = peak.bytes();
    }
    const size_t counted = frame_bytes(request.data_window, kAovs, c.settings);
    const size_t uncounted = size_t(1) << 20;  // tiles, threads, light paths
    EXPECT_LT(most, counted + uncounted) << c.name;
    // The second film is taken only where a group of pixels ends before others.
    const bool is_whole = c.settings.target_error == 0;
    EXPECT_TRUE(!is_whole || most + counted / 4 > counted) << c.name << ": counted in vain";
  }
}

}  // namespace
}  // namespace alabaster
