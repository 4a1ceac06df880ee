#include "delegate/cli/outputs.h"

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <regex>

namespace alabaster::cli {
namespace {

bool is_exr(const hd::RenderProduct& product) {
  std::string extension = std::filesystem::path(product.file).extension();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return extension == ".exr";
}

hd::RenderVar var_of(const std::string& aov) {
  static const std::map<std::string, const char*> types{{"depth", "float"},   {"cameraDepth", "float"},
                                                        {"primId", "int"},    {"instanceId", "int"},
                                                        {"elementId", "int"}, {"sampleCount", "int"}};
  const auto found = types.find(aov);
  return {aov, aov, found == types.end() ? "half" : found->second};
}

void add_layers(const std::vector<std::string>& aovs, hd::RenderProduct* product) {
  if (product->vars.empty()) product->vars.push_back(var_of("color"));
  for (const std::string& aov : aovs) {
    const auto same = [&](const hd::RenderVar& var) { return var.aov == hd::Token(aov); };
    if (std::none_of(product->vars.begin(), product->vars.end(), same)) product->vars.push_back(var_of(aov));
  }
}

}  // namespace

std::vector<hd::RenderProduct> make_products(const RenderArguments& a, const std::vector<hd::RenderProduct>& existing,
                                             std::string* error) {
  std::vector<hd::RenderProduct> products;
  for (const std::string& file : a.outputs) products.emplace_back().file = file;
  if (products.empty()) products = existing;
  const bool any_exr = std::any_of(products.begin(), products.end(), is_exr);
  const bool any_display = !std::all_of(products.begin(), products.end(), is_exr);
  const bool display_options = !a.display.empty() || !a.view.empty() || !a.look.empty() || a.exposure;
  if (products.empty()) {
    *error = "Nothing to write: add -o FILE, or products to the render description.";
  } else if (!a.aovs.empty() && !any_exr) {
    *error = "--aov adds layers to EXR files, and none is written: add -o FILE.exr.";
  } else if (display_options && !any_display) {
    *error =
        "--display, --view, --look and --exposure are for .png, .tif and .jpg files, and none is written: EXR "
        "stays scene-linear.";
  }
  if (!error->empty()) return {};
  for (hd::RenderProduct& product : products) {
    if (is_exr(product)) {
      if (!a.aovs.empty()) add_layers(a.aovs, &product);
      continue;
    }
    if (!a.display.empty()) product.display = a.display;
    if (!a.view.empty()) product.view = a.view;
    if (!a.look.empty()) product.look = a.look;
    if (a.exposure) product.exposure = *a.exposure;
    if (display_options) product.colorSpace.clear();
  }
  return products;
}

std::string size_value(const std::string& text) {
  std::smatch m;
  static const std::regex pattern("([0-9]+)[xX]([0-9]+)");
  return std::regex_match(text, m, pattern) ? "[" + m[1].str() + "," + m[2].str() + "]" : "";
}

std::string crop_value(const std::string& text) {
  static const std::regex pattern("-?[0-9]+(,-?[0-9]+){3}");
  return std::regex_match(text, pattern) ? "[" + text + "]" : "";
}

}  // namespace alabaster::cli
