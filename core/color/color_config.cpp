#include "core/color/color_config.h"

#include <algorithm>
#include <atomic>
#include <cctype>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <mutex>
#include <optional>
#include <set>
#include <sstream>

#include "core/color/builtin_config.h"
#include "core/color/chromaticities.h"
#include "core/color/config_check.h"
#include "core/color/config_inputs.h"
#include "core/color/config_numbers.h"
#include "core/color/known_code_points.h"
#include "core/color/ocio_transform.h"
#include "core/math/largest_half.h"

namespace OCIO = OCIO_NAMESPACE;

namespace alabaster {
namespace {

constexpr const char* kBuiltinOrigin = "built-in";

std::string join(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : ", ") + name;
  return text.empty() ? "none" : text;
}

bool contains(const std::vector<std::string>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

/// The names that OCIO gives one by one.
template <class NameAt>
std::vector<std::string> list(int count, const NameAt& name_at) {
  std::vector<std::string> names;
  for (int i = 0; i < count; ++i) names.emplace_back(name_at(i));
  return names;
}

OCIO::ConstConfigRcPtr parse_config(const std::string& yaml) {
  std::istringstream text(streams_read_decimal_points() ? yaml : with_whole_numbers(yaml));
  return OCIO::Config::CreateFromStream(text);
}

OCIO::ConstConfigRcPtr builtin_config() {
  static const OCIO::ConstConfigRcPtr config = parse_config(builtin_config_text());
  return config;
}

/// As OpenColorIO reads a file of that name: its LUTs are found from the file's folder.
OCIO::ConstConfigRcPtr parse_config_file(const std::string& text, const std::string& path) {
  const OCIO::ConfigRcPtr config = parse_config(text)->createEditableCopy();
  config->setWorkingDir(std::filesystem::absolute(path).lexically_normal().parent_path().c_str());
  return config;
}

/// Names after a `$`, a `${` or a `%`, as OpenColorIO writes variables.
std::set<std::string> variable_names(const std::string& text) {
  const auto is_of_name = [](char c) { return std::isalnum(static_cast<unsigned char>(c)) || c == '_'; };
  std::set<std::string> names;
  for (size_t at = text.find_first_of("$%"); at != std::string::npos; at = text.find_first_of("$%", at)) {
    const size_t first = text.compare(at, 2, "${") == 0 ? at + 2 : at + 1;
    at = first;
    while (at < text.size() && is_of_name(text[at])) ++at;
    if (at > first && !std::isdigit(static_cast<unsigned char>(text[first])))
      names.insert(text.substr(first, at - first));
  }
  return names;
}

/// The meaning of a colour space name in some config.
struct SpaceMeaning {
  enum class Kind { unknown, rendering, data, in_config, in_builtin } kind = Kind::unknown;
  std::string name;  // of the space, for in_config and in_builtin
};

class OcioColorConfig final : public ColorConfig {
 public:
  /// `text`: of the configuration, as it was read.
  OcioColorConfig(OCIO::ConstConfigRcPtr config, std::string origin, std::string rendering, std::string text)
      : config_(std::move(config)),
        origin_(std::move(origin)),
        rendering_(std::move(rendering)),
        text_(std::move(text)) {}

  std::string origin() const override { return origin_; }
  std::string rendering_space() const override { return rendering_; }
  std::vector<std::string> color_spaces() const override {
    return list(config_->getNumColorSpaces(), [&](int i) { return config_->getColorSpaceNameByIndex(i); });
  }
  std::vector<std::string> displays() const override {
    return list(config_->getNumDisplays(), [&](int i) { return config_->getDisplay(i); });
  }
  std::string default_display() const override { return config_->getDefaultDisplay(); }
  std::vector<std::string> views(const std::string& display) const override {
    const char* name = display.c_str();
    return list(config_->getNumViews(name), [&](int i) { return config_->getView(name, i); });
  }
  std::string default_view(const std::string& display) const override {
    const char* view = config_->getDefaultView(display.c_str());
    return view ? view : "";
  }
  std::vector<std::string> looks() const override {
    return list(config_->getNumLooks(), [&](int i) { return config_->getLookNameByIndex(i); });
  }
  std::array<float, 8> chromaticities(const std::string& space) const override;
  std::shared_ptr<const ColorTransform> to_rendering_space(const std::string& from,
                                                           const DiagnosticSink& sink) const override {
    return convert(from, true, sink);
  }
  std::shared_ptr<const ColorTransform> from_rendering_space(const std::string& to,
                                                             const DiagnosticSink& sink) const override {
    return convert(to, false, sink);
  }
  std::shared_ptr<const ColorTransform> display_transform(const DisplayRequest& request,
                                                          const DiagnosticSink& sink) const override;
  std::optional<CodePoints> code_points(const std::string& display, const std::string& view) const override;
  std::string serialize() const override;
  ConfigInputs inputs() const;
  void report_unknown_primaries(const DiagnosticSink& sink) const;

 private:
  SpaceMeaning meaning_of(const std::string& name) const;
  bool is_scene_space(const char* name) const;
  const char* interchange_role() const;
  std::shared_ptr<const ColorTransform> convert(const std::string& name, bool to_rendering,
                                                const DiagnosticSink& sink) const;
  OCIO::ConstProcessorRcPtr through_builtin(const std::string& builtin_space, bool to_rendering,
                                            const DiagnosticSink& sink) const;
  bool check_view(const std::string& display, const std::string& view, const DiagnosticSink& sink) const;
  bool check_looks(const std::string& looks, const DiagnosticSink& sink) const;
  XyzColumns columns_of(const std::string& space) const;
  void fail(const DiagnosticSink& sink, const char* code, std::string text) const {
    report(sink, Severity::error, code, origin_, std::move(text));
  }

  OCIO::ConstConfigRcPtr config_;
  std::string origin_;
  std::string rendering_;
  std::string text_;
  mutable std::atomic<bool> has_warned_ = false;  // that primaries are not known
};

bool OcioColorConfig::is_scene_space(const char* name) const {
  const auto space = config_->getColorSpace(name);
  return space && !space->isData() && space->getReferenceSpaceType() == OCIO::REFERENCE_SPACE_SCENE;
}

// The config's own definition of a name goes first: an artist who writes "sRGB" means the sRGB of the show. Names that
// must work everywhere fall back to the names that common configs use, then to the built-in config's definition.
SpaceMeaning OcioColorConfig::meaning_of(const std::string& name) const {
  using Kind = SpaceMeaning::Kind;
  if (name == "auto") return {Kind::rendering, {}};
  if (name == "raw" || name == "data") return {Kind::data, {}};
  const bool srgb = name == "sRGB" || name == "srgb_texture";
  const bool linear = name == "linear" || name == "lin_rec709";
  if (!srgb && !linear) {
    const auto space = config_->getColorSpace(name.c_str());
    if (!space) return {};
    return space->isData() ? SpaceMeaning{Kind::data, {}} : SpaceMeaning{Kind::in_config, space->getName()};
  }
  if (is_scene_space(name.c_str())) return {Kind::in_config, name};
  const std::vector<const char*> usual =
      srgb ? std::vector{"sRGB - Texture", "srgb_texture", "srgb_tx", "Utility - sRGB - Texture", "sRGB"}
           : std::vector{"Linear Rec.709 (sRGB)", "lin_rec709", "lin_srgb", "Utility - Linear - sRGB"};
  for (const char* candidate : usual)
    if (is_scene_space(candidate)) return {Kind::in_config, candidate};
  return {Kind::in_builtin, srgb ? "sRGB - Texture" : "Linear Rec.709"};
}

/// The role by which this config can be joined to the built-in one; null if it has none.
const char* OcioColorConfig::interchange_role() const {
  for (const char* role : {OCIO::ROLE_INTERCHANGE_SCENE, OCIO::ROLE_INTERCHANGE_DISPLAY})
    if (config_->hasRole(role)) return role;
  return nullptr;
}

OCIO::ConstProcessorRcPtr OcioColorConfig::through_builtin(const std::string& builtin_space, bool to_rendering,
                                                           const DiagnosticSink& sink) const {
  const OCIO::ConstConfigRcPtr builtin = builtin_config();
  if (const char* role = interchange_role()) {
    return to_rendering ? OCIO::Config::GetProcessorFromConfigs(builtin, builtin_space.c_str(), role, config_,
                                                                rendering_.c_str(), role)
                        : OCIO::Config::GetProcessorFromConfigs(config_, rendering_.c_str(), role, builtin,
                                                                builtin_space.c_str(), role);
  }
  report(sink, Severity::warning, "ocio.interchange.missing", origin_,
         "the configuration has no '" + builtin_space +
             "' and no aces_interchange or cie_xyz_d65_interchange role, so its '" + rendering_ +
             "' is taken to have Rec.709 primaries; give one of these roles, or name a colour space of the "
             "configuration");
  const char* linear = "Linear Rec.709";
  return to_rendering ? builtin->getProcessor(builtin_space.c_str(), linear)
                      : builtin->getProcessor(linear, builtin_space.c_str());
}

std::shared_ptr<const ColorTransform> OcioColorConfig::convert(const std::string& name, bool to_rendering,
                                                               const DiagnosticSink& sink) const {
  using Kind = SpaceMeaning::Kind;
  try {
    const QuietOcio quiet;
    const SpaceMeaning meaning = meaning_of(name);
    switch (meaning.kind) {
      case Kind::unknown:
        fail(
            sink, "ocio.space.unknown",
            "there is no colour space '" + name + "'; use sRGB, linear, raw, auto, or one of: " + join(color_spaces()));
        return nullptr;
      case Kind::rendering:
      case Kind::data:
        return make_transform(nullptr, 1, kLargestFloat);
      case Kind::in_config: {
        const char* space = meaning.name.c_str();
        return make_transform(to_rendering ? config_->getProcessor(space, rendering_.c_str())
                                           : config_->getProcessor(rendering_.c_str(), space),
                              1, kLargestFloat);
      }
      case Kind::in_builtin:
        return make_transform(through_builtin(meaning.name, to_rendering, sink), 1, kLargestFloat);
    }
  } catch (const std::exception& e) {
    fail(sink, "ocio.transform",
         "cannot convert between '" + name + "' and '" + rendering_ + "': " + e.what() +
             "; check that the configuration is complete, with the LUT files it names");
  }
  return nullptr;
}

bool OcioColorConfig::check_view(const std::string& display, const std::string& view,
                                 const DiagnosticSink& sink) const {
  if (!contains(displays(), display)) {
    fail(sink, "ocio.display.unknown", "there is no display '" + display + "'; use one of: " + join(displays()));
    return false;
  }
  if (!contains(views(display), view)) {
    fail(sink, "ocio.view.unknown",
         "display '" + display + "' has no view '" + view + "'; use one of: " + join(views(display)));
    return false;
  }
  return true;
}

/// `text`: OCIO's list of looks, divided by ',' or ':', each with '+' or '-' before it or without.
bool OcioColorConfig::check_looks(const std::string& text, const DiagnosticSink& sink) const {
  std::string list = text;
  std::replace(list.begin(), list.end(), ':', ',');
  std::istringstream stream(list);
  for (std::string look; std::getline(stream, look, ',');) {
    const size_t begin = look.find_first_not_of(" +-"), end = look.find_last_not_of(' ');
    if (begin == std::string::npos) continue;
    look = look.substr(begin, end - begin + 1);
    if (config_->getLook(look.c_str())) continue;
    fail(sink, "ocio.look.unknown", "there is no look '" + look + "'; the configuration's looks: " + join(looks()));
    return false;
  }
  return true;
}

std::shared_ptr<const ColorTransform> OcioColorConfig::display_transform(const DisplayRequest& request,
                                                                         const DiagnosticSink& sink) const {
  const std::string display = request.display.empty() ? default_display() : request.display;
  const std::string view = request.view.empty() ? default_view(display) : request.view;
  const float scale = std::exp2(request.exposure);
  if (!std::isnormal(scale)) {
    fail(sink, "ocio.exposure", "exposure must be a number of stops between -126 and 127");
    return nullptr;
  }
  try {
    const QuietOcio quiet;
    if (!check_view(display, view, sink) || !check_looks(request.look, sink)) return nullptr;
    const auto transform = OCIO::DisplayViewTransform::Create();
    transform->setSrc(rendering_.c_str());
    transform->setDisplay(display.c_str());
    transform->setView(view.c_str());
    const auto pipeline = OCIO::LegacyViewingPipeline::Create();
    pipeline->setDisplayViewTransform(transform);
    if (!request.look.empty()) {
      pipeline->setLooksOverrideEnabled(true);
      pipeline->setLooksOverride(request.look.c_str());
    }
    // The exposure is a plain scale in the scene-linear space, done with the scrub: OCIO sees values in half range.
    return make_transform(pipeline->getProcessor(config_), scale, kLargestHalf);
  } catch (const std::exception& e) {
    fail(sink, "ocio.transform",
         "cannot make view '" + view + "' of display '" + display + "': " + e.what() +
             "; check that the configuration is complete, with the LUT files it names");
  }
  return nullptr;
}

XyzColumns OcioColorConfig::columns_of(const std::string& space) const {
  const char* role = interchange_role();
  const auto processor =
      OCIO::Config::GetProcessorFromConfigs(config_, space.c_str(), role, builtin_config(), "CIE-XYZ-D65", role);
  std::array<float, 15> rgb = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 1, 1, 1};
  OCIO::PackedImageDesc image(rgb.data(), 5, 1, 3);
  processor->getDefaultCPUProcessor()->apply(image);
  XyzColumns columns{};
  for (size_t i = 0; i < 3; ++i) {
    double sum = 0;
    for (size_t j = 0; j < 3; ++j) {
      columns[j][i] = double(rgb[3 * (j + 1) + i]);
      sum += columns[j][i];
    }
    // Gamma curves keep 0 and 1 and so show their primaries; a log curve or a tone map does not, and has none to show.
    if (std::abs(rgb[i]) > 1e-3f || std::abs(sum - double(rgb[12 + i])) > 1e-3) return {};
  }
  return columns;
}

// Found by running the space's red, green, blue and white through one of the config's interchange roles to CIE XYZ (see
// chromaticities_of); a config without such a role, or a space that is data or not made of three primaries, gives
// Rec.709.
std::array<float, 8> OcioColorConfig::chromaticities(const std::string& name) const {
  using Kind = SpaceMeaning::Kind;
  try {
    const QuietOcio quiet;
    const SpaceMeaning meaning = name.empty() ? SpaceMeaning{Kind::rendering, {}} : meaning_of(name);
    const bool in_config = meaning.kind == Kind::in_config || meaning.kind == Kind::rendering;
    if (!in_config || !interchange_role()) return kRec709;
    return chromaticities_of(columns_of(meaning.kind == Kind::rendering ? rendering_ : meaning.name));
  } catch (const std::exception&) {
    return kRec709;  // a missing LUT is reported when the space is used
  }
}

std::optional<CodePoints> OcioColorConfig::code_points(const std::string& display, const std::string& view) const {
  try {
    const QuietOcio quiet;
    return known_code_points(config_, display.c_str(), view.c_str());
  } catch (const std::exception&) {
    return std::nullopt;  // a missing LUT is reported when the space is used
  }
}

void OcioColorConfig::report_unknown_primaries(const DiagnosticSink& sink) const {
  if (!sink || interchange_role() || has_warned_.exchange(true)) return;
  report(
      sink, Severity::warning, "ocio.interchange.missing", origin_,
      "the configuration has no aces_interchange or cie_xyz_d65_interchange role, so the chromaticities of an EXR are "
      "not known and those of Rec.709 are written; give one of these roles");
}

// OpenColorIO itself would write numbers as the host's locale has them.
std::string OcioColorConfig::serialize() const {
  return text_;
}

ConfigInputs OcioColorConfig::inputs() const {
  ConfigInputs inputs;
  inputs.library = OCIO::GetVersion();
  for (const char* name :
       {OCIO::OCIO_ACTIVE_DISPLAYS_ENVVAR, OCIO::OCIO_ACTIVE_VIEWS_ENVVAR, OCIO::OCIO_INACTIVE_COLORSPACES_ENVVAR}) {
    const char* value = std::getenv(name);
    inputs.variables[name] = value ? std::optional<std::string>(value) : std::nullopt;
  }
  const OCIO::ConstContextRcPtr context = config_->getCurrentContext();
  std::map<std::string, std::string> known;
  for (int i = 0; i < context->getNumStringVars(); ++i)
    known[context->getStringVarNameByIndex(i)] = context->getStringVarByIndex(i);
  for (const std::string& name : variable_names(text_)) {
    if (const auto found = known.find(name); found != known.end()) {
      inputs.variables[name] = found->second;
      continue;
    }
    if (config_->getEnvironmentMode() == OCIO::ENV_ENVIRONMENT_LOAD_ALL)
      inputs.variables.try_emplace(name, std::nullopt);  // else OpenColorIO does not look for it
    for (const auto& [begin, value] : known)             // "$SHOTS" refers to SHOT where SHOTS is no variable
      if (name.starts_with(begin)) inputs.variables[begin] = value;
  }
  try {
    const QuietOcio quiet;
    config_fault(config_, {}, &inputs.luts);
  } catch (const std::exception&) {
    // A part that OpenColorIO cannot read is reported where it is used.
  }
  return inputs;
}

/// Where a configuration comes from.
struct ConfigFile {
  std::string origin, within, remedy;
};

const char* opening_code(InputFile::Fault fault) {
  switch (fault) {
    case InputFile::Fault::missing:
      return "ocio.config.missing";
    case InputFile::Fault::none:  // too large
      return "ocio.config.invalid";
    default:
      return "ocio.config.unreadable";
  }
}

/// A configuration that is built into OpenColorIO, such as ocio://default; null and `fault` if none has this name.
OCIO::ConstConfigRcPtr named_config(const std::string& name, std::string* fault) {
#if OCIO_VERSION_HEX >= 0x02020000
  try {
    return OCIO::Config::CreateFromBuiltinConfig(name.c_str());
  } catch (const std::exception& e) {
    *fault = std::string("OpenColorIO ") + OCIO::GetVersion() + " has no such configuration: " + e.what();
  }
#else
  *fault = name.substr(0, 7) + " names configurations of OpenColorIO 2.2 or later; this is " + OCIO::GetVersion();
#endif
  return nullptr;
}

/// Null + report unless the file is one that OCIO can make sense of.
OCIO::ConstConfigRcPtr read_config(const ConfigFile& from, std::string* text, const DiagnosticSink& sink) {
  const auto fail = [&](const char* code, const std::string& text) {
    report(sink, Severity::error, code, from.origin, text + "; " + from.remedy);
    return OCIO::ConstConfigRcPtr();
  };
  if (from.origin.starts_with("ocio://")) {
    std::string fault;
    const OCIO::ConstConfigRcPtr config = named_config(from.origin, &fault);
    return config ? config : fail("ocio.config.builtin_name", fault);
  }
  const InputFile file(from.origin, from.within);
  if (file.fault() == InputFile::Fault::not_regular)
    return fail("ocio.config.unreadable", "this is not a file; name the config.ocio inside it");
  if (const std::string fault = read_config_text(file, text); !fault.empty())
    return fail(opening_code(file.fault()), fault);
  if (const std::string fault = config_text_fault(*text); !fault.empty()) return fail("ocio.config.invalid", fault);
  try {
    const OCIO::ConstConfigRcPtr config = parse_config_file(*text, from.origin);
    const std::string fault = config_fault(config, from.within);
    return fault.empty() ? config : fail("ocio.config.invalid", fault + "; mend it");
  } catch (const std::exception& e) {
    return fail("ocio.config.invalid",
                std::string("not a configuration that OpenColorIO ") + OCIO::GetVersion() + " can read: " + e.what());
  }
}

/// The configuration that was loaded last, and the state of its file. Checks and writers of several products ask for
/// the same one in turn.
class LastConfig {
 public:
  std::shared_ptr<const ColorConfig> find(const ConfigFile& from) const {
    const std::lock_guard lock(mutex_);
    const bool same = config_ && config_->origin() == from.origin && within_ == from.within;
    return same && state_ == state_of(from) ? config_ : nullptr;
  }
  void keep(const ConfigFile& from, std::shared_ptr<const ColorConfig> config) {
    const std::lock_guard lock(mutex_);
    state_ = state_of(from);
    within_ = from.within;
    config_ = std::move(config);
  }

