#include "delegate/tradeoff/configurations.h"

#include "delegate/tradeoff/name_pattern.h"

#include <algorithm>
#include <sstream>

#include "delegate/description/quality_presets.h"

namespace alabaster::tradeoff {
namespace {

enum class Needs { nothing, subsurface, textures };
enum class Measured { always, if_named };

/// A value as written here: numbers for numbers, words for words, 0 and 1 for switches.
using KnobValue = std::variant<int64_t, double, const char*, bool>;

struct Knob {
  const char* setting;
  KnobValue value;
  Needs needs = Needs::nothing;
  Measured measured = Measured::always;
};

// The base is the most accurate configuration meant for pictures. Beyond 32 bounces no change is visible.
constexpr int64_t kBaseDepth = 32, kReferenceDepth = 128;

constexpr Knob kBase[] = {
    {"subsurface", "walk"},
    {"inversion", "exact"},
};

// The knobs to measure against the base, most used first: when time is short, the last ones are left out.
constexpr Knob kKnobs[] = {
    {"subsurface", "lambert", Needs::subsurface},
    {"subsurface", "diffusion", Needs::subsurface},
    {"subsurface", "reference", Needs::subsurface},
    {"maxDepth", int64_t(2)},
    {"maxDepth", int64_t(4)},
    {"maxDepth", int64_t(8)},
    {"maxDepth", int64_t(16)},
    {"adaptive", true},
    {"glossyFilter", 0.5},
    {"glossyFilter", 1.0},
    {"textureFilter", 0.5, Needs::textures},
    {"walkGuiding", false, Needs::subsurface, Measured::if_named},
    {"walkSphereSteps", false, Needs::subsurface, Measured::if_named},
    {"inversion", "chiang2016", Needs::subsurface, Measured::if_named},
};

constexpr int kCoarser[] = {1, 2};

// The study itself decides when a render ends, which random numbers it takes and whether it is denoised.
constexpr const char* kDecidedHere[] = {"samples", "seed", "targetError", "timeLimit", "denoise"};

constexpr const char* kPresets = "quality";  // their group
constexpr const char* kCoarserGroup = "refineLevel";

bool is_if_named(const Configuration& configuration) {
  return configuration.group == kCoarserGroup || std::any_of(std::begin(kKnobs), std::end(kKnobs), [&](const Knob& k) {
           return k.measured == Measured::if_named && configuration.group == k.setting;
         });
}

hd::Value value_of(const KnobValue& value) {
  return std::visit(
      [](const auto& held) -> hd::Value {
        if constexpr (std::is_same_v<std::decay_t<decltype(held)>, const char*>) {
          return std::string(held);
        } else {
          return held;
        }
      },
      value);
}

std::string text_of(const KnobValue& value) {
  if (const auto* word = std::get_if<const char*>(&value)) return *word;
  if (const auto* on = std::get_if<bool>(&value)) return *on ? "on" : "off";
  if (const auto* share = std::get_if<double>(&value)) return (std::ostringstream() << *share).str();
  return std::to_string(std::get<int64_t>(value));
}

/// Compares by meaning: scene files write numbers in other types than the table.
bool same(const hd::Value& a, const hd::Value& b) {
  const std::string text = a.text_or("");
  if (!text.empty() || !b.text_or("").empty()) return text == b.text_or("");
  return a.number_or(-1) == b.number_or(-1);
}

/// "maxDepth=4", "adaptive=true"
std::string flag_text(const Knob& knob) {
  const auto* on = std::get_if<bool>(&knob.value);
  return std::string(knob.setting) + "=" + (!on ? text_of(knob.value) : *on ? "true" : "false");
}

class ListMaker {
 public:
  ListMaker(const SceneTraits& traits, const hd::Dictionary& scene_settings,
            const std::vector<hd::RenderSettingDescriptor>& known)
      : traits_(traits), scene_settings_(scene_settings), known_(known) {
    base_.name = "walk";
    base_.group = "base";
    base_.settings = scene_settings;
    for (const char* key : kDecidedHere) base_.settings.erase(key);
    for (const Knob& knob : kBase) base_.settings[knob.setting] = value_of(knob.value);
    for (const char* spares : {"adaptive", "walkGuiding", "walkSphereSteps", "glossyFilter", "textureFilter"})
      base_.settings.erase(spares);
    base_.settings["maxDepth"] = std::max(kBaseDepth, static_cast<int64_t>(number("maxDepth")));
  }

  ConfigurationList make() {
    list_.reference = base_;
    list_.reference.name = list_.reference.group = "the reference";
    list_.reference.settings["subsurface"] = std::string("reference");
    list_.reference.settings["maxDepth"] = std::max(kReferenceDepth, static_cast<int64_t>(number("maxDepth")));
    list_.measured.push_back(base_);
    for (const auto& preset : hd::description::QualityPresets()) add_preset(preset);
    for (const Knob& knob : kKnobs) add(knob);
    for (const int levels : kCoarser) add_coarser(levels);
    return std::move(list_);
  }

