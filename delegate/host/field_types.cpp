// The tables of fields and parameters for people, and the types of fields by name.
#include <cmath>

#include "delegate/host/open_fields.h"

namespace alabaster::hd::host {
namespace {

using Found = std::optional<FieldType>;

template <class Rows>
Found find_parameter(const Rows& rows, std::span<const OtherParameter> others, const std::string& name) {
  for (const auto& row : rows)
    if (name == row.name) return type_of(row);
  for (const OtherParameter& row : others)
    if (name == row.name) return row.type;
  return std::nullopt;
}

constexpr const char* kCapitals = "ABCDEFGHIJKLMNOPQRSTUVWXYZ";

/// `name` is that of the row, with any text in the place of its part in capitals. Rows with two such parts have no
/// name.
bool is_of(const Field& row, const std::string& name) {
  const std::string_view pattern = row.name;
  if (!is_pattern(pattern)) return false;
  const size_t begin = pattern.find_first_of(kCapitals), end = pattern.find_first_not_of(kCapitals, begin);
  const std::string_view before = pattern.substr(0, begin);
  const std::string_view after = end == std::string_view::npos ? "" : pattern.substr(end);
  return name.size() > before.size() + after.size() && name.starts_with(before) && name.ends_with(after);
}

Found find_field(const Kind& kind, const std::string& name) {
  for (const auto& table : {kind.fields, kind.open})
    for (const Field& row : table)
      if (name == row.name) return row.type;
  Found found;
  const std::string parameter = std::string_view(kind.parameters) == "lights" ? without_inputs_namespace(name) : name;
  if (!kind.fields.empty())  // parameters of materials are those of nodes
    visit_table(kind.parameters,
                [&](const auto& rows, const auto&, auto others) { found = find_parameter(rows, others, parameter); });
  if (found) return found;
  for (const Field& row : kind.open)
    if (row.type.type != ALABASTER_NONE && is_of(row, name)) return row.type;
  return std::nullopt;
}

// What rows of one table have beside those of the others.
template <class T>
void add_own(const T&, FieldRow*) {}
void add_own(const MaterialParameter& parameter, FieldRow* row) {
  if (!parameter.is_textured()) return;
  const bool is_color_image = parameter.texels == Texels::colors;
  row->texture = is_color_image ? "colorTexture" : parameter.is_color() ? "distanceTexture" : "numberTexture";
}
void add_lights(uint32_t of, FieldRow* row) {
  for (size_t type = 0; type < std::size(kLightTypes); ++type)
    if (of >> type & 1) row->lights.emplace_back(kLightTypes[type]);
}
void add_own(const Parameter<alabaster::LightParameters>& parameter, FieldRow* row) {
  add_lights(parameter.of, row);
}
void add_own(const Parameter<CameraParameters>& parameter, FieldRow* row) {
  row->in_millimetres = parameter.of == kMillimetres;
}

}  // namespace

FieldRow row_of_field(const Field& field) {
  FieldRow row{field.name, field.unit, field.text, field.type};
  row.low = field.limits.low, row.high = field.limits.high;
  row.words = words_of(field.limits);
  if (field.get) row.fallback = field.get(field, field.defaults());
  return row;
}

FieldRow plain_row(const char* name, const char* unit, const char* text, double low, double high,
                   std::span<const char* const> words) {
  FieldRow row{name, unit, text};
  row.low = low, row.high = high;
  for (const char* word : words)
    if (word) row.words.emplace_back(word);
  return row;
}

FieldRow row_of(const OtherParameter& parameter) {
  FieldRow row = plain_row(parameter.name, parameter.unit, parameter.text ? parameter.text : "", parameter.low,
                           kUnbounded, parameter.words);
  row.type = parameter.type;
  add_lights(parameter.of, &row);
  if (row.type.type == ALABASTER_STRING)
    row.fallback = std::string(parameter.fallback);
  else if (row.type.type == ALABASTER_FLOAT2)
    row.fallback = Vec2f(0);
  else if (row.type.type == ALABASTER_FLOAT4)
    row.fallback = Array<Vec4f>();
  return row;
}

std::vector<FieldRow> ParameterRows(const std::string& schema) {
  std::vector<FieldRow> all;
  visit_table(schema, [&](const auto& rows, const auto& defaults, auto others) {
    for (const auto& parameter : rows) {
      all.push_back(row_of(parameter, defaults));
      add_own(parameter, &all.back());
    }
    for (const OtherParameter& other : others)
      if (other.text) all.push_back(row_of(other));
  });
  return all;
}

std::vector<FieldRow> FieldRows(const std::string& kind) {
  std::span<const Field> fields;
  if (kind == "product") fields = kProductFields;
  for (const Kind& one : kinds())
    if (kind == one.name) fields = one.fields;
  std::vector<FieldRow> all;
  for (const Field& field : fields) all.push_back(row_of_field(field));
  return all;
}

std::string limit_text(double limit) {
  const bool is_whole = limit == std::floor(limit) && std::abs(limit) < 0x1p53;
  return is_whole ? std::to_string(int64_t(limit)) : Value(limit).to_string();
}

std::string MustBe(const FieldRow& row) {
  if (!row.words.empty()) {
    std::string known;
    for (const std::string& word : row.words) known += (known.empty() ? "one of " : ", ") + word;
    return known;
  }
  if (row.type.type == ALABASTER_BOOL) return "true or false";
  const TypeInfo& info = GetTypeInfo(row.type.type);
  if (row.type.is_array) return std::string("an array of ") + info.name;
  if (info.bytes == 0) return "a text";
  const bool is_whole = info.scalar == Scalar::int32 || info.scalar == Scalar::int64 || info.scalar == Scalar::uint32;
  std::string text = is_whole ? "a whole number" : "a number";
  if (info.components > 1) text = std::to_string(info.components) + (is_whole ? " whole numbers" : " numbers");
  if (row.is_color) text = "a colour: three numbers";
  const bool has_low = row.low != -kUnbounded, has_high = row.high != kUnbounded;
  if (row.is_above_zero())
    text += " above 0" + (has_high ? ", at most " + limit_text(row.high) : std::string());
  else if (has_low && has_high)
    text += (row.is_color ? ", each from " : " from ") + limit_text(row.low) + " to " + limit_text(row.high);
  else if (has_low || has_high)
    text += has_low ? ", at least " + limit_text(row.low) : ", at most " + limit_text(row.high);
  return text;
}

bool is_pattern(std::string_view name) {
  const size_t begin = name.find_first_of(kCapitals);
  return begin != std::string_view::npos && (begin == 0 || name[begin - 1] == ':');
}

FieldType TypeOfField(const Token& kind, const std::string& name) {
  const std::string wanted = kind.str().ends_with("Light") ? "light" : kind.str();
  Found all;
  for (const Kind& one : kinds()) {
    if (!wanted.empty() && wanted != one.name) continue;
    const Found found = find_field(one, name);
    if (!found) continue;
    if (all && !(*all == *found)) return {};
    all = found;
  }
  return all.value_or(FieldType());
}

}  // namespace alabaster::hd::host
