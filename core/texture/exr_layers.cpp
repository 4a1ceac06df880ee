#include "core/texture/exr_layers.h"

#include <algorithm>
#include <string_view>

namespace alabaster {
namespace {

std::string lower_case(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](char c) { return c >= 'A' && c <= 'Z' ? char(c + 32) : c; });
  return text;
}

template <size_t N>
bool is_one_of(const std::string& word, const std::string_view (&words)[N]) {
  return std::find(std::begin(words), std::end(words), word) != std::end(words);
}

constexpr std::string_view kRed[] = {"r", "red"}, kGreen[] = {"g", "grn", "green"}, kBlue[] = {"b", "blu", "blue"},
                           kAlpha[] = {"a", "alpha"};
/// Names of the picture in renderers and compositors.
constexpr std::string_view kPictures[] = {"rgba",    "rgb",   "beauty", "combined", "composite", "color",
                                          "colour",  "c",     "ci",     "main",     "image",     "default",
                                          "primary", "final", "master", "rgba_main"};
/// Their names of data that parts hold as R, G and B.
constexpr std::string_view kData[] = {
    "z",      "depth", "n",     "normal", "normals",      "p",        "position",   "pos",     "pworld",
    "nworld", "uv",    "st",    "motion", "motionvector", "velocity", "vector",     "forward", "id",
    "mask",   "matte", "alpha", "ao",     "objectid",     "primid",   "cryptomatte"};

/// Channels of a part whose names are equal up to the last '.'.
struct Group {
  size_t part = 0;
  std::string part_name, prefix;
  std::vector<std::string> channels;  // whole names

  std::string suffix(size_t channel) const { return channels[channel].substr(prefix.empty() ? 0 : prefix.size() + 1); }
  template <size_t N>
  std::string find(const std::string_view (&suffixes)[N]) const {
    for (size_t i = 0; i < channels.size(); ++i)
      if (is_one_of(lower_case(suffix(i)), suffixes)) return channels[i];
    return {};
  }
  bool has_rgb() const { return !find(kRed).empty() && !find(kGreen).empty() && !find(kBlue).empty(); }
  std::string name() const {
    return part_name.empty() || part_name == prefix ? prefix : prefix.empty() ? part_name : part_name + "." + prefix;
  }
  /// True if a word between the dots of its name is one of these.
  template <size_t N>
  bool is_named(const std::string_view (&words)[N]) const {
    const std::string text = lower_case(name());
    for (size_t begin = 0; begin <= text.size();) {
      const size_t end = std::min(text.find('.', begin), text.size());
      if (is_one_of(text.substr(begin, end - begin), words)) return true;
      begin = end + 1;
    }
    return false;
  }
  /// Other than alpha.
  std::vector<std::string> values() const {
    std::vector<std::string> result;
    const std::string alpha = find(kAlpha);
    for (const std::string& channel : channels)
      if (channel != alpha || channels.size() == 1) result.push_back(channel);
    return result;
  }
  bool has(const char* channel) const { return std::find(channels.begin(), channels.end(), channel) != channels.end(); }
  /// OpenEXR's grey, which may stand beside other channels.
  bool has_luminance() const { return prefix.empty() && has("Y") && !has("X"); }
  /// Channels that are one value together.
  bool is_value() const {
    std::string letters;
    for (size_t i = 0; i < channels.size(); ++i) letters += suffix(i) + " ";
    constexpr std::string_view kVectors[] = {"g r ", "u v ", "x y ", "x y z "};
    return has_rgb() || values().size() == 1 || is_one_of(lower_case(letters), kVectors);
  }
};

std::vector<Group> groups_of(const std::vector<ExrPart>& parts) {
  std::vector<Group> groups;
  for (size_t p = 0; p < parts.size(); ++p) {
    if (parts[p].is_deep || !parts[p].is_known) continue;
    const size_t first = groups.size();
    for (const ExrPart::Channel& channel : parts[p].channels) {
      const size_t dot = channel.name.rfind('.');
      const std::string prefix = dot == std::string::npos ? "" : channel.name.substr(0, dot);
      auto found = std::find_if(groups.begin() + std::ptrdiff_t(first), groups.end(),
                                [&](const Group& group) { return group.prefix == prefix; });
      if (found == groups.end()) found = groups.insert(found, {p, parts[p].name, prefix, {}});
      found->channels.push_back(channel.name);
    }
  }
  return groups;
}

