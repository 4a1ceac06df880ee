#include "core/session/frame_memory.h"

#include <algorithm>

#include "core/convergence/frame_error.h"
#include "core/film/sample_sum.h"

namespace alabaster {

FilmExtras film_extras(const RenderSettings& settings, size_t light_groups) {
  FilmExtras extras{is_adaptive(settings), {}, light_groups};
  if (settings.first_sample > 0) extras.range = {settings.first_sample, settings.samples};
  return extras;
}

size_t frame_bytes(const PixelRect& window, AovSet aovs, const RenderSettings& settings, size_t light_groups) {
  if (window.empty()) return 0;
  const size_t films = settings.target_error > 0 ? 2 : 1;
  const bool adaptive = is_adaptive(settings);
  uint64_t samples = settings.samples;  // the most that a pixel takes
  if (adaptive) samples *= static_cast<uint64_t>(kLargestSampleRate);
  const size_t estimate = frame_error_bytes(window, std::min(samples, kMostSummedSamples));
  const size_t rates = adaptive ? sample_allocation_bytes(window) : 0;
  const size_t making = adaptive ? making_allocation_bytes(window) : 0;
  return films * film_bytes(window, aovs, film_extras(settings, light_groups)) + rates + std::max(estimate, making);
}

}  // namespace alabaster
