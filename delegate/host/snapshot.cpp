#include "delegate/host/snapshot.h"

#include <algorithm>

#include "core/math/float_environment.h"
#include "delegate/host/planned_product.h"

namespace alabaster::hd::host {
namespace {

/// A buffer's pixels as floats, or as ints where it holds those. Rows bottom-up.
struct Pixels {
  std::vector<float> floats;
  std::vector<int32_t> ints;
  int components = 0;
};

/// Without components if the buffer has another size.
Pixels read(RenderBuffer& buffer, const Vec2i& size) {
  constexpr Format kFloats[] = {Format::float32, Format::float32vec2, Format::float32vec3, Format::float32vec4};
  Pixels pixels;
  PixelMemory memory;
  memory.yDown = false;
  memory.size = size;
  memory.format = buffer.GetFormat();
  const int components = FormatComponents(memory.format);
  if (components == 0) return pixels;
  const size_t count = static_cast<size_t>(size.x) * static_cast<size_t>(size.y);
  if (memory.format == Format::int32) {
    pixels.ints.resize(count);
    memory.pixels = pixels.ints.data();
  } else {
    memory.format = kFloats[components - 1];
    pixels.floats.resize(count * static_cast<size_t>(components));
    memory.pixels = pixels.floats.data();
  }
  memory.rowBytes = static_cast<size_t>(size.x) * FormatSize(memory.format);
  if (buffer.ResolveTo(&memory)) pixels.components = components;
  return pixels;
}

/// Convergence may not be latched yet: a render that is over without it is neither stopped nor failed.
bool is_over(RenderPass& pass) {
  const bool over = pass.WaitForConvergence(0);
  const PassState state = pass.GetState();
  return over && (state == PassState::converged || state == PassState::rendering);
}

}  // namespace

bool WriteSnapshot(const RenderDelegate& delegate, RenderPass& pass, const RenderPassState& state,
                   const RenderProduct& product, const OutputColors& colors, const DiagnosticSink& sink) {
  const FloatEnvironment environment;
  const auto fail = [&](const std::string& text) {
    if (sink) sink({Severity::error, "snapshot", product.file, text});
    return false;
  };
  PlannedProduct planned;
  if (!plan_product(product, state.framing.dataWindow, colors, sink, &planned)) return false;
  ProductImage image;
  image.incomplete = !is_over(pass);  // before pixels are read
  image.framing = state.framing;
  const Vec2i size(state.framing.dataWindow.width(), state.framing.dataWindow.height());
  std::map<std::string, Pixels> held;
  for (const RenderVar& var : WantedVars(product)) {
    const auto binding = std::find_if(state.aovBindings.begin(), state.aovBindings.end(),
                                      [&](const AovBinding& b) { return b.aovName == var.aov && b.renderBuffer; });
    if (binding == state.aovBindings.end()) return fail("AOV '" + var.aov.str() + "' is not bound");
    Pixels& pixels = held[var.aov.str()] = read(*binding->renderBuffer, size);
    if (pixels.components == 0)
      return fail("the buffer of AOV '" + var.aov.str() + "' is not as large as the data window");
    image.aovs[var.aov.str()] = {pixels.components, pixels.floats, pixels.ints};
  }
  image.metadata = ProductMetadata(delegate, delegate.GetRenderStats(), state.camera);
  return write_planned({planned}, image, sink).size() == 1;
}

}  // namespace alabaster::hd::host
