#include <cmath>
#include <filesystem>
#include <stdexcept>

#include "delegate/archive/archive.h"
#include "delegate/support/selection.h"

namespace alabaster::hd::archive {
namespace {

constexpr const char* kSettingsPath = "renderSettingsPrimPath";

void set_framing(const Framing& framing, RenderSettingsDescription* settings) {
  const Rect2i& data = framing.dataWindow;
  if (data.empty()) throw std::runtime_error("the pass has no pixels; give its framing a data window");
  const Vec2f corner = framing.displayMin, size = framing.displayMax - framing.displayMin;
  settings->pixelAspectRatio = framing.pixelAspectRatio;
  settings->width = data.width(), settings->height = data.height();
  settings->crop.reset();
  if (!(size.x > 0 && size.y > 0)) return;
  for (const float n : {size.x, size.y, corner.x, corner.y})
    if (n != std::trunc(n) || std::abs(n) > 0x1p24f)
      throw std::runtime_error("the display window ends within pixels, which is not written; give it whole numbers");
  settings->width = static_cast<int>(size.x), settings->height = static_cast<int>(size.y);
  const int x = static_cast<int>(corner.x), y = static_cast<int>(corner.y);
  const Rect2i crop = {data.minX - x, data.minY - y, data.maxX - x, data.maxY - y};
  if (crop != settings->frame_window()) settings->crop = crop;
}

std::vector<Token> purposes_of(const std::vector<Token>& render_tags) {
  std::vector<Token> purposes;
  for (const Token& tag : render_tags) purposes.push_back(tag == Token("geometry") ? Token("default") : tag);
  return purposes;
}

void add_settings(const std::map<Token, Value>& given, RenderSettingsDescription* settings, SceneInfo* info) {
  for (const auto& [name, value] : given) {
    if (value.empty() || name == Token(kSettingsPath)) continue;
    if (name == Token("ocio")) {
      info->color_config.resolved = value.text_or("");
      continue;
    }
    settings->settings[name.str()] = value;
    if (name == Token("frame")) settings->frame = value.number_or(0);
  }
}

/// The render settings to draw with, and their path.
std::pair<Path, RenderSettingsDescription> own_settings(const host::Prims& prims,
                                                        const std::map<Token, Value>& settings) {
  const auto named = settings.find(kSettingsPath);
  const Path path(named == settings.end() ? std::string() : named->second.text_or(""));
  const auto* found = host::FindPrim<RenderSettingsDescription>(prims, path);
  return found ? std::pair(path, *found) : std::pair(Path("/render"), RenderSettingsDescription());
}

std::string write(const std::string& file, const host::Prims& prims, const RenderPassState& state,
                  const std::map<Token, Value>& settings, SceneInfo info) {
  auto [path, drawn] = own_settings(prims, settings);
  info.settings = path;
  if (drawn.products.empty()) {
    RenderProduct product;
    product.file = std::filesystem::path(file).stem().string() + ".exr", product.dataType = "float";
    drawn.products = {product};
  }
  add_settings(settings, &drawn, &info);
  set_framing(state.framing, &drawn);
  drawn.windowPolicy = state.windowPolicy;
  drawn.includedPurposes = purposes_of(state.renderTags);
  host::Prims all = prims;
  if (!state.camera.empty()) drawn.camera = state.camera;
  if (state.freeCamera) all[drawn.camera = Path("/freeCamera")] = *state.freeCamera;
  if (!host::FindPrim<CameraDescription>(all, drawn.camera))
    return drawn.camera.empty() ? "the pass has no camera; name one of the scene, or give one"
                                : drawn.camera.str() + " is no camera of the scene; name one that is";
  const support::Selection selection({}, state.collection);
  for (auto& [id, prim] : all)
    if (auto* mesh = std::get_if<host::MeshDescription>(&prim))
      mesh->visible = mesh->visible && selection.includes(id, true, "geometry");
  all[path] = std::move(drawn);
  return WriteArchive(file, all, info);
}

}  // namespace

std::string WritePass(const std::string& file, const host::Prims& prims, const RenderPassState& state,
                      const std::map<Token, Value>& settings, SceneInfo info) {
  try {
    return write(file, prims, state, settings, std::move(info));
  } catch (const std::bad_alloc&) {
    return "memory ran out";
  } catch (const std::exception& e) {
    return e.what();
  }
}

}  // namespace alabaster::hd::archive
