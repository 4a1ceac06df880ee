#include "delegate/description/lengths.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <limits>
#include <tuple>

namespace alabaster::hd::description {
namespace {

using nlohmann::json;

struct LengthUnit {
  const char* name;
  double millimetres;
};
constexpr LengthUnit kLengthUnits[] = {{"um", 0.001}, {"mm", 1}, {"cm", 10}, {"m", 1000}, {"in", 25.4}, {"ft", 304.8}};

const LengthUnit* find_unit(std::string_view name) {
  const auto* found = std::find_if(std::begin(kLengthUnits), std::end(kLengthUnits),
                                   [&](const LengthUnit& u) { return u.name == name; });
  return found == std::end(kLengthUnits) ? nullptr : found;
}

std::string_view trimmed(std::string_view text) {
  const size_t begin = text.find_first_not_of(' ');
  return begin == text.npos ? std::string_view() : text.substr(begin, text.find_last_not_of(' ') + 1 - begin);
}

/// What a row's lengths are converted to: millimetres, or scene units.
struct LengthRow {
  const host::FieldRow& row;
  double metres_per_unit;

  // A division by a power of ten gives the number nearest to what was typed. None: it is no finite one.
  std::optional<double> convert(double number, const LengthUnit& unit) const {
    const double converted = number * unit.millimetres / (row.in_millimetres ? 1 : 1000 * metres_per_unit);
    return std::abs(converted) <= double(std::numeric_limits<float>::max()) ? std::optional(converted) : std::nullopt;
  }
};

/// A text, and the unit behind it; null: there is none.
std::pair<std::string_view, const LengthUnit*> split_unit(std::string_view text) {
  size_t letters = text.size();
  while (letters > 0 && std::isalpha(static_cast<unsigned char>(text[letters - 1]))) --letters;
  return {trimmed(text.substr(0, letters)), find_unit(text.substr(letters))};
}

// "3.7mm", or "3.7" with a unit.
std::optional<json> read_number(std::string_view text, const LengthUnit* unit, const LengthRow& into) {
  text = trimmed(text);
  if (!unit) std::tie(text, unit) = split_unit(text);
  double number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (!unit || error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return into.convert(number, *unit);
}

// Also "[3.7, 1.4, 0.7]mm", or with a unit behind each number.
std::optional<json> read_text(std::string_view text, const LengthRow& into) {
  const auto [numbers, unit] = split_unit(trimmed(text));
  if (!numbers.starts_with('[') || !numbers.ends_with(']')) return read_number(text, nullptr, into);
  json list = json::array();
  for (size_t begin = 1; begin < numbers.size();) {
    const size_t end = std::min(numbers.find(',', begin), numbers.size() - 1);
    const std::optional<json> entry = read_number(numbers.substr(begin, end - begin), unit, into);
    if (!entry) return std::nullopt;
    list.push_back(*entry);
    begin = end + 1;
  }
  return list;
}

std::optional<json> read_object(const json& value, const LengthRow& into) {
  const LengthUnit* const unit = value.size() == 1 ? find_unit(value.begin().key()) : nullptr;
  if (!unit) return std::nullopt;
  json numbers = value.front();
  const auto convert = [&](json* number) {
    if (!number->is_number()) return true;  // the check of values tells of it
    const auto converted = into.convert(number->get<double>(), *unit);
    if (converted) *number = *converted;
    return converted.has_value();
  };
  bool fits = numbers.is_array() || convert(&numbers);
  if (numbers.is_array())
    for (json& one : numbers) fits = convert(&one) && fits;
  return fits ? std::optional(numbers) : std::nullopt;
}

}  // namespace

std::string length_units() {
  std::string text;
  for (size_t i = 0; i < std::size(kLengthUnits); ++i)
    text += std::string(i == 0 ? "" : i + 1 < std::size(kLengthUnits) ? ", " : " or ") + kLengthUnits[i].name;
  return text;
}

nlohmann::ordered_json length_schema() {
  std::string names;
  nlohmann::ordered_json properties;
  const nlohmann::ordered_json number = {{"type", "number"}};
  for (const LengthUnit& unit : kLengthUnits) {
    names += (names.empty() ? "" : "|") + std::string(unit.name);
    properties[unit.name] = {{"anyOf", {number, {{"type", "array"}, {"items", number}}}}};
  }
  return {
      {"anyOf",
       {{{"type", "string"}, {"pattern", "(" + names + ")\\s*\\]?\\s*$"}},
        {{"type", "object"},
         {"additionalProperties", false},
         {"minProperties", 1},
         {"maxProperties", 1},
         {"properties", properties}}}},
      {"description", "A length with its unit: 3.7mm, [3.7, 1.4, 0.7]mm, or an object of the unit and the numbers."}};
}

std::optional<json> without_unit(const json& value, const host::FieldRow& row, double metres_per_unit) {
  const LengthRow into{row, metres_per_unit};
  if (row.unit != "scene unit") return std::nullopt;
  if (value.is_string()) return read_text(value.get_ref<const std::string&>(), into);
  if (value.is_object()) return read_object(value, into);
  if (!value.is_array()) return std::nullopt;
  json list = value;
  bool any = false;
  for (json& one : list) {
    if (!without_unit(one, row, 1)) continue;
    const auto number = without_unit(one, row, metres_per_unit);
    if (!number) return std::nullopt;
    one = *number, any = true;
  }
  return any ? std::optional(list) : std::nullopt;
}

bool resolve_lengths(double metres_per_unit, const Key& key, json* value) {
  if (without_unit(*value, key.row, 1)) {
    auto number = without_unit(*value, key.row, metres_per_unit);
    if (number) *value = std::move(*number);
    return number.has_value();
  }
  bool fits = true;
  const auto resolve_keys = [&](json& object) {
    for (auto& [name, child] : object.items())
      fits = resolve_lengths(metres_per_unit, *find_key(key.keys, name), &child) && fits;
  };
  if (value->is_array() && key.form == Key::Form::objects) {
    for (json& entry : *value) resolve_keys(entry);
  } else if (value->is_object()) {
    resolve_keys(*value);
  }
  return fits;
}

}  // namespace alabaster::hd::description
