// Values for the rows of tables of fields: one that a row takes, and those that it refuses.
#pragma once

#include <cmath>
#include <nlohmann/json.hpp>

#include "delegate/host/scene_fields.h"
#include "delegate/support/json_values.h"

namespace alabaster::hd::host {

/// A value other than the default. Names of files are `file`.
inline Value good_value(const FieldRow& row, const std::string& file = "a.hdr") {
  if (!row.words.empty()) {
    const bool is_last = row.fallback.text_or("") == row.words.back();
    return Value(std::string(is_last ? row.words.front() : row.words.back()));
  }
  switch (row.type.type) {
    case ALABASTER_BOOL:
      return row.fallback.number_or(0) == 0;
    case ALABASTER_STRING:
      return std::string(row.name.ends_with("file") ? file : "a");
    case ALABASTER_FLOAT2:
      return Vec2f(1, 10);
    case ALABASTER_FLOAT3:
      return Vec3f(0.25f, 0.5f, 0.75f);
    case ALABASTER_FLOAT4:
      return row.type.is_array ? Value(Array<Vec4f>{Vec4f(1, 0, 0, 0), Vec4f(0, 1, 0, 0)}) : Value(Vec4f(1, 0, 0, 0));
    default:
      break;
  }
  const bool is_whole = row.type.type != ALABASTER_FLOAT && row.type.type != ALABASTER_DOUBLE;
  const double fallback = row.fallback.number_or(0), step = is_whole ? 1 : 0.25;
  const double value = fallback + step <= row.high ? fallback + step : fallback - step;
  return is_whole ? Value(int32_t(value)) : Value(float(value));
}

/// A value that the row refuses, as JSON, and whether it is a number out of range: the renderer takes the nearest then.
struct WrongValue {
  nlohmann::json value;
  bool is_out_of_range = false;
};
inline std::vector<WrongValue> wrong_values(const FieldRow& row) {
  if (!row.words.empty()) return {{row.words.back() + "x"}, {3}};
  if (row.type.type == ALABASTER_STRING) return {{3}, {nlohmann::json{1, 2}}};
  std::vector<WrongValue> all{{"high"}};
  if (row.type.type == ALABASTER_BOOL) return all;
  const bool is_vector = GetTypeInfo(row.type.type).components > 1;
  if (is_vector) all.push_back({nlohmann::json{1, 2, 3, 4}});
  const auto add = [&](double number) {
    all.push_back({row.is_color ? nlohmann::json{1, number, 1} : nlohmann::json(number), true});
  };
  if (is_vector && !row.is_color) return all;
  if (row.type.type == ALABASTER_UINT || row.type.type == ALABASTER_INT) all.push_back({row.low + 0.5});
  if (std::isfinite(row.low)) add(row.is_above_zero() ? 0 : row.low - 1);
  if (std::isfinite(row.high)) add(row.high + 1);
  return all;
}

}  // namespace alabaster::hd::host
