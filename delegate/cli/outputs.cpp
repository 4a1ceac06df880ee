#include "delegate/cli/outputs.h"

#include <algorithm>
#include <filesystem>
#include <map>

#include "delegate/cli/command_words.h"
#include "delegate/cli/console.h"
#include "delegate/support/extension.h"
#include "delegate/support/nearest_name.h"

namespace alabaster::cli {
namespace {

bool is_exr(const hd::RenderProduct& product) {
  return hd::support::lower_extension(product.file) == ".exr";
}

void add_layers(const std::vector<std::string>& aovs, hd::RenderProduct* product) {
  if (product->vars.empty()) product->vars.push_back(hd::host::UsualRenderVar("color"));
  for (const std::string& aov : aovs) {
    const auto same = [&](const hd::RenderVar& var) { return var.aov == hd::Token(aov); };
    if (std::none_of(product->vars.begin(), product->vars.end(), same))
      product->vars.push_back(hd::host::UsualRenderVar(aov));
  }
}

std::string unknown_aov(const std::vector<std::string>& aovs) {
  const std::vector<std::string>& known = hd::host::ProductAovs();
  for (const std::string& aov : aovs) {
    if (std::find(known.begin(), known.end(), aov) != known.end()) continue;
    if (const std::string primvars = "primvars:"; aov.starts_with(primvars) && aov != primvars) continue;
    return "--aov: there is no '" + aov + "'; choose from " + joined(known) + ", primvars:NAME." +
           hd::support::Suggestion(aov, known);
  }
  return "";
}

}  // namespace

std::vector<hd::RenderProduct> make_products(const PictureArguments& a, const std::vector<hd::RenderProduct>& existing,
                                             const char* command, Console& console) {
  std::vector<hd::RenderProduct> products;
  for (const std::string& file : a.outputs) products.emplace_back().file = file;
  if (products.empty()) products = existing;
  const bool any_exr = std::any_of(products.begin(), products.end(), is_exr);
  const bool any_display = !std::all_of(products.begin(), products.end(), is_exr);
  const bool display_options = !a.display.empty() || !a.view.empty() || !a.look.empty() || a.exposure;
  console.require_usage(command, unknown_aov(a.aovs));
  if (products.empty())
    console.usage_error(command, "There is nothing to write: add -o FILE, or products to the render description.");
  if (!a.aovs.empty() && !any_exr)
    console.usage_error(command, "--aov adds layers to EXR files, but no EXR file is written: add -o FILE.exr.");
  if (display_options && !any_display)
    console.usage_error(command,
                        "--display, --view, --look and --exposure apply to .png, .tif and .jpg files, but none is "
                        "written; EXR stays scene-linear.");
  for (hd::RenderProduct& product : products) {
    if (a.denoise) product.denoise = true;
    if (!a.color_space.empty() && !a.outputs.empty() && !is_exr(product)) product.colorSpace = a.color_space;
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

std::string frame_file(const std::string& file, double frame) {
  const size_t last = file.rfind('#'), slash = file.rfind('/');
  if (last == std::string::npos || (slash != std::string::npos && last < slash)) return {};
  const auto begin_of = [&](size_t end) { return file.find_last_not_of('#', end) + 1; };
  size_t first = begin_of(last), digits = 0;
  if (first >= 2 && file[first - 1] == '.' && file[first - 2] == '#')
    digits = last + 1 - first, first = begin_of(first - 2);
  return file.substr(0, first) + formatted("%0*.*f", int(last + 1 - first), int(digits), frame) + file.substr(last + 1);
}

std::string same_file_twice(const std::vector<std::string>& files) {
  std::map<std::string, std::string> spelt;  // by canonical path
  for (const std::string& file : files) {
    std::error_code error;
    std::filesystem::path path = std::filesystem::weakly_canonical(std::filesystem::absolute(file, error), error);
    if (error) path = std::filesystem::path(file).lexically_normal();
    const auto [other, is_new] = spelt.emplace(path.string(), file);
    if (!is_new) return "'" + other->second + "' and '" + file + "' are the same file: give each output its own name.";
  }
  return "";
}

}  // namespace alabaster::cli
