#include "delegate/view/parameter_rows.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <optional>

#include "delegate/host/scene_fields.h"

namespace alabaster::view {
namespace {

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

// None for what no row can show.
std::optional<RowKind> kind_of(const hd::host::FieldRow& field) {
  const hd::TypeInfo& info = hd::GetTypeInfo(field.type.type);
  if (field.is_color) return RowKind::color;
  if (field.type.is_array || info.components > 1) return std::nullopt;
  if (!field.words.empty()) return RowKind::choice;
  if (field.type.type == ALABASTER_BOOL) return RowKind::toggle;
  if (info.bytes == 0) return RowKind::text;
  return info.scalar == hd::Scalar::float32 ? RowKind::number : RowKind::integer;
}

}  // namespace

std::vector<ParameterRow> parameter_rows(const std::string& schema) {
  std::vector<ParameterRow> rows;
  for (const hd::host::FieldRow& field : hd::host::ParameterRows(schema)) {
    const std::optional<RowKind> kind = kind_of(field);
    if (!kind) continue;
    ParameterRow row;
    row.name = field.name, row.label = label_of(field.name), row.kind = *kind;
    row.unit = field.unit == "none" ? "" : field.unit;
    row.in_millimetres = field.unit == "scene unit", row.is_length = row.in_millimetres && !field.in_millimetres;
    if (row.in_millimetres) row.unit = "mm";
    row.description = field.text;
    row.default_value = field.fallback;
    row.minimum = field.is_above_zero() ? kLeastAbove : field.low, row.maximum = field.high;
    row.choices = field.words, row.applies_to = field.lights;
    rows.push_back(std::move(row));
  }
  return rows;
}

SoftRange soft_range(const ParameterRow& row, double value, double scene_size) {
  const bool length = row.is_length;
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
  constexpr std::pair<const char*, const char*> kUnits[] = {{"nanometre", "nm"}, {"kelvin", "K"}};
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