 private:
  const hd::RenderSettingDescriptor* find(const std::string& setting) const {
    const auto found = std::find_if(known_.begin(), known_.end(), [&](const hd::RenderSettingDescriptor& descriptor) {
      return descriptor.key == hd::Token(setting);
    });
    return found == known_.end() ? nullptr : &*found;
  }

  hd::Value in_base(const std::string& setting) const {
    if (const auto found = base_.settings.find(setting); found != base_.settings.end()) return found->second;
    const auto* descriptor = find(setting);
    return descriptor ? descriptor->defaultValue : hd::Value();
  }
  double number(const std::string& setting) const { return in_base(setting).number_or(0); }

  void skip(const std::string& name, const std::string& why) { list_.skipped.push_back(name + ": " + why); }

  void add(const Knob& knob) {
    const bool rung = std::string(knob.setting) == "subsurface";
    const std::string name = rung ? text_of(knob.value) : std::string(knob.setting) + "=" + text_of(knob.value);
    if (!find(knob.setting)) return;
    if (knob.needs == Needs::subsurface && !traits_.subsurface) return skip(name, "the scene has no subsurface");
    if (knob.needs == Needs::textures && !traits_.textures) return skip(name, "the scene has no images");
    if (same(in_base(knob.setting), value_of(knob.value))) return;  // that is the base
    Configuration configuration = base_;
    configuration.name = name;
    configuration.group = knob.setting;
    configuration.flags = rung ? "--subsurface " + name : "--set " + flag_text(knob);
    configuration.settings[knob.setting] = value_of(knob.value);
    list_.measured.push_back(std::move(configuration));
  }

  void add_coarser(int levels) {
    const std::string name = "refineLevel-" + std::to_string(levels);
    if (traits_.refine_level < levels)
      return skip(name, traits_.refine_level == 0
                            ? "no mesh in the scene is subdivided"
                            : "the scene subdivides only " + std::to_string(traits_.refine_level) +
                                  (traits_.refine_level == 1 ? " time" : " times"));
    Configuration configuration = base_;
    configuration.name = name;
    configuration.group = kCoarserGroup;
    configuration.coarser = levels;
    list_.measured.push_back(std::move(configuration));
  }

  /// The scene as --quality renders it, but without the preset's limits on samples, error and time.
  void add_preset(const hd::description::QualityPreset& preset) {
    Configuration configuration{kPresets + ("=" + preset.name), kPresets, scene_settings_, 0,
                                "--quality " + preset.name};
    for (const auto& [name, value] : preset.settings) configuration.settings[name] = value;
    for (const char* key : kDecidedHere) configuration.settings.erase(key);
    list_.measured.push_back(std::move(configuration));
  }

  const SceneTraits traits_;
  const hd::Dictionary& scene_settings_;
  const std::vector<hd::RenderSettingDescriptor>& known_;
  Configuration base_;
  ConfigurationList list_;
};

}  // namespace

std::string Configuration::fingerprint() const {
  std::string text = "coarser " + std::to_string(coarser);
  for (const auto& [key, value] : settings) text += "; " + key + " " + value.to_string();
  return text;
}

SceneTraits traits_of(const hd::host::RetainedSceneDelegate& scene, hd::RenderDelegate* delegate) {
  SceneTraits traits;
  traits.subsurface = delegate->InvokeCommand("requirements", {}).value.text_or("").starts_with("subsurface: yes");
  for (const auto& [path, mesh] : scene.GetMeshes())
    if (mesh.topology.scheme != hd::Token("none"))
      traits.refine_level = std::max(traits.refine_level, mesh.displayStyle.refineLevel);
  for (const auto& [path, network] : scene.GetMaterials())
    for (const auto& [node_path, node] : network.nodes)
      for (const auto& [name, value] : node.parameters) traits.textures |= value.get<hd::AssetPath>() != nullptr;
  return traits;
}

uint64_t Configuration::first_samples() const {
  constexpr uint64_t kAdaptive = 32;  // schemas/render_settings.json
  const auto adaptive = settings.find("adaptive");
  return adaptive != settings.end() && adaptive->second.number_or(0) != 0 ? kAdaptive : 1;
}

ConfigurationList make_configurations(const SceneTraits& traits, const hd::Dictionary& scene_settings,
                                      const std::vector<hd::RenderSettingDescriptor>& known, const std::string& only) {
  ConfigurationList list = ListMaker(traits, scene_settings, known).make();
  if (only.empty()) {
    std::erase_if(list.measured, is_if_named);
    std::erase_if(list.skipped, [](const std::string& line) { return line.starts_with(kCoarserGroup); });
    return list;
  }
  const NamePattern pattern(only);
  const auto unwanted = [&](const Configuration& configuration) {
    return configuration.group != "base" && !pattern.matches(configuration.name);
  };
  std::erase_if(list.measured, unwanted);
  std::erase_if(list.skipped, [&](const std::string& line) { return !pattern.matches(line); });
  return list;
}

}  // namespace alabaster::tradeoff
