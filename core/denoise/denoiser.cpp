#include "core/denoise/denoiser.h"

#include <dlfcn.h>

#include <cstdlib>
#include <mutex>
#include <utility>

#include "core/denoise/oidn_search.h"

namespace alabaster {
namespace {

constexpr const char* kRemedy =
    "Install it, for example with `pip install --no-deps --target FOLDER pyoidn`, and set ALABASTER_OIDN=FOLDER; or "
    "render without denoising.";

// The library's C interface, from its manual: handles are opaque, enumerations are ints.
constexpr int kCpuDevice = 1, kFloat3 = 3;
constexpr int kNoError = 0, kOutOfMemory = 4, kCancelled = 6;
constexpr int kOldestVersion = 20000;  // 10000 major + 100 minor + patch

}  // namespace

// Outside of the unnamed namespace: g++ 14 fails on pointers to functions of its types in a unity build.
struct DeviceHandle;
struct FilterHandle;

/// Addresses of the functions that are used; all of them exist.
struct Denoiser::Functions {
  DeviceHandle* (*new_device)(int type);
  void (*set_device_int)(DeviceHandle*, const char* name, int value);
  void (*set_device_bool)(DeviceHandle*, const char* name, bool value);
  int (*get_device_int)(DeviceHandle*, const char* name);
  int (*get_device_error)(DeviceHandle*, const char** message);
  void (*commit_device)(DeviceHandle*);
  void (*release_device)(DeviceHandle*);
  FilterHandle* (*new_filter)(DeviceHandle*, const char* type);
  void (*set_image)(FilterHandle*, const char* name, void* pixels, int format, size_t width, size_t height,
                    size_t offset, size_t pixel_stride, size_t row_stride);
  void (*set_filter_bool)(FilterHandle*, const char* name, bool value);
  void (*set_progress)(FilterHandle*, bool (*progress)(void* user, double fraction), void* user);
  void (*commit_filter)(FilterHandle*);
  void (*execute_filter)(FilterHandle*);
  void (*release_filter)(FilterHandle*);

  /// The name of a function that `library` lacks; null: it has all of them.
  const char* look_up(void* library) {
    const char* missing = nullptr;
    const auto find = [&](auto& function, const char* name) {
      function = reinterpret_cast<std::remove_reference_t<decltype(function)>>(dlsym(library, name));
      if (!function && !missing) missing = name;
    };
    find(new_device, "oidnNewDevice");
    find(set_device_int, "oidnSetDeviceInt");
    find(set_device_bool, "oidnSetDeviceBool");
    find(get_device_int, "oidnGetDeviceInt");
    find(get_device_error, "oidnGetDeviceError");
    find(commit_device, "oidnCommitDevice");
    find(release_device, "oidnReleaseDevice");
    find(new_filter, "oidnNewFilter");
    find(set_image, "oidnSetSharedFilterImage");
    find(set_filter_bool, "oidnSetFilterBool");
    find(set_progress, "oidnSetFilterProgressMonitorFunction");
    find(commit_filter, "oidnCommitFilter");
    find(execute_filter, "oidnExecuteFilter");
    find(release_filter, "oidnReleaseFilter");
    return missing;
  }
};

namespace {

/// A device and the work on it. Errors stay with the device: the first one is kept until it is asked for.
template <class Functions>
class Device {
 public:
  Device(const Functions& functions, uint32_t threads) : oidn_(functions), handle_(oidn_.new_device(kCpuDevice)) {
    if (!handle_) return;
    oidn_.set_device_int(handle_, "numThreads", static_cast<int>(threads));
    oidn_.set_device_bool(handle_, "setAffinity", false);  // the threads are the host's
    oidn_.commit_device(handle_);
  }
  ~Device() {
    if (handle_) oidn_.release_device(handle_);
  }
  Device(const Device&) = delete;
  Device& operator=(const Device&) = delete;

  int version() const { return handle_ ? oidn_.get_device_int(handle_, "version") : 0; }

  DenoiseStatus status(std::string* problem) const {
    const char* message = nullptr;
    const int error = oidn_.get_device_error(handle_, &message);
    if (error == kCancelled) return DenoiseStatus::cancelled;
    if (error == kNoError && handle_) return DenoiseStatus::done;
    *problem = error == kOutOfMemory ? "there is not enough memory"
               : message && *message ? message
               : handle_ == nullptr  ? "it has no device for this processor"
                                     : "error " + std::to_string(error);
    return DenoiseStatus::failed;
  }

