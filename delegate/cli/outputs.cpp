#include "delegate/cli/outputs.h"

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <fstream>
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

/// Of "NAME" or "NAME=LAYER". A layer of that AOV which is there already gets the name.
void add_layers(const std::vector<std::string>& aovs, hd::RenderProduct* product) {
  if (product->vars.empty()) product->vars.push_back(hd::host::UsualRenderVar("color"));
  for (const std::string& given : aovs) {
    const std::string aov = aov_of(given);
    const hd::RenderVar usual = hd::host::UsualRenderVar(aov);
    const auto same = [&](const hd::RenderVar& var) { return var.aov == usual.aov; };
    auto found = std::find_if(product->vars.begin(), product->vars.end(), same);
    if (found == product->vars.end()) found = product->vars.insert(found, usual);
    if (given != aov) found->name = given.substr(aov.size() + 1);
  }
}

std::string unknown_aov(const std::vector<std::string>& aovs) {
  const std::vector<std::string>& known = hd::host::ProductAovs();
  for (const std::string& given : aovs) {
    const std::string aov = aov_of(given);
    if (given.size() == aov.size() + 1) return "--aov: '" + given + "' has no name of a layer: write NAME=LAYER.";
    if (std::find(known.begin(), known.end(), aov) != known.end()) continue;
    if (const std::string primvars = "primvars:"; aov.starts_with(primvars) && aov != primvars) continue;
    if (aov.starts_with("lightGroup:")) continue;
    if (aov.starts_with("lpe:")) {
      if (hd::host::UsualRenderVar(aov).aov != hd::Token(aov)) continue;
      return "--aov: " + hd::host::NoSuchAov(aov) + ".";
    }
    return "--aov: there is no '" + aov + "'; choose from " + joined(known) +
           ", lightGroup:NAME, primvars:NAME, lpe:EXPRESSION." + hd::support::Suggestion(aov, known);
  }
  return "";
}

}  // namespace

std::string aov_of(const std::string& given) {
  return given.substr(0, given.find('='));
}

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
  if (!a.compression.empty() && !any_exr)
    console.usage_error(command, "--compression applies to .exr files, but none is written: add -o FILE.exr.");
  if (a.tiles && !any_exr)
    console.usage_error(command, "--tiles applies to .exr files, but none is written: add -o FILE.exr.");
  for (hd::RenderProduct& product : products) {
    if (a.denoise) product.denoise = true;
    if (!a.color_space.empty() && !a.outputs.empty() && !is_exr(product)) product.colorSpace = a.color_space;
    if (is_exr(product)) {
      if (!a.compression.empty()) product.compression = hd::Token(a.compression);
      if (a.tiles) product.tiles = static_cast<int>(*a.tiles);
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

hd::Rect2i product_window(const hd::RenderSettingsDescription& frame, const hd::RenderProduct& product) {
  const bool has_size = product.width > 0 && product.height > 0 && !frame.crop;
  return has_size ? hd::Rect2i{0, 0, product.width, product.height} : frame.window();
}

bool is_there(const hd::RenderSettingsDescription& frame, const hd::RenderProduct& product) {
  hd::Rect2i window = product_window(frame, product);
  if (is_exr(product) && frame.crop) window = {0, 0, frame.width, frame.height};  // which its display window is
  if (hd::host::PictureSize(product.file) != hd::Vec2i(window.width(), window.height())) return false;
  std::ifstream in(product.file, std::ios::binary);  // every format has our attributes as plain texts
  const std::string bytes(std::istreambuf_iterator<char>(in), {});
  return bytes.find("alabaster/incomplete") == std::string::npos;
}

std::optional<FramePlace> frame_place(const std::string& file) {
  const size_t name = file.rfind('/') + 1;  // 0 without a slash
  const auto is_digit = [&](size_t i) { return i < file.size() && file[i] >= '0' && file[i] <= '9'; };
  for (size_t at = file.size(); at-- > name;) {
    if (file[at] == '#') {
      const auto begin_of = [&](size_t end) { return std::max(file.find_last_not_of('#', end) + 1, name); };
      FramePlace place{begin_of(at), at + 1, at + 1 - begin_of(at), 0};
      if (place.begin >= name + 2 && file[place.begin - 1] == '.' && file[place.begin - 2] == '#')
        place.digits = place.width, place.begin = begin_of(place.begin - 2), place.width = at + 1 - place.begin;
      return place;
    }
    if (file[at] != '%' && !(file[at] == '$' && at + 1 < file.size() && file[at + 1] == 'F')) continue;
    size_t end = at + (file[at] == '%' ? 1 : 2), width = 0;
    for (; is_digit(end) && width < 10; ++end) width = 10 * width + size_t(file[end] - '0');
    if (file[at] == '%' && (end >= file.size() || file[end++] != 'd')) continue;
    const bool is_bare = width == 0;  // %d and $F may be of a word
    if (is_bare && end < file.size() && std::isalnum(static_cast<unsigned char>(file[end]))) continue;
    return FramePlace{at, end, std::max(width, size_t(1)), 0};
  }
  return {};
}

std::string frame_file(const std::string& file, double frame) {
  const auto place = frame_place(file);
  if (!place) return {};
  return file.substr(0, place->begin) + formatted("%0*.*f", int(place->width), int(place->digits), frame) +
         file.substr(place->end);
}

void check_frame_names(const std::vector<std::string>& files, const RenderArguments& a, Console& console) {
  const FrameList& frames = a.frames;
  for (const std::string& file : files) {
    const auto place = frame_place(file);
    if (!place)
      console.usage_error(
          a.turntable ? "--turntable" : "--frames",
          "All frames would go to '" + file + "': give the name a place for their numbers, such as frame.####.exr.");
    if (place->digits < frames.digits)
      console.usage_error("--frames", "These frames need " + std::to_string(frames.digits) +
                                          " digits after the point, and '" + file + "' has " +
                                          std::to_string(place->digits) + ": write for example ###." +
                                          std::string(frames.digits, '#') + ".");
  }
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