/// R, G and B of the file's only part, whatever that is called, are the picture.
const Group* picture_of(const std::vector<Group>& groups, bool has_parts) {
  const auto first = [&](const auto& is) -> const Group* {
    const auto found = std::find_if(groups.begin(), groups.end(), is);
    return found == groups.end() ? nullptr : &*found;
  };
  const auto is_plain = [](const Group& group) { return group.prefix.empty() && group.has_rgb(); };
  if (const auto* group = first([&](const Group& g) { return is_plain(g) && (!has_parts || g.part_name.empty()); }))
    return group;
  if (const auto* group = first([](const Group& g) { return g.has_rgb() && g.is_named(kPictures); })) return group;
  if (const auto* group = first([&](const Group& g) { return is_plain(g) && !g.is_named(kData); })) return group;
  if (const auto* group = first([](const Group& g) { return g.has_luminance() && !g.is_named(kData); })) return group;
  const bool is_alone = groups.size() == 1 && groups[0].is_value();
  const bool is_picture = is_alone && (groups[0].has_rgb() ? !groups[0].is_named(kData) : groups[0].prefix.empty());
  return is_picture ? groups.data() : nullptr;
}

ExrLayer layer_of(const Group& group) {
  ExrLayer layer{group.part, {group.find(kRed), group.find(kGreen), group.find(kBlue), group.find(kAlpha)}};
  std::vector<std::string> values = group.values();
  if (group.has_rgb()) return layer;
  if (group.has_luminance() || values.size() == 1) {
    std::fill_n(layer.channels.begin(), 3, group.has_luminance() ? "Y" : values[0]);
    if (group.channels.size() == 1) layer.channels[3].clear();
  } else if (layer.channels[0].empty() || layer.channels[1].empty()) {
    values.resize(3);  // U and V, or X, Y and Z: in the order of the alphabet, as files have them
    std::copy(values.begin(), values.end(), layer.channels.begin());
  }
  return layer;
}

std::string names_of(const std::vector<Group>& groups) {
  constexpr size_t kMost = 20;
  std::string text;
  size_t count = 0;
  const auto add = [&](const std::string& name) {
    if (++count <= kMost) text += (text.empty() ? "" : ", ") + name;
  };
  for (const Group& group : groups)
    if (const std::string name = group.name(); !name.empty())
      add(name);
    else
      for (const std::string& channel : group.channels) add(channel);
  return count > kMost ? text + " and " + std::to_string(count - kMost) + " more" : text;
}

}  // namespace

bool find_exr_layer(const std::vector<ExrPart>& parts, const std::string& name, ExrLayer* layer, ImageFault* fault) {
  const std::vector<Group> groups = groups_of(parts);
  if (groups.empty()) return *layer = {}, true;  // OpenEXR says what is wrong, or it is deep
  if (name.empty()) {
    if (const Group* const group = picture_of(groups, parts.size() > 1)) return *layer = layer_of(*group), true;
    *fault = {"texture.layer", "none of its layers is called as a picture is: it has " + names_of(groups) +
                                   "; name one of them as the texture's 'layer', or export the colour as R, G and B"};
    return false;
  }
  const std::array<std::string (*)(const Group&), 3> names = {[](const Group& g) { return g.name(); },
                                                              [](const Group& g) { return g.prefix; },
                                                              [](const Group& g) { return g.part_name; }};
  for (const auto& of : names)
    for (const Group& group : groups)
      if (of(group) == name) return *layer = layer_of(group), true;
  for (const Group& group : groups)
    for (const std::string& channel : group.channels)
      if (channel == name) return *layer = {group.part, {channel, channel, channel, ""}}, true;
  *fault = {"texture.layer", "it has no layer '" + name + "'; it has " + names_of(groups)};
  return false;
}

}  // namespace alabaster
