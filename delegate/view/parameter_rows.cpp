#include "delegate/view/parameter_rows.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "delegate/description/render_description.h"

namespace alabaster::view {
namespace {

using nlohmann::ordered_json;  // rows have the order of the tables

constexpr double kInfinite = std::numeric_limits<double>::infinity();
constexpr double kMostInteger = (1 << 30) - 1, kMostNumber = 1e37;  // that sliders take
constexpr double kLeastAbove = 1e-6;                                // above a bound that is excluded
constexpr double kDecades = 1000;  // beyond this ratio of values a slider is logarithmic

// Words of the schemas' names that are none of plain English.
constexpr std::pair<const char*, const char*> kWords[] = {
    {"ior", "IOR"}, {"ies", "IES"}, {"spec", "specular"}, {"diff", "diffuse"}, {"trans", "transmission"}};

std::string word_of(const std::string& word) {
  for (const auto& [name, shown] : kWords)
    if (word == name) return shown;
  return word;
}

// "scatterDistance" as "Scatter distance", "shaping:ies:file" as "Shaping IES file", "fStop" as "F stop".
std::string label_of(const std::string& name) {
  std::string label, word;
  const auto end_word = [&] {
    if (!word.empty()) label += (label.empty() ? "" : " ") + word_of(word);
    word.clear();
  };
  for (const char c : name) {
    if (c == ':' || std::isupper(static_cast<unsigned char>(c))) end_word();
    if (c != ':') word += char(std::tolower(static_cast<unsigned char>(c)));
  }
  end_word();
  if (!label.empty()) label[0] = char(std::toupper(static_cast<unsigned char>(label[0])));
  return label;
}

void read_limits(const ordered_json& schema, ParameterRow* row) {
  row->minimum = schema.value("minimum", schema.value("exclusiveMinimum", -kInfinite) + kLeastAbove);
  row->maximum = schema.value("maximum", kInfinite);
}

// False for what no row can show.
bool read_type(const ordered_json& schema, const ordered_json& entry, ParameterRow* row) {
  const std::string type = schema.value("type", "");
  const ordered_json& value = entry["default"];
  if (type == "boolean") {
    row->kind = RowKind::toggle, row->default_value = value.get<bool>();
  } else if (type == "string") {
    row->kind = schema.contains("enum") ? RowKind::choice : RowKind::text;
    row->choices = schema.value("enum", std::vector<std::string>());
    row->default_value = value.get<std::string>();
  } else if (type == "array") {
    if (!value.is_array() || value.size() != 3) return false;
    row->kind = RowKind::color;
    row->default_value = hd::Vec3f(value[0].get<float>(), value[1].get<float>(), value[2].get<float>());
    read_limits(schema["items"], row);
  } else {
    row->kind = type == "integer" ? RowKind::integer : RowKind::number;
    row->default_value = value.get<double>();
    read_limits(schema, row);
  }
  return true;
}

}  // namespace

std::vector<ParameterRow> parameter_rows(const std::string& schema) {
  std::vector<ParameterRow> rows;
  const char* const text = hd::description::SchemaText(schema);
  if (!text) return rows;
  const ordered_json document = ordered_json::parse(text);
  for (const auto& [name, entry] : document["properties"].items()) {
    ParameterRow row;
    row.name = name, row.label = label_of(name);
    row.unit = entry.value("unit", "none");
    if (row.unit == "none") row.unit.clear();
    if (entry.value("unitInDescription", "") == "mm") row.unit = "mm", row.scale = 0.001;
    row.description = entry.value("description", "");
    row.applies_to = entry.value("appliesTo", std::vector<std::string>());
    if (read_type(entry.contains("anyOf") ? entry["anyOf"][0] : entry, entry, &row)) rows.push_back(std::move(row));
  }
  return rows;
}

SoftRange soft_range(const ParameterRow& row, double value, double scene_size) {
  const bool length = row.unit == "scene unit";
  double usual = 10;
  if (const double given = row.default_value.number_or(0); given > 0) usual = 10 * given;
  if (length) usual = scene_size;
  SoftRange range;
  range.low = std::isfinite(row.minimum) ? row.minimum : -usual;
  range.high = std::min(row.maximum, row.maximum / kDecades > usual ? usual : row.maximum);
  // A slider up to 1,048,576 is of no use to somebody who wants 64.
  if (row.kind == RowKind::integer && row.maximum > 4096) range.high = std::min(row.maximum, std::max(usual, 4096.0));
  if (length) range.high = std::min(row.maximum, usual);
  if (value > range.high) range.high = std::min(row.maximum, 2 * value);
  if (value < range.low) range.low = std::max(row.minimum, 2 * value);
  const double most = row.kind == RowKind::integer ? kMostInteger : kMostNumber;
  range.low = std::clamp(range.low, -most, most), range.high = std::clamp(range.high, -most, most);
  range.logarithmic = row.minimum >= 0 && (length || !std::isfinite(row.maximum) || range.high >= kDecades);
  return range;
}

std::string unit_text(const ParameterRow& row) {
  constexpr std::pair<const char*, const char*> kUnits[] = {
      {"scene unit", "scene units"}, {"nanometre", "nm"}, {"kelvin", "K"}};
  for (const auto& [unit, text] : kUnits)
    if (row.unit == unit) return text;
  return row.unit;
}

std::string value_format(const ParameterRow& row, const SoftRange& range, double value) {
  // The meaning of a zero where it is no amount.
  constexpr std::pair<const char*, const char*> kZeros[] = {{"fStop", "pinhole"},     {"apertureBlades", "round"},
                                                            {"threads", "all cores"}, {"timeLimit", "none"},
                                                            {"targetError", "none"},  {"attenuationDistance", "none"}};
  for (const auto& [name, meaning] : kZeros)
    if (value == 0 && row.name == name)
      return std::string(row.kind == RowKind::integer ? "%d" : "%.0f") + " (" + meaning + ")";
  const std::string unit = unit_text(row), behind = unit.empty() ? "" : " " + unit;
  if (row.kind == RowKind::integer) return "%d" + behind;
  double size = std::max(std::abs(range.high), 1e-9);
  if (range.logarithmic && value > 0) size = std::clamp(value * 10, 1e-9, size);
  const int digits = std::clamp(int(std::ceil(3 - std::log10(size))), 0, 9);
  const std::string number = "%." + std::to_string(digits) + "f";
  return row.unit == "f-number" ? "f/" + number : number + behind;
}

double limited(const ParameterRow& row, double value) {
  return std::isnan(value) ? row.default_value.number_or(0)
                           : std::clamp(value, std::max(row.minimum, -kMostNumber), std::min(row.maximum, kMostNumber));
}

}  // namespace alabaster::view
