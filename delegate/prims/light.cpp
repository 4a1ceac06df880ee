#include "core/color/blackbody.h"
#include "core/light/ies_profile.h"
#include "core/subsurface/built_once.h"

#include "delegate/prims/motion.h"
#include "delegate/prims/parameters.h"
#include "delegate/prims/prims.h"
#include "delegate/support/color_space.h"

namespace alabaster::hd::prims {

/// The files that a light names. They are read once, however often the light moves.
struct LightFiles {
  TextureSource image, profile;

  struct Contents {
    std::shared_ptr<const Texture> texture;
    std::shared_ptr<const IesProfile> ies;
    std::optional<std::string> fault;
  };
  BuiltOnce<Contents> contents = {};

  static bool is_named(const TextureSource& source) { return !source.path.empty() || source.bytes; }
  Contents read(const Path& light, SceneParam& param, const CancelToken& cancel) const {
    Contents out;
    const alabaster::DiagnosticSink sink = [&](const alabaster::Diagnostic& d) { param.file_faults().add(light, d); };
    if (is_named(image)) out.texture = param.texture(image, &out.fault, sink, cancel);
    if (is_named(profile)) out.ies = param.profile(profile, &out.fault, sink);
    return out;
  }
};

namespace {

// Null if the light names no file.
std::shared_ptr<LightFiles> pull_files(SceneDelegate& scene, const Path& id, LightType type) {
  auto files = std::make_shared<LightFiles>();
  if (type != LightType::dome && type != LightType::distant) {
    files->profile = source_of(scene.GetLightParamValue(id, "shaping:ies:file"));
  }
  if (type == LightType::dome || type == LightType::rect) {
    files->image = source_of(scene.GetLightParamValue(id, "texture:file"));
    files->image.layer = scene.GetLightParamValue(id, "texture:layer").text_or("");
    files->image.is_environment = type == LightType::dome;
  }
  return LightFiles::is_named(files->image) || LightFiles::is_named(files->profile) ? files : nullptr;
}

}  // namespace

void LightPrim::reread(const std::string& file, SceneParam& param) {
  if (!files_ || !(names_image(files_->image.path, file) || names_image(files_->profile.path, file))) return;
  auto again = std::make_shared<LightFiles>();
  again->image = files_->image;
  again->profile = files_->profile;
  files_ = std::move(again);
  post(param);
}

DirtyBits LightPrim::post_record(SceneDelegate& scene, SceneParam& param, DirtyBits bits) {
  if (bits & dirty::kTransform) {
    record_.light.light_to_world = scene.GetTransform(GetId());
    record_.motion = checked_motion(scene.SampleTransform(GetId()), GetId(), param.sink());
  }
  if (bits & dirty::kParams) {
    record_.light_link = scene.GetLightParamValue(GetId(), "lightLink").text_or("");
    record_.shadow_link = scene.GetLightParamValue(GetId(), "shadowLink").text_or("");
    record_.light_group = scene.GetLightParamValue(GetId(), "lightGroup").text_or("");
    const auto get = [&](const char* name) { return scene.GetLightParamValue(GetId(), name); };
    read_parameters(light_parameters(), get, GetId().str(), param.sink(), &record_.light);
    const Token space(std::string("color") + support::kColorSpace);
    if (scene.GetLightParamValue(GetId(), space).text_or("") == support::kLinearRec709)
      if (const auto to_rendering = param.rec709_to_rendering()) {
        const Rgb color = (*to_rendering)(record_.light.color);
        record_.light.color = {std::max(color.r, 0.0f), std::max(color.g, 0.0f), std::max(color.b, 0.0f)};
      }
  }
  if (bits & dirty::kVisibility) record_.visible = scene.GetVisible(GetId());
  if (bits & (dirty::kParams | dirty::kResource)) {
    // OpenColorIO ends the process if memory runs out in here: lights without a temperature do not call it.
    const ColorConfig& colors = param.colors();
    record_.light.color_of_temperature =
        record_.light.enable_color_temperature
            ? blackbody(record_.light.color_temperature, colors.chromaticities(colors.rendering_space()))
            : Rgb(1.0f);
    files_ = pull_files(scene, GetId(), record_.light.type);
    if (files_) param.set_reread(GetId(), [this, &param](const std::string& file) { reread(file, param); });
  }
  post(param);
  return dirty::kClean;
}

void LightPrim::post(SceneParam& param) {
  if (!files_) return param.post(GetId(), record_);
  param.post_unread(GetId(), [&param, id = GetId(), record = record_, files = files_](const CancelToken& cancel) {
    const LightFiles::Contents& contents = files->contents.get([&] { return files->read(id, param, cancel); });
    LightRecord read = record;
    read.light.texture = contents.texture, read.light.ies = contents.ies, read.fault = contents.fault;
    return read;
  });
}

}  // namespace alabaster::hd::prims