 private:
  // A checksum of the file's content, because times are too coarse to tell two versions apart.
  static std::optional<size_t> state_of(const ConfigFile& from) {
    std::string text;
    if (!read_config_text(InputFile(from.origin, from.within), &text).empty()) return std::nullopt;
    return std::hash<std::string>()(text);
  }
  mutable std::mutex mutex_;
  std::shared_ptr<const ColorConfig> config_;
  std::optional<size_t> state_;
  std::string within_;  // its LUTs were judged by
};

std::shared_ptr<const ColorConfig> load_file(const ConfigFile& from, const DiagnosticSink& sink) {
  std::string text;
  const OCIO::ConstConfigRcPtr config = read_config(from, &text, sink);
  if (!config) return nullptr;
  const std::string& origin = from.origin;
  const auto linear = config->getColorSpace(OCIO::ROLE_SCENE_LINEAR);
  if (!linear) {
    report(sink, Severity::error, "ocio.role.missing", origin,
           "the configuration has no scene_linear role, so there is no space to render in; add one, or " + from.remedy);
    return nullptr;
  }
  try {
    config->validate();
  } catch (const std::exception& e) {
    report(sink, Severity::warning, "ocio.config.invalid", origin,
           std::string("the configuration has a fault: ") + e.what() +
               "; transforms that do not need that part will work");
  }
  return std::make_shared<OcioColorConfig>(config, origin, linear->getName(), text);
}

}  // namespace

