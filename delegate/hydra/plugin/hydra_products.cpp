#include "delegate/hydra/plugin/hydra_products.h"

#include <pxr/imaging/hd/tokens.h>

#include <algorithm>
#include <cmath>

#include "delegate/host/frame_recorder.h"
#include "delegate/hydra/plugin/hydra_prims.h"

namespace alabaster::hydra {
namespace {

using Product = pxr::HdRenderSettings::RenderProduct;

// UsdRender has applied the policy to the aperture, which is the camera's again here: the same picture.
hd::WindowPolicy to_policy(const pxr::TfToken& policy) {
  if (policy == "cropAperture") return hd::WindowPolicy::crop;
  if (policy == "adjustApertureWidth") return hd::WindowPolicy::matchVertically;
  if (policy == "adjustApertureHeight") return hd::WindowPolicy::matchHorizontally;
  return policy == "adjustPixelAspectRatio" ? hd::WindowPolicy::dontConform : hd::WindowPolicy::fit;
}

// The window's NDC begin at the lower left, pixels at the upper one.
hd::Framing to_framing(const Product& product) {
  const int width = product.resolution[0], height = product.resolution[1];
  const auto &low = product.dataWindowNDC.GetMin(), &high = product.dataWindowNDC.GetMax();
  const auto pixel = [](float part, int size) { return static_cast<int>(std::ceil(part * static_cast<float>(size))); };
  hd::Framing framing;
  framing.displayMax = {static_cast<float>(width), static_cast<float>(height)};
  framing.dataWindow = {pixel(low[0], width), height - pixel(high[1], height), pixel(high[0], width),
                        height - pixel(low[1], height)};
  framing.pixelAspectRatio = product.pixelAspectRatio;
  return framing;
}

hd::RenderVar to_var(const Product::RenderVar& theirs) {
  const auto layer = theirs.namespacedSettings.find("driver:parameters:aov:name");
  return TranslateRenderVar({theirs.varPath.GetName(), theirs.sourceName, theirs.sourceType.GetString(),
                             theirs.dataType.GetString(),
                             layer == theirs.namespacedSettings.end() ? "" : ToValue(layer->second).text_or("")});
}

hd::CameraDescription camera_of(const Product& product, const HydraCamera& camera) {
  hd::CameraDescription description = camera.description();
  if (product.disableMotionBlur) description.parameters["shutterOpen"] = description.parameters["shutterClose"] = 0.0;
  if (product.disableDepthOfField) description.parameters["fStop"] = 0.0f;
  return description;
}

}  // namespace

void HydraProducts::set(const pxr::HdRenderSettings::RenderProducts& products,
                        const std::vector<hd::Token>& render_tags) {
  stop();
  products_ = products;
  render_tags_ = render_tags;
  next_ = 0;
}

void HydraProducts::fault(const Product& product, const std::string& text) const {
  sink_({hd::Severity::error, "hydra.product", product.productPath.GetString(), text});
}

// Variables that the renderer does not have are no fault of a stage that was made for others.
hd::RenderProduct HydraProducts::to_product(const Product& theirs) const {
  hd::RenderProduct ours;
  ours.file = theirs.name.GetString();
  for (const Product::RenderVar& their_var : theirs.renderVars) {
    const hd::RenderVar var = to_var(their_var);
    std::string fault = hd::host::LightPathsFault(var);
    if (fault.empty() && delegate_->GetDefaultAovDescriptor(var.aov).format == hd::Format::invalid)
      fault = hd::host::NoSuchAov(var.aov.str());
    const auto is_same = [&](const hd::RenderVar& other) { return other.name == var.name && other.aov == var.aov; };
    if (!fault.empty())
      sink_({hd::Severity::warning, "hydra.product", their_var.varPath.GetString(),
             "layer " + var.name + " is not written: " + fault});
    else if (std::none_of(ours.vars.begin(), ours.vars.end(), is_same))
      ours.vars.push_back(var);
  }
  if (ours.vars.empty()) ours.vars.push_back(hd::host::UsualRenderVar("color"));
  hd::host::ResolveRenderVars(static_cast<int>(delegate_->GetRenderSetting("cryptoRanks").number_or(0)), &ours.vars);
  return ours;
}

// Several layers may show one AOV, which has one buffer.
bool HydraProducts::bind(const hd::RenderProduct& product, hd::RenderPassState* state) {
  const hd::Rect2i& window = state->framing.dataWindow;
  for (const hd::RenderVar& var : product.vars) {
    if (running_->buffers.contains(var.aov)) continue;
    const hd::Path id("/alabasterProduct/" + var.aov.str());
    auto* const buffer = static_cast<hd::RenderBuffer*>(delegate_->CreateBprim("renderBuffer", id));
    running_->buffers[var.aov] = buffer;
    const hd::AovDescriptor aov = delegate_->GetDefaultAovDescriptor(var.aov);
    if (!buffer || !buffer->Allocate({.dimensions = {window.width(), window.height(), 1}, .format = aov.format}))
      return false;
    state->aovBindings.push_back({var.aov, buffer, aov.clearValue});
  }
  return true;
}

bool HydraProducts::begin(const Product& product, const pxr::HdRenderIndex& index) {
  if (!product.type.IsEmpty() && product.type != "raster")
    return fault(product, "is of type '" + product.type.GetString() + "'; only raster is written"), false;
  const auto* camera =
      dynamic_cast<const HydraCamera*>(index.GetSprim(pxr::HdPrimTypeTokens->camera, product.cameraPath));
  if (!camera) return fault(product, "has no camera; give the render settings or the product one"), false;
  hd::RenderPassState state;
  state.freeCamera = camera_of(product, *camera);
  state.framing = to_framing(product);
  state.windowPolicy = to_policy(product.aspectRatioConformPolicy);
  state.renderTags = render_tags_;
  if (!state.framing.valid()) return fault(product, "has no pixels: its resolution or its window is empty"), false;
  running_.emplace();
  running_->product = to_product(product);
  running_->product.camera = ToPath(product.cameraPath);
  running_->image.framing = state.framing;
  // Buffers are as large as the data window, and begin at the origin.
  const hd::Rect2i& window = running_->image.framing.dataWindow;
  const hd::Vec2f corner(static_cast<float>(window.minX), static_cast<float>(window.minY));
  state.framing.displayMin -= corner, state.framing.displayMax -= corner;
  state.framing.dataWindow = {0, 0, window.width(), window.height()};
  if (!hd::host::CheckProduct(running_->product, window, {}, sink_) || !bind(running_->product, &state)) return false;
  running_->driver = std::make_unique<PassDriver>(delegate_->CreateRenderPass());
  running_->driver->Execute(state);
  return true;
}

void HydraProducts::write() {
  for (const auto& [aov, buffer] : running_->buffers) {
    const auto count = static_cast<size_t>(hd::FormatComponents(buffer->GetFormat()));
    const size_t values = count * static_cast<size_t>(buffer->GetWidth()) * static_cast<size_t>(buffer->GetHeight());
    hd::host::AovPixels& pixels = running_->image.aovs[aov.str()];
    pixels.components = static_cast<int>(count);
    const void* const data = MapResolved(buffer);
    if (buffer->GetFormat() == hd::Format::int32)
      pixels.ints = {static_cast<const int32_t*>(data), values};
    else
      pixels.floats = {static_cast<const float*>(data), values};
  }
  const hd::CommandResult named = delegate_->InvokeCommand("names", {});
  if (const auto names = named.value.get_or(std::shared_ptr<const hd::Dictionary>())) running_->image.names = *names;
  running_->image.metadata =
      hd::host::ProductMetadata(*delegate_, delegate_->GetRenderStats(), running_->product.camera);
  hd::host::WriteProducts({running_->product}, running_->image, {}, sink_);
  for (const auto& [aov, buffer] : running_->buffers) buffer->Unmap();
}

void HydraProducts::stop() {
  if (!running_) return;
  running_->driver.reset();
  for (const auto& [aov, buffer] : running_->buffers) {
    if (!buffer) continue;
    buffer->Finalize(delegate_->GetRenderParam());
    delegate_->DestroyBprim(buffer);
  }
  running_.reset();
}

void HydraProducts::Execute(const pxr::HdRenderIndex& index) {
  if (!running_ && next_ >= products_.size() && changes_ != changes_seen_) next_ = 0;
  if (!running_ && next_ == 0) changes_seen_ = changes_;
  while (!running_ && next_ < products_.size())
    if (!begin(products_[next_++], index)) stop();
}

bool HydraProducts::IsConverged(const pxr::HdRenderIndex& index) {
  if (!running_) return next_ >= products_.size();
  if (!running_->driver->IsConverged()) return false;
  write();
  stop();
  Execute(index);
  return !running_;
}

}  // namespace alabaster::hydra
