// A library with the C interface of Open Image Denoise, for tests of loading, errors, progress and cancelling. Guides
// are halved instead of denoised; the picture becomes color + albedo + normal if it is HDR with clean guides, else
// black. So a test sees whether everything arrived. A progress function is called five times.
//
// $FAKE_OIDN: "slow" (a minute, unless it is cancelled), "version 1", "no device", "out of memory", "broken", "not
// finite" or, by default, nothing. "color alone": the picture is color times two, whatever the guides.
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdlib>
#include <cstring>
#include <map>
#include <string>
#include <thread>

namespace {

bool is_asked_to(const char* what) {
  const char* value = std::getenv("FAKE_OIDN");
  return value && std::strcmp(value, what) == 0;
}

struct Device {
  std::map<std::string, int> parameters;
  int error = 0;
  std::string message;
  bool committed = false;
};

struct Filter {
  Device* device = nullptr;
  std::map<std::string, float*> images;
  std::map<std::string, bool> switches;
  size_t values = 0;
  bool (*progress)(void*, double) = nullptr;
  void* user = nullptr;
  bool committed = false;

  float value(size_t i) const {
    const auto image = [&](const char* name) { return images.at(name)[i]; };
    if (images.count("color") == 0) return 0.5f * image(images.count("albedo") ? "albedo" : "normal");
    if (is_asked_to("not finite")) return NAN;
    if (is_asked_to("color alone")) return 2 * image("color");
    const auto is_on = [&](const char* name) { return switches.count(name) && switches.at(name); };
    return is_on("hdr") && is_on("cleanAux") ? image("color") + image("albedo") + image("normal") : 0;
  }
};

void fail(Device* device, int error, const char* message) {
  if (device->error != 0) return;
  device->error = error;
  device->message = message;
}

}  // namespace

extern "C" {

Device* oidnNewDevice(int type) {
  return is_asked_to("no device") || type != 1 ? nullptr : new Device;
}
void oidnSetDeviceInt(Device* device, const char* name, int value) {
  device->parameters[name] = value;
}
void oidnSetDeviceBool(Device* device, const char* name, bool value) {
  device->parameters[name] = value;
}
int oidnGetDeviceInt(Device* device, const char* name) {
  if (std::string(name) == "version") return is_asked_to("version 1") ? 10403 : 29901;
  return device->parameters[name];
}
int oidnGetDeviceError(Device* device, const char** message) {
  static const std::string none = "this processor is not supported";
  if (!device) return *message = none.c_str(), 5;
  *message = device->message.c_str();
  const int error = device->error;
  device->error = 0;
  return error;
}
void oidnCommitDevice(Device* device) {
  // A host's threads are neither pinned nor more than it allows: a test's limit is in $FAKE_OIDN_THREADS.
  device->committed = true;
  const char* threads = std::getenv("FAKE_OIDN_THREADS");
  if (threads && (device->parameters["numThreads"] != std::atoi(threads) || device->parameters["setAffinity"] != 0))
    fail(device, 2, "wrong threads");
}
void oidnReleaseDevice(Device* device) {
  delete device;
}
Filter* oidnNewFilter(Device* device, const char* type) {
  auto* filter = new Filter;
  filter->device = device;
  if (!device->committed || std::string(type) != "RT") fail(device, 2, "no such filter");
  return filter;
}
void oidnSetSharedFilterImage(Filter* filter, const char* name, void* pixels, int format, size_t width, size_t height,
                              size_t offset, size_t pixel_stride, size_t row_stride) {
  if (format != 3 || offset != 0 || pixel_stride != 0 || row_stride != 0) fail(filter->device, 2, "wrong image");
  filter->images[name] = static_cast<float*>(pixels);
  filter->values = 3 * width * height;
}
void oidnSetFilterBool(Filter* filter, const char* name, bool value) {
  filter->switches[name] = value;
}
void oidnSetFilterProgressMonitorFunction(Filter* filter, bool (*progress)(void*, double), void* user) {
  filter->progress = progress;
  filter->user = user;
}
void oidnCommitFilter(Filter* filter) {
  filter->committed = true;
}
void oidnExecuteFilter(Filter* filter) {
  if (is_asked_to("out of memory")) return fail(filter->device, 4, "bad_alloc");
  if (is_asked_to("broken") || !filter->committed) return fail(filter->device, 1, "the network is broken");
  const int steps = is_asked_to("slow") ? 60000 : 4;
  for (int step = 0; step <= steps; ++step) {
    if (steps > 4) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    if (filter->progress && !filter->progress(filter->user, double(step) / steps))
      return fail(filter->device, 6, "cancelled");
  }
  float* const output = filter->images.at("output");
  for (size_t i = 0; i < filter->values; ++i) output[i] = filter->value(i);
}
void oidnReleaseFilter(Filter* filter) {
  delete filter;
}
}
