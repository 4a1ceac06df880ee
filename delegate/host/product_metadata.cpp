#include "delegate/host/product_metadata.h"

#include <ctime>

#include "delegate/host/product_writer.h"

namespace alabaster::hd::host {
namespace {

// As EXIF, TIFF and OpenEXR write times.
std::string utc_now() {
  const std::time_t now = std::time(nullptr);
  std::tm parts{};
  gmtime_r(&now, &parts);
  char text[32];
  std::strftime(text, sizeof text, "%Y:%m:%d %H:%M:%S", &parts);
  return text;
}

}  // namespace

Dictionary ProductMetadata(const RenderDelegate& delegate, const Dictionary& stats, const Path& camera) {
  Dictionary m;
  m["capDate"] = utc_now();
  m["utcOffset"] = 0.0f;  // of capDate
  m["alabaster/camera"] = camera.str();
  // Threads change no picture: that of one machine and that of a farm's parts are the same file.
  for (const RenderSettingDescriptor& setting : delegate.GetRenderSettingDescriptors())
    if (setting.key != Token("threads")) m["alabaster/" + setting.key.str()] = delegate.GetRenderSetting(setting.key);
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
  for (const char* name : kCameraMatrices)
    if (const auto found = stats.find(std::string("camera.") + name); found != stats.end()) m[name] = found->second;
  return m;
}

}  // namespace alabaster::hd::host
