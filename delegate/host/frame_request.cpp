#include "delegate/host/frame_request.h"

#include <algorithm>
#include <cmath>

#include "core/film/aov.h"
#include "core/math/float_environment.h"
#include "core/math/transform.h"
#include "delegate/host/light_paths.h"
#include "delegate/support/nearest_name.h"
#include "delegate/support/size_text.h"

namespace alabaster::hd::host {
namespace {

struct Fault {
  const char* code = nullptr;  // null: none
  std::string text;
};

Fault request_fault(const RenderSettingsDescription& d) {
  const Rect2i window = d.window();
  if (d.width < 1 || d.height < 1 || d.width > kMostPixels || d.height > kMostPixels)
    return {"record.resolution", "width and height must be from 1 to 65536"};
  const auto fits = [](int first, int last) { return first < last && int64_t(last) - first <= kMostPixels; };
  const bool square_enough = d.pixelAspectRatio >= 1e-6f && d.pixelAspectRatio <= 1e6f;  // OpenEXR's limits
  if (!fits(window.minX, window.maxX) || !fits(window.minY, window.maxY) || !square_enough)
    return {"record.framing",
            "the crop must be 1 to 65536 pixels wide and high, and pixelAspectRatio from 1e-6 to 1e6"};
  if (!window.overlaps(d.frame_window()))
    return {"record.crop",
            "the crop lies wholly outside the frame of " + support::size_text(d.width, d.height) + " pixels"};
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

// Those of the lights and meshes, and light without a group.
std::set<std::string> light_groups_of(const RetainedSceneDelegate& scene) {
  std::set<std::string> names{""};
  for (const auto& [path, light] : scene.GetLights())
    if (const auto group = light.parameters.find("lightGroup"); light.visible && group != light.parameters.end())
      names.insert(group->second.text_or(""));
  for (const auto& [path, mesh] : scene.GetMeshes())
    if (const auto group = mesh.primvars.find("lightGroup"); group != mesh.primvars.end())
      names.insert(group->second.value.text_or(""));
  return names;
}

const std::string kAllLightGroups = aov_info(Aov::light_group).name + std::string("*");

void expand_light_groups(const std::set<std::string>& groups, std::vector<RenderVar>* vars) {
  std::vector<RenderVar> all;
  for (const RenderVar& var : *vars) {
    if (var.aov.str() != kAllLightGroups) {
      all.push_back(var);
      continue;
    }
    const bool usual = var.name.empty() || var.name == kAllLightGroups;
    for (const std::string& group : groups)
      all.push_back({usual           ? ""
                     : group.empty() ? var.name
                                     : var.name + "_" + group,
                     aov_info(Aov::light_group).name + group, var.dataType});
  }
  *vars = std::move(all);
}

// The scene's, else the delegate's.
double setting_of(const char* name, const RenderSettingsDescription& d, const RenderDelegate& delegate) {
  const auto own = d.settings.find(name);
  return (own != d.settings.end() ? own->second : delegate.GetRenderSetting(name)).number_or(0);
}

Fault aov_fault(const RenderDelegate& delegate, const std::set<std::string>& aovs) {
  for (const std::string& aov : aovs)
    if (delegate.GetDefaultAovDescriptor(aov).format == Format::invalid) return {"record.aov", NoSuchAov(aov)};
  if (const auto groups = std::count_if(aovs.begin(), aovs.end(), [](const auto& aov) { return is_light_group(aov); });
      groups > static_cast<std::ptrdiff_t>(kMostLightGroups))
    return {"record.aov", "the frame has " + std::to_string(groups) + " AOVs of light groups, and " +
                              std::to_string(kMostLightGroups) +
                              " are the most: name those that you want, lightGroup:NAME"};
  return {};
}

// The crop of a picture of another size: all pixels that it touches there.
Rect2i scaled(const Rect2i& crop, const RenderSettingsDescription& from, int width, int height) {
  const double x = double(width) / from.width, y = double(height) / from.height;
  return {static_cast<int>(std::floor(crop.minX * x)), static_cast<int>(std::floor(crop.minY * y)),
          static_cast<int>(std::ceil(crop.maxX * x)), static_cast<int>(std::ceil(crop.maxY * y))};
}

// The picture of a product, without its AOVs.
FrameRequest picture_of(const RenderSettingsDescription& settings, const RenderProduct& product) {
  FrameRequest picture{settings, !product.disableMotionBlur, !product.disableDepthOfField, {}};
  RenderSettingsDescription& d = picture.description;
  d.products = {product};
  if (!product.camera.empty()) d.camera = product.camera;
  if (product.width != 0) d.width = product.width;
  if (product.height != 0) d.height = product.height;
  if (settings.crop && settings.width > 0 && settings.height > 0)
    d.crop = scaled(*settings.crop, settings, d.width, d.height);
  return picture;
}

bool shows_the_same(const FrameRequest& a, const FrameRequest& b) {
  return a.description.camera == b.description.camera && a.description.width == b.description.width &&
         a.description.height == b.description.height && a.motion_blur == b.motion_blur &&
         a.depth_of_field == b.depth_of_field;
}

std::vector<FrameRequest> pictures_of(const RenderSettingsDescription& settings) {
  if (settings.products.empty()) return {{settings, true, true, {}}};
  std::vector<FrameRequest> pictures;
  for (const RenderProduct& product : settings.products) {
    FrameRequest picture = picture_of(settings, product);
    const auto same = std::find_if(pictures.begin(), pictures.end(),
                                   [&](const FrameRequest& other) { return shows_the_same(picture, other); });
    if (same == pictures.end())
      pictures.push_back(std::move(picture));
    else
      same->description.products.push_back(product);
  }
  return pictures;
}

}  // namespace

FramePlan PlanFrame(const RetainedSceneDelegate& scene, const Path& settings, const RenderDelegate& delegate,
                    const RecordOptions& options) {
  const FloatEnvironment environment;
  FramePlan plan;
  const auto refusal = [&](const Fault& fault) {
    if (options.diagnostics) options.diagnostics({Severity::error, fault.code, settings.str(), fault.text});
    static_cast<RecordEnd&>(plan) = {RecordStatus::input_failed, fault.code, fault.text};
    return plan;
  };
  const auto found = scene.GetAllRenderSettings().find(settings);
  if (found == scene.GetAllRenderSettings().end())
    return refusal({"record.settings", "there are no such render settings"});
  RenderSettingsDescription all = found->second;
  if (!options.products.empty()) all.products = options.products;
  const bool denoise = setting_of("denoise", all, delegate) != 0;
  const int ranks = static_cast<int>(setting_of("cryptoRanks", all, delegate));
  const std::set<std::string> groups =
      options.light_groups.empty() ? light_groups_of(scene)
                                   : std::set<std::string>(options.light_groups.begin(), options.light_groups.end());
  for (RenderProduct& product : all.products) {
    product.denoise = product.denoise.value_or(denoise);
    ResolveRenderVars(ranks, &product.vars);
    expand_light_groups(groups, &product.vars);
  }

  // The pictures
  std::vector<FrameRequest> pictures = pictures_of(all);
  for (const FrameRequest& picture : pictures) {
    if (const Fault fault = request_fault(picture.description); fault.code) return refusal(fault);
    if (const Fault fault = camera_fault(scene, picture.description.camera); fault.code) return refusal(fault);
  }
  if (pictures.size() > 1 && (options.resume || !options.checkpoint.empty()))
    return refusal(
        {"record.checkpoint",
         "a checkpoint holds one picture, but the products have several cameras or sizes: render them one by one"});

  // Their files. A configuration that cannot be read is a product's fault.
  OutputColors colors = options.colors;
  colors.held = plan.colors = colors.config({});
  for (FrameRequest& picture : pictures)
    for (const RenderProduct& product : picture.description.products) {
      const ProductCheck check = plan_product(product, picture.description.window(), colors, options.diagnostics,
                                              &picture.files.emplace_back());
      if (check) continue;
      const bool memory = check.status == ProductStatus::out_of_memory;
      static_cast<RecordEnd&>(plan) = {memory ? RecordStatus::render_failed : RecordStatus::output_failed,
                                       "record.product", "'" + product.file + "': " + check.text};
      plan.product = check.status;
      return plan;
    }

  // Their AOVs
  for (FrameRequest& picture : pictures) {
    picture.aovs = aovs_of(picture.description.products);
    if (denoise && picture.aovs.contains("color")) picture.aovs.insert("denoised");  // else color would show it
    for (const std::string& aov : options.aovs) picture.aovs.insert(aov_of_light_paths(aov));
    if (picture.aovs.erase(kAllLightGroups) != 0)
      for (const std::string& group : groups) picture.aovs.insert(aov_info(Aov::light_group).name + group);
    if (const Fault fault = aov_fault(delegate, picture.aovs); fault.code) return refusal(fault);
  }
  plan.pictures = std::make_shared<const std::vector<FrameRequest>>(std::move(pictures));
  return plan;
}

std::string NoSuchAov(const std::string& name) {
  if (std::string fault = light_paths_fault(name); !fault.empty()) return fault;
  std::vector<std::string> known;
  std::string all;
  for (const AovInfo& aov : kAovs) {
    known.emplace_back(aov.name);
    all += (all.empty() ? "" : ", ") + known.back();
  }
  return "there is no AOV '" + name + "'" + support::DidYouMean(name, known, "; there are " + all);
}

}  // namespace alabaster::hd::host
