#include <algorithm>
#include <cmath>

#include "delegate/description/description_reader.h"
#include "delegate/description/quality_presets.h"
#include "delegate/host/product_writer.h"
#include "delegate/support/process_usage.h"
#include "delegate/support/window_policy.h"

namespace alabaster::hd::description {
namespace {

using nlohmann::json;

std::optional<Vec2i> resolution_of(const json& entry) {
  if (!entry.contains("resolution")) return std::nullopt;
  return Vec2i(entry["resolution"][0].get<int>(), entry["resolution"][1].get<int>());
}

bool read_crop(const Reader& reader, const std::string& pointer, const json& entry, std::optional<Rect2i>* crop) {
  if (!entry.contains("crop")) return true;
  const json& c = entry["crop"];
  *crop = Rect2i{c[0].get<int>(), c[1].get<int>(), c[2].get<int>(), c[3].get<int>()};
  if (!(*crop)->empty()) return true;
  return reader.fail(pointer + "/crop", "The crop is empty: give x0, y0, x1, y1 with x1 > x0 and y1 > y0.");
}

// The schema allows no other names.
WindowPolicy policy_of(const std::string& name) {
  const auto& names = support::kWindowPolicyNames;
  const auto found = std::find(names.begin(), names.end(), name);
  return found == names.end() ? WindowPolicy::matchVertically : static_cast<WindowPolicy>(found - names.begin());
}

StudioChoice studio_of(const std::string& name) {
  if (name == "on") return StudioChoice::on;
  return name == "off" ? StudioChoice::off : StudioChoice::when_dark;
}

RenderVar var_of(const std::string& aov, const std::string& data_type) {
  RenderVar var = host::UsualRenderVar(aov);
  if (data_type == "float" && var.dataType == Token("half")) var.dataType = "float";
  return var;
}

}  // namespace

bool loosens_memory_limit(double mib) {
  return !(mib >= 1 && mib <= std::ceil(static_cast<double>(support::default_memory_limit()) / 0x1p20));
}

bool apply_settings(const Reader& reader) {
  const auto entry = reader.value().find("settings");
  if (entry == reader.value().end()) return true;
  RenderSettingsDescription& settings = reader.state().settings;
  if (const auto size = resolution_of(*entry)) {
    settings.width = size->x;
    settings.height = size->y;
  }
  if (!read_crop(reader, "/settings", *entry, &settings.crop)) return false;
  settings.pixelAspectRatio = entry->value("pixelAspectRatio", settings.pixelAspectRatio);
  if (entry->contains("windowPolicy")) settings.windowPolicy = policy_of((*entry)["windowPolicy"]);
  settings.frame = entry->value("frame", settings.frame);
  if (entry->contains("studio")) reader.state().studio = studio_of((*entry)["studio"]);
  // Settings given beside a preset override it.
  if (const QualityPreset* preset = FindQualityPreset(entry->value("quality", "")))
    for (const auto& [name, value] : preset->settings) settings.settings[name] = value;
  constexpr const char* kNotOfTheRenderer[] = {"resolution",   "crop",    "pixelAspectRatio",
                                               "windowPolicy", "quality", "studio"};
  for (const auto& [name, value] : entry->items())
    if (std::find(std::begin(kNotOfTheRenderer), std::end(kNotOfTheRenderer), name) == std::end(kNotOfTheRenderer)) {
      // Zero means something else: no limit.
      if (value.is_number_float() && value.get<double>() != 0 && value.get<float>() == 0)
        return reader.fail(pointer_append("/settings", name), "The number is too small: it would count as zero.");
      if (name == "memoryLimit" && !reader.is_users() && loosens_memory_limit(value.get<double>())) {
        if (value.get<double>() != 0)
          reader.warn("/settings/memoryLimit",
                      "A file cannot raise the limit, so this is not taken: " +
                          std::to_string(support::default_memory_limit() >> 20) +
                          " MiB hold. Raise it with --memory-limit (hosts: setting memoryLimit).");
        continue;
      }
      settings.settings[name] = to_value(value);
    }
  return true;
}

bool apply_products(const Reader& reader) {
  if (reader.value().contains("ocio")) {
    const AssetPath config = reader.asset("/ocio", reader.value()["ocio"]);
    if (config.resolved.empty()) return false;
    reader.state().result->color_config = config.resolved;
    reader.state().result->color_config_within = config.within;
  }
  const auto entries = reader.value().find("products");
  if (entries == reader.value().end()) return true;
  std::erase_if(reader.state().products, [](const ProductPlan& plan) { return plan.is_of_archive; });
  for (size_t i = 0; i < entries->size(); ++i) {
    const json& entry = (*entries)[i];
    const std::string pointer = "/products/" + std::to_string(i);
    ProductPlan plan;
    plan.frame.resolution = resolution_of(entry);
    if (!read_crop(reader, pointer, entry, &plan.frame.crop)) return false;
    RenderProduct& product = plan.product;
    product.file = reader.resolve(pointer + "/file", entry["file"]);
    if (product.file.empty()) return false;
    product.within = reader.within();
    const std::string data_type = entry.value("dataType", "");
    product.dataType = data_type;
    for (const json& aov : entry.value("aovs", json::array())) product.vars.push_back(var_of(aov, data_type));
    if (entry.contains("denoise")) product.denoise = entry["denoise"].get<bool>();
    product.colorSpace = entry.value("colorSpace", "");
    product.display = entry.value("display", "");
    product.view = entry.value("view", "");
    product.look = entry.value("look", "");
    product.exposure = entry.value("exposure", 0.0f);
    const bool display =
        entry.contains("display") || entry.contains("view") || entry.contains("look") || entry.contains("exposure");
    if (display && !product.colorSpace.empty())
      return reader.fail(pointer, "Give either a colorSpace or display, view, look and exposure, not both.");
    reader.state().products.push_back(std::move(plan));
  }
  return true;
}

}  // namespace alabaster::hd::description
