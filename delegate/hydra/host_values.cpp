#include "delegate/hydra/host_values.h"

#include <cmath>
#include <limits>

#include "delegate/host/product_writer.h"
#include "delegate/support/lookup.h"
#include "delegate/support/process_usage.h"

namespace alabaster::hydra {
namespace {

// The number in the type of `like`; `value` itself where that is no number, or would lose its fraction.
hd::Value number_like(const hd::Value& like, const hd::Value& value) {
  const double number = value.number_or(NAN);
  if (std::isnan(number)) return value;
  if (like.get<bool>()) return number != 0;
  if (like.get<float>()) return static_cast<float>(number);
  if (like.get<double>()) return number;
  const bool is_whole = number == std::floor(number) && std::abs(number) < 9e15;
  if (like.get<int64_t>() && is_whole) return static_cast<int64_t>(number);
  return value;
}

}  // namespace

hd::DirtyBits TranslateBits(uint32_t host, std::span<const BitPair> table) {
  hd::DirtyBits ours = hd::dirty::kClean;
  for (const BitPair& pair : table)
    if (host & pair.host) ours |= pair.ours;
  return ours;
}

Setting TranslateSetting(const hd::Token& key, const hd::Value& value,
                         const std::vector<hd::RenderSettingDescriptor>& known) {
  constexpr std::string_view kOurs = "alabaster:";
  std::string name = key.str();
  if (name.starts_with(kOurs)) name.erase(0, kOurs.size());
  if (name == "convergedSamplesPerPixel") name = "samples";
  for (const hd::RenderSettingDescriptor& setting : known)
    if (setting.key == hd::Token(name)) return {setting.key, number_like(setting.defaultValue, value)};
  return {name, value};
}

hd::Value WithinHostLimits(const hd::Token& key, const hd::Value& scene, const hd::Value& host) {
  const bool is_memory = key == hd::Token("memoryLimit");
  if (!is_memory && !(key == hd::Token("timeLimit"))) return scene;
  const double otherwise = is_memory ? static_cast<double>(hd::support::default_memory_limit()) / 0x1p20
                                     : std::numeric_limits<double>::infinity();
  const auto limit = [&](const hd::Value& value) {
    const double number = value.number_or(0);
    return number > 0 ? number : otherwise;
  };
  return limit(scene) <= limit(host) ? scene : host;
}

hd::RenderVar TranslateRenderVar(const HostRenderVar& theirs) {
  constexpr std::string_view kLightPaths = "lpe:";
  constexpr std::pair<const char*, const char*> kUsual[] = {{"Ci", "color"},     {"RGBA", "color"}, {"RGB", "color"},
                                                            {"beauty", "color"}, {"a", "alpha"},    {"A", "alpha"}};
  std::string source = theirs.source_name.empty() ? theirs.prim : theirs.source_name;
  const bool has_light_paths = theirs.source_type == "lpe" || source.starts_with(kLightPaths);
  if (theirs.source_type == "primvar") source.insert(0, "primvars:");
  if (has_light_paths && !source.starts_with(kLightPaths)) source.insert(0, kLightPaths);
  for (const auto& [name, aov] : kUsual)
    if (source == name) source = aov;
  hd::RenderVar ours = hd::host::UsualRenderVar(source);
  if (has_light_paths) ours.name = theirs.prim;
  if (!theirs.layer.empty() && source != "color") ours.name = theirs.layer;
  const std::string& type = theirs.data_type;
  const bool is_half = type.starts_with("half") || type.ends_with('h');
  ours.dataType = type.starts_with("int") ? "int" : is_half ? "half" : "float";
  return ours;
}

hd::Dictionary HostStatistics(hd::Dictionary statistics) {
  for (const char* key : {"percentDone", "fractionDone"}) statistics[key] = hd::support::number_in(statistics, key);
  return statistics;
}

}  // namespace alabaster::hydra
