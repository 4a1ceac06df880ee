#include "delegate/gltf/gltf_names.h"

#include <algorithm>
#include <numeric>
#include <string_view>
#include <vector>

namespace alabaster::hd::gltf {
namespace {

constexpr size_t kLongestName = 120;

struct DisneyParameter {
  std::string_view name;
  int components;
};
constexpr DisneyParameter kDisneyParameters[] = {
    {"baseColor", 3},       {"metallic", 1},          {"roughness", 1},
    {"anisotropic", 1},     {"specularTint", 1},      {"ior", 1},
    {"specular", 1},        {"specularColor", 3},     {"sheen", 1},
    {"sheenTint", 1},       {"clearcoat", 1},         {"clearcoatGloss", 1},
    {"scatterDistance", 3}, {"scatterAnisotropy", 1}, {"emission", 3}};

// Levenshtein's distance.
size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), size_t(0));
  for (size_t i = 0; i < a.size(); ++i) {
    size_t diagonal = row[0];
    row[0] = i + 1;
    for (size_t j = 0; j < b.size(); ++j) {
      const size_t replaced = diagonal + (a[i] == b[j] ? 0 : 1);
      diagonal = row[j + 1];
      row[j + 1] = std::min({row[j] + 1, row[j + 1] + 1, replaced});
    }
  }
  return row.back();
}

}  // namespace

std::string clean_name(const std::string& text) {
  std::string name = text;
  if (name.size() > kLongestName) {
    size_t end = kLongestName;  // not inside a UTF-8 sequence
    while (end > 0 && (static_cast<unsigned char>(name[end]) & 0xc0) == 0x80) --end;
    name.resize(end);
  }
  for (char& c : name)
    if (c == '/' || static_cast<unsigned char>(c) <= ' ' || c == 0x7f) c = '_';
  return name;
}

std::string prim_name(size_t index, const std::string& name) {
  std::string text = std::to_string(index);
  if (!name.empty()) text.append("_").append(clean_name(name));
  return text;
}

int disney_parameter_components(const std::string& name) {
  for (const DisneyParameter& parameter : kDisneyParameters)
    if (parameter.name == name) return parameter.components;
  return 0;
}

std::string nearest_disney_parameter(const std::string& name) {
  const std::string_view text = std::string_view(name).substr(0, 64);  // longer names have no nearest one
  const auto nearest = std::min_element(std::begin(kDisneyParameters), std::end(kDisneyParameters),
                                        [&](const DisneyParameter& a, const DisneyParameter& b) {
                                          return edit_distance(text, a.name) < edit_distance(text, b.name);
                                        });
  return std::string(nearest->name);
}

}  // namespace alabaster::hd::gltf