std::shared_ptr<const ColorConfig> ColorConfig::load(const std::string& path, const DiagnosticSink& sink,
                                                     const std::string& within) {
  static LastConfig last;
  const char* environment = std::getenv("OCIO");
  const bool from_environment = path.empty() && environment && *environment;
  const std::string origin = from_environment ? environment : path.empty() ? kBuiltinOrigin : path;
  const std::string remedy = std::string(from_environment ? "set $OCIO, which names it, to" : "give") +
                             " a .ocio file (profile version 1 to 2.1), or 'built-in' for the built-in configuration";
  try {
    const QuietOcio quiet;
    if (origin == kBuiltinOrigin)
      return std::make_shared<OcioColorConfig>(builtin_config(), origin, "Linear Rec.709", builtin_config_text());
    const ConfigFile from{origin, from_environment ? "" : within, remedy};
    if (auto held = last.find(from)) return held;
    const auto loaded = load_file(from, sink);
    if (loaded) last.keep(from, loaded);
    return loaded;
  } catch (const std::exception& e) {
    report(sink, Severity::error, "ocio.config.invalid", origin, std::string(e.what()) + "; " + remedy);
    return nullptr;
  }
}

std::shared_ptr<const RgbMatrix> rec709_to_rendering(const ColorConfig& config, const DiagnosticSink& sink) {
  if (config.origin() == kBuiltinOrigin) return nullptr;
  const auto transform = config.to_rendering_space("sRGB", sink);
  if (!transform) return nullptr;
  std::array<float, 12> m{1, 0, 0, 1, 0, 1, 0, 1, 0, 0, 1, 1};  // primaries, which have no curve at 0 and 1
  transform->apply(m.data(), 3);
  return std::make_shared<const RgbMatrix>(RgbMatrix{{m[0], m[1], m[2]}, {m[4], m[5], m[6]}, {m[8], m[9], m[10]}});
}

ConfigInputs config_inputs(const ColorConfig& config) {
  return static_cast<const OcioColorConfig&>(config).inputs();  // there is no other kind
}

void report_unknown_primaries(const ColorConfig& config, const DiagnosticSink& sink) {
  static_cast<const OcioColorConfig&>(config).report_unknown_primaries(sink);
}

}  // namespace alabaster
