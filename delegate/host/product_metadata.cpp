#include "delegate/host/product_metadata.h"

#include <ctime>

namespace alabaster::hd::host {
namespace {

std::string utc_now() {
  const std::time_t now = std::time(nullptr);
  std::tm parts{};
  gmtime_r(&now, &parts);
  char text[32];
  std::strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%SZ", &parts);
  return text;
}

}  // namespace

Dictionary product_metadata(const RenderDelegate& delegate, const Dictionary& stats, const Path& camera) {
  Dictionary m;
  m["capDate"] = utc_now();
  m["alabaster/camera"] = camera.str();
  for (const RenderSettingDescriptor& setting : delegate.GetRenderSettingDescriptors())
    m["alabaster/" + setting.key.str()] = delegate.GetRenderSetting(setting.key);
  const std::pair<const char*, const char*> kept[] = {{"samplesDone", "numCompletedSamples"},
                                                      {"pixelsWithoutSample", "pixelsWithoutSample"},
                                                      {"error/relativeRmse", "error.relativeRmse"},
                                                      {"error/low", "error.low"},
                                                      {"error/high", "error.high"},
                                                      {"error/isKnown", "error.isKnown"},
                                                      {"endedBy", "endedBy"},
                                                      {"target/missed", "target.missed"},
                                                      {"target/samples", "target.samples"},
                                                      {"target/seconds", "target.seconds"},
                                                      {"renderSeconds", "totalClockTime"},
                                                      {"cpuSeconds", "cpuSeconds"},
                                                      {"denoiser", "denoiser"},
                                                      {"sceneFaults", "scene.faults"},
                                                      {"peakMemory", "peakMemory"}};
  for (const auto& [name, key] : kept)
    if (const auto found = stats.find(key); found != stats.end()) m[std::string("alabaster/") + name] = found->second;
  return m;
}

}  // namespace alabaster::hd::host
