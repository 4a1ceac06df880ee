#include <cmath>

#include "delegate/description/written_parts.h"

namespace alabaster::hd::description {

using nlohmann::json;

json to_json(const Value& value, const json& property) {
  const json type = property.is_object() ? property.value("type", json()) : json();
  if (const auto* held = value.get<Array<Vec4f>>()) {
    json all = json::array();
    for (const Vec4f& v : *held) all.push_back({v.x, v.y, v.z, v.w});
    return all;
  }
  if (const auto* held = value.get<int64_t>(); held && type != "boolean") return *held;  // a double may not hold it
  std::array<double, 4> numbers{};
  const size_t count = value.components(&numbers);
  if (count == 0) return value.text_or("");
  if (count > 1) return std::vector<double>(numbers.begin(), numbers.begin() + static_cast<ptrdiff_t>(count));
  if (type == "boolean" || (type.is_null() && value.get<bool>())) return numbers[0] != 0;
  constexpr double kExact = 0x1p53;
  const bool is_whole = std::abs(numbers[0]) < kExact && numbers[0] == std::trunc(numbers[0]);
  if (is_whole && (type == "integer" || value.get<int32_t>())) return static_cast<int64_t>(numbers[0]);
  return numbers[0];
}

json to_json(const Matrix4d& matrix) {
  return std::vector<double>(&matrix.x[0][0], &matrix.x[0][0] + 16);
}

std::string pattern_of(const std::string& name) {
  constexpr std::string_view kSpecial = "*?[]\\";
  std::string pattern;
  for (const char c : name) {
    if (kSpecial.find(c) != std::string_view::npos) pattern += '\\';
    pattern += c;
  }
  return pattern;
}

}  // namespace alabaster::hd::description
