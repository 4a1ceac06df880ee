#include <cmath>

#include "delegate/description/document_keys.h"
#include "delegate/description/load_state.h"
#include "delegate/host/product_writer.h"
#include "delegate/support/json_values.h"
#include "delegate/support/process_usage.h"

namespace alabaster::hd::description {
namespace {

using nlohmann::json;

std::optional<Vec2i> resolution_of(const json& entry) {
  if (!entry.contains("resolution")) return std::nullopt;
  return Vec2i(entry["resolution"][0].get<int>(), entry["resolution"][1].get<int>());
}

void read_crop(LoadState& load, const std::string& pointer, const json& entry, std::optional<Rect2i>* crop) {
  if (!entry.contains("crop")) return;
  const json& c = entry["crop"];
  *crop = Rect2i{c[0].get<int>(), c[1].get<int>(), c[2].get<int>(), c[3].get<int>()};
  if ((*crop)->empty())
    load.fail(pointer + "/crop", "The crop is empty: give x0, y0, x1, y1 with x1 > x0 and y1 > y0.");
}

/// Sets the named fields of settings that are no prim yet.
void set_fields(LoadState& load, const std::string& pointer, const host::Fields& fields,
                RenderSettingsDescription* settings) {
  const std::string fault = host::ReadSettings(fields, settings);
  if (!fault.empty()) load.fail(pointer, fault + ".");
}

// True if the file may not set this limit. A limit that is not 0 is then reported.
bool is_refused_limit(const LoadState& load, const json& mib) {
  const std::string pointer = "/settings/memoryLimit";
  if (load.document.is_of_option(pointer) || !loosens_memory_limit(mib.get<double>())) return false;
  if (mib.get<double>() != 0) load.warn(pointer, refused_limit_text(load.options));
  return true;
}

RenderVar var_of(const std::string& aov, const std::string& data_type) {
  RenderVar var = host::UsualRenderVar(aov);
  if (data_type == "float" && var.dataType == Token("half")) var.dataType = "float";
  return var;
}

/// `known`: the products so far, by file.
ProductPlan product_of(LoadState& load, const std::string& pointer, const json& entry, std::set<std::string>* known) {
  ProductPlan plan;
  plan.place = pointer;
  plan.frame.resolution = resolution_of(entry);
  read_crop(load, pointer, entry, &plan.frame.crop);
  host::Fields fields{{"products:0:file", load.resolve(pointer + "/file", entry["file"])}};
  for (const Key& key : find_key(description_key().keys, "products")->keys)
    if (const std::string& name = key.row.name; !key.kind.empty() && entry.contains(name))
      fields.emplace_back("products:0:" + name, support::value_of(entry[name]));
  RenderSettingsDescription settings;
  set_fields(load, pointer, fields, &settings);
  plan.product = std::move(settings.products[0]);
  if (!known->insert(plan.product.file).second)
    load.fail(pointer + "/file", "'" + entry["file"].get<std::string>() + "' and '" + plan.product.file +
                                     "' are the same file: give each output its own name.");
  plan.product.within = load.within_of(pointer + "/file");
  for (const json& aov : entry.value("aovs", json::array()))
    plan.product.vars.push_back(var_of(aov, plan.product.dataType.str()));
  const bool display =
      entry.contains("display") || entry.contains("view") || entry.contains("look") || entry.contains("exposure");
  if (display && !plan.product.colorSpace.empty())
    load.fail(pointer, "Give either a colorSpace or display, view, look and exposure, not both.");
  return plan;
}

}  // namespace

bool loosens_memory_limit(double mib) {
  return !(mib >= 1 && mib <= std::ceil(static_cast<double>(support::default_memory_limit()) / 0x1p20));
}

std::string refused_limit_text(const LoadOptions& options) {
  return "A file cannot raise the limit of memory, so this is not taken: " +
         std::to_string(support::default_memory_limit() >> 20) + " MiB hold. Raise it with " +
         (options.are_flags ? "--memory-limit." : "the renderer's setting memoryLimit.");
}

void apply_settings(LoadState& load) {
  const json* entry = load.part("settings");
  if (!entry) return;
  RenderSettingsDescription& settings = load.settings;
  if (const auto size = resolution_of(*entry)) settings.width = size->x, settings.height = size->y;
  read_crop(load, "/settings", *entry, &settings.crop);
  const std::string studio = entry->value("studio", "auto");
  load.studio = studio == "on" ? StudioChoice::on : studio == "off" ? StudioChoice::off : StudioChoice::when_dark;
  for (const auto& [name, value] : entry->items()) {
    const std::string pointer = pointer_append("/settings", name);
    // Zero means something else: no limit.
    if (value.is_number_float() && value.get<double>() != 0 && value.get<float>() == 0)
      load.fail(pointer, "The number is too small: it would count as zero.");
    if (name == "resolution" || name == "crop" || name == "quality" || name == "studio") continue;
    if (name == "memoryLimit" && is_refused_limit(load, value)) continue;
    set_fields(load, pointer, {{name, support::value_of(value)}}, &settings);
  }
}

void apply_products(LoadState& load) {
  if (const json* ocio = load.part("ocio")) {
    const AssetPath config = load.asset("/ocio", *ocio);
    load.result->color_config = config.resolved;
    load.result->color_config_within = config.within;
  }
  if (!load.part("products")) return;
  std::erase_if(load.products, [](const ProductPlan& plan) { return plan.is_of_archive; });
  std::set<std::string> known;
  load.for_each_entry("products", [&](const std::string& pointer, const json& entry) {
    load.products.push_back(product_of(load, pointer, entry, &known));
  });
}

}  // namespace alabaster::hd::description