  using Images = std::vector<std::pair<const char*, float*>>;
  /// Runs one filter over images of `frame`'s size.
  DenoiseStatus run(const DenoiserFrame& frame, const Images& images, bool is_picture,
                    std::function<bool(double)>* progress, std::string* problem) const {
    FilterHandle* filter = oidn_.new_filter(handle_, "RT");
    if (!filter) return status(problem);
    for (const auto& [name, pixels] : images)
      oidn_.set_image(filter, name, pixels, kFloat3, frame.width, frame.height, 0, 0, 0);
    if (is_picture) {
      oidn_.set_filter_bool(filter, "hdr", true);
      oidn_.set_filter_bool(filter, "cleanAux", true);
    }
    if (*progress)
      oidn_.set_progress(
          filter,
          [](void* user, double fraction) { return (*static_cast<std::function<bool(double)>*>(user))(fraction); },
          progress);
    oidn_.commit_filter(filter);
    oidn_.execute_filter(filter);
    oidn_.release_filter(filter);
    return status(problem);
  }

 private:
  const Functions& oidn_;
  DeviceHandle* handle_;
};

std::string version_text(int version) {
  return std::to_string(version / 10000) + "." + std::to_string(version / 100 % 100) + "." +
         std::to_string(version % 100);
}

}  // namespace

Denoiser::Denoiser(std::string file, std::unique_ptr<const Functions> functions, int version)
    : file_(std::move(file)), name_("Open Image Denoise " + version_text(version)), functions_(std::move(functions)) {}

Denoiser::~Denoiser() = default;

// The library stays loaded to the end of the process (RTLD_NODELETE): its threads may still run when the last user
// leaves. Its names stay its own (RTLD_LOCAL), for a host may bring another copy.
std::shared_ptr<const Denoiser> Denoiser::open(const std::string& file, std::string* problem) {
  void* library = dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL | RTLD_NODELETE);
  if (!library) return *problem = dlerror(), nullptr;
  auto functions = std::make_unique<Functions>();
  const char* missing = functions->look_up(library);
  dlclose(library);
  if (missing) return *problem = file + " has no function " + missing + ": it is not Open Image Denoise 2", nullptr;
  const Device device(*functions, 0);
  if (device.status(problem) != DenoiseStatus::done) return *problem = file + ": " + *problem, nullptr;
  const int version = device.version();
  if (version < kOldestVersion)
    return *problem = file + " is version " + version_text(version) + ", and version 2 is needed", nullptr;
  return std::shared_ptr<const Denoiser>(new Denoiser(file, std::move(functions), version));
}

std::shared_ptr<const Denoiser> Denoiser::load(std::string* problem) {
  const char* variable = std::getenv("ALABASTER_OIDN");
  const std::string named = variable ? variable : "";
  std::string first;  // why the first one that exists could not be used
  for (const std::string& file : find_oidn(named)) {
    std::string reason;
    if (auto denoiser = open(file, &reason)) return denoiser;
    if (first.empty() && file.find('/') != std::string::npos) first = std::move(reason);
  }
  if (first.empty() && !named.empty()) first = "ALABASTER_OIDN=" + named + " does not lead to libOpenImageDenoise.so.2";
  *problem = first.empty() ? std::string("Open Image Denoise 2 was not found. ") + kRemedy
                           : "Open Image Denoise 2 cannot be used: " + first + ". " + kRemedy;
  return nullptr;
}

DenoiseStatus Denoiser::denoise(DenoiserFrame* frame, const DenoiseOptions& options, std::string* problem) const {
  if (frame->color.empty()) return DenoiseStatus::done;
  const Device device(*functions_, options.threads);
  DenoiseStatus status = device.status(problem);
  float *const color = frame->color.data(), *const albedo = frame->albedo.data(), *const normal = frame->normal.data();
  const struct {
    typename Device<Functions>::Images images;
    bool is_picture;
  } steps[] = {{{{"albedo", albedo}, {"output", albedo}}, false},
               {{{"normal", normal}, {"output", normal}}, false},
               {{{"color", color}, {"albedo", albedo}, {"normal", normal}, {"output", color}}, true}};
  std::mutex one_at_a_time;
  for (size_t i = 0; i < std::size(steps) && status == DenoiseStatus::done; ++i) {
    std::function<bool(double)> progress;
    if (options.progress)
      progress = [&, i](double fraction) {
        const std::lock_guard lock(one_at_a_time);
        return options.progress((static_cast<double>(i) + fraction) / std::size(steps));
      };
    status = device.run(*frame, steps[i].images, steps[i].is_picture, &progress, problem);
  }
  return status;
}

}  // namespace alabaster
