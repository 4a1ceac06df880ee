#include "delegate/host/frame_request.h"

#include "core/math/transform.h"
#include "delegate/host/product_plan.h"

namespace alabaster::hd::host {
namespace {

struct Fault {
  const char* code = nullptr;  // null: none
  std::string text;
};

Fault request_fault(const RenderSettingsDescription& d) {
  const Rect2i window = d.window();
  if (d.width < 1 || d.height < 1 || d.width > 65536 || d.height > 65536)
    return {"record.resolution", "width and height must be from 1 to 65536"};
  const auto fits = [](int first, int last) { return first < last && int64_t(last) - first <= 65536; };
  const bool square_enough = d.pixelAspectRatio >= 1e-6f && d.pixelAspectRatio <= 1e6f;  // OpenEXR's limits
  if (!fits(window.minX, window.maxX) || !fits(window.minY, window.maxY) || !square_enough)
    return {"record.framing",
            "the crop must be 1 to 65536 pixels wide and high, and pixelAspectRatio from 1e-6 to 1e6"};
  if (!window.overlaps(d.frame_window()))
    return {"record.crop", "the crop lies wholly outside the frame of " + std::to_string(d.width) + " x " +
                               std::to_string(d.height) + " pixels"};
  return {};
}

Fault camera_fault(const RetainedSceneDelegate& scene, const Path& path) {
  const auto camera = scene.GetCameras().find(path);
  if (camera == scene.GetCameras().end()) return {};
  if (is_valid_affine(camera->second.transform)) return {};
  return {"record.camera",
          "the transform of camera " + path.str() + " is not finite or cannot be inverted: it may be scaled to zero"};
}

std::set<std::string> aovs_of(const std::vector<RenderProduct>& products) {
  std::set<std::string> aovs;
  for (const RenderProduct& product : products)
    for (const RenderVar& var : WantedVars(product)) aovs.insert(var.aov.str());
  if (aovs.empty()) aovs.insert("color");
  return aovs;
}

bool wants_denoised(const RenderSettingsDescription& d, const RenderDelegate& delegate) {
  const auto own = d.settings.find("denoise");
  return (own != d.settings.end() ? own->second : delegate.GetRenderSetting("denoise")).number_or(0) != 0;
}

Fault aov_fault(const RenderDelegate& delegate, const std::set<std::string>& aovs) {
  for (const std::string& aov : aovs)
    if (delegate.GetDefaultAovDescriptor(aov).format == Format::invalid)
      return {"record.aov", "AOV '" + aov + "' is not supported"};
  return {};
}

}  // namespace

RecordStatus CheckFrame(const RetainedSceneDelegate& scene, const Path& settings, const RenderDelegate& delegate,
                        const RecordOptions& options, FrameRequest* request) {
  // Reports a fault, if there is one.
  const auto refuse = [&](const Fault& fault) {
    if (fault.code && options.diagnostics)
      options.diagnostics({Severity::error, fault.code, settings.str(), fault.text});
    return fault.code != nullptr;
  };
  const auto found = scene.GetAllRenderSettings().find(settings);
  if (found == scene.GetAllRenderSettings().end()) {
    refuse({"record.settings", "there are no such render settings"});
    return RecordStatus::input_failed;
  }
  RenderSettingsDescription& d = request->description = found->second;
  const bool denoise = wants_denoised(d, delegate);
  for (RenderProduct& product : d.products) product.denoise = product.denoise.value_or(denoise);
  if (refuse(request_fault(d)) || refuse(camera_fault(scene, d.camera))) return RecordStatus::input_failed;
  for (const RenderProduct& product : d.products)
    if (!CheckProduct(product, options.colors, options.diagnostics)) return RecordStatus::output_failed;
  request->aovs = aovs_of(d.products);
  if (denoise && request->aovs.contains("color")) request->aovs.insert("denoised");  // else color would show it
  request->aovs.insert(options.aovs.begin(), options.aovs.end());
  return refuse(aov_fault(delegate, request->aovs)) ? RecordStatus::input_failed : RecordStatus::done;
}

}  // namespace alabaster::hd::host
