#include "delegate/cli/outputs.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <map>

namespace alabaster::cli {
namespace {

bool is_exr(const hd::RenderProduct& product) {
  std::string extension = std::filesystem::path(product.file).extension();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return extension == ".exr";
}

void add_layers(const std::vector<std::string>& aovs, hd::RenderProduct* product) {
  if (product->vars.empty()) product->vars.push_back(hd::host::UsualRenderVar("color"));
  for (const std::string& aov : aovs) {
    const auto same = [&](const hd::RenderVar& var) { return var.aov == hd::Token(aov); };
    if (std::none_of(product->vars.begin(), product->vars.end(), same))
      product->vars.push_back(hd::host::UsualRenderVar(aov));
  }
}

// Parses numbers with one of `separators` between them. Empty if `text` holds anything else or a number does not fit.
template <class Number>
std::vector<Number> parse_numbers(const std::string& text, const std::string& separators) {
  std::vector<Number> numbers;
  const char *at = text.data(), *end = at + text.size();
  while (true) {
    const auto [next, error] = std::from_chars(at, end, numbers.emplace_back());
    if (error != std::errc()) return {};
    if (next == end) return numbers;
    if (separators.find(*next) == std::string::npos) return {};
    at = next + 1;
  }
}

std::string unknown_aov(const std::vector<std::string>& aovs) {
  const std::vector<std::string>& known = hd::host::ProductAovs();
  for (const std::string& aov : aovs) {
    if (std::find(known.begin(), known.end(), aov) != known.end()) continue;
    if (const std::string primvars = "primvars:"; aov.starts_with(primvars) && aov != primvars) continue;
    std::string names;
    for (const std::string& name : known) names += (names.empty() ? "" : ", ") + name;
    return "--aov: there is no '" + aov + "'; choose from " + names + ", primvars:NAME.";
  }
  return "";
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
  *error = unknown_aov(a.aovs);
  if (!error->empty()) return {};
  if (products.empty()) {
    *error = "There is nothing to write: add -o FILE, or products to the render description.";
  } else if (!a.aovs.empty() && !any_exr) {
    *error = "--aov adds layers to EXR files, but no EXR file is written: add -o FILE.exr.";
  } else if (display_options && !any_display) {
    *error =
        "--display, --view, --look and --exposure apply to .png, .tif and .jpg files, but none is written; EXR stays "
        "scene-linear.";
  }
  if (!error->empty()) return {};
  for (hd::RenderProduct& product : products) {
    if (a.denoise) product.denoise = true;
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

std::optional<hd::Vec2i> parse_size(const std::string& text) {
  const auto numbers = parse_numbers<int>(text, "xX");
  if (numbers.size() != 2) return std::nullopt;
  for (const int side : numbers)
    if (side < 1 || side > 65536) return std::nullopt;
  return hd::Vec2i(numbers[0], numbers[1]);
}

std::string size_fault(const std::string& text) {
  if (text.empty() || parse_size(text)) return "";
  return "'" + text + "' is not a resolution: write for example 1280x720, up to 65536x65536.";
}

std::optional<hd::Rect2i> parse_crop(const std::string& text) {
  const auto numbers = parse_numbers<int>(text, ",");
  if (numbers.size() != 4) return std::nullopt;
  return hd::Rect2i{numbers[0], numbers[1], numbers[2], numbers[3]};
}

std::optional<PixelChoice> parse_pixel(const std::string& text) {
  const auto numbers = parse_numbers<int>(text, ",");
  if (numbers.size() == 2) return PixelChoice{numbers[0], numbers[1], {}};
  if (numbers.size() != 3 || numbers[2] < 0) return std::nullopt;
  return PixelChoice{numbers[0], numbers[1], static_cast<uint32_t>(numbers[2])};
}

std::optional<std::pair<double, double>> parse_interval(const std::string& text) {
  const auto numbers = parse_numbers<double>(text, ":");
  if (numbers.size() != 2 || !std::isfinite(numbers[0]) || !std::isfinite(numbers[1]) || numbers[1] < numbers[0])
    return std::nullopt;
  return std::pair(numbers[0], numbers[1]);
}

std::optional<std::pair<uint32_t, uint32_t>> parse_samples(const std::string& text) {
  const auto numbers = parse_numbers<uint32_t>(text, ":");
  if (numbers.size() != 2 || numbers[0] >= numbers[1] || numbers[1] > 1048576) return std::nullopt;
  return std::pair(numbers[0], numbers[1]);
}

std::vector<uint32_t> parse_frames(const std::string& text) {
  constexpr uint64_t kMost = 100'000;
  std::vector<uint32_t> range = parse_numbers<uint32_t>(text, ":");
  if (range.size() == 2) range.push_back(1);
  if (range.size() != 3 || range[2] == 0 || range[0] > range[1] || (range[1] - range[0]) / range[2] >= kMost) return {};
  std::vector<uint32_t> frames;
  for (uint64_t frame = range[0]; frame <= range[1]; frame += range[2]) frames.push_back(uint32_t(frame));
  return frames;
}

std::string frame_file(const std::string& file, uint32_t frame) {
  const size_t last = file.rfind('#'), slash = file.rfind('/');
  if (last == std::string::npos || (slash != std::string::npos && last < slash)) return {};
  const size_t before = file.find_last_not_of('#', last), first = before == std::string::npos ? 0 : before + 1;
  const std::string number = std::to_string(frame);
  const size_t digits = last + 1 - first;
  const std::string zeros(digits > number.size() ? digits - number.size() : 0, '0');
  return file.substr(0, first) + zeros + number + file.substr(last + 1);
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
