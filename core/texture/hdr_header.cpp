#include "core/texture/hdr_header.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <string_view>
#include <utility>
#include <vector>

namespace alabaster {
namespace {

/// The numbers of a text, up to the first word that is none.
std::vector<float> numbers_in(std::string_view text) {
  std::vector<float> numbers;
  const char* at = text.data();
  const char* const end = at + text.size();
  for (float number = 0;; numbers.push_back(number)) {
    while (at != end && (*at == ' ' || *at == '\t' || *at == '\r' || *at == '+')) ++at;
    const auto [after, error] = std::from_chars(at, end, number);
    if (error != std::errc() || after == at) return numbers;
    at = after;
  }
}

/// Divides by one or three positive numbers. False: they are none.
bool divide(std::array<float, 3>* scale, const std::vector<float>& by) {
  if (by.empty()) return false;
  for (size_t i = 0; i < 3; ++i) {
    const float value = by.size() < 3 ? by[0] : by[i];
    (*scale)[i] /= value;
    if (!(value > 0) || !std::isnormal((*scale)[i])) return false;
  }
  return true;
}

bool read_line(std::string_view line, HdrHeader* header, ImageFault* fault) {
  const auto fail = [&](const char* code, const std::string& text) { return *fault = {code, text}, false; };
  const auto value_of = [&](std::string_view name) -> std::optional<std::string_view> {
    if (!line.starts_with(name)) return std::nullopt;
    return line.substr(name.size());
  };
  if (const auto format = value_of("FORMAT="); format && format->find("xyze") != std::string_view::npos)
    return fail("texture.format", "its colours are CIE XYZ; convert it to RGB (ra_xyze -r)");
  for (const char* const name : {"EXPOSURE=", "COLORCORR="})
    if (const auto value = value_of(name); value && !divide(&header->scale, numbers_in(*value)))
      return fail("texture.damaged",
                  std::string(name) + " in its header is no positive number; export the image again");
  if (const auto value = value_of("PRIMARIES=")) {
    const std::vector<float> numbers = numbers_in(*value);
    if (numbers.size() != 8)
      return fail("texture.damaged", "PRIMARIES= in its header has not eight numbers; export the image again");
    header->chromaticities.emplace();
    std::copy(numbers.begin(), numbers.end(), header->chromaticities->begin());
  }
  return true;
}

/// By the line of the picture's size: "-Y 8 +X 16", the first axis being that from row to row.
int orientation_of(std::string_view size) {
  constexpr std::pair<std::string_view, std::string_view> kAxes[] = {{"-Y ", " +X "}, {"-Y ", " -X "}, {"+Y ", " -X "},
                                                                     {"+Y ", " +X "}, {"+X ", " -Y "}, {"-X ", " -Y "},
                                                                     {"-X ", " +Y "}, {"+X ", " +Y "}};
  for (size_t i = 0; i < std::size(kAxes); ++i)
    if (size.starts_with(kAxes[i].first) && size.find(kAxes[i].second) != std::string_view::npos) return int(i + 1);
  return 1;
}

}  // namespace

bool read_hdr_header(const FileBytes& file, HdrHeader* header, ImageFault* fault) {
  constexpr uint64_t kMostBytes = 65536;  // OpenImageIO says what is wrong with what lies beyond
  std::vector<char> text(size_t(std::min(file.size, kMostBytes)));
  if (!file.read(0, text.data(), text.size())) return true;
  std::string_view left(text.data(), text.size());
  while (!left.empty()) {
    const size_t end = std::min(left.find('\n'), left.size());
    const std::string_view line = left.substr(0, end);
    left.remove_prefix(std::min(end + 1, left.size()));
    if (line.empty() || line == "\r") {
      header->orientation = orientation_of(left.substr(0, left.find('\n')));
      return true;
    }
    if (!read_line(line, header, fault)) return false;
  }
  return true;
}

}  // namespace alabaster
